//! SYNC: the statement, and the switching of outputs at their place along the path ([`crate::motion::actions`]).

use super::Controller;
use crate::machine::chip::Chip;
use crate::motion::actions::{Action, MOST_LEAD, MOST_MS, MOST_WAY};
use lang::fault::Fault;
use lang::isa::flags;
use lang::wire::{RunState, TRACE_OK, TraceKind};

impl<C: Chip> Controller<C> {
    /// SYNC: takes the action, once there is room for another one.
    ///
    /// # Errors
    /// F20: no such output, or one of the controller's; a time or a lead beyond its limits; too many that wait for places after the path's end.
    pub fn sync(&mut self) -> Result<bool, Fault> {
        if !self.motor.actions.has_room() {
            if self.motor.path_rests() {
                // More than there is room for at one place, without a block that would bring them there.
                let end = self.motor.path_end();
                if self.motor.actions.all_lie_beyond(end) {
                    return Err(Fault::ValueRange);
                }
                self.flush_actions(Some(end));
            }
            return Ok(false);
        }
        let bits = self.vm.operand();
        let [lead, value, n] = [self.vm.pop(), self.vm.pop(), self.vm.pop()];
        let (mut action, mut fits);
        if bits & flags::SYNC_ANALOG != 0 {
            fits = self.takes_aout(n, value);
            action = Action::analog(n as u8, value as u16, value as u16 != self.safe_aout());
        } else {
            let pulse = bits & flags::SYNC_PULSE != 0;
            fits = (1..=16).contains(&n) && self.may_switch(n as u8);
            action = Action::new(n as u8, pulse || value != 0);
            if pulse {
                fits &= (1..=MOST_MS).contains(&value);
                action.pulse = value as u16;
            }
        }
        let mut way = lead;
        if bits & flags::LEAD_TIME != 0 {
            fits &= (-MOST_MS..=MOST_LEAD).contains(&lead);
            action.lead = lead as i16;
            way = 0;
        }
        fits &= (-MOST_WAY..=MOST_WAY).contains(&way);
        if !fits {
            return Err(Fault::ValueRange);
        }
        action.pc = self.pc_of_effect();
        // A host that takes one event after the other hears of it here, as of blocks.
        if self.trace.on || self.vm.is_piece {
            let (kind, argument, value) = self.told(&action);
            self.emit(kind, argument, value);
        }
        self.motor.act(action, way);
        Ok(true)
    }

    /// One pass: what is due is carried out, each at the pins before the next.
    #[inline(never)]
    pub fn act(&mut self) {
        self.motor.follow_actions();
        while let Some(action) = self.motor.due_action() {
            self.carry_out(action);
        }
    }

    /// The path is at its end, and no block follows what still waits for one: up to the place `most`, um along the path, or
    /// for any.
    #[inline(never)]
    pub fn flush_actions(&mut self, most: Option<u32>) {
        while let Some(action) = self.motor.actions.flush(most) {
            self.carry_out(action);
        }
    }

    /// A fault that a handler may take puts no output into its state: what was to go off goes off now, the rest is dropped.
    pub fn end_actions(&mut self) {
        while let Some(action) = self.motor.actions.take_off() {
            self.carry_out(action);
        }
        self.drop_actions();
    }

    /// The event of an action: kind, argument, value.
    fn told(&self, action: &Action) -> (TraceKind, u8, i32) {
        let n = action.output() | TRACE_OK;
        if action.is_analog() {
            return (TraceKind::Aout, self.aout_argument(n), action.pulse.into());
        }
        (TraceKind::Out, n, action.is_on().into())
    }

    /// An analog output acts. In a pause in which it has its safe value another one waits for the end of it.
    fn carry_out_analog(&mut self, action: &Action) {
        let mut waits = false;
        if self.session.is(RunState::Paused) {
            self.io.aout.resume = action.pulse;
            waits = action.is_on() && self.pauses_aout();
        }
        if !waits {
            self.set_aout(action.pulse);
        }
    }

    fn carry_out_switch(&mut self, action: &Action) {
        let n = action.output();
        let bit = 1 << (n.wrapping_sub(1) & 15);
        let on = action.is_on();
        // In a pause what is off stays off until it is over.
        if self.session.is(RunState::Paused) {
            self.io.resume &= !bit;
            if on {
                self.io.resume |= bit;
            } else {
                self.set_output(n.into(), false);
            }
        } else {
            self.set_output(n.into(), on);
        }
    }

    #[inline(never)]
    fn carry_out(&mut self, action: Action) {
        if action.is_analog() {
            self.carry_out_analog(&action);
        } else {
            self.carry_out_switch(&action);
        }
        self.exchange();
        if !self.trace.on && !self.vm.is_piece {
            let places = self.motor.places();
            let (kind, argument, value) = self.told(&action);
            self.chip.event(kind as u8, argument, value, &places, action.pc);
        }
    }

    /// A run ends, or something has gone wrong: nothing acts any more, and what pulses keep on goes off.
    pub fn drop_actions(&mut self) {
        let on = self.motor.actions.drop_all();
        self.io.outputs &= !on;
        self.io.resume &= !on;
    }
}
