//! Time: what happens next, and letting it happen.

use lang::axis::Axis;
use lang::fault::Fault;
use lang::profile::InputRole;

use super::inputs::{START, STOP};
use super::{Halt, Machine};
use crate::sim::record::StopReason;
use crate::sim::trace::What;
use crate::sim::world::{Action, Button};

/// Stop held that long ends the run, us.
const HOLD_US: u64 = 2_000_000;

impl Machine {
    /// Time of the clocks that a pause holds: TIMER, waits, ON EVERY; us.
    pub(super) fn run_clock(&self) -> u64 {
        self.paused_since.unwrap_or(self.now) - self.paused_us
    }

    /// The simulated time at which the run clock shows `run`.
    pub(super) fn at_run_clock(&self, run: u64) -> u64 {
        run + self.paused_us
    }

    /// Finds out when something happens next.
    pub(super) fn find_next(&mut self) -> Option<u64> {
        let next = self.next_change();
        self.next = next.unwrap_or(u64::MAX).min(self.limit).max(1);
        next
    }

    /// The earliest thing that can happen by itself.
    fn next_change(&self) -> Option<u64> {
        let every = if self.paused_since.is_none() {
            self.slots.iter().flatten().filter_map(|slot| slot.tick).min()
        } else {
            None
        };
        let stop = self.stop_held_since.map(|since| since + HOLD_US);
        [
            self.scenario.next_us(),
            self.motion.next_us(),
            self.next_crossing(),
            self.inputs.next_us(),
            self.outputs.next_us(),
            every.map(|run| self.at_run_clock(run)),
            stop,
            self.resume_at,
        ]
        .into_iter()
        .flatten()
        .min()
        .map(|us| us.max(self.now))
    }

    /// When a moving axis comes to a place where its switch or the plate changes.
    fn next_crossing(&self) -> Option<u64> {
        let mut first = None;
        for axis in Axis::ALL {
            if !self.motion.turns(axis) {
                continue;
            }
            for place in self.plant.thresholds(axis, &self.scenario) {
                let at = self.motion.reaches(axis, place, self.now);
                first = first.into_iter().chain(at).min();
            }
        }
        first
    }

    /// Advances to the next thing that happens, or to `deadline` if that is earlier; `false` when
    /// nothing can happen any more, which stops the run.
    pub(super) fn tick(&mut self, deadline: Option<u64>) -> bool {
        let next = self.find_next();
        let Some(to) = next.into_iter().chain(deadline).min() else {
            self.halt = Some(Halt::Stopped(StopReason::Idle));
            return false;
        };
        self.advance_to(to.max(self.now));
        self.halt.is_none()
    }

    /// Lets everything happen until `to`.
    pub(super) fn advance_to(&mut self, to: u64) {
        loop {
            if self.halt.is_some() {
                return;
            }
            self.find_next();
            if self.next > to {
                break;
            }
            self.now = self.now.max(self.next);
            if self.now >= self.limit {
                self.now = self.limit;
                self.halt = Some(Halt::Stopped(StopReason::Limit));
                self.attention = true;
                return;
            }
            self.process();
        }
        self.now = self.now.max(to);
    }

    /// Everything that is due now.
    pub(super) fn process(&mut self) {
        self.look_for_interruption();
        self.motion.advance(self.now);
        self.log_milestones();
        self.feel_plant();
        match self.scenario.advance(self.now) {
            Ok(actions) => actions.into_iter().for_each(|action| self.act(action)),
            Err(error) => {
                self.world_error = Some(error);
                self.halt = Some(Halt::Stopped(StopReason::Idle));
                self.attention = true;
                return;
            }
        }
        self.filter();
        while let Some((n, line)) = self.outputs.end_pulse(self.now) {
            self.write(What::Out { line, n, v: 0 });
            self.outputs_changed();
        }
        self.every();
        if self.stop_held_since.is_some_and(|since| self.now >= since + HOLD_US) {
            self.stop_held_since = None;
            self.halt = Some(Halt::Stopped(StopReason::Button));
            self.attention = true;
        }
        self.pause_outputs();
        if self.resume_at.is_some_and(|at| self.now >= at) {
            self.go_on();
        }
        self.run_limits();
        self.laser();
    }

    fn act(&mut self, action: Action) {
        match action {
            Action::Input { n, on } => {
                self.inputs.drive(n, on, self.now);
                self.feel_plant();
                // An emergency stop does not wait for a filter.
                if on && self.role(n) == Some(InputRole::EmergencyStop) {
                    self.emergency_stop();
                }
            }
            Action::Button { button, down } => {
                let n = if button == Button::Start { START } else { STOP };
                self.inputs.drive(n, down, self.now);
            }
            Action::EmergencyStop => self.emergency_stop(),
            Action::Char(c) => self.char_in = c,
            // The engine shares the value.
            Action::Register { .. } => {}
            Action::Stall { axis, steps } => {
                let direction = self.motion.direction(axis);
                self.plant.lose(axis, if direction < 0 { steps.saturating_neg() } else { steps });
                self.feel_plant();
            }
        }
    }

    /// A filtered input changed: roles, ON IN.
    fn filter(&mut self) {
        while let Some((n, on)) = self.inputs.take_filtered(self.now) {
            if n == START || n == STOP {
                self.button(if n == START { Button::Start } else { Button::Stop }, on);
                continue;
            }
            self.log.input(self.now, n, on);
            self.input_event(n, on);
            match self.role(n) {
                Some(InputRole::Start) => self.button(Button::Start, on),
                Some(InputRole::Stop) => self.button(Button::Stop, on),
                Some(InputRole::Hold | InputRole::Door) if on => self.pause(),
                _ => {}
            }
        }
    }

    fn role(&self, n: i32) -> Option<InputRole> {
        self.profile.inputs.iter().find(|input| input.n == n).and_then(|input| input.role)
    }

    fn button(&mut self, button: Button, down: bool) {
        match (button, down) {
            (Button::Stop, true) => {
                self.stop_held_since = Some(self.now);
                self.pause();
            }
            (Button::Stop, false) => self.stop_held_since = None,
            (Button::Start, true) => {
                if self.stop_held_since.is_some() || self.is_held() {
                    return;
                }
                if self.paused_since.is_none() {
                    self.start_presses += 1;
                } else if self.resume_at.is_none() {
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

    fn emergency_stop(&mut self) {
        self.cut = self.pieces.line;
        self.motion.halt(self.now);
        self.log_milestones();
        for axis in Axis::ALL {
            self.axes.set_homed(axis, false);
            self.adopt(axis);
        }
        self.halt = Some(Halt::Fault(Fault::EmergencyStop));
        self.attention = true;
    }

    fn pause(&mut self) {
        if self.paused_since.is_none() {
            self.paused_since = Some(self.now);
            self.motion.pause(true, self.now);
            self.attention = true;
        }
        self.resume_at = None;
    }

    /// Outputs take their pause states when the machine has come to a stand.
    fn pause_outputs(&mut self) {
        if self.paused_since.is_some() && !self.outputs_paused && self.motion.stands() {
            self.outputs_paused = true;
            self.outputs.pause();
            self.outputs_changed();
        }
    }

    fn start_again(&mut self) {
        let spin_up = self.outputs_paused && self.outputs.resume();
        self.outputs_paused = false;
        self.outputs_changed();
        if spin_up && self.profile.run.spin_up_ms > 0 {
            self.resume_at = Some(self.now + u64::from(self.profile.run.spin_up_ms) * 1_000);
        } else {
            self.go_on();
        }
    }

    fn go_on(&mut self) {
        self.resume_at = None;
        if let Some(since) = self.paused_since.take() {
            self.paused_us += self.now - since;
            self.motion.pause(false, self.now);
            self.log_milestones();
        }
    }

    /// Reference switches and probe as they are now.
    pub(super) fn feel_plant(&mut self) {
        let at = self.motion.positions(self.now);
        self.plant.reach(at);
        for axis in Axis::ALL {
            let closed = self.plant.switch_closed(axis, at[axis.index()], &self.scenario);
            self.inputs.sense(self.profile.reference_input(axis), closed, self.now);
        }
        let touches = self.scenario.probe_touches(self.plant.true_positions(at));
        self.inputs.sense(self.profile.probe_input(), touches, self.now);
        self.seek_inputs();
        self.limit_switches();
    }

    /// F06: an axis runs into its closed reference switch outside homing.
    fn limit_switches(&mut self) {
        for axis in Axis::ALL {
            let Some(part) = self.profile.axis(axis) else { continue };
            let toward = part.home.direction.sign();
            if self.homing() != Some(axis)
                && self.halt.is_none()
                && self.motion.direction(axis) == toward
                && self.inputs.raw(self.profile.reference_input(axis))
            {
                self.cut = self.pieces.line;
                self.motion.halt(self.now);
                self.log_milestones();
                self.axes.set_homed(axis, false);
                Axis::ALL.into_iter().for_each(|axis| self.adopt(axis));
                self.halt = Some(Halt::Fault(Fault::LimitSwitch));
                self.attention = true;
            }
        }
    }

    /// A laser shines only while an axis turns, and with some power. What the board makes of less
    /// than full power, on and off each millisecond, counts as on here.
    fn laser(&mut self) {
        let power = self.pieces.beam.unwrap_or(self.power);
        let turning = power > 0 && Axis::ALL.into_iter().any(|axis| self.motion.turns(axis));
        if self.outputs.shine(turning) {
            self.outputs_changed();
        }
    }

    /// Tells the world and the record which outputs changed.
    pub(super) fn outputs_changed(&mut self) {
        for (n, on) in self.outputs.take_changes() {
            self.log.output(self.now, n, on);
            self.scenario.output_changed(n, on, self.now);
        }
        self.next = 0;
    }
}
