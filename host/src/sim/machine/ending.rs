//! What is known of a run's end.

use lang::fault::Fault;

use crate::sim::record::StopReason;
use crate::sim::world::WorldError;

/// Why the run is over although the program has not ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Halt {
    /// The run was stopped.
    Stopped(StopReason),
    /// A fault that no handler may take.
    Fault(Fault),
}

/// See the module.
#[derive(Debug)]
pub struct Ending {
    /// Why the run is over, once it is.
    pub halt: Option<Halt>,
    /// Why the run was stopped, once it has been.
    pub stopped: Option<StopReason>,
    /// Line of the path's block that a fault has cut.
    pub cut: Option<u32>,
    /// The world's script failed.
    pub world_error: Option<WorldError>,
    /// Asked now and then: `true` ends the run.
    pub interrupted: fn() -> bool,
}

impl Ending {
    /// No end in sight; `interrupted` says when the user wants one.
    pub fn new(interrupted: fn() -> bool) -> Ending {
        Ending { halt: None, stopped: None, cut: None, world_error: None, interrupted }
    }
}
