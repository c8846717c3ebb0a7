//! Operator actions: Start, Stop, pause and resume.

use lang::profile::InputRole;

use super::Machine;
use crate::sim::world::Button;

impl Machine {
    /// A button, or an input that acts as one, changed behind its filter.
    pub(super) fn button(&mut self, button: Button, down: bool) {
        match (button, down) {
            (Button::Stop, true) => {
                self.buttons.stop_since = Some(self.clock.now());
                self.hold();
            }
            (Button::Stop, false) => self.buttons.stop_since = None,
            (Button::Start, true) => {
                if self.buttons.stop_since.is_some() || self.is_held() {
                    return;
                }
                if !self.pause.is_on() {
                    self.buttons.presses += 1;
                } else if self.pause.resume_at.is_none() {
                    self.start_again();
                }
            }
            (Button::Start, false) => {}
        }
    }

    /// Whether an input with role hold, door or emergency stop is active.
    fn is_held(&self) -> bool {
        self.profile.inputs.iter().any(|input| {
            matches!(input.role, Some(InputRole::Hold | InputRole::Door | InputRole::EmergencyStop))
                && self.inputs.read(input.n).unwrap_or(false)
        })
    }

    /// Time of the clocks that a pause holds: TIMER, waits, ON EVERY; us.
    pub(super) fn run_clock(&self) -> u64 {
        self.pause.run_clock(self.clock.now())
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
