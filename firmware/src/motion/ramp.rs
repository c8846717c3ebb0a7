//! The ramp generator: from a run of equal events and its speeds to segments of linearly
//! changing intervals.
//!
//! A run is a number of *events* (a step of the axis with most steps) that lie one *pitch* apart
//! (um for a path, one step for an axis of its own). With squared speeds, constant acceleration
//! is a constant sum: `v1^2 = v0^2 + 2 a n`. One segment lasts 2 to 8 ms; its end speed is
//!
//! `v1^2 = min(v0^2 + 2 a n, nominal^2, exit^2 + 2 d left)`
//!
//! so the mean acceleration of a segment never exceeds the ramp, and the last term makes a short
//! move a triangle by itself. A segment takes two roots and three divisions, a step takes none.
//!
//! `v^2 = v0^2 + 2 a s` is how grbl's planner and Klipper's look-ahead count speeds, too. A first interval, a constant
//! change of it and a count are the format of Klipper's `queue_step`. AVR446 and Austin ("Generate stepper-motor speed
//! profiles in real time", 2005) divide for each step instead, which a 16-bit chip cannot do at 40 000 steps/s.

use super::scaled::Scaled;

/// A piece of a motion with linearly changing time between events, as the step engine takes it.
///
/// The first event comes `interval` after the event before it; after each event `dif` is added
/// to `interval`. Where an interval would not fit the timer's 16 bits, an event is made of
/// `mask + 1` sub-events, of which only the last one steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Segment {
    /// First interval, 1/65536 timer ticks, below 2^31.
    pub interval: u32,
    /// Change of the interval after each sub-event, 1/65536 ticks.
    pub dif: i32,
    /// Number of sub-events, a multiple of `mask + 1`.
    pub events: u16,
    /// Sub-events of an event less one: a power of two less one.
    pub mask: u16,
}

impl Segment {
    /// Nothing.
    pub const NONE: Segment = Segment { interval: 0, dif: 0, events: 0, mask: 0 };

    /// Time from the event before the first one to the last one, in 1/65536 timer ticks.
    pub fn duration(&self) -> u64 {
        let n = i64::from(self.events);
        let sum = n * i64::from(self.interval) + n * (n - 1) / 2 * i64::from(self.dif);
        sum.unsigned_abs()
    }

    /// Number of events, each a step of the axis with most steps.
    pub fn steps(&self) -> u16 {
        (u32::from(self.events) / (u32::from(self.mask) + 1)) as u16
    }
}

/// What a run of events may do; lengths in units of the caller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Limits {
    /// Square of the speed to run at, (units/s)^2.
    pub nominal2: Scaled,
    /// Square of the speed from which and to which the machine may jump.
    pub start2: Scaled,
    /// Square of the speed at the end.
    pub exit2: Scaled,
    /// Growth of the squared speed over one event.
    pub accel2: Scaled,
    /// Its decline over one event while braking.
    pub decel2: Scaled,
    /// Interval at speed 1, ticks.
    pub tick: Scaled,
    /// The next line is planned meanwhile, as on the small chip in a course: segments are as long on a ramp as at a constant
    /// speed.
    #[cfg(not(target_arch = "msp430"))]
    pub through: bool,
}

/// Twice a ramp, less 1/32: that leaves room for what a linear interval exceeds constant
/// acceleration by within a segment.
const TWICE: Scaled = Scaled::constant(31);

impl Limits {
    /// Nothing allowed.
    pub const NONE: Limits = Limits {
        nominal2: Scaled::ZERO,
        start2: Scaled::ZERO,
        exit2: Scaled::ZERO,
        accel2: Scaled::ZERO,
        decel2: Scaled::ZERO,
        tick: Scaled::ZERO,
        #[cfg(not(target_arch = "msp430"))]
        through: false,
    };

    /// Sets what depends on the pitch, units per event: `accel` and `decel` in units/s2, the step timer's `clock`
    /// in Hz.
    pub fn set_pitch(&mut self, pitch: Scaled, accel: Scaled, decel: Scaled, clock: Scaled) {
        let energy = pitch.times(TWICE).shifted(-4);
        self.accel2 = accel.times(energy);
        self.decel2 = decel.times(energy);
        self.tick = pitch.times(clock);
    }
}

/// The changing part of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Run {
    /// Events that no segment has taken yet.
    pub left: u32,
    /// Square of the present speed, not 0.
    pub v2: Scaled,
    /// The last one that was taken a root of, with it: segments follow one another.
    pub known: (Scaled, Scaled),
    /// Sum of the speeds at both ends of the last segment.
    pub sum: Scaled,
}

impl Run {
    /// At its end.
    pub const NONE: Run =
        Run { left: 0, v2: Scaled::ZERO, known: (Scaled::ZERO, Scaled::ZERO), sum: Scaled::ZERO };

    /// Whether what is left suffices to come down to the exit speed.
    pub fn can_stop(&self, limits: &Limits) -> bool {
        self.v2 <= limits.exit2.plus(limits.decel2.times(Scaled::new(self.left)))
    }

    /// The next segment; `false` at rest: when nothing is left or, while `braking`, at a speed no
    /// higher than the start rate.
    ///
    /// The mean interval is that of constant acceleration, `2 / (v0 + v1)`, and the line through
    /// it begins or ends at the shorter of `1 / v0` and `1 / v1`: there, where the same change of
    /// interval is the most acceleration, it exceeds the ramp by no more than `(v1 - v0) / v0`.
    ///
    /// Units: `v` in units/s, `v2` in (units/s)^2, `tick` in ticks at 1 unit/s, intervals in 1/65536 tick.
    pub fn segment(&mut self, limits: &Limits, braking: bool, out: &mut Segment) -> bool {
        if self.left == 0 || braking && self.v2 <= limits.start2 {
            return false;
        }
        let v0 = if self.v2 == self.known.0 { self.known.1 } else { self.v2.root() };
        let n = self.slice(limits, v0, braking);
        self.left -= u32::from(n);
        let target = if braking { limits.start2 } else { limits.nominal2 };
        let mut v2 = self.v2;
        if v2 != target {
            let events = Scaled::new(n.into());
            v2 = if target > v2 {
                v2.plus(limits.accel2.times(events)).least(target)
            } else {
                v2.minus(limits.decel2.times(events)).most(target)
            };
        }
        // Never faster than the events after this segment, which `left` counts now, can brake from.
        v2 = v2.least(limits.exit2.plus(limits.decel2.times(Scaled::new(self.left))));
        // At a constant speed, most of the time of a long move, one root and one division do.
        let v1 = if v2 == self.v2 { v0 } else { v2.root() };
        self.known = (v2, v1);
        let sum = v0.plus(v1);
        self.sum = sum;
        // An interval above 2^15 ticks is halved until it fits; each half is a sub-event.
        let sub = LONGEST.saturating_sub(sum.exponent_over(limits.tick)).clamp(0, 15);
        let shortest = limits.tick.over(v0.most(v1)).shifted(16 - sub).floor();
        let events = n << sub;
        out.events = events;
        out.mask = (1 << sub) - 1;
        out.interval = shortest;
        out.dif = 0;
        if v2 != self.v2 {
            // Constant acceleration takes `2 n pitch / (v0 + v1)` for n events, so the mean interval is twice `tick` over
            // the sum. The line of intervals goes from `shortest` at the faster end to `shortest + span` at the
            // slower one; each event takes the value in its middle, hence the half `change` at either end.
            let middle = limits.tick.over(sum).shifted(17 - sub).floor();
            let span = 2 * middle.saturating_sub(shortest);
            let change = span / u32::from(events);
            out.interval = shortest + change / 2;
            out.dif = change as i32;
            if v2 > self.v2 {
                out.interval = shortest + span - change / 2;
                out.dif = -out.dif;
            }
        }
        self.v2 = v2;
        true
    }

    /// Events of the next segment: a power of two that takes 4 to 8 ms while the speed stays what it is,
    /// half of that on a ramp and where the brake is near, and there no more than changes the speed by
    /// about 1/32 (but 1 to 2 ms), which keeps the linear interval within 5 % of constant
    /// acceleration. A remainder below one and a quarter of it is taken at once.
    ///
    /// Powers of two need no division: the exponent of a quotient is the difference of two exponents. With
    /// `e = exponent of tick / v` an interval has 2^e to 2^(e+1) ticks, so `2^(15 - e)` events last 2^15 to 2^16 ticks (2 to
    /// 4 ms at 16 MHz); twice as many at a constant speed. With `f = exponent of accel2 / v2`, `2^(-5 - f)` events change
    /// v^2 by 1/32 to 1/16 of it, which is 1/64 to 1/32 of v.
    fn slice(&self, limits: &Limits, v: Scaled, braking: bool) -> u16 {
        let mut exp = 15i8.saturating_sub(limits.tick.exponent_over(v));
        let cruises =
            self.v2 == limits.nominal2 && !braking && self.cruises(limits, exp.saturating_add(2));
        #[cfg(not(target_arch = "msp430"))]
        let cruises = cruises || limits.through;
        if cruises {
            exp = exp.saturating_add(1);
        } else {
            let steep = limits.accel2.most(limits.decel2);
            exp = exp.min(
                (-5i8).saturating_sub(steep.exponent_over(self.v2)).max(exp.saturating_sub(1)),
            );
        }
        let n = 1u16 << exp.clamp(0, 14);
        if self.left <= u32::from(n + n / 4) { self.left as u16 } else { n }
    }

    /// Whether no brake begins within `2^exp` events. `left * decel2 - v2` is what can be braked beyond a stop; over `decel2`
    /// it is the number of events until the brake begins. The exit speed is taken for 0, which errs to shorter segments.
    fn cruises(&self, limits: &Limits, exp: i8) -> bool {
        let runs_through = limits.exit2 > limits.start2 && limits.exit2 >= self.v2;
        let spare = Scaled::new(self.left).times(limits.decel2).minus(self.v2);
        runs_through || spare >= limits.decel2 && spare.exponent_over(limits.decel2) >= exp
    }
}

/// The mean interval of a segment is twice the pitch's ticks over both speeds' sum, its longest one is
/// less than twice that: below 2^15 ticks, for the engine's signed lateness test, when the sum over the
/// ticks is at least 2 to this, and one less for each halving.
const LONGEST: i8 = -13;
