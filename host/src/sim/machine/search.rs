//! The move to an input that is under way.

use lang::axis::Axis;
use lang::effect::Sensor;

/// See the module.
#[derive(Debug, Default)]
pub struct Search {
    /// What it looks for; `None` between such moves.
    pub seek: Option<Seek>,
    /// The axis that is homing: its switch is no limit switch.
    pub homing: Option<Axis>,
}

/// What a move looks for.
#[derive(Clone, Copy, Debug)]
pub struct Seek {
    /// What moves.
    pub axis: Axis,
    /// What ends the move.
    pub target: Target,
    /// Where it answered, steps.
    pub caught: Option<i32>,
}

/// What ends such a move.
#[derive(Clone, Copy, Debug)]
pub enum Target {
    /// The axis's reference switch takes a state.
    Reference(bool),
    /// A probe answers.
    Sensor(Sensor),
}
