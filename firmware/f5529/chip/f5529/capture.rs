//! TA2, used by the self-test only: clock input P2.2, capture inputs P2.3 (TA2.0) and P2.4 (TA2.1).

use super::reg::{P2SEL, TA2CCR0, TA2CCR1, TA2CCTL0, TA2CCTL1, TA2CTL, TA2R};

/// The three pins in their port.
const PINS: u8 = 1 << 2 | 1 << 3 | 1 << 4;
/// Continuous, cleared.
const RUNS: u16 = 0b10 << 4 | 1 << 2;
/// SMCLK.
const SMCLK: u16 = 0b10 << 8;
/// Divided by eight.
const EIGHTH: u16 = 0b11 << 6;
/// Synchronous capture; which edges is in the upper two bits.
const CAPTURE: u16 = 1 << 11 | 1 << 8;

/// The pins are inputs as any others, the timer stands still.
pub fn close() {
    TA2CTL.set(0);
    TA2CCTL0.set(0);
    TA2CCTL1.set(0);
    P2SEL.clear(PINS);
}

/// Counts rising edges at P2.2 from 0.
pub fn count() {
    close();
    P2SEL.raise(1 << 2);
    TA2CTL.set(RUNS);
}

/// Captures edges, 1 rising, 2 falling, 3 both, at P2.3 and at P2.4, in cycles or, `slow`, in eights of them.
pub fn open(slow: bool, first: u16, second: u16) {
    close();
    // The pins first: a pin that is high as it comes to the timer is no edge.
    P2SEL.raise(1 << 3 | 1 << 4);
    TA2CTL.set(SMCLK | RUNS | if slow { EIGHTH } else { 0 });
    TA2CCTL0.set(first << 14 | CAPTURE);
    TA2CCTL1.set(second << 14 | CAPTURE);
}

/// When the last edge came at P2.3, and at P2.4.
#[inline(always)]
pub fn edges() -> (u16, u16) {
    (TA2CCR0.get(), TA2CCR1.get())
}

/// The counter.
#[inline(always)]
pub fn now() -> u16 {
    TA2R.get()
}

/// Hardware revision of the chip (SLAS590, "Device Descriptors").
pub fn revision() -> u8 {
    super::reg::Byte(0x1A06).get()
}
