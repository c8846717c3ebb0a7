//! A checker of motion against physics: from the instants of an axis's steps, whether the motor
//! could follow.
//!
//! It knows nothing of the planner. [`check`] judges one stream of steps, [`Machine::check`] whatever a
//! machine did. Speeds are means over half windows of at least
//! [`HALF_WINDOW`] steps, because one timer tick in a single interval looks like a huge
//! acceleration (1 tick at 30 000 steps/s: 1.7 million steps/s2); the bound is the ramp plus
//! 5 % plus what an error of one tick at each end of a half window can make.

mod record;
#[cfg(test)]
mod tests;

pub use record::{Count, Machine, Step};

/// Steps in each half of a window.
pub const HALF_WINDOW: usize = 10;

/// Ticks in a second of the records that are checked, whatever the chip's step timer has.
pub const TICKS_PER_SECOND: u32 = 16_000_000;
const HZ: f64 = TICKS_PER_SECOND as f64;

/// A time of a step timer of `clock` Hz in the ticks of a record.
pub fn ticks(time: u64, clock: u32) -> u64 {
    time * u64::from(TICKS_PER_SECOND) / u64::from(clock)
}

/// What the axis can follow.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Start and stop rate, steps/s.
    pub start: f64,
    /// Top rate, steps/s.
    pub top: f64,
    /// Ramp up, steps/s2.
    pub accel: f64,
    /// Ramp down, steps/s2.
    pub decel: f64,
}

/// What was found, and at which step.
#[derive(Clone, Debug, PartialEq)]
pub struct Violation {
    /// Index of the step in the record.
    pub step: usize,
    /// What exceeded its bound.
    pub what: What,
    /// The value found, steps/s or steps/s2.
    pub found: f64,
    /// The bound.
    pub bound: f64,
}

/// A bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// Left rest, or came to it, faster than the start rate.
    Start,
    /// Above the top rate.
    Top,
    /// Sped up too fast.
    Accel,
    /// Slowed down too fast.
    Decel,
    /// Changed its speed, forward or backward, by more steps/s than its ramps do in that time.
    Bend,
}

impl Limits {
    /// Highest rate over the interval that leaves rest or comes to it on a ramp: it may already be an
    /// acceleration and a half faster than the start rate.
    pub fn jump(&self, ramp: f64) -> f64 {
        (self.start * self.start + 3.2 * ramp).sqrt() * 1.05
    }
}

fn bound(what: What, step: usize, found: f64, bound: f64) -> Result<(), Violation> {
    if found <= bound { Ok(()) } else { Err(Violation { step, what, found, bound }) }
}

/// Checks one motion from rest to rest in one direction: `times` are the instants of its steps in
/// timer ticks, ascending.
///
/// # Errors
/// The first violation.
pub fn check(times: &[u64], limits: &Limits) -> Result<(), Violation> {
    let rate = |a: usize, b: usize| (b - a) as f64 * HZ / (times[b] - times[a]) as f64;
    let last = times.len().saturating_sub(1);
    if last == 0 {
        return Ok(());
    }
    for i in 0..last {
        let ticks = (times[i + 1] - times[i]) as f64;
        bound(What::Top, i, HZ / (ticks + 1.0), limits.top * 1.02)?;
    }
    // An instant is a whole tick.
    let least = |n: usize| HZ / ((times[n + 1] - times[n]) as f64 + 1.0);
    bound(What::Start, 0, least(0), limits.jump(limits.accel))?;
    bound(What::Start, last, least(last - 1), limits.jump(limits.decel))?;
    let window = 2 * HALF_WINDOW;
    for i in 0..=last.saturating_sub(window) {
        if i + window > last {
            break;
        }
        let (mid, end) = (i + HALF_WINDOW, i + window);
        let (v0, v1) = (rate(i, mid), rate(mid, end));
        let time = (times[end] - times[i]) as f64 / HZ / 2.0;
        let tick = |a: usize, b: usize| 2.0 / (times[b] - times[a]) as f64;
        let slack = (v0 * tick(i, mid) + v1 * tick(mid, end)) / time;
        let a = (v1 - v0) / time;
        bound(What::Accel, mid, a, limits.accel * 1.05 + slack)?;
        bound(What::Decel, mid, -a, limits.decel * 1.05 + slack)?;
    }
    Ok(())
}

/// The instants at which the events of segments fall, ticks, as the engine's compare register
/// would have them, the first segment beginning at `from`.
pub fn instants<'a>(segments: impl IntoIterator<Item = &'a super::Segment>, from: u64) -> Vec<u64> {
    let mut time = from << 16;
    let mut out = Vec::new();
    for s in segments {
        let mut interval = i64::from(s.interval);
        for event in 1..=u32::from(s.events) {
            time += interval as u64;
            interval += i64::from(s.dif);
            if event & u32::from(s.mask) == 0 {
                out.push(time >> 16);
            }
        }
    }
    out
}
