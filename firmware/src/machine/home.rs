//! Homing: state and actions behind [`crate::rules::home`].

use crate::machine::chip::Chip;
use crate::machine::controller::{Controller, Plan};
use crate::motion::Pace;
use crate::rules::home::{BEGIN, FAST, Homes, SLOW, home};
use crate::rules::{Axis, Progress};
use lang::fault::Fault;
use lang::isa::{first, last};
use lang::record::AxisRecord;

impl<C: Chip> Controller<C> {
    /// Plans a reference run by the profile.
    ///
    /// # Errors
    /// F01.
    pub fn plan_home(&mut self, n: u8) -> Result<(), Fault> {
        let record = self.motor.axis(n);
        let positive = record.flags & AxisRecord::HOME_POSITIVE != 0;
        let position = self.motor.convert(n, record.home_position, true)?;
        let away = if positive { -record.home_clearance } else { record.home_clearance };
        let rest = self.motor.convert(n, record.home_position.wrapping_add(away), true)?;
        self.seek.plan = Plan {
            input: self.record.reference[usize::from(n)],
            closed: true,
            positive,
            pace: Pace::of(record).with_steps(u32::from(record.home_fast)),
            slow: u32::from(record.home_slow),
            stroke: self.motor.convert(n, record.home_stroke, true)?,
            pause: record.home_pause,
            position,
            clearance: rest.wrapping_sub(position),
        };
        Ok(())
    }

    /// Home, Home?.
    ///
    /// # Errors
    /// F20, F01, F10, F11.
    pub fn home(&mut self, code: u8) -> Result<bool, Fault> {
        let first = self.program.effect.phase == 0;
        if first {
            self.program.effect.phase = BEGIN;
        }
        home(self, code, first)
    }

    /// Whether the effect under way looks for a switch or a probe at this instant.
    pub fn seeks(&self) -> bool {
        match self.program.effect.code {
            first::Home..=last::HomeQuery => matches!(self.program.effect.phase, FAST | SLOW),
            first::Probe => self.program.effect.phase == 1,
            _ => false,
        }
    }
}

impl<C: Chip> Homes for Controller<C> {
    fn plan(&mut self, n: u8) -> Result<(), Fault> {
        self.program.effect.n = n;
        if self.motor.axis(n).flags & AxisRecord::PRESENT == 0 {
            return Err(Fault::ValueRange);
        }
        self.plan_home(n)
    }
    fn axis(&self) -> Axis {
        Axis::new(self.program.effect.n)
    }
    // The plan was made of an axis that is there.
    fn is_there(&self, _: Axis) -> bool {
        true
    }
    fn take_pace(&mut self, _: Axis) {}
    fn is_by_command(&self) -> bool {
        false
    }
    fn command_speed(&mut self) -> i32 {
        0
    }
    fn profile_speed(&mut self, _: Axis) -> i32 {
        0
    }
    fn bound_speed(&mut self, _: i32) {}
    fn slow_down(&mut self, _: Axis) {}
    // What moves when the run begins is sent on from where it is.
    fn moving(&self) -> u8 {
        if self.program.effect.phase == BEGIN {
            0
        } else {
            self.motor.moving() & 1 << self.program.effect.n
        }
    }
    fn phase(&self) -> u8 {
        self.program.effect.phase
    }
    fn set_phase(&mut self, phase: u8) {
        self.program.effect.phase = phase;
    }
    fn forget_home(&mut self, axis: Axis) {
        self.motor.homed &= !axis.bit();
    }
    fn set_home(&mut self, axis: Axis) {
        self.motor.homed |= axis.bit();
    }
    fn forget_place(&mut self, axis: Axis) {
        self.motor.placed &= !axis.bit();
    }
    fn set_offset(&mut self, axis: Axis, um: i32) {
        self.motor.offset[axis.i()] = um;
    }
    #[inline(never)]
    fn is_closed(&self) -> bool {
        self.unfiltered(self.seek.plan.input) == self.seek.plan.closed
    }
    fn way(&self, _: Axis) -> u8 {
        if self.seek.plan.positive { AxisRecord::HOME_POSITIVE as u8 } else { 0 }
    }
    fn stroke(&self, _: Axis) -> i32 {
        self.seek.plan.stroke
    }
    fn place(&self, _: Axis) -> i32 {
        self.seek.plan.position
    }
    // The plan's has its sign already.
    fn clearance(&self, _: Axis) -> i32 {
        if self.seek.plan.positive {
            self.seek.plan.clearance.wrapping_neg()
        } else {
            self.seek.plan.clearance
        }
    }
    fn pause(&self, _: Axis) -> u16 {
        self.seek.plan.pause
    }
    fn planned(&self, _: Axis, steps: i32) -> i32 {
        steps
    }
    fn time(&self) -> i32 {
        self.program.effect.left
    }
    fn set_time(&mut self, ms: i32) {
        self.program.effect.left = ms;
    }
    fn position(&self, axis: Axis) -> i32 {
        self.motor.position(axis.n())
    }
    #[inline(never)]
    fn seek_to(&mut self, axis: Axis, steps: i32) -> Progress {
        let mut pace = self.seek.plan.pace;
        if self.program.effect.phase == SLOW {
            pace = pace.with_steps(self.seek.plan.slow);
        }
        self.motor.go(axis.n(), steps, pace, true);
        Ok(false)
    }
    fn rest_at(&mut self, axis: Axis, steps: i32) -> Progress {
        self.motor.settle(axis.n(), steps);
        self.seek_to(axis, steps)
    }
    fn brake(&mut self, axis: Axis) {
        self.motor.stop(axis.bit());
    }
    fn catch(&mut self, axis: Axis) {
        self.motor.hit(axis.n(), self.position(axis));
    }
    fn set_place(&mut self, axis: Axis) {
        self.motor.place(axis.n(), self.seek.plan.position);
    }
    fn settle_here(&mut self, axis: Axis) {
        self.motor.settle_here(axis.n());
    }
    fn asks(&self) -> bool {
        self.program.effect.code == first::HomeQuery
    }
}
