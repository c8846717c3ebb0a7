//! What the controller knows of its axes: commanded places, work offsets, reference.
//!
//! Each axis keeps its commanded machine position in um and rounds it to steps once, half away
//! from zero; after a move in Steps, a stop, a probe or Home the um value is LENGTH of the steps
//! (lang/README.md, The machine).

use firmware::rules::Axis as Nth;
use firmware::rules::coords::{self, Stands, Targets};
use lang::axis::Axis;
use lang::effect::Coord;
use lang::fault::Fault;
use lang::place::{self, Place, Target};
use lang::profile::Profile;
use lang::record::{AxisRecord, MachineRecord};

use crate::sim::trace::PerAxis;

#[derive(Clone, Copy, Debug, Default)]
struct State {
    record: AxisRecord,
    /// The commanded place.
    place: Place,
    /// Work position = machine position - offset, um.
    offset: i32,
    homed: bool,
    /// Home or SetPos since power-up.
    referenced: bool,
    /// Runs by MoveSpeed.
    running: bool,
    probed: i32,
    probe_ok: bool,
}

/// See the module.
#[derive(Debug)]
pub struct Axes {
    states: [State; 3],
    require_homing: bool,
    /// SetPos lets the machine place of an axis that is far away begin anew ([`place::is_far`]).
    renews: bool,
}

/// An axis with a target, which counts from `from` when it is relative, and where that lies.
struct Aimed<'a> {
    axes: &'a Axes,
    axis: Axis,
    from: Place,
    target: Target,
    place: Place,
}

impl Aimed<'_> {
    fn state(&self) -> &State {
        self.axes.state(self.axis)
    }
}

impl Stands for Aimed<'_> {
    fn position(&self, _: Nth) -> i32 {
        self.from.steps
    }
    fn steps(&self, _: Nth) -> i32 {
        self.from.steps
    }
    fn offset(&self, _: Nth) -> i32 {
        self.state().offset
    }
    fn to_steps(&self, _: Nth, um: i32) -> Option<i32> {
        self.axes.to_steps(self.axis, um).ok()
    }
    fn to_um(&self, _: Nth, steps: i32) -> Option<i32> {
        self.axes.length(self.axis, steps).ok()
    }
}

impl Targets for Aimed<'_> {
    fn is_there(&self, _: Nth) -> bool {
        self.axes.is_present(self.axis)
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
    fn um(&self, _: Nth) -> i32 {
        self.from.um
    }
    fn set_new_um(&mut self, _: Nth, um: i32) {
        self.place.um = um;
    }
    fn set_new_steps(&mut self, _: Nth, steps: i32) {
        self.place.steps = steps;
    }
    fn is_too_far(&self, _: Nth) -> bool {
        place::way(self.from.steps, self.place.steps).is_err()
    }
    fn is_homed(&self, _: Nth) -> bool {
        self.state().homed
    }
    fn is_above(&self, _: Nth) -> bool {
        self.place.um > self.state().record.max
    }
    fn is_below(&self, _: Nth) -> bool {
        self.place.um < self.state().record.min
    }
    fn is_placed(&self, _: Nth) -> bool {
        self.state().referenced
    }
    fn wants_homing(&self) -> bool {
        self.axes.require_homing
    }
}

/// `value * times / over`, half away from zero.
///
/// # Errors
/// F01 when the result does not fit.
pub fn scaled(value: i32, times: u16, over: u16) -> Result<i32, Fault> {
    let twice = 2 * i64::from(value) * i64::from(times);
    let over = i64::from(over.max(1));
    let rounded = (twice + twice.signum() * over) / (2 * over);
    i32::try_from(rounded).map_err(|_| Fault::Overflow)
}

impl Axes {
    /// Every axis at 0, nowhere referenced; `renews`: of a part on which SetPos lets places begin anew.
    pub fn new(profile: &Profile, record: &MachineRecord, renews: bool) -> Axes {
        let mut states = [State::default(); 3];
        for axis in Axis::ALL {
            states[axis.index()].record = record.axes[axis.index()];
        }
        Axes { states, require_homing: profile.require_homing, renews }
    }

    /// Values of the axes that the machine has.
    pub fn named(&self, values: [i32; 3]) -> PerAxis {
        PerAxis::new(Axis::ALL.map(|axis| self.is_present(axis).then_some(values[axis.index()])))
    }

    fn state(&self, axis: Axis) -> &State {
        &self.states[axis.index()]
    }

    fn state_mut(&mut self, axis: Axis) -> &mut State {
        &mut self.states[axis.index()]
    }

    /// Whether the machine has the axis.
    pub fn is_present(&self, axis: Axis) -> bool {
        self.state(axis).record.flags & AxisRecord::PRESENT != 0
    }

    /// Commanded machine position, steps.
    pub fn steps(&self, axis: Axis) -> i32 {
        self.state(axis).place.steps
    }

    /// Whether the axis is homed: soft limits hold.
    pub fn is_homed(&self, axis: Axis) -> bool {
        self.state(axis).homed
    }

    /// Sets whether the axis is homed; homing is a reference, too.
    pub fn set_homed(&mut self, axis: Axis, homed: bool) {
        let state = self.state_mut(axis);
        state.homed = homed;
        state.referenced = homed;
    }

    /// Whether the axis runs by MoveSpeed.
    pub fn is_running(&self, axis: Axis) -> bool {
        self.state(axis).running
    }

    /// Sets whether the axis runs by MoveSpeed.
    pub fn set_running(&mut self, axis: Axis, running: bool) {
        self.state_mut(axis).running = running;
    }

    /// Steps to um.
    ///
    /// # Errors
    /// F01.
    pub fn length(&self, axis: Axis, steps: i32) -> Result<i32, Fault> {
        let record = &self.state(axis).record;
        scaled(steps, record.um, record.steps)
    }

    /// um to steps.
    ///
    /// # Errors
    /// F01.
    pub fn to_steps(&self, axis: Axis, um: i32) -> Result<i32, Fault> {
        let record = &self.state(axis).record;
        scaled(um, record.steps, record.um)
    }

    /// The place that a word asks for, counted from `from` when it is relative, within the travel of
    /// a homed axis.
    ///
    /// # Errors
    /// Those of [`coords::aim`].
    pub fn aim(&self, axis: Axis, word: Coord, from: Place) -> Result<Place, Fault> {
        let target = Target::from(word);
        let mut aimed = Aimed { axes: self, axis, from, target, place: Place::default() };
        coords::aim(&mut aimed, Nth::new(axis.index() as u8), target.value)?;
        Ok(aimed.place)
    }

    /// The commanded place.
    pub fn place(&self, axis: Axis) -> Place {
        self.state(axis).place
    }

    /// The axis is commanded to `place`.
    pub fn command(&mut self, axis: Axis, place: Place) {
        self.state_mut(axis).place = place;
    }

    /// The axis rests at `steps`, wherever it was commanded.
    pub fn adopt(&mut self, axis: Axis, steps: i32) {
        let um = self.length(axis, steps).unwrap_or(self.state(axis).place.um);
        self.command(axis, Place { um, steps });
        self.state_mut(axis).running = false;
    }

    /// The soft limit toward which an axis runs, steps; `None` while it is not homed.
    pub fn travel_end(&self, axis: Axis, negative: bool) -> Option<i32> {
        let state = self.state(axis);
        let um = if negative { state.record.min } else { state.record.max };
        state.homed.then(|| self.to_steps(axis, um).ok()).flatten()
    }

    /// The present place becomes the work position `value`, um. The machine place of an axis that has not homed begins
    /// anew at 0 where it is far away ([`place::is_far`]).
    ///
    /// # Errors
    /// F01, F20 for an axis that the machine lacks.
    pub fn set_work(&mut self, axis: Axis, value: i32) -> Result<(), Fault> {
        if !self.is_present(axis) {
            return Err(Fault::ValueRange);
        }
        let renews = self.renews;
        let state = self.state_mut(axis);
        let Place { um, steps } = state.place;
        state.offset = um.checked_sub(value).ok_or(Fault::Overflow)?;
        state.referenced = true;
        if renews && !state.homed && place::is_far(um, steps) {
            state.offset = state.offset.wrapping_sub(um);
            state.place = Place::default();
        }
        Ok(())
    }

    /// A run begins where the axis is: without a work offset, and what SetPos told holds no more.
    pub fn begin_run(&mut self, axis: Axis) {
        let state = self.state_mut(axis);
        state.offset = 0;
        state.referenced = state.homed;
    }

    /// Forgets the work offset.
    pub fn clear_offset(&mut self, axis: Axis) {
        self.state_mut(axis).offset = 0;
    }

    /// Work position at `steps`, um.
    ///
    /// # Errors
    /// F01.
    pub fn work_at(&self, axis: Axis, steps: i32) -> Result<i32, Fault> {
        let um = self.length(axis, steps)?;
        um.checked_sub(self.state(axis).offset).ok_or(Fault::Overflow)
    }

    /// A probe was caught at `steps`, or missed.
    pub fn set_probed(&mut self, axis: Axis, steps: Option<i32>) {
        let state = self.state_mut(axis);
        state.probe_ok = steps.is_some();
        if let Some(steps) = steps {
            state.probed = steps;
        }
    }

    /// `PROBEOK`.
    pub fn probe_ok(&self, axis: Axis) -> bool {
        self.state(axis).probe_ok
    }

    /// `PROBEDST`.
    pub fn probed_steps(&self, axis: Axis) -> i32 {
        self.state(axis).probed
    }

    /// `PROBED`.
    ///
    /// # Errors
    /// F01.
    pub fn probed_work(&self, axis: Axis) -> Result<i32, Fault> {
        self.work_at(axis, self.state(axis).probed)
    }
}
