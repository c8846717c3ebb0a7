//! SYNC: the statement, and the switching of outputs at their place along the path ([`crate::motion::actions`]).

use super::Controller;
use crate::machine::chip::Chip;
use crate::motion::actions::{Action, MOST_LEAD, MOST_MS};
use lang::fault::Fault;
use lang::isa::flags;
use lang::wire::{RunState, TRACE_OK, TraceKind};

impl<C: Chip> Controller<C> {
    /// SYNC: takes the action, once there is room for another one.
    ///
    /// # Errors
    /// F20: no such output, a time or a lead beyond its limits; too many that wait for places after the path's end.
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
        let there = (1..=16).contains(&n) && self.all_outputs() >> ((n - 1) & 15) & 1 != 0;
        let pulse = bits & flags::SYNC_PULSE != 0;
        let mut action = Action::new(n as u8, pulse || value != 0);
        let mut way = lead;
        let mut fits = there;
        if pulse {
            fits &= (1..=MOST_MS).contains(&value);
            action.pulse = value as u16;
        }
        if bits & flags::LEAD_TIME != 0 {
            fits &= (-MOST_MS..=MOST_LEAD).contains(&lead);
            action.lead = lead as i16;
            way = 0;
        }
        if !fits {
            return Err(Fault::ValueRange);
        }
        action.pc = self.pc_of_effect();
        // A host that takes one event after the other hears of it here, as of blocks.
        if self.trace.on || self.vm.is_piece {
            self.emit_outcome(TraceKind::Out, n as u8, true, i32::from(action.is_on()));
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

    #[inline(never)]
    fn carry_out(&mut self, action: Action) {
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
        self.exchange();
        if !self.trace.on && !self.vm.is_piece {
            let places = self.motor.places();
            self.chip.event(TraceKind::Out as u8, n | TRACE_OK, on.into(), &places, action.pc);
        }
    }

    /// A run ends, or something has gone wrong: nothing acts any more, and what pulses keep on goes off.
    pub fn drop_actions(&mut self) {
        let on = self.motor.actions.drop_all();
        self.io.outputs &= !on;
        self.io.resume &= !on;
    }
}
