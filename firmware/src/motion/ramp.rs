//! The ramp generator: from a stretch of equal events and its speeds to segments of linearly
//! changing intervals.
//!
//! A stretch is a number of *events* (a step of the axis with most steps) that lie `pitch` path
//! units apart (um for a path, 1/256 step for an axis of its own). Speeds are kept as 16-bit
//! mantissas of a common exponent and squared in 32 bits, where constant acceleration is a
//! constant sum: `v1^2 = v0^2 + 2 a n`. One segment lasts 3 to 8 ms; its end speed is
//!
//! `v1^2 = min(v0^2 + 2 a n, nominal^2, exit^2 + 2 d left)`
//!
//! so the mean acceleration of a segment never exceeds the ramp, and the last term makes a short
//! move a triangle by itself. The interval between events then runs linearly from `1 / v0` to
//! `1 / v1`. Each segment takes one square root and two divisions, a step takes none.

use super::math::{bits, isqrt, mul_div, mul_sat, scale};

/// A piece of a motion with linearly changing time between events, as the step engine takes it.
///
/// The first event comes `interval` after the event before it; after each event `dif` is added
/// to `interval`. Where an interval would not fit the timer's 16 bits, the segment runs on
/// `2^shift` sub-events for each event, of which only the last one steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Segment {
    /// Number of sub-events, 1..=65535, a multiple of `2^shift`.
    pub events: u16,
    /// Sub-events per event as a power of two, 0..=15.
    pub shift: u8,
    /// First interval, 1/65536 timer ticks of 1/16 us, below 2^31.
    pub interval: u32,
    /// Change of the interval after each sub-event, 1/65536 ticks.
    pub dif: i32,
}

impl Segment {
    /// Time from the event before the first one to the last one, in 1/65536 timer ticks.
    pub fn duration(&self) -> u64 {
        let n = i64::from(self.events);
        let sum = n * i64::from(self.interval) + n * (n - 1) / 2 * i64::from(self.dif);
        sum.unsigned_abs()
    }

    /// Number of events, each a step of the axis with most steps.
    pub fn steps(&self) -> u16 {
        self.events >> self.shift
    }
}

/// What a stretch of equal events may do; units of length are the caller's, see the module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stretch {
    /// Number of events, at least 1.
    pub events: u32,
    /// Length in units of `per` events.
    pub length: u32,
    /// See `length`.
    pub per: u32,
    /// Speed at its beginning, units/s.
    pub entry: u32,
    /// Speed from which and to which the machine may jump, units/s.
    pub start: u32,
    /// Speed that is asked for, units/s, at least 1.
    pub nominal: u32,
    /// Highest speed that may ever be asked for (override), units/s.
    pub top: u32,
    /// Speed at its end, units/s.
    pub exit: u32,
    /// Ramp up, units/s2.
    pub accel: u32,
    /// Ramp down, units/s2.
    pub decel: u32,
}

/// The state of a ramp over one stretch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ramp {
    /// Events that no segment has taken yet.
    left: u32,
    /// Square of the present speed.
    v2: u32,
    /// Square of the speed at which the stretch must end.
    exit2: u32,
    /// Growth of the squared speed over one event.
    accel2: u32,
    /// Its decline over one event while braking.
    decel2: u32,
    /// Interval at speed 1 as a mantissa with its top bit set.
    tick: u32,
    /// Present interval, 1/65536 ticks, of sub-events of `shift`.
    interval: u32,
    /// Present speed, normalized: the root of `v2` is `root / 2^root_exp`.
    root: u16,
    /// See `root`.
    root_exp: i8,
    /// Speed to run at.
    nominal: u16,
    /// Speed at which to come to rest.
    start: u16,
    /// Exponent of all speeds: units/s = mantissa * 2^exp.
    exp: i8,
    /// Exponent of `tick` over speed: 1/65536 ticks = tick / v * 2^tick_exp.
    tick_exp: i8,
    /// Sub-events of `interval` as a power of two.
    shift: u8,
    /// Ramp down to `start` and rest there.
    braking: bool,
}

/// An eighth of the timer's rate: 16 MHz times a pitch of 2000 units still fits into 32 bits.
const TIMER_HZ_8: u32 = 2_000_000;

/// Longest interval that the engine takes, in bits of 1/65536 ticks: 32 767 ticks, for its signed
/// lateness test.
const INTERVAL_BITS: i8 = 31;

/// The ramps are planned lower by 1 / 2^5, which leaves room for what a linear interval exceeds
/// constant acceleration by within a segment.
const MARGIN: u32 = 5;

impl Ramp {
    /// A ramp at the beginning of a stretch.
    pub fn new(s: &Stretch) -> Ramp {
        // The top speed in 16 bits; it may be below 1/s.
        let mut ramp =
            Ramp { exp: bits(s.top.max(s.nominal).max(1)) as i8 - 16, ..Ramp::default() };
        ramp.pitch(s.length, s.per, s.accel, s.decel);
        ramp.left = s.events;
        ramp.start = ramp.speed(s.start.min(s.nominal));
        ramp.nominal = ramp.speed(s.nominal);
        ramp.exit(s.exit);
        ramp.v2 = square(ramp.speed(s.entry));
        (ramp.root, ramp.root_exp) = root(ramp.v2);
        (ramp.interval, ramp.shift) = ramp.interval_at(ramp.root, ramp.root_exp);
        ramp
    }

    /// Sets what depends on the distance between events: `length` units for `events` of them.
    fn pitch(&mut self, length: u32, events: u32, accel: u32, decel: u32) {
        let tick = mul_div(TIMER_HZ_8, length, events).max(1);
        let up = tick.leading_zeros() as i8;
        self.tick = tick << up;
        // 16 MHz in 1/65536 ticks is TIMER_HZ_8 * 2^19.
        self.tick_exp = 19 - self.exp - up;
        self.accel2 = self.energy(accel, length, events);
        self.decel2 = self.energy(decel, length, events);
    }

    /// `2 * accel * length / events` in squared mantissas, at least 1.
    fn energy(&self, accel: u32, length: u32, events: u32) -> u32 {
        let by = self.exp.max(0);
        let half = mul_div(accel, length, scale(events, by));
        let energy = scale(half, 1 + by - 2 * self.exp);
        (energy - (energy >> MARGIN)).max(1)
    }

    /// A speed in units/s as a mantissa, 1..=65535.
    fn speed(&self, units: u32) -> u16 {
        scale(units, -self.exp).clamp(1, 0xFFFF) as u16
    }

    /// The interval at the speed `root / 2^exp` and the sub-events that it needs.
    fn interval_at(&self, root: u16, exp: i8) -> (u32, u8) {
        let q = self.tick / u32::from(root);
        let by = self.tick_exp + exp;
        let shift = (bits(q) as i8 + by - INTERVAL_BITS).clamp(0, 15);
        (self.interval_of(q, by - shift), shift as u8)
    }

    /// `q * 2^by` within the engine's range.
    fn interval_of(&self, q: u32, by: i8) -> u32 {
        scale(q, by).min((1 << INTERVAL_BITS) - 1)
    }

    /// A segment of `n` events from the present speed to the root of `v2`, now the present one.
    ///
    /// The mean interval is that of constant acceleration, `2 / (v0 + v)`, and the line through
    /// it begins or ends at the shorter of `1 / v0` and `1 / v`: there, where the same change of
    /// interval is the most acceleration, it exceeds the ramp by no more than `(v - v0) / v0`.
    fn segment(&mut self, n: u16, v2: u32) -> Segment {
        if v2 == self.v2 {
            return Segment {
                events: n << self.shift,
                shift: self.shift,
                interval: self.interval,
                dif: 0,
            };
        }
        let (root, exp) = root(v2);
        let (end, end_shift) = self.interval_at(root, exp);
        let shift = self.shift.max(end_shift);
        let shortest = (self.interval >> (shift - self.shift)).min(end >> (shift - end_shift));
        let common = exp.min(self.root_exp);
        let sum = (u32::from(root) >> (exp - common))
            + (u32::from(self.root) >> (self.root_exp - common));
        let q = self.tick / sum;
        let middle = self.interval_of(q, self.tick_exp + 1 + common - shift as i8);
        let events = n << shift;
        let change = 2 * middle.saturating_sub(shortest) / u32::from(events);
        let half = change * u32::from(events - 1) / 2;
        let faster = v2 > self.v2;
        (self.interval, self.shift) = (end, end_shift);
        (self.root, self.root_exp) = (root, exp);
        self.v2 = v2;
        let (interval, dif) =
            if faster { (middle + half, -(change as i32)) } else { (middle - half, change as i32) };
        Segment { events, shift, interval, dif }
    }

    /// Asks for another speed, units/s, not above the stretch's top.
    pub fn nominal(&mut self, units: u32) {
        self.nominal = self.speed(units);
    }

    /// Sets the speed at the end of the stretch, units/s: raised when another block joins.
    pub fn exit(&mut self, units: u32) {
        self.exit2 = square(self.speed(units));
    }

    /// Brakes to rest wherever that is, or goes on again.
    pub fn brake(&mut self, on: bool) {
        self.braking = on;
    }

    /// Whether a braking ramp has come to the speed from which it may stand still, or the stretch
    /// is over.
    pub fn at_rest(&self) -> bool {
        self.left == 0 || self.braking && self.is_slow()
    }

    /// Whether what is left suffices to come down to the exit speed.
    pub fn can_stop(&self) -> bool {
        self.v2 <= self.exit2.saturating_add(mul_sat(self.decel2, self.left))
    }

    /// Whether the present speed is one from which the machine may stand still at once.
    pub fn is_slow(&self) -> bool {
        self.v2 <= square(self.start)
    }

    /// Events that no segment has taken yet.
    pub fn left(&self) -> u32 {
        self.left
    }

    /// Present speed, units/s.
    pub fn velocity(&self) -> u32 {
        scale(u32::from(self.root), self.exp - self.root_exp)
    }

    /// The next segment of at most `most` events; `None` at rest.
    pub fn next_segment(&mut self) -> Option<Segment> {
        if self.at_rest() {
            return None;
        }
        let n = self.slice();
        let left = self.left - u32::from(n);
        let target = if self.braking { self.start } else { self.nominal };
        let target2 = square(target);
        let n32 = u32::from(n);
        let mut v2 = if target2 >= self.v2 {
            target2.min(self.v2.saturating_add(mul_sat(self.accel2, n32)))
        } else {
            target2.max(self.v2.saturating_sub(mul_sat(self.decel2, n32)))
        };
        v2 = v2.min(self.exit2.saturating_add(mul_sat(self.decel2, left)));
        self.left = left;
        let segment = self.segment(n, v2.max(1));
        Some(segment)
    }

    /// Events of the next segment: a power of two that takes 4 to 8 ms at a constant speed and
    /// half of that on a ramp, where the shorter time keeps the linear interval within 5 % of
    /// constant acceleration, and no more than changes the speed by 1/32, but not below 8 events.
    /// A remainder below one and a half of it is taken at once.
    fn slice(&self) -> u16 {
        let ticks = bits(self.interval >> 16) + self.shift;
        let cruising = u8::from(self.v2 == square(self.nominal) && !self.braking);
        let mut n = 1u16 << (16 + cruising).saturating_sub(ticks).min(14);
        let steep = self.accel2.max(self.decel2);
        while n > 8 && mul_sat(steep, u32::from(n)) > self.v2 >> 4 {
            n >>= 1;
        }
        if self.left <= u32::from(n + n / 2) { self.left as u16 } else { n }
    }
}

/// The square root of `v2`, at least 1, as a 16-bit mantissa with its top bit set and the power of
/// two by which it is too large: slow speeds keep their precision.
fn root(v2: u32) -> (u16, i8) {
    let exp = v2.leading_zeros() as i8 / 2;
    (isqrt(v2 << (2 * exp)), exp)
}

/// A square in 32 bits.
fn square(v: u16) -> u32 {
    u32::from(v) * u32::from(v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::TICKS_PER_SECOND;
    use proptest::prelude::*;

    fn seconds(ramp: &mut Ramp) -> (f64, u32) {
        let (mut time, mut events) = (0.0, 0);
        while let Some(s) = ramp.next_segment() {
            assert!(s.interval < 1 << 31, "{s:?}");
            assert_eq!(s.events & ((1 << s.shift) - 1), 0, "{s:?}");
            events += u32::from(s.steps());
            time += s.duration() as f64 / 65536.0 / f64::from(TICKS_PER_SECOND);
        }
        (time, events)
    }

    /// Time of a trapezoid or triangle from and to `start`, s.
    fn ideal(n: f64, start: f64, nominal: f64, accel: f64, decel: f64) -> f64 {
        let start = start.min(nominal);
        let up = (nominal * nominal - start * start) / (2.0 * accel);
        let down = (nominal * nominal - start * start) / (2.0 * decel);
        if up + down <= n {
            (nominal - start) / accel + (nominal - start) / decel + (n - up - down) / nominal
        } else {
            let peak = (start * start + 2.0 * n * accel * decel / (accel + decel)).sqrt();
            (peak - start) / accel + (peak - start) / decel
        }
    }

    proptest! {
        #[test]
        fn a_ramp_takes_the_time_of_its_trapezoid(
            n in 1u32..60_000,
            start in 100u32..2_000,
            nominal in 1u32..100_000,
            accel in 2_000u32..60_000,
            decel in 2_000u32..60_000,
        ) {
            prop_assume!(n < nominal * 20);
            let mut ramp = Ramp::new(&Stretch {
                events: n, length: 256, per: 1,
                entry: start.min(nominal) * 256, start: start * 256, nominal: nominal * 256,
                top: 100_000 * 256, exit: start * 256, accel: accel * 256, decel: decel * 256,
            });
            let (time, events) = seconds(&mut ramp);
            prop_assert_eq!(events, n);
            let want = ideal(n.into(), start.into(), nominal.into(), accel.into(), decel.into());
            prop_assert!((time - want).abs() < want * 0.03 + 0.01, "{} for {}", time, want);
        }
    }
}
