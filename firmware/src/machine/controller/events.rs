//! Events (ON lines), and the handlers that events and faults start.

use super::Controller;
use super::effect::{Effect, PULSE};
use super::program::Program;
use crate::machine::chip::Chip;
use lang::fault::Fault;
use lang::isa::Op;
use lang::vm::flag;
use lang::wire::Called;

/// An ON line.
#[derive(Clone, Copy)]
pub struct Event {
    /// 0 none, 1 rise, 2 fall, 3 every; bit 7: it has come and was not served.
    pub kind: u8,
    /// Input number.
    pub n: u8,
    /// Period, ms.
    pub period: i32,
    /// Milliseconds to the next tick.
    pub left: i32,
}

/// [`Event::kind`]: it has come and was not served.
pub const PENDING: u8 = 0x80;

/// Whether a handler is open, by the VM's flags.
pub fn is_in_handler(flags: u8) -> bool {
    handlers(flags) != 0
}

/// Handlers that are open: at most one of an event and one of errors.
pub(super) fn handlers(flags: u8) -> usize {
    usize::from(flags & flag::EVENT != 0) + usize::from(flags & flag::ERROR != 0)
}

impl<C: Chip> Controller<C> {
    /// A handler has come to its end: what it interrupted goes on.
    pub(super) fn handler_left(&mut self) {
        let open = handlers(self.vm.flags);
        self.program.feed = self.program.feeds_aside[open & 1];
        if open == 0 {
            self.program.effect = self.program.outer;
            self.program.outer = Effect::NONE;
        }
        // A wait that was interrupted may be over: then that comes first.
        if self.program.effect.code == 0 {
            self.serve();
        }
    }

    /// Begins the handler of the first event that has come, between statements and in waits.
    pub(super) fn serve(&mut self) {
        // Never inside a move: only waits are interrupted, once they have begun.
        const WAITS: [u8; 7] = [
            0,
            PULSE,
            Op::Wait as u8,
            Op::WaitIn as u8,
            Op::WaitChar as u8,
            Op::WaitStart as u8,
            Op::WaitMove as u8,
        ];
        let code = self.program.effect.code;
        #[expect(clippy::manual_contains, reason = "a call of memchr is longer")]
        let waits = WAITS.iter().any(|&wait| wait == code);
        if !self.vm.can_interrupt() || !waits || (code != 0 && self.program.effect.phase == 0) {
            return;
        }
        let mut slot = 0;
        while slot < self.program.events.len() {
            let event = &mut self.program.events[slot];
            if event.kind & PENDING != 0 {
                event.kind &= !PENDING;
                self.program.outer = self.program.effect;
                self.program.outer_pc = self.program.pc;
                self.program.forget();
                self.program.put_feed_aside(0);
                if self.vm.is_piece {
                    self.vm.flags |= flag::EVENT;
                    let place = if code == 0 { Called::Behind } else { Called::Within };
                    self.call_host(place, slot as u8, 0);
                    return;
                }
                if !self.vm.interrupt(slot as u8) {
                    self.raise(Fault::Stack, self.vm.pc, true);
                }
                return;
            }
            slot += 1;
        }
    }
}

impl Program {
    /// A millisecond of the ON lines: inputs that went on and off, input n in bit n - 1. Edges in a
    /// pause are remembered, the clocks of ON EVERY stand still.
    pub(super) fn listen(&mut self, executes: bool, rose: u32, fell: u32) {
        for event in &mut self.events {
            let edges = match event.kind & !PENDING {
                1 => rose,
                2 => fell,
                3 if executes => {
                    event.left -= 1;
                    if event.left > 0 {
                        continue;
                    }
                    event.left = event.period;
                    event.kind |= PENDING;
                    continue;
                }
                _ => continue,
            };
            if edges >> ((event.n - 1) & 31) & 1 != 0 {
                event.kind |= PENDING;
            }
        }
    }
}
