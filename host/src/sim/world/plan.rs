//! What a world has planned: jobs in time, hooks on outputs, plates, switches, expectations.

use std::collections::BTreeMap;

use lang::axis::Axis;
use rhai::FnPtr;

use super::{Action, Beside, Button, Registers};
use crate::sim::trace::PerAxis;

/// Jobs and hooks that a world may have at a time.
pub const JOB_LIMIT: usize = 100_000;

/// Something that happens at its time.
#[derive(Clone, Debug)]
pub enum Job {
    /// A closure of the script.
    Call(FnPtr),
    /// A button is let go.
    Release(Button),
    /// A button is pressed for so many us.
    Press(Button, u64),
    /// The controller sees it.
    Act(Action),
    /// Somebody takes a thing of the cell away, or puts it back.
    Hands(String, bool),
    /// Another step of the ramp of an analog input, from 0; older ramps of it are over.
    Ramp(usize, u64),
}

/// An `after_out`.
#[derive(Clone, Debug)]
struct Hook {
    n: i32,
    on: bool,
    delay_us: u64,
    function: FnPtr,
}

/// What `expect_` asks for.
#[derive(Clone, Copy, Debug)]
pub enum Expectation {
    /// An output's state.
    Out(i32, bool),
    /// An axis's place.
    Pos(Axis, i32),
}

/// A voltage that goes evenly to another.
#[derive(Clone, Copy, Debug, Default)]
struct Ramp {
    /// mV and us.
    from: (u16, u64),
    to: (u16, u64),
    /// Counts ramps of this input.
    number: u64,
}

impl Ramp {
    /// mV at a time, us.
    fn at(&self, us: u64) -> u16 {
        let ((from, begin), (to, end)) = (self.from, self.to);
        if us >= end {
            return to;
        }
        let (way, part) = (i64::from(to) - i64::from(from), (us - begin.min(us)).cast_signed());
        (i64::from(from) + way * part / (end - begin).cast_signed()) as u16
    }
}

/// See the module.
#[derive(Debug, Default)]
pub struct Plan {
    /// Time of the callback that runs, us.
    pub now_us: u64,
    /// Nobody is there, as without a world.
    pub unattended: bool,
    /// Reference switches, steps from power-up.
    pub switches: [Option<i32>; 3],
    /// Probe plates: machine position, side.
    pub plates: [Option<(i32, i32)>; 3],
    /// The program's AT variables.
    pub registers: Registers,
    /// The host's client has ended: what only it can do has no effect any more.
    pub client_gone: bool,
    /// The cell beside the world.
    pub beside: Beside,
    /// What the world itself gives to inputs, from 1.
    inputs: BTreeMap<i32, bool>,
    jobs: BTreeMap<(u64, u64), Job>,
    sequence: u64,
    ramps: [Ramp; 4],
    hooks: Vec<Hook>,
    held: [u32; 2],
    actions: Vec<Action>,
    expectations: Vec<(usize, Expectation)>,
}

impl Plan {
    /// When the next job is due.
    pub fn next_us(&self) -> Option<u64> {
        if !self.actions.is_empty() {
            return Some(self.now_us);
        }
        self.jobs.first_key_value().map(|((us, _), _)| *us)
    }

    /// The next job that is due, and its time becomes the present.
    pub fn take_due(&mut self, now_us: u64) -> Option<Job> {
        let first = self.jobs.first_entry()?;
        let (us, _) = *first.key();
        if us > now_us {
            return None;
        }
        self.now_us = self.now_us.max(us);
        Some(first.remove())
    }

    /// What was done to the controller since the last call.
    pub fn take_actions(&mut self) -> Vec<Action> {
        std::mem::take(&mut self.actions)
    }

    /// Puts `job` at `us`, or now if that is past.
    ///
    /// # Errors
    /// There are too many.
    pub fn schedule(&mut self, us: u64, job: Job) -> Result<(), String> {
        if self.jobs.len() >= JOB_LIMIT {
            return Err(format!("more than {JOB_LIMIT} things are planned at a time"));
        }
        self.sequence += 1;
        self.jobs.insert((us.max(self.now_us), self.sequence), job);
        Ok(())
    }

    /// The controller sees `action` now, unless that is at an input that hangs.
    pub fn act(&mut self, action: Action) {
        if let Action::Input { n, on } = action {
            self.inputs.insert(n, on);
            if self.beside.is_forced(n) {
                return;
            }
        }
        self.actions.push(action);
    }

    /// From now on input `n`, from 1, hangs in a state; with `None` it is as world and cell give it.
    pub fn force(&mut self, n: i32, on: Option<bool>) {
        self.beside.force(n, on);
        let own = self.inputs.get(&n).copied().unwrap_or(false);
        self.actions.push(Action::Input { n, on: on.unwrap_or(own) });
    }

    /// Somebody takes a thing of the cell away, or puts it back: now, or when the run begins.
    ///
    /// # Errors
    /// There is no such thing, or no cell, or too many things are planned.
    pub fn hands(&mut self, name: &str, puts: bool) -> Result<(), String> {
        if self.beside.hands(name, puts)? {
            return Ok(());
        }
        self.schedule(0, Job::Hands(name.to_owned(), puts))
    }

    /// Analog input `n`, from 1, goes to a voltage, mV, within a time, us.
    ///
    /// # Errors
    /// There are too many things planned.
    pub fn ramp(&mut self, n: i32, mv: u16, time_us: u64) -> Result<(), String> {
        let Some(place) = usize::try_from(n - 1).ok().filter(|place| *place < self.ramps.len())
        else {
            return Ok(());
        };
        let (now, old) = (self.now_us, self.ramps[place]);
        let (from, to) = ((old.at(now), now), (mv, now.saturating_add(time_us)));
        self.ramps[place] = Ramp { from, to, number: old.number + 1 };
        self.climb(place, old.number + 1)
    }

    /// A step of a ramp, if it still is the last one of its input, and the next step after it.
    ///
    /// # Errors
    /// There are too many things planned.
    pub fn climb(&mut self, place: usize, number: u64) -> Result<(), String> {
        let ramp = self.ramps[place];
        if ramp.number != number {
            return Ok(());
        }
        let now = self.now_us;
        self.act(Action::Analog { n: place as i32 + 1, mv: ramp.at(now) });
        if now < ramp.to.1 {
            self.schedule((now + 1_000).min(ramp.to.1), Job::Ramp(place, number))?;
        }
        Ok(())
    }

    /// A button goes down and, `hold_us` later, up again. A button held twice at once is down
    /// until both are over.
    pub fn press(&mut self, button: Button, hold_us: u64) {
        self.held[button as usize] += 1;
        if self.held[button as usize] == 1 {
            self.act(Action::Button { button, down: true });
        }
        self.sequence += 1;
        self.jobs.insert((self.now_us + hold_us, self.sequence), Job::Release(button));
    }

    /// One hold of the button is over.
    pub fn release(&mut self, button: Button) {
        self.held[button as usize] -= 1;
        if self.held[button as usize] == 0 {
            self.act(Action::Button { button, down: false });
        }
    }

    /// Remembers an `after_out`.
    ///
    /// # Errors
    /// There are too many.
    pub fn hook(&mut self, n: i32, on: bool, delay_us: u64, call: FnPtr) -> Result<(), String> {
        if self.hooks.len() >= 1_000 {
            return Err("more than 1000 after_out hooks".to_owned());
        }
        self.hooks.push(Hook { n, on, delay_us, function: call });
        Ok(())
    }

    /// Schedules the hooks of an output's edge.
    pub fn output_changed(&mut self, n: i32, on: bool, now_us: u64) {
        self.now_us = self.now_us.max(now_us);
        for index in 0..self.hooks.len() {
            let hook = &self.hooks[index];
            if hook.n == n && hook.on == on && self.jobs.len() < JOB_LIMIT {
                self.sequence += 1;
                let job = Job::Call(hook.function.clone());
                self.jobs.insert((self.now_us + hook.delay_us, self.sequence), job);
            }
        }
    }

    /// Remembers what must hold at the end; `line` is the script's.
    ///
    /// # Errors
    /// There are too many.
    pub fn expect(&mut self, line: usize, what: Expectation) -> Result<(), String> {
        if self.expectations.len() >= 10_000 {
            return Err("more than 10000 expectations".to_owned());
        }
        self.expectations.push((line, what));
        Ok(())
    }

    /// The expectations that do not hold.
    pub fn failures(&self, file: &str, output: &dyn Fn(i32) -> bool, pos: &PerAxis) -> Vec<String> {
        let word = |on| if on { "on" } else { "off" };
        let mut failures = Vec::new();
        for &(line, what) in &self.expectations {
            match what {
                Expectation::Out(n, on) if output(n) != on => failures.push(format!(
                    "{file}:{line}: output {n} is {}, expected {}",
                    word(!on),
                    word(on)
                )),
                Expectation::Pos(axis, want) if pos.get(axis) != Some(want) => {
                    let letter = axis.letter();
                    failures.push(match pos.get(axis) {
                        Some(at) => format!("{file}:{line}: {letter} is at {at}, expected {want}"),
                        None => format!("{file}:{line}: the machine has no {letter}"),
                    });
                }
                _ => {}
            }
        }
        failures
    }
}
