//! Outputs: states, roles, pulses, and what becomes of them in a pause and at the end.

use lang::fault::Fault;
use lang::profile::{OutputRole, Profile, SafeState};

/// Highest output number and one more.
const LINES: usize = 17;

#[derive(Clone, Copy, Debug, Default)]
struct Output {
    /// As the script set it.
    state: bool,
    /// As it is at the terminal.
    real: bool,
    /// What the world and the record have been told.
    told: bool,
    /// State before the pause.
    before: bool,
    role: Option<OutputRole>,
    /// Dark at rest.
    beam: bool,
    pause: SafeState,
    fault: SafeState,
    end: SafeState,
}

/// A Pulse under way.
#[derive(Clone, Copy, Debug)]
struct Pulse {
    n: i32,
    /// When it is over, us.
    until: u64,
    /// Line of its statement.
    line: u32,
}

/// All outputs.
#[derive(Debug)]
pub struct Outputs {
    lines: [Output; LINES],
    count: i32,
    turning: bool,
    pulses: Vec<Pulse>,
}

impl Outputs {
    /// States after reset.
    pub fn new(profile: &Profile) -> Outputs {
        let plain = Output { pause: SafeState::Keep, ..Output::default() };
        let mut lines = [plain; LINES];
        for output in &profile.outputs {
            let Some(line) = usize::try_from(output.n).ok().and_then(|n| lines.get_mut(n)) else {
                continue;
            };
            line.role = output.role;
            // Beside a PWM it is the laser's enable.
            line.beam = output.role == Some(OutputRole::Laser) && profile.pwm.is_none();
            line.pause = output.pause;
            line.fault = output.fault;
            line.end = output.end;
            line.state = output.reset == SafeState::On;
        }
        let mut outputs =
            Outputs { lines, count: profile.wiring.outputs(), turning: false, pulses: Vec::new() };
        outputs.drive();
        for line in &mut outputs.lines {
            line.told = line.real;
        }
        outputs
    }

    /// States at the terminals from those of the script.
    fn drive(&mut self) {
        for line in &mut self.lines {
            line.real = line.state && (self.turning || !line.beam);
        }
    }

    fn checked(&mut self, n: i32) -> Result<&mut Output, Fault> {
        if !(1..=self.count).contains(&n) {
            return Err(Fault::ValueRange);
        }
        let line = &mut self.lines[n as usize];
        if matches!(line.role, Some(OutputRole::Lamp | OutputRole::Enable)) {
            return Err(Fault::ValueRange);
        }
        Ok(line)
    }

    /// Whether the script may set output `n`.
    ///
    /// # Errors
    /// F20 for a number that the wiring lacks and for outputs of the controller itself.
    pub fn check(&mut self, n: i32) -> Result<(), Fault> {
        self.checked(n).map(|_| ())
    }

    /// Sets an output.
    ///
    /// # Errors
    /// F20 as [`Outputs::check`].
    pub fn set(&mut self, n: i32, on: bool) -> Result<(), Fault> {
        let line = self.checked(n)?;
        line.state = on;
        self.drive();
        Ok(())
    }

    /// Outputs that SetPort sets: those of 1..8 that a script may set.
    pub fn port(&self) -> Vec<i32> {
        (1..=self.count.min(8))
            .filter(|n| {
                let role = self.lines[*n as usize].role;
                !matches!(role, Some(OutputRole::Lamp | OutputRole::Enable))
            })
            .collect()
    }

    /// `OUT(n)`: as the script set it.
    ///
    /// # Errors
    /// F20 for a number that the wiring lacks.
    pub fn read(&self, n: i32) -> Result<bool, Fault> {
        if !(1..=self.count).contains(&n) {
            return Err(Fault::ValueRange);
        }
        Ok(self.lines[n as usize].state)
    }

    /// Switches output `n` off again at `until`, on behalf of a statement.
    pub fn pulse(&mut self, n: i32, until: u64, line: u32) {
        self.pulses.push(Pulse { n, until, line });
    }

    /// When a pulse is over next, us.
    pub fn next_us(&self) -> Option<u64> {
        self.pulses.iter().map(|pulse| pulse.until).min()
    }

    /// Ends a pulse that is over at `now`; gives its output and line.
    pub fn end_pulse(&mut self, now: u64) -> Option<(i32, u32)> {
        let index = self.pulses.iter().position(|pulse| pulse.until <= now)?;
        let Pulse { n, line, .. } = self.pulses.remove(index);
        let output = &mut self.lines[n as usize];
        output.state = false;
        output.before = false;
        self.drive();
        Some((n, line))
    }

    /// Drivers' enable.
    pub fn enable(&mut self, on: bool) {
        for line in &mut self.lines {
            if line.role == Some(OutputRole::Enable) {
                line.state = on;
            }
        }
        self.drive();
    }

    /// Whether an axis turns: a laser follows. `true` when that changes an output.
    pub fn shine(&mut self, turning: bool) -> bool {
        if self.turning == turning {
            return false;
        }
        self.turning = turning;
        self.drive();
        self.lines.iter().any(|line| line.real != line.told)
    }

    /// Pause states.
    pub fn pause(&mut self) {
        for line in &mut self.lines {
            line.before = line.state;
            line.state = applied(line.pause, line.state);
        }
        self.drive();
    }

    /// The states before the pause; whether a spindle starts again by that.
    pub fn resume(&mut self) -> bool {
        let mut spindle = false;
        for line in &mut self.lines {
            spindle |= line.role == Some(OutputRole::Spindle) && line.before && !line.state;
            line.state = line.before;
        }
        self.drive();
        spindle
    }

    /// States at the end of a run.
    pub fn safe(&mut self, fault: bool) {
        self.pulses.clear();
        for line in &mut self.lines {
            if !matches!(line.role, Some(OutputRole::Lamp | OutputRole::Enable)) {
                line.state = applied(if fault { line.fault } else { line.end }, line.state);
            }
        }
        self.drive();
    }

    /// What changed at the terminals since the last call.
    pub fn take_changes(&mut self) -> Vec<(i32, bool)> {
        let mut changes = Vec::new();
        for (n, line) in self.lines.iter_mut().enumerate() {
            if line.real != line.told {
                line.told = line.real;
                changes.push((n as i32, line.real));
            }
        }
        changes
    }

    /// Outputs that are on at their terminals.
    pub fn on(&self) -> impl Iterator<Item = i32> {
        self.lines.iter().enumerate().filter(|(_, line)| line.real).map(|(n, _)| n as i32)
    }
}

fn applied(state: SafeState, present: bool) -> bool {
    match state {
        SafeState::Off => false,
        SafeState::On => true,
        SafeState::Keep => present,
    }
}
