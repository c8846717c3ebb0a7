//! Start and Stop.

/// Stop held that long ends the run, us.
const HOLD_US: u64 = 2_000_000;

/// What was pressed.
#[derive(Debug, Default)]
pub struct Buttons {
    /// Since when Stop is down, us.
    pub stop_since: Option<u64>,
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
