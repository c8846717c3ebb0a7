//! Lines and single axes of the small chip: from commanded places to what the ramp generator and the step engine need.
//!
//! Each motion starts from rest and comes to rest, but for lines of a course. Twins: `motion::path` for one lone block,
//! `motion::single`. The small chip's alone: the larger one has a queue of blocks and looks ahead.
//!
//! The unit of an interpolated motion is the um along its path, with a feed in steps/s the step along it; an event is a step
//! of the axis with most steps. The unit of a single axis is its step.
//!
//! The plan of a motion is a handful of numbers: events, increments of the axes (Bresenham's line as accumulators, as
//! in grbl's stepper interrupt), the speed to run at, and what v^2 grows and falls by over one event. [`plan`], [`limit`] and
//! [`remember`] compute them one after the other; `tick` is the length, then the pitch, then the interval at speed 1.
//! Names that end in 2 are squares of speeds. [`super::segments`] makes segments of them while the motion runs.
#![cfg_attr(any(), micro(module = "rules.planner", section = "line"))]

use super::Axis;
use super::pace::{OwnPaces, Paces};
use crate::motion::scaled::Scaled;
use lang::isa::Op;

/// See [`Op::Probe`]; up to [`Op::HomeQuery`] what moves at speeds of its own, whatever the overrides are.
#[cfg_attr(any(), micro("OP_PROBE"))]
const PROBE: u8 = Op::Probe as u8;
/// See [`Op::HomeQuery`].
#[cfg_attr(any(), micro("OP_HOME_QUERY"))]
const HOME_QUERY: u8 = Op::HomeQuery as u8;
/// Manner of a motion: a line at the feed.
const AT_FEED: u8 = 0;
/// As fast as the axes can.
const RAPID: u8 = 1;
/// A single axis.
#[cfg_attr(any(), micro("LONE&255"))]
const LONE: u8 = 0xFF;

/// What plans look at and make.
pub trait Planner: Paces + OwnPaces {
    /// Bit per axis that moves.
    #[cfg_attr(any(), micro(place = "MOVING"))]
    fn moving(&self) -> u8;
    /// See [`Planner::moving`].
    #[cfg_attr(any(), micro(place = "MOVING"))]
    fn set_moving(&mut self, axes: u8);
    /// The axis moves.
    #[cfg_attr(any(), micro(has = "MOVING"))]
    fn moves(&self, axis: Axis) -> bool;
    /// It has no step to make.
    #[cfg_attr(any(), micro(off = "MOVING"))]
    fn stand(&mut self, axis: Axis);
    /// The motion's manner.
    #[cfg_attr(any(), micro(place = "HIT"))]
    fn manner(&self) -> u8;
    /// See [`Planner::manner`].
    #[cfg_attr(any(), micro(place = "HIT"))]
    fn set_manner(&mut self, manner: u8);
    /// It is a rapid one.
    #[cfg_attr(any(), micro(is = "HIT, 1"))]
    fn hurries(&self) -> bool;
    /// It is a single axis.
    #[cfg_attr(any(), micro(is = "HIT, LONE&255"))]
    fn is_lone(&self) -> bool;
    /// An emergency stop has answered at its pin.
    #[cfg_attr(any(), micro(is = "WATCH, TRIPPED&255"))]
    fn has_tripped(&self) -> bool;
    /// No pin is watched.
    #[cfg_attr(any(), micro(code = "LET WATCH, 0"))]
    fn unwatch(&mut self);
    /// Steps of an axis: as many as it has to make, at least 0.
    #[cfg_attr(any(), micro(place = "NEW_STEPS"))]
    fn distance(&self, axis: Axis) -> i32;
    /// See [`Planner::distance`].
    #[cfg_attr(any(), micro(place = "NEW_STEPS"))]
    fn set_distance(&mut self, axis: Axis, steps: i32);
    /// Where it stands, steps.
    #[cfg_attr(any(), micro(place = "ACTUAL"))]
    fn start_of_way(&self, axis: Axis) -> i32;
    /// It goes the way of this number's sign.
    #[cfg_attr(any(), micro(code = "CALL line_direction"))]
    fn turn(&mut self, axis: Axis, way: i32);
    /// Events of the motion: steps of the longest axis.
    #[cfg_attr(any(), micro(place = "LEFT"))]
    fn left(&self) -> i32;
    /// See [`Planner::left`].
    #[cfg_attr(any(), micro(place = "LEFT"))]
    fn set_left(&mut self, events: i32);
    /// The feed is in steps/s.
    #[cfg_attr(any(), micro(any = "FEED+3, 0x80"))]
    fn feeds_steps(&self) -> bool;
    /// F: um/s, negative steps/s, 0 for none.
    #[cfg_attr(any(), micro(place = "FEED"))]
    fn feed(&self) -> i32;
    /// Length of the path, or its square; then what an event is long; then the interval at speed 1, ticks.
    #[cfg_attr(any(), micro(place = "TICK"))]
    fn tick(&self) -> Scaled;
    /// See [`Planner::tick`].
    #[cfg_attr(any(), micro(place = "TICK"))]
    fn set_tick(&mut self, length: Scaled);
    /// Speed from rest; then the speed that the last segment ends at.
    #[cfg_attr(any(), micro(place = "V"))]
    fn end_speed(&self) -> Scaled;
    /// See [`Planner::end_speed`].
    #[cfg_attr(any(), micro(place = "V"))]
    fn set_end_speed(&mut self, speed: Scaled);
    /// It bounds the speed from rest.
    #[cfg_attr(any(), micro(code = "F bound V"))]
    fn least_start(&mut self, speed: Scaled);
    /// What an axis starts at, steps/s.
    #[cfg_attr(any(), micro(record = "A_START_RATE"))]
    fn start_rate(&self, axis: Axis) -> u16;
    /// The ramp down of the pace.
    #[cfg_attr(any(), micro(place = "TEMP+8"))]
    fn pace_down(&self) -> Scaled;
    /// What of an event a step of an axis is that makes so many, 2^-32.
    #[cfg_attr(any(), micro(code = "CALL line_fraction"))]
    fn share_of(&self, steps: i32) -> i32;
    /// What an event adds to the accumulator of an axis.
    #[cfg_attr(any(), micro(place = "INC"))]
    fn share(&self, axis: Axis) -> i32;
    /// See [`Planner::share`].
    #[cfg_attr(any(), micro(place = "INC"))]
    fn set_share(&mut self, axis: Axis, share: i32);
    /// Accumulator, count and direction of an axis as a motion begins from rest, whether it has steps to make or none.
    #[cfg_attr(any(), micro(code = "CALL line_origin"))]
    fn begin_axis(&mut self, axis: Axis);
    /// The speed that overrides act on: that of the axes, or that which a single one is to have.
    #[cfg_attr(any(), micro(place = "CAUGHT"))]
    fn limit(&self) -> Scaled;
    /// See [`Planner::limit`].
    #[cfg_attr(any(), micro(place = "CAUGHT"))]
    fn set_limit(&mut self, speed: Scaled);
    /// Growth of the speed's square over one event.
    #[cfg_attr(any(), micro(place = "ACCEL2"))]
    fn set_accel2(&mut self, growth: Scaled);
    /// Its decline while braking.
    #[cfg_attr(any(), micro(place = "DECEL2"))]
    fn set_decel2(&mut self, decline: Scaled);
    /// See [`Planner::set_decel2`].
    #[cfg_attr(any(), micro(place = "DECEL2"))]
    fn decel2(&self) -> Scaled;
    /// Square of the speed to run at.
    #[cfg_attr(any(), micro(place = "NOMINAL2"))]
    fn nominal2(&self) -> Scaled;
    /// See [`Planner::nominal2`].
    #[cfg_attr(any(), micro(place = "NOMINAL2"))]
    fn set_nominal2(&mut self, square: Scaled);
    /// Square of the speed from and to rest.
    #[cfg_attr(any(), micro(place = "START2"))]
    fn start2(&self) -> Scaled;
    /// See [`Planner::start2`].
    #[cfg_attr(any(), micro(place = "START2"))]
    fn set_start2(&mut self, square: Scaled);
    /// It bounds that.
    #[cfg_attr(any(), micro(code = "F bound START2"))]
    fn least_start2(&mut self, square: Scaled);
    /// Square of [`Planner::end_speed`].
    #[cfg_attr(any(), micro(place = "V2"))]
    fn end_speed2(&self) -> Scaled;
    /// See [`Planner::end_speed2`].
    #[cfg_attr(any(), micro(place = "V2"))]
    fn set_end_speed2(&mut self, square: Scaled);
    /// Ticks of a second.
    #[cfg_attr(any(), micro(code = "DO ticks_a_second"))]
    fn clock(&self) -> Scaled;
    /// Code of the effect under way, 0 for none.
    #[cfg_attr(any(), micro(place = "EFFECT"))]
    fn effect(&self) -> u8;
    /// Its axis.
    #[cfg_attr(any(), micro(code = "DO axis_n"))]
    fn axis(&self) -> Axis;
    /// Override of feeds and single axes, percent.
    #[cfg_attr(any(), micro(place = "OVERRIDE"))]
    fn override_of_feeds(&self) -> u8;
    /// That of rapid moves.
    #[cfg_attr(any(), micro(place = "OVERRIDE+1"))]
    fn override_of_rapids(&self) -> u8;
    /// No step comes any more.
    #[cfg_attr(any(), micro(code = "DO motion_rests", holds = "EQUAL"))]
    fn rests(&self) -> bool;
    /// An axis goes in negative direction.
    #[cfg_attr(any(), micro(has = "NEGATIVE"))]
    fn goes_down(&self, axis: Axis) -> bool;
}

/// Lines of a course, which small chips have in images that have room for them.
pub trait Chains: Planner {
    /// The line waits for the last segment of the one before.
    #[cfg_attr(any(), micro(any = "MOTION, M_NEXT", when = "HAS_COURSES"))]
    fn follows(&self) -> bool;
    /// How a share differs from what an event adds now.
    #[cfg_attr(any(), micro(code = "CALL line_change"))]
    fn change_of(&self, axis: Axis, share: i32) -> i32;
    /// See [`Chains::change_of`]: it comes when the line begins.
    #[cfg_attr(any(), micro(place = "NEXT_INC"))]
    fn set_change(&mut self, axis: Axis, change: i32);
    /// It ends at rest.
    #[cfg_attr(any(), micro(code = "BITS_OFF MOTION, M_THROUGH", when = "HAS_COURSES"))]
    fn end_at_rest(&mut self);
    /// It ends at speed.
    #[cfg_attr(any(), micro(code = "BITS_ON MOTION, M_THROUGH"))]
    fn end_at_speed(&mut self);
    /// Lines of a course are left.
    #[cfg_attr(any(), micro(any = "MOTION, M_COURSE", when = "HAS_COURSES"))]
    fn is_in_course(&self) -> bool;
    /// Square of the speed at which the line may end.
    #[cfg_attr(any(), micro(place = "EXIT2"))]
    fn exit2(&self) -> Scaled;
    /// A line of the course is planned: this is the square where its entry falls, else what that says.
    #[cfg_attr(any(), micro(code = "CALL course_line; GET JOINED; PUT JOINS"))]
    fn next_exit(&mut self, fallen: Scaled);
}

/// Speed of an axis at the end of the segment planned last, steps/s, negative in negative direction, 0 at rest.
#[cfg_attr(any(), micro(label = "motion_speed"))]
pub fn speed(m: &mut impl Planner, axis: Axis) -> i32 {
    if m.rests() {
        return 0;
    }
    // Events/s, `v / pitch`, times the axis's share of them, 2^-32: 2^-19 here and 2^-13 in `rounded`.
    let events = m.clock().times(m.end_speed()).over(m.tick());
    let steps = rounded(m, events.times(Scaled::new(m.share(axis) as u32)).shifted(-19));
    if m.goes_down(axis) { steps.wrapping_neg() } else { steps }
}

/// The integer next to a scaled number over 2^13.
#[cfg_attr(any(), micro(label = "rounded", longs = "TEMP"))]
pub fn rounded(_m: &impl Planner, number: Scaled) -> i32 {
    Scaled::new(1).shifted(12).plus(number).shifted(-13).floor() as i32
}

/// A rapid move of these axes in a line begins.
#[cfg_attr(any(), micro(label = "line_rapid"))]
pub fn rapid(m: &mut impl Chains, axes: u8) {
    m.set_manner(RAPID);
    plan(m, axes);
}

/// The axis of this bit sets off at the pace, none of which is above its own.
#[cfg_attr(any(), micro(label = "axis_begin"))]
pub fn single(m: &mut impl Chains, axes: u8) {
    m.set_manner(LONE);
    plan(m, axes);
}

/// These axes set off in a line at the feed; without one as fast as they can.
#[cfg_attr(any(), micro(label = "line_begin"))]
pub fn line(m: &mut impl Chains, axes: u8) {
    m.set_manner(AT_FEED);
    plan(m, axes);
}

/// From where axes stand to their commanded places. None moves when there is no step to make. The machine rests, or the
/// line before plays its last segments.
///
/// Steps, directions and the square of the path's length: the sum of the squares of the axes' ways. A feed in steps/s counts
/// the length in steps, so that the same formulas give a speed along the path in steps/s.
#[cfg_attr(any(), micro(longs = "CAUGHT"))]
fn plan(m: &mut impl Chains, axes: u8) {
    m.set_moving(axes);
    if !m.has_tripped() {
        m.unwatch();
    }
    m.set_left(0);
    m.set_tick(Scaled::ZERO);
    for axis in Axis::UP {
        m.set_distance(axis, 0);
        if !m.moves(axis) {
            continue;
        }
        let way = m.steps(axis).wrapping_sub(m.start_of_way(axis));
        if way == 0 {
            m.stand(axis);
            continue;
        }
        m.turn(axis, way);
        let steps = way.wrapping_abs();
        m.set_distance(axis, steps);
        m.set_left(m.left().max(steps));
        let mut way = Scaled::new(m.distance(axis) as u32);
        if !m.feeds_steps() {
            way = way.times(Scaled::new(u32::from(m.um_of(axis))));
            way = way.over(Scaled::new(u32::from(m.steps_of(axis))));
        }
        m.set_tick(m.tick().plus(way.times(way)));
    }
    if m.moving() != 0 {
        limit(m);
    }
}

/// The lowest limits along the path: speed, ramps, start rate; and what an event is for each axis. A single axis has the
/// length of its steps, and its limits already.
///
/// `step`, the length over an axis's steps, is the path for each of its steps; a limit in steps/s or steps/s2 times that is
/// a limit along the path. The accumulator of an axis gets `steps * 2^32 / events` at each event. A line that follows
/// another at speed must not touch the accumulators that still play: it leaves the difference for its first segment.
#[cfg_attr(any(), micro(longs = "CAUGHT"))]
fn limit(m: &mut impl Chains) {
    let most = Scaled::MAX;
    m.set_end_speed(most);
    if m.is_lone() {
        m.set_tick(Scaled::new(m.left() as u32));
    } else {
        m.set_pace_speed(most);
        m.set_pace_up(most);
        m.set_pace_down(most);
        m.set_tick(m.tick().root());
    }
    for axis in Axis::DOWN {
        if m.moves(axis) {
            // Path for each step of the axis.
            let step = m.tick().over(Scaled::new(m.distance(axis) as u32));
            m.least_speed(step.times(Scaled::new(m.top_rate(axis) as u32)));
            m.least_up(step.times(Scaled::new(m.ramp_up(axis) as u32)));
            m.least_down(step.times(Scaled::new(m.ramp_down(axis) as u32)));
            let start = Scaled::new(1).most(Scaled::new(u32::from(m.start_rate(axis))));
            m.least_start(start.times(step));
        }
        let share = m.share_of(m.distance(axis));
        if m.follows() {
            m.set_change(axis, m.change_of(axis, share));
            continue;
        }
        m.set_share(axis, share);
        m.begin_axis(axis);
    }
    m.set_limit(m.pace_speed());
    nominal(m);
    remember(m);
}

/// The planner's memory, from the length of the path and its limits.
///
/// `v1^2 = v0^2 + 2 a pitch` for each event, with 31/16 in place of 2 as in `motion::ramp`. A line of a course may end at
/// `exit2`, which the host has computed. Where the course's entry falls, a line ends slower than the one before by what
/// it can brake itself: its exit is the one before less `left * decel2`.
#[cfg_attr(any(), micro(longs = "TEMP"))]
fn remember(m: &mut impl Chains) {
    let event = m.tick().over(Scaled::new(m.left() as u32));
    m.set_tick(event);
    // Twice the ramps, less 1/32.
    let twice = Scaled::new(31).times(m.tick()).shifted(-4);
    m.set_decel2(twice.times(m.pace_down()));
    m.set_accel2(twice.times(m.pace_up()));
    let start2 = m.end_speed().times(m.end_speed());
    let speed2 = if m.follows() {
        // At the speed of the line before, and to rest as slowly as either wants it.
        m.least_start2(start2);
        m.end_speed2()
    } else {
        m.set_start2(start2);
        let speed2 = m.start2().least(m.nominal2());
        m.set_end_speed2(speed2);
        speed2
    };
    m.set_end_speed(speed2.root());
    m.set_tick(m.clock().times(m.tick()));
    m.end_at_rest();
    if m.is_in_course() {
        let brake = Scaled::new(m.left() as u32).times(m.decel2());
        m.next_exit(m.exit2().minus(brake));
        if m.start2() < m.exit2() {
            m.end_at_speed();
        }
    }
}

/// The speed to run at, from the speed that the axes can or that a single one is to have, the feed and the override; homing
/// and probing have none.
#[cfg_attr(any(), micro(label = "motion_nominal", longs = "TEMP, NOMINAL2"))]
pub fn nominal(m: &mut impl Planner) {
    let axis = m.axis();
    let hundred = Scaled::new(100);
    let percent = if matches!(m.effect(), PROBE..=HOME_QUERY) {
        100
    } else if m.hurries() {
        i32::from(m.override_of_rapids())
    } else {
        i32::from(m.override_of_feeds())
    };
    let part = Scaled::new(percent as u32).over(hundred);
    let asked = if m.manner() == AT_FEED && m.feed() != 0 {
        Scaled::new(m.feed().wrapping_abs() as u32)
    } else {
        Scaled::MAX
    };
    let mut speed = asked.least(m.limit()).times(part);
    if m.is_lone() {
        speed = speed.least(Scaled::new(m.top_rate(axis) as u32));
    } else {
        speed = speed.least(m.limit());
    }
    m.set_nominal2(speed.times(speed));
}
