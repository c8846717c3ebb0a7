//! USCI_A0: the UART of the link.

use super::reg::{self, bis, set};

/// Rate of its clock, SMCLK.
pub const CLOCK: u32 = 16_000_000;

/// For the handlers: status, received character, character to be sent.
pub const STAT: u16 = 0x0065;
/// See [`STAT`].
pub const RXBUF: u16 = 0x0066;
/// See [`STAT`].
pub const TXBUF: u16 = 0x0067;
/// Enables of its interrupts: bit 0 received, bit 1 sent.
pub const IE: u16 = 0x0001;

/// Starts it, listening: divider and modulation (SLAU144, table 15-4), and the parity's bits of CTL0.
pub fn open(divider: u16, modulation: u8, parity: u8) {
    let uart = reg::uart();
    set!(uart.uca0ctl1, 0b10 << 6 | 1);
    set!(uart.uca0ctl0, parity);
    set!(uart.uca0br0, divider as u8);
    set!(uart.uca0br1, (divider >> 8) as u8);
    set!(uart.uca0mctl, modulation);
    set!(uart.uca0ctl1, 0b10 << 6);
    bis!(reg::special().ie2, 1);
}

/// Lets the handler send what is in the ring.
#[inline(always)]
pub fn transmit() {
    bis!(reg::special().ie2, 2);
}

/// Whether a character is under way.
#[inline(always)]
pub fn is_busy() -> bool {
    reg::uart().uca0stat.read().bits() & 1 != 0
}
