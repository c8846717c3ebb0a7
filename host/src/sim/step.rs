//! What the machine tells an engine.

use lang::fault::Fault;

/// What an engine does next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Go on; the value of a [`lang::effect::Effect::Read`], else 0.
    Done(i32),
    /// Serve the handler of this event slot, then the statement that was about to run, or
    /// `Machine::resume` when it came from a wait.
    Event(u8),
    /// The statement failed.
    Fault(Fault),
    /// A fault that came by itself (MoveSpeed at a soft limit): ERL is the statement about to run
    /// or waiting, and RESUME NEXT goes on with it.
    Late(Fault),
    /// The run is over; call `Machine::finish`.
    Stop,
}
