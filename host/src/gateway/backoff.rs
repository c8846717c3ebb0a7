//! Exponential back-off for boards that do not respond.

use std::time::{Duration, Instant};

/// Rest behind the first request without an answer; it doubles with each further one.
const FIRST: Duration = Duration::from_millis(500);
/// Longest rest.
const LONGEST: Duration = Duration::from_secs(10);

/// Rest between two tries to stop a board that is left alone otherwise.
const STOP_REST: Duration = Duration::from_secs(1);

/// Whether a board answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Health {
    /// It was not asked yet.
    Unknown = 0,
    /// It answered the last request.
    Up = 1,
    /// It did not.
    Silent = 2,
}

/// What is known of a board's answering.
#[derive(Debug, Default)]
pub struct Backoff {
    asked: bool,
    misses: u32,
    until: Option<Instant>,
    stop_until: Option<Instant>,
}

impl Backoff {
    /// Whether the board may be asked now.
    pub fn may_ask(&self, now: Instant) -> bool {
        self.until.is_none_or(|until| now >= until)
    }

    /// Whether the board may be told to stop now.
    pub fn may_stop(&self, now: Instant) -> bool {
        self.may_ask(now) || self.stop_until.is_none_or(|until| now >= until)
    }

    /// The same; the next try has to rest, unless the board answers.
    pub fn takes_stop(&mut self, now: Instant) -> bool {
        let may = self.may_stop(now);
        if may {
            self.stop_until = Some(now + STOP_REST);
        }
        may
    }

    /// The board answered.
    pub fn hit(&mut self) {
        *self = Backoff { asked: true, ..Backoff::default() };
    }

    /// The board did not answer.
    pub fn miss(&mut self, now: Instant) {
        let rest = FIRST.saturating_mul(1 << self.misses.min(16)).min(LONGEST);
        self.asked = true;
        self.misses = self.misses.saturating_add(1);
        self.until = Some(now + rest);
    }

    /// Requests without an answer since the last one with one.
    pub fn misses(&self) -> u32 {
        self.misses
    }

    /// Whether it answers.
    pub fn health(&self) -> Health {
        match (self.asked, self.misses) {
            (false, _) => Health::Unknown,
            (true, 0) => Health::Up,
            (true, _) => Health::Silent,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Backoff, Health, LONGEST, STOP_REST};
    use std::time::{Duration, Instant};

    #[test]
    fn rests_double_up_to_the_longest_and_an_answer_ends_them() {
        let mut backoff = Backoff::default();
        let mut now = Instant::now();
        assert_eq!(backoff.health(), Health::Unknown);
        let mut rests = Vec::new();
        for _ in 0..40 {
            assert!(backoff.may_ask(now));
            backoff.miss(now);
            let begun = now;
            while !backoff.may_ask(now) {
                now += Duration::from_millis(100);
            }
            rests.push((now - begun).as_millis());
        }
        assert_eq!(rests[..5], [500, 1000, 2000, 4000, 8000]);
        assert!(rests[5..].iter().all(|rest| *rest == LONGEST.as_millis()));
        assert_eq!(backoff.health(), Health::Silent);
        backoff.hit();
        assert!(backoff.may_ask(now));
        assert_eq!(backoff.health(), Health::Up);
    }

    #[test]
    fn a_stop_goes_to_a_board_that_is_left_alone_but_not_all_the_time() {
        let mut backoff = Backoff::default();
        let mut now = Instant::now();
        (0..9).for_each(|_| backoff.miss(now));
        assert!(!backoff.may_ask(now) && backoff.may_stop(now) && backoff.takes_stop(now));
        backoff.miss(now);
        assert!(!backoff.may_stop(now) && !backoff.takes_stop(now));
        now += STOP_REST;
        assert!(!backoff.may_ask(now) && backoff.takes_stop(now));
        backoff.hit();
        assert!(backoff.may_ask(now) && backoff.may_stop(now));
    }
}
