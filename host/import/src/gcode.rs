//! G-code of CAM tools, controllers and lasers.
//!
//! The language takes G-code itself, so most lines stay as they are. What it has no meaning for is
//! refused or left out with a diagnostic ([`rules`]); repetition becomes tables and loops
//! ([`fold`]).

mod arc;
mod beam;
mod fold;
mod follow;
mod named;
mod param;
mod read;
mod rules;
mod words;
mod write;

pub(crate) use named::Param;
pub(crate) use param::expanded;

use super::diag::Diags;
use super::script::Made;
use super::{Format, Job};

/// Makes a script of a program with these parameters.
pub(crate) fn import(job: &Job<'_>, format: Format, params: &[Param], diags: &mut Diags) -> Made {
    let mut blocks = read::read(job, format, diags);
    if diags.has_errors() {
        return Made::default();
    }
    // Nobody edits the pixels of a picture, nor what is run as it is.
    let names = match format == Format::Laser || job.options.plain {
        true => Vec::new(),
        false => named::name(&mut blocks, params),
    };
    write::script(job, format, (&blocks, &names), diags)
}
