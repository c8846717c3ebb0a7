//! The machine as a debugger shows it.

use lang::axis::Axis;

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
    /// Analog outputs: number and value, mV or steps of a share as the profile says.
    pub aouts: Vec<(i32, i32)>,
    /// Axes that there are.
    pub axes: Vec<AxisView>,
}
