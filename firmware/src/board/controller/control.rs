//! Begin, pause and end of a run, and the faults that end one.

use super::Controller;
use super::events::handlers;
use crate::flash::{Area, Image};
use crate::moves::default_feed;
use crate::observe;
use crate::vm::vm;
use firmware::session::Order;
use firmware::store::Store;
use firmware::verify;
use lang::fault::Fault;
#[cfg(feature = "stream")]
use lang::wire::Called;
use lang::wire::{Control, RunState, Seen};

impl Controller {
    /// A control code from the link.
    pub fn control(&mut self, control: Control) {
        let program = self.image().is_some();
        let blocked = self.blocked();
        let order = match control {
            Control::Start => self.session.start(blocked, program),
            Control::Stop => self.session.stop(),
            Control::Pause => self.session.pause(),
            Control::Resume if !blocked => self.session.resume(),
            Control::EmergencyStop => {
                self.emergency(0);
                Order::None
            }
            Control::Restart if !self.session.is_active() && self.motor.moving() == 0 => {
                self.reset.wanted = true;
                Order::None
            }
            Control::Acknowledge if self.session.state() as u8 == RunState::Fault as u8 => {
                self.session.start(blocked, program)
            }
            _ => Order::None,
        };
        self.obey(order);
    }

    /// Does what the session decided.
    pub fn obey(&mut self, order: Order) {
        match order {
            Order::None => {}
            Order::Begin => self.begin(),
            Order::Brake => {
                self.motor.pause(true);
            }
            Order::Resume => {
                let before = self.io.outputs;
                self.io.outputs = self.io.resume;
                let spindle = self.record.spindle;
                let bit = if spindle == 0 { 0 } else { 1 << ((spindle - 1) & 15) };
                self.clock.spin = 1;
                if self.io.outputs & !before & bit != 0 {
                    self.clock.spin += self.record.spin_up;
                }
            }
            Order::Finish => self.motor.stop(0b111),
        }
    }

    /// Checks the stored program and starts it.
    pub(super) fn begin(&mut self) {
        // The host has not read how the last run ended: the press comes too early.
        if self.trace.is_unread() {
            return;
        }
        if let Err(fault) = self.choose() {
            self.fail(fault);
            return;
        }
        let Some(image) = self.image() else { return };
        if !self.enter(image) {
            self.fail(Fault::ImageRefused);
            return;
        }
        self.begun();
    }

    /// The VM stands at the beginning of the program at an address; `false` when that fails its check.
    pub(super) fn enter(&mut self, image: u16) -> bool {
        if verify::sound(&Image(image), Store::area::<Area>()).is_none() || !self.check(image) {
            return false;
        }
        #[cfg(feature = "stream")]
        crate::stream::forget_pieces();
        vm().begin(image, self.keep_base());
        self.load();
        true
    }

    /// The VM stands at the beginning of a run.
    pub fn begun(&mut self) {
        self.trace.begin();
        self.set_out_anew();
    }

    /// The VM stands at the beginning of a program, whose run goes on from another's: the host hears of both.
    pub fn set_out_anew(&mut self) {
        observe::beside(Seen::Begun, 0, 0);
        crate::boot::mark(true);
        self.command.jogs = false;
        self.session.begun();
        self.motor.begin();
        self.program.begin(default_feed());
        self.motor.power = self.full_power();
        self.motor.follows = false;
        self.talk.abandon();
    }

    /// Steps cease at once, outputs go to their safe states whatever trace and KEEP values have to do,
    /// F14 is latched.
    pub fn emergency(&mut self, input: u8) {
        self.darken();
        self.motor.halt();
        self.motor.homed = 0;
        self.io.outputs = self.io.outputs & self.record.fault.keep | self.record.fault.on;
        self.exchange();
        self.program.fault_input = input;
        self.program.effect.code =
            if self.session.is_active() { self.program.effect.code } else { 0 };
        self.fail(Fault::EmergencyStop);
    }

    /// A fault that ends the run.
    pub fn fail(&mut self, fault: Fault) {
        if vm().fault != fault.number() {
            vm().fault = fault.number();
            vm().fault_pc = self.place();
        }
        let order = self.session.end(Some(fault));
        self.obey(order);
    }

    /// A fault of the program: its handler, or the end of the run.
    pub fn raise(&mut self, fault: Fault, pc: u16, between: bool) {
        self.motor.stop(0b111);
        let open = handlers();
        let waits = self.program.effect.code != 0;
        self.program.forget();
        self.talk.print.abandon();
        observe::beside(Seen::Abandoned, 0, pc);
        if vm().raise(fault, pc, between) {
            self.program.put_feed_aside(open);
            #[cfg(feature = "stream")]
            if crate::stream::owns() {
                let place = match (between, waits) {
                    (false, _) => Called::Failed,
                    (true, false) => Called::Behind,
                    (true, true) => Called::Within,
                };
                crate::stream::call(place, 0, fault.number());
            }
        } else {
            self.fail(fault);
        }
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
        let pc = vm().fault_pc.wrapping_sub(vm().code);
        let number = u16::from(self.session.fault());
        crate::boot::log([
            number | u16::from(self.program.fault_input) << 8,
            pc,
            vm().line(vm().fault_pc),
        ]);
    }
}
