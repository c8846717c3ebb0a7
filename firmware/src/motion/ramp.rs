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
    /// Events that no segment has taken yet; `u32::MAX` is endless.
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
    /// Present speed.
    v: u16,
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
const INTERVAL_BITS: u8 = 31;

impl Ramp {
    /// A ramp at the beginning of a stretch.
    pub fn new(s: &Stretch) -> Ramp {
        let mut ramp = Ramp::default();
        // The top speed in 16 bits; it may be below 1/s.
        ramp.exp = bits(s.top.max(s.nominal).max(1)) as i8 - 16;
        ramp.pitch(s.length, s.per, s.accel, s.decel);
        ramp.left = s.events;
        ramp.start = ramp.speed(s.start.min(s.nominal));
        ramp.nominal = ramp.speed(s.nominal);
        ramp.exit(s.exit);
        ramp.v = ramp.speed(s.entry);
        ramp.v2 = square(ramp.v);
        (ramp.interval, ramp.shift) = ramp.interval_at(ramp.v);
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
        scale(half, 1 + by - 2 * self.exp).max(1)
    }

    /// A speed in units/s as a mantissa, 1..=65535.
    fn speed(&self, units: u32) -> u16 {
        scale(units, -self.exp).clamp(1, 0xFFFF) as u16
    }

    /// The interval at a speed and the sub-events that it needs.
    fn interval_at(&self, v: u16) -> (u32, u8) {
        let q = self.tick / u32::from(v.max(1));
        let shift = (bits(q) as i8 + self.tick_exp - INTERVAL_BITS as i8).clamp(0, 15);
        let interval = scale(q, self.tick_exp - shift).min((1 << INTERVAL_BITS) - 1);
        (interval, shift as u8)
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
        self.left == 0 || self.braking && self.v <= self.start
    }

    /// Events that no segment has taken yet.
    pub fn left(&self) -> u32 {
        self.left
    }

    /// Present speed, units/s.
    pub fn velocity(&self) -> u32 {
        scale(u32::from(self.v), self.exp)
    }

    /// The next segment of at most `most` events; `None` at rest.
    pub fn next_segment(&mut self) -> Option<Segment> {
        if self.at_rest() {
            return None;
        }
        let n = self.slice();
        let endless = self.left == u32::MAX;
        let left = if endless { self.left } else { self.left - u32::from(n) };
        let target = if self.braking { self.start } else { self.nominal };
        let target2 = square(target);
        let n32 = u32::from(n);
        let mut v2 = if target2 >= self.v2 {
            target2.min(self.v2.saturating_add(mul_sat(self.accel2, n32)))
        } else {
            target2.max(self.v2.saturating_sub(mul_sat(self.decel2, n32)))
        };
        if !endless {
            v2 = v2.min(self.exit2.saturating_add(mul_sat(self.decel2, left)));
        }
        let v = isqrt(v2).max(1);
        let (mut end, end_shift) = self.interval_at(v);
        let shift = self.shift.max(end_shift);
        let begin = self.interval >> (shift - self.shift);
        end >>= shift - end_shift;
        let events = n << shift;
        let dif = (end as i32 - begin as i32) / i32::from(events).max(1);
        let segment = Segment { events, shift, interval: begin.wrapping_add_signed(dif / 2), dif };
        self.interval = begin.wrapping_add_signed(dif * i32::from(events)) << (shift - end_shift);
        self.shift = end_shift;
        self.v2 = v2;
        self.v = v;
        self.left = left;
        Some(segment)
    }

    /// Events of the next segment: a power of two that takes 4 to 8 ms at a constant speed and
    /// half of that on a ramp, where the shorter time keeps the linear interval within 5 % of
    /// constant acceleration; a remainder below one and a half of it is taken at once.
    fn slice(&self) -> u16 {
        let ticks = bits(self.interval >> 16) + self.shift;
        let cruising = u8::from(self.v == self.nominal && !self.braking);
        let n = 1u16 << (16 + cruising).saturating_sub(ticks).min(14);
        if self.left <= u32::from(n + n / 2) { self.left as u16 } else { n }
    }
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
