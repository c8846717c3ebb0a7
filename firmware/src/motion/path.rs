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

use super::math::fraction;
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
    /// Bit n: axis n moves in negative direction.
    pub negative: u8,
    /// Set the accumulators to one half first: a new block begins.
    pub begin: bool,
}

/// One half, where the accumulators begin.
pub const HALF: u32 = 1 << 31;

impl PathSegment {
    /// Plays the segment's first `events` events (at most [`Segment::steps`]) on accumulators and
    /// positions, steps.
    pub fn played(&self, events: u16, acc: &mut [u32; 3], position: &mut [i32; 3]) {
        for axis in 0..3 {
            let from = if self.begin { HALF } else { acc[axis] };
            let sum = u64::from(from) + u64::from(self.inc[axis]) * u64::from(events);
            acc[axis] = sum as u32;
            let steps = (sum >> 32) as i32;
            position[axis] += if self.negative >> axis & 1 != 0 { -steps } else { steps };
        }
    }
}

/// What follows from a block's distances, in um, um/s, um/s2.
struct Geometry {
    events: u32,
    length: Scaled,
    start: Scaled,
    top: Scaled,
    accel: Scaled,
    decel: Scaled,
    feed: Scaled,
    /// Direction, 32768 is 1.
    unit: [i16; 3],
}

/// The planner of interpolated motion.
#[derive(Clone, Copy, Debug)]
pub struct Path {
    run: Run,
    limits: Limits,
    /// Direction at the end of the playing block.
    unit: [i16; 3],
    /// Programmed speed of the playing block, um/s.
    feed: Scaled,
    /// Its axes' top, um/s.
    top: Scaled,
    active: bool,
    begin: bool,
    exact: bool,
    paused: bool,
    /// Percent of the programmed speed, 10..=200.
    percent: u8,
    /// Corner tolerance, um.
    corner: u16,
    /// Distances of the playing block.
    steps: [i32; 3],
    next: Option<Block>,
}

impl Path {
    /// An idle path that may leave a corner by `corner` um.
    pub fn new(corner: u16) -> Path {
        Path {
            run: Run::default(),
            limits: Limits::default(),
            unit: [0; 3],
            feed: Scaled::ZERO,
            top: Scaled::ZERO,
            active: false,
            begin: false,
            exact: true,
            paused: false,
            percent: 100,
            corner,
            steps: [0; 3],
            next: None,
        }
    }

    /// Takes a block; `false` when one is waiting already: offer it again later. A block without
    /// any step is taken and forgotten.
    pub fn push(&mut self, axes: &[AxisRecord; 3], block: &Block) -> bool {
        if self.next.is_some() {
            return false;
        }
        if block.steps == [0; 3] {
            return true;
        }
        self.next = Some(*block);
        if self.active && !self.exact {
            self.join(&geometry(axes, block));
        }
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

    /// Speed override, 10 to 200 percent of each block's speed, never above what the axes can.
    pub fn set_override(&mut self, percent: u8) {
        self.percent = percent.clamp(10, 200);
        self.set_nominal();
    }

    /// Speed along the path at the end of the last segment handed out, um/s.
    pub fn velocity(&self) -> u32 {
        if self.active { self.run.v2.root().floor() } else { 0 }
    }

    /// Puts the next segment into `segment`, which must hold the one before: increments and
    /// directions are those of a block and only written when one begins. `false` when idle or in a
    /// pause.
    pub fn next_segment(&mut self, axes: &[AxisRecord; 3], segment: &mut PathSegment) -> bool {
        if !self.active {
            let Some(block) = self.next.take() else { return false };
            self.run.v2 = Scaled::ZERO;
            self.activate(axes, &block);
        }
        if !self.run.segment(&self.limits, self.paused, &mut segment.ramp) {
            return false;
        }
        segment.begin = self.begin;
        if self.begin {
            self.begin = false;
            segment.negative = 0;
            let events = largest(&self.steps);
            for axis in 0..3 {
                let steps = self.steps[axis];
                segment.inc[axis] = fraction(steps.unsigned_abs(), events);
                segment.negative |= u8::from(steps < 0) << axis;
            }
        }
        if self.run.left == 0 {
            self.active = false;
            if let Some(block) = self.next.take() {
                if self.exact {
                    self.run.v2 = Scaled::ZERO;
                }
                self.activate(axes, &block);
            }
        }
        true
    }

    /// Makes `block` the playing one, entered at the present speed but at least its start rate.
    fn activate(&mut self, axes: &[AxisRecord; 3], block: &Block) {
        let g = geometry(axes, block);
        self.active = true;
        self.begin = true;
        self.exact = block.exact;
        self.steps = block.steps;
        self.unit = g.unit;
        self.feed = g.feed;
        self.top = g.top;
        self.run.left = g.events;
        self.limits.start2 = g.start.times(g.start);
        self.limits.exit2 = self.limits.start2;
        let pitch = g.length.over(Scaled::new(g.events));
        self.limits.set_pitch(pitch, g.accel, g.decel);
        self.set_nominal();
        self.run.v2 = self.run.v2.most(self.limits.start2.least(self.limits.nominal2));
    }

    /// The playing block's speed under the override.
    fn set_nominal(&mut self) {
        let percent = Scaled::new(self.percent.into()).over(HUNDRED);
        let nominal = self.feed.times(percent).least(self.top);
        self.limits.nominal2 = nominal.times(nominal);
    }

    /// Raises the speed at the end of the playing block to that of the corner into `next`.
    fn join(&mut self, next: &Geometry) {
        // Half the difference of the unit vectors is the sine q of half the deflection, c its
        // cosine; junction deviation: v^2 = a delta c / (1 - c) = a delta c (1 + c) / q^2.
        let mut turn = Scaled::ZERO;
        for axis in 0..3 {
            let d = Scaled::new(self.unit[axis].abs_diff(next.unit[axis]).into());
            turn = turn.plus(d.times(d));
        }
        let q2 = turn.shifted(-32);
        let c = ONE.minus(q2).root();
        let smooth = next.accel.least(next.decel).times(Scaled::new(self.corner.into()));
        let smooth = smooth.times(c).times(ONE.plus(c));
        // What the axes may jump by anyway: their start rate.
        let start2 = next.start.times(next.start);
        let corner = smooth.most(start2.shifted(-2)).over(q2);
        // What the next block can brake from.
        let reach = start2.plus(next.decel.times(next.length).shifted(1));
        let feed = self.feed.least(next.feed);
        self.limits.exit2 = corner.least(reach).least(feed.times(feed));
    }
}

/// 1
const ONE: Scaled = Scaled::constant(1);
/// 100
const HUNDRED: Scaled = Scaled::constant(100);

/// The largest distance.
fn largest(steps: &[i32; 3]) -> u32 {
    let mut most = 0;
    for s in steps {
        most = s.unsigned_abs().max(most);
    }
    most
}

/// Events, length, direction and limits along the path of a block with at least one step.
fn geometry(axes: &[AxisRecord; 3], block: &Block) -> Geometry {
    let mut um = [Scaled::ZERO; 3];
    let mut sum = Scaled::ZERO;
    let mut in_steps = Scaled::ZERO;
    for a in 0..3 {
        let steps = Scaled::new(block.steps[a].unsigned_abs());
        um[a] = steps.times(Scaled::new(axes[a].um.into())).over(Scaled::new(axes[a].steps.into()));
        sum = sum.plus(um[a].times(um[a]));
        in_steps = in_steps.plus(steps.times(steps));
    }
    let length = sum.root();
    let mut g = Geometry {
        events: largest(&block.steps),
        length,
        start: Scaled::MAX,
        top: Scaled::MAX,
        accel: Scaled::MAX,
        decel: Scaled::MAX,
        feed: Scaled::MAX,
        unit: [0; 3],
    };
    for a in 0..3 {
        let steps = block.steps[a];
        if steps == 0 {
            continue;
        }
        let axis = &axes[a];
        let along = length.over(Scaled::new(steps.unsigned_abs()));
        g.start = g.start.least(along.times(Scaled::new(axis.start_rate.into())));
        g.top = g.top.least(along.times(Scaled::new(axis.top_rate)));
        g.accel = g.accel.least(along.times(Scaled::new(axis.accel)));
        g.decel = g.decel.least(along.times(Scaled::new(axis.decel)));
        let unit = um[a].over(length).shifted(15).floor().min(0x7FFF) as i16;
        g.unit[a] = if steps < 0 { -unit } else { unit };
    }
    let feed = match block.feed {
        Feed::Rapid => g.top,
        Feed::Um(feed) => Scaled::new(feed.max(1)),
        Feed::Steps(feed) => Scaled::new(feed.max(1)).times(length).over(in_steps.root()),
    };
    g.feed = feed.least(g.top);
    g
}
