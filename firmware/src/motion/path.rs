//! Interpolated motion: blocks in, segments for three axes out.
//!
//! Units are um, um/s and um/s2, so feeds, corners and arcs do not depend on the axes' steps per millimetre. A name that
//! ends in 2 is the square of a speed, (um/s)^2. An *event* is a step of the block's axis with most steps.
//!
//! Up to 81 blocks ahead of the playing one are known ([`ring`]). The speed at the corner between two of them is the lowest
//! of: what junction deviation and the arc through the middle of the shorter block allow ([`Geometry::corner2`]), either
//! block's feed, and what the blocks after it can brake from ([`ring`]).

mod block;
mod brakes;
pub mod geometry;
mod ring;
mod waiting;

use super::arc::{Arc, Walk};
use super::math::{fraction, size};
use super::ramp::{Limits, Run, Segment};
use super::scaled::Scaled;
pub use block::{Block, FOLLOWS, FULL, Feed, Manner};
use geometry::{Geometry, Shape, Tail, tangent, to_um};
use lang::record::AxisRecord;
use ring::{Ring, Taken};

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
    /// Power of a laser: [`Manner::power`], or the part of it that the speed is of the programmed one.
    pub power: u16,
    /// The block's [`Manner::tag`].
    pub tag: u32,
    /// Its whole way, steps of each axis.
    pub way: [i32; 3],
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

/// A line of the small chip, where the ring keeps less.
#[cfg(not(target_arch = "msp430"))]
#[derive(Clone, Copy, Debug)]
struct Ending {
    /// Square of the speed at which it may end; the others as in [`Geometry`].
    end2: Scaled,
    pitch: Scaled,
    feed: Scaled,
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
    /// Its axes' top, um/s, less than a hundredth below.
    top: Scaled,
    /// Increments, accumulators and directions of the line or chord that plays.
    inc: [u32; 3],
    acc: [u16; 3],
    negative: u8,
    active: bool,
    begin: bool,
    within: bool,
    paused: bool,
    /// Percent of the programmed speed: of feeds 10..=200, of rapid moves 10..=100.
    percents: [u8; 2],
    /// The block is a rapid move.
    rapid: bool,
    /// Corner tolerance, um.
    corner: u16,
    /// Rate of the step timer, Hz.
    clock: Scaled,
    walk: Option<Walk>,
    /// Length of each of its chords, um.
    stride: Scaled,
    power: u16,
    /// Where it follows the speed: over twice the programmed speed; 0 elsewhere.
    gain: Scaled,
    tag: u32,
    way: [i32; 3],
    /// Where the newest block ends, um along all blocks since power-up, modulo 2^32, each cut to whole um.
    end: u32,
    /// Where the one ends that plays, or was the last to. Both are kept from the first action of a run on (`measures`).
    playing_end: u32,
    measures: bool,
    /// Chords of an arc that follow the one that plays.
    after: u16,
    /// The end of the newest block; `None` where the next one begins at rest.
    tail: Option<Tail>,
    ring: Ring,
    /// The newest line, where the host has said how fast it may end ([`Path::push_ending`]).
    #[cfg(not(target_arch = "msp430"))]
    ending: Option<Ending>,
}

impl Path {
    /// Nothing to do, no corner tolerance, no clock.
    const IDLE: Path = Path {
        run: Run::NONE,
        limits: Limits::NONE,
        exit2: Scaled::ZERO,
        accel: Scaled::ZERO,
        decel: Scaled::ZERO,
        feed: Scaled::ZERO,
        top: Scaled::ZERO,
        inc: [0; 3],
        acc: [0; 3],
        negative: 0,
        active: false,
        begin: false,
        within: false,
        paused: false,
        percents: [100; 2],
        rapid: false,
        corner: 0,
        clock: Scaled::ZERO,
        walk: None,
        stride: Scaled::ZERO,
        power: 0,
        gain: Scaled::ZERO,
        tag: 0,
        way: [0; 3],
        end: 0,
        playing_end: 0,
        measures: false,
        after: 0,
        tail: None,
        ring: Ring::EMPTY,
        #[cfg(not(target_arch = "msp430"))]
        ending: None,
    };

    /// An idle path that may leave a corner by `corner` um, for a step timer of `clock` Hz.
    pub fn new(corner: u16, clock: Scaled) -> Path {
        Path { corner, clock, ..Path::IDLE }
    }

    /// A new run begins with an empty path, otherwise as [`Path::new`].
    pub fn begin(&mut self, corner: u16, clock: Scaled) {
        self.clear();
        self.measures = false;
        self.corner = corner;
        self.clock = clock;
    }

    /// Takes a line; `false` when no more may wait: offer it again later. A block without any step is taken
    /// and forgotten.
    pub fn push(&mut self, axes: &[AxisRecord; 3], block: &Block) -> bool {
        if block.steps == [0; 3] {
            return true;
        }
        let shape = Shape::Line(&block.steps, &block.um);
        self.append(axes, &shape, &block.manner)
    }

    /// Takes a line that may end at a speed of this square, (um/s)^2, though none after it is known: as the small chip
    /// plans, to the last bit. One at a time may wait, and what is pushed after it must be a line of the same kind.
    #[cfg(not(target_arch = "msp430"))]
    pub fn push_ending(&mut self, axes: &[AxisRecord; 3], block: &Block, end2: Scaled) {
        if block.steps == [0; 3] {
            return;
        }
        let before = self.ending.take().map_or(Scaled::ZERO, |ending| ending.end2);
        let shape = Shape::Line(&block.steps, &block.um);
        if self.is_idle() {
            self.ring.begin(axes);
        }
        let g = Geometry::of(axes, &shape, block.manner.feed);
        self.ring.append(&shape, &g, &block.manner, before);
        let end2 = if block.manner.exact { Scaled::ZERO } else { end2 };
        self.ending = Some(Ending { end2, pitch: g.pitch, feed: g.feed });
    }

    /// Takes an arc, as [`Path::push`] a line.
    pub fn push_arc(&mut self, axes: &[AxisRecord; 3], arc: &Arc, manner: &Manner) -> bool {
        self.append(axes, &Shape::Arc(arc), manner)
    }

    /// Appends a block: its geometry, the speed of the corner in front of it, its place in the ring. Then the blocks before
    /// it may be faster, as more way to brake is known. The corner's speed is computed once, for the present override
    /// or for 100 % if that is higher: a lower override acts through `nominal2` while the block plays. The ring raises the
    /// entries of waiting blocks; the exit of the playing one is raised here, by as much as the next block's entry.
    fn append(&mut self, axes: &[AxisRecord; 3], shape: &Shape, manner: &Manner) -> bool {
        if !self.has_room() {
            return false;
        }
        if self.is_idle() {
            self.ring.begin(axes);
        }
        let g = Geometry::of(axes, shape, manner.feed);
        let rapid = matches!(manner.feed, Feed::Rapid);
        let fast = g.feed.most(overridden(g.feed, g.top, self.percents[usize::from(rapid)]));
        let corner2 = match &self.tail {
            Some(tail) => {
                let ramp = self.ring.ramp().least(g.ramp());
                g.corner2(axes, tail, ramp, fast, self.corner)
            }
            None => Scaled::ZERO,
        };
        self.tail = None;
        if !manner.exact {
            let mut unit = g.unit;
            if let Shape::Arc(arc) = shape {
                unit = tangent(arc, g.length, true);
            }
            self.tail = Some(Tail { length: g.length, fast, unit });
        }
        let enter2 = self.ring.append(shape, &g, manner, corner2);
        if self.measures {
            self.end = self.end.wrapping_add(self.ring.newest_length(g.events));
        }
        if let (true, Some(enter2)) = (self.active, enter2) {
            let gain = enter2.minus(self.exit2);
            self.limits.exit2 = self.limits.exit2.plus(gain);
            self.exit2 = self.exit2.plus(gain);
        }
        true
    }

    /// Whether another block would be taken.
    pub fn has_room(&self) -> bool {
        self.ring.has_room()
    }

    /// Whether the block after the playing one is known.
    pub fn knows_next(&self) -> bool {
        !self.ring.is_empty()
    }

    /// Whether every block has been handed out as segments.
    pub fn is_idle(&self) -> bool {
        !self.active && self.ring.is_empty()
    }

    /// Ramps down to a pause (`true`), or goes on with the rest.
    pub fn pause(&mut self, on: bool) {
        self.paused = on;
    }

    /// Whether a pause has been reached.
    pub fn is_paused(&self) -> bool {
        self.paused && (!self.active || self.run.v2 <= self.limits.start2)
    }

    /// From now on the lengths of the blocks are added up.
    pub fn measure(&mut self) {
        if !self.measures {
            self.measures = true;
            self.end = self.playing_end.wrapping_add(self.ring.lengths());
        }
    }

    /// Where the newest block ends, um along the path from some origin, modulo 2^32.
    pub fn end(&self) -> u32 {
        self.end
    }

    /// Where the last segment that was handed out ends, counted as [`Path::end`]. At the end of a block it is exact.
    pub fn place(&self) -> u32 {
        if !self.active {
            return self.playing_end;
        }
        let left = Scaled::new(self.run.left).times(self.limits.tick).over(self.clock);
        let chords = Scaled::new(self.after.into()).times(self.stride);
        let left = if self.after == 0 { left } else { left.plus(chords) };
        self.playing_end.wrapping_sub(left.floor())
    }

    /// Forgets the rest of the path; for a stop, when [`Path::is_paused`].
    pub fn clear(&mut self) {
        self.active = false;
        self.walk = None;
        self.ring.clear();
        self.playing_end = self.end;
        self.after = 0;
        self.tail = None;
        self.paused = false;
        #[cfg(not(target_arch = "msp430"))]
        {
            self.ending = None;
            self.limits.through = false;
        }
    }

    /// Speed override: 10 to 200 % of each block's feed, 10 to 100 % of a rapid move's speed, at most what the axes can.
    pub fn set_override(&mut self, feed: u8, rapid: u8) {
        self.percents = [feed.clamp(10, 200), rapid.clamp(10, 100)];
        self.set_nominal();
    }

    /// Speed along the path at the end of the last segment handed out, um/s.
    pub fn velocity(&self) -> u32 {
        if self.active { self.run.v2.root().floor() } else { 0 }
    }

    /// The line that is over goes through its end, behind which another one comes in time.
    fn goes_through(&self) -> bool {
        #[cfg(not(target_arch = "msp430"))]
        return self.limits.through;
        #[cfg(target_arch = "msp430")]
        return false;
    }

    /// Puts the next segment into `segment`, which must hold the one before: increments and
    /// directions are only written when a line or chord begins. `false` when idle or in a pause.
    pub fn next_segment(&mut self, axes: &[AxisRecord; 3], segment: &mut PathSegment) -> bool {
        if !self.active {
            if !self.goes_through() {
                self.run.v2 = Scaled::ZERO;
            }
            self.activate(axes);
        }
        if !self.active || !self.run.segment(&self.limits, self.paused, &mut segment.ramp) {
            return false;
        }
        segment.power = self.power;
        if self.gain != Scaled::ZERO {
            segment.power = self.run.sum.times(self.gain).floor().min(FULL.into()) as u16;
        }
        segment.begin = self.begin;
        if self.begin {
            self.begin = false;
            segment.within = self.within;
            segment.tag = self.tag;
            segment.way = self.way;
            segment.inc = self.inc;
            segment.acc = self.acc;
            segment.negative = self.negative;
        }
        if self.run.left == 0 {
            self.within = true;
            self.active = self.chord(axes);
            if !self.active {
                // It rests where its own start rate is as fast as the corner: the next line has one of its own, which
                // may be a hundred times lower.
                if self.exit2 <= self.limits.start2 {
                    self.run.v2 = Scaled::ZERO;
                }
                self.activate(axes);
            }
        }
        true
    }

    /// Makes the oldest waiting block the playing one. It is entered at the speed at which the block before it ended, at
    /// least at its own start rate. Its exit speed is the next block's entry, as far as that is known ([`Ring::bounds`]).
    fn activate(&mut self, axes: &[AxisRecord; 3]) {
        while !self.active {
            let Some(Taken { n, far, events }) = self.ring.take(&mut self.way) else {
                // The next block, if one comes, begins at rest.
                self.tail = None;
                return;
            };
            if self.measures {
                let length = self.ring.length(n, Scaled::new(events));
                self.playing_end = self.playing_end.wrapping_add(length);
            }
            self.after = 0;
            let block = &self.ring.blocks[n];
            let sort = self.ring.sorts[n];
            #[cfg_attr(target_arch = "msp430", allow(unused_mut))]
            let mut length = block.length();
            self.within = false;
            self.rapid = sort.is_rapid();
            self.power = block.power & !FOLLOWS;
            self.gain = Scaled::ZERO;
            if block.power & FOLLOWS != 0 {
                self.gain = Scaled::new(self.power.into()).over(block.feed()).shifted(-1);
            }
            self.tag = sort.tag(block);
            self.feed = block.feed();
            let (bounds, exit2) = self.ring.bounds(n);
            self.top = bounds.top;
            self.accel = bounds.accel;
            self.decel = bounds.decel;
            self.limits.start2 = bounds.start2;
            self.exit2 = exit2;
            #[cfg(not(target_arch = "msp430"))]
            if let Some(ending) = &self.ending {
                length = ending.pitch;
                self.feed = ending.feed;
                self.exit2 = exit2.most(ending.end2);
                self.limits.through = self.exit2 > self.limits.start2;
            }
            self.set_nominal();
            self.run.v2 = self.run.v2.most(self.limits.start2.least(self.limits.nominal2));
            if sort.is_arc() {
                let walk = Walk::new(axes, &self.ring.far[far]);
                self.stride = length.over(Scaled::new(walk.chords().into()));
                self.walk = Some(walk);
                // One without any step is over already.
                self.active = self.chord(axes);
            } else {
                self.line(length, events);
            }
        }
    }

    /// Begins a line of some [`Geometry::pitch`] and so many events: Bresenham's line as accumulators (DDA). At each event
    /// `acc += inc` modulo 2^32 for each axis, and the carry is its step, with `inc = steps * 2^32 / events`. As `acc` begins at
    /// one half, after k events an axis has made `k * steps / events` rounded: within half a step of the line.
    fn line(&mut self, pitch: Scaled, events: u32) {
        self.negative = 0;
        for (axis, steps) in self.way.iter().enumerate() {
            self.inc[axis] = if *steps == 0 { 0 } else { fraction(size(*steps), events) };
            self.acc[axis] = HALF;
            self.negative |= u8::from(*steps < 0) << axis;
        }
        self.limits.set_pitch(pitch, self.accel, self.decel, self.clock);
        self.limits.exit2 = self.exit2;
        self.run.left = events;
        self.active = true;
        self.begin = true;
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
        self.limits.set_pitch(pitch, self.accel, self.decel, self.clock);
        // The chord may end as fast as the chords after it can brake from: `rest` is their length in events of this one,
        // and what this chord's whole events fall short of its span.
        let rest = self.stride.over(pitch).times(Scaled::new(chord.after.into()));
        let rest = rest.plus(chord.span()).minus(Scaled::new(chord.events));
        self.limits.exit2 = self.exit2.plus(self.limits.decel2.times(rest));
        self.after = chord.after;
        true
    }

    /// The playing block's speed under the override.
    fn set_nominal(&mut self) {
        let percent = self.percents[usize::from(self.rapid)];
        let nominal = overridden(self.feed, self.top, percent);
        self.limits.nominal2 = nominal.times(nominal);
    }
}

/// A programmed speed under an override, no more than its axes can.
fn overridden(feed: Scaled, top: Scaled, percent: u8) -> Scaled {
    if percent == 100 {
        return feed;
    }
    let percent = Scaled::new(percent.into()).over(HUNDRED);
    feed.times(percent).least(top.most(feed))
}

const HUNDRED: Scaled = Scaled::constant(100);
