//! Commands of holding registers 2000 and up (InterpCNC V3 Modbus protocol, Commands).
//!
//! The words of a command are read by their index; consecutive ones, speeds and ramps, by
//! [`Commands::next`]. Where the chips differ: 102 to 104 give a moving axis of the larger one a new target; the
//! small one moves one thing at a time.
#![cfg_attr(any(), micro(module = "rules.commands", prefix = "command_"))]

mod leaves;

pub use leaves::Commands;

use super::{Answer, Axis, coords, pace};
use crate::motion::scaled::Scaled;
use lang::isa::Op;
use lang::record::AxisRecord;
use lang::wire::{Control, Direct, Exception, command};

/// Commands.
const STOP_AXIS: u16 = 100;
const STOP_AXES: u16 = 101;
const MOVE_SPEED: u16 = 102;
const MOVE_TO: u16 = 103;
const MOVE_BY: u16 = 104;
const SET_POSITION: u16 = 105;
const HOME: u16 = 106;
const PROBE: u16 = 107;
const PROBE_MASK: u16 = 108;
const FORCE_INPUT: u16 = 110;
const HOME_PROFILE: u16 = 1110;
const JOG: u16 = 1111;
const DIRECT: u16 = 1200;
const _: () = assert!(
    STOP_AXIS == command::STOP_AXIS
        && STOP_AXES == command::STOP_AXES
        && MOVE_SPEED == command::MOVE_SPEED
        && MOVE_TO == command::MOVE_TO
        && MOVE_BY == command::MOVE_BY
        && SET_POSITION == command::SET_POSITION
        && HOME == command::HOME
        && PROBE == command::PROBE
        && PROBE_MASK == command::PROBE_MASK
        && FORCE_INPUT == command::FORCE_INPUT
        && HOME_PROFILE == command::HOME_PROFILE
        && JOG == command::JOG
        && DIRECT == command::DIRECT
);

/// What command 1200 does.
const ACKNOWLEDGE: u16 = 88;
const RESUME: u16 = 129;
const PAUSE: u16 = 130;
const STOP_JOG: u16 = 133;
const STOP: u16 = 255;
const _: () = assert!(
    ACKNOWLEDGE == Direct::Acknowledge as u16
        && RESUME == Direct::Resume as u16
        && PAUSE == Direct::Pause as u16
        && STOP_JOG == Direct::StopJog as u16
        && STOP == Direct::Stop as u16
);

/// What a control code asks for.
const CONTROL_STOP: u8 = 2;
const CONTROL_PAUSE: u8 = 3;
const CONTROL_RESUME: u8 = 4;
const CONTROL_ACKNOWLEDGE: u8 = 6;
const _: () = assert!(
    CONTROL_STOP == Control::Stop as u8
        && CONTROL_PAUSE == Control::Pause as u8
        && CONTROL_RESUME == Control::Resume as u8
        && CONTROL_ACKNOWLEDGE == Control::Acknowledge as u8
);

/// Command 1111: places count from where the axes are. Below it axes have their bits.
pub const RELATIVE: u16 = 64;
/// Bits of three axes, and what lies between them and [`RELATIVE`].
const AXES: u16 = 7;
const BETWEEN: u16 = 56;

/// See [`Op::Probe`].
#[cfg_attr(any(), micro("OP_PROBE"))]
const OP_PROBE: u8 = Op::Probe as u8;
/// See [`AxisRecord::HOME_POSITIVE`].
#[cfg_attr(any(), micro("AXIS_HOME_POSITIVE"))]
const HOME_POSITIVE: u8 = AxisRecord::HOME_POSITIVE as u8;
/// See [`Op::Home`].
#[cfg_attr(any(), micro("OP_HOME"))]
const OP_HOME: u8 = Op::Home as u8;

/// Executes the command.
///
/// # Errors
/// Illegal value, busy, no program whose profile 1110 and 1111 need.
#[cfg_attr(any(), micro(entry = "command_execute", begins = "mov #COMMAND+4, r5"))]
pub fn execute(m: &mut impl Commands) -> Answer {
    m.set_axes(m.argument() as u8);
    let axis = Axis::new((m.argument() as u8).wrapping_sub(1));
    if m.command() == STOP_AXES {
        return stop(m);
    }
    if m.command() == FORCE_INPUT {
        return force(m);
    }
    if m.command() == DIRECT {
        return direct(m);
    }
    if m.command() != JOG {
        if m.argument() >= 4 {
            return Err(Exception::IllegalValue);
        }
        if !m.is_there(axis) {
            return Err(Exception::IllegalValue);
        }
        m.set_axes(axis.bit());
        if m.command() == STOP_AXIS {
            return stop(m);
        }
    }
    if m.is_active() || m.effect() != 0 {
        return Err(Exception::Busy);
    }
    if m.command() == MOVE_SPEED && m.speed() == 0 {
        return stop(m);
    }
    if m.in_the_way() != 0 || m.blocking() != 0 {
        return Err(Exception::Busy);
    }
    m.set_number((m.argument() as u8).wrapping_sub(1));
    m.set_flags(0);
    match m.command() {
        MOVE_SPEED => run(m, axis),
        MOVE_TO => go(m, axis, coords::offset_steps(m, axis)),
        MOVE_BY => go(m, axis, m.position(axis)),
        SET_POSITION => position_is(m, axis, m.work_position()),
        HOME => home(m),
        PROBE => {
            m.set_level(m.probe_level() as u8);
            if m.probe_level() >= 2 {
                return Err(Exception::IllegalValue);
            }
            if m.probe_input() >= 17 {
                return Err(Exception::IllegalValue);
            }
            m.await_input((m.probe_input() as u8).wrapping_add(1));
            m.next();
            probe(m, axis)
        }
        PROBE_MASK => {
            m.await_off(m.xor());
            m.await_of(m.and());
            m.next();
            m.next();
            probe(m, axis)
        }
        _ => by_profile(m),
    }
}

/// Those that want a program.
fn by_profile(m: &mut impl Commands) -> Answer {
    match m.command() {
        HOME_PROFILE => {
            if !m.has_program() {
                return Err(Exception::DeviceFailure);
            }
            m.plan(m.number()).map_err(|_| Exception::IllegalValue)?;
            home_under_way(m)
        }
        JOG => {
            if !m.has_program() {
                return Err(Exception::DeviceFailure);
            }
            jog(m)
        }
        _ => Err(Exception::IllegalValue),
    }
}

/// Stops the axes that are meant; in a run, ends the run.
fn stop(m: &mut impl Commands) -> Answer {
    if m.is_active() {
        return control(m, CONTROL_STOP);
    }
    abandon(m);
    for axis in Axis::DOWN {
        if m.is_meant(axis) && m.is_moving(axis) {
            m.brake(axis);
        }
    }
    Ok(())
}

fn control(m: &mut impl Commands, code: u8) -> Answer {
    m.control(code);
    Ok(())
}

/// The input from 0, its level.
fn force(m: &mut impl Commands) -> Answer {
    if m.argument() >= 16 {
        return Err(Exception::IllegalValue);
    }
    m.force((m.argument() as u8).wrapping_add(1))
}

/// What to do; [`STOP`] is all axes.
fn direct(m: &mut impl Commands) -> Answer {
    if m.argument() == STOP {
        return stop(m);
    }
    if m.argument() == ACKNOWLEDGE {
        return control(m, CONTROL_ACKNOWLEDGE);
    }
    match m.argument() {
        RESUME => control(m, CONTROL_RESUME),
        PAUSE => control(m, CONTROL_PAUSE),
        STOP_JOG => {
            if m.is_held() {
                m.brake_all();
            }
            Ok(())
        }
        _ => Err(Exception::IllegalValue),
    }
}

/// The work position of the axis becomes a place, steps.
///
/// # Errors
/// Busy while it moves; illegal when it does not fit.
#[cfg_attr(any(), micro(label = "work_position_is", longs = "SPARE"))]
pub fn position_is(m: &mut impl Commands, axis: Axis, place: i32) -> Answer {
    if m.moving_of(axis) != 0 {
        return Err(Exception::Busy);
    }
    let way = m.position(axis).wrapping_sub(place);
    let um = m.to_um(axis, way).ok_or(Exception::IllegalValue)?;
    m.set_offset(axis, um);
    Ok(())
}

/// 103, 104: ramp up, speed, ramp down, and how far from `start`.
#[cfg_attr(any(), micro(of = "axis"))]
fn go(m: &mut impl Commands, axis: Axis, start: i32) -> Answer {
    target(m, axis, start)?;
    m.go(axis);
    Ok(())
}

/// The pace of the command, and where a way behind it ends that begins at `start`: the new place of the axis.
#[cfg_attr(any(), micro(label = "command_target"))]
fn target(m: &mut impl Commands, axis: Axis, start: i32) -> Answer {
    m.set_start(start);
    if !pace(m, axis) {
        return Err(Exception::IllegalValue);
    }
    let way = m.next();
    aim(m, axis, way)
}

/// Where a way ends: the new place of the axis.
#[cfg_attr(any(), micro(label = "command_aim"))]
fn aim(m: &mut impl Commands, axis: Axis, way: i32) -> Answer {
    let place = way.checked_add(m.start()).ok_or(Exception::IllegalValue)?;
    m.aim_steps(axis, place).map_err(|_| Exception::IllegalValue)?;
    Ok(())
}

/// The pace with the command's ramp up, speed, ramp down, none above the machine's; whether all are above 0.
#[cfg_attr(any(), micro(label = "command_pace"))]
fn pace(m: &mut impl Commands, axis: Axis) -> bool {
    m.take_pace(axis);
    m.count_in_steps();
    let up = m.next();
    let up = pace::rate_of(m, axis, up);
    m.least_up(up);
    let speed = m.next();
    let speed = pace::rate_of(m, axis, speed);
    pace::speed_least(m, speed);
    let down = m.next();
    let down = pace::rate_of(m, axis, down);
    m.least_down(down).least(m.pace_up()).least(m.pace_speed()) != Scaled::ZERO
}

/// 102: ramp, speed with its sign; to the end of the travel of an axis that has homed, for hours of any other.
#[cfg_attr(any(), micro(of = "axis"))]
fn run(m: &mut impl Commands, axis: Axis) -> Answer {
    m.set_ramp_down(m.ramp());
    m.set_far();
    let mut target = if m.speed() < 0 {
        m.set_speed(m.speed().wrapping_neg());
        m.set_far_to(m.far().wrapping_neg());
        m.travel_steps(axis, m.travel_begin(axis))
    } else {
        m.travel_steps(axis, m.travel_end(axis))
    };
    if !m.is_homed(axis) {
        target = m.position(axis).wrapping_add(m.far());
    }
    m.set_target(axis, target);
    if !pace(m, axis) {
        return Err(Exception::IllegalValue);
    }
    m.run(axis);
    held(m)
}

/// Axes that move do so for as long as the host speaks.
fn held(m: &mut impl Commands) -> Answer {
    if m.moving() != 0 {
        m.set_held();
    }
    Ok(())
}

/// 1111: bits of axes, 64 for distances; um/min and um, floats of mm.
#[cfg_attr(any(), micro(longs = "SPARE"))]
fn jog(m: &mut impl Commands) -> Answer {
    if m.argument() >= RELATIVE + 8 {
        return Err(Exception::IllegalValue);
    }
    m.set_flags(m.argument() as u8);
    if m.argument() & BETWEEN != 0 {
        return Err(Exception::IllegalValue);
    }
    if m.argument() & AXES == 0 {
        return Err(Exception::IllegalValue);
    }
    let minute = Scaled::new(60);
    let speed = m.next_thousandths().max(0);
    let feed = Scaled::new(speed as u32).over(minute).floor();
    if feed == 0 {
        return Err(Exception::IllegalValue);
    }
    m.set_feed(feed as i32);
    // All targets before any is commanded.
    for axis in Axis::UP {
        if !m.is_named(axis) {
            continue;
        }
        let um = m.next_thousandths();
        let way = m.to_steps(axis, um).ok_or(Exception::IllegalValue)?;
        m.set_start(way);
        let mut start = m.position(axis);
        if !m.counts_from_here() {
            start = coords::offset_steps(m, axis);
        }
        aim(m, axis, start)?;
    }
    m.go_in_line();
    held(m)
}

/// 106: 0, input from 0, its level when closed, 1 for positive, then speed, speed off the switch, ramps up and down,
/// stroke, rest, place, clearance.
fn home(m: &mut impl Commands) -> Answer {
    if m.nothing() != 0 {
        return Err(Exception::IllegalValue);
    }
    if m.switch() >= 17 {
        return Err(Exception::IllegalValue);
    }
    m.set_switch(m.switch());
    if m.closed_level() >= 2 {
        return Err(Exception::IllegalValue);
    }
    if m.closed_level() & 1 == 0 {
        m.set_inverted();
    }
    if m.home_side() >= 2 {
        return Err(Exception::IllegalValue);
    }
    for which in Axis::FOUR {
        if m.home_rate(which).max(0) == 0 {
            return Err(Exception::IllegalValue);
        }
    }
    let axis = m.axis();
    m.take_plan(axis);
    m.set_stroke(m.home_stroke().wrapping_abs());
    if m.home_side() == 0 {
        m.set_way(0);
    } else {
        m.set_clearance(m.home_clearance().wrapping_neg());
        m.set_way(HOME_POSITIVE);
    }
    home_under_way(m)
}

fn home_under_way(m: &mut impl Commands) -> Answer {
    let axis = m.axis();
    m.first_phase();
    m.set_homing(axis);
    m.set_effect(m.number().wrapping_add(OP_HOME));
    Ok(())
}

/// 107, 108: behind the inputs, ramp up, speed, ramp down and a distance.
#[cfg_attr(any(), micro(of = "axis"))]
fn probe(m: &mut impl Commands, axis: Axis) -> Answer {
    target(m, axis, m.position(axis))?;
    m.set_probing(axis);
    m.first_phase();
    m.set_effect(OP_PROBE);
    if !m.begin_probe(axis) {
        abandon(m);
    }
    Ok(())
}

/// What an effect by command came to: 0, or a fault.
#[cfg_attr(any(), micro(entry = "command_done"))]
pub fn done(m: &mut impl Commands, result: u8) {
    if result == 0 {
        return;
    }
    abandon(m);
}

/// A reference run or a probe by command is given up and counts as failed.
#[cfg_attr(any(), micro(label = "abandon"))]
pub fn abandon(m: &mut impl Commands) {
    if m.effect() == 0 {
        return;
    }
    let axis = m.axis();
    if m.effect() == OP_PROBE {
        m.set_probe_failed(axis);
    } else {
        m.set_homing_failed(axis);
    }
    m.forget();
}
