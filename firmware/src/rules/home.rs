//! Homing, and the reference switches as limit switches.
//!
//! [`home`] runs on every chip: fast to the switch, rest, slowly off it, clearance. Its numbers differ: the larger
//! chip makes a plan in steps when homing begins and refuses what does not fit. The small one has no room for a plan and
//! takes numbers from the axis's record, or from that of command 106, whenever it needs them. [`Switches`] is the small
//! chip's only: the larger one homes an axis while others move, so it checks limits axis by axis, by watched pins.
#![cfg_attr(any(), micro(module = "rules.home", prefix = "home_"))]

use super::effects::Effects;
use super::{Axis, DONE, NOT_YET, Progress};
use lang::fault::Fault;
use lang::isa::Op;
use lang::record::AxisRecord;
use lang::wire::TraceKind;

/// See [`Op::Home`]; the axes follow, then [`HOME_QUERY`].
#[cfg_attr(any(), micro("OP_HOME"))]
const HOME: u8 = Op::Home as u8;
/// See [`Op::HomeQuery`].
#[cfg_attr(any(), micro("OP_HOME_QUERY"))]
const HOME_QUERY: u8 = Op::HomeQuery as u8;
/// See [`AxisRecord::HOME_POSITIVE`].
#[cfg_attr(any(), micro("AXIS_HOME_POSITIVE"))]
const HOME_POSITIVE: u8 = AxisRecord::HOME_POSITIVE as u8;

/// Phases: the run is planned.
pub const BEGIN: u8 = 1;
/// Braking.
pub const REST: u8 = 2;
/// Resting.
pub const PAUSE: u8 = 3;
/// Braking behind the switch.
pub const OPEN: u8 = 4;
/// To the clearance.
pub const CLEAR: u8 = 5;
/// Toward the switch; from here on the axis may move.
pub const FAST: u8 = 6;
/// Off it.
pub const SLOW: u8 = 7;

/// What a reference run looks at and does.
pub trait Homes: Effects {
    /// Plans the run of an axis by the profile: it is the effect's.
    ///
    /// # Errors
    /// F20 for an axis that the machine lacks, F01; on the small chip none.
    #[cfg_attr(any(), micro(code = "DO home_by_profile", sure = 1))]
    fn plan(&mut self, n: u8) -> Result<(), Fault>;
    /// The axis of the run.
    #[cfg_attr(any(), micro(code = "DO axis_n"))]
    fn axis(&self) -> Axis;
    /// The machine has it.
    #[cfg_attr(any(), micro(code = "DO axis_there", holds = "NOT_EQUAL"))]
    fn is_there(&self, axis: Axis) -> bool;
    /// The small chip's pace, from the axis's record.
    #[cfg_attr(any(), micro(code = "DO axis_pace"))]
    fn take_pace(&mut self, axis: Axis);
    /// On the small chip: command 106 brought the numbers.
    #[cfg_attr(any(), micro(any = "BITS, HOME_COMMAND"))]
    fn is_by_command(&self) -> bool;
    /// They bound the pace; speed toward the switch, a scaled number.
    #[cfg_attr(
        any(),
        micro(
            code = "F load HOME_UP, NEW; F bound TEMP+4; F load HOME_DOWN, NEW; F bound TEMP+8; F load HOME_SPEED, NEW; CALL home_record",
            sets = "plan"
        )
    )]
    fn command_speed(&mut self) -> i32;
    /// That of the profile.
    #[cfg_attr(any(), micro(code = "FR load A_HOME_FAST, SHORT, NEW", sets = "plan"))]
    fn profile_speed(&mut self, axis: Axis) -> i32;
    /// It bounds the pace.
    #[cfg_attr(any(), micro(code = "DO speed_least"))]
    fn bound_speed(&mut self, speed: i32);
    /// So does the speed off the switch.
    #[cfg_attr(any(), micro(code = "FR load A_HOME_SLOW, SHORT, NEW; DO speed_least", of = "plan"))]
    fn slow_down(&mut self, axis: Axis);
    /// What moves of what the run waits for: on the small chip anything, else the axis.
    #[cfg_attr(any(), micro(place = "MOVING"))]
    fn moving(&self) -> u8;
    /// What the run has come to.
    #[cfg_attr(any(), micro(place = "PHASE"))]
    fn phase(&self) -> u8;
    /// See [`Homes::phase`].
    #[cfg_attr(any(), micro(place = "PHASE"))]
    fn set_phase(&mut self, phase: u8);
    /// The axis has not homed.
    #[cfg_attr(any(), micro(off = "HOMED"))]
    fn forget_home(&mut self, axis: Axis);
    /// It has.
    #[cfg_attr(any(), micro(on = "HOMED"))]
    fn set_home(&mut self, axis: Axis);
    /// Nothing has said where it is.
    #[cfg_attr(any(), micro(off = "PLACED"))]
    fn forget_place(&mut self, axis: Axis);
    /// Its work offset, um.
    #[cfg_attr(any(), micro(place = "OFFSET"))]
    fn set_offset(&mut self, axis: Axis, um: i32);
    /// Its switch is closed, before the filter.
    #[cfg_attr(any(), micro(code = "DO home_closed", holds = "NOT_EQUAL"))]
    fn is_closed(&self) -> bool;
    /// Where the switch is: [`AxisRecord::HOME_POSITIVE`].
    #[cfg_attr(any(), micro(record = "A_FLAGS", of = "plan"))]
    fn way(&self, axis: Axis) -> u8;
    /// How far to look for the switch, in the plan's unit.
    #[cfg_attr(any(), micro(record = "A_HOME_STROKE", of = "plan"))]
    fn stroke(&self, axis: Axis) -> i32;
    /// Where the switch opens.
    #[cfg_attr(any(), micro(record = "A_HOME_POSITION", of = "plan"))]
    fn place(&self, axis: Axis) -> i32;
    /// The clearance, away from the switch when positive.
    #[cfg_attr(any(), micro(record = "A_HOME_CLEARANCE", of = "plan"))]
    fn clearance(&self, axis: Axis) -> i32;
    /// The rest between the two runs, ms.
    #[cfg_attr(any(), micro(record = "A_HOME_PAUSE", of = "plan"))]
    fn pause(&self, axis: Axis) -> u16;
    /// A number of the plan in steps.
    #[cfg_attr(any(), micro(code = "DO to_steps", of = "plan"))]
    fn planned(&self, axis: Axis, value: i32) -> i32;
    /// The time that is left, ms.
    #[cfg_attr(any(), micro(place = "TIME"))]
    fn time(&self) -> i32;
    /// See [`Homes::time`].
    #[cfg_attr(any(), micro(place = "TIME"))]
    fn set_time(&mut self, ms: i32);
    /// Where the axis is at this instant, steps.
    #[cfg_attr(any(), micro(place = "ACTUAL", load = "DO here"))]
    fn position(&self, axis: Axis) -> i32;
    /// The axis sets off to a place, at the pace of the phase.
    #[cfg_attr(any(), micro(code = "F store STEPS, AXIS; DO begin_axis"))]
    fn seek_to(&mut self, axis: Axis, steps: i32) -> Progress;
    /// That place is commanded, too.
    #[cfg_attr(any(), micro(code = "DO axis_at; CALL settle; DO begin_axis"))]
    fn rest_at(&mut self, axis: Axis, steps: i32) -> Progress;
    /// The axis brakes.
    #[cfg_attr(any(), micro(code = "DO motion_stop"))]
    fn brake(&mut self, axis: Axis);
    /// The switch has opened where the axis is: it brakes.
    #[cfg_attr(any(), micro(code = "DO here; F store OPENED; DO motion_hit"))]
    fn catch(&mut self, axis: Axis);
    /// The place where it opened is the plan's: what the axis went on counts from there.
    #[cfg_attr(
        any(),
        micro(
            code = "FR load A_HOME_POSITION, LONG; DO to_steps; F add ACTUAL, AXIS; F sub OPENED; F store ACTUAL, AXIS",
            of = "plan"
        )
    )]
    fn set_place(&mut self, axis: Axis);
    /// The commanded place is where the axis stands.
    #[cfg_attr(any(), micro(code = "DO axis_at; DO settle_here"))]
    fn settle_here(&mut self, axis: Axis);
    /// The statement asks whether the switch is found.
    #[cfg_attr(any(), micro(is = "EFFECT, OP_HOME_QUERY"))]
    fn asks(&self) -> bool;
}

/// The small chip's switches.
pub trait Switches: Effects {
    /// Input number of an axis's reference switch.
    #[cfg_attr(any(), micro(code = "CALL reference"))]
    fn reference(&self, n: u8) -> u8;
    /// The same.
    #[cfg_attr(any(), micro(code = "DO reference_at"))]
    fn reference_at(&self, axis: Axis) -> u8;
    /// Level of an input before its filter, 0 or 1.
    #[cfg_attr(any(), micro(code = "DO unfiltered"))]
    fn unfiltered(&self, n: u8) -> u8;
    /// Flags of a run: the switch is off when it is closed.
    #[cfg_attr(any(), micro(any = "BITS, HOME_INVERT"))]
    fn is_inverted(&self) -> bool;
    /// Axes that move.
    #[cfg_attr(any(), micro(place = "MOVING"))]
    fn moving(&self) -> u8;
    /// The axis is one of them.
    #[cfg_attr(any(), micro(has = "MOVING"))]
    fn is_moving(&self, axis: Axis) -> bool;
    /// It moves in negative direction.
    #[cfg_attr(any(), micro(has = "NEGATIVE"))]
    fn is_negative(&self, axis: Axis) -> bool;
    /// An axis homes.
    #[cfg_attr(any(), micro(code = "DO map_homes", holds = "NO_CARRY"))]
    fn homes(&self) -> bool;
    /// Where the axis's switch is: [`AxisRecord::HOME_POSITIVE`].
    #[cfg_attr(any(), micro(record = "A_FLAGS"))]
    fn side(&self, axis: Axis) -> u8;
    /// The axis has not homed.
    #[cfg_attr(any(), micro(off = "HOMED"))]
    fn forget_home(&mut self, axis: Axis);
    /// The input of the next fault.
    #[cfg_attr(any(), micro(place = "FAULT_IN"))]
    fn set_fault_input(&mut self, n: u8);
    /// Steps cease at once.
    #[cfg_attr(any(), micro(code = "DO motion_halt"))]
    fn halt(&mut self);
    /// F06 ends the run.
    #[cfg_attr(any(), micro(code = "LIT F_LIMIT_SWITCH; DO fail"))]
    fn fail_at_limit(&mut self);
}

/// An axis that moves toward its closed reference switch outside homing: F06. Each millisecond.
#[cfg_attr(any(), micro(entry = "limits", bytes = "TEMP"))]
pub fn limits(m: &mut impl Switches) {
    if m.moving() == 0 || m.homes() {
        return;
    }
    for axis in Axis::DOWN {
        let input = m.reference_at(axis);
        if m.unfiltered(input) == 0 || !m.is_moving(axis) {
            continue;
        }
        let mut side = m.side(axis);
        // A switch at the positive end, or the other way round.
        if m.is_negative(axis) {
            side = side.wrapping_add(HOME_POSITIVE);
        }
        if side & HOME_POSITIVE != 0 {
            m.forget_home(axis);
            m.set_fault_input(input);
            m.halt();
            m.fail_at_limit();
            return;
        }
    }
}

/// Home, Home? and commands 106, 1110.
///
/// # Errors
/// F20, F10, F11; those of the plan.
#[cfg_attr(any(), micro(label = "fx_home", bytes = "FLAGS"))]
pub fn home(m: &mut impl Homes, code: u8, first: bool) -> Progress {
    if first {
        let mut n = code.wrapping_sub(HOME);
        if n == HOME_QUERY - HOME {
            n = m.operand();
        }
        m.plan(n)?;
    }
    let axis = m.axis();
    if !m.is_there(axis) {
        return Err(Fault::ValueRange);
    }
    m.take_pace(axis);
    let speed = if m.is_by_command() { m.command_speed() } else { m.profile_speed(axis) };
    m.bound_speed(speed);
    let phase = m.phase();
    if m.moving() != 0 && phase < FAST {
        return NOT_YET;
    }
    match phase {
        BEGIN => {
            m.forget_home(axis);
            m.forget_place(axis);
            m.set_offset(axis, 0);
            m.set_phase(REST);
            if m.is_closed() {
                return NOT_YET;
            }
            m.set_phase(FAST);
            seek(m, axis, m.way(axis))
        }
        REST => {
            m.set_time(i32::from(m.pause(axis)));
            m.set_phase(PAUSE);
            NOT_YET
        }
        PAUSE => {
            if m.time() != 0 {
                return NOT_YET;
            }
            m.set_phase(SLOW);
            m.slow_down(axis);
            seek(m, axis, m.way(axis).wrapping_add(HOME_POSITIVE))
        }
        FAST => {
            if !m.is_closed() {
                if m.moving() != 0 {
                    return NOT_YET;
                }
                missed(m, axis);
                if m.asks() {
                    return DONE;
                }
                return Err(Fault::HomeNotFound);
            }
            m.set_phase(REST);
            m.brake(axis);
            NOT_YET
        }
        SLOW => {
            if m.is_closed() {
                if m.moving() != 0 {
                    return NOT_YET;
                }
                missed(m, axis);
                return Err(Fault::HomeStaysClosed);
            }
            m.set_phase(OPEN);
            m.catch(axis);
            NOT_YET
        }
        OPEN => {
            m.set_phase(CLEAR);
            m.set_home(axis);
            m.set_place(axis);
            let way = m.way(axis);
            let mut away = m.clearance(axis);
            if way & HOME_POSITIVE != 0 {
                away = away.wrapping_neg();
            }
            let steps = m.planned(axis, away.wrapping_add(m.place(axis)));
            m.rest_at(axis, steps)
        }
        _ => {
            m.tell_met(TraceKind::Home, m.position(axis));
            DONE
        }
    }
}

/// Moves by the stroke, in positive direction when `toward` says so.
#[cfg_attr(any(), micro(of = "plan", bytes = "FLAGS"))]
fn seek(m: &mut impl Homes, axis: Axis, toward: u8) -> Progress {
    let mut stroke = m.planned(axis, m.stroke(axis));
    if toward & HOME_POSITIVE == 0 {
        stroke = stroke.wrapping_neg();
    }
    m.seek_to(axis, stroke.wrapping_add(m.position(axis)))
}

/// A reference run that failed ends where the axis stands.
#[cfg_attr(any(), micro(leaves = 0))]
pub fn missed(m: &mut impl Homes, axis: Axis) {
    m.settle_here(axis);
    m.tell(TraceKind::Home, m.position(axis));
}

/// Whether the switch of the run is closed: an input's number and [`Switches::is_inverted`] are the effect's flags.
pub fn closed(m: &mut impl Switches) -> bool {
    let mut level = m.unfiltered(m.bits() & 31);
    if m.is_inverted() {
        level = level.wrapping_add(1);
    }
    level & 1 != 0
}

/// Plans the reference run of an axis, which becomes the effect's number.
pub fn by_profile(m: &mut impl Switches, n: u8) {
    m.set_number(n);
    m.set_bits(m.reference(n));
}
