//! How a motion of the small chip ends: by itself, on a ramp, where an input answered, or at once.
//!
//! Runs on the small chip only, whose planner is [`planner`](super::planner); the larger one has a queue of blocks.
#![cfg_attr(any(), micro(module = "rules.stops", section = "line"))]

use super::Axis;
use crate::motion::scaled::Scaled;

/// Nothing of a motion's flags.
const NONE: u8 = 0;

/// What the end of a motion looks at and does.
pub trait Stops {
    /// Bit per axis that moves.
    #[cfg_attr(any(), micro(place = "MOVING"))]
    fn moving(&self) -> u8;
    /// See [`Stops::moving`].
    #[cfg_attr(any(), micro(place = "MOVING"))]
    fn set_moving(&mut self, axes: u8);
    /// How the motion goes on, of which nothing is left.
    #[cfg_attr(any(), micro(place = "MOTION"))]
    fn set_motion(&mut self, flags: u8);
    /// It brakes, then its rest is forgotten. Lines of a course are taken all the same, while it brakes.
    #[cfg_attr(
        any(),
        micro(
            code = "BITS_OFF MOTION, M_PAUSE|M_SETTLE|M_JOG; BITS_ON MOTION, M_STOP",
            when = "HAS_COURSES",
            or = "LET MOTION, M_STOP"
        )
    )]
    fn brake_to_stop(&mut self);
    /// Its rest is forgotten, without a ramp.
    #[cfg_attr(any(), micro(code = "LET MOTION, M_STOP"))]
    fn end_at_once(&mut self);
    /// See [`Stops::brake_to_stop`].
    #[cfg_attr(any(), micro(any = "MOTION, M_STOP"))]
    fn brakes_to_stop(&self) -> bool;
    /// It ends elsewhere than it was to.
    #[cfg_attr(any(), micro(any = "MOTION, M_STOP|M_SETTLE|M_JOG"))]
    fn ends_elsewhere(&self) -> bool;
    /// The commanded places will be where it ends.
    #[cfg_attr(any(), micro(code = "BITS_ON MOTION, M_SETTLE"))]
    fn settle_at_end(&mut self);
    /// The motion is over: a pause is left of how it went on.
    #[cfg_attr(any(), micro(code = "BITS_OFF MOTION, ~M_PAUSE&0xff"))]
    fn keep_pause(&mut self);
    /// The commanded places are where the axes stand.
    #[cfg_attr(any(), micro(code = "CALL settle_all"))]
    fn settle_all(&mut self);
    /// Events that no segment has taken yet.
    #[cfg_attr(any(), micro(place = "LEFT"))]
    fn left(&self) -> i32;
    /// See [`Stops::left`].
    #[cfg_attr(any(), micro(place = "LEFT"))]
    fn set_left(&mut self, events: i32);
    /// Square of the speed that the last segment ends at.
    #[cfg_attr(any(), micro(place = "V2"))]
    fn set_end_speed2(&mut self, square: Scaled);
    /// Square of the speed to run at.
    #[cfg_attr(any(), micro(place = "NOMINAL2"))]
    fn nominal2(&self) -> Scaled;
    /// Square of the speed from and to rest.
    #[cfg_attr(any(), micro(place = "START2"))]
    fn start2(&self) -> Scaled;
    /// What an event takes of the square while the motion brakes.
    #[cfg_attr(any(), micro(place = "DECEL2"))]
    fn decel2(&self) -> Scaled;
    /// The commanded place of an axis, steps.
    #[cfg_attr(any(), micro(place = "STEPS"))]
    fn steps(&self, axis: Axis) -> i32;
    /// The step engine has no segments.
    #[cfg_attr(any(), micro(code = "F clear SLOT0+EVENTS; F clear SLOT1+EVENTS"))]
    fn empty_slots(&mut self);
    /// No step comes any more.
    #[cfg_attr(any(), micro(code = "DO motion_rests", holds = "EQUAL"))]
    fn rests(&self) -> bool;
    /// The main loop's look at the motion.
    #[cfg_attr(any(), micro(code = "DO motion_poll"))]
    fn poll(&mut self);
}

/// No step comes any more, and what the engine has counted is in the places: whether the motion is over, or rests in a pause.
#[cfg_attr(any(), micro(entry = "motion_over"))]
pub fn over(m: &mut impl Stops) {
    if !m.brakes_to_stop() && m.left() != 0 {
        return;
    }
    m.set_moving(0);
    if m.ends_elsewhere() {
        m.keep_pause();
        m.settle_all();
    }
}

/// Ramps down and forgets the rest, also of a pause.
#[cfg_attr(any(), micro(label = "motion_stop"))]
pub fn stop(m: &mut impl Stops) {
    m.brake_to_stop();
    if m.moving() == 0 {
        m.set_motion(NONE);
    }
}

/// The probe or switch answered when an axis was at `place`, steps: one no faster than its start rate stands still at once, a
/// faster one ramps down to a place that depends on that position and the speed alone. Then the commanded place is
/// where it stands.
#[cfg_attr(any(), micro(label = "motion_hit", longs = "TEMP+8, TEMP"))]
pub fn hit(m: &mut impl Stops, axis: Axis, place: i32) {
    let rest = place.wrapping_sub(m.steps(axis)).wrapping_abs();
    if m.start2() >= m.nominal2() {
        return halt(m);
    }
    // Half v^2 / d, and 24 ms for the main loop's round and what the engine holds, and one.
    let ramp = Scaled::new(31).times(m.nominal2()).over(m.decel2()).shifted(-5);
    let held = Scaled::new(9).times(m.nominal2()).root().shifted(-7);
    let way = held.plus(ramp).floor() as i32;
    let less = way.wrapping_sub(rest);
    m.settle_at_end();
    let less = less.wrapping_add(1);
    if less >= 0 {
        return;
    }
    // What is left less what is not to be made of it.
    let left = m.left().wrapping_add(less);
    if left < 0 {
        return stop(m);
    }
    m.set_left(left);
}

/// Steps cease at once: none after the next event, which is armed already and at most 2 ms away. The rest is forgotten, the
/// commanded places are where the axes stand.
#[cfg_attr(any(), micro(label = "motion_halt"))]
pub fn halt(m: &mut impl Stops) {
    // The step engine takes no offence at a line of a course that is late.
    m.set_end_speed2(Scaled::ZERO);
    // At rest, too: the interrupt may have left them.
    m.empty_slots();
    if m.moving() == 0 {
        return m.settle_all();
    }
    m.set_left(0);
    m.end_at_once();
    loop {
        if m.rests() {
            return m.poll();
        }
    }
}
