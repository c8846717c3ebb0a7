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

use super::math::{fraction, isqrt, length, mul_div, root_of_product};
use super::ramp::{Ramp, Segment, Stretch};
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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

/// What follows from a block's distances.
struct Geometry {
    events: u32,
    length: u32,
    start: u32,
    top: u32,
    accel: u32,
    decel: u32,
    nominal: u32,
    /// Direction, 32768 is 1.
    unit: [i32; 3],
}

/// The planner of interpolated motion.
#[derive(Clone, Copy, Debug)]
pub struct Path {
    ramp: Ramp,
    inc: [u32; 3],
    negative: u8,
    begin: bool,
    active: bool,
    paused: bool,
    /// Percent of the programmed speed, 10..=200.
    percent: u8,
    /// Corner tolerance, um.
    corner: u16,
    /// Direction at the end of the playing block.
    unit: [i32; 3],
    /// Programmed speed of the playing block, um/s.
    feed: u32,
    top: u32,
    accel: u32,
    exact: bool,
    next: Option<Block>,
}

impl Path {
    /// An idle path that may leave a corner by `corner` um.
    pub fn new(corner: u16) -> Path {
        Path {
            ramp: Ramp::default(),
            inc: [0; 3],
            negative: 0,
            begin: false,
            active: false,
            paused: false,
            percent: 100,
            corner,
            unit: [0; 3],
            feed: 0,
            top: 0,
            accel: 0,
            exact: true,
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
            let next = geometry(axes, block);
            let exit = self.corner_speed(&next);
            self.ramp.exit(exit);
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
        self.ramp.brake(on);
    }

    /// Whether a pause has been reached.
    pub fn is_paused(&self) -> bool {
        self.paused && (!self.active || self.ramp.at_rest())
    }

    /// Forgets the rest of the path; for a stop, when [`Path::is_paused`].
    pub fn clear(&mut self) {
        self.active = false;
        self.next = None;
        self.pause(false);
    }

    /// Speed override, 10 to 200 percent of each block's speed, never above what the axes can.
    pub fn set_override(&mut self, percent: u8) {
        self.percent = percent.clamp(10, 200);
        if self.active {
            self.ramp.nominal(self.nominal());
        }
    }

    /// Present speed along the path, um/s, at the end of the last segment handed out.
    pub fn velocity(&self) -> u32 {
        if self.active { self.ramp.velocity() } else { 0 }
    }

    /// The next segment; `None` when idle or in a pause.
    pub fn next_segment(&mut self, axes: &[AxisRecord; 3]) -> Option<PathSegment> {
        if !self.active {
            let block = self.next.take()?;
            self.activate(axes, &block, 0);
        }
        let ramp = self.ramp.next_segment()?;
        let segment =
            PathSegment { ramp, inc: self.inc, negative: self.negative, begin: self.begin };
        self.begin = false;
        if self.ramp.left() == 0 {
            self.active = false;
            if let Some(block) = self.next.take() {
                let entry = if self.exact { 0 } else { self.ramp.velocity() };
                self.activate(axes, &block, entry);
            }
        }
        Some(segment)
    }

    /// Makes `block` the playing one, entered at `entry` um/s or from rest.
    fn activate(&mut self, axes: &[AxisRecord; 3], block: &Block, entry: u32) {
        let g = geometry(axes, block);
        for axis in 0..3 {
            self.inc[axis] = increment(block.steps[axis].unsigned_abs(), g.events);
        }
        self.negative = 0;
        for axis in 0..3 {
            if block.steps[axis] < 0 {
                self.negative |= 1 << axis;
            }
        }
        self.begin = true;
        self.active = true;
        self.unit = g.unit;
        self.feed = g.nominal;
        self.top = g.top;
        self.accel = g.accel.min(g.decel);
        self.exact = block.exact;
        let start = g.start.min(self.nominal());
        self.ramp = Ramp::new(&Stretch {
            events: g.events,
            length: g.length,
            per: g.events,
            entry: entry.max(start),
            start,
            nominal: self.nominal(),
            top: g.top.min(g.nominal.saturating_mul(2)),
            exit: start,
            accel: g.accel,
            decel: g.decel,
        });
        self.ramp.brake(self.paused);
    }

    /// The playing block's speed under the override, um/s.
    fn nominal(&self) -> u32 {
        mul_div(self.feed, u32::from(self.percent), 100).clamp(1, self.top)
    }

    /// The speed at the corner from the playing block into `next`, um/s.
    fn corner_speed(&self, next: &Geometry) -> u32 {
        let turn = length([
            self.unit[0].abs_diff(next.unit[0]),
            self.unit[1].abs_diff(next.unit[1]),
            self.unit[2].abs_diff(next.unit[2]),
        ]);
        // Half the difference of the unit vectors is the sine q of half the deflection, its
        // cosine c; junction deviation: v^2 = a delta c / (1 - c) = a delta c (1 + c) / q^2.
        let q = (turn / 2).min(ONE);
        let c = u32::from(isqrt(ONE * ONE - q * q));
        let k = u32::from(isqrt(c * (ONE + c)));
        let smooth = root_of_product(self.accel.min(next.accel), u32::from(self.corner));
        // What an axis may jump by anyway: its start rate.
        let jump = mul_div(next.start, ONE, turn.max(1));
        let corner = mul_div(smooth, k, q.max(1)).max(jump);
        // What the next block can brake from.
        let reach =
            length([next.start, root_of_product(next.decel.saturating_mul(2), next.length), 0]);
        corner.min(reach).min(self.feed).min(next.nominal).max(1)
    }
}

/// A number of steps of an axis as um, rounded down.
fn um_of(axis: &AxisRecord, steps: u32) -> u32 {
    mul_div(steps, u32::from(axis.um), u32::from(axis.steps))
}

/// 1 in unit vectors.
const ONE: u32 = 1 << 15;

/// `steps * 2^32 / events`, at most 2^32 - 1.
pub fn increment(steps: u32, events: u32) -> u32 {
    fraction(steps, events)
}

/// Events, length, direction and limits along the path of a block with at least one step.
fn geometry(axes: &[AxisRecord; 3], block: &Block) -> Geometry {
    let steps = block.steps.map(i32::unsigned_abs);
    let events = steps[0].max(steps[1]).max(steps[2]);
    let um = [0, 1, 2].map(|a: usize| um_of(&axes[a], steps[a]));
    let length_um = length(um).max(1);
    let mut g = Geometry {
        events,
        length: length_um,
        start: u32::MAX,
        top: u32::MAX,
        accel: u32::MAX,
        decel: u32::MAX,
        nominal: 0,
        unit: [0; 3],
    };
    for a in 0..3 {
        if steps[a] == 0 {
            continue;
        }
        let along = |rate| mul_div(rate, length_um, steps[a]);
        g.start = g.start.min(along(u32::from(axes[a].start_rate)));
        g.top = g.top.min(along(axes[a].top_rate));
        g.accel = g.accel.min(along(axes[a].accel));
        g.decel = g.decel.min(along(axes[a].decel));
        let unit = mul_div(um[a], ONE, length_um).min(ONE) as i32;
        g.unit[a] = if block.steps[a] < 0 { -unit } else { unit };
    }
    let feed = match block.feed {
        Feed::Rapid => g.top,
        Feed::Um(feed) => feed,
        Feed::Steps(feed) => mul_div(feed, length_um, length(steps)),
    };
    g.nominal = feed.clamp(1, g.top);
    g
}
