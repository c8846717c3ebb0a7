//! Commanded places of the axes: where targets lie, what the travel allows.

use super::{AXES, CLOCK, Motor};
use crate::step;
use crate::vm::{axis, convert, machine};
use firmware::motion::Single;
use lang::fault::Fault;
use lang::place::{self, Aimed, Place, Target};
use lang::record::{AxisRecord, MachineRecord};

/// An axis of the machine.
struct Standing<'a> {
    motor: &'a Motor,
    n: u8,
}

impl Aimed for Standing<'_> {
    fn record(&self) -> &AxisRecord {
        axis(self.n)
    }

    fn commanded(&self) -> Place {
        let i = usize::from(self.n);
        Place { um: self.motor.um[i], steps: self.motor.steps[i] }
    }

    fn offset(&self) -> i32 {
        self.motor.offset[usize::from(self.n)]
    }

    fn is_homed(&self) -> bool {
        self.motor.homed >> self.n & 1 != 0
    }

    fn is_lost(&self) -> bool {
        self.motor.placed >> self.n & 1 == 0 && machine().flags & MachineRecord::REQUIRE_HOMING != 0
    }

    fn convert(&self, value: i32, to_steps: bool) -> Result<i32, Fault> {
        convert(self.n, value, to_steps)
    }
}

impl Motor {
    /// The resting axis stands at `steps`.
    pub fn place(&mut self, n: u8, steps: i32) {
        let i = usize::from(n);
        self.actual[i] = steps;
        step::set_count(i, steps);
        self.single[i] = Single::new(steps, CLOCK);
        self.settle(n, steps);
    }

    /// The commanded place is that of `steps`.
    pub fn settle(&mut self, n: u8, steps: i32) {
        let i = usize::from(n);
        self.steps[i] = steps;
        if axis(n).steps != 0 {
            self.um[i] = convert(n, steps, false).unwrap_or(0);
        }
    }

    /// The commanded place is where the axis is.
    #[inline(never)]
    pub fn settle_here(&mut self, n: u8) {
        self.settle(n, self.actual[usize::from(n)]);
    }

    /// Where a target lies.
    ///
    /// # Errors
    /// F01, F05, F07, F20 for an axis that the machine lacks.
    pub fn aim(&self, n: u8, target: Target) -> Result<Place, Fault> {
        if n >= AXES {
            return Err(Fault::ValueRange);
        }
        place::aim(&Standing { motor: self, n }, target)
    }

    /// Makes a place the commanded one. Returns the steps to go.
    pub fn command(&mut self, n: u8, place: Place) -> i32 {
        let i = usize::from(n);
        let before = self.steps[i];
        self.um[i] = place.um;
        self.steps[i] = place.steps;
        place.steps.wrapping_sub(before)
    }

    /// Where a homed axis must stop in a direction, steps.
    pub fn limit(&self, n: u8, negative: bool) -> Option<i32> {
        if self.homed >> n & 1 == 0 {
            return None;
        }
        let um = if negative { axis(n).min } else { axis(n).max };
        convert(n, um, true).ok()
    }

    /// Whether a place lies within the travel of a homed axis, and less than 2^31 steps away.
    pub fn within(&self, n: u8, steps: i32) -> bool {
        if place::way(self.position(n), steps).is_err() {
            return false;
        }
        let (low, high) = (self.limit(n, true), self.limit(n, false));
        low.is_none_or(|low| steps >= low) && high.is_none_or(|high| steps <= high)
    }

    /// Where an axis is at this instant, steps.
    #[inline(never)]
    pub fn position(&self, n: u8) -> i32 {
        self.actual[usize::from(n)]
    }
}
