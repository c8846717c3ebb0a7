//! Positions of the axes and the seam to the step engine.

use crate::vm::{axis, convert, machine};
use lang::fault::Fault;
use lang::record::{AxisRecord, MachineRecord};

/// Axes.
pub const AXES: u8 = 3;

/// Where the axes are and what they do.
pub struct Motor {
    /// Commanded machine positions, um.
    pub um: [i32; 3],
    /// Commanded machine positions, steps.
    pub steps: [i32; 3],
    /// Work offsets: machine position less work position, um.
    pub offset: [i32; 3],
    /// Machine positions where the probe answered, steps.
    pub probed: [i32; 3],
    /// Bit per axis: homed.
    pub homed: u8,
    /// Bit per axis: the last probe answered.
    pub probe_ok: u8,
}

/// A target as a statement gives it.
#[derive(Clone, Copy)]
pub struct Target {
    /// um or steps.
    pub value: i32,
    /// `value` is in steps.
    pub in_steps: bool,
    /// 0 work, 1 machine, 2 relative.
    pub frame: u8,
}

impl Motor {
    /// Everything at 0.
    pub const fn new() -> Motor {
        Motor { um: [0; 3], steps: [0; 3], offset: [0; 3], probed: [0; 3], homed: 0, probe_ok: 0 }
    }

    /// A new run: work offsets are 0, commanded places are where the axes stand.
    pub fn begin(&mut self) {
        self.offset = [0; 3];
        let mut n = 0;
        while n < AXES {
            self.settle(n);
            n += 1;
        }
    }

    /// The commanded place in um follows from that in steps.
    pub fn settle(&mut self, n: u8) {
        if axis(n).um != 0 {
            self.um[usize::from(n)] = convert(n, self.steps[usize::from(n)], false).unwrap_or(0);
        }
    }

    /// Takes a target: tests it and makes it the commanded place. Returns the steps to go.
    ///
    /// # Errors
    /// F01, F05, F07, F20 for an axis that the machine lacks.
    pub fn command(&mut self, n: u8, target: Target) -> Result<i32, Fault> {
        let i = usize::from(n);
        let record = axis(n);
        if n >= AXES || record.flags & AxisRecord::PRESENT == 0 {
            return Err(Fault::ValueRange);
        }
        let bit = 1 << n;
        let steps;
        let um;
        if target.in_steps {
            steps = if target.frame == 2 {
                self.steps[i].checked_add(target.value).ok_or(Fault::Overflow)?
            } else {
                target.value
            };
            um = convert(n, steps, false)?;
        } else {
            let base = match target.frame {
                0 => self.offset[i],
                1 => 0,
                _ => self.um[i],
            };
            um = base.checked_add(target.value).ok_or(Fault::Overflow)?;
            steps = convert(n, um, true)?;
        }
        if self.homed & bit != 0 {
            if um < record.min || um > record.max {
                return Err(Fault::SoftLimit);
            }
        } else if target.frame != 2 && machine().flags & MachineRecord::REQUIRE_HOMING != 0 {
            return Err(Fault::NotHomed);
        }
        let before = self.steps[i];
        self.um[i] = um;
        self.steps[i] = steps;
        Ok(steps.wrapping_sub(before))
    }

    /// Bit per axis that moves.
    pub fn moving(&self) -> u8 {
        0
    }

    /// Where an axis is at this instant, steps.
    pub fn position(&self, n: u8) -> i32 {
        self.steps[usize::from(n)]
    }

    /// Brakes everything to a pause, or goes on.
    pub fn pause(&mut self, _on: bool) {}

    /// Ramps everything down and forgets the rest.
    pub fn stop(&mut self, _axes: u8) {}

    /// Steps cease at once; positions are unknown.
    pub fn halt(&mut self) {
        self.homed = 0;
    }
}
