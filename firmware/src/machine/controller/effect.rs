//! State of the effect under way.

use super::Controller;
use super::io::Io;
use super::program::Program;
use crate::machine::chip::Chip;
use lang::isa::{first, last};
use lang::wire::TraceKind;

/// A statement that acts on the machine, as far as it has come.
#[derive(Clone, Copy)]
pub struct Effect {
    /// Its code, 0 for none.
    pub code: u8,
    /// What it has come to.
    pub phase: u8,
    /// Input or output number, character, axis.
    pub n: u8,
    /// Flags of the instruction.
    pub bits: u8,
    /// Milliseconds to go; negative is for ever.
    pub left: i32,
}

impl Effect {
    /// None.
    pub const NONE: Effect = Effect { code: 0, phase: 0, n: 0, bits: 0, left: 0 };

    /// A millisecond less for what waits; others keep something else in `left`.
    pub(super) fn count_down(&mut self) {
        let waits = matches!(
            self.code,
            first::Home..=last::HomeQuery | first::Wait | first::WaitIn | first::WaitChar
        );
        if waits && self.left > 0 {
            self.left -= 1;
        }
    }
}

/// Code of Pulse.
pub(super) const PULSE: u8 = first::Pulse;
/// Phase of a Pulse that lasts; behind it the pulse is over and was told.
pub const PULSE_BEGUN: u8 = 1;

/// Code of the pseudo-effect that ends a run.
pub const END: u8 = 0xFF;

impl Program {
    /// A pulse ends in time even in a pause or while a handler runs.
    pub(super) fn pulse_tick(&mut self, io: &mut Io) {
        for effect in [&mut self.effect, &mut self.outer] {
            if effect.code == PULSE && effect.phase == PULSE_BEGUN && effect.left > 0 {
                effect.left -= 1;
                if effect.left == 0 {
                    let bit = 1 << ((effect.n - 1) & 15);
                    io.outputs &= !bit;
                    io.resume &= !bit;
                }
            }
        }
    }
}

impl<C: Chip> Controller<C> {
    /// A pulse that ended while a handler runs is told before the handler does anything more.
    pub(super) fn pulse_over(&mut self) {
        let pulse = &mut self.program.outer;
        if pulse.code != PULSE || pulse.phase != PULSE_BEGUN || pulse.left != 0 || self.trace.full {
            return;
        }
        pulse.phase += 1;
        let n = pulse.n;
        let pc = core::mem::replace(&mut self.program.pc, self.program.outer_pc);
        self.emit(TraceKind::Out, n, 0);
        self.program.pc = pc;
    }
}
