//! A waiting block, packed into 24 bytes: um, um/s, um/s2.

use super::block::{Feed, Manner};
use super::geometry::Geometry;
use crate::motion::scaled::Scaled;

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct Waiting {
    /// Distance of each axis, steps; not of one in [`super::ring::Ring::far`].
    steps: [i16; 3],
    /// Upper halves of [`Geometry::pitch`] of a line or the length of an arc, and of [`Geometry::feed`]...
    length: u16,
    feed: u16,
    /// ... and the bytes below them.
    length_low: u8,
    feed_low: u8,
    /// Of [`Geometry::accel`] and [`Geometry::decel`] 16 bits ([`narrow`]).
    accel: u16,
    decel: u16,
    /// Upper half of [`Geometry::top`].
    top: u16,
    /// Upper half of the square of the speed from which it may start.
    start2: u16,
    /// See [`Manner`].
    pub power: u16,
    /// Lower half of [`Manner::tag`].
    tag: u16,
}

/// What sort of block it is, in a byte of its own, as a block has an even number of them.
#[derive(Clone, Copy, Debug)]
pub struct Sort(u8);

/// [`Sort`]: bits of [`Manner::tag`] above those in [`Waiting`].
const TAG: u8 = 0x0F;
/// [`Sort`]: a rapid move.
const RAPID: u8 = 1 << 4;
/// [`Sort`]: an arc.
const ARC: u8 = 1 << 5;
/// [`Sort`]: an arc or the way of a line lies in [`super::ring::Ring::far`].
const IS_FAR: u8 = 1 << 6;

impl Sort {
    /// A line that lies near.
    pub const LINE: Sort = Sort(0);

    /// A line that runs in a manner.
    pub fn of(manner: &Manner) -> Sort {
        let mut sort = (manner.tag >> 16) as u8 & TAG;
        if let Feed::Rapid = manner.feed {
            sort |= RAPID;
        }
        Sort(sort)
    }

    /// It lies in [`super::ring::Ring::far`], a line or an arc.
    pub fn set_far(&mut self, arc: bool) {
        self.0 |= if arc { ARC | IS_FAR } else { IS_FAR };
    }

    /// A rapid move.
    pub fn is_rapid(self) -> bool {
        self.0 & RAPID != 0
    }

    /// An arc, the oldest of [`super::ring::Ring::far`].
    pub fn is_arc(self) -> bool {
        self.0 & ARC != 0
    }

    /// An arc or a line of which the way is the oldest of [`super::ring::Ring::far`].
    pub fn is_far(self) -> bool {
        self.0 & IS_FAR != 0
    }

    /// [`Manner::tag`] of a block of this sort.
    pub fn tag(self, block: &Waiting) -> u32 {
        u32::from(self.0 & TAG) << 16 | u32::from(block.tag)
    }
}

/// Upper half of a number: less than a hundredth below it.
fn upper(of: Scaled) -> u16 {
    (of.0 >> 16) as u16
}

/// A number of its upper half.
fn whole(upper: u16) -> Scaled {
    Scaled(u32::from(upper) << 16)
}

/// The byte below that.
fn low(of: Scaled) -> u8 {
    (of.0 as u16 >> 8) as u8
}

/// A number of its upper half and the byte below: less than 1/32768 below it.
fn with_low(upper: u16, low: u8) -> Scaled {
    Scaled(u32::from(upper) << 16 | u32::from(low) << 8)
}

/// A ramp in 16 bits, less than 1/1024 below it: its exponent from 2^-16 to 2^47 and all of its mantissa but the bit
/// that is always set. Ramps are from 100 steps/s2 of 1/65535 um to three axes' 10^7 of 65535 um, 2^-10 to 2^41.
fn narrow(ramp: Scaled) -> u16 {
    let exponent = (ramp.0 >> 24) as u8;
    match exponent {
        0..=LOWEST => 0,
        HIGHEST.. => u16::MAX,
        _ => u16::from(exponent - LOWEST) << 10 | (ramp.0 << 3 >> 16) as u16 & 0x3FF,
    }
}

/// A ramp of [`narrow`].
fn wide(ramp: u16) -> Scaled {
    let exponent = u32::from((ramp >> 10) as u8 + LOWEST);
    Scaled(exponent << 24 | 1 << 23 | u32::from(ramp & 0x3FF) << 13)
}

/// Exponents of 2^-16 um/s2 and of 2^48 um/s2.
const LOWEST: u8 = 128 - 23 - 16;
const HIGHEST: u8 = LOWEST + 64;

impl Waiting {
    /// None.
    pub const NONE: Waiting = Waiting {
        steps: [0; 3],
        length: 0,
        feed: 0,
        length_low: 0,
        feed_low: 0,
        accel: 0,
        decel: 0,
        top: 0,
        start2: 0,
        power: 0,
        tag: 0,
    };

    /// Makes it a line of no way yet.
    pub fn set(&mut self, g: &Geometry, start2: Scaled, manner: &Manner) {
        self.set_length(g.pitch);
        self.feed = upper(g.feed);
        self.feed_low = low(g.feed);
        self.accel = narrow(g.accel);
        self.decel = narrow(g.decel);
        self.top = upper(g.top);
        self.start2 = upper(start2);
        self.power = manner.power;
        self.tag = manner.tag as u16;
    }

    /// See [`Waiting::length`].
    pub fn set_length(&mut self, length: Scaled) {
        self.length = upper(length);
        self.length_low = low(length);
    }

    /// The way of a line, steps; `false` when that is too long and lies elsewhere.
    pub fn set_way(&mut self, steps: &[i32; 3]) -> bool {
        let mut fits = true;
        for (near, steps) in self.steps.iter_mut().zip(steps) {
            *near = *steps as i16;
            fits &= i32::from(*near) == *steps;
        }
        fits
    }

    /// Gets the way of a line that has it, steps.
    pub fn get_way(&self, way: &mut [i32; 3]) {
        for (way, near) in way.iter_mut().zip(&self.steps) {
            *way = i32::from(*near);
        }
    }

    /// [`Geometry::pitch`] of a line, the length of an arc.
    pub fn length(&self) -> Scaled {
        with_low(self.length, self.length_low)
    }

    /// See [`Geometry`].
    pub fn feed(&self) -> Scaled {
        with_low(self.feed, self.feed_low)
    }

    /// See [`Geometry`].
    pub fn decel(&self) -> Scaled {
        wide(self.decel)
    }

    /// Its bounds, as far as it keeps them.
    pub fn bounds(&self) -> Bounds {
        Bounds {
            top: whole(self.top),
            accel: wide(self.accel),
            decel: wide(self.decel),
            start2: whole(self.start2),
        }
    }
}

/// What bounds a block: 11 bits of [`Geometry::accel`] and [`Geometry::decel`], of the others 8, and all of the newest.
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
    /// Those of nothing.
    pub const NONE: Bounds = Bounds {
        top: Scaled::ZERO,
        accel: Scaled::ZERO,
        decel: Scaled::ZERO,
        start2: Scaled::ZERO,
    };
}

#[cfg(test)]
mod tests {
    use super::{Scaled, narrow, wide};

    #[test]
    fn a_ramp_of_any_machine_keeps_its_size() {
        // Parts of 2^-16 um/s2, from 100 steps/s2 of 1/65535 um to 10^7 of 65535 um.
        let mut parts = 100.0;
        while parts < 6.6e11 * 65_536.0 * 3.0 {
            let up = (parts as u64).ilog2().saturating_sub(23) as i8;
            let ramp = Scaled::new((parts as u64 >> up) as u32).shifted(up - 16);
            let kept = wide(narrow(ramp));
            assert!(kept <= ramp && ramp.minus(kept) <= ramp.shifted(-10), "{kept:?} for {ramp:?}");
            parts *= 1.37;
        }
    }
}
