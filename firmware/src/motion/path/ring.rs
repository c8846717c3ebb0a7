//! The blocks that wait, and how fast each may end.
//!
//! A block may end as fast as the corner behind it allows and as all that is known behind that can be
//! braked over: `exit^2 = min(corner^2, exit^2 + 2 d length)` of the next one, from the newest block, which
//! ends at rest, back to the playing one. A new block raises these speeds and never lowers one, so the pass
//! ends at the first block that it does not change. Inside the ring squares of speeds are integers in a unit of
//! which the machine's highest are some 2^30: a sum takes a tenth of what one of [`Scaled`] does, and the pass is
//! up to 64 of them for each block.

use super::geometry::{Geometry, Shape, to_um};
use super::{Feed, Manner};
use crate::motion::arc::Arc;
use crate::motion::scaled::Scaled;
use lang::record::AxisRecord;

/// Blocks that may wait, a power of two.
pub const DEPTH: usize = 32;
/// Arcs among them: an arc is no faster than half of its radius can brake, so few are enough.
pub const ARCS: usize = 4;

/// What of a block its beginning needs; um, um/s, um/s2.
#[derive(Clone, Copy, Debug)]
pub struct Waiting {
    /// Distance of each axis, steps.
    pub steps: [i32; 3],
    /// [`Geometry::pitch`] of a line, the length of an arc.
    pub length: Scaled,
    /// See [`Geometry`].
    pub feed: Scaled,
    /// See [`Geometry`].
    pub top: Scaled,
    /// See [`Geometry`].
    pub accel: Scaled,
    /// See [`Geometry`].
    pub decel: Scaled,
    /// Square of the speed from which it may start.
    pub start2: Scaled,
    /// See [`Manner`].
    pub power: u16,
    /// See [`Manner`].
    pub tag: u32,
    /// A rapid move.
    pub rapid: bool,
    /// Rests at its end.
    pub exact: bool,
    /// The oldest arc of [`Ring::arcs`].
    pub arc: bool,
}

impl Waiting {
    const NONE: Waiting = Waiting {
        steps: [0; 3],
        length: Scaled::ZERO,
        feed: Scaled::ZERO,
        top: Scaled::ZERO,
        accel: Scaled::ZERO,
        decel: Scaled::ZERO,
        start2: Scaled::ZERO,
        power: 0,
        tag: 0,
        rapid: false,
        exact: false,
        arc: false,
    };
}

/// The blocks that wait, oldest first. What the reverse pass looks at lies in arrays of its own.
#[derive(Clone, Copy, Debug)]
pub struct Ring {
    /// What their beginnings need.
    pub blocks: [Waiting; DEPTH],
    /// Squares of the speeds at which each may be entered by its corner...
    corner2: [u32; DEPTH],
    /// ... what each can take away from a squared speed, ...
    ramp2: [u32; DEPTH],
    /// ... and at which it may end.
    exit2: [u32; DEPTH],
    /// They are (um/s)^2 times 2 to this.
    unit: i8,
    /// The oldest block.
    first: u8,
    count: u8,
    /// The arcs among them.
    pub arcs: [Arc; ARCS],
    /// The oldest arc.
    first_arc: u8,
    arc_count: u8,
    /// Sum of `ramp2`.
    ahead2: u32,
    /// Square of the newest block's top speed: no more than that need be braked over.
    top2: u32,
}

impl Ring {
    /// Nothing waits.
    pub const EMPTY: Ring = Ring {
        blocks: [Waiting::NONE; DEPTH],
        corner2: [0; DEPTH],
        ramp2: [0; DEPTH],
        exit2: [0; DEPTH],
        unit: 0,
        first: 0,
        count: 0,
        arcs: [Arc::NONE; ARCS],
        first_arc: 0,
        arc_count: 0,
        ahead2: 0,
        top2: 0,
    };

    /// Forgets all.
    pub fn clear(&mut self) {
        self.count = 0;
        self.arc_count = 0;
        self.ahead2 = 0;
    }

    /// A path begins: its unit is that of the axes.
    pub fn begin(&mut self, axes: &[AxisRecord; 3]) {
        let mut top = Scaled::ZERO;
        for axis in axes {
            top = top.most(to_um(axis, Scaled::new(axis.top_rate.max(1))));
        }
        // Three axes at their top together are below 2^31.
        self.unit = 28i8.saturating_sub(top.times(top).exponent_over(Scaled::constant(1)));
    }

    /// A squared speed in the ring's unit, at most 2^31.
    fn fixed(&self, v2: Scaled) -> u32 {
        v2.shifted(self.unit).floor()
    }

    /// A squared speed of the ring's unit.
    fn scaled(&self, v2: u32) -> Scaled {
        Scaled::new(v2).shifted(-self.unit)
    }

    /// Whether nothing waits.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Whether another block is wanted: two at least, then as long as they would not brake from top speed.
    pub fn has_room(&self) -> bool {
        self.count < 2
            || usize::from(self.count) < DEPTH
                && usize::from(self.arc_count) < ARCS
                && self.ahead2 < self.top2
    }

    /// Appends a block that may be entered at `corner2` by its corner. Returns the square of the speed at which the
    /// oldest one may be entered now, if that may have become higher.
    pub fn append(
        &mut self,
        shape: &Shape,
        g: &Geometry,
        manner: &Manner,
        corner2: Scaled,
    ) -> Option<Scaled> {
        let mut n = usize::from(self.first + self.count) % DEPTH;
        let block = &mut self.blocks[n];
        block.feed = g.feed;
        block.top = g.top;
        block.accel = g.accel;
        block.decel = g.decel;
        block.start2 = g.start2();
        block.power = manner.power;
        block.tag = manner.tag;
        block.rapid = matches!(manner.feed, Feed::Rapid);
        block.exact = manner.exact;
        block.arc = false;
        match shape {
            Shape::Line(steps, _) => {
                block.steps = **steps;
                block.length = g.pitch;
            }
            Shape::Arc(arc) => {
                block.arc = true;
                for axis in 0..3 {
                    block.steps[axis] = arc.end[axis].wrapping_sub(arc.start[axis]);
                }
                block.length = g.length;
                self.arcs[usize::from(self.first_arc + self.arc_count) % ARCS] = **arc;
                self.arc_count += 1;
            }
        }
        let mut exit2 = self.fixed(self.blocks[n].start2);
        self.corner2[n] = self.fixed(corner2);
        self.exit2[n] = exit2;
        self.ramp2[n] = self.fixed(g.ramp2());
        self.ahead2 = self.ahead2.saturating_add(self.ramp2[n]);
        self.top2 = self.fixed(g.top.times(g.top));
        self.count += 1;
        let first = usize::from(self.first);
        loop {
            let enter2 = self.corner2[n].min(exit2.saturating_add(self.ramp2[n]));
            if n == first {
                return Some(self.scaled(enter2));
            }
            n = (n + DEPTH - 1) % DEPTH;
            exit2 = self.exit2[n];
            if enter2 <= exit2 {
                return None;
            }
            self.exit2[n] = enter2;
            exit2 = enter2;
        }
    }

    /// Takes the oldest block: its place in [`Ring::blocks`] and for [`Ring::exit2`] until the next one is appended.
    pub fn take(&mut self) -> Option<usize> {
        if self.count == 0 {
            return None;
        }
        let n = usize::from(self.first);
        self.first = ((n + 1) % DEPTH) as u8;
        self.count -= 1;
        self.ahead2 = self.ahead2.saturating_sub(self.ramp2[n]);
        Some(n)
    }

    /// Square of the speed at which the block at a place may end.
    pub fn exit2(&self, n: usize) -> Scaled {
        self.scaled(self.exit2[n]).most(self.blocks[n].start2)
    }

    /// Takes the oldest arc: its place in [`Ring::arcs`], as for [`Ring::take`].
    pub fn take_arc(&mut self) -> usize {
        let n = usize::from(self.first_arc);
        self.first_arc = ((n + 1) % ARCS) as u8;
        self.arc_count -= 1;
        n
    }
}
