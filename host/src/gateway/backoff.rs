//! How seldom a board is asked that does not answer.

use std::time::{Duration, Instant};

/// Rest behind the first request without an answer; it doubles with each further one.
const FIRST: Duration = Duration::from_millis(500);
/// Longest rest.
const LONGEST: Duration = Duration::from_secs(10);

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
}

impl Backoff {
    /// Whether the board may be asked now.
    pub fn may_ask(&self, now: Instant) -> bool {
        self.until.is_none_or(|until| now >= until)
    }

    /// The board answered.
    pub fn hit(&mut self) {
        *self = Backoff { asked: true, misses: 0, until: None };
    }

    /// The board did not answer.
    pub fn miss(&mut self, now: Instant) {
        let rest = FIRST.saturating_mul(1 << self.misses.min(16)).min(LONGEST);
        *self =
            Backoff { asked: true, misses: self.misses.saturating_add(1), until: Some(now + rest) };
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
    use super::{Backoff, Health, LONGEST};
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
}
