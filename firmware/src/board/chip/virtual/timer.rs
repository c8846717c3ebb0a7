//! Timer0_A: the millisecond and the line's silence. Timer1_A: the step engine.

use super::reg::{self, set};

/// Timer ticks in a millisecond: SMCLK / 8 = 2 MHz.
pub const PER_MS: u16 = 2000;
/// Ticks of the step engine in a microsecond.
pub const STEP_PER_US: u16 = 16;
/// Channel of the step engine that is the STEP pin of the first axis.
pub const FIRST: usize = 0;

/// Timer0_A, for the handlers: counter, compare registers and control of the channels of the millisecond and of
/// the silence.
pub const R: u16 = 0x0170;
/// See [`R`].
pub const MS_CCR: u16 = 0x0172;
/// See [`R`].
pub const SILENCE_CCTL: u16 = 0x0164;
/// See [`R`].
pub const SILENCE_CCR: u16 = 0x0174;

/// Timer1_A's registers (SLAS735, peripheral file map): control, control of the first channel, counter,
/// compare register of the first channel, interrupt vector. The PAC derives them from Timer0_A's and gets
/// all but TA1IV wrong.
pub const STEP_CTL: u16 = 0x0180;
/// See [`STEP_CTL`].
pub const STEP_CCTL: u16 = 0x0182;
/// See [`STEP_CTL`].
pub const STEP_R: u16 = 0x0190;
/// See [`STEP_CTL`].
pub const STEP_CCR: u16 = 0x0192;
/// See [`STEP_CTL`].
pub const STEP_IV: u16 = 0x011E;

/// Timer0_A: SMCLK / 8 = 2 MHz, continuous; CCR0 is the millisecond, CCR1 the link's silence.
pub fn open() {
    let timer = reg::timer0();
    set!(timer.taccr0, PER_MS);
    set!(timer.tacctl0, 1 << 4);
    // A watchdog reset leaves it as it was.
    set!(timer.tacctl1, 0);
    set!(timer.tactl, 0b10 << 8 | 0b11 << 6 | 0b10 << 4 | 1 << 2);
}

/// Time in ticks.
#[inline(always)]
pub fn now() -> u16 {
    reg::timer0().tar.read().bits()
}

/// When the next millisecond ends.
#[inline(always)]
pub fn due() -> u16 {
    reg::timer0().taccr0.read().bits()
}

/// Puts that off.
#[inline(always)]
pub fn set_due(at: u16) {
    set!(reg::timer0().taccr0, at);
}
