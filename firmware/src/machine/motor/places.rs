//! Commanded places of the axes: where targets lie, what the travel allows.

use super::{AXES, Motor, clock};
use crate::machine::chip::Chip;
use crate::motion::Single;
use crate::rules::Axis;
use crate::rules::coords::{self, Settles, Stands, Targets};
use lang::fault::Fault;
use lang::place::{self, Place, Target};
use lang::record::{AxisRecord, MachineRecord};

impl<C: Chip> Stands for Motor<C> {
    fn position(&self, axis: Axis) -> i32 {
        self.actual[axis.i()]
    }
    fn steps(&self, axis: Axis) -> i32 {
        self.steps[axis.i()]
    }
    fn offset(&self, axis: Axis) -> i32 {
        self.offset[axis.i()]
    }
    #[inline(always)]
    fn to_steps(&self, axis: Axis, um: i32) -> Option<i32> {
        self.convert(axis.n(), um, true).ok()
    }
    #[inline(always)]
    fn to_um(&self, axis: Axis, steps: i32) -> Option<i32> {
        self.convert(axis.n(), steps, false).ok()
    }
}

impl<C: Chip> Settles for Motor<C> {
    fn set_um(&mut self, axis: Axis, um: i32) {
        self.um[axis.i()] = um;
    }
    fn set_steps(&mut self, axis: Axis, steps: i32) {
        self.steps[axis.i()] = steps;
    }
}

/// An axis with a target, and where that lies.
struct Aimed<'a, C: Chip> {
    motor: &'a Motor<C>,
    target: Target,
    place: Place,
}

impl<C: Chip> Stands for Aimed<'_, C> {
    fn position(&self, axis: Axis) -> i32 {
        Stands::position(self.motor, axis)
    }
    fn steps(&self, axis: Axis) -> i32 {
        self.motor.steps(axis)
    }
    fn offset(&self, axis: Axis) -> i32 {
        self.motor.offset(axis)
    }
    fn to_steps(&self, axis: Axis, um: i32) -> Option<i32> {
        self.motor.to_steps(axis, um)
    }
    fn to_um(&self, axis: Axis, steps: i32) -> Option<i32> {
        self.motor.to_um(axis, steps)
    }
}

impl<C: Chip> Targets for Aimed<'_, C> {
    fn is_there(&self, n: Axis) -> bool {
        self.motor.axis(n.n()).flags & AxisRecord::PRESENT != 0
    }
    fn in_steps(&self) -> bool {
        self.target.in_steps
    }
    fn is_relative(&self) -> bool {
        self.target.frame == Target::RELATIVE
    }
    fn is_machine(&self) -> bool {
        self.target.frame == Target::MACHINE
    }
    fn um(&self, axis: Axis) -> i32 {
        self.motor.um[axis.i()]
    }
    fn set_new_um(&mut self, _: Axis, um: i32) {
        self.place.um = um;
    }
    fn set_new_steps(&mut self, _: Axis, steps: i32) {
        self.place.steps = steps;
    }
    fn is_too_far(&self, axis: Axis) -> bool {
        place::way(self.steps(axis), self.place.steps).is_err()
    }
    fn is_homed(&self, axis: Axis) -> bool {
        self.motor.homed & axis.bit() != 0
    }
    fn is_above(&self, n: Axis) -> bool {
        self.place.um > self.motor.axis(n.n()).max
    }
    fn is_below(&self, n: Axis) -> bool {
        self.place.um < self.motor.axis(n.n()).min
    }
    fn is_placed(&self, axis: Axis) -> bool {
        self.motor.placed & axis.bit() != 0
    }
    fn wants_homing(&self) -> bool {
        self.motor.machine.flags & MachineRecord::REQUIRE_HOMING != 0
    }
}

impl<C: Chip> Motor<C> {
    /// The resting axis stands at `steps`. After so long a way by MoveSpeed that this does not fit into um, its machine
    /// place begins anew at 0, without a work offset: no axis that has homed comes so far.
    pub fn place(&mut self, n: u8, mut steps: i32) {
        let i = usize::from(n);
        if self.convert(n, steps, false).is_err() {
            steps = 0;
            self.offset[i] = 0;
        }
        self.actual[i] = steps;
        self.chip.set_count(i, steps);
        self.single[i] = Single::new(steps, const { clock::<C>() });
        self.settle(n, steps);
    }

    /// The commanded place is that of `steps`.
    pub fn settle(&mut self, n: u8, steps: i32) {
        coords::settle(self, Axis::new(n), steps);
    }

    /// The commanded place is where the axis is.
    #[inline(never)]
    pub fn settle_here(&mut self, n: u8) {
        let here = self.position(n);
        if self.convert(n, here, false).is_err() && !self.moves(n) {
            return self.place(n, here);
        }
        coords::settle_here(self, Axis::new(n));
    }

    /// Where a target lies.
    ///
    /// # Errors
    /// F01, F05, F07, F20 for an axis that the machine lacks.
    pub fn aim(&self, n: u8, target: Target) -> Result<Place, Fault> {
        if n >= AXES {
            return Err(Fault::ValueRange);
        }
        let mut aimed = Aimed { motor: self, target, place: Place::default() };
        coords::aim(&mut aimed, Axis::new(n), target.value)?;
        Ok(aimed.place)
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
        let um = if negative { self.axis(n).min } else { self.axis(n).max };
        self.convert(n, um, true).ok()
    }

    /// Whether a command may send an axis to a place, steps, homed or not.
    ///
    /// # Errors
    /// F01, F05.
    pub fn allows(&self, axis: Axis, steps: i32) -> Result<(), Fault> {
        place::way(self.position(axis.n()), steps)?;
        let target = Target { value: steps, in_steps: true, frame: Target::RELATIVE };
        coords::aim_place(&mut Aimed { motor: self, target, place: Place::default() }, axis, steps)
    }

    /// Where the axes are at this instant, steps.
    pub fn places(&self) -> [i32; 3] {
        self.actual
    }

    /// Where an axis is at this instant, steps.
    #[inline(never)]
    pub fn position(&self, n: u8) -> i32 {
        self.actual[usize::from(n)]
    }
}
