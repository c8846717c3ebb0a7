//! Start of a run, and the faults that end one; how Start, Stop and the link interact is in [`crate::rules::session`].

use super::Controller;
use crate::machine::chip::Chip;
use crate::machine::flash::Area;
use crate::machine::reset;
use crate::rules::session;
use crate::store::Store;
use crate::verify;
use lang::fault::Fault;
use lang::wire::{Control, Seen};

impl<C: Chip> Controller<C> {
    /// A control code from the link or a button.
    pub fn control(&mut self, control: Control) {
        if let Control::EmergencyStop = control {
            self.program.fault_input = 0;
        }
        session::control(self, control as u8);
    }

    /// The VM stands at the beginning of the program at an address; `false` when that fails its check.
    pub(super) fn enter(&mut self, image: u16) -> bool {
        if verify::sound(&self.image_at(image), Store::area::<Area<C>>()).is_none()
            || !self.check(image)
        {
            return false;
        }
        self.forget_pieces();
        self.begin_image(image, self.keep_base());
        self.load();
        // What the check and the flash took is none of the program's time: a wait would be shorter by it.
        self.clock.tick = self.chip.millis();
        true
    }

    /// A run of the image at an address begins, which the caller has checked and which no library holds: a simulation
    /// keeps the program's flow to itself and brings the VM one statement after the other.
    pub fn begin_at(&mut self, image: u16) {
        self.begin_image(image, 0);
        self.begun();
    }

    /// The VM stands at the beginning of a run.
    pub fn begun(&mut self) {
        self.trace.begin();
        self.set_out_anew();
    }

    /// The VM stands at the beginning of a program, whose run goes on from another's: the host hears of both.
    pub fn set_out_anew(&mut self) {
        self.chip.beside(Seen::Begun, 0, 0);
        self.chip.mark(true);
        self.command.jogs = false;
        self.session.begun();
        self.motor.begin();
        self.program.begin(self.default_feed());
        self.motor.power = self.full_power();
        self.motor.follows = false;
        self.talk.abandon();
    }

    /// The emergency stop at an input.
    pub fn emergency(&mut self, input: u8) {
        self.program.fault_input = input;
        session::emergency(self);
    }

    /// A fault that ends the run.
    pub fn fail(&mut self, fault: Fault) {
        session::fail(self, fault.number());
    }

    /// A fault of the statement at `pc`: what was commanded before it ends first.
    pub(super) fn found(&mut self, fault: Fault, pc: u16) {
        if self.motor.path_rests() {
            self.raise(fault, pc, false);
        } else {
            self.program.forget();
            self.program.late = Some((fault, pc));
        }
    }

    /// The last fault with its place and input survives power-off.
    pub(super) fn log(&mut self) {
        let pc = self.vm.fault_pc.wrapping_sub(self.vm.code);
        let number = u16::from(self.session.fault);
        let line = self.vm.line(self.vm.fault_pc);
        reset::log(&self.chip, [number | u16::from(self.program.fault_input) << 8, pc, line]);
    }
}
