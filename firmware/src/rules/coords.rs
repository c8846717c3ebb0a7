//! Positions of the axes: targets, the travel, work positions.
//!
//! The commanded position of an axis is where it was last sent, um and steps; [`aim`] makes it from a target.
#![cfg_attr(any(), micro(module = "rules.coords"))]

use super::Axis;
use lang::fault::Fault;

/// An axis as it stands.
pub trait Stands {
    /// Where it is at this instant, steps.
    #[cfg_attr(any(), micro(place = "ACTUAL", load = "DO here"))]
    fn position(&self, axis: Axis) -> i32;
    /// Its commanded place, steps.
    #[cfg_attr(any(), micro(place = "STEPS"))]
    fn steps(&self, axis: Axis) -> i32;
    /// Its work offset: machine position less work position, um.
    #[cfg_attr(any(), micro(place = "OFFSET"))]
    fn offset(&self, axis: Axis) -> i32;
    /// um as steps, half away from zero; nothing when they do not fit.
    #[cfg_attr(any(), micro(code = "DO to_steps", holds = "CARRY"))]
    fn to_steps(&self, axis: Axis, um: i32) -> Option<i32>;
    /// Steps as um, in the same way.
    #[cfg_attr(any(), micro(code = "DO to_um", holds = "CARRY"))]
    fn to_um(&self, axis: Axis, steps: i32) -> Option<i32>;
}

/// One whose commanded place is set.
pub trait Settles: Stands {
    /// The commanded place, um.
    #[cfg_attr(any(), micro(place = "UM"))]
    fn set_um(&mut self, axis: Axis, um: i32);
    /// The commanded place, steps.
    #[cfg_attr(any(), micro(place = "STEPS"))]
    fn set_steps(&mut self, axis: Axis, steps: i32);
}

/// One that has a target. Where the chips differ: an axis of the larger one may be told to go on before it has come to its
/// commanded place, so a way begins at that place, on the small one where the axis stands; and the travel of the
/// small one is below 2^31 um, so that differences say what lies outside of it.
pub trait Targets: Stands {
    /// The machine has the axis.
    #[cfg_attr(any(), micro(code = "DO axis_there", holds = "NOT_EQUAL"))]
    fn is_there(&self, axis: Axis) -> bool;
    /// The target is in steps, else in um.
    #[cfg_attr(any(), micro(any = "FRAME_OF, F_STEPS"))]
    fn in_steps(&self) -> bool;
    /// It counts from the commanded place.
    #[cfg_attr(any(), micro(any = "FRAME_OF, F_RELATIVE"))]
    fn is_relative(&self) -> bool;
    /// It is a machine position.
    #[cfg_attr(any(), micro(any = "FRAME_OF, F_MACHINE"))]
    fn is_machine(&self) -> bool;
    /// The commanded place, um.
    #[cfg_attr(any(), micro(place = "UM"))]
    fn um(&self, axis: Axis) -> i32;
    /// The new place, um.
    #[cfg_attr(any(), micro(place = "NEW_UM"))]
    fn set_new_um(&mut self, axis: Axis, um: i32);
    /// The new place, steps.
    #[cfg_attr(any(), micro(place = "NEW_STEPS"))]
    fn set_new_steps(&mut self, axis: Axis, steps: i32);
    /// The way to the new place is 2^31 steps or more: it would wrap.
    #[cfg_attr(
        any(),
        micro(code = "F load NEW_STEPS, AXIS; F sub ACTUAL, AXIS", holds = "OVERFLOW")
    )]
    fn is_too_far(&self, axis: Axis) -> bool;
    /// The axis has homed: its travel holds.
    #[cfg_attr(any(), micro(has = "HOMED"))]
    fn is_homed(&self, axis: Axis) -> bool;
    /// The new place lies above the travel.
    #[cfg_attr(any(), micro(code = "FR load A_MAX, LONG; F sub NEW_UM, AXIS", holds = "NEGATIVE"))]
    fn is_above(&self, axis: Axis) -> bool;
    /// It lies below.
    #[cfg_attr(any(), micro(code = "F load NEW_UM, AXIS; FR sub A_MIN, LONG", holds = "NEGATIVE"))]
    fn is_below(&self, axis: Axis) -> bool;
    /// Home or SetPos has said where the axis is.
    #[cfg_attr(any(), micro(has = "PLACED"))]
    fn is_placed(&self, axis: Axis) -> bool;
    /// The machine wants its axes homed first.
    #[cfg_attr(
        any(),
        micro(
            code = "F base STORED; FR word PROGRAM_MACHINE+MC_FLAGS, SHORT; TESTI MC_REQUIRE_HOMING",
            holds = "NOT_EQUAL"
        )
    )]
    fn wants_homing(&self) -> bool;
}

/// A new place becomes the commanded one: the small chip's way, whose axes rest at that time. The larger one counts the
/// steps to go from the commanded place before.
pub trait Commands: Settles {
    /// The new place, um.
    #[cfg_attr(any(), micro(place = "NEW_UM"))]
    fn new_um(&self, axis: Axis) -> i32;
    /// The new place, steps.
    #[cfg_attr(any(), micro(place = "NEW_STEPS"))]
    fn new_steps(&self, axis: Axis) -> i32;
    /// The line is joined to the next one of its course, which makes its way, too ([`lang::image::course`]).
    #[cfg_attr(any(), micro(any = "JOINS", when = "HAS_COURSES"))]
    fn is_joined(&self) -> bool;
    /// Of axes of joined lines this is one.
    #[cfg_attr(any(), micro(code = "UP JOINS"))]
    fn count_joined(&mut self);
}

/// Where the axis stands for the link: its work position in steps.
pub fn work_steps(m: &impl Stands, axis: Axis) -> i32 {
    m.position(axis).wrapping_sub(offset_steps(m, axis))
}

/// Where it is to stand.
pub fn target_steps(m: &impl Stands, axis: Axis) -> i32 {
    m.steps(axis).wrapping_sub(offset_steps(m, axis))
}

/// The work offset in steps, 0 when it does not fit.
pub fn offset_steps(m: &impl Stands, axis: Axis) -> i32 {
    m.to_steps(axis, m.offset(axis)).unwrap_or(0)
}

/// Where a target lies: it is the new place of the axis.
///
/// # Errors
/// F20 for an axis that the machine lacks; those of [`aim_place`].
pub fn aim(m: &mut impl Targets, axis: Axis, target: i32) -> Result<(), Fault> {
    if !m.is_there(axis) {
        return Err(Fault::ValueRange);
    }
    let mut place = target;
    if m.is_relative() {
        if m.in_steps() {
            place = place.checked_add(m.steps(axis)).ok_or(Fault::Overflow)?;
        } else {
            place = place.checked_add(m.um(axis)).ok_or(Fault::Overflow)?;
        }
    } else if !m.in_steps() && !m.is_machine() {
        place = place.checked_add(m.offset(axis)).ok_or(Fault::Overflow)?;
    }
    aim_place(m, axis, place)
}

/// The same for a machine position; a relative one is allowed to an axis that must be homed first.
///
/// # Errors
/// F01 when it does not fit or is 2^31 steps away, F05 outside the travel of an axis that has homed, F07 for one that
/// must be homed first and neither was nor was placed; in this order.
pub fn aim_place(m: &mut impl Targets, axis: Axis, place: i32) -> Result<(), Fault> {
    if m.in_steps() {
        m.set_new_steps(axis, place);
        m.set_new_um(axis, m.to_um(axis, place).ok_or(Fault::Overflow)?);
    } else {
        m.set_new_um(axis, place);
        m.set_new_steps(axis, m.to_steps(axis, place).ok_or(Fault::Overflow)?);
    }
    if m.is_too_far(axis) {
        return Err(Fault::Overflow);
    }
    if m.is_homed(axis) {
        if m.is_above(axis) || m.is_below(axis) {
            return Err(Fault::SoftLimit);
        }
        return Ok(());
    }
    if m.is_placed(axis) || m.is_relative() {
        return Ok(());
    }
    if m.wants_homing() {
        return Err(Fault::NotHomed);
    }
    Ok(())
}

/// Makes the new place the commanded one; whether there is no way to make: the axis stands there in steps, or the line is
/// joined to the next one, from whose place in um the steps are told.
#[cfg_attr(any(), micro(holds = "EQUAL"))]
pub fn command(m: &mut impl Commands, axis: Axis) -> bool {
    m.set_um(axis, m.new_um(axis));
    if m.is_joined() {
        m.count_joined();
        return true;
    }
    m.set_steps(axis, m.new_steps(axis));
    m.steps(axis).wrapping_sub(m.position(axis)) == 0
}

/// The commanded place is where the axis stands.
pub fn settle_here(m: &mut impl Settles, axis: Axis) {
    settle(m, axis, m.position(axis));
}

/// The commanded place is that of `steps`; um are 0 when they do not fit.
pub fn settle(m: &mut impl Settles, axis: Axis, steps: i32) {
    m.set_steps(axis, steps);
    m.set_um(axis, m.to_um(axis, steps).unwrap_or(0));
}
