//! The pause: what holds the machine, its outputs and the run clock, and how it goes on.

use super::Machine;

/// A pause, and what all of them took.
#[derive(Debug, Default)]
pub struct Pause {
    /// When it began, us; `None` without one.
    since: Option<u64>,
    /// What the pauses before it took, us.
    before_us: u64,
    /// What the run clock showed when the program that runs began, us.
    pub program_us: u64,
    /// The machine stands and its outputs have their pause states.
    outputs: bool,
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
}

impl Machine {
    /// Time of the clocks that a pause holds: TIMER, waits, ON EVERY; us.
    pub(super) fn run_clock(&self) -> u64 {
        self.pause.since.unwrap_or(self.clock.now()) - self.pause.before_us
    }

    /// A pause begins.
    pub(super) fn hold(&mut self) {
        if self.pause.since.is_none() {
            self.pause.since = Some(self.clock.now());
            self.motion.pause(true, self.clock.now());
            self.events.attention = true;
        }
        self.pause.resume_at = None;
    }

    /// Outputs take their pause states when the machine has come to a stand.
    pub(super) fn pause_outputs(&mut self) {
        if self.pause.is_on() && !self.pause.outputs && self.motion.stands() {
            self.pause.outputs = true;
            self.outputs.pause();
            self.outputs_changed();
        }
    }

    /// Start in a pause: outputs first, then, behind a spindle's run-up, motion.
    pub(super) fn start_again(&mut self) {
        let spin_up = self.pause.outputs && self.outputs.resume();
        self.pause.outputs = false;
        self.outputs_changed();
        if spin_up && self.profile.run.spin_up_ms > 0 {
            let spin_up_us = u64::from(self.profile.run.spin_up_ms) * 1_000;
            self.pause.resume_at = Some(self.clock.now() + spin_up_us);
        } else {
            self.go_on();
        }
    }

    /// The pause is over.
    pub(super) fn go_on(&mut self) {
        self.pause.resume_at = None;
        if let Some(since) = self.pause.since.take() {
            self.pause.before_us += self.clock.now() - since;
            self.motion.pause(false, self.clock.now());
            self.log_milestones();
        }
    }
}
