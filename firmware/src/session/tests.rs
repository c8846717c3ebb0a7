//! The rules of runs with a machine that does nothing but tell what it was asked to do.

use super::Session;
use crate::rules::session::{self, Runs};
use lang::fault::Fault;
use lang::wire::{End, RunState};

/// What the machine was asked to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    None,
    Begin,
    Brake,
    Resume,
    Finish,
}

/// A machine without motors.
struct Bench {
    session: Session,
    blocked: bool,
    program: bool,
    order: Order,
}

impl Runs for Bench {
    crate::session_leaves!();

    fn is_stored(&self) -> bool {
        self.program
    }
    fn set_number(&mut self, _: u8) {}
    fn holds_stop(&self) -> bool {
        self.blocked
    }
    fn blocking(&self) -> u8 {
        0
    }
    fn has_tripped(&self) -> bool {
        false
    }
    fn emergency_now(&self) -> u8 {
        0
    }
    fn note_emergency(&mut self) {}
    fn brake_to_pause(&mut self) {
        self.order = Order::Brake;
    }
    fn brake_all(&mut self) {
        self.order = Order::Finish;
    }
    fn give_up(&mut self) {}
    fn halt(&mut self) {}
    fn unwatch(&mut self) {}
    fn forget_homes(&mut self) {}
    fn goes_on_alone(&mut self) -> bool {
        false
    }
    fn rests(&self) -> bool {
        true
    }
    fn goes_through(&self) -> bool {
        false
    }
    fn seeks(&self) -> bool {
        false
    }
    fn go_on(&mut self) {}
    fn set_outputs_at(&mut self, _: u8) {}
    fn exchange(&mut self) {}
    fn outputs(&self) -> u16 {
        0
    }
    fn set_outputs(&mut self, _: u16) {
        self.order = Order::Resume;
    }
    fn resume_outputs(&self) -> u16 {
        0
    }
    fn set_resume(&mut self, _: u16) {}
    fn spindle(&self) -> u8 {
        0
    }
    fn spin_up(&self) -> u16 {
        0
    }
    fn spin(&self) -> u16 {
        0
    }
    fn set_spin(&mut self, _: u16) {}
    fn latch(&mut self, fault: u8) {
        self.session.fault = fault;
    }
    fn forget_fault(&mut self) {}
    fn log(&mut self) {}
    fn has_next_line(&self) -> bool {
        false
    }
    fn drop_line(&mut self) {}
    fn before_start(&self) -> u8 {
        0
    }
    fn attach(&mut self) -> bool {
        true
    }
    fn refuse(&mut self) {}
    fn enter(&mut self) {}
    fn program_has_courses(&self) -> bool {
        false
    }
    fn take_courses(&mut self) {}
    fn load(&mut self) {}
    fn set_stack(&mut self) {}
    fn begin_trace(&mut self) {}
    fn halts(&self) -> bool {
        false
    }
    fn halt_first(&mut self) {}
    fn begun(&mut self) {
        self.session.begun();
        self.order = Order::Begin;
    }
    fn tells(&self) -> bool {
        false
    }
    fn keeps_flash(&self) -> u8 {
        0
    }
    fn save_kept(&mut self) {}
    fn leave_courses(&mut self) {}
    fn unmark(&mut self) {}
    fn settle_place(&mut self) {}
    fn tell_end(&mut self, _: i32) {}
    fn forget(&mut self) {}
    fn leave(&mut self) {
        self.session.forget_wait();
    }
    fn restart(&mut self) {}
}

impl Bench {
    fn new() -> Bench {
        Bench { session: Session::new(), blocked: false, program: false, order: Order::None }
    }

    /// What a rule asks the machine to do.
    fn does(&mut self, rule: impl FnOnce(&mut Bench)) -> Order {
        self.order = Order::None;
        rule(self);
        self.order
    }

    fn start(&mut self, blocked: bool, program: bool) -> Order {
        (self.blocked, self.program) = (blocked, program);
        self.does(session::start)
    }

    fn pause(&mut self) -> Order {
        self.does(session::pause)
    }

    fn stop(&mut self) -> Order {
        self.does(session::stop)
    }

    fn fail(&mut self, fault: Fault) -> Order {
        self.does(|bench| session::fail(bench, fault.number()))
    }

    /// Everything rests; how the run has ended, if it has.
    fn rested(&mut self) -> Option<End> {
        self.session.last = End::None as u8;
        session::stopping(self);
        End::from_number(self.session.last.into()).filter(|end| *end != End::None)
    }

    fn state(&self) -> RunState {
        RunState::from_number(self.session.shown().into()).expect("a state")
    }
}

fn running() -> Bench {
    let mut bench = Bench::new();
    bench.session.stored(true);
    assert_eq!(bench.start(false, true), Order::Begin);
    bench
}

#[test]
fn start_does_nothing_without_a_program_or_when_blocked() {
    let mut bench = Bench::new();
    bench.session.stored(false);
    assert_eq!(bench.start(false, false), Order::None);
    bench.session.stored(true);
    assert_eq!(bench.start(true, true), Order::None);
    assert_eq!(bench.state(), RunState::Ready);
}

#[test]
fn a_pause_is_reached_at_rest_and_left_by_start() {
    let mut bench = running();
    assert_eq!(bench.pause(), Order::Brake);
    assert_eq!(bench.pause(), Order::None);
    assert_eq!(bench.start(false, true), Order::None, "not before it rests");
    assert_eq!(bench.rested(), None);
    assert_eq!(bench.state(), RunState::Paused);
    assert_eq!(bench.start(true, true), Order::None, "a door is open");
    assert_eq!(bench.start(false, true), Order::Resume);
    assert!(bench.executes());
}

#[test]
fn a_stop_ends_a_paused_run_too() {
    let mut bench = running();
    bench.pause();
    bench.rested();
    assert_eq!(bench.stop(), Order::Finish);
    assert_eq!(bench.rested(), Some(End::Stopped));
    assert_eq!((bench.state(), bench.session.last), (RunState::Ready, End::Stopped as u8));
}

#[test]
fn a_fault_is_latched_and_the_first_start_only_acknowledges() {
    let mut bench = running();
    assert_eq!(bench.fail(Fault::SoftLimit), Order::Finish);
    assert_eq!(bench.rested(), Some(End::Fault));
    assert_eq!((bench.state(), bench.session.fault), (RunState::Fault, 5));
    assert_eq!(bench.start(false, true), Order::None);
    assert_eq!(bench.state(), RunState::Ready);
    assert_eq!(bench.session.fault, 5, "still to be read");
    assert_eq!(bench.start(false, true), Order::Begin);
}

#[test]
fn wait_start_takes_only_a_press_during_the_wait() {
    let mut bench = running();
    bench.start(false, true);
    bench.session.wait_start();
    assert!(!bench.session.take_start());
    assert_eq!(bench.state(), RunState::WaitStart);
    bench.start(false, true);
    assert!(bench.session.take_start());
    assert_eq!(bench.state(), RunState::Running);
}
