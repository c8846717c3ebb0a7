//! The machine as a debugger shows it.

use lang::axis::Axis;

use super::Machine;

/// An axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AxisView {
    /// Which.
    pub axis: Axis,
    /// Work position, um.
    pub um: i32,
    /// Machine position, steps.
    pub steps: i32,
    /// Whether it moves.
    pub moving: bool,
    /// Whether it knows its reference.
    pub homed: bool,
}

/// What can be seen of a machine at an instant.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct View {
    /// TIMER, ms; none of a board, which has no register for it.
    pub timer: Option<i32>,
    /// Inputs: number and state.
    pub inputs: Vec<(i32, bool)>,
    /// Outputs: number and state.
    pub outputs: Vec<(i32, bool)>,
    /// Axes that there are.
    pub axes: Vec<AxisView>,
}

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
            axes: self.profile.axes().map(|(letter, _)| axis(letter)).collect(),
        }
    }
}
