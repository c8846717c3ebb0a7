//! Waits, during which event handlers may run, and the events themselves.

use lang::axis::Axis;
use lang::effect::{Effect, Want};
use lang::fault::Fault;
use lang::plain::Plain;

use super::{Machine, Step};
use crate::sim::trace::What;

/// ON IN or ON EVERY.
#[derive(Clone, Copy, Debug)]
pub struct Slot {
    /// Input and edge; `None` for ON EVERY.
    input: Option<(i32, bool)>,
    /// Next tick, us of the run clock.
    pub tick: Option<u64>,
    period_us: u64,
    pending: bool,
}

/// What a statement waits for.
#[derive(Clone, Copy, Debug)]
enum Until {
    /// The run clock.
    Clock,
    /// An input.
    Input {
        n: i32,
        want: Want,
        /// State when last looked at, for edges.
        before: bool,
    },
    /// Start was pressed so many times before.
    Start(u64),
    /// A character.
    Char(i32),
    /// Axes of their own.
    Axes([bool; 3]),
    /// Simulated time, whatever is paused.
    Pulse(u64),
}

/// A statement that waits.
#[derive(Clone, Copy, Debug)]
pub struct Wait {
    line: u32,
    until: Until,
    /// us of the run clock.
    deadline: Option<u64>,
    query: bool,
}

/// How a wait ended.
enum Ended {
    Ok,
    TimedOut,
}

impl Machine {
    /// Begins a wait and goes on with it.
    pub(super) fn begin_wait(&mut self, effect: &Effect) -> Result<Step, Fault> {
        let line = self.line;
        let start = self.run_clock();
        let deadline = |ms: i32| match u64::try_from(ms) {
            Ok(ms) => Ok(start + ms * 1_000),
            Err(_) => Err(Fault::ValueRange),
        };
        let limit = |ms: Option<i32>| ms.map(deadline).transpose();
        let wait = match *effect {
            Effect::Plain(Plain::Wait, [ms, _]) => {
                let end = deadline(ms)?;
                self.write(What::Wait { line, ms });
                Wait { line, until: Until::Clock, deadline: Some(end), query: false }
            }
            Effect::WaitIn { n, want, timeout, query } => {
                let before = self.inputs.read(n)?;
                let until = Until::Input { n, want, before };
                Wait { line, until, deadline: limit(timeout)?, query }
            }
            Effect::Plain(Plain::WaitStart, _) => {
                let until = Until::Start(self.start_presses);
                if self.scenario.waits_for_start(self.now) {
                    self.released.push(line);
                }
                Wait { line, until, deadline: None, query: false }
            }
            Effect::WaitChar { c, timeout, query } => {
                if !(33..=125).contains(&c) {
                    return Err(Fault::ValueRange);
                }
                Wait { line, until: Until::Char(c), deadline: limit(timeout)?, query }
            }
            Effect::WaitMove(axis) => {
                let mut which = [axis.is_none(); 3];
                if let Some(axis) = axis {
                    which[axis.index()] = true;
                }
                for axis in Axis::ALL {
                    if which[axis.index()] && self.axes.is_running(axis) {
                        return Err(Fault::ValueRange);
                    }
                }
                Wait { line, until: Until::Axes(which), deadline: None, query: false }
            }
            Effect::Plain(Plain::Pulse, [n, ms]) => {
                self.outputs.check(n)?;
                let Ok(ms) = u64::try_from(ms) else { return Err(Fault::ValueRange) };
                self.set_out(n, true)?;
                let until = self.now + ms * 1_000;
                self.outputs.pulse(n, until, line);
                Wait { line, until: Until::Pulse(until), deadline: None, query: false }
            }
            _ => return Ok(Step::Done(0)),
        };
        self.waits.push(wait);
        self.next = 0;
        Ok(self.resume())
    }

    /// Goes on with the innermost wait after an event handler.
    pub fn resume(&mut self) -> Step {
        loop {
            if self.halt.is_some() {
                return Step::Stop;
            }
            let Some(mut wait) = self.waits.pop() else { return Step::Done(0) };
            self.line = wait.line;
            if self.paused_since.is_none() {
                if let Some(ended) = self.ended(&mut wait) {
                    return self.report(&wait, &ended);
                }
                if !self.handler
                    && !self.held
                    && let Some(step) = self.interruption()
                {
                    match step {
                        Step::Event(slot) => self.take_event(slot),
                        _ => self.late = None,
                    }
                    self.waits.push(wait);
                    return step;
                }
            }
            let deadline = match wait.until {
                // A pulse that ends in a pause is over; what follows waits for the pause's end.
                Until::Pulse(until) if until > self.now || self.paused_since.is_none() => {
                    Some(until.max(self.now))
                }
                _ if self.paused_since.is_some() => None,
                _ => wait.deadline.map(|run| self.at_run_clock(run)),
            };
            self.waits.push(wait);
            self.tick(deadline);
        }
    }

    fn ended(&self, wait: &mut Wait) -> Option<Ended> {
        let over = match &mut wait.until {
            Until::Clock => false,
            Until::Input { n, want, before } => {
                let state = self.inputs.read(*n).unwrap_or(false);
                let edge = state != *before;
                *before = state;
                match want {
                    Want::On => state,
                    Want::Off => !state,
                    Want::Rise => edge && state,
                    Want::Fall => edge && !state,
                }
            }
            Until::Start(presses) => self.start_presses > *presses,
            Until::Char(c) => self.char_in == *c,
            Until::Axes(which) => Axis::ALL
                .into_iter()
                .all(|axis| !which[axis.index()] || self.motion.is_solo_idle(axis)),
            Until::Pulse(until) => self.now >= *until,
        };
        if over {
            return Some(Ended::Ok);
        }
        let late = wait.deadline.is_some_and(|deadline| self.run_clock() >= deadline);
        match wait.until {
            Until::Clock if late => Some(Ended::Ok),
            _ if late => Some(Ended::TimedOut),
            _ => None,
        }
    }

    fn report(&mut self, wait: &Wait, ended: &Ended) -> Step {
        let (line, ok) = (wait.line, matches!(ended, Ended::Ok));
        match wait.until {
            Until::Input { n, want, .. } => {
                let v = u8::from(matches!(want, Want::On | Want::Rise));
                self.write(What::WaitIn { line, n, v, ok });
            }
            Until::Char(c) => {
                if ok {
                    self.char_in = 0;
                }
                self.write(What::WaitChar { line, c, ok });
            }
            Until::Start(_) => self.write(What::WaitStart { line }),
            Until::Clock | Until::Axes(_) | Until::Pulse(_) => {}
        }
        if matches!(wait.until, Until::Input { .. } | Until::Char(_)) {
            if ok {
                self.timed_out &= !wait.query;
            } else if wait.query {
                self.timed_out = true;
            } else {
                return Step::Fault(Fault::TimedOut);
            }
        }
        Step::Done(0)
    }

    /// ON IN.
    pub(super) fn on_input(&mut self, slot: u8, n: i32, want: Want) -> Result<(), Fault> {
        self.inputs.read(n)?;
        if let Some(place) = self.slots.get_mut(usize::from(slot)) {
            let input = Some((n, want == Want::Rise));
            *place = Some(Slot { input, tick: None, period_us: 0, pending: false });
        }
        Ok(())
    }

    /// ON IN n OFF.
    pub(super) fn off_input(&mut self, n: i32) {
        for slot in &mut self.slots {
            if slot.is_some_and(|slot| slot.input.is_some_and(|(input, _)| input == n)) {
                *slot = None;
            }
        }
    }

    /// ON EVERY.
    pub(super) fn on_every(&mut self, slot: u8, ms: i32) -> Result<(), Fault> {
        let Ok(period) = u64::try_from(ms) else { return Err(Fault::ValueRange) };
        if period == 0 {
            return Err(Fault::ValueRange);
        }
        let period_us = period * 1_000;
        let tick = Some(self.run_clock() + period_us);
        if let Some(place) = self.slots.get_mut(usize::from(slot)) {
            *place = Some(Slot { input: None, tick, period_us, pending: false });
        }
        Ok(())
    }

    /// ON EVERY OFF.
    pub(super) fn off_every(&mut self) {
        for slot in &mut self.slots {
            if slot.is_some_and(|slot| slot.tick.is_some()) {
                *slot = None;
            }
        }
    }

    /// An input changed: its events are remembered once.
    pub(super) fn input_event(&mut self, n: i32, on: bool) {
        for slot in self.slots.iter_mut().flatten() {
            if slot.input == Some((n, on)) {
                slot.pending = true;
                self.attention = true;
            }
        }
    }

    /// Ticks that are due are remembered once each.
    pub(super) fn every(&mut self) {
        if self.paused_since.is_some() {
            return;
        }
        let clock = self.run_clock();
        for slot in self.slots.iter_mut().flatten() {
            while let Some(tick) = slot.tick.filter(|tick| *tick <= clock) {
                slot.tick = Some(tick + slot.period_us);
                slot.pending = true;
                self.attention = true;
            }
        }
    }

    /// The first slot whose event waits to be served.
    pub(super) fn pending_slot(&self) -> Option<u8> {
        let pending = |slot: &Option<Slot>| slot.is_some_and(|slot| slot.pending);
        self.slots.iter().position(pending).map(|slot| slot as u8)
    }

    /// The event of `slot` is served.
    pub(super) fn take_event(&mut self, slot: u8) {
        if let Some(slot) = self.slots.get_mut(usize::from(slot)).and_then(Option::as_mut) {
            slot.pending = false;
        }
    }
}
