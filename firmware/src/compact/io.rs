//! Inputs, outputs and buttons at the pins.

use crate::consts::constants;
use crate::pins;

constants! {
    P1IN = 0x20;
    P1OUT = 0x21;
    P1IFG = 0x23;
    P1IES = 0x24;
    P1IE = 0x25;
    P1SEL = 0x26;
    P1REN = 0x27;
    P1SEL2 = 0x41;
    P2OUT = 0x29;
    P2DIR = 0x2A;
    P2SEL = 0x2E;
    UCB0CTL0 = 0x68;
    UCB0CTL1 = 0x69;
    UCB0BR0 = 0x6A;
    UCB0STAT = 0x6D;
    UCB0RXBUF = 0x6E;
    UCB0TXBUF = 0x6F;
    P1_SPI = pins::P1_REF_Y_OR_CLOCK | pins::P1_REF_Z_OR_MISO | pins::P1_PROBE_OR_MOSI;
    // UCB0CTL1: from SMCLK, not held in reset as it is after one. UCB0CTL0: data captured on the first edge, most
    // significant bit first, master, synchronous. UCB0STAT: busy (SLAU144, 16.4).
    UCB_RUN = 0b10 << 6;
    UCB_MASTER = 1 << 7 | 1 << 5 | 1 << 3 | 1;
    UCB_BUSY = 1;
}

core::arch::global_asm!(include_str!("io/io.s"), options(raw));
