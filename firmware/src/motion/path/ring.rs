//! The blocks that wait, and how fast each may be entered.
//!
//! A block may be entered no faster than its corner allows, and no faster than the blocks from it on can brake from:
//! `enter^2 = min(corner^2, enter^2 of the next one + 2 d length)`, from the newest block, which ends at rest, back to
//! the oldest. grbl (`planner_recalculate`) and Klipper (`LookAheadQueue.flush`) walk back over all blocks for that.
//! Here no walk is needed. Written out, the recursion for the oldest block is the minimum over all corners of
//! `corner^2 + sum of 2 d length of the blocks before that corner`; call this sum the corner's *line*. When the oldest block
//! is taken, the same amount leaves all sums, so their order never changes. The minimum of such a queue is kept by
//! [`Brakes`]: a new corner removes the corners before it whose line is not below its own, each at most once, and the
//! first that is left is the minimum. A block costs a bounded time on average, however many wait.
//!
//! Squares of speeds are integers here, (um/s)^2 times a power of two that brings the machine's highest to some 2^28:
//! adding two takes a tenth of the time that [`Scaled`] takes. A name that ends in 2 is such a square.
//!
//! [`DEPTH`] blocks are the largest thing in RAM, so each number has as few bits as it needs; the bounds of the newest
//! block are kept in full. Blocks with long ways, of which few suffice to brake over, have their own store ([`Ring::far`]).

use super::block::Manner;
use super::brakes::{Brakes, DEPTH, HIGHEST};
use super::geometry::{Geometry, Shape, to_um};
use super::waiting::{Bounds, Sort, Waiting};
use crate::motion::arc::Arc;
use crate::motion::math::largest;
use crate::motion::scaled::Scaled;
use lang::record::AxisRecord;

/// The place behind one, as far on as the second says, at most all around.
fn behind(n: u8, by: u8) -> usize {
    let n = usize::from(n) + usize::from(by);
    if n < DEPTH { n } else { n - DEPTH }
}

/// Those among them that are arcs or have more than 32767 steps of an axis. An arc is no faster than half of its radius
/// can brake, and ways like that are long, so few are enough.
pub const FAR: usize = 4;

/// Twice a ramp, less what [`crate::motion::ramp::Limits::set_pitch`] keeps back, times 16.
const TWICE: Scaled = Scaled::constant(31);

/// A block that was taken.
#[derive(Clone, Copy, Debug)]
pub struct Taken {
    /// Its place in [`Ring::blocks`] and [`Ring::sorts`], and for [`Ring::bounds`].
    pub n: usize,
    /// That of an arc in [`Ring::far`].
    pub far: usize,
    /// Steps of its axis with most steps.
    pub events: u32,
}

/// The blocks that wait, oldest first.
#[derive(Clone, Copy, Debug)]
pub struct Ring {
    /// What their beginnings need.
    pub blocks: [Waiting; DEPTH],
    /// Their sorts.
    pub sorts: [Sort; DEPTH],
    /// Which corners in front of them are braked for.
    brakes: Brakes,
    /// Squares of speeds are (um/s)^2 times 2 to this.
    unit: i8,
    /// The oldest block.
    first: u8,
    count: u8,
    /// The oldest of [`Ring::far`].
    first_far: u8,
    far_count: u8,
    /// Arcs and the ways of far lines among them, these from 0.
    pub far: [Arc; FAR],
    /// What all together can take away from a squared speed.
    ahead2: u32,
    /// What bounds the newest block.
    newest: Bounds,
    /// Square of the speed that its end may have as long as nothing behind it is known.
    end2: u32,
    /// Square of its top speed: no more than that need be braked over.
    top2: u32,
}

impl Ring {
    /// Nothing waits.
    pub const EMPTY: Ring = Ring {
        blocks: [Waiting::NONE; DEPTH],
        sorts: [Sort::LINE; DEPTH],
        brakes: Brakes::NONE,
        unit: 0,
        first: 0,
        count: 0,
        first_far: 0,
        far_count: 0,
        far: [Arc::NONE; FAR],
        ahead2: 0,
        newest: Bounds::NONE,
        end2: 0,
        top2: 0,
    };

    /// Forgets all.
    pub fn clear(&mut self) {
        self.count = 0;
        self.brakes.clear();
        self.far_count = 0;
        self.ahead2 = 0;
    }

    /// A path begins: its unit is that of the axes.
    pub fn begin(&mut self, axes: &[AxisRecord; 3]) {
        let mut top = Scaled::ZERO;
        for axis in axes {
            top = top.most(to_um(axis, Scaled::new(axis.top_rate.max(1))));
        }
        // Three axes at their top together are below [`HIGHEST`].
        self.unit = 26i8.saturating_sub(top.times(top).exponent_over(Scaled::constant(1)));
    }

    /// A squared speed in the ring's unit, at most [`HIGHEST`].
    fn fixed(&self, v2: Scaled) -> u32 {
        v2.shifted(self.unit).floor().min(HIGHEST)
    }

    /// A squared speed of the ring's unit.
    fn scaled(&self, v2: u32) -> Scaled {
        Scaled::new(v2).shifted(-self.unit)
    }

    /// What the newest block can do to change its direction, um/s2.
    pub fn ramp(&self) -> Scaled {
        self.newest.accel.least(self.newest.decel)
    }

    /// Whether nothing waits.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Whether another block is wanted: two at least, then as long as they would not brake from top speed.
    pub fn has_room(&self) -> bool {
        self.count < 2
            || usize::from(self.count) < DEPTH
                && usize::from(self.far_count) < FAR
                && self.ahead2 < self.top2
    }

    /// Appends a block that may be entered at `corner2` by its corner, when [`Ring::has_room`]. Returns the square of the
    /// speed at which the oldest one may be entered now, if that may have become higher.
    ///
    /// Until now the newest block ended at `end2` (its start rate), whose line is `end2 + ahead2`. If a corner's line is
    /// no higher, that corner limits the oldest block with or without the new one. Otherwise the new block lifts that end, and
    /// the minimum is looked up again.
    pub fn append(
        &mut self,
        shape: &Shape,
        g: &Geometry,
        manner: &Manner,
        corner2: Scaled,
    ) -> Option<Scaled> {
        let n = behind(self.first, self.count);
        let start2 = g.start2();
        self.newest = Bounds { top: g.top, accel: g.accel, decel: g.decel, start2 };
        let block = &mut self.blocks[n];
        block.set(g, start2, manner);
        let mut sort = Sort::of(manner);
        let far = usize::from(self.first_far + self.far_count) % FAR;
        match shape {
            Shape::Line(steps, _) => {
                if !block.set_way(steps) {
                    sort.set_far(false);
                    self.far[far].start = [0; 3];
                    self.far[far].end = **steps;
                }
            }
            Shape::Arc(arc) => {
                block.set_length(g.length);
                sort.set_far(true);
                self.far[far] = **arc;
            }
        }
        self.sorts[n] = sort;
        self.far_count += u8::from(sort.is_far());
        let ramp2 = self.ramp2(n, g.events);
        let settled = self.brakes.hold(self.end2 + self.ahead2);
        self.enter(n, ramp2, self.fixed(corner2));
        self.top2 = self.fixed(g.top.times(g.top));
        (!settled).then(|| self.scaled(self.brakes.least(self.end2 + self.ahead2)))
    }

    /// Length of the block at a place, a line of so many events, in whole um: the same when it is appended and when it is
    /// taken.
    pub fn length(&self, n: usize, events: Scaled) -> u32 {
        let length = self.blocks[n].length();
        if self.sorts[n].is_arc() { length.floor() } else { length.times(events).floor() }
    }

    /// Those of all blocks that wait, together.
    #[inline(never)]
    pub fn lengths(&self) -> u32 {
        let (mut all, mut far) = (0_u32, usize::from(self.first_far));
        let mut k = 0;
        while k < self.count {
            let n = behind(self.first, k);
            let mut way = [0; 3];
            self.blocks[n].get_way(&mut way);
            if self.sorts[n].is_far() {
                let Arc { start, end, .. } = &self.far[far];
                for axis in 0..3 {
                    way[axis] = end[axis].wrapping_sub(start[axis]);
                }
                far = (far + 1) % FAR;
            }
            all = all.wrapping_add(self.length(n, Scaled::new(largest(&way))));
            k += 1;
        }
        all
    }

    /// That of the newest one.
    pub fn newest_length(&self, events: Scaled) -> u32 {
        self.length(behind(self.first, self.count.saturating_sub(1)), events)
    }

    /// What the block at a place can take away from a squared speed, a line of so many events, on the ramp that it will be
    /// given: the same when it is appended and when it is taken. `2 d length`, less the 1/32 that the ramp generator
    /// keeps back (31/16 for 2), in the ring's unit. Both times it follows from the same rounded numbers: a sum from
    /// which something else were taken than was added would drift.
    fn ramp2(&self, n: usize, events: Scaled) -> u32 {
        let block = &self.blocks[n];
        let mut ramp = block.decel().times(block.length()).times(TWICE).shifted(-4);
        if !self.sorts[n].is_arc() {
            ramp = ramp.times(events);
        }
        self.fixed(ramp)
    }

    /// Enters the newest block: the corner in front of it, what it can brake, and its end, where it may rest.
    fn enter(&mut self, n: usize, ramp2: u32, corner2: u32) {
        // The block before rests where its own start rate is as fast.
        let rest2 = if self.count == 0 { 0 } else { self.end2 };
        self.brakes.append(n as u8, corner2.max(rest2), self.ahead2);
        self.brakes.go(ramp2);
        self.end2 = self.fixed(self.blocks[n].bounds().start2);
        self.ahead2 += ramp2;
        self.count += 1;
    }

    /// Takes the oldest block and gets its way, steps, also of an arc: it is valid until the next one is appended.
    pub fn take(&mut self, way: &mut [i32; 3]) -> Option<Taken> {
        if self.count == 0 {
            return None;
        }
        let n = usize::from(self.first);
        let far = usize::from(self.first_far);
        self.blocks[n].get_way(way);
        if self.sorts[n].is_far() {
            self.first_far = ((far + 1) % FAR) as u8;
            self.far_count -= 1;
            let Arc { start, end, .. } = &self.far[far];
            for axis in 0..3 {
                way[axis] = end[axis].wrapping_sub(start[axis]);
            }
        }
        let events = largest(way);
        let ramp2 = self.ramp2(n, Scaled::new(events));
        self.first = behind(self.first, 1) as u8;
        self.count -= 1;
        self.ahead2 -= ramp2;
        self.brakes.take(n as u8, ramp2);
        Some(Taken { n, far, events })
    }

    /// What bounds the block that was taken from a place, and the square of the speed at which it may end: the lowest
    /// line of the corners that still wait, the newest block's end among them.
    pub fn bounds(&self, n: usize) -> (Bounds, Scaled) {
        if self.count == 0 {
            return (self.newest, self.newest.start2);
        }
        let bounds = self.blocks[n].bounds();
        let exit2 = self.scaled(self.brakes.least(self.end2 + self.ahead2));
        (bounds, exit2.most(bounds.start2))
    }
}
