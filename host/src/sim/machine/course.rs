//! Event loop: finds what happens next, and lets it happen.

use lang::axis::Axis;
use lang::profile::InputRole;

use super::Machine;
use super::ending::Halt;
use super::inputs::{START, STOP};
use crate::sim::record::StopReason;
use crate::sim::trace::What;
use crate::sim::world::{Action, Button};

impl Machine {
    /// Finds out when something happens next.
    pub(super) fn find_next(&mut self) -> Option<u64> {
        let next = self.next_change();
        self.clock.expect(next);
        next
    }

    /// The earliest thing that can happen by itself.
    fn next_change(&self) -> Option<u64> {
        let every = if self.pause.is_on() { None } else { self.events.next_tick() };
        [
            self.scenario.next_us(),
            self.motion.next_us(),
            self.next_crossing(),
            self.inputs.next_us(),
            self.outputs.next_us(),
            every.map(|run| self.pause.at_run_clock(run)),
            self.buttons.next_us(),
            self.pause.resume_at,
        ]
        .into_iter()
        .flatten()
        .min()
        .map(|us| us.max(self.clock.now()))
    }

    /// Advances to the next thing that happens, or to `deadline` if that is earlier; `false` when
    /// nothing can happen any more, which stops the run.
    pub(super) fn tick(&mut self, deadline: Option<u64>) -> bool {
        let next = self.find_next();
        let Some(to) = next.into_iter().chain(deadline).min() else {
            self.halt(Halt::Stopped(StopReason::Idle));
            return false;
        };
        self.advance_to(to.max(self.clock.now()));
        !self.is_halted()
    }

    /// Lets everything happen until `to`.
    pub(super) fn advance_to(&mut self, to: u64) {
        loop {
            if self.is_halted() {
                return;
            }
            self.find_next();
            if self.clock.next() > to {
                break;
            }
            if self.clock.reach_next() {
                self.halt(Halt::Stopped(StopReason::Limit));
                return;
            }
            self.process();
        }
        self.clock.reach(to);
    }

    /// Everything that is due now.
    pub(super) fn process(&mut self) {
        self.look_for_interruption();
        self.motion.advance(self.clock.now());
        self.log_milestones();
        self.feel_plant();
        match self.scenario.advance(self.clock.now()) {
            Ok(actions) => actions.into_iter().for_each(|action| self.act(action)),
            Err(error) => {
                self.ending.world_error = Some(error);
                self.halt(Halt::Stopped(StopReason::Idle));
                return;
            }
        }
        self.filter();
        while let Some((n, line)) = self.outputs.end_pulse(self.clock.now()) {
            self.write(What::Out { line, n, v: 0, sync: false, pos: None });
            self.outputs_changed();
        }
        self.every();
        if self.buttons.take_hold(self.clock.now()) {
            self.halt(Halt::Stopped(StopReason::Button));
        }
        self.pause_outputs();
        if self.pause.resume_at.is_some_and(|at| self.clock.now() >= at) {
            self.go_on();
        }
        self.run_limits();
        self.laser();
    }

    fn act(&mut self, action: Action) {
        match action {
            Action::Input { n, on } => {
                self.inputs.drive(n, on, self.clock.now());
                self.feel_plant();
                // An emergency stop does not wait for a filter.
                if on && self.role(n) == Some(InputRole::EmergencyStop) {
                    self.emergency_stop();
                }
            }
            Action::Button { button, down } => {
                let n = if button == Button::Start { START } else { STOP };
                self.inputs.drive(n, down, self.clock.now());
            }
            Action::EmergencyStop => self.emergency_stop(),
            Action::Char(c) => self.waits.char_in = c,
            // The engine shares the value.
            Action::Register { .. } => {}
            // The MSP430G2553 reads none.
            Action::Analog { .. } => {}
            Action::Stall { axis, steps } => {
                let direction = self.motion.direction(axis);
                self.plant.lose(axis, if direction < 0 { steps.saturating_neg() } else { steps });
                self.feel_plant();
            }
        }
    }

    /// A filtered input changed: roles, ON IN.
    fn filter(&mut self) {
        while let Some((n, on)) = self.inputs.take_filtered(self.clock.now()) {
            if n == START || n == STOP {
                self.button(if n == START { Button::Start } else { Button::Stop }, on);
                continue;
            }
            self.log.input(self.clock.now(), n, on);
            self.events.input(n, on);
            match self.role(n) {
                Some(InputRole::Start) => self.button(Button::Start, on),
                Some(InputRole::Stop) => self.button(Button::Stop, on),
                Some(InputRole::Hold | InputRole::Door) if on => self.hold(),
                _ => {}
            }
        }
    }

    fn role(&self, n: i32) -> Option<InputRole> {
        self.profile.inputs.iter().find(|input| input.n == n).and_then(|input| input.role)
    }

    /// Ticks of ON EVERY that are due are remembered.
    fn every(&mut self) {
        if !self.pause.is_on() {
            self.events.tick(self.run_clock());
        }
    }

    /// An axis that ran by MoveSpeed rests at its soft limit: F05 comes by itself.
    fn run_limits(&mut self) {
        for axis in Axis::ALL {
            if self.axes.is_running(axis) && self.motion.is_solo_idle(axis) {
                self.adopt(axis);
                self.events.fail_late();
            }
        }
    }
}
