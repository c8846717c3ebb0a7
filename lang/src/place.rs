//! Where a word of a move leads: one rule for the boards and the simulated machine.

use crate::effect::{Coord, Dist, Frame};
use crate::fault::Fault;
use crate::record::AxisRecord;

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

/// An axis as [`aim`] sees it.
pub trait Aimed {
    /// Its part of the profile.
    fn record(&self) -> &AxisRecord;
    /// Where it is commanded to: relative words count from there.
    fn commanded(&self) -> Place;
    /// Its work offset: machine position less work position, um.
    fn offset(&self) -> i32;
    /// Whether it is homed: soft limits hold.
    fn is_homed(&self) -> bool;
    /// Whether the machine wants it homed first, and neither Home nor SetPos has said where it is.
    fn is_lost(&self) -> bool;
    /// Turns um into steps (`to_steps`) or steps into um, half away from zero.
    ///
    /// # Errors
    /// F01.
    fn convert(&self, value: i32, to_steps: bool) -> Result<i32, Fault>;
}

/// Steps from one place to another.
///
/// # Errors
/// F01 where they do not fit: a machine never moves to a wrapped position.
pub fn way(from: i32, to: i32) -> Result<i32, Fault> {
    to.checked_sub(from).ok_or(Fault::Overflow)
}

/// Where `target` lies for an axis.
///
/// # Errors
/// F20 for an axis that the machine lacks, F01 also for one 2^31 steps away or more, F05 outside the travel of a homed axis, F07 for an
/// absolute word of one that must be homed first; in this order.
#[inline]
pub fn aim(axis: &impl Aimed, target: Target) -> Result<Place, Fault> {
    let record = axis.record();
    if record.flags & AxisRecord::PRESENT == 0 {
        return Err(Fault::ValueRange);
    }
    let relative = target.frame == Target::RELATIVE;
    let (um, steps);
    if target.in_steps {
        let base = if relative { axis.commanded().steps } else { 0 };
        steps = base.checked_add(target.value).ok_or(Fault::Overflow)?;
        um = axis.convert(steps, false)?;
    } else {
        let base = match target.frame {
            Target::WORK => axis.offset(),
            Target::MACHINE => 0,
            _ => axis.commanded().um,
        };
        um = base.checked_add(target.value).ok_or(Fault::Overflow)?;
        steps = axis.convert(um, true)?;
    }
    way(axis.commanded().steps, steps)?;
    if axis.is_homed() {
        if um < record.min || um > record.max {
            return Err(Fault::SoftLimit);
        }
    } else if axis.is_lost() && !relative {
        return Err(Fault::NotHomed);
    }
    Ok(Place { um, steps })
}
