//! State and actions behind the rules of runs ([`crate::rules::session`]); the state itself is [`crate::session`].

use super::Controller;
use crate::machine::chip::Chip;
use crate::rules::commands;
use crate::rules::session::{AT_FAULT, AT_PAUSE, Runs};
use lang::fault::Fault;
use lang::wire::{End, TraceKind};

impl<C: Chip> Runs for Controller<C> {
    crate::session_leaves!();

    fn is_stored(&self) -> bool {
        self.image().is_some()
    }
    fn set_number(&mut self, n: u8) {
        self.program.effect.n = n;
    }

    fn holds_stop(&self) -> bool {
        self.io.buttons.accepted() & 1 != 0
    }
    fn blocking(&self) -> u8 {
        Controller::blocking(self)
    }
    // What has tripped is looked at by itself, as limit switches may be among it.
    fn has_tripped(&self) -> bool {
        false
    }
    fn emergency_now(&self) -> u8 {
        Controller::emergency_now(self)
    }
    // Who tells of an emergency stop says its input.
    fn note_emergency(&mut self) {}

    // A spindle that comes up again after the last pause lets nothing move any more.
    fn brake_to_pause(&mut self) {
        self.clock.spin = 0;
        self.motor.pause(true);
    }
    fn brake_all(&mut self) {
        self.drop_actions();
        self.clock.spin = 0;
        self.motor.stop(0b111);
        self.motor.end_pause();
    }
    fn give_up(&mut self) {
        commands::abandon(self);
        self.command.jogs = false;
        self.command.hold = 0;
    }
    fn halt(&mut self) {
        self.darken();
        self.drop_actions();
        self.motor.halt();
        self.motor.end_pause();
    }
    fn unwatch(&mut self) {}
    fn forget_homes(&mut self) {
        self.motor.homed = 0;
    }
    fn goes_on_alone(&mut self) -> bool {
        !self.come_to_rest()
    }
    fn rests(&self) -> bool {
        self.motor.rests()
    }
    // The path of a pause is one.
    fn goes_through(&self) -> bool {
        false
    }
    fn seeks(&self) -> bool {
        Controller::seeks(self)
    }
    fn go_on(&mut self) {
        Controller::go_on(self);
    }

    fn set_outputs_at(&mut self, occasion: u8) {
        let states = match occasion {
            AT_PAUSE => self.record.pause,
            AT_FAULT => self.record.fault,
            _ => self.record.end,
        };
        self.io.outputs = self.io.outputs & states.keep | states.on;
        if occasion == AT_PAUSE {
            self.pause_aout();
            self.drive_pwm();
        } else {
            self.go_safe();
        }
        self.drive_aout();
    }
    fn exchange(&mut self) {
        Controller::exchange(self);
    }
    fn outputs(&self) -> u16 {
        self.io.outputs
    }
    // After a pause.
    fn set_outputs(&mut self, outputs: u16) {
        self.io.outputs = outputs;
        self.resume_aout();
    }
    fn resume_outputs(&self) -> u16 {
        self.io.resume
    }
    fn set_resume(&mut self, outputs: u16) {
        self.io.resume = outputs;
    }
    fn spindle(&self) -> u8 {
        let n = self.record.spindle;
        u8::from(n != 0 && self.io.outputs >> ((n - 1) & 15) & 1 != 0)
    }
    fn spin_up(&self) -> u16 {
        self.record.spin_up
    }
    fn spin(&self) -> u16 {
        self.clock.spin
    }
    fn set_spin(&mut self, ms: u16) {
        self.clock.spin = ms;
    }

    // One that was raised has its place already.
    fn latch(&mut self, fault: u8) {
        if self.vm.fault != fault {
            self.vm.fault = fault;
            self.vm.fault_pc = self.place();
        }
        self.session.fault = fault;
    }
    // One that was handled is the VM's alone.
    fn forget_fault(&mut self) {}
    fn log(&mut self) {
        Controller::log(self);
    }
    fn has_next_line(&self) -> bool {
        false
    }
    fn drop_line(&mut self) {}

    // The host has not read how the last run ended: the press comes too early.
    fn before_start(&self) -> u8 {
        u8::from(self.trace.is_unread())
    }
    fn attach(&mut self) -> bool {
        if let Err(fault) = self.choose() {
            self.fail(fault);
            return false;
        }
        let Some(image) = self.image() else { return false };
        let sound = self.enter(image);
        if !sound {
            self.fail(Fault::ImageRefused);
        }
        sound
    }
    // `attach` has said why.
    fn refuse(&mut self) {}
    // So it has put the VM where the program begins.
    fn enter(&mut self) {}
    fn program_has_courses(&self) -> bool {
        false
    }
    fn take_courses(&mut self) {}
    fn load(&mut self) {}
    fn set_stack(&mut self) {}
    fn begin_trace(&mut self) {
        self.trace.begin();
    }
    // `begin_trace` has seen to that.
    fn halts(&self) -> bool {
        false
    }
    fn halt_first(&mut self) {}
    fn begun(&mut self) {
        self.set_out_anew();
    }

    fn tells(&self) -> bool {
        self.trace.full
    }
    fn keeps_flash(&self) -> u8 {
        u8::from(!self.motor.settled() || !self.lines.rests)
    }
    fn save_kept(&mut self) {
        self.save();
    }
    fn leave_courses(&mut self) {}
    fn unmark(&mut self) {
        self.drive_pwm();
        self.chip.mark(false);
    }
    fn settle_place(&mut self) {
        if self.session.last == End::Fault as u8 {
            self.program.pc = self.vm.fault_pc;
        } else if self.session.last != End::Done as u8 {
            if self.program.effect.code == 0 {
                self.program.pc = self.vm.pc;
            }
            self.program.pc = self.place();
        }
    }
    fn tell_end(&mut self, fault: i32) {
        self.emit(TraceKind::End, self.session.last, fault);
    }
    fn forget(&mut self) {
        self.program.effect.code = 0;
    }
    fn leave(&mut self) {
        self.program.forget();
        self.session.forget_wait();
        // A streamed run leaves what is stored, or nothing.
        self.session.stored(self.image().is_some());
    }
    fn restart(&mut self) {
        if !self.session.is_active() && self.motor.moving() == 0 {
            self.reset.wanted = true;
        }
    }
}
