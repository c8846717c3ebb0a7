//! USCI_A1: the UART of the link, the LaunchPad's back channel.

use super::clock::{RATE, RATE_OF_REFO};
use super::reg::{
    UCA1BR0, UCA1BR1, UCA1CTL0, UCA1CTL1, UCA1IE, UCA1MCTL, UCA1RXBUF, UCA1STAT, UCA1TXBUF,
};

/// Rates of its clock, SMCLK: from the crystal and from REFO.
pub const CLOCKS: [u32; 2] = [RATE, RATE_OF_REFO];

/// For the handlers: status, received character, character to be sent.
pub const STAT: u16 = UCA1STAT.0;
/// See [`STAT`].
pub const RXBUF: u16 = UCA1RXBUF.0;
/// See [`STAT`].
pub const TXBUF: u16 = UCA1TXBUF.0;
/// Enables of its interrupts: bit 0 received, bit 1 sent.
pub const IE: u16 = UCA1IE.0;

/// Starts it, listening: divider and modulation (SLAU208, 36.3.10), and the parity's bits of CTL0.
pub fn open(divider: u16, modulation: u8, parity: u8) {
    UCA1CTL1.set(0b10 << 6 | 1);
    UCA1CTL0.set(parity);
    UCA1BR0.set(divider as u8);
    UCA1BR1.set((divider >> 8) as u8);
    UCA1MCTL.set(modulation);
    UCA1CTL1.set(0b10 << 6);
    UCA1IE.set(1);
}

/// Lets the handler send what is in the ring.
#[inline(always)]
pub fn transmit() {
    UCA1IE.raise(2);
}

/// Whether a character is under way.
#[inline(always)]
pub fn is_busy() -> bool {
    UCA1STAT.get() & 1 != 0
}
