//! Statements that move single axes, stop them and wait for them.
//!
//! Where the chips differ: the small one moves one thing at a time and begins no statement while anything moves. On
//! the larger one an axis that moves on its own can get a new target, be waited for and be stopped.
#![cfg_attr(any(), micro(module = "rules.axes", prefix = "fx_"))]

use super::pace::Paces;
use super::{Axis, DONE, NOT_YET, Progress, pace};
use crate::motion::scaled::Scaled;
use lang::fault::Fault;
use lang::isa::{Op, flags};
use lang::wire::TraceKind;

/// See [`Op::Move`]; in front of it the axes of MoveAxe and MoveRel, behind it [`Op::MoveRamp`].
#[cfg_attr(any(), micro("OP_MOVE"))]
const MOVE: u8 = Op::Move as u8;
/// See [`flags::ACCEL`].
#[cfg_attr(any(), micro("FL_ACCEL"))]
const ACCEL: u8 = flags::ACCEL;
/// See [`flags::ACCEL_STEPS`].
#[cfg_attr(any(), micro("FL_ACCEL_STEPS"))]
const ACCEL_STEPS: u8 = flags::ACCEL_STEPS;
/// See [`flags::DECEL`].
#[cfg_attr(any(), micro("FL_DECEL"))]
const DECEL: u8 = flags::DECEL;
/// See [`flags::DECEL_STEPS`].
#[cfg_attr(any(), micro("FL_DECEL_STEPS"))]
const DECEL_STEPS: u8 = flags::DECEL_STEPS;

/// As [`crate::effect_rows`].
#[macro_export]
macro_rules! axis_rows {
    ($consumer:ident) => {
        $consumer! {
            axes {
                MoveTo MoveRamp move_axe(code first);
                StopAxe StopAxe stop_axe();
                StopAll StopAll stop_all();
                WaitMove WaitMove wait_move();
            }
        }
    };
}

/// What these statements look at and do.
pub trait Axes: Paces {
    /// The statement's code.
    #[cfg_attr(any(), micro(place = "UNIT"))]
    fn set_code(&mut self, code: u8);
    /// It is MoveAxe or MoveRel with flags of one byte.
    #[cfg_attr(any(), micro(is = "UNIT, OP_MOVE"))]
    fn is_move(&self) -> bool;
    /// What the flags of a short form would be.
    #[cfg_attr(any(), micro(code = "DO short_flags"))]
    fn short_flags(&self, code: u8) -> u8;
    /// The flags of its ramps.
    #[cfg_attr(any(), micro(place = "RAMPS"))]
    fn ramps(&self) -> u8;
    /// See [`Axes::ramps`].
    #[cfg_attr(any(), micro(place = "RAMPS"))]
    fn set_ramps(&mut self, flags: u8);
    /// They say a ramp down.
    #[cfg_attr(any(), micro(any = "RAMPS, FL_DECEL"))]
    fn has_decel(&self) -> bool;
    /// The target is in the unit and frame of the statement's flags; on the small chip the relative one's bit is the next.
    #[cfg_attr(
        any(),
        micro(
            code = "GET FLAGS; ANDI FL_STEPS+FL_RELATIVE; ADDI FL_RELATIVE; ANDI F_STEPS+F_RELATIVE; PUT FRAME_OF"
        )
    )]
    fn take_move_frame(&mut self);
    /// Where it lies: the new place of the axis.
    ///
    /// # Errors
    /// See [`aim`](super::coords::aim).
    #[cfg_attr(any(), micro(code = "DO aim"))]
    fn aim_move(&mut self, axis: Axis, target: i32) -> Result<(), Fault>;
    /// The new place is commanded; whether there is no way to it.
    #[cfg_attr(any(), micro(code = "DO command", holds = "EQUAL"))]
    fn command_place(&mut self, axis: Axis) -> bool;
    /// An axis that moves is sent to the place that it was commanded already.
    #[cfg_attr(any(), micro(never = 1))]
    fn is_sent_again(&self, axis: Axis) -> bool;
    /// It sets off at the pace; the statement is done when it is there, with START at once.
    #[cfg_attr(any(), micro(code = "DO begin_axis"))]
    fn set_out(&mut self, axis: Axis) -> Progress;
    /// What moves of what the statement waits for: on the small chip anything.
    #[cfg_attr(any(), micro(place = "MOVING"))]
    fn moving(&self) -> u8;
    /// The statement was begun and is called again.
    #[cfg_attr(any(), micro(never = 1))]
    fn goes_on(&mut self) -> bool;
    /// An axis is stopped, and waited for; on the small chip it rests.
    #[cfg_attr(any(), micro(code = ""))]
    fn stop_axis(&mut self, n: u8);
    /// All of them are.
    #[cfg_attr(any(), micro(code = ""))]
    fn stop_axes(&mut self);
    /// A host that traces has yet to be told of one.
    #[cfg_attr(any(), micro(never = 1))]
    fn tells_stops(&mut self) -> bool;
    /// An axis is waited for, or all of them.
    ///
    /// # Errors
    /// F20 for one that MoveSpeed runs; on the small chip none.
    #[cfg_attr(any(), micro(code = "", sure = 1))]
    fn await_axis(&mut self, n: u8) -> Result<(), Fault>;
    /// What is waited for moves.
    #[cfg_attr(any(), micro(never = 1))]
    fn awaits_move(&self) -> bool;
}

/// The small chip's planner.
pub trait Begins {
    /// The axis of this bit goes to its commanded place at the pace, where it is not there already.
    #[cfg_attr(any(), micro(code = "CALL axis_begin"))]
    fn begin(&mut self, axis: u8);
}

/// MoveAxe, MoveRel.
///
/// # Errors
/// F08; those of the target.
#[cfg_attr(any(), micro(bytes = "FLAGS", longs = "SPARE, SPARE_TOO"))]
pub fn move_axe(m: &mut impl Axes, code: u8, first: bool) -> Progress {
    if first {
        m.set_ramps(0);
        let bits = if code < MOVE {
            m.short_flags(code)
        } else {
            m.set_code(code);
            let bits = m.operand();
            if !m.is_move() {
                let ramps = m.operand();
                m.set_ramps(ramps);
            }
            bits
        };
        let axis = pace::axis_flags(m, bits);
        let decel = pace::rate(m, axis, m.ramps() & (DECEL | DECEL_STEPS));
        if decel == Scaled::ZERO {
            return Err(Fault::SpeedRange);
        }
        let accel = pace::rate(m, axis, m.ramps() & (ACCEL | ACCEL_STEPS));
        if accel == Scaled::ZERO {
            return Err(Fault::SpeedRange);
        }
        m.least_up(accel);
        // One ramp is both.
        m.least_down(if m.has_decel() { decel } else { accel });
        if pace::speed_flags(m, axis) == Scaled::ZERO {
            return Err(Fault::SpeedRange);
        }
        m.take_move_frame();
        let target = m.pop();
        m.aim_move(axis, target)?;
        if !m.command_place(axis) {
            m.tell(TraceKind::Axe, 0);
            return m.set_out(axis);
        }
        if m.is_sent_again(axis) {
            return m.set_out(axis);
        }
        return DONE;
    }
    if m.moving() != 0 {
        return NOT_YET;
    }
    DONE
}

/// On the small chip the axis sets off to its commanded place at the pace.
#[cfg_attr(any(), micro(label = "begin_axis"))]
pub fn begin_axis(m: &mut impl Begins, axis: Axis) -> Progress {
    m.begin(axis.bit());
    NOT_YET
}

/// StopAxe.
pub fn stop_axe(m: &mut impl Axes) -> Progress {
    if !m.goes_on() {
        let n = m.operand();
        m.set_number(n);
        m.stop_axis(n);
        m.tell(TraceKind::Stop, 0);
    }
    if m.awaits_move() {
        return NOT_YET;
    }
    DONE
}

/// StopAll.
pub fn stop_all(m: &mut impl Axes) -> Progress {
    if !m.goes_on() {
        m.stop_axes();
    }
    if m.tells_stops() || m.awaits_move() {
        return NOT_YET;
    }
    DONE
}

/// WaitMove.
///
/// # Errors
/// F20 for an axis that MoveSpeed runs.
pub fn wait_move(m: &mut impl Axes) -> Progress {
    if !m.goes_on() {
        let n = m.operand();
        m.await_axis(n)?;
    }
    if m.awaits_move() {
        return NOT_YET;
    }
    DONE
}
