//! Where a word of a move leads; the rule itself is `aim` in `firmware/src/rules/coords.rs`.

use crate::effect::{Coord, Dist, Frame};
use crate::fault::Fault;

/// Where an axis stands, or is to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Machine position, um.
    pub um: i32,
    /// The same in steps.
    pub steps: i32,
}

/// A word as a statement's operands tell it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Target {
    /// um or steps.
    pub value: i32,
    /// `value` is in steps.
    pub in_steps: bool,
    /// What it counts from: [`Target::WORK`], [`Target::MACHINE`] or [`Target::RELATIVE`].
    pub frame: u8,
}

impl Target {
    /// [`Target::frame`]: [`Frame::Work`].
    pub const WORK: u8 = Frame::Work as u8;
    /// [`Target::frame`]: [`Frame::Machine`].
    pub const MACHINE: u8 = Frame::Machine as u8;
    /// [`Target::frame`]: [`Frame::Relative`].
    pub const RELATIVE: u8 = Frame::Relative as u8;
}

impl From<Coord> for Target {
    fn from(word: Coord) -> Target {
        let (value, in_steps) = match word.value {
            Dist::Um(value) => (value, false),
            Dist::Steps(value) => (value, true),
        };
        Target { value, in_steps, frame: word.frame as u8 }
    }
}

/// Whether an axis that has not homed is so far away that SetPos lets its machine place begin anew at 0, on parts that
/// do so: 2^30 um, which is 1073 m, or 2^30 steps. Otherwise a feed that only goes on would end where 32 bits do.
pub const fn is_far(um: i32, steps: i32) -> bool {
    um.unsigned_abs() >= 1 << 30 || steps.unsigned_abs() >= 1 << 30
}

/// Steps from one place to another.
///
/// # Errors
/// F01 where they do not fit: a machine never moves to a wrapped position.
pub fn way(from: i32, to: i32) -> Result<i32, Fault> {
    to.checked_sub(from).ok_or(Fault::Overflow)
}
