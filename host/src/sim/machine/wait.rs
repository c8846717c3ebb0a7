//! Waits, during which event handlers may run.

use lang::axis::Axis;
use lang::effect::{Effect, Want};
use lang::fault::Fault;
use lang::plain::Plain;

use super::Machine;
use super::waits::{Until, Wait};
use crate::sim::step::Step;
use crate::sim::trace::What;

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
                let until = Until::Start(self.buttons.presses);
                if self.scenario.waits_for_start(self.clock.now()) {
                    self.waits.released.push(self.log.shown(line));
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
                let until = self.clock.now() + ms * 1_000;
                self.outputs.pulse(n, until, line);
                Wait { line, until: Until::Pulse(until), deadline: None, query: false }
            }
            _ => return Ok(Step::Done(0)),
        };
        self.waits.open.push(wait);
        self.clock.look_anew();
        Ok(self.resume())
    }

    /// Goes on with the innermost wait after an event handler.
    pub fn resume(&mut self) -> Step {
        loop {
            if self.is_halted() {
                return Step::Stop;
            }
            let Some(mut wait) = self.waits.open.pop() else { return Step::Done(0) };
            self.line = wait.line;
            if !self.pause.is_on() {
                if let Some(ended) = self.ended(&mut wait) {
                    return self.report(&wait, &ended);
                }
                if self.events.may_interrupt()
                    && let Some(step) = self.events.interruption()
                {
                    self.events.take(step);
                    self.waits.open.push(wait);
                    return step;
                }
            }
            let deadline = match wait.until {
                // A pulse that ends in a pause is over; what follows waits for the pause's end.
                Until::Pulse(until) if until > self.clock.now() || !self.pause.is_on() => {
                    Some(until.max(self.clock.now()))
                }
                _ if self.pause.is_on() => None,
                _ => wait.deadline.map(|run| self.pause.at_run_clock(run)),
            };
            self.waits.open.push(wait);
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
            Until::Start(presses) => self.buttons.presses > *presses,
            Until::Char(c) => self.waits.char_in == *c,
            Until::Axes(which) => Axis::ALL
                .into_iter()
                .all(|axis| !which[axis.index()] || self.motion.is_solo_idle(axis)),
            Until::Pulse(until) => self.clock.now() >= *until,
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
                    self.waits.char_in = 0;
                }
                self.write(What::WaitChar { line, c, ok });
            }
            Until::Start(_) => self.write(What::WaitStart { line }),
            Until::Clock | Until::Axes(_) | Until::Pulse(_) => {}
        }
        if matches!(wait.until, Until::Input { .. } | Until::Char(_)) {
            if ok {
                self.waits.timed_out &= !wait.query;
            } else if wait.query {
                self.waits.timed_out = true;
            } else {
                return Step::Fault(Fault::TimedOut);
            }
        }
        Step::Done(0)
    }
}
