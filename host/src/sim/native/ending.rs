//! How a run ends: what asks for it, and when nothing can happen any more.

use firmware::machine::controller::PENDING;
use lang::axis::Axis;
use lang::fault::Fault;
use lang::isa::first;
use lang::wire::{Control, RunState};

use super::{Native, QUESTION};
use crate::sim::record::{Record, StopReason, Summary};
use crate::sim::trace::{PerAxis, Status, What};
use crate::sim::unattended::Unattended;
use crate::sim::{End, SimError};
use desk::PER_MS;

/// Nothing has happened for so long in a run in which nothing can happen any more, us: longer than any filter.
pub(super) const QUIET_US: u64 = 100_000;
/// Time after the end in which outputs come to the pins, ms.
const END_MS: u64 = 3;
/// Longest time that a stop may take, us: a ramp from the top rate of a slow machine.
const STOP_PATIENCE_US: u64 = 60_000_000;

impl Native {
    /// Whether the run is over whatever the program wants.
    pub fn is_halted(&self) -> bool {
        self.ended.is_some() || self.stop.is_some()
    }

    /// The run is over.
    pub(super) fn halt(&mut self, why: StopReason) {
        if !self.is_halted() {
            self.stop = Some(why);
        }
    }

    /// Ends a run whose time is up, whose user wants that, or in which nothing can happen any more.
    pub(super) fn watch(&mut self) {
        if self.is_halted() {
            return;
        }
        self.passes = self.passes.wrapping_add(1);
        if self.passes.is_multiple_of(QUESTION) && (self.options.interrupted)() {
            return self.halt(StopReason::Interrupted);
        }
        let us = self.now_us();
        if us >= self.options.limit_us {
            return self.halt(StopReason::Limit);
        }
        // People of a cell come before nobody, as around a board.
        if self.around.is_none() {
            self.press_start(us);
        }
        if !self.is_stuck() {
            self.alive_us = us;
        } else if us - self.alive_us < self.patience_us() {
        } else if self.cell_presses_start(us) || self.press_start(us) {
            self.alive_us = us;
        } else {
            self.idle_us = self.alive_us;
            self.halt(StopReason::Idle);
        }
    }

    /// In a world of nobody what waits for Start gets a press; whether it does now.
    fn press_start(&mut self, us: u64) -> bool {
        let waits = self.board.controller().session.shown() == RunState::WaitStart as u8;
        if !waits || self.pressed || !self.scene.scenario.is_unattended() {
            return false;
        }
        self.pressed = true;
        let comes = self.scene.scenario.waits_for_start(us);
        if comes {
            let pc = self.board.controller().pc_of_effect();
            let line = self.board.desk().line_at(pc);
            self.released.push(self.log.shown(line));
        }
        comes
    }

    /// Nothing can happen any more, unless something is on its way through a filter.
    fn is_stuck(&self) -> bool {
        let controller = self.board.controller();
        let (program, session) = (&controller.program, &controller.session);
        let waits = match program.effect.code {
            first::WaitIn | first::WaitChar => program.effect.left < 0,
            first::WaitStart => true,
            _ => false,
        };
        let stands = session.is(RunState::Paused)
            || waits && session.executes() && program.effect.phase != 0 && !self.is_told_the_time();
        stands
            && self.scenario_is_over()
            && controller.motor.rests()
            && controller.clock.spin == 0
            && controller.analog_is_settled()
    }

    /// Whether ON EVERY lets something happen.
    fn is_told_the_time(&self) -> bool {
        let events = &self.board.controller().program.events;
        events.iter().any(|event| event.kind & !PENDING == 3)
    }

    /// Whether neither world nor cell does anything by itself any more.
    fn scenario_is_over(&self) -> bool {
        self.scene.scenario.next_us().is_none() && self.cell_is_due().is_none()
    }

    /// Ends the run: `fault` is the program's, `None` its END or whatever stopped it. `line` is that of the statement
    /// under way; the machine says which has ended.
    ///
    /// # Errors
    /// The world's script failed on the way.
    pub fn finish(&mut self, fault: Option<Fault>, line: u32) -> Result<End, SimError> {
        if let Some(error) = self.failed.take() {
            return Err(error.into());
        }
        let asked_us = self.now_us();
        if self.ended.is_none() {
            self.stopping = Some(line);
            self.board.desk().wake();
            match fault {
                Some(fault) => self.board.controller_mut().fail(fault),
                None => self.board.controller_mut().control(Control::Stop),
            }
            while self.ended.is_none() && self.now_us() < asked_us + STOP_PATIENCE_US {
                self.turn();
            }
        }
        let status = if fault.is_some() { Status::Fault } else { Status::Stopped };
        let end = self.ended.unwrap_or(End { status, fault, line });
        if end.status == Status::Stopped && self.stop.is_none() {
            self.stop = Some(StopReason::Button);
        }
        self.come_out();
        let outputs = self.board.controller().io.outputs;
        let on = (1..=16).filter(|n| outputs >> (n - 1) & 1 != 0);
        let us = self.end_us();
        self.log.close(us, on);
        Ok(end)
    }

    /// The outputs' end states come to the pins.
    fn come_out(&mut self) {
        let until = self.board.desk().ticks() + END_MS * PER_MS;
        while self.board.desk().ticks() < until {
            self.board.drive(until);
            self.collect();
        }
    }

    /// When the run was over: nothing happened in the time that it took to find that nothing can.
    pub(super) fn end_us(&self) -> u64 {
        match (self.stop, self.ended_us) {
            (Some(StopReason::Idle), _) => self.idle_us,
            (_, Some(us)) => us,
            _ => self.now_us(),
        }
    }

    /// Where the axes are, steps.
    pub(super) fn steps(&self) -> PerAxis {
        let motor = &self.board.controller().motor;
        let place =
            |axis: Axis| self.profile.axis(axis).map(|_| motor.position(axis.index() as u8));
        PerAxis::new(Axis::ALL.map(place))
    }

    /// The machine has told the end of the run.
    pub(super) fn take_end(&mut self, us: u64, what: &What) {
        let What::End { status, fault, line, .. } = what else { return };
        let number = fault.as_ref().and_then(|code| code.get(1..)?.parse().ok());
        let fault = number.and_then(Fault::from_number);
        self.ended = Some(End { status: *status, fault, line: *line });
        self.ended_us = Some(us);
        self.pieces.close(us, &self.board, &mut self.log);
    }

    /// Closes the books: the numbers of the run, the record, and what the world expected in vain.
    pub fn results(&mut self, end: &End) -> (Summary, Record, Vec<String>) {
        let pos = self.steps();
        let failures = {
            let plant = self.board.plant();
            let on = |n: i32| self.scene.is_on(n, u8::try_from(n).is_ok_and(|n| plant.output(n)));
            self.scene.scenario.failures(&on, &pos)
        };
        let before = self.pulses;
        let steps = {
            let plant = self.board.plant();
            [0, 1, 2].map(|i: usize| plant.motors[i].pulses - before[i])
        };
        let stopped = (end.status == Status::Stopped).then_some(self.stop).flatten();
        let us = self.end_us();
        let (summary, record) = self.log.results(end, stopped, us, self.statements, steps);
        (summary, record, failures)
    }

    /// What the run did that nobody told it, in a world of nobody.
    pub fn unattended(&self) -> Unattended {
        if !self.scene.scenario.is_unattended() {
            return Unattended::default();
        }
        let steps = |place: i64| i32::try_from(place).unwrap_or_default();
        let plant = self.board.plant();
        Unattended {
            released: self.released.clone(),
            reached: self.reached.map(|ends| ends.map(steps)),
            switches: plant.switches.map(|own| own.map(|own| steps(own.position))),
        }
    }
}
