//! The state of a run, for the rules of [`crate::rules::session`] on the host and the larger chip.

use lang::fault::Fault;
use lang::wire::{End, RunState};

/// What [`Runs`](crate::rules::session::Runs) asks of the state alone, for a machine that keeps one as `session`.
#[macro_export]
macro_rules! session_leaves {
    () => {
        fn set_state(&mut self, state: u8) {
            self.session.state = state;
        }
        fn is_active(&self) -> bool {
            self.session.is_active()
        }
        fn executes(&self) -> bool {
            self.session.executes()
        }
        fn is_paused(&self) -> bool {
            self.session.is(lang::wire::RunState::Paused)
        }
        fn is_fault(&self) -> bool {
            self.session.is(lang::wire::RunState::Fault)
        }
        fn is_ready(&self) -> bool {
            self.session.is(lang::wire::RunState::Ready)
        }
        fn ending(&self) -> u8 {
            self.session.ending
        }
        fn set_ending(&mut self, how: u8) {
            self.session.ending = how;
        }
        fn ends_by_fault(&self) -> bool {
            self.session.ending == lang::wire::End::Fault as u8
        }
        fn set_last_end(&mut self, how: u8) {
            self.session.last = how;
        }
        fn fault(&self) -> u8 {
            self.session.fault
        }
        fn release(&mut self) {
            self.session.release();
        }
    };
}

/// The state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Session {
    /// [`RunState`], of which waiting for Start is no part.
    pub state: u8,
    /// [`End`] that the run comes to as soon as everything rests, 0 for a pause.
    pub ending: u8,
    /// The program waits for Start.
    waiting: bool,
    /// Start was pressed while it waited.
    released: bool,
    /// Number of the last fault, 0 for none.
    pub fault: u8,
    /// [`End`] of the last run.
    pub last: u8,
    /// Runs begun.
    pub runs: u16,
}

impl Session {
    /// No program.
    pub const fn new() -> Session {
        Session {
            state: RunState::Empty as u8,
            ending: End::None as u8,
            waiting: false,
            released: false,
            fault: 0,
            last: End::None as u8,
            runs: 0,
        }
    }

    /// The state as the link shows it.
    pub fn shown(&self) -> u8 {
        if self.waiting && self.executes() { RunState::WaitStart as u8 } else { self.state }
    }

    /// Whether it is this state.
    pub fn is(&self, state: RunState) -> bool {
        self.state == state as u8
    }

    /// Whether a run was begun and has not ended.
    #[inline(never)]
    pub fn is_active(&self) -> bool {
        self.executes() || self.is(RunState::Paused) || self.is(RunState::Stopping)
    }

    /// Whether the program may execute statements now.
    pub fn executes(&self) -> bool {
        self.is(RunState::Running)
    }

    /// A fault from before the reset is latched.
    pub fn latch(&mut self, fault: Fault) {
        self.fault = fault.number();
        self.state = RunState::Fault as u8;
    }

    /// A program is stored, or none is.
    pub fn stored(&mut self, program: bool) {
        if !self.is_active() && !self.is(RunState::Fault) {
            self.state = if program { RunState::Ready } else { RunState::Empty } as u8;
        }
    }

    /// The program was checked and begins.
    pub fn begun(&mut self) {
        let runs = self.runs.wrapping_add(1);
        *self = Session { state: RunState::Running as u8, runs, ..Session::new() };
    }

    /// The program waits for Start from now on; a press from before does not count.
    pub fn wait_start(&mut self) {
        self.waiting = true;
        self.released = false;
    }

    /// Start is pressed: what waits for it goes on.
    pub fn release(&mut self) {
        self.released |= self.waiting && self.executes();
    }

    /// Whether Start was pressed since [`Session::wait_start`].
    pub fn take_start(&mut self) -> bool {
        if self.released {
            self.waiting = false;
        }
        self.released
    }

    /// The run has ended: nothing waits any more.
    pub fn forget_wait(&mut self) {
        self.waiting = false;
    }
}

impl Default for Session {
    fn default() -> Session {
        Session::new()
    }
}

#[cfg(test)]
mod tests;
