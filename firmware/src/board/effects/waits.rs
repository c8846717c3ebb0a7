//! Waits for inputs and characters, and how they end.

use crate::controller::Controller;
use crate::vm::vm;
use lang::fault::Fault;
use lang::isa::flags;
use lang::wire::TraceKind;

/// Wants of WaitIn: level off, level on, rise, fall.
const WANT_EDGE: u8 = 2;

impl Controller {
    pub(super) fn wait_in(&mut self) -> Result<bool, Fault> {
        if self.first() {
            let bits = vm().operand();
            self.effect.left = if bits & flags::TIMEOUT != 0 { vm().pop() } else { -1 };
            if bits & flags::TIMEOUT != 0 && self.effect.left < 0 {
                return Err(Fault::ValueRange);
            }
            let mut want = bits & 3;
            if bits & flags::LEVEL != 0 {
                want = u8::from(vm().pop() != 0);
            }
            let n = match bits & flags::INPUT_ON_STACK {
                0 => u16::from(bits >> flags::INPUT) + 1,
                _ => vm().pop_small(17),
            };
            if n == 0 || n > 17 {
                return Err(Fault::ValueRange);
            }
            self.effect.n = n as u8;
            self.effect.bits = bits & flags::WAIT_QUERY | want;
            // Bit 1 of the phase: the level before.
            self.effect.phase = 1 | u8::from(self.input(n as u8)) << 1;
        }
        let now = self.input(self.effect.n);
        let before = self.effect.phase & 2 != 0;
        let want = self.effect.bits & 3;
        let met = now == (want & 1 != 0) && (want & WANT_EDGE == 0 || now != before);
        self.effect.phase = 1 | u8::from(now) << 1;
        let level = i32::from(want & 1);
        self.outcome(TraceKind::WaitIn, met, level)
    }

    pub(super) fn wait_char(&mut self) -> Result<bool, Fault> {
        if self.first() {
            let bits = vm().operand();
            self.effect.left = if bits & flags::TIMEOUT != 0 { vm().pop() } else { -1 };
            self.effect.bits = bits & flags::WAIT_QUERY;
            self.effect.n = vm().pop_small(125) as u8;
            if !(33..=125).contains(&self.effect.n) {
                return Err(Fault::ValueRange);
            }
        }
        let met = self.char_in == self.effect.n;
        if met {
            self.char_in = 0;
        }
        self.outcome(TraceKind::WaitChar, met, i32::from(self.effect.n))
    }

    /// The end of a wait: met, timed out, or not yet.
    fn outcome(&mut self, kind: TraceKind, met: bool, value: i32) -> Result<bool, Fault> {
        if !met && self.effect.left != 0 {
            return Ok(false);
        }
        self.emit_outcome(kind, self.effect.n, met, value);
        if self.effect.bits & flags::WAIT_QUERY != 0 {
            self.timed_out = !met;
        } else if !met {
            return Err(Fault::TimedOut);
        }
        Ok(true)
    }
}
