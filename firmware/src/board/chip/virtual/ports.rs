//! Pins of buttons, inputs, outputs, directions and shift registers.

use super::pins::{
    P1_PROBE_OR_MOSI, P1_REF_X_OR_PROBE, P1_REF_Y_OR_CLOCK, P1_REF_Z_OR_MISO, P1_START, P1_STOP,
    P2_DIR, P2_OUT1_OR_LATCH, P2_OUT2_OR_ENABLE, P2_STEP,
};
use super::reg::{self, bic, bis, set};

/// The probe of the chain wiring among the [`inputs`].
pub const PROBE: u8 = P1_REF_X_OR_PROBE;
/// DIR of each axis, in the port of directions.
pub const DIR: [u8; 3] = P2_DIR;
/// The latch of the shift registers, in its port.
pub const LATCH: u8 = P2_OUT1_OR_LATCH;

/// For the handlers: levels of the inputs, flags of their edges, which edges, which of them answer.
pub const IN: u16 = 0x0020;
/// See [`IN`].
pub const IFG: u16 = 0x0023;
/// See [`IN`].
pub const IES: u16 = 0x0024;
/// See [`IN`].
pub const IE: u16 = 0x0025;
/// The port of directions, and that of the latch.
pub const DIR_OUT: u16 = 0x0029;
/// See [`DIR_OUT`].
pub const LATCH_OUT: u16 = 0x0029;
/// The chain's SPI: status, received and sent byte.
pub const SPI_STAT: u16 = 0x006D;
/// See [`SPI_STAT`].
pub const SPI_RXBUF: u16 = 0x006E;
/// See [`SPI_STAT`].
pub const SPI_TXBUF: u16 = 0x006F;

/// Levels of the port of inputs: bits 4 to 7 are inputs 1 to 4 of the direct wiring, low when closed.
#[inline(always)]
pub fn inputs() -> u8 {
    reg::ports().p1in.read().bits()
}

/// Bit 0 Stop, bit 1 Start, on when closed to ground.
pub fn buttons() -> u16 {
    let pins = inputs();
    u16::from(pins & P1_STOP == 0) | u16::from(pins & P1_START == 0) << 1
}

/// Direct wiring: levels of the two outputs.
#[inline(always)]
pub fn set_outputs(levels: u16) {
    let ports = reg::ports();
    for (bit, pin) in [(1, P2_OUT1_OR_LATCH), (2, P2_OUT2_OR_ENABLE)] {
        if levels & bit != 0 {
            bis!(ports.p2out, pin);
        } else {
            bic!(ports.p2out, pin);
        }
    }
    // Not before they have their levels.
    bis!(ports.p2dir, P2_OUT1_OR_LATCH | P2_OUT2_OR_ENABLE);
}

/// Makes port 1 the SPI master of the chain: 4 MHz, as the 74HC165 take their time, data valid at the
/// rising edge.
pub fn open_chain() {
    let ports = reg::ports();
    let spi = reg::spi();
    set!(spi.ucb0ctl1, 0b10 << 6 | 1);
    set!(spi.ucb0ctl0, 1 << 7 | 1 << 5 | 1 << 3 | 1);
    set!(spi.ucb0br0, 4);
    set!(spi.ucb0br1, 0);
    set!(spi.ucb0ctl1, 0b10 << 6);
    let pins = P1_REF_Y_OR_CLOCK | P1_REF_Z_OR_MISO | P1_PROBE_OR_MOSI;
    bis!(ports.p1sel, pins);
    bis!(ports.p1sel2, pins);
    // The outputs' enable stays high until the registers hold what the chip sends.
    bis!(ports.p2out, P2_OUT1_OR_LATCH | P2_OUT2_OR_ENABLE);
    set!(ports.p2dir, 0xFF);
}

/// Sends a byte to the chain and brings the one that comes.
#[inline(always)]
pub fn chain_byte(out: u8) -> u8 {
    let spi = reg::spi();
    set!(spi.ucb0txbuf, out);
    while spi.ucb0stat.read().bits() & 1 != 0 {}
    spi.ucb0rxbuf.read().bits()
}

/// Takes the chain's inputs and shows its outputs.
#[inline(always)]
pub fn latch() {
    let ports = reg::ports();
    bic!(ports.p2out, P2_OUT1_OR_LATCH);
    bis!(ports.p2out, P2_OUT1_OR_LATCH);
}

/// The chain's outputs drive from now on.
#[inline(always)]
pub fn enable_chain() {
    bic!(reg::ports().p2out, P2_OUT2_OR_ENABLE);
}

/// Which edge of an input answers: `falling` those that go low.
pub fn set_edges(falling: u8) {
    let ports = reg::ports();
    set!(ports.p1ies, falling);
    // Another edge than before may be taken for one that has come.
    set!(ports.p1ifg, 0);
}

/// Inputs whose edges answer.
#[inline(always)]
pub fn watch_edges(pins: u8) {
    set!(reg::ports().p1ie, pins);
}

/// Gives the timer the STEP pins.
#[inline(always)]
pub fn give_steps() {
    bis!(reg::ports().p2sel, P2_STEP);
}

/// Levels of the DIR pins.
#[inline(always)]
pub fn set_dirs(levels: u8) {
    let all = DIR[0] | DIR[1] | DIR[2];
    bic!(reg::ports().p2out, all);
    bis!(reg::ports().p2out, levels);
}
