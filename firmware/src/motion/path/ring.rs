//! The blocks that wait, and how fast each may be entered.
//!
//! A block may be entered as fast as the corner in front of it allows and as all that is known from it on can be
//! braked over: `enter^2 = min(corner^2, enter^2 of the next one + 2 d length)`, from the newest block, which
//! ends at rest, back to the oldest. A new block raises these speeds and never lowers one. Where the corner is the
//! lower bound, no block to come changes anything in front of it: those blocks keep their last value, and
//! the pass goes over the others, which all brake for the newest one's end. Squares of speeds are integers in a
//! unit of which the machine's highest are some 2^30: a sum takes a tenth of what one of [`Scaled`] does.
//!
//! [`DEPTH`] of these blocks are the largest thing in RAM. So what needs few bits has few, except of the newest block:
//! a line alone is planned to the last bit. Blocks with long ways, of which few suffice to brake over, keep them apart.

use super::geometry::{Geometry, Shape, to_um};
use super::{Feed, Manner};
use crate::motion::arc::Arc;
use crate::motion::scaled::Scaled;
use lang::record::AxisRecord;

/// Blocks that may wait: 50 mm/s at 250 mm/s2 wants 50 chords of 0.1 mm.
pub const DEPTH: usize = 64;

/// The place behind one, as far on as the second says, at most all around.
fn behind(n: u8, by: u8) -> usize {
    let n = usize::from(n) + usize::from(by);
    if n < DEPTH { n } else { n - DEPTH }
}

/// The place in front of one.
fn before(n: usize) -> usize {
    if n == 0 { DEPTH - 1 } else { n - 1 }
}

/// Those among them that are arcs or have more than 32767 steps of an axis. An arc is no faster than half of its radius
/// can brake, and ways like that are long, so few are enough.
pub const FAR: usize = 4;

/// What of a block its beginning needs; um, um/s, um/s2.
#[derive(Clone, Copy, Debug)]
pub struct Waiting {
    /// Distance of each axis, steps; not of one in [`Ring::far`].
    steps: [i16; 3],
    /// [`Geometry::pitch`] of a line, the length of an arc.
    pub length: Scaled,
    /// See [`Geometry`].
    pub feed: Scaled,
    /// Upper halves and, in one, the bytes below them of [`Geometry::accel`] and [`Geometry::decel`].
    ramps: [u16; 3],
    /// Upper half of [`Geometry::top`].
    top: u16,
    /// Upper half of the square of the speed from which it may start.
    start2: u16,
    /// See [`Manner`].
    pub power: u16,
    /// [`Manner::tag`] with [`RAPID`] and others in its top byte.
    head: u32,
}

/// [`Waiting::head`]: a rapid move.
const RAPID: u32 = 1 << 24;
/// [`Waiting::head`]: rests at its end.
const EXACT: u32 = 1 << 25;
/// [`Waiting::head`]: an arc.
const ARC: u32 = 1 << 26;
/// [`Waiting::head`]: the oldest of [`Ring::far`], an arc or the way of a line.
const IS_FAR: u32 = 1 << 27;

/// Upper half of a number: less than a hundredth below it.
fn upper(of: Scaled) -> u16 {
    (of.0 >> 16) as u16
}

/// A number of its upper half.
fn whole(upper: u16) -> Scaled {
    Scaled(u32::from(upper) << 16)
}

impl Waiting {
    const NONE: Waiting = Waiting {
        steps: [0; 3],
        length: Scaled::ZERO,
        feed: Scaled::ZERO,
        ramps: [0; 3],
        top: 0,
        start2: 0,
        power: 0,
        head: 0,
    };

    /// See [`Manner`].
    pub fn tag(&self) -> u32 {
        self.head & (RAPID - 1)
    }

    /// A rapid move.
    pub fn is_rapid(&self) -> bool {
        self.head & RAPID != 0
    }

    /// Rests at its end.
    pub fn is_exact(&self) -> bool {
        self.head & EXACT != 0
    }

    /// An arc, the oldest of [`Ring::far`].
    pub fn is_arc(&self) -> bool {
        self.head & ARC != 0
    }

    /// Its bounds, as far as it keeps them.
    fn bounds(&self) -> Bounds {
        let [accel, low, decel] = self.ramps;
        Bounds {
            top: whole(self.top),
            accel: Scaled(u32::from(accel) << 16 | u32::from(low & 0xFF00)),
            decel: Scaled(u32::from(decel) << 16 | u32::from(low << 8)),
            start2: whole(self.start2),
        }
    }
}

/// What bounds a block: 16 bits of [`Geometry::accel`] and [`Geometry::decel`], of the others 8, and all of the newest.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// See [`Geometry`].
    pub top: Scaled,
    /// See [`Geometry`].
    pub accel: Scaled,
    /// See [`Geometry`].
    pub decel: Scaled,
    /// Square of the speed from which it may start.
    pub start2: Scaled,
}

impl Bounds {
    const NONE: Bounds = Bounds {
        top: Scaled::ZERO,
        accel: Scaled::ZERO,
        decel: Scaled::ZERO,
        start2: Scaled::ZERO,
    };
}

/// What the pass over the waiting blocks looks at.
#[derive(Clone, Copy, Debug)]
struct Entry {
    /// Square of the speed at which the block may be entered: by its corner, then, where that is known, for good.
    enter2: u32,
    /// What it can take away from a squared speed.
    ramp2: u32,
}

/// The blocks that wait, oldest first.
#[derive(Clone, Copy, Debug)]
pub struct Ring {
    /// What their beginnings need.
    pub blocks: [Waiting; DEPTH],
    /// Squares of speeds are (um/s)^2 times 2 to [`Ring::unit`].
    entries: [Entry; DEPTH],
    unit: i8,
    /// The oldest block.
    first: u8,
    count: u8,
    /// So many of the newest may be entered the faster the more is known.
    open: u8,
    /// Arcs and the ways of far lines among them, these from 0.
    pub far: [Arc; FAR],
    /// The oldest of these.
    first_far: u8,
    far_count: u8,
    /// Sum of [`Entry::ramp2`].
    ahead2: u32,
    /// What bounds the newest block.
    newest: Bounds,
    /// Squares of its start speed...
    start2: u32,
    /// ... and of its top speed: no more than that need be braked over.
    top2: u32,
}

impl Ring {
    /// Nothing waits.
    pub const EMPTY: Ring = Ring {
        blocks: [Waiting::NONE; DEPTH],
        entries: [Entry { enter2: 0, ramp2: 0 }; DEPTH],
        unit: 0,
        first: 0,
        count: 0,
        open: 0,
        far: [Arc::NONE; FAR],
        first_far: 0,
        far_count: 0,
        ahead2: 0,
        newest: Bounds::NONE,
        start2: 0,
        top2: 0,
    };

    /// Forgets all.
    pub fn clear(&mut self) {
        self.count = 0;
        self.open = 0;
        self.far_count = 0;
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

    /// A squared speed in the ring's unit, at most 2^31 - 1.
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
                && usize::from(self.far_count) < FAR
                && self.ahead2 < self.top2
    }

    /// Appends a block that may be entered at `corner2` by its corner, when [`Ring::has_room`]. Returns the square of the
    /// speed at which the oldest one may be entered now, if that may have become higher.
    pub fn append(
        &mut self,
        shape: &Shape,
        g: &Geometry,
        manner: &Manner,
        corner2: Scaled,
    ) -> Option<Scaled> {
        let n = behind(self.first, self.count);
        let block = &mut self.blocks[n];
        block.feed = g.feed;
        block.top = upper(g.top);
        let low = g.accel.0 as u16 & 0xFF00 | g.decel.0 as u16 >> 8;
        block.ramps = [upper(g.accel), low, upper(g.decel)];
        let start2 = g.start2();
        block.start2 = upper(start2);
        self.newest = Bounds { top: g.top, accel: g.accel, decel: g.decel, start2 };
        block.power = manner.power;
        block.head = manner.tag;
        if let Feed::Rapid = manner.feed {
            block.head |= RAPID;
        }
        if manner.exact {
            block.head |= EXACT;
        }
        let far = usize::from(self.first_far + self.far_count) % FAR;
        match shape {
            Shape::Line(steps, _) => {
                block.length = g.pitch;
                let mut is_far = false;
                for (near, steps) in block.steps.iter_mut().zip(*steps) {
                    *near = *steps as i16;
                    is_far |= i32::from(*near) != *steps;
                }
                if is_far {
                    block.head |= IS_FAR;
                    self.far[far].start = [0; 3];
                    self.far[far].end = **steps;
                }
            }
            Shape::Arc(arc) => {
                block.length = g.length;
                block.head |= ARC | IS_FAR;
                self.far[far] = **arc;
            }
        }
        self.far_count += u8::from(block.head & IS_FAR != 0);
        let enter2 = self.enter(n, self.fixed(start2), self.fixed(g.ramp2()), self.fixed(corner2));
        self.top2 = self.fixed(g.top.times(g.top));
        let all = self.open == self.count;
        let enter2 = self.raise(n, enter2);
        all.then(|| self.scaled(enter2))
    }

    /// Sets the entry of the newest block, at a place. Returns the square of the speed at which it may be entered by what
    /// it can take away.
    fn enter(&mut self, n: usize, start2: u32, ramp2: u32, corner2: u32) -> u32 {
        // The block before ends at its own start speed at least. Where this one cannot come down from there
        // the axes jump, and never from more.
        let least2 = if self.count == 0 { 0 } else { self.start2 };
        let reach2 = start2 + ramp2;
        let mut enter2 = least2;
        if least2 <= reach2 {
            enter2 = enter2.max(corner2);
        }
        self.entries[n] = Entry { enter2, ramp2 };
        self.start2 = start2;
        // Below 2^32: room is where the sum is below a top speed's square.
        self.ahead2 += ramp2;
        self.count += 1;
        self.open += 1;
        reach2.max(least2)
    }

    /// Raises the speeds at which the open blocks may be entered, the newest of them, at a place, at no more than
    /// `enter2`. Returns that of the oldest of them.
    fn raise(&mut self, mut n: usize, mut enter2: u32) -> u32 {
        let mut left = self.open;
        loop {
            let entry = &self.entries[n];
            left -= 1;
            if enter2 >= entry.enter2 {
                enter2 = entry.enter2;
                self.open -= left + 1;
                break;
            }
            if left == 0 {
                return enter2;
            }
            n = before(n);
            enter2 += self.entries[n].ramp2;
        }
        while left != 0 {
            left -= 1;
            n = before(n);
            let entry = &mut self.entries[n];
            enter2 = entry.enter2.min(enter2 + entry.ramp2);
            entry.enter2 = enter2;
        }
        enter2
    }

    /// Takes the oldest block: its place in [`Ring::blocks`] and for [`Ring::bounds`] until the next one is appended.
    pub fn take(&mut self) -> Option<usize> {
        if self.count == 0 {
            return None;
        }
        let n = usize::from(self.first);
        self.first = behind(self.first, 1) as u8;
        self.count -= 1;
        self.open = self.open.min(self.count);
        self.ahead2 -= self.entries[n].ramp2;
        Some(n)
    }

    /// What bounds the block that was taken from a place, and the square of the speed at which it may end.
    pub fn bounds(&self, n: usize) -> (Bounds, Scaled) {
        if self.count == 0 {
            return (self.newest, self.newest.start2);
        }
        let bounds = self.blocks[n].bounds();
        let mut enter2 = self.entries[usize::from(self.first)].enter2;
        if self.open == self.count {
            enter2 = self.start2 + self.ahead2;
        }
        (bounds, self.scaled(enter2).most(bounds.start2))
    }

    /// Gets the way of the block that was taken from a place, steps. Returns the place in [`Ring::far`] of an arc, for as
    /// long.
    pub fn way(&mut self, n: usize, way: &mut [i32; 3]) -> usize {
        let block = &self.blocks[n];
        let far = usize::from(self.first_far);
        for (way, near) in way.iter_mut().zip(&block.steps) {
            *way = i32::from(*near);
        }
        if block.head & IS_FAR != 0 {
            self.first_far = ((far + 1) % FAR) as u8;
            self.far_count -= 1;
            let Arc { start, end, .. } = &self.far[far];
            for axis in 0..3 {
                way[axis] = end[axis].wrapping_sub(start[axis]);
            }
        }
        far
    }
}
