//! What follows from a block's shape: its length and direction, its limits along the path, and how fast
//! the corner in front of it may be passed.

use super::block::Feed;
use crate::motion::arc::Arc;
use crate::motion::math::{largest, signed, size};
use crate::motion::scaled::Scaled;
use lang::part::PATH_RATE;
use lang::record::AxisRecord;

/// A block's shape.
#[derive(Clone, Copy, Debug)]
pub enum Shape<'a> {
    /// A line of so many steps of each axis, with the same in um as [`super::block::Block::um`].
    Line(&'a [i32; 3], &'a [i32; 3]),
    /// An arc.
    Arc(&'a Arc),
}

/// A distance or rate of an axis in steps as one in um.
pub fn to_um(axis: &AxisRecord, steps: Scaled) -> Scaled {
    let um = steps.times(Scaled::new(axis.um.into()));
    // Most machines have steps of whole um, and a quotient takes as long as ten products.
    if axis.steps == 1 { um } else { um.over(Scaled::new(axis.steps.into())) }
}

/// In um, um/s, um/s2.
#[derive(Clone, Copy, Debug)]
pub struct Geometry {
    /// Length along the path.
    pub length: Scaled,
    /// Of a line the part of it that belongs to a step of the axis with most steps.
    pub pitch: Scaled,
    /// Speed at which it may begin and end at rest.
    pub start: Scaled,
    /// The most that its axes can.
    pub top: Scaled,
    /// Ramp up.
    pub accel: Scaled,
    /// Ramp down.
    pub decel: Scaled,
    /// Programmed speed, at most `top`.
    pub feed: Scaled,
    /// Steps of the axis with most steps, of an arc of one of its plane.
    pub events: Scaled,
    /// Direction at its beginning, [`UNIT`] is 1.
    pub unit: [i32; 3],
}

/// What the corner behind a block follows from.
#[derive(Clone, Copy, Debug)]
pub struct Tail {
    /// The block's length, um.
    pub length: Scaled,
    /// Its speed as far as an override makes it higher, um/s.
    pub fast: Scaled,
    /// Direction at its end, [`UNIT`] is 1.
    pub unit: [i32; 3],
}

/// 1
const ONE: Scaled = Scaled::constant(1);
/// 1 of a direction: 2 to this. A step of one axis may be thousands of another's long, and that other one's
/// part of the direction must still have bits to spare.
const UNIT: i8 = 29;
/// The highest part of a direction.
const WHOLE: u32 = (1 << UNIT) - 1;
/// Bits of [`UNIT`] below those of an arc's tangent.
const BELOW: i8 = UNIT - 15;
/// us in a second.
const MILLION: Scaled = Scaled::constant(1_000_000);
/// us that the board's main loop takes for a block: its statement, its plan, its first segment, with the link and the
/// milliseconds between them. Where a statement takes longer, the path knows less and slows down by itself.
const PLANNING: Scaled = Scaled::constant(900);
/// The same for a chord of an arc.
const CHORD: Scaled = Scaled::constant(900);
/// us that an event's interrupt takes from the main loop: 212 cycles.
const EVENT: Scaled = Scaled::constant(9);
/// The square of a chord's steps is 0.8 times the radius in steps: 0.1 steps of sagitta.
const SAGITTA: Scaled = Scaled::constant(0xCCCC_CCCD).shift(-32);
/// 2^32 to a turn: one part in radians.
const RADIAN: Scaled = Scaled::constant(0xC90F_DAA2).shift(-61);

/// Whether an axis of a line is bounded by another one: with the same scale and rates that one makes more steps.
fn is_within(axes: &[AxisRecord; 3], steps: &[i32; 3], n: usize) -> bool {
    let (own, way) = (&axes[n], size(steps[n]));
    for other in 0..3 {
        let more = size(steps[other]);
        let axis = &axes[other];
        if (more > way || more == way && other < n)
            && axis.steps == own.steps
            && axis.um == own.um
            && axis.accel == own.accel
            && axis.decel == own.decel
            && axis.top_rate == own.top_rate
            && axis.start_rate == own.start_rate
        {
            return true;
        }
    }
    false
}

/// Direction of an arc of some length along its helix, at its beginning or end.
pub fn tangent(arc: &Arc, length: Scaled, at_end: bool) -> [i32; 3] {
    let mut unit = [0; 3];
    let plane = arc.radius.times(Scaled::new(arc.sweep)).times(RADIAN).over(length);
    let part = |of: i16, part: Scaled| {
        let size = part.times(Scaled::size(of.into())).shifted(BELOW).floor().min(WHOLE);
        signed(size as i32, of.into())
    };
    let [a, b, c] = arc.axes();
    let [x, y] = arc.tangent(at_end);
    unit[a] = part(x, plane);
    unit[b] = part(y, plane);
    let rise = arc.end[c].wrapping_sub(arc.start[c]);
    let along = ONE.minus(plane.times(plane)).root();
    unit[c] = part(if rise < 0 { -0x7FFF } else { 0x7FFF }, along);
    unit
}

impl Geometry {
    const NONE: Geometry = Geometry {
        length: Scaled::ZERO,
        pitch: Scaled::MAX,
        start: Scaled::MAX,
        top: Scaled::MAX,
        accel: Scaled::MAX,
        decel: Scaled::MAX,
        feed: Scaled::MAX,
        events: Scaled::ZERO,
        unit: [0; 3],
    };

    /// Of a block with any step.
    pub fn of(axes: &[AxisRecord; 3], shape: &Shape, feed: Feed) -> Geometry {
        let mut g = Geometry::NONE;
        match shape {
            Shape::Line(steps, way) => g.line(axes, steps, way, feed),
            Shape::Arc(arc) => g.arc(axes, arc, feed),
        }
        g
    }

    /// The geometry of a line of so many `steps`, commanded as `way`, um.
    ///
    /// Length: the root of the sum of squares of the axes' ways, um. An axis that makes `n` of `length` um in steps moves one
    /// step in `length / n` um of path. Its limits in steps, times that, are limits along the path; the lowest of
    /// all axes holds, as in grbl's `limit_value_by_axis_maximum`. [`is_within`] leaves out axes that cannot be the lowest.
    fn line(&mut self, axes: &[AxisRecord; 3], steps: &[i32; 3], way: &[i32; 3], feed: Feed) {
        let mut sum = Scaled::ZERO;
        let mut parts = [Scaled::ZERO; 3];
        let commanded = way[0] | way[1] | way[2] != 0;
        let most = largest(steps);
        for a in 0..3 {
            // Of the axis with most steps they are the way. Beside it one step may be longer than the whole line: its
            // commanded way keeps the other axes at their speed.
            let um = if commanded && size(steps[a]) < most {
                Scaled::size(way[a])
            } else if steps[a] != 0 {
                to_um(&axes[a], Scaled::size(steps[a]))
            } else {
                continue;
            };
            sum = sum.plus(um.times(um));
            parts[a] = um;
        }
        self.length = sum.root();
        let (mut signs, mut long) = (steps, self.length);
        if commanded {
            signs = way;
            long = Scaled::squares(way).root();
            parts = way.map(Scaled::size);
        }
        let long = ONE.shifted(UNIT).over(long);
        self.events = Scaled::new(most);
        for a in 0..3 {
            if steps[a] != 0 && !is_within(axes, steps, a) {
                let along = self.length.over(Scaled::size(steps[a]));
                self.pitch = self.pitch.least(along);
                self.limit(&axes[a], along);
            }
            let unit = parts[a].times(long).floor().min(WHOLE);
            self.unit[a] = signed(unit as i32, signs[a]);
        }
        let mut in_steps = Scaled::ZERO;
        if let Feed::Steps(_) = feed {
            in_steps = Scaled::squares(steps).root();
        }
        self.feed(feed, in_steps);
    }

    /// The geometry of an arc or helix: length `sqrt((r angle)^2 + rise^2)`, um.
    ///
    /// Two more limits than a line has. Going round needs the acceleration `v^2 / r` toward the centre, so `v^2 <= a r`. And
    /// the arc is played in chords, each of which must last until the next one is planned. A chord of `c` steps leaves a
    /// circle of `r` steps by `c^2 / (8 r)` (its sagitta); 0.1 steps of that give `c^2 = 0.8 r`. Planning it takes CHORD us
    /// and EVENT us for each of its step interrupts, hence `v <= c * per_step / (c * EVENT + CHORD)`.
    fn arc(&mut self, axes: &[AxisRecord; 3], arc: &Arc, feed: Feed) {
        let [a, b, c] = arc.axes();
        let plane = arc.radius.times(Scaled::new(arc.sweep)).times(RADIAN);
        let rise = Scaled::size(arc.end[c].wrapping_sub(arc.start[c]));
        let rise_um = to_um(&axes[c], rise);
        self.length = plane.times(plane).plus(rise_um.times(rise_um)).root();
        // Each axis of the plane carries the whole speed somewhere.
        let (step_a, step_b) = (to_um(&axes[a], ONE), to_um(&axes[b], ONE));
        self.limit(&axes[a], step_a);
        self.limit(&axes[b], step_b);
        // The ramp must also hold the arc: v^2 / r, and a chord must last as long as the next one takes to plan.
        let per_step = step_a.least(step_b);
        let bend = self.ramp().times(arc.radius).root();
        let events = arc.radius.over(per_step).times(SAGITTA).root();
        let planned = events.times(per_step).times(MILLION).over(events.times(EVENT).plus(CHORD));
        self.top = self.top.least(bend).least(planned);
        if rise.0 != 0 {
            self.limit(&axes[c], self.length.over(rise));
        }
        self.events = self.length.over(per_step);
        self.unit = tangent(arc, self.length, false);
        self.feed(feed, self.events);
    }

    /// Lowers the limits to those of an axis that moves by one step in `along` um of path.
    fn limit(&mut self, axis: &AxisRecord, along: Scaled) {
        self.start = self.start.least(along.times(Scaled::new(axis.start_rate.max(1).into())));
        self.top = self.top.least(along.times(Scaled::new(axis.top_rate.min(PATH_RATE))));
        self.accel = self.accel.least(along.times(Scaled::new(axis.accel)));
        self.decel = self.decel.least(along.times(Scaled::new(axis.decel)));
    }

    /// Lowers the speed to a feed; the path is `steps` steps long.
    fn feed(&mut self, feed: Feed, steps: Scaled) {
        let feed = match feed {
            Feed::Rapid => self.top,
            Feed::Um(feed) => Scaled::new(feed.max(1)),
            Feed::Steps(feed) => Scaled::new(feed.max(1)).times(self.length).over(steps),
        };
        self.feed = self.feed.least(feed).least(self.top);
    }

    /// What it can do to change its direction, um/s2.
    pub fn ramp(&self) -> Scaled {
        self.accel.least(self.decel)
    }

    /// Square of the speed from which and to which it may jump.
    pub fn start2(&self) -> Scaled {
        self.start.times(self.start)
    }

    /// Square of the speed at which it may follow another block, itself as `fast` as that: by the corner between them,
    /// from which the path may stay away `corner` um on the lower of both ramps and of that with which the axes turn,
    /// by both lengths and speeds, and by what the chip needs to plan it. Not by what can be braked over.
    ///
    /// Junction deviation, as in grbl (`planner.c`) and Klipper (`toolhead.py`): an arc is laid into the corner that touches
    /// both lines and passes the corner point at the distance `corner`, um. With the deflection `t` between the lines
    /// and `c = cos(t / 2)` its radius is `corner * c / (1 - c)`, and `v^2 = ramp * radius` holds the arc. The axes do not follow
    /// that arc; it only says how fast the corner itself may be taken.
    ///
    /// A second arc touches both lines in the middle of the shorter one: radius `length / 2 / tan(t / 2)`. Without it the
    /// chords of a curve, whose deflection shrinks with their length, could be passed faster than the curve (Klipper's
    /// centripetal limit). The lower of both holds.
    pub fn corner2(
        &self,
        axes: &[AxisRecord; 3],
        before: &Tail,
        ramp: Scaled,
        fast: Scaled,
        corner: u16,
    ) -> Scaled {
        // Half the difference of the unit vectors is the sine q of half the deflection, c its
        // cosine; junction deviation: v^2 = a delta c / (1 - c) = a delta c (1 + c) / q^2.
        let mut turn = [0; 3];
        for (n, turn) in turn.iter_mut().enumerate() {
            *turn = before.unit[n] - self.unit[n];
        }
        let turn2 = Scaled::squares(&turn);
        // It must last as long as the block after it takes to plan.
        let time = self.events.times(EVENT).plus(PLANNING);
        let mut feed = before.fast.least(fast);
        let way = self.length.times(MILLION);
        if feed.times(time) > way {
            feed = way.over(time);
        }
        let feed2 = feed.times(feed);
        if turn2 == Scaled::ZERO {
            return feed2;
        }
        let q2 = turn2.shifted(-2 * UNIT - 2);
        let size = turn2.root();
        // The path bends to the side, where an axis may have to do much that hardly moves along it: as on a line that
        // goes there.
        let (mut ramp, mut start) = (ramp, Scaled::MAX);
        for n in 0..3 {
            // The change of velocity at the corner is `turn * v`: axis n has `turn[n] / size` of it.
            if turn[n] != 0 && !is_within(axes, &turn, n) {
                let axis = &axes[n];
                let along = to_um(axis, size.over(Scaled::size(turn[n])));
                ramp = ramp.least(along.times(Scaled::new(axis.accel.min(axis.decel))));
                start = start.least(along.times(Scaled::new(axis.start_rate.max(1).into())));
            }
        }
        let c = ONE.minus(q2).root();
        let ramp = ramp.times(c);
        let smooth = ramp.times(Scaled::new(corner.into())).times(ONE.plus(c));
        // What the axes may jump by anyway: their start rate. The jump is 2 q v, so v^2 = start^2 / (4 q^2).
        let corner = smooth.most(start.times(start).shifted(-2));
        // The arc that touches both blocks, in the middle of the shorter one, has a radius of half of its
        // length by the tangent: without this bound chords might be the faster the shorter they are.
        let q = size.shifted(-UNIT - 1);
        let bend = ramp.times(before.length.least(self.length)).times(q).shifted(-1);
        corner.least(bend).over(q2).least(feed2)
    }
}
