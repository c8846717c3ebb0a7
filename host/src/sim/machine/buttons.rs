//! Start and Stop.

use lang::profile::InputRole;

use super::Machine;
use crate::sim::world::Button;

/// Stop held that long ends the run, us.
const HOLD_US: u64 = 2_000_000;

/// What was pressed.
#[derive(Debug, Default)]
pub struct Buttons {
    /// Since when Stop is down, us.
    stop_since: Option<u64>,
    /// How often Start was pressed while no pause held the run: what WaitStart waits for.
    pub presses: u64,
}

impl Buttons {
    /// When Stop has been held long enough to end the run, us.
    pub fn next_us(&self) -> Option<u64> {
        self.stop_since.map(|since| since + HOLD_US)
    }

    /// Whether Stop has been held that long; only once for each time it is pressed.
    pub fn take_hold(&mut self, now: u64) -> bool {
        let held = self.next_us().is_some_and(|at| now >= at);
        if held {
            self.stop_since = None;
        }
        held
    }
}

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
}
