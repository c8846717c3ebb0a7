//! Rates and paces: speeds and ramps of statements and commands, limited to the axis's own.
//!
//! [`OwnPaces`] is the small chip's only: the larger one keeps a [`Pace`](crate::motion::Pace).
#![cfg_attr(any(), micro(module = "rules.pace"))]

use super::Axis;
use super::coords::Stands;
use super::effects::Effects;
use crate::motion::scaled::Scaled;
use lang::isa::flags;

/// See [`flags::AXIS`].
#[cfg_attr(any(), micro("FL_AXIS"))]
const AXIS: u8 = flags::AXIS;
/// See [`flags::SPEED`].
#[cfg_attr(any(), micro("FL_SPEED"))]
const SPEED: u8 = flags::SPEED;
/// See [`flags::SPEED_STEPS`].
#[cfg_attr(any(), micro("FL_SPEED_STEPS"))]
const SPEED_STEPS: u8 = flags::SPEED_STEPS;

/// The pace of a move: a speed and ramps, steps.
pub trait Paces: Stands + Effects {
    /// The flags of the statement, which names an axis.
    #[cfg_attr(any(), micro(place = "FLAGS"))]
    fn flags(&self) -> u8;
    /// See [`Paces::flags`].
    #[cfg_attr(any(), micro(place = "FLAGS"))]
    fn keep_flags(&mut self, flags: u8);
    /// What a statement's flags say of a rate: whether it brings one, and in which unit.
    #[cfg_attr(any(), micro(place = "UNIT"))]
    fn set_unit(&mut self, flags: u8);
    /// They say that a rate is on the stack.
    #[cfg_attr(any(), micro(any = "UNIT, FL_ACCEL|FL_DECEL|FL_SPEED"))]
    fn brings_rate(&self) -> bool;
    /// They say steps, else um.
    #[cfg_attr(any(), micro(any = "UNIT, FL_ACCEL_STEPS|FL_DECEL_STEPS|FL_SPEED_STEPS"))]
    fn counts_steps(&self) -> bool;
    /// Rates are in steps.
    #[cfg_attr(any(), micro(code = "LET UNIT, 2"))]
    fn count_in_steps(&mut self);
    /// They are in um.
    #[cfg_attr(any(), micro(code = "LET UNIT, 0"))]
    fn count_in_um(&mut self);
    /// Steps of the axis for [`Paces::um_of`].
    #[cfg_attr(any(), micro(record = "A_STEPS"))]
    fn steps_of(&self, axis: Axis) -> u16;
    /// See [`Paces::steps_of`].
    #[cfg_attr(any(), micro(record = "A_UM"))]
    fn um_of(&self, axis: Axis) -> u16;
    /// The pace is the axis's own.
    #[cfg_attr(any(), micro(code = "DO axis_pace"))]
    fn take_pace(&mut self, axis: Axis);
    /// A rate bounds the pace's ramp up; which is then the smaller one.
    #[cfg_attr(any(), micro(code = "F bound TEMP+4"))]
    fn least_up(&mut self, rate: Scaled) -> Scaled;
    /// It bounds the speed.
    #[cfg_attr(any(), micro(code = "F bound TEMP"))]
    fn least_speed(&mut self, rate: Scaled) -> Scaled;
    /// It bounds the ramp down.
    #[cfg_attr(any(), micro(code = "F bound TEMP+8"))]
    fn least_down(&mut self, rate: Scaled) -> Scaled;
    /// The pace's ramp up.
    #[cfg_attr(any(), micro(place = "TEMP+4"))]
    fn pace_up(&self) -> Scaled;
    /// Its speed.
    #[cfg_attr(any(), micro(place = "TEMP"))]
    fn pace_speed(&self) -> Scaled;
}

/// The small chip's pace, from the axis's record.
pub trait OwnPaces {
    /// The axis's top speed, steps/s.
    #[cfg_attr(any(), micro(record = "A_TOP_RATE"))]
    fn top_rate(&self, axis: Axis) -> i32;
    /// Its ramp up, steps/s2.
    #[cfg_attr(any(), micro(record = "A_ACCEL"))]
    fn ramp_up(&self, axis: Axis) -> i32;
    /// Its ramp down.
    #[cfg_attr(any(), micro(record = "A_DECEL"))]
    fn ramp_down(&self, axis: Axis) -> i32;
    /// The pace's speed.
    #[cfg_attr(any(), micro(place = "TEMP"))]
    fn set_pace_speed(&mut self, speed: Scaled);
    /// Its ramp up.
    #[cfg_attr(any(), micro(place = "TEMP+4"))]
    fn set_pace_up(&mut self, ramp: Scaled);
    /// Its ramp down.
    #[cfg_attr(any(), micro(place = "TEMP+8"))]
    fn set_pace_down(&mut self, ramp: Scaled);
}

/// A rate from the stack, when flags say that there is one: scaled steps, above every number without one, 0 when it is not
/// above 0.
pub fn rate(m: &mut impl Paces, axis: Axis, flags: u8) -> Scaled {
    m.set_unit(flags);
    if !m.brings_rate() {
        return Scaled::MAX;
    }
    let value = m.pop();
    rate_of(m, axis, value)
}

/// A rate as scaled steps, 0 when it is not above 0.
pub fn rate_of(m: &mut impl Paces, axis: Axis, value: i32) -> Scaled {
    let mut rate = Scaled::new(value.max(0) as u32);
    if !m.counts_steps() {
        let steps = rate.times(Scaled::new(u32::from(m.steps_of(axis))));
        rate = steps.over(Scaled::new(u32::from(m.um_of(axis))));
    }
    rate
}

/// A speed that the statement's flags say bounds the pace's, which is then 0 when it is not above 0.
pub fn speed_flags(m: &mut impl Paces, axis: Axis) -> Scaled {
    let speed = rate(m, axis, m.flags() & (SPEED | SPEED_STEPS));
    speed_least(m, speed)
}

/// A speed bounds the pace's.
pub fn speed_least(m: &mut impl Paces, speed: Scaled) -> Scaled {
    m.least_speed(speed)
}

/// The flags of a statement name an axis, which is the effect's; its pace is the move's.
pub fn axis_flags(m: &mut impl Paces, flags: u8) -> Axis {
    m.keep_flags(flags);
    let n = flags & AXIS;
    m.set_number(n);
    let axis = Axis::new(n);
    m.take_pace(axis);
    axis
}

/// The small chip's pace is that of the axis's record.
pub fn axis_pace(m: &mut impl OwnPaces, axis: Axis) {
    m.set_pace_speed(Scaled::new(m.top_rate(axis) as u32));
    m.set_pace_up(Scaled::new(m.ramp_up(axis) as u32));
    m.set_pace_down(Scaled::new(m.ramp_down(axis) as u32));
}
