//! State and actions behind the rules of faults ([`crate::rules::handlers`]).

use super::Controller;
use super::events::handlers as open_handlers;
use crate::machine::chip::Chip;
use crate::rules::handlers::{self, Handles};
use lang::fault::Fault;
use lang::vm::flag;
use lang::wire::Called;
use lang::wire::Seen;

/// A fault on its way to its handler.
struct Raised<'a, C: Chip> {
    controller: &'a mut Controller<C>,
    fault: Fault,
    /// Where it is, and whether that is between two statements.
    pc: u16,
    between: bool,
    /// Handlers that are open.
    open: usize,
    /// A statement was under way.
    waits: bool,
}

impl<C: Chip> Controller<C> {
    /// A fault of the program: its handler, or the end of the run.
    pub fn raise(&mut self, fault: Fault, pc: u16, between: bool) {
        let mut raised = Raised {
            open: open_handlers(self.vm.flags),
            waits: self.program.effect.code != 0,
            controller: self,
            fault,
            pc,
            between,
        };
        handlers::raise(&mut raised, fault.number());
    }
}

impl<C: Chip> Handles for Raised<'_, C> {
    fn note(&mut self, fault: u8) {
        self.controller.end_actions();
        self.controller.motor.stop(0b111);
        self.controller.vm.fault = fault;
        self.controller.vm.fault_pc = self.pc;
    }
    fn forget(&mut self) {
        self.controller.program.forget();
    }
    fn abandon_print(&mut self) {
        self.controller.talk.print.abandon();
        self.controller.chip.beside(Seen::Abandoned, 0, self.pc);
    }
    fn leave_statement(&mut self) {
        self.controller.vm.flags &= !(flag::MORE | flag::WITHIN);
    }
    fn is_beyond_handlers(&self) -> bool {
        !self.fault.can_be_handled()
    }
    fn is_in_handler(&self) -> bool {
        self.controller.vm.flags & flag::ERROR != 0
    }
    fn has_handler(&self) -> bool {
        self.controller.vm.handler != 0
    }
    // The handlers of a streamed job are the host's.
    fn open_handler(&mut self) -> bool {
        self.controller.vm.is_piece || self.controller.vm.open_handler(self.pc, self.between)
    }
    fn fail(&mut self) {
        self.controller.fail(self.fault);
    }
    fn enter_handler(&mut self) {
        self.controller.vm.flags |= flag::ERROR;
        if !self.controller.vm.is_piece {
            self.controller.vm.pc = self.controller.vm.handler;
        }
    }
    fn put_feed_aside(&mut self) {
        self.controller.program.put_feed_aside(self.open);
    }
    fn unwind(&mut self) {
        if !self.controller.vm.is_piece {
            self.controller.vm.unwind();
        }
        if self.controller.vm.is_piece {
            let place = match (self.between, self.waits) {
                (false, _) => Called::Failed,
                (true, false) => Called::Behind,
                (true, true) => Called::Within,
            };
            self.controller.call_host(place, 0, self.fault.number());
        }
    }
}
