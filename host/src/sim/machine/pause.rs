//! The pause: what holds the machine, its outputs and the run clock, and how it goes on.

/// A pause, and what all of them took.
#[derive(Debug, Default)]
pub struct Pause {
    /// When it began, us; `None` without one.
    pub since: Option<u64>,
    /// What the pauses before it took, us.
    pub before_us: u64,
    /// What the run clock showed when the program that runs began, us.
    pub program_us: u64,
    /// The machine stands and its outputs have their pause states.
    pub outputs: bool,
    /// When the machine goes on behind a spindle's run-up, us.
    pub resume_at: Option<u64>,
}

impl Pause {
    /// Whether there is one.
    pub fn is_on(&self) -> bool {
        self.since.is_some()
    }

    /// The simulated time at which the run clock shows `run`.
    pub fn at_run_clock(&self, run: u64) -> u64 {
        run + self.before_us
    }

    /// What the run clock shows at `now`: the clock of TIMER, waits and ON EVERY, us.
    pub fn run_clock(&self, now: u64) -> u64 {
        self.since.unwrap_or(now) - self.before_us
    }
}
