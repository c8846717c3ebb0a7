//! The check of a whole job before the first move.

use lang::fault::Fault;

use super::feed::{BUDGET, Feed, Refused, Step};
use crate::track::Track;

/// Instructions that the check executes at most.
pub(super) const CHECK: u64 = 50_000_000;

/// What the check before the first move found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Checked {
    /// Statements of the machine.
    pub count: u64,
    /// The line from which on the job hangs on what the machine answers, so that only a run shows
    /// what comes.
    pub open: Option<u32>,
}

/// Runs the whole job on the host, up to the first question to the machine.
///
/// # Errors
/// It would fail.
pub fn check(mut feed: Feed<'_>, mut track: Track) -> Result<Checked, Refused> {
    let mut checked = Checked::default();
    let mut left = CHECK;
    loop {
        match feed.step() {
            Step::Effect(effect, line) => {
                if Track::is_open(&effect) || Track::arms(&effect) {
                    checked.open = Some(line);
                    return Ok(checked);
                }
                checked.count += 1;
                match track.follow(&effect) {
                    Ok(()) => feed.complete(0),
                    Err(fault) => feed.fail(fault).map_err(|fault| fails(fault, line))?,
                }
            }
            Step::Guard(..) | Step::Left(..) => {}
            Step::Thinks => left = left.saturating_sub(BUDGET.into()),
            Step::End => return Ok(checked),
            Step::Fault(fault, line) => feed.fail(fault).map_err(|fault| fails(fault, line))?,
        }
        left = left.saturating_sub(1);
        if left == 0 {
            checked.open = Some(feed.line());
            return Ok(checked);
        }
    }
}

/// Refuses a job for the fault that it would end with.
pub(super) fn fails(fault: Fault, line: u32) -> Refused {
    let text = format!("the job would stop here with {fault}: {}", fault.text());
    Refused::new(line, text, fault.remedy())
}
