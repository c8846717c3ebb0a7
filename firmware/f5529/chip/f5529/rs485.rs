//! USCI_A0: the UART of the RS-485 line, with the pin that lets its transceiver drive.

use super::ports;
use super::reg::{
    UCA0BR0, UCA0BR1, UCA0CTL0, UCA0CTL1, UCA0IE, UCA0MCTL, UCA0RXBUF, UCA0STAT, UCA0TXBUF,
};

/// For the handlers: status, received character, character to be sent.
pub const STAT: u16 = UCA0STAT.0;
/// See [`STAT`].
pub const RXBUF: u16 = UCA0RXBUF.0;
/// See [`STAT`].
pub const TXBUF: u16 = UCA0TXBUF.0;
/// Enables of its interrupts: bit 0 received, bit 1 sent.
pub const IE: u16 = UCA0IE.0;

/// As [`super::line::open`], with its pins.
pub fn open(divider: u16, modulation: u8, parity: u8) {
    ports::open_rs485();
    UCA0CTL1.set(0b10 << 6 | 1);
    UCA0CTL0.set(parity);
    UCA0BR0.set(divider as u8);
    UCA0BR1.set((divider >> 8) as u8);
    UCA0MCTL.set(modulation);
    UCA0CTL1.set(0b10 << 6);
    UCA0IE.set(1);
}

/// As [`super::line::transmit`]; the transceiver drives from now on.
#[inline(always)]
pub fn transmit() {
    ports::drive_rs485();
    UCA0IE.raise(2);
}

/// As [`super::line::is_busy`].
#[inline(always)]
pub fn is_busy() -> bool {
    UCA0STAT.get() & 1 != 0
}
