//! What the controller knows of its axes: commanded places, work offsets, reference.
//!
//! Each axis keeps its commanded machine position in um and rounds it to steps once, half away
//! from zero; after a move in Steps, a stop, a probe or Home the um value is LENGTH of the steps
//! (language.md, Machine).

use lang::axis::Axis;
use lang::effect::{Coord, Dist, Frame};
use lang::fault::Fault;
use lang::profile::Profile;
use lang::record::{AxisRecord, MachineRecord};

use crate::sim::trace::PerAxis;

#[derive(Clone, Copy, Debug, Default)]
struct State {
    present: bool,
    record: AxisRecord,
    /// Commanded machine position, um.
    um: i32,
    /// The same in steps.
    steps: i32,
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

/// A place that a move asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Machine position, um.
    pub um: i32,
    /// The same in steps.
    pub steps: i32,
}

/// See the module.
#[derive(Debug)]
pub struct Axes {
    states: [State; 3],
    require_homing: bool,
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
    /// Every axis at 0, nowhere referenced.
    pub fn new(profile: &Profile, record: &MachineRecord) -> Axes {
        let mut states = [State::default(); 3];
        for axis in Axis::ALL {
            let state = &mut states[axis.index()];
            state.present = profile.axis(axis).is_some();
            state.record = record.axes[axis.index()];
        }
        Axes { states, require_homing: profile.require_homing }
    }

    /// Values of the axes that the machine has.
    pub fn named(&self, values: [i32; 3]) -> PerAxis {
        PerAxis::new([0, 1, 2].map(|i: usize| self.states[i].present.then_some(values[i])))
    }

    fn state(&self, axis: Axis) -> &State {
        &self.states[axis.index()]
    }

    fn state_mut(&mut self, axis: Axis) -> &mut State {
        &mut self.states[axis.index()]
    }

    /// Whether the machine has the axis.
    pub fn is_present(&self, axis: Axis) -> bool {
        self.state(axis).present
    }

    /// Commanded machine position, steps.
    pub fn steps(&self, axis: Axis) -> i32 {
        self.state(axis).steps
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

    /// The place that a word asks for, counted from `from` when it is relative.
    ///
    /// # Errors
    /// F20 for an axis that the machine lacks, F07 for an absolute word of an axis that must be
    /// homed first, F01.
    pub fn resolve(&self, axis: Axis, word: Coord, from: Place) -> Result<Place, Fault> {
        let state = self.state(axis);
        if !state.present {
            return Err(Fault::ValueRange);
        }
        if word.frame != Frame::Relative && self.require_homing && !state.referenced {
            return Err(Fault::NotHomed);
        }
        let sum = |a: i32, b: i32| a.checked_add(b).ok_or(Fault::Overflow);
        match (word.value, word.frame) {
            (Dist::Um(value), frame) => {
                let um = match frame {
                    Frame::Work => sum(value, state.offset)?,
                    Frame::Machine => value,
                    Frame::Relative => sum(from.um, value)?,
                };
                Ok(Place { um, steps: self.to_steps(axis, um)? })
            }
            (Dist::Steps(value), frame) => {
                let steps = match frame {
                    Frame::Relative => sum(from.steps, value)?,
                    Frame::Work | Frame::Machine => value,
                };
                Ok(Place { um: self.length(axis, steps)?, steps })
            }
        }
    }

    /// The commanded place.
    pub fn place(&self, axis: Axis) -> Place {
        Place { um: self.state(axis).um, steps: self.state(axis).steps }
    }

    /// The axis is commanded to `place`.
    pub fn command(&mut self, axis: Axis, place: Place) {
        let state = self.state_mut(axis);
        state.um = place.um;
        state.steps = place.steps;
    }

    /// The axis rests at `steps`, wherever it was commanded.
    pub fn adopt(&mut self, axis: Axis, steps: i32) {
        let um = self.length(axis, steps).unwrap_or(self.state(axis).um);
        self.command(axis, Place { um, steps });
        self.state_mut(axis).running = false;
    }

    /// Soft limits.
    ///
    /// # Errors
    /// F05 for a place outside the travel of a homed axis.
    pub fn check_travel(&self, axis: Axis, um: i32) -> Result<(), Fault> {
        let state = self.state(axis);
        if state.homed && !(state.record.min..=state.record.max).contains(&um) {
            return Err(Fault::SoftLimit);
        }
        Ok(())
    }

    /// The soft limit toward which an axis runs, steps; `None` while it is not homed.
    pub fn travel_end(&self, axis: Axis, negative: bool) -> Option<i32> {
        let state = self.state(axis);
        let um = if negative { state.record.min } else { state.record.max };
        state.homed.then(|| self.to_steps(axis, um).ok()).flatten()
    }

    /// The present place becomes the work position `value`, um.
    ///
    /// # Errors
    /// F01, F20 for an axis that the machine lacks.
    pub fn set_work(&mut self, axis: Axis, value: i32) -> Result<(), Fault> {
        let state = self.state_mut(axis);
        if !state.present {
            return Err(Fault::ValueRange);
        }
        state.offset = state.um.checked_sub(value).ok_or(Fault::Overflow)?;
        state.referenced = true;
        Ok(())
    }

    /// Forgets the work offset.
    pub fn clear_offset(&mut self, axis: Axis) {
        self.state_mut(axis).offset = 0;
    }

    /// Work position, um: at `steps`, or the commanded one.
    ///
    /// # Errors
    /// F01.
    pub fn work_at(&self, axis: Axis, steps: Option<i32>) -> Result<i32, Fault> {
        let um = match steps {
            Some(steps) => self.length(axis, steps)?,
            None => self.state(axis).um,
        };
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
        self.work_at(axis, Some(self.state(axis).probed))
    }
}
