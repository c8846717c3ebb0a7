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
    /// Time since the run began, us.
    pub us: u64,
    /// Inputs: number and state.
    pub inputs: Vec<(i32, bool)>,
    /// Outputs: number and state.
    pub outputs: Vec<(i32, bool)>,
    /// Axes that there are.
    pub axes: Vec<AxisView>,
}

impl Machine {
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
            us: self.clock.now(),
            inputs: (1..=most).filter_map(|n| Some((n, self.inputs.read(n).ok()?))).collect(),
            outputs: (1..=most).filter_map(|n| Some((n, self.outputs.read(n).ok()?))).collect(),
            axes: self.profile.axes().map(|(letter, _)| axis(letter)).collect(),
        }
    }
}
