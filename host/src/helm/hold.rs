//! A jog while a button is held, as a chain of bounded moves.
//!
//! The board needs no clock for it: each accepted keep-alive gives the axis a target that it reaches
//! within [`LOOK_AHEAD`] of the write, its ramp included. If page, browser, tool or
//! cable fails, the axis rests within that time, because it gets no farther target.

use std::time::{Duration, Instant};

use lang::axis::Axis;

use super::User;

/// How long the axis goes on behind the last keep-alive.
pub const LOOK_AHEAD: Duration = Duration::from_millis(300);
/// Room that is left for the request's way over the line and the board's main loop.
const LINE: Duration = Duration::from_millis(20);
/// A hold without an accepted keep-alive for so long is over.
pub const KEEP_FRESH: Duration = Duration::from_millis(250);
/// Ramps of a held jog are no longer than this: so the next keep-alive finds it at full speed.
const LONGEST_RAMP: f64 = 0.1;

/// Least rate of a held axis, steps/s: a slower one stands at its target between two keep-alives, where a Stop of
/// somebody else cannot be told from the arrival.
pub const SLOWEST: u32 = 20;

/// Why a hold is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Over {
    /// No hold has this number, or it is over already.
    Unknown,
    /// The button was let go.
    Released,
    /// No keep-alive came in time.
    Silent,
}

impl Over {
    /// For people.
    pub const fn text(self) -> &'static str {
        match self {
            Over::Unknown => "this hold is over",
            Over::Released => "let go",
            Over::Silent => "no sign of life from the page: the axis stopped by itself",
        }
    }
}

/// What the owner is to do for a hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Due {
    /// Give the axis its next target.
    Extend,
    /// Stop it.
    End(Over),
}

/// A held jog.
#[derive(Clone, Debug)]
pub struct Hold {
    user: User,
    id: u64,
    /// The axis.
    pub axis: Axis,
    /// Toward larger positions.
    pub positive: bool,
    /// Full speed, steps/s.
    pub rate: u32,
    /// The flatter of the axis's ramps, steps/s2.
    pub accel: u32,
    /// Lowest and highest machine position in steps once the axis is homed.
    pub travel: (i64, i64),
    /// Machine position in steps that it does not go beyond.
    bound: Option<i64>,
    begun: Instant,
    accepted: Instant,
    /// A keep-alive was accepted and is not on the board yet.
    due: bool,
    released: bool,
}

impl Hold {
    /// A jog of `user` with a number of its own, alive for one keep-alive's time. `rate` is bounded so
    /// that the ramp is short.
    pub fn new(
        (user, id): (User, u64),
        axis: Axis,
        positive: bool,
        (rate, accel): (u32, u32),
        travel: (i64, i64),
    ) -> Hold {
        let now = Instant::now();
        let most = (f64::from(accel) * LONGEST_RAMP) as u32;
        let rate = rate.min(most).max(1);
        Hold {
            user,
            id,
            axis,
            positive,
            rate,
            accel: accel.max(1),
            travel,
            bound: None,
            begun: now,
            accepted: now,
            due: true,
            released: false,
        }
    }

    /// The same, which goes no further than a machine position in steps.
    #[must_use]
    pub const fn bounded(self, bound: Option<i64>) -> Hold {
        Hold { bound, ..self }
    }

    /// Whose it is.
    pub const fn user(&self) -> User {
        self.user
    }

    /// Its number.
    pub const fn id(&self) -> u64 {
        self.id
    }

    pub(super) fn is(&self, user: User, id: u64) -> bool {
        (self.user, self.id) == (user, id)
    }

    /// Takes a keep-alive; one that comes too late revives nothing.
    pub(super) fn keep(&mut self, now: Instant) -> Result<(), Over> {
        if self.released {
            return Err(Over::Released);
        }
        if now - self.accepted > KEEP_FRESH {
            return Err(Over::Silent);
        }
        self.accepted = now;
        self.due = true;
        Ok(())
    }

    pub(super) const fn release(&mut self) {
        self.released = true;
    }

    /// What is to be done now.
    pub(super) fn due(&mut self, now: Instant) -> Option<Due> {
        if self.released {
            Some(Due::End(Over::Released))
        } else if now.saturating_duration_since(self.accepted) > KEEP_FRESH {
            Some(Due::End(Over::Silent))
        } else {
            std::mem::take(&mut self.due).then_some(Due::Extend)
        }
    }

    /// When it is over without a further keep-alive.
    pub(super) fn until(&self) -> Instant {
        self.accepted + KEEP_FRESH
    }

    /// Steps from where the axis is to the place that it may go to now.
    pub(super) fn reach(&self, now: Instant) -> i64 {
        let (full, accel) = (f64::from(self.rate), f64::from(self.accel));
        // Time that is left of the keep-alive, which may have waited for the line.
        let age = now.saturating_duration_since(self.accepted);
        let time = LOOK_AHEAD.saturating_sub(LINE).saturating_sub(age).as_secs_f64();
        let present = (accel * now.saturating_duration_since(self.begun).as_secs_f64()).min(full);
        // Up to a peak and down to rest in exactly that time, at most at full speed.
        let peak = full.min((present + accel * time) / 2.0);
        if peak < present {
            // No time but for the ramp down.
            return (present * present / (2.0 * accel)) as i64;
        }
        let ramps = (2.0 * peak - present) / accel;
        let ways = (2.0 * peak * peak - present * present) / (2.0 * accel);
        (ways + peak * (time - ramps).max(0.0)) as i64
    }

    /// Whether an axis that has `left` steps to its target was stopped by somebody else, another process
    /// at the line or the machine's own Stop: it rests there, or became slower (steps/s) farther away
    /// than its ramp begins.
    pub(super) fn was_stopped(&self, left: i64, before: u32, now: u32) -> bool {
        let left = left.unsigned_abs() as f64;
        let ramp = f64::from(before) * f64::from(before) / (2.0 * f64::from(self.accel));
        // Speeds are told to some per cent, and places are a moment older.
        let slower = f64::from(now) < 0.8 * f64::from(before);
        left > 0.0 && slower && left > 1.5 * ramp + 20.0
    }

    /// The target for an axis at machine position `at`, which never comes back behind `last`.
    pub(super) fn target(&self, at: i64, last: Option<i64>, homed: bool, now: Instant) -> i64 {
        let reach = self.reach(now);
        let (low, high) = self.travel;
        let target = if self.positive {
            last.unwrap_or(i64::MIN).max(at + reach)
        } else {
            last.unwrap_or(i64::MAX).min(at - reach)
        };
        // Where it is to go, an axis that stands beyond stays.
        let target = match self.bound {
            Some(bound) if self.positive => target.min(bound.max(at)),
            Some(bound) => target.max(bound.min(at)),
            None => target,
        };
        if !homed {
            return target;
        }
        // Never beyond the travel, and an axis that stands beyond it may only come back.
        if self.positive { target.min(high.max(at)) } else { target.max(low.min(at)) }
    }
}

#[cfg(test)]
mod tests {
    use super::{Due, Hold, KEEP_FRESH, LOOK_AHEAD, Over};
    use crate::helm::User;
    use lang::axis::Axis;
    use std::time::Duration;

    fn hold(rate: u32, accel: u32) -> Hold {
        Hold::new((User::new(), 7), Axis::X, true, (rate, accel), (0, 30_000))
    }

    /// Time that the axis needs for `steps` from speed `v` down to rest, at full speed `full`.
    fn time(steps: f64, v: f64, full: f64, accel: f64) -> f64 {
        let mut peak = ((2.0 * accel * steps + v * v) / 2.0).sqrt().min(full);
        peak = peak.max(v);
        let ramps = (2.0 * peak * peak - v * v) / (2.0 * accel);
        (2.0 * peak - v) / accel + (steps - ramps).max(0.0) / peak
    }

    proptest::proptest! {
        #[test]
        fn no_target_takes_longer_than_it_may(
            rate in 1u32..60_000, accel in 100u32..10_000_000, ms in 0u64..3_000, age in 0u64..250,
        ) {
            let mut hold = hold(rate, accel);
            let now = hold.begun + Duration::from_millis(ms + age);
            hold.accepted = hold.begun + Duration::from_millis(ms);
            let present = (f64::from(accel) * (ms + age) as f64 / 1e3).min(f64::from(hold.rate));
            let steps = hold.reach(now);
            let takes = time(steps as f64, present, f64::from(hold.rate), f64::from(accel));
            // The ramp down from full speed is all that may remain where the keep-alive is old.
            let left = (LOOK_AHEAD - Duration::from_millis(age)).as_secs_f64();
            proptest::prop_assert!(steps >= 0);
            proptest::prop_assert!(takes <= left.max(0.11) + 1e-6, "{steps} steps take {takes} s");
        }
    }

    #[test]
    fn a_hold_lives_on_keeps_alone_and_never_again() {
        let mut hold = hold(2_000, 25_000);
        let begun = hold.begun;
        assert_eq!(hold.due(begun), Some(Due::Extend));
        assert_eq!(hold.due(begun), None);
        let later = begun + Duration::from_millis(100);
        assert_eq!(hold.keep(later), Ok(()));
        assert_eq!(hold.due(later), Some(Due::Extend));
        let late = later + KEEP_FRESH + Duration::from_millis(1);
        assert_eq!(hold.keep(late), Err(Over::Silent));
        assert_eq!(hold.due(late), Some(Due::End(Over::Silent)));
        hold.release();
        assert_eq!(hold.keep(later), Err(Over::Released));
    }

    #[test]
    fn a_homed_axis_keeps_inside_its_travel() {
        let hold = hold(2_000, 25_000);
        let now = hold.begun;
        assert!(hold.target(29_990, None, false, now) > 30_000);
        assert_eq!(hold.target(29_990, None, true, now), 30_000);
        assert_eq!(hold.target(30_500, None, true, now), 30_500);
        let far = hold.target(0, None, true, now);
        assert!(hold.target(10, Some(far + 50), true, now) >= far + 50);
        assert!(far > 100 && far < 600, "{far}");
    }

    #[test]
    fn a_hold_with_an_end_stops_there_and_never_turns_round() {
        let hold = hold(2_000, 25_000).bounded(Some(50));
        let now = hold.begun;
        assert_eq!(hold.target(0, None, false, now), 50);
        assert_eq!(hold.target(60, None, true, now), 60, "it stands beyond: it stays");
        let back = Hold { positive: false, ..hold };
        assert_eq!(back.target(100, None, true, now), 50);
        assert_eq!(back.target(20, None, false, now), 20);
    }

    #[test]
    fn an_axis_that_somebody_else_stops_is_told_from_one_that_arrives() {
        let hold = hold(2_000, 25_000);
        // Its ramp is 80 steps.
        assert!(!hold.was_stopped(500, 0, 1_000), "it speeds up");
        assert!(!hold.was_stopped(500, 2_000, 1_950));
        assert!(!hold.was_stopped(60, 2_000, 1_700), "it comes to its place");
        assert!(!hold.was_stopped(0, 2_000, 0), "it is there");
        assert!(hold.was_stopped(400, 2_000, 1_200));
        assert!(hold.was_stopped(-400, 2_000, 0));
    }

    #[test]
    fn a_weak_axis_is_slowed_down_to_a_short_ramp() {
        assert_eq!(hold(8_000, 25_000).rate, 2_500);
        assert_eq!(hold(8_000, 100).rate, 10);
    }
}
