//! One pass of the program: runs the VM to its next effect, then polls the effect.

use super::Controller;
use super::effect::{END, Effect};
use crate::machine::chip::Chip;
use crate::machine::vm::{HANDLER_END, YIELD};
use crate::rules::{commands, session};
use lang::fault::Fault;
use lang::isa::{first, last};
use lang::vm::flag;
use lang::wire::RunState;

/// Codes from here on are effects.
const FIRST_EFFECT: u16 = lang::isa::EFFECTS as u16;
/// Those below them, which only larger parts have.
const SYNC: u16 = first::Sync as u16;
const SET_AOUT: u16 = first::SetAout as u16;

/// Whether an effect tells nothing behind its first call.
fn tells_once(code: u8) -> bool {
    matches!(code, first::Linear..=last::MoveRamp | first::Arc..=last::ArcBy | first::Wait | first::StopAxe)
}

impl<C: Chip> Controller<C> {
    /// One pass of the program.
    pub fn run(&mut self) {
        if self.session.is(RunState::Stopping) {
            session::stopping(self);
            return;
        }
        if self.session.is(RunState::Paused) {
            return;
        }
        if !self.session.executes() {
            if !self.session.is_active() && self.program.effect.code != 0 {
                self.direct_effect();
            }
            return;
        }
        // The handler comes over the link.
        if self.awaits_handler() {
            return;
        }
        if self.motor.take_limited() != 0 {
            let pc = if self.program.effect.code != 0 { self.program.pc } else { self.vm.pc };
            self.raise(Fault::SoftLimit, pc, true);
            return;
        }
        if let Some((fault, pc)) = self.program.late {
            if self.motor.path_rests() {
                self.program.late = None;
                self.raise(fault, pc, false);
            }
            return;
        }
        self.pulse_over();
        if self.program.effect.code == 0 {
            self.step();
        }
        self.go_on();
    }

    /// Goes on with the effect under way, if there is one.
    pub fn go_on(&mut self) {
        // A line longer than the ring was announced by the event that fills the slot, and the host
        // takes it before it asks for the next one.
        let prints = matches!(
            self.program.effect.code,
            first::PrintNumber..=last::PrintTextFar | first::PrintEnd
        );
        // What tells its only event at its beginning goes on to its end: a host halts the program before
        // the next effect.
        let told = self.program.effect.phase != 0 && tells_once(self.program.effect.code);
        let free = !self.trace.full || told || self.talk.announced && prints;
        if self.program.effect.code != 0 && free {
            match self.perform() {
                Ok(true) => {
                    self.program.forget();
                    self.serve();
                }
                Ok(false) => self.serve(),
                Err(fault) => {
                    let pc = self.program.pc;
                    self.found(fault, pc);
                }
            }
        }
    }

    /// The program or piece has come to its end.
    fn ended(&mut self) {
        match self.follow_piece() {
            Ok(true) if self.stream.is_dry() => return self.serve(),
            Ok(true) => return,
            Ok(false) => {}
            Err(fault) => return self.fail(fault),
        }
        self.program.effect.code = END;
    }

    /// Goes on with a homing or probing command.
    fn direct_effect(&mut self) {
        let result = self.perform();
        if let Ok(false) = result {
            return;
        }
        if result.is_err() {
            commands::abandon(self);
        }
        self.program.forget();
    }

    /// Lets the VM run to its next effect, or for a slice.
    fn step(&mut self) {
        self.vm.poll = 0;
        let exit = self.chip.run(&mut self.vm);
        // Codes above a byte leave the core between two instructions.
        // Behind an instruction, and behind the wait that a handler goes back to.
        let behind = exit <= 0xFF || exit == HANDLER_END;
        self.program.pc = self.vm.pc.wrapping_sub(u16::from(behind));
        match exit {
            YIELD => self.serve(),
            HANDLER_END => {
                self.vm.flags &= !flag::EVENT;
                self.handler_left();
            }
            0 => self.ended(),
            SYNC..=SET_AOUT | FIRST_EFFECT..=0xFF => {
                let more = self.vm.flags & flag::MORE != 0;
                self.vm.flags &= !(flag::MORE | flag::WITHIN);
                if more {
                    self.vm.flags |= flag::WITHIN;
                }
                self.program.effect.code = exit as u8;
            }
            0x01..FIRST_EFFECT => match self.vm.soft(exit as u8, &self.motor.machine) {
                Ok(false) => {}
                // A GOTO left the error handler and with it what it had interrupted.
                Ok(true) if exit as u8 == first::Leave => {
                    self.program.outer = Effect::NONE;
                    self.serve();
                }
                Ok(true) => self.handler_left(),
                Err(fault) => self.found(fault, self.vm.pc.wrapping_sub(1)),
            },
            _ => {
                let fault = Fault::from_number(exit as u8).unwrap_or(Fault::ImageRefused);
                self.found(fault, self.vm.pc.wrapping_sub(1));
            }
        }
    }
}
