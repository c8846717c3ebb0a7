//! TA1: the millisecond and the lines' silences. TA0: the step engine, whose channels 1 to 3 are the STEP pins.

use super::clock::RATE;
use super::reg::{
    TA0CCR0, TA0CCTL0, TA0CTL, TA0IV, TA0R, TA1CCR0, TA1CCR1, TA1CCR2, TA1CCTL0, TA1CCTL1,
    TA1CCTL2, TA1CTL, TA1R,
};

/// Timer ticks in a millisecond: SMCLK / 8.
pub const PER_MS: u16 = (RATE / 8000) as u16;
/// Ticks of the step engine in a microsecond.
pub const STEP_PER_US: u16 = RATE.div_ceil(1_000_000) as u16;
/// Channel of the step engine that is the STEP pin of the first axis.
pub const FIRST: usize = 1;

/// For the handlers: counter, compare registers and control of the channels of the millisecond and of
/// the silence.
pub const R: u16 = TA1R.0;
/// See [`R`].
pub const MS_CCR: u16 = TA1CCR0.0;
/// See [`R`].
pub const MS_CCTL: u16 = TA1CCTL0.0;
/// See [`R`].
pub const SILENCE_CCTL: u16 = TA1CCTL1.0;
/// See [`R`].
pub const SILENCE_CCR: u16 = TA1CCR1.0;

/// See [`R`]: of the RS-485 line.
pub const BUS_CCTL: u16 = TA1CCTL2.0;
/// See [`BUS_CCTL`].
pub const BUS_CCR: u16 = TA1CCR2.0;

/// Of the step engine: control, control of the first channel, counter, compare register of the first
/// channel, interrupt vector.
pub const STEP_CTL: u16 = TA0CTL.0;
/// See [`STEP_CTL`].
pub const STEP_CCTL: u16 = TA0CCTL0.0;
/// See [`STEP_CTL`].
pub const STEP_R: u16 = TA0R.0;
/// See [`STEP_CTL`].
pub const STEP_CCR: u16 = TA0CCR0.0;
/// See [`STEP_CTL`].
pub const STEP_IV: u16 = TA0IV.0;

/// SMCLK / 8, continuous; CCR0 is the millisecond, CCR1 the link's silence.
pub fn open() {
    TA1CCR0.set(PER_MS);
    TA1CCTL0.set(1 << 4);
    // A watchdog reset leaves it as it was.
    TA1CCTL1.set(0);
    TA1CCTL2.set(0);
    TA1CTL.set(0b10 << 8 | 0b11 << 6 | 0b10 << 4 | 1 << 2);
}

/// Time in ticks.
#[inline(always)]
pub fn now() -> u16 {
    TA1R.get()
}

/// When the next millisecond ends.
#[inline(always)]
pub fn due() -> u16 {
    TA1CCR0.get()
}

/// Puts that off.
#[inline(always)]
pub fn set_due(at: u16) {
    TA1CCR0.set(at);
}
