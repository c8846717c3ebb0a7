use super::{Format, Job};
use super::diag::Diags;
pub(crate) fn import(_job: &Job<'_>, _format: Format, _diags: &mut Diags) -> String { String::new() }
