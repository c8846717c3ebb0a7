//! Probing: a move that ends where inputs answer.
//!
//! [`probe`] runs on every chip. [`Watches`] is the small one's only: all of its axes rest when a probe begins.
#![cfg_attr(any(), micro(module = "rules.probe", prefix = "probe_"))]

use super::pace::Paces;
use super::{Axis, DONE, NOT_YET, Progress, pace};
use crate::motion::scaled::Scaled;
use lang::fault::Fault;
use lang::wire::TraceKind;

/// Phases: on the way.
pub const MOVES: u8 = 1;
/// Braking behind the place where the inputs answered.
pub const CAUGHT: u8 = 2;
/// At the end of the way, without an answer.
pub const MISSED: u8 = 3;

/// As [`crate::effect_rows`].
#[macro_export]
macro_rules! probe_rows {
    ($consumer:ident) => {
        $consumer! {
            probe {
                Probe Probe probe(first);
            }
        }
    };
}

/// What a probe looks at and does.
pub trait Probes: Paces {
    /// The axis moves yet: the statement begins again later. On the small chip nothing does then.
    #[cfg_attr(any(), micro(never = 1))]
    fn comes_later(&mut self, axis: Axis) -> bool;
    /// The flags of what is waited for.
    #[cfg_attr(any(), micro(code = "DO operand_byte; PUT RAMPS"))]
    fn take_sensor(&mut self);
    /// They say masks of inputs.
    #[cfg_attr(any(), micro(any = "RAMPS, FL_MASK"))]
    fn has_masks(&self) -> bool;
    /// They say an input and its level.
    #[cfg_attr(any(), micro(any = "RAMPS, FL_SENSOR"))]
    fn has_sensor(&self) -> bool;
    /// The profile's input, from 1, or 0.
    #[cfg_attr(any(), micro(code = "PROFILE B_PROBE"))]
    fn sensor(&self) -> u8;
    /// The inputs of a mask that must be off; said first.
    #[cfg_attr(any(), micro(code = "DO probe_xor"))]
    fn await_off(&mut self, inputs: i32);
    /// Those that count.
    #[cfg_attr(any(), micro(code = "DO probe_and"))]
    fn await_of(&mut self, inputs: i32);
    /// An input from 1, of the level that was set.
    #[cfg_attr(any(), micro(code = "DO probe_input"))]
    fn await_input(&mut self, n: u8);
    /// The statement brings a speed.
    #[cfg_attr(any(), micro(any = "FLAGS, FL_SPEED"))]
    fn has_speed(&self) -> bool;
    /// F: um/s, negative steps/s, 0 for none.
    #[cfg_attr(any(), micro(place = "FEED"))]
    fn feed(&self) -> i32;
    /// The limit is in the unit and frame of the flags.
    #[cfg_attr(any(), micro(code = "GET FLAGS; ANDI F_STEPS+F_MACHINE+F_RELATIVE; PUT FRAME_OF"))]
    fn take_frame(&mut self);
    /// Where it lies: the new place of the axis.
    ///
    /// # Errors
    /// See [`aim`](super::coords::aim).
    #[cfg_attr(any(), micro(code = "DO aim"))]
    fn aim_at(&mut self, axis: Axis, limit: i32) -> Result<(), Fault>;
    /// The axis sets off to it at the pace; not when the inputs answer already.
    #[cfg_attr(any(), micro(code = "DO probe_begin", holds = "EQUAL"))]
    fn begin_probe(&mut self, axis: Axis) -> bool;
    /// The axis of the effect.
    #[cfg_attr(any(), micro(code = "DO axis_n"))]
    fn axis(&self) -> Axis;
    /// What the effect has come to.
    #[cfg_attr(any(), micro(place = "PHASE"))]
    fn phase(&self) -> u8;
    /// See [`Probes::phase`].
    #[cfg_attr(any(), micro(place = "PHASE"))]
    fn set_phase(&mut self, phase: u8);
    /// The next phase.
    #[cfg_attr(any(), micro(code = "UP PHASE"))]
    fn next_phase(&mut self);
    /// A pin answered between two looks: not 0.
    #[cfg_attr(any(), micro(place = "HIT"))]
    fn hit(&self) -> u8;
    /// Where the axis was then, steps.
    #[cfg_attr(any(), micro(code = "CALL motion_caught"))]
    fn caught(&mut self, axis: Axis) -> i32;
    /// The inputs answer.
    #[cfg_attr(any(), micro(code = "DO probe_answers", holds = "NOT_EQUAL"))]
    fn answers(&self) -> bool;
    /// The axis when it moves; on the small chip all.
    #[cfg_attr(any(), micro(place = "MOVING"))]
    fn moving_of(&self, axis: Axis) -> u8;
    /// Where its last probe answered, steps.
    #[cfg_attr(any(), micro(place = "PROBED"))]
    fn probed(&self, axis: Axis) -> i32;
    /// See [`Probes::probed`].
    #[cfg_attr(any(), micro(place = "PROBED"))]
    fn set_probed(&mut self, axis: Axis, steps: i32);
    /// It has answered.
    #[cfg_attr(any(), micro(on = "PROBE_OK"))]
    fn set_answered(&mut self, axis: Axis);
    /// The axis was at a place: it brakes.
    #[cfg_attr(any(), micro(code = "DO motion_hit"))]
    fn brake_from(&mut self, axis: Axis, steps: i32);
    /// No pin is watched any more; on the small chip the next motion sees to that.
    #[cfg_attr(any(), micro(code = ""))]
    fn watch_nothing(&mut self);
    /// The statement tells whether it has found something.
    #[cfg_attr(any(), micro(any = "BITS, FL_QUERY"))]
    fn is_asked(&self) -> bool;
}

/// The small chip's pins.
pub trait Watches: Probes {
    /// Its last probe has not answered.
    #[cfg_attr(any(), micro(off = "PROBE_OK"))]
    fn forget_answer(&mut self, axis: Axis);
    /// The new place is commanded: the axis sets off to it at the pace.
    #[cfg_attr(any(), micro(code = "DO command; DO begin_axis"))]
    fn set_off(&mut self, axis: Axis);
    /// No pin has answered.
    #[cfg_attr(any(), micro(place = "HIT"))]
    fn set_hit(&mut self, hit: u8);
    /// The pins of inputs that count, of the direct wiring; all of port 1 rest now.
    #[cfg_attr(any(), micro(code = "CALL probe_pins"))]
    fn pins(&mut self) -> u8;
    /// The pins that are watched.
    #[cfg_attr(any(), micro(place = "WATCH"))]
    fn watch(&mut self, pins: u8);
    /// Flags of the profile: the chain wiring.
    #[cfg_attr(any(), micro(code = "PROFILE B_FLAGS; TESTI BOARD_CHAIN", holds = "NOT_EQUAL"))]
    fn is_chained(&self) -> bool;
    /// Inputs 1 to 16 that count.
    #[cfg_attr(any(), micro(place = "PROBE_AND"))]
    fn counting(&self) -> u16;
    /// Input 17 does.
    #[cfg_attr(any(), micro(any = "BITS, PROBE_AND_17"))]
    fn counts_17(&self) -> bool;
    /// Its pin is watched.
    #[cfg_attr(any(), micro(code = "LET WATCH, P1_REF_X_OR_PROBE"))]
    fn watch_17(&mut self);
    /// The step that is caught is the last.
    #[cfg_attr(any(), micro(code = "BITS_ON IDLE, WATCH_ENDS"))]
    fn end_there(&mut self);
    /// It is not.
    #[cfg_attr(any(), micro(code = "BITS_OFF IDLE, WATCH_ENDS"))]
    fn go_on_there(&mut self);
    /// The axis is no faster than its start rate.
    #[cfg_attr(any(), micro(code = "F load START2; F sub NOMINAL2", holds = "NEGATIVE"))]
    fn is_faster_than_start(&self) -> bool;
}

/// Probe, ProbeMask, commands 107 and 108.
///
/// # Errors
/// F08, F12, F19, F20; those of the limit.
#[cfg_attr(any(), micro(label = "fx_probe"))]
pub fn probe(m: &mut impl Probes, first: bool) -> Progress {
    if first {
        let bits = m.operand();
        let axis = pace::axis_flags(m, bits);
        if m.comes_later(axis) {
            return NOT_YET;
        }
        m.take_sensor();
        if m.has_masks() {
            let off = m.pop();
            m.await_off(off);
            let of = m.pop();
            m.await_of(of);
        } else {
            m.set_level(1);
            let mut n = m.sensor();
            if m.has_sensor() {
                m.pop_level();
                n = m.pop_input()?;
            }
            if n == 0 {
                return Err(Fault::ValueRange);
            }
            m.await_input(n);
        }
        if m.has_speed() {
            if pace::speed_flags(m, axis) == Scaled::ZERO {
                return Err(Fault::SpeedRange);
            }
        } else {
            m.count_in_um();
            let mut feed = m.feed();
            if feed < 0 {
                m.count_in_steps();
                feed = feed.wrapping_neg();
            }
            let speed = pace::rate_of(m, axis, feed);
            if pace::speed_least(m, speed) == Scaled::ZERO {
                return Err(Fault::SpeedRange);
            }
        }
        m.take_frame();
        let limit = m.pop();
        m.aim_at(axis, limit)?;
        if m.begin_probe(axis) {
            return NOT_YET;
        }
        let axis = m.axis();
        m.tell(TraceKind::Probe, m.position(axis));
        return Err(Fault::InputActive);
    }
    let axis = m.axis();
    if m.phase() == MOVES {
        if m.hit() != 0 {
            let at = m.caught(axis);
            return answered(m, axis, at);
        }
        if m.answers() {
            return answered(m, axis, m.position(axis));
        }
        if m.moving_of(axis) != 0 {
            return NOT_YET;
        }
        m.set_phase(MISSED);
    }
    if m.moving_of(axis) != 0 {
        return NOT_YET;
    }
    m.watch_nothing();
    if m.phase() == CAUGHT {
        m.tell_met(TraceKind::Probe, m.probed(axis));
        return DONE;
    }
    m.tell(TraceKind::Probe, m.position(axis));
    if m.is_asked() {
        return DONE;
    }
    Err(Fault::ProbeMissed)
}

fn answered(m: &mut impl Probes, axis: Axis, at: i32) -> Progress {
    m.set_probed(axis, at);
    m.next_phase();
    m.set_answered(axis);
    m.brake_from(axis, m.probed(axis));
    NOT_YET
}

/// The axis sets off to its new place at the pace; not when the inputs answer already. A probe at pins of port 1 is
/// caught at its very step.
#[cfg_attr(any(), micro(holds = "EQUAL"))]
pub fn begin(m: &mut impl Watches, axis: Axis) -> bool {
    m.forget_answer(axis);
    if m.answers() {
        return false;
    }
    m.set_off(axis);
    m.set_hit(0);
    let pins = m.pins();
    m.watch(pins);
    if m.is_chained() {
        m.watch(0);
        if m.counting() == 0 && m.counts_17() {
            m.watch_17();
        }
    }
    m.go_on_there();
    if !m.is_faster_than_start() {
        // It stands still at once.
        m.end_there();
    }
    true
}
