//! The acceleration of the head, from the times of its steps: what hangs on a weak vacuum is lost by it.
//!
//! Speeds are means of windows of 20 ms or more, between the first step and the last one in each; an acceleration is the
//! difference of two of them over the time between their middles. So it is exact where an axis has a ramp longer than two
//! windows, and a jump of the speed counts as a ramp of one window. An axis that steps beside a faster one does so up to
//! a step of that late: so much of a difference is not believed.

use crate::law::Steps;
use crate::region::Scale;

/// Shortest window, us.
const WINDOW_US: u64 = 20_000;
/// Steps of the fastest axis that a window has at least.
const LEAST: u32 = 4;
/// After so long without a step the head rests, us.
const REST_US: u64 = 3 * WINDOW_US;

/// The steps of an axis in a window: the first and the last one, each with its time, us.
#[derive(Clone, Copy, Debug, Default)]
struct Way {
    first: (u64, i32),
    last: (u64, i32),
    steps: u32,
}

/// The mean speed of a window, and what of it is not certain.
#[derive(Clone, Copy, Debug)]
struct Speed {
    /// Middle of the window, us.
    at_us: f64,
    mm_s: [f64; 3],
    off: [f64; 3],
}

/// See the module.
#[derive(Clone, Debug, Default)]
pub(super) struct Shake {
    /// Where the head was at the last call.
    at: Option<Steps>,
    /// When the window began, us; `None` at rest.
    began: Option<u64>,
    ways: [Way; 3],
    before: Option<Speed>,
    /// When the last step came, and the longest time between two steps of the fastest axis in the last window, us.
    last_us: u64,
    interval_us: u64,
}

impl Shake {
    /// When it must be told the time if no step comes; `None` at rest.
    pub(super) fn due(&self) -> Option<u64> {
        self.began.map(|_| self.last_us + REST_US)
    }

    /// The head is there at a time. Gives the acceleration, mm/s^2, where one has become known.
    pub(super) fn look(&mut self, at: &Steps, us: u64, scale: Scale) -> Option<f64> {
        let before = *self.at.get_or_insert(*at);
        self.at = Some(*at);
        if before[..3] != at[..3] {
            self.began.get_or_insert(us);
            self.last_us = us;
            for axis in (0..3).filter(|&axis| before[axis] != at[axis]) {
                let (way, here) = (&mut self.ways[axis], (us, at[axis]));
                if way.steps == 0 {
                    way.first = here;
                }
                way.last = here;
                way.steps += 1;
            }
        }
        let began = self.began?;
        if us >= self.last_us + REST_US {
            let ended = self.before.map(|before| {
                let dt = self.last_us as f64 - before.at_us + self.slack_us();
                acceleration(&before, &Speed { mm_s: [0.0; 3], off: [0.0; 3], ..before }, dt)
            });
            *self = Shake { at: self.at, ..Shake::default() };
            return ended;
        }
        let most = self.ways.iter().map(|way| way.steps).max()?;
        if us < began + WINDOW_US || most < LEAST {
            return None;
        }
        let speed = self.speed(scale)?;
        let found = match self.before {
            Some(before) => acceleration(&before, &speed, speed.at_us - before.at_us),
            None => {
                let dt = speed.at_us - began as f64 + self.slack_us();
                acceleration(&Speed { mm_s: [0.0; 3], off: [0.0; 3], ..speed }, &speed, dt)
            }
        };
        (self.before, self.began, self.ways) = (Some(speed), Some(us), Default::default());
        Some(found)
    }

    /// A motion begins before its first step and ends behind its last one: how long, at most, us.
    fn slack_us(&self) -> f64 {
        WINDOW_US.max(3 * self.interval_us) as f64
    }

    /// The mean speed of the window that ends.
    fn speed(&mut self, scale: Scale) -> Option<Speed> {
        let steps = |way: &Way| way.last.1.abs_diff(way.first.1).max(1);
        let main = (0..3).max_by_key(|&axis| self.ways[axis].steps)?;
        let fastest = self.ways[main];
        let takes = fastest.last.0 - fastest.first.0;
        let each = takes as f64 / f64::from(steps(&fastest));
        self.interval_us = each.ceil() as u64;
        let mut speed = Speed {
            at_us: (fastest.first.0 + fastest.last.0) as f64 / 2.0,
            mm_s: [0.0; 3],
            off: [0.0; 3],
        };
        for (axis, (way, scale)) in self.ways.iter().zip(scale).enumerate() {
            let seconds = way.last.0.saturating_sub(way.first.0) as f64 / 1e6;
            if way.steps < 2 || seconds <= 0.0 {
                // A step less than those that would not fit: it goes at most so fast.
                let most = f64::from(way.steps + 1) / scale.abs();
                speed.off[axis] = most / (takes as f64 / 1e6);
                continue;
            }
            speed.mm_s[axis] = f64::from(way.last.1 - way.first.1) / scale / seconds;
            if axis != main {
                speed.off[axis] = speed.mm_s[axis].abs() * each / 1e6 / seconds;
            }
        }
        Some(speed)
    }
}

/// What is certain of the acceleration between two speeds, mm/s^2; `dt` is the time between them, us.
fn acceleration(from: &Speed, to: &Speed, dt: f64) -> f64 {
    let change = |axis: usize| {
        let off = from.off[axis] + to.off[axis];
        ((to.mm_s[axis] - from.mm_s[axis]).abs() - off).max(0.0)
    };
    let change = (0..3).map(|axis| change(axis).powi(2)).sum::<f64>().sqrt();
    change / (dt.max(WINDOW_US as f64 / 2.0) / 1e6)
}
