//! Interpolated motion: blocks in, segments for three axes out.
//!
//! Path units are micrometres, so feeds, corners and arcs do not depend on the axes' steps per
//! millimetre; a block's events are the steps of its axis with most steps. The other axes follow
//! by `acc += inc` with the carry as the step, `inc = steps * 2^32 / events` and `acc` starting at
//! one half: each stays within half a step of the ideal line and all arrive together.
//!
//! One block ahead of the playing one is known. The speed at the corner between them is the
//! largest of which the deviation of an inscribed arc stays within the profile's corner
//! tolerance (junction deviation), with which the next block can still come to rest, and that
//! neither block's feed forbids.

use super::arc::{Arc, Walk};
use super::math::{fraction, largest, signed, size};
use super::ramp::{Limits, Run, Segment};
use super::scaled::Scaled;
use lang::record::AxisRecord;

/// How fast a block may go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feed {
    /// As fast as every axis can.
    Rapid,
    /// um/s along the path.
    Um(u32),
    /// steps/s along the path.
    Steps(u32),
}

/// An interpolated move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    /// Distance of each axis, steps.
    pub steps: [i32; 3],
    /// Its speed.
    pub feed: Feed,
    /// Come to rest at the end (G61).
    pub exact: bool,
}

/// A segment with what the engine's three accumulators need.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct PathSegment {
    /// Events and intervals.
    pub ramp: Segment,
    /// Added to each axis's accumulator at each event; a carry is a step.
    pub inc: [u32; 3],
    /// Upper halves of the accumulators at the beginning of a block; the lower ones are 0.
    pub acc: [u16; 3],
    /// Bit n: axis n moves in negative direction.
    pub negative: u8,
    /// Set the accumulators first: a line or a chord begins.
    pub begin: bool,
    /// A chord of an arc after its first one: no new block.
    pub within: bool,
}

impl PathSegment {
    /// Plays the segment's first `events` events (at most [`Segment::steps`]) on accumulators and
    /// positions, steps.
    pub fn played(&self, events: u16, acc: &mut [u32; 3], position: &mut [i32; 3]) {
        for axis in 0..3 {
            let from = if self.begin { u32::from(self.acc[axis]) << 16 } else { acc[axis] };
            let sum = u64::from(from) + u64::from(self.inc[axis]) * u64::from(events);
            acc[axis] = sum as u32;
            let steps = (sum >> 32) as i32;
            position[axis] += if self.negative >> axis & 1 != 0 { -steps } else { steps };
        }
    }
}

/// Where the accumulators of a line begin: one half.
const HALF: u16 = 1 << 15;

/// What follows from a block's shape, in um, um/s, um/s2.
#[derive(Clone, Copy, Debug)]
struct Geometry {
    length: Scaled,
    start: Scaled,
    top: Scaled,
    accel: Scaled,
    decel: Scaled,
    feed: Scaled,
    /// Direction at its beginning, 32768 is 1.
    unit: [i16; 3],
}

/// A block that waits, or one that plays.
#[derive(Clone, Copy, Debug)]
enum Shape {
    Line([i32; 3]),
    Arc(Arc),
}

/// The block that waits.
#[derive(Clone, Copy, Debug)]
struct Next {
    shape: Shape,
    geometry: Geometry,
    rapid: bool,
    exact: bool,
}

/// The planner of interpolated motion.
#[derive(Clone, Copy, Debug)]
pub struct Path {
    run: Run,
    limits: Limits,
    /// Square of the speed at the end of the block.
    exit2: Scaled,
    /// Ramps of the block, um/s2.
    accel: Scaled,
    decel: Scaled,
    /// Programmed speed of the block, um/s.
    feed: Scaled,
    /// Its axes' top, um/s.
    top: Scaled,
    /// Direction at its end.
    unit: [i16; 3],
    /// Increments, accumulators and directions of the line or chord that plays.
    inc: [u32; 3],
    acc: [u16; 3],
    negative: u8,
    active: bool,
    begin: bool,
    within: bool,
    exact: bool,
    paused: bool,
    /// Percent of the programmed speed: of feeds 10..=200, of rapid moves 10..=100.
    percents: [u8; 2],
    /// The block is a rapid move.
    rapid: bool,
    /// Corner tolerance, um.
    corner: u16,
    walk: Option<Walk>,
    /// Length of each of its chords, um.
    stride: Scaled,
    next: Option<Next>,
}

impl Path {
    /// Nothing to do, no corner tolerance.
    pub const IDLE: Path = Path {
        run: Run::NONE,
        limits: Limits::NONE,
        exit2: Scaled::ZERO,
        accel: Scaled::ZERO,
        decel: Scaled::ZERO,
        feed: Scaled::ZERO,
        top: Scaled::ZERO,
        unit: [0; 3],
        inc: [0; 3],
        acc: [0; 3],
        negative: 0,
        active: false,
        begin: false,
        within: false,
        exact: true,
        paused: false,
        percents: [100; 2],
        rapid: false,
        corner: 0,
        walk: None,
        stride: Scaled::ZERO,
        next: None,
    };

    /// An idle path that may leave a corner by `corner` um.
    pub fn new(corner: u16) -> Path {
        Path { corner, ..Path::IDLE }
    }

    /// A new run begins with an empty path that may leave a corner by `corner` um.
    pub fn begin(&mut self, corner: u16) {
        self.clear();
        self.corner = corner;
    }

    /// Takes a line; `false` when a block is waiting already: offer it again later. A block without
    /// any step is taken and forgotten.
    pub fn push(&mut self, axes: &[AxisRecord; 3], block: &Block) -> bool {
        let shape = Shape::Line(block.steps);
        block.steps == [0; 3] || self.append(axes, shape, block.feed, block.exact)
    }

    /// Takes an arc, as [`Path::push`] a line.
    pub fn push_arc(&mut self, axes: &[AxisRecord; 3], arc: &Arc, feed: Feed, exact: bool) -> bool {
        self.append(axes, Shape::Arc(*arc), feed, exact)
    }

    fn append(&mut self, axes: &[AxisRecord; 3], shape: Shape, feed: Feed, exact: bool) -> bool {
        if self.next.is_some() {
            return false;
        }
        let geometry = geometry(axes, &shape, feed);
        if self.active && !self.exact {
            self.join(&geometry);
        }
        let rapid = matches!(feed, Feed::Rapid);
        self.next = Some(Next { shape, geometry, rapid, exact });
        true
    }

    /// Whether another block would be taken.
    pub fn has_room(&self) -> bool {
        self.next.is_none()
    }

    /// Whether every block has been handed out as segments.
    pub fn is_idle(&self) -> bool {
        !self.active && self.next.is_none()
    }

    /// Ramps down to a pause (`true`), or goes on with the rest.
    pub fn pause(&mut self, on: bool) {
        self.paused = on;
    }

    /// Whether a pause has been reached.
    pub fn is_paused(&self) -> bool {
        self.paused && (!self.active || self.run.v2 <= self.limits.start2)
    }

    /// Forgets the rest of the path; for a stop, when [`Path::is_paused`].
    pub fn clear(&mut self) {
        self.active = false;
        self.next = None;
        self.paused = false;
    }

    /// Speed override: 10 to 200 percent of each block's feed, 10 to 100 percent of a rapid move's
    /// speed, never above what the axes can.
    pub fn set_override(&mut self, feed: u8, rapid: u8) {
        self.percents = [feed.clamp(10, 200), rapid.clamp(10, 100)];
        self.set_nominal();
    }

    /// Speed along the path at the end of the last segment handed out, um/s.
    pub fn velocity(&self) -> u32 {
        if self.active { self.run.v2.root().floor() } else { 0 }
    }

    /// Puts the next segment into `segment`, which must hold the one before: increments and
    /// directions are only written when a line or chord begins. `false` when idle or in a pause.
    pub fn next_segment(&mut self, axes: &[AxisRecord; 3], segment: &mut PathSegment) -> bool {
        if !self.active {
            self.run.v2 = Scaled::ZERO;
            self.activate(axes);
        }
        if !self.active || !self.run.segment(&self.limits, self.paused, &mut segment.ramp) {
            return false;
        }
        segment.begin = self.begin;
        if self.begin {
            self.begin = false;
            segment.within = self.within;
            segment.inc = self.inc;
            segment.acc = self.acc;
            segment.negative = self.negative;
        }
        if self.run.left == 0 {
            self.within = true;
            self.active = self.chord(axes);
            if !self.active {
                if self.exact {
                    self.run.v2 = Scaled::ZERO;
                }
                self.activate(axes);
            }
        }
        true
    }

    /// Makes the waiting block the playing one, entered at the present speed but at least its
    /// start rate.
    fn activate(&mut self, axes: &[AxisRecord; 3]) {
        let Some(next) = self.next.take() else { return };
        let g = &next.geometry;
        self.active = true;
        self.within = false;
        self.exact = next.exact;
        self.rapid = next.rapid;
        self.feed = g.feed;
        self.top = g.top;
        self.accel = g.accel;
        self.decel = g.decel;
        self.unit = g.unit;
        self.limits.start2 = g.start.times(g.start);
        self.exit2 = self.limits.start2;
        self.set_nominal();
        self.run.v2 = self.run.v2.most(self.limits.start2.least(self.limits.nominal2));
        match next.shape {
            Shape::Line(steps) => {
                let events = largest(&steps);
                self.negative = 0;
                for axis in 0..3 {
                    let steps = steps[axis];
                    self.inc[axis] = fraction(size(steps), events);
                    self.acc[axis] = HALF;
                    self.negative |= u8::from(steps < 0) << axis;
                }
                self.run.left = events;
                self.begin = true;
                self.limits.exit2 = self.exit2;
                let pitch = g.length.over(Scaled::new(events));
                self.limits.set_pitch(pitch, g.accel, g.decel);
                self.walk = None;
            }
            Shape::Arc(arc) => {
                self.unit = tangent(&arc, g.length, true);
                let walk = Walk::new(axes, &arc);
                self.stride = g.length.over(Scaled::new(walk.chords().into()));
                self.walk = Some(walk);
                self.active = self.chord(axes);
            }
        }
    }

    /// Begins the next chord of an arc; `false` when there is none.
    fn chord(&mut self, axes: &[AxisRecord; 3]) -> bool {
        let Some(walk) = &mut self.walk else { return false };
        let Some(chord) = walk.next(axes) else {
            self.walk = None;
            return false;
        };
        let mut sum = Scaled::ZERO;
        self.negative = 0;
        for (axis, delta) in chord.delta.iter().enumerate() {
            let um = to_um(&axes[axis], Scaled::size(*delta));
            sum = sum.plus(um.times(um));
            self.negative |= u8::from(*delta < 0) << axis;
        }
        let length = sum.root().shifted(-12);
        self.inc = chord.inc;
        self.acc = chord.acc;
        self.begin = true;
        self.run.left = chord.events;
        let pitch = length.over(chord.span());
        self.limits.set_pitch(pitch, self.accel, self.decel);
        // What can be braked over the chords that follow, of which the whole steps of this one take a
        // part or leave one.
        let rest = self.stride.over(pitch).times(Scaled::new(chord.after.into()));
        let rest = rest.plus(chord.span()).minus(Scaled::new(chord.events));
        self.limits.exit2 = self.exit2.plus(self.limits.decel2.times(rest));
        true
    }

    /// The playing block's speed under the override.
    fn set_nominal(&mut self) {
        let percent = Scaled::new(self.percents[usize::from(self.rapid)].into()).over(HUNDRED);
        let nominal = self.feed.times(percent).least(self.top);
        self.limits.nominal2 = nominal.times(nominal);
    }

    /// Raises the speed at the end of the playing block to that of the corner into `next`.
    fn join(&mut self, next: &Geometry) {
        // Half the difference of the unit vectors is the sine q of half the deflection, c its
        // cosine; junction deviation: v^2 = a delta c / (1 - c) = a delta c (1 + c) / q^2.
        let mut turn = Scaled::ZERO;
        for axis in 0..3 {
            let d = Scaled::size(i32::from(self.unit[axis]) - i32::from(next.unit[axis]));
            turn = turn.plus(d.times(d));
        }
        let q2 = turn.shifted(-32);
        let c = ONE.minus(q2).root();
        let smooth = next.accel.least(next.decel).times(Scaled::new(self.corner.into()));
        let smooth = smooth.times(c).times(ONE.plus(c));
        // What the axes may jump by anyway: their start rate.
        let start2 = next.start.times(next.start);
        let corner = smooth.most(start2.shifted(-2)).over(q2);
        // What the next block can brake from, on the ramp that it will be given (`Limits::set_pitch`).
        let ramp = next.decel.times(next.length).shifted(1);
        let reach = start2.plus(ramp.minus(ramp.shifted(-5)));
        // What lasts as long as the block after it takes to plan.
        let feed = self.feed.least(next.feed).least(next.length.times(BLOCKS));
        let exit2 = corner.least(reach).least(feed.times(feed));
        let gain = exit2.minus(self.exit2);
        self.limits.exit2 = self.limits.exit2.plus(gain);
        self.exit2 = self.exit2.plus(gain);
    }
}

/// 1
const ONE: Scaled = Scaled::constant(1);
/// Blocks a second that the board's main loop can plan while it steps and answers.
const BLOCKS: Scaled = Scaled::constant(200);
/// The same for chords, 285 a second: 0.8 times its square.
const CHORDS: Scaled = Scaled::constant(64_980);
/// 100
const HUNDRED: Scaled = Scaled::constant(100);
/// 2^32 to a turn: one part in radians.
const RADIAN: Scaled = Scaled::constant(0xC90F_DAA2).shift(-61);

/// A distance or rate of an axis in steps as one in um.
fn to_um(axis: &AxisRecord, steps: Scaled) -> Scaled {
    steps.times(Scaled::new(axis.um.into())).over(Scaled::new(axis.steps.into()))
}

/// Direction of an arc of some length along its helix, at its beginning or end.
fn tangent(arc: &Arc, length: Scaled, at_end: bool) -> [i16; 3] {
    let mut unit = [0; 3];
    let plane = arc.radius.times(Scaled::new(arc.sweep)).times(RADIAN).over(length);
    let part = |of: i16, part: Scaled| {
        let size = part.times(Scaled::size(of.into())).floor().min(0x7FFF);
        signed(size as i32, of.into()) as i16
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
        start: Scaled::MAX,
        top: Scaled::MAX,
        accel: Scaled::MAX,
        decel: Scaled::MAX,
        feed: Scaled::MAX,
        unit: [0; 3],
    };

    /// Lowers the limits to those of an axis that moves by one step in `along` um of path.
    fn limit(&mut self, axis: &AxisRecord, along: Scaled) {
        self.start = self.start.least(along.times(Scaled::new(axis.start_rate.max(1).into())));
        self.top = self.top.least(along.times(Scaled::new(axis.top_rate)));
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
}

/// Length, direction and limits along the path of a block.
fn geometry(axes: &[AxisRecord; 3], shape: &Shape, feed: Feed) -> Geometry {
    let mut g = Geometry::NONE;
    match shape {
        Shape::Line(steps) => {
            let mut um = [Scaled::ZERO; 3];
            let mut sum = Scaled::ZERO;
            let mut in_steps = Scaled::ZERO;
            for a in 0..3 {
                let steps = Scaled::size(steps[a]);
                um[a] = to_um(&axes[a], steps);
                sum = sum.plus(um[a].times(um[a]));
                in_steps = in_steps.plus(steps.times(steps));
            }
            g.length = sum.root();
            for a in 0..3 {
                if steps[a] == 0 {
                    continue;
                }
                g.limit(&axes[a], g.length.over(Scaled::size(steps[a])));
                let unit = um[a].over(g.length).shifted(15).floor().min(0x7FFF);
                g.unit[a] = signed(unit as i32, steps[a]) as i16;
            }
            g.feed(feed, in_steps.root());
        }
        Shape::Arc(arc) => {
            let [a, b, c] = arc.axes();
            let plane = arc.radius.times(Scaled::new(arc.sweep)).times(RADIAN);
            let rise = Scaled::size(arc.end[c].wrapping_sub(arc.start[c]));
            let rise_um = to_um(&axes[c], rise);
            g.length = plane.times(plane).plus(rise_um.times(rise_um)).root();
            // Each axis of the plane carries the whole speed somewhere.
            g.limit(&axes[a], to_um(&axes[a], ONE));
            g.limit(&axes[b], to_um(&axes[b], ONE));
            // The ramp must also hold the arc: v^2 / r, and a chord must last as long as the next one
            // takes to plan. Its square is 0.8 r steps (0.1 steps of sagitta).
            let per_step = to_um(&axes[a], ONE).least(to_um(&axes[b], ONE));
            let bend = g.accel.least(g.decel).least(per_step.times(CHORDS));
            g.top = g.top.least(bend.times(arc.radius).root());
            if rise.0 != 0 {
                g.limit(&axes[c], g.length.over(rise));
            }
            g.unit = tangent(arc, g.length, false);
            g.feed(feed, g.length.over(per_step));
        }
    }
    g
}
