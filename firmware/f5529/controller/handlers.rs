//! What the rules of faults look at and do here.

use super::Controller;
use super::events::handlers as open_handlers;
use crate::observe;
use crate::vm::vm;
use firmware::rules::handlers::{self, Handles};
use lang::fault::Fault;
use lang::vm::flag;
use lang::wire::Called;
use lang::wire::Seen;

/// A fault on its way to its handler.
struct Raised<'a> {
    controller: &'a mut Controller,
    fault: Fault,
    /// Where it is, and whether that is between two statements.
    pc: u16,
    between: bool,
    /// Handlers that are open.
    open: usize,
    /// A statement was under way.
    waits: bool,
}

impl Controller {
    /// A fault of the program: its handler, or the end of the run.
    pub fn raise(&mut self, fault: Fault, pc: u16, between: bool) {
        let mut raised = Raised {
            open: open_handlers(),
            waits: self.program.effect.code != 0,
            controller: self,
            fault,
            pc,
            between,
        };
        handlers::raise(&mut raised, fault.number());
    }
}

impl Handles for Raised<'_> {
    fn note(&mut self, fault: u8) {
        self.controller.motor.stop(0b111);
        vm().fault = fault;
        vm().fault_pc = self.pc;
    }
    fn forget(&mut self) {
        self.controller.program.forget();
    }
    fn abandon_print(&mut self) {
        self.controller.talk.print.abandon();
        observe::beside(Seen::Abandoned, 0, self.pc);
    }
    fn leave_statement(&mut self) {
        vm().flags &= !(flag::MORE | flag::WITHIN);
    }
    fn is_beyond_handlers(&self) -> bool {
        !self.fault.can_be_handled()
    }
    fn is_in_handler(&self) -> bool {
        vm().flags & flag::ERROR != 0
    }
    fn has_handler(&self) -> bool {
        vm().handler != 0
    }
    // The handlers of a streamed job are the host's.
    fn open_handler(&mut self) -> bool {
        crate::streams() || vm().open_handler(self.pc, self.between)
    }
    fn fail(&mut self) {
        self.controller.fail(self.fault);
    }
    fn enter_handler(&mut self) {
        vm().flags |= flag::ERROR;
        if !crate::streams() {
            vm().pc = vm().handler;
        }
    }
    fn put_feed_aside(&mut self) {
        self.controller.program.put_feed_aside(self.open);
    }
    fn unwind(&mut self) {
        if !crate::streams() {
            vm().unwind();
        }
        if crate::stream::owns() {
            let place = match (self.between, self.waits) {
                (false, _) => Called::Failed,
                (true, false) => Called::Behind,
                (true, true) => Called::Within,
            };
            crate::stream::call(place, 0, self.fault.number());
        }
    }
}
