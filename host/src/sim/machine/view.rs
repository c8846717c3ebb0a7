//! The machine as a debugger shows it.

use lang::axis::Axis;

use super::Machine;
use crate::sim::view::{AxisView, View};

impl Machine {
    /// TIMER: ms since the program began, without the pauses, modulo 2^32 as the boards count.
    pub(super) fn timer(&self) -> i32 {
        let us = self.run_clock() - self.pause.program_us;
        ((us / 1_000) as u32).cast_signed()
    }

    /// What can be seen of it now.
    pub fn view(&self) -> View {
        let steps = self.motion.positions(self.clock.now());
        let axis = |axis: Axis| AxisView {
            axis,
            um: self.axes.work_at(axis, steps[axis.index()]).unwrap_or_default(),
            steps: steps[axis.index()],
            moving: self.motion.is_moving(axis),
            homed: self.axes.is_homed(axis),
        };
        let most = 16;
        View {
            timer: Some(self.timer()),
            inputs: (1..=most).filter_map(|n| Some((n, self.inputs.read(n).ok()?))).collect(),
            outputs: (1..=most).filter_map(|n| Some((n, self.outputs.read(n).ok()?))).collect(),
            aouts: Vec::new(),
            axes: self.profile.axes().map(|(letter, _)| axis(letter)).collect(),
        }
    }
}
