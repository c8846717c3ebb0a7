//! Statements that set speeds and ramps, and what a program may read of axes, inputs and time.
#![cfg_attr(any(), micro(module = "rules.moves", prefix = "fx_"))]

use super::{Axis, DONE, Progress};
use lang::fault::Fault;
use lang::isa::{Look, Op, flags};

/// See [`Op::SetPosZero`]; the axes follow.
#[cfg_attr(any(), micro("OP_SET_POS_ZERO"))]
const SET_POS_ZERO: u8 = Op::SetPosZero as u8;
/// See [`flags::AXIS`].
#[cfg_attr(any(), micro("FL_AXIS"))]
const AXIS: u8 = flags::AXIS;

/// What is asked for: see [`Look`].
const POS: u8 = 0;
const POS_STEPS: u8 = 1;
const PROBED: u8 = 2;
const PROBED_STEPS: u8 = 3;
const PROBE_OK: u8 = 4;
const MOVING: u8 = 5;
const HOMED: u8 = 6;
const IN_PORT: u8 = 7;
const TIMER: u8 = 8;
const _: () = assert!(
    POS == Look::Pos as u8
        && POS_STEPS == Look::PosSteps as u8
        && PROBED == Look::Probed as u8
        && PROBED_STEPS == Look::ProbedSteps as u8
        && PROBE_OK == Look::ProbeOk as u8
        && MOVING == Look::Moving as u8
        && HOMED == Look::Homed as u8
        && IN_PORT == Look::InPort as u8
        && TIMER == Look::Timer as u8
        && Look::CharIn as u8 == 9
);

/// As [`crate::effect_rows`].
#[macro_export]
macro_rules! move_rows {
    ($consumer:ident) => {
        $consumer! {
            moves {
                Feed Spindle feed(code);
                SetPos SetPos set_pos();
                SetPosZero SetPosZero set_pos_zero(code);
                Read Read read();
            }
        }
    };
}

/// What these rules look at and change.
pub trait Moves {
    /// The statement's next operand byte.
    #[cfg_attr(any(), micro(code = "DO operand_byte"))]
    fn operand(&mut self) -> u8;
    /// The top of the stack, taken.
    #[cfg_attr(any(), micro(code = "DO pop_value"))]
    fn pop(&mut self) -> i32;
    /// Puts a value on the stack.
    #[cfg_attr(any(), micro(code = "CALL push_value"))]
    fn push_long(&mut self, value: i32);
    /// The statement's code.
    #[cfg_attr(any(), micro(place = "UNIT"))]
    fn set_code(&mut self, code: u8);
    /// It is S.
    #[cfg_attr(any(), micro(is = "UNIT, OP_SPINDLE"))]
    fn is_spindle(&self) -> bool;
    /// It is F in um/s.
    #[cfg_attr(any(), micro(is = "UNIT, OP_FEED"))]
    fn is_feed(&self) -> bool;
    /// S, on a machine that has a power to set.
    ///
    /// # Errors
    /// F20 beyond the power there is; on the small chip, which has none to set, none.
    #[cfg_attr(any(), micro(code = "", sure = 1))]
    fn set_power(&mut self, value: i32) -> Result<(), Fault>;
    /// F: um/s, negative steps/s.
    #[cfg_attr(any(), micro(place = "FEED"))]
    fn set_feed(&mut self, feed: i32);
    /// The axis rests: its work zero may be set.
    ///
    /// # Errors
    /// F20 while it moves; on the small chip nothing moves when a statement begins.
    #[cfg_attr(any(), micro(code = "", sure = 1))]
    fn must_rest(&self, axis: Axis) -> Result<(), Fault>;
    /// The commanded place, um.
    #[cfg_attr(any(), micro(place = "UM"))]
    fn um(&self, axis: Axis) -> i32;
    /// Work offset: machine position less work position, um.
    #[cfg_attr(any(), micro(place = "OFFSET"))]
    fn offset(&self, axis: Axis) -> i32;
    /// See [`Moves::offset`].
    #[cfg_attr(any(), micro(place = "OFFSET"))]
    fn set_offset(&mut self, axis: Axis, um: i32);
    /// SetPos has said where the axis is.
    #[cfg_attr(any(), micro(on = "PLACED"))]
    fn set_placed(&mut self, axis: Axis);
    /// Where the axis is at this instant, steps.
    #[cfg_attr(any(), micro(place = "ACTUAL", load = "DO here"))]
    fn position(&self, axis: Axis) -> i32;
    /// Where its last probe answered, steps.
    #[cfg_attr(any(), micro(place = "PROBED"))]
    fn probed(&self, axis: Axis) -> i32;
    /// Steps as um, half away from zero; nothing when they do not fit.
    #[cfg_attr(any(), micro(code = "DO to_um", holds = "CARRY"))]
    fn to_um(&self, axis: Axis, steps: i32) -> Option<i32>;
    /// Its last probe answered.
    #[cfg_attr(any(), micro(has = "PROBE_OK"))]
    fn has_probed(&self, axis: Axis) -> bool;
    /// It moves.
    #[cfg_attr(any(), micro(has = "MOVING"))]
    fn is_moving(&self, axis: Axis) -> bool;
    /// It has homed.
    #[cfg_attr(any(), micro(has = "HOMED"))]
    fn is_homed(&self, axis: Axis) -> bool;
    /// Levels of the inputs from bit 0 on, input 17 in bit 16.
    #[cfg_attr(
        any(),
        micro(code = "LIT 17; DO input; F put TEMP+2; F word INPUT; F put TEMP; F load TEMP")
    )]
    fn port(&self) -> i32;
    /// Milliseconds of the run.
    #[cfg_attr(any(), micro(place = "TIMER_MS"))]
    fn timer(&self) -> i32;
    /// The character that a host has sent, 0 for none.
    #[cfg_attr(any(), micro(place = "CHAR_IN"))]
    fn char_in(&self) -> u8;
    /// See [`Moves::char_in`].
    #[cfg_attr(any(), micro(place = "CHAR_IN"))]
    fn set_char_in(&mut self, c: u8);
}

/// F and S.
///
/// # Errors
/// F08, F20.
pub fn feed(m: &mut impl Moves, code: u8) -> Progress {
    m.set_code(code);
    let value = m.pop();
    if m.is_spindle() {
        m.set_power(value)?;
        return DONE;
    }
    let mut feed = value.max(0);
    if feed == 0 {
        return Err(Fault::SpeedRange);
    }
    if !m.is_feed() {
        feed = feed.wrapping_neg();
    }
    m.set_feed(feed);
    DONE
}

/// Work zeros: the commanded place becomes 0.
pub fn set_pos_zero(m: &mut impl Moves, code: u8) -> Progress {
    let axis = Axis::new(code.wrapping_sub(SET_POS_ZERO));
    place_is(m, axis, 0)
}

/// SetPos: it becomes the value on the stack.
pub fn set_pos(m: &mut impl Moves) -> Progress {
    let axis = Axis::new(m.operand());
    let place = m.pop();
    place_is(m, axis, place)
}

#[cfg_attr(any(), micro(longs = "SPARE"))]
fn place_is(m: &mut impl Moves, axis: Axis, place: i32) -> Progress {
    m.must_rest(axis)?;
    let offset = m.um(axis).checked_sub(place).ok_or(Fault::Overflow)?;
    m.set_offset(axis, offset);
    m.set_placed(axis);
    DONE
}

/// What a program asks for.
#[cfg_attr(any(), micro(bytes = "FLAGS"))]
pub fn read(m: &mut impl Moves) -> Progress {
    let look = m.operand();
    let axis = Axis::new(look & AXIS);
    match look >> 2 {
        POS => {
            let um = m.to_um(axis, m.position(axis)).unwrap_or(0);
            m.push_long(um.wrapping_sub(m.offset(axis)));
            DONE
        }
        POS_STEPS => {
            m.push_long(m.position(axis));
            DONE
        }
        PROBED => {
            let um = m.to_um(axis, m.probed(axis)).unwrap_or(0);
            m.push_long(um.wrapping_sub(m.offset(axis)));
            DONE
        }
        PROBED_STEPS => {
            m.push_long(m.probed(axis));
            DONE
        }
        PROBE_OK => {
            m.push_long(if m.has_probed(axis) { 1 } else { 0 });
            DONE
        }
        MOVING => {
            m.push_long(if m.is_moving(axis) { 1 } else { 0 });
            DONE
        }
        HOMED => {
            m.push_long(if m.is_homed(axis) { 1 } else { 0 });
            DONE
        }
        IN_PORT => {
            m.push_long(m.port());
            DONE
        }
        TIMER => {
            m.push_long(m.timer());
            DONE
        }
        _ => {
            let c = m.char_in();
            m.set_char_in(0);
            m.push_long(i32::from(c));
            DONE
        }
    }
}
