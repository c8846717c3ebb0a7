//! The ramp generator of the small chip: from what is left of a motion to segments of linearly changing intervals.
//!
//! One segment lasts 2 to 8 ms and ends at `v1^2 = min(v0^2 + 2 a n, nominal^2, start^2 + 2 d left)`. Its n events are a power of
//! two, or all that is left. The twin, with the why of each number, is `motion::ramp`. What counts in powers of two and
//! divides stands in `g2553/motion/ramp.s`, with registers of its own.
#![cfg_attr(any(), micro(module = "rules.segments", section = "ramp"))]

use crate::motion::scaled::Scaled;

/// What a segment is made of. Squares are of speeds, speeds are scaled numbers.
pub trait Segments {
    /// Events that no segment has taken yet.
    #[cfg_attr(any(), micro(place = "LEFT"))]
    fn left(&self) -> i32;
    /// The motion brakes to a pause or its end.
    #[cfg_attr(any(), micro(any = "MOTION, M_PAUSE|M_STOP"))]
    fn brakes(&self) -> bool;
    /// The goal is the square from and to rest, else that of the speed to run at.
    #[cfg_attr(any(), micro(code = "LIT (START2-NOMINAL2)/4; DO axis_select"))]
    fn aim_at_rest(&mut self);
    /// See [`Segments::aim_at_rest`].
    #[cfg_attr(any(), micro(place = "NOMINAL2, AXIS"))]
    fn goal2(&self) -> Scaled;
    /// Square of the speed from and to rest.
    #[cfg_attr(any(), micro(place = "START2"))]
    fn start2(&self) -> Scaled;
    /// Square of the speed at which a line of a course may end.
    #[cfg_attr(any(), micro(place = "EXIT2"))]
    fn exit2(&self) -> Scaled;
    /// It ends there.
    #[cfg_attr(any(), micro(any = "MOTION, M_THROUGH", when = "HAS_COURSES"))]
    fn ends_at_speed(&self) -> bool;
    /// Interval at speed 1, ticks.
    #[cfg_attr(any(), micro(place = "TICK"))]
    fn tick(&self) -> Scaled;
    /// Growth of the square over one event.
    #[cfg_attr(any(), micro(place = "ACCEL2"))]
    fn accel2(&self) -> Scaled;
    /// Its decline while braking.
    #[cfg_attr(any(), micro(place = "DECEL2"))]
    fn decel2(&self) -> Scaled;
    /// The speed that the last segment ends at.
    #[cfg_attr(any(), micro(place = "V"))]
    fn end_speed(&self) -> Scaled;
    /// See [`Segments::end_speed`].
    #[cfg_attr(any(), micro(place = "V"))]
    fn set_end_speed(&mut self, speed: Scaled);
    /// Its square.
    #[cfg_attr(any(), micro(place = "V2"))]
    fn end_speed2(&self) -> Scaled;
    /// See [`Segments::end_speed2`].
    #[cfg_attr(any(), micro(place = "V2"))]
    fn set_end_speed2(&mut self, square: Scaled);
    /// The same of this one.
    #[cfg_attr(any(), micro(place = "TEMP"))]
    fn next_speed(&self) -> Scaled;
    /// See [`Segments::next_speed`].
    #[cfg_attr(any(), micro(place = "TEMP"))]
    fn set_next_speed(&mut self, speed: Scaled);
    /// Its square.
    #[cfg_attr(any(), micro(place = "TEMP+4"))]
    fn next_speed2(&self) -> Scaled;
    /// See [`Segments::next_speed2`].
    #[cfg_attr(any(), micro(place = "TEMP+4"))]
    fn set_next_speed2(&mut self, square: Scaled);
    /// It bounds that; which is then the smaller one.
    #[cfg_attr(any(), micro(code = "F bound TEMP+4"))]
    fn least_next_speed2(&mut self, square: Scaled) -> Scaled;
    /// Sum of the speeds at both ends.
    #[cfg_attr(any(), micro(place = "TEMP+8"))]
    fn sum(&self) -> Scaled;
    /// See [`Segments::sum`].
    #[cfg_attr(any(), micro(place = "TEMP+8"))]
    fn set_sum(&mut self, sum: Scaled);
    /// Keeps the sign of how far two squares lie apart: not 0 unless that is.
    #[cfg_attr(any(), micro(code = "DO segment_sign"))]
    fn keep_sign(&mut self, gap: i32) -> i32;
    /// The kept sign says that the speed is below the goal.
    #[cfg_attr(any(), micro(code = "", holds = "NEGATIVE"))]
    fn is_slow(&self) -> bool;
    /// Events of 4 to 8 ms at a constant speed, by how far interval and speed lie apart.
    #[cfg_attr(any(), micro(code = "CALL segment_by_time"))]
    fn events_by_time(&mut self, gap: i32);
    /// Twice as many events from now the brake has not begun, by what the square may rise until then.
    #[cfg_attr(any(), micro(code = "CALL segment_cruises", holds = "CARRY"))]
    fn cruises(&self, rise: Scaled) -> bool;
    /// Half as many, and no more than change the speed by about 1/32, but 1 to 2 ms: by how far the ramp and the square
    /// lie apart.
    #[cfg_attr(any(), micro(code = "CALL segment_by_speed"))]
    fn events_by_speed(&mut self, gap: i32);
    /// The segment takes them of what is left, or all of that where little more is.
    #[cfg_attr(any(), micro(code = "CALL segment_take"))]
    fn take_events(&mut self) -> Scaled;
    /// Makes sub-events of them where intervals are long, by how far sum and tick lie apart. The slot's numbers are there
    /// from now on, the goal is not.
    #[cfg_attr(any(), micro(code = "CALL segment_divide"))]
    fn divide(&mut self, gap: i32);
    /// A number of ticks in the unit of intervals, 1/65536 of one.
    #[cfg_attr(any(), micro(code = "DO segment_scale"))]
    fn units(&self, ticks: Scaled) -> i32;
    /// The slot's interval, while it is the speed that it is made of.
    #[cfg_attr(any(), micro(place = "SLOT0, AXIS"))]
    fn fastest(&self) -> Scaled;
    /// See [`Segments::fastest`].
    #[cfg_attr(any(), micro(place = "SLOT0, AXIS"))]
    fn set_fastest(&mut self, speed: Scaled);
    /// The slot's first interval.
    #[cfg_attr(any(), micro(place = "SLOT0, AXIS"))]
    fn interval(&self) -> i32;
    /// See [`Segments::interval`].
    #[cfg_attr(any(), micro(place = "SLOT0, AXIS"))]
    fn set_interval(&mut self, interval: i32);
    /// What an interval is longer by than the one before.
    #[cfg_attr(any(), micro(place = "SLOT0+CHANGE, AXIS"))]
    fn set_dif(&mut self, change: i32);
    /// That, of what the mean interval is longer by than the shortest.
    #[cfg_attr(any(), micro(code = "CALL segment_change"))]
    fn dif_of(&mut self, longer: i32) -> i32;
    /// Half of that, and of a speed that rises the whole: what the first interval is longer by than the shortest.
    #[cfg_attr(any(), micro(code = "CALL segment_half"))]
    fn first_of(&self, change: i32) -> i32;
    /// The slot is filled.
    #[cfg_attr(
        any(),
        micro(code = "", holds = "CARRY", ends = "mov r5, SLOT0+EVENTS(r6); setc; ret")
    )]
    fn fill(&mut self) -> bool;
}

/// Fills the empty slot; not so when nothing is left, or while braking at a speed no higher than the start rate. 7 000 cycles at
/// the most.
///
/// As many events as last 4 to 8 ms at a constant speed, on a ramp half as many or fewer. The new v^2 is that after so
/// many events of ramp toward the goal, but no more than the events that are left can brake from.
#[cfg_attr(any(), micro(entry = "segment", begins = "clr r8", holds = "CARRY"))]
pub fn segment(m: &mut impl Segments) -> bool {
    if m.left() == 0 {
        return false;
    }
    if m.brakes() {
        m.aim_at_rest();
        if m.start2() >= m.end_speed2() {
            return false;
        }
    }
    m.events_by_time(m.tick().gap(m.end_speed()));
    let gap = m.end_speed2().gap(m.goal2());
    if m.keep_sign(gap) != 0
        || !m.cruises(Scaled::new(m.left() as u32).times(m.decel2()).minus(m.end_speed2()))
    {
        // But behind the last segments of a line that ends at speed the next one is planned, which takes time.
        if !m.ends_at_speed() {
            m.events_by_speed(m.accel2().most(m.decel2()).gap(m.end_speed2()));
        }
    }
    let events = m.take_events();
    if m.is_slow() {
        m.set_next_speed2(events.times(m.accel2()).plus(m.end_speed2()).least(m.goal2()));
    } else {
        m.set_next_speed2(events.times(m.decel2()));
        m.set_next_speed2(m.end_speed2().minus(m.next_speed2()).most(m.goal2()));
    }
    let brake = Scaled::new(m.left() as u32).times(m.decel2());
    let most = if m.ends_at_speed() { brake.plus(m.exit2()) } else { brake.plus(m.start2()) };
    let next = m.least_next_speed2(most).root();
    m.set_next_speed(next);
    m.set_sum(next.plus(m.end_speed()));
    m.divide(m.sum().gap(m.tick()));
    shape(m)
}

/// The slot's intervals, from the speeds at both ends: `tick / v` at the faster end, and twice `tick / (v0 + v1)` in the
/// mean, which is what constant acceleration takes. The intervals lie on the line through both.
#[cfg_attr(any(), micro(holds = "CARRY"))]
fn shape(m: &mut impl Segments) -> bool {
    // At the faster end.
    m.set_fastest(m.end_speed().most(m.next_speed()));
    m.set_interval(m.units(m.tick().over(m.fastest())));
    let gap = m.next_speed2().gap(m.end_speed2());
    if m.keep_sign(gap) == 0 {
        m.set_dif(0);
    } else {
        // The speed changes: twice what the mean interval is longer by.
        let mean = m.units(m.tick().over(m.sum()).shifted(1));
        let change = m.dif_of(mean.wrapping_sub(m.interval()).max(0));
        m.set_dif(change);
        let first = m.first_of(change);
        m.set_interval(m.interval().wrapping_add(first));
    }
    m.set_end_speed(m.next_speed());
    m.set_end_speed2(m.next_speed2());
    m.fill()
}
