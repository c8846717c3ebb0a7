//! Runs: how Start, Stop, the link, inputs and the program's end interact.
//!
//! A run brakes to a pause or to its end; the rest is done as soon as everything rests. Each chip enters a
//! program in its own way, and knows in its own way whether everything rests.
#![cfg_attr(any(), micro(module = "rules.session", prefix = "run_", section = "session"))]

mod leaves;

pub use leaves::Runs;

use super::{NOT_YET, Progress};
use lang::fault::Fault;
use lang::wire::{Control, End, RunState};

/// States.
const EMPTY: u8 = 0;
const READY: u8 = 1;
const RUNNING: u8 = 2;
const PAUSED: u8 = 3;
const FAULT: u8 = 4;
const STOPPING: u8 = 6;
const _: () = assert!(
    EMPTY == RunState::Empty as u8
        && READY == RunState::Ready as u8
        && RUNNING == RunState::Running as u8
        && PAUSED == RunState::Paused as u8
        && FAULT == RunState::Fault as u8
        && STOPPING == RunState::Stopping as u8
);

/// How a run ends.
const DONE: u8 = 1;
const STOPPED: u8 = 2;
const FAILED: u8 = 3;
const _: () =
    assert!(DONE == End::Done as u8 && STOPPED == End::Stopped as u8 && FAILED == End::Fault as u8);

/// Occasions of outputs.
#[cfg_attr(any(), micro("B_AT_PAUSE"))]
pub const AT_PAUSE: u8 = 0;
/// See [`AT_PAUSE`].
#[cfg_attr(any(), micro("B_AT_END"))]
pub const AT_END: u8 = 1;
/// See [`AT_PAUSE`].
#[cfg_attr(any(), micro("B_AT_FAULT"))]
pub const AT_FAULT: u8 = 2;

/// See [`Fault::EmergencyStop`].
#[cfg_attr(any(), micro("F_EMERGENCY_STOP"))]
const EMERGENCY_STOP: u8 = Fault::EmergencyStop.number();

const _: () = assert!(
    Control::Start as u8 == 1
        && Control::Stop as u8 == 2
        && Control::Pause as u8 == 3
        && Control::Resume as u8 == 4
        && Control::EmergencyStop as u8 == 5
        && Control::Acknowledge as u8 == 6
        && Control::Restart as u8 == 7
        && Control::ALL.len() == 7
);

/// The emergency stop as long as its input is pressed, or when its pin has tripped.
#[cfg_attr(any(), micro(entry = "emergency_input"))]
pub fn watch_emergency(m: &mut impl Runs) {
    if m.has_tripped() || m.emergency_now() != 0 {
        emergency(m);
    }
}

/// Obeys a [`Control`] code; one that is not for this state does nothing.
#[cfg_attr(any(), micro(entry = "control"))]
pub fn control(m: &mut impl Runs, code: u8) {
    match code {
        1 => start(m),
        2 => stop(m),
        3 => pause(m),
        4 => {
            if m.is_paused() {
                start(m);
            }
        }
        5 => emergency(m),
        6 => {
            if m.is_fault() {
                start(m);
            }
        }
        _ => m.restart(),
    }
}

/// Stop or hold: ramp down and pause.
#[cfg_attr(any(), micro(entry = "run_pause"))]
pub fn pause(m: &mut impl Runs) {
    if m.executes() {
        m.set_state(STOPPING);
        m.brake_to_pause();
        return;
    }
    end_commands(m);
}

/// Ends the run on a ramp.
#[cfg_attr(any(), micro(entry = "run_stop"))]
pub fn stop(m: &mut impl Runs) {
    if m.is_active() {
        finish(m, STOPPED);
    } else {
        end_commands(m);
    }
}

/// Without a run, what commands move comes to rest on its ramp.
fn end_commands(m: &mut impl Runs) {
    if m.is_active() {
        return;
    }
    m.give_up();
    m.brake_all();
}

/// Ends the active run as an [`End`] says.
fn finish(m: &mut impl Runs, how: u8) {
    m.set_ending(how);
    m.set_state(STOPPING);
    m.brake_all();
}

/// The program has come to its end.
#[cfg_attr(any(), micro(label = "fx_end"))]
pub fn end(m: &mut impl Runs) -> Progress {
    if m.goes_on_alone() {
        return NOT_YET;
    }
    finish(m, DONE);
    NOT_YET
}

/// Steps cease at once, outputs go to their safe states whatever trace and KEEP values have to do, F14 is latched,
/// with the input that is on now.
pub fn emergency(m: &mut impl Runs) {
    m.halt();
    m.unwatch();
    m.forget_homes();
    m.set_outputs_at(AT_FAULT);
    m.exchange();
    m.note_emergency();
    fail(m, EMERGENCY_STOP);
    if m.is_fault() {
        m.forget();
    }
}

/// A fault that ends the run, if there is one.
#[cfg_attr(any(), micro(entry = "fail"))]
pub fn fail(m: &mut impl Runs, fault: u8) {
    m.latch(fault);
    if m.has_next_line() {
        m.drop_line();
    }
    if m.is_active() {
        return finish(m, FAILED);
    }
    m.set_state(FAULT);
}

/// Start: the button, the link, autorun. Nothing while Stop is held or an input keeps the machine from working.
#[cfg_attr(any(), micro(entry = "run_start"))]
pub fn start(m: &mut impl Runs) {
    if m.holds_stop() || m.blocking() != 0 {
        return;
    }
    if m.is_paused() {
        return resume(m);
    }
    if m.is_fault() {
        m.set_state(EMPTY);
        if m.is_stored() {
            m.set_state(READY);
        }
        return;
    }
    m.release();
    if m.is_ready() && m.before_start() == 0 {
        begin(m);
    }
}

/// The stored program is checked and begins.
fn begin(m: &mut impl Runs) {
    if !m.attach() {
        return m.refuse();
    }
    m.enter();
    if m.program_has_courses() {
        m.take_courses();
    }
    m.load();
    m.set_state(RUNNING);
    m.set_stack();
    m.begin_trace();
    if m.halts() {
        m.halt_first();
    }
    m.begun();
}

/// Goes on after a pause: nothing moves before the spindle has come up again.
#[cfg_attr(any(), micro(bytes = "TEMP"))]
fn resume(m: &mut impl Runs) {
    m.set_state(RUNNING);
    let turned = m.spindle();
    m.set_outputs(m.resume_outputs());
    m.set_spin(1);
    if turned == 0 && m.spindle() != 0 {
        m.set_spin(m.spin_up().wrapping_add(m.spin()));
    }
}

/// One pass on the ramp into a pause or to the end.
#[cfg_attr(any(), micro(entry = "run_stopping"))]
pub fn stopping(m: &mut impl Runs) {
    if !m.rests() {
        // It brakes along the path: lines go on. What homing or probing looks for may come on the way to rest, too.
        if m.goes_through() || m.seeks() {
            m.go_on();
        }
        return;
    }
    if m.ending() != 0 {
        // Outputs wait for nothing, the end for the host that traces.
        m.set_outputs_at(if m.ends_by_fault() { AT_FAULT } else { AT_END });
        if m.tells() {
            return;
        }
    }
    if m.keeps_flash() != 0 {
        return;
    }
    m.save_kept();
    if m.ending() == 0 {
        m.set_resume(m.outputs());
        m.set_outputs_at(AT_PAUSE);
        m.set_state(PAUSED);
        return;
    }
    ended(m);
}

/// The run has ended and everything rests.
fn ended(m: &mut impl Runs) {
    m.set_state(READY);
    let how = m.ending();
    m.set_last_end(how);
    m.set_number(how);
    m.set_ending(0);
    m.leave_courses();
    m.unmark();
    m.settle_place();
    if how == FAILED {
        m.set_state(FAULT);
        m.log();
    } else {
        m.forget_fault();
    }
    m.tell_end(i32::from(m.fault()));
    m.leave();
}
