//! Circular arcs and helices (G2, G3) as chords.
//!
//! An arc is known by its centre; the point on it is turned by a fixed angle for each chord, in
//! 1/256 um, by four products with `sin` and `1 - cos` as 32-bit fractions. The angle is such that
//! a chord leaves the arc by at most 0.1 steps. A chord runs a whole number of steps of its axis
//! with most steps, the others are interpolated with their fractions of a step kept from chord to
//! chord, so the path stays within 0.71 + 0.1 steps of the circle, and the last chord ends on the
//! commanded step. Where the end misses the circle (by no more than RS274/NGC allows), the radius
//! changes evenly along the arc.
//!
//! grbl's `mc_arc` turns a vector by a fixed angle in the same way, with two terms of the series, and corrects it by a
//! true sine and cosine every dozen chords. Here the two fractions are right to 2^-26, and nothing is corrected.

use super::math::{fraction, high, largest, mul_div, signed, size};
use super::scaled::Scaled;
use lang::fault::Fault;
use lang::record::AxisRecord;
use lang::trig::angle;

/// An arc in machine coordinates, centre known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arc {
    /// Index of the plane's first axis: 0 for XY, 1 for YZ, 2 for ZX. The second follows it
    /// cyclically, the helix axis is the third.
    pub first: u8,
    /// Seen from the positive end of the helix axis.
    pub clockwise: bool,
    /// The centre in the plane, um.
    pub center: [i32; 2],
    /// The start less the centre, um.
    pub from: [i32; 2],
    /// The end less the centre, um.
    pub to: [i32; 2],
    /// Radius at the start, um.
    pub radius: Scaled,
    /// Angle of the start, 2^32 to a turn.
    pub begin: u32,
    /// The angle from start to end in the arc's direction, 2^32 to a turn; a full circle is one
    /// part less.
    pub sweep: u32,
    /// Where all axes are, steps.
    pub start: [i32; 3],
    /// Where they end, steps.
    pub end: [i32; 3],
}

/// Start and end of an arc as they were commanded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ends {
    /// See [`Arc::first`].
    pub first: u8,
    /// See [`Arc::clockwise`].
    pub clockwise: bool,
    /// Machine positions of all axes, um.
    pub from_um: [i32; 3],
    /// See `from_um`.
    pub to_um: [i32; 3],
    /// Machine positions of all axes, steps.
    pub start: [i32; 3],
    /// See `start`.
    pub end: [i32; 3],
}

/// The end may miss its circle by this, um (RS274/NGC interpreters: 0.005 mm).
const MISS_UM: Scaled = Scaled::constant(5);

/// Radii stay below this, um, so that 1/256 um fit into 32 bits.
const FAR_UM: u32 = 1 << 22;

impl Ends {
    /// Indices of the plane's axes.
    fn plane(&self) -> [usize; 2] {
        plane(self.first)
    }

    /// The arc around `offset` from the start (I, J, K of the plane), um; a full circle when it
    /// ends where it starts.
    ///
    /// # Errors
    /// F09: the end misses the circle by more than 5 um and 0.1 % of the radius, or the radius is
    /// 0 or above 4 m.
    pub fn around(&self, offset: [i32; 2]) -> Result<Arc, Fault> {
        let axes = self.plane();
        let mut arc = Arc {
            first: self.first,
            clockwise: self.clockwise,
            start: self.start,
            end: self.end,
            ..Arc::NONE
        };
        for i in 0..2 {
            let from = self.from_um[axes[i]];
            let center = from.checked_add(offset[i]).ok_or(Fault::Arc)?;
            arc.center[i] = center;
            arc.from[i] = from.checked_sub(center).ok_or(Fault::Arc)?;
            arc.to[i] = self.to_um[axes[i]].checked_sub(center).ok_or(Fault::Arc)?;
            if size(arc.from[i]) > FAR_UM || size(arc.to[i]) > FAR_UM {
                return Err(Fault::Arc);
            }
        }
        let (r0, r1) = (distance(arc.from), distance(arc.to));
        let miss = r0.minus(r1).plus(r1.minus(r0));
        if r0 < ONE || miss > MISS_UM && miss.times(THOUSAND) > r0 {
            return Err(Fault::Arc);
        }
        arc.radius = r0;
        arc.begin = angle(arc.from);
        let turn = angle(arc.to).wrapping_sub(arc.begin);
        let turn = if self.clockwise { turn.wrapping_neg() } else { turn };
        arc.sweep = if turn == 0 || arc.from == arc.to { u32::MAX } else { turn };
        Ok(arc)
    }

    /// The arc of a radius, um: the shorter one, for a negative radius the longer one.
    ///
    /// # Errors
    /// F09: start and end coincide, or lie more than two radii apart (5 um and 0.1 % are forgiven).
    ///
    /// The centre lies on the perpendicular through the chord's middle, `sqrt(r^2 - h^2)` beside it with `h` half the chord.
    /// Turning the half chord by a quarter turn and scaling it by `sqrt(r^2 - h^2) / h` leads from the middle to it.
    pub fn with_radius(&self, radius: i32) -> Result<Arc, Fault> {
        let axes = self.plane();
        let mut half = [0; 2];
        for i in 0..2 {
            let chord = self.to_um[axes[i]].checked_sub(self.from_um[axes[i]]).ok_or(Fault::Arc)?;
            if size(chord) > 2 * FAR_UM {
                return Err(Fault::Arc);
            }
            half[i] = chord;
        }
        // Half the chord h, the centre lies sqrt(r^2 - h^2) beside its middle.
        let h = distance(half).shifted(-1);
        let r = Scaled::size(radius);
        let over = h.minus(r);
        if h.0 == 0 || over > MISS_UM && over.times(THOUSAND) > r {
            return Err(Fault::Arc);
        }
        // (r - h)(r + h) keeps what r^2 - h^2 would lose when both are nearly equal.
        let ratio = r.minus(h).times(r.plus(h)).root().over(h);
        // The centre is to the left of the chord for a short counterclockwise arc.
        let left = self.clockwise == (radius < 0);
        let side = |along: i32| {
            let beside = ratio.times(Scaled::size(along)).floor();
            signed((beside as i32 + 1) >> 1, along)
        };
        let (x, y) = (side(half[0]), side(half[1]));
        let offset = if left {
            [half[0] / 2 - y, half[1] / 2 + x]
        } else {
            [half[0] / 2 + y, half[1] / 2 - x]
        };
        self.around(offset)
    }
}

/// Indices of the axes of a plane.
fn plane(first: u8) -> [usize; 2] {
    match first {
        0 => [0, 1],
        1 => [1, 2],
        _ => [2, 0],
    }
}

/// 1
const ONE: Scaled = Scaled::constant(1);
/// 1000: 0.1 %
const THOUSAND: Scaled = Scaled::constant(1000);

fn distance(v: [i32; 2]) -> Scaled {
    let x = Scaled::size(v[0]);
    let y = Scaled::size(v[1]);
    x.times(x).plus(y.times(y)).root()
}

impl Arc {
    /// Nothing.
    pub const NONE: Arc = Arc {
        first: 0,
        clockwise: false,
        center: [0; 2],
        from: [0; 2],
        to: [0; 2],
        radius: Scaled::ZERO,
        begin: 0,
        sweep: 0,
        start: [0; 3],
        end: [0; 3],
    };

    /// Indices of the plane's axes and of the helix axis.
    pub fn axes(&self) -> [usize; 3] {
        let [a, b] = plane(self.first);
        [a, b, 3 - a - b]
    }

    /// The furthest that each plane axis gets, um: start, end, and those of the circle's four
    /// extremes that the arc passes. Lowest and highest for each axis of [`Arc::axes`].
    pub fn extremes(&self) -> [[i32; 2]; 2] {
        let radius = self.radius.floor() as i32;
        let mut out = [[0; 2]; 2];
        for (i, span) in out.iter_mut().enumerate() {
            let (a, b) = (self.center[i] + self.from[i], self.center[i] + self.to[i]);
            *span = [a.min(b), a.max(b)];
        }
        for quarter in 0..4u32 {
            let ahead = (quarter << 30).wrapping_sub(self.begin);
            let ahead = if self.clockwise { ahead.wrapping_neg() } else { ahead };
            if ahead < self.sweep {
                let i = quarter as usize & 1;
                let at =
                    if quarter < 2 { self.center[i] + radius } else { self.center[i] - radius };
                out[i] = [out[i][0].min(at), out[i][1].max(at)];
            }
        }
        out
    }

    /// Direction of travel in the plane at the start (or at the end), 32768 is 1.
    pub fn tangent(&self, at_end: bool) -> [i16; 2] {
        let v = if at_end { self.to } else { self.from };
        let r = self.radius;
        let unit = |c: i32| {
            let unit = Scaled::size(c).over(r).shifted(15).floor().min(0x7FFF);
            signed(unit as i32, c) as i16
        };
        let (x, y) = (unit(v[0]), unit(v[1]));
        if self.clockwise { [y, -x] } else { [-y, x] }
    }
}

/// `value * fraction / 2^32`, rounded toward 0: the size is multiplied, the sign is put back.
fn turned(value: i32, fraction: i32) -> i32 {
    signed(high(size(value), size(fraction)) as i32, value ^ fraction)
}

/// Sine and 1 - cosine of an angle of at most 1/12 turn (2^32 to a turn), as 32-bit fractions.
///
/// Horner's form of `x - x^3/3! + x^5/5! - x^7/7!` and `x^2/2! - x^4/4! + x^6/6! - x^8/8!`, all positive inside. The
/// constants are 2^32 over 6, 120, 5040 and over 24, 720, 40320. The first terms left out, `x^9/9!` and `x^10/10!`, are at
/// most 2^-26 and 2^-31. `1 - cos` and not `cos` is kept: of a small angle it has all its bits.
fn sine(angle: u32) -> (i32, i32) {
    // angle * 2 pi: 0xC90FDAA2 is pi * 2^30.
    let rad = mul_div(angle, 0xC90F_DAA2, 1 << 29);
    let z = high(rad, rad);
    let third = 35_791_394 - high(z, 852_176);
    let s = rad - high(rad, high(z, 715_827_883 - high(z, third)));
    let third = 5_965_232 - high(z, 106_522);
    let v = high(z, (1 << 31) - high(z, 178_956_971 - high(z, third)));
    (s as i32, v as i32)
}

/// A chord as the path plays it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Chord {
    /// Steps of the axis with most steps.
    pub events: u32,
    /// Distance of each axis, 1/4096 step.
    pub delta: [i32; 3],
    /// Increments of the engine's accumulators.
    pub inc: [u32; 3],
    /// Upper halves of the accumulators at its beginning.
    pub acc: [u16; 3],
    /// Chords that follow.
    pub after: u16,
}

impl Chord {
    /// Length along the axis with most steps, steps with fractions: of a last chord its events.
    pub fn span(&self) -> Scaled {
        if self.after == 0 {
            return Scaled::new(self.events);
        }
        Scaled::new(largest(&self.delta)).shifted(-(FINE as i8))
    }
}

/// The walk along an arc, chord by chord.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Walk {
    arc: Arc,
    /// The point on the arc less its centre, 1/256 um.
    point: [i32; 2],
    sine: i32,
    versine: i32,
    chord: u16,
    chords: u16,
    /// Whole steps that the axes have to go to the arc's end.
    rest: [i32; 3],
    /// How far the end of the chord before is ahead of the axes' whole steps, 1/4096 step.
    goal: [i32; 3],
    /// The same of where the motion along that chord has really come to.
    exact: [i32; 3],
}

/// Bits of 1/4096 step.
const FINE: u32 = 12;

/// 8 times 0.1 steps: the square of a chord's angle is this over the radius.
const SAGITTA: Scaled = Scaled(104 << 24 | 0xCC_CCCD);
/// 2^32 / 2 pi
const PER_RADIAN: Scaled = Scaled::constant(683_565_276);

/// um/256 of an axis as 1/4096 steps, to the nearest.
fn fine(axis: &AxisRecord, um_256: i32) -> i32 {
    let fine = mul_div(size(um_256), u32::from(axis.steps) << 5, u32::from(axis.um));
    signed(((fine >> 1).wrapping_add(fine & 1)) as i32, um_256)
}

/// By how many 1/4096 `value * times / over` is ahead of the whole number next to it, `whole`.
fn ahead(value: i32, times: u32, over: u32, whole: i32) -> i32 {
    let below = mul_div(size(value), times, over);
    let rest = size(value).wrapping_mul(times).wrapping_sub(below.wrapping_mul(over));
    let part = mul_div(rest, 1 << FINE, over) as i32;
    (signed(below as i32, value).wrapping_sub(whole) << FINE) + signed(part, value)
}

impl Walk {
    /// At the beginning of an arc.
    ///
    /// The sagitta of a chord of angle `w` is nearly `r w^2 / 8`; 0.1 steps of that give the widest angle,
    /// `sqrt(0.8 step / r)`. The sweep is cut into the fewest equal chords that are no wider.
    pub fn new(axes: &[AxisRecord; 3], arc: &Arc) -> Walk {
        let (sweep, radius) = (arc.sweep, arc.radius);
        let [a, b, _] = arc.axes();
        let um = |n: usize| Scaled::new(axes[n].um.into()).over(Scaled::new(axes[n].steps.into()));
        let step = um(a).least(um(b));
        let widest = SAGITTA.times(step).over(radius).root().times(PER_RADIAN);
        let count = Scaled::new(sweep).over(widest.least(Scaled::constant(u32::MAX / 12)));
        let chords = count.floor().min(0xFFFE) as u16 + 1;
        let (sine, mut versine) = sine(sweep / u32::from(chords));
        // The radius grows by the end's miss, in equal parts.
        let end = distance(arc.to);
        let mut goal = [0; 3];
        let mut rest = [0; 3];
        for (i, n) in arc.axes().into_iter().enumerate() {
            rest[n] = arc.end[n].wrapping_sub(arc.start[n]);
            if let (Some(center), Some(from)) = (arc.center.get(i), arc.from.get(i)) {
                // The start's whole step is not quite where the arc begins.
                let um = center.wrapping_add(*from);
                goal[n] = ahead(um, axes[n].steps.into(), axes[n].um.into(), arc.start[n]);
            }
        }
        // Turning scales by (1 - versine): less of it lets the radius grow by the same part with each chord.
        let per =
            |d: Scaled| d.over(radius).over(Scaled::new(chords.into())).shifted(32).floor() as i32;
        versine -= per(end.minus(radius)) - per(radius.minus(end));
        Walk {
            arc: *arc,
            point: [arc.from[0] << 8, arc.from[1] << 8],
            sine: if arc.clockwise { -sine } else { sine },
            versine,
            chord: 0,
            chords,
            rest,
            goal,
            exact: [0; 3],
        }
    }

    /// How many chords the arc is made of.
    pub fn chords(&self) -> u16 {
        self.chords
    }

    /// The next chord with any steps; `None` at the end.
    pub fn next(&mut self, axes: &[AxisRecord; 3]) -> Option<Chord> {
        while self.chord != self.chords {
            self.chord += 1;
            let after = self.chords - self.chord;
            let target = self.target(axes, after == 0);
            let chord = self.chord_to(target, after);
            if chord.events != 0 {
                return Some(chord);
            }
        }
        None
    }

    /// The next point, ahead of the axes' whole steps by so many 1/4096 steps: turned by a chord, or the end.
    ///
    /// The rotation `x' = x cos w - y sin w`, `y' = y cos w + x sin w` with `cos w = 1 - versine`: four products. The end is
    /// taken as it was commanded, so what the roundings have added up ends with the arc.
    #[expect(clippy::needless_range_loop, reason = "an iterator costs flash on the chip")]
    fn target(&mut self, axes: &[AxisRecord; 3], last: bool) -> [i32; 3] {
        let [x, y] = self.point;
        let point = if last {
            [self.arc.to[0] << 8, self.arc.to[1] << 8]
        } else {
            [
                x - turned(x, self.versine) - turned(y, self.sine),
                y - turned(y, self.versine) + turned(x, self.sine),
            ]
        };
        let [a, b, c] = self.arc.axes();
        for i in 0..2 {
            let n = if i == 0 { a } else { b };
            // Chord by chord: from the machine's zero it would not fit.
            let chord = fine(&axes[n], point[i].wrapping_sub(self.point[i]));
            self.goal[n] = self.goal[n].wrapping_add(chord);
            if last {
                // Within half a step of the end's whole step, so that it rounds to that.
                let end = self.rest[n] << FINE;
                self.goal[n] = self.goal[n].clamp(end - 2000, end + 2000);
            }
        }
        self.point = point;
        let rise = self.arc.end[c].wrapping_sub(self.arc.start[c]);
        let made = rise.wrapping_sub(self.rest[c]);
        self.goal[c] = ahead(rise, self.chord.into(), self.chords.into(), made);
        self.goal
    }

    /// A chord from where the axes are to `target`; the last one ends on its steps.
    ///
    /// The engine plays whole events: as many as the longest axis has steps, rounded. Each other axis gets its share of
    /// an event as increment (2^32 is a step), and its accumulator starts at one half plus what it is off its whole step, so
    /// that a step comes where the true place passes the middle between two steps. What the rounded events move too far or
    /// leave is kept in `exact`, and the next chord begins there: errors do not add up.
    #[expect(clippy::needless_range_loop, reason = "an iterator costs flash on the chip")]
    fn chord_to(&mut self, target: [i32; 3], after: u16) -> Chord {
        let last = after == 0;
        let mut chord = Chord { after, ..Chord::default() };
        let mut longest = 0;
        for n in 0..3 {
            chord.delta[n] = target[n].wrapping_sub(self.exact[n]);
            let length = if last { size(self.rest[n]) << FINE } else { size(chord.delta[n]) };
            longest = longest.max(length);
        }
        chord.events = (longest + (1 << (FINE - 1))) >> FINE;
        if chord.events == 0 {
            return chord;
        }
        let whole = chord.events << FINE;
        let over = if last { whole } else { longest };
        for n in 0..3 {
            let delta = chord.delta[n];
            let length = size(delta);
            let whole_way = last && size(self.rest[n]) == chord.events;
            let inc = if whole_way { u32::MAX } else { fraction(length, over) };
            // The axis is off its whole step by this; the accumulator continues from there.
            let off = signed(self.exact[n], delta);
            let acc = (0x8000 + (off << 4)).clamp(1, 0xFFFF) as u16;
            let steps = carries(acc, inc, chord.events) as i32;
            let moved = if inc == u32::MAX { whole } else { mul_div(length, whole, over) } as i32;
            let steps = signed(steps, delta);
            self.rest[n] = self.rest[n].wrapping_sub(steps);
            self.goal[n] -= steps << FINE;
            self.exact[n] += signed(moved, delta) - (steps << FINE);
            chord.inc[n] = inc;
            chord.acc[n] = acc;
        }
        chord
    }
}

/// Carries of an accumulator that begins at `acc` in its upper half, over `events` increments, fewer than 2^24:
/// `(acc * 2^16 + inc * events) / 2^32` in 32-bit products. A helix may have more than 65535 events in one chord.
fn carries(acc: u16, inc: u32, events: u32) -> u32 {
    let (inc_high, inc_low) = (inc >> 16, inc & 0xFFFF);
    let (high, low) = (events >> 16, events & 0xFFFF);
    // At most 65535 * 65535 + 2 * 65535.
    let sum = inc_high * low + ((inc_low * low) >> 16) + u32::from(acc);
    if high == 0 {
        return sum >> 16;
    }
    (sum >> 16) + (((sum & 0xFFFF) + inc_low * high) >> 16) + inc_high * high
}

#[cfg(test)]
mod tests {
    use super::carries;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn carries_are_those_of_64_bits(acc: u16, inc: u32, events in 0u32..1 << 24) {
            let exact = (u64::from(acc) << 16) + u64::from(inc) * u64::from(events);
            prop_assert_eq!(u64::from(carries(acc, inc, events)), exact >> 32);
        }
    }

    #[test]
    fn carries_at_the_edges() {
        for events in [0, 1, 65_535, 65_536, 65_537, (1 << 24) - 1] {
            for (acc, inc) in [(0, 0), (0xFFFF, u32::MAX), (0xFFFF, 0xFFFF), (1, u32::MAX - 1)] {
                let exact = (u64::from(acc) << 16) + u64::from(inc) * u64::from(events);
                assert_eq!(
                    u64::from(carries(acc, inc, events)),
                    exact >> 32,
                    "{acc} {inc} {events}"
                );
            }
        }
    }
}
