//! The run state machine: what Start, Stop, the link and the program make of each other.
//!
//! It decides and counts; the board does what [`Order`] says.

use lang::fault::Fault;
use lang::wire::{End, RunState};

/// What the board is to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Nothing.
    None,
    /// Check the stored program and run it from its beginning.
    Begin,
    /// Ramp down; the program stands still.
    Brake,
    /// Go on after a pause.
    Resume,
    /// Ramp down and end the run.
    Finish,
}

/// The state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Session {
    state: RunState,
    /// The run ends when everything rests, instead of pausing.
    ending: Option<End>,
    /// The program waits for Start.
    waiting: bool,
    /// Start was pressed while it waited.
    released: bool,
    /// Last fault.
    fault: u8,
    last: End,
    runs: u16,
}

impl Session {
    /// No program.
    pub const fn new() -> Session {
        Session {
            state: RunState::Empty,
            ending: None,
            waiting: false,
            released: false,
            fault: 0,
            last: End::None,
            runs: 0,
        }
    }

    /// The state as the link shows it.
    pub fn state(&self) -> RunState {
        if self.waiting && self.is(RunState::Running) { RunState::WaitStart } else { self.state }
    }

    fn is(&self, state: RunState) -> bool {
        self.state as u8 == state as u8
    }

    /// Whether a run was begun and has not ended.
    #[inline(never)]
    pub fn is_active(&self) -> bool {
        self.is(RunState::Running) || self.is(RunState::Paused) || self.is(RunState::Stopping)
    }

    /// Whether the program may execute statements now.
    pub fn executes(&self) -> bool {
        self.is(RunState::Running)
    }

    /// Whether the program stands still in a pause, or on its ramp into one.
    pub fn is_paused(&self) -> bool {
        self.is(RunState::Paused) || self.is(RunState::Stopping)
    }

    /// Number of the last fault, 0 for none.
    pub fn fault(&self) -> u8 {
        self.fault
    }

    /// The last fault from before a power-off.
    pub fn remember(&mut self, fault: u8) {
        self.fault = fault;
    }

    /// How the last run ended.
    pub fn last(&self) -> End {
        self.last
    }

    /// Runs begun.
    pub fn runs(&self) -> u16 {
        self.runs
    }

    /// A program is stored, or none is.
    pub fn stored(&mut self, program: bool) {
        if !self.is_active() && !self.is(RunState::Fault) {
            self.state = if program { RunState::Ready } else { RunState::Empty };
        }
    }

    /// Start: the button or the link. `blocked` while Stop is held or a hold, door or emergency
    /// stop input is active.
    pub fn start(&mut self, blocked: bool, program: bool) -> Order {
        match self.state {
            RunState::Fault => {
                if !blocked {
                    self.state = if program { RunState::Ready } else { RunState::Empty };
                }
                Order::None
            }
            _ if blocked => Order::None,
            RunState::Ready => Order::Begin,
            RunState::Paused => self.resume(),
            RunState::Running if self.waiting => {
                self.released = true;
                Order::None
            }
            _ => Order::None,
        }
    }

    /// The program was checked and begins.
    pub fn begun(&mut self) {
        self.state = RunState::Running;
        self.ending = None;
        self.waiting = false;
        self.fault = 0;
        self.last = End::None;
        self.runs = self.runs.wrapping_add(1);
    }

    /// Stop or hold: ramp down and pause.
    pub fn pause(&mut self) -> Order {
        if !self.is(RunState::Running) {
            return Order::None;
        }
        self.state = RunState::Stopping;
        Order::Brake
    }

    /// Goes on after a pause.
    pub fn resume(&mut self) -> Order {
        if !self.is(RunState::Paused) {
            return Order::None;
        }
        self.state = RunState::Running;
        Order::Resume
    }

    /// Ends the run on a ramp.
    pub fn stop(&mut self) -> Order {
        if !self.is_active() {
            return Order::None;
        }
        self.state = RunState::Stopping;
        self.ending = Some(End::Stopped);
        Order::Finish
    }

    /// The program came to its end, or failed with a fault that nothing handles.
    pub fn end(&mut self, fault: Option<Fault>) -> Order {
        if let Some(fault) = fault {
            self.fault = fault.number();
        }
        if !self.is_active() {
            if fault.is_some() {
                self.state = RunState::Fault;
            }
            return Order::None;
        }
        self.state = RunState::Stopping;
        self.ending = Some(if fault.is_some() { End::Fault } else { End::Done });
        Order::Finish
    }

    /// How the run ends as soon as everything rests; none for a pause.
    pub fn ends(&self) -> Option<End> {
        self.ending
    }

    /// Everything rests: a pause or an end is reached. Returns how the run ended, if it did.
    pub fn rested(&mut self) -> Option<End> {
        if !self.is(RunState::Stopping) {
            return None;
        }
        let Some(end) = self.ending.take() else {
            self.state = RunState::Paused;
            return None;
        };
        self.waiting = false;
        self.last = end;
        self.state = if end as u8 == End::Fault as u8 { RunState::Fault } else { RunState::Ready };
        Some(end)
    }

    /// The program waits for Start from now on; a press from before does not count.
    pub fn wait_start(&mut self) {
        self.waiting = true;
        self.released = false;
    }

    /// Whether Start was pressed since [`Session::wait_start`].
    pub fn take_start(&mut self) -> bool {
        if self.released {
            self.waiting = false;
        }
        self.released
    }
}

impl Default for Session {
    fn default() -> Session {
        Session::new()
    }
}

#[cfg(test)]
mod tests {
    use super::{Order, Session};
    use lang::fault::Fault;
    use lang::wire::{End, RunState};

    fn running() -> Session {
        let mut session = Session::new();
        session.stored(true);
        assert_eq!(session.start(false, true), Order::Begin);
        session.begun();
        session
    }

    #[test]
    fn start_does_nothing_without_a_program_or_when_blocked() {
        let mut session = Session::new();
        session.stored(false);
        assert_eq!(session.start(false, false), Order::None);
        session.stored(true);
        assert_eq!(session.start(true, true), Order::None);
        assert_eq!(session.state(), RunState::Ready);
    }

    #[test]
    fn a_pause_is_reached_at_rest_and_left_by_start() {
        let mut session = running();
        assert_eq!(session.pause(), Order::Brake);
        assert_eq!(session.pause(), Order::None);
        assert_eq!(session.start(false, true), Order::None, "not before it rests");
        assert_eq!(session.rested(), None);
        assert_eq!(session.state(), RunState::Paused);
        assert_eq!(session.start(true, true), Order::None, "a door is open");
        assert_eq!(session.start(false, true), Order::Resume);
        assert!(session.executes());
    }

    #[test]
    fn a_stop_ends_a_paused_run_too() {
        let mut session = running();
        session.pause();
        session.rested();
        assert_eq!(session.stop(), Order::Finish);
        assert_eq!(session.rested(), Some(End::Stopped));
        assert_eq!((session.state(), session.last()), (RunState::Ready, End::Stopped));
    }

    #[test]
    fn a_fault_is_latched_and_the_first_start_only_acknowledges() {
        let mut session = running();
        assert_eq!(session.end(Some(Fault::SoftLimit)), Order::Finish);
        assert_eq!(session.rested(), Some(End::Fault));
        assert_eq!((session.state(), session.fault()), (RunState::Fault, 5));
        assert_eq!(session.start(false, true), Order::None);
        assert_eq!(session.state(), RunState::Ready);
        assert_eq!(session.fault(), 5, "still to be read");
        assert_eq!(session.start(false, true), Order::Begin);
    }

    #[test]
    fn wait_start_takes_only_a_press_during_the_wait() {
        let mut session = running();
        session.start(false, true);
        session.wait_start();
        assert!(!session.take_start());
        assert_eq!(session.state(), RunState::WaitStart);
        session.start(false, true);
        assert!(session.take_start());
        assert_eq!(session.state(), RunState::Running);
    }
}
