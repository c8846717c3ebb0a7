//! Inputs with their filters.

use lang::fault::Fault;
use lang::profile::{FIRST_THRESHOLD, LAST_THRESHOLD, Profile};

/// Filter time where the profile names no input, ms.
const FILTER_MS: u8 = 5;
/// Number of the Start button: one that no input of a wiring has.
pub const START: i32 = LAST_THRESHOLD + 1;
/// Number of the Stop button.
pub const STOP: i32 = START + 1;
/// Highest input number and one more.
const INPUTS: usize = LAST_THRESHOLD as usize + 1;
/// The same with the buttons.
const LINES: usize = INPUTS + 2;

/// One input.
#[derive(Clone, Copy, Debug, Default)]
struct Input {
    /// What the world drives.
    driven: bool,
    /// What the plant does: a switch, the plate.
    sensed: bool,
    /// After the filter.
    state: bool,
    /// When the filter follows, us.
    due: Option<u64>,
    filter_us: u64,
}

impl Input {
    fn raw(&self) -> bool {
        self.driven || self.sensed
    }

    fn change(&mut self, now: u64) {
        if self.raw() == self.state {
            self.due = None;
        } else if self.due.is_none() {
            self.due = Some(now + self.filter_us);
        }
    }
}

/// All inputs, and the buttons Start and Stop: the board has one filter for all of them.
#[derive(Debug)]
pub struct Inputs {
    lines: [Input; LINES],
    count: i32,
    /// Inputs that thresholds make.
    made: Vec<i32>,
}

impl Inputs {
    /// Every input off.
    pub fn new(profile: &Profile) -> Inputs {
        let named = profile.inputs.iter().map(|input| input.filter_ms);
        let filter_us = u64::from(named.max().unwrap_or(FILTER_MS)) * 1_000;
        let mut lines = [Input { filter_us, ..Input::default() }; LINES];
        // Two levels are filter enough.
        for line in &mut lines[FIRST_THRESHOLD as usize..INPUTS] {
            line.filter_us = 0;
        }
        let made = profile.thresholds.iter().map(|threshold| threshold.input).collect();
        Inputs { lines, count: profile.wiring.inputs(), made }
    }

    /// What was there before power-up needs no filter; a button that is pressed then is pressed
    /// now.
    pub fn settle(&mut self) {
        for line in &mut self.lines[..INPUTS] {
            line.state = line.raw();
            line.due = None;
        }
    }

    /// Numbers of the inputs that are on, behind their filters.
    pub fn on(&self) -> Vec<i32> {
        let lines = self.lines[..INPUTS].iter().zip(0..).filter(|(line, _)| line.state);
        lines.map(|(_, n)| n).collect()
    }

    fn line(&mut self, n: i32) -> Option<&mut Input> {
        usize::try_from(n).ok().and_then(|n| self.lines.get_mut(n))
    }

    /// The world drives an input.
    pub fn drive(&mut self, n: i32, on: bool, now: u64) {
        if let Some(line) = self.line(n) {
            line.driven = on;
            line.change(now);
        }
    }

    /// The plant drives an input.
    pub fn sense(&mut self, n: i32, on: bool, now: u64) {
        if let Some(line) = self.line(n)
            && line.sensed != on
        {
            line.sensed = on;
            line.change(now);
        }
    }

    /// Unfiltered state.
    pub fn raw(&self, n: i32) -> bool {
        usize::try_from(n).ok().and_then(|n| self.lines.get(n)).is_some_and(Input::raw)
    }

    /// When a filter follows next, us.
    pub fn next_us(&self) -> Option<u64> {
        self.lines.iter().filter_map(|line| line.due).min()
    }

    /// An input whose filter follows at `now`, with its new state.
    pub fn take_filtered(&mut self, now: u64) -> Option<(i32, bool)> {
        let (n, line) = self
            .lines
            .iter_mut()
            .enumerate()
            .find(|(_, line)| line.due.is_some_and(|due| due <= now))?;
        line.due = None;
        line.state = line.raw();
        Some((n as i32, line.state))
    }

    /// `IN(n)`.
    ///
    /// # Errors
    /// F20 for a number that the wiring lacks.
    pub fn read(&self, n: i32) -> Result<bool, Fault> {
        if !(1..=self.count).contains(&n) && !self.made.contains(&n) {
            return Err(Fault::ValueRange);
        }
        Ok(self.lines[n as usize].state)
    }

    /// `INPORT()`: input n is bit n - 1.
    pub fn port(&self) -> i32 {
        self.bits(|line| line.state)
    }

    /// All inputs without their filters, as a probe sees them.
    pub fn raw_port(&self) -> i32 {
        self.bits(Input::raw)
    }

    fn bits(&self, of: impl Fn(&Input) -> bool) -> i32 {
        let all = (1..=self.count).chain(self.made.iter().copied());
        all.fold(0, |bits, n| bits | i32::from(of(&self.lines[n as usize])) << (n - 1))
    }
}
