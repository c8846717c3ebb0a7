//! Inputs and outputs at the pins: shift registers of the chain wiring, pins of the direct wiring,
//! buttons, probe.
//!
//! Bit order, as the emulator's plant has it: the first byte read holds inputs 1 to 8, the first
//! byte sent outputs 9 to 16. While the latch is low the 74HC165 load; its rise shows what the
//! 74HC595 were sent.

use crate::guard;
use crate::pins::{
    P1_PROBE_OR_MOSI, P1_REF_X_OR_PROBE, P1_REF_Y_OR_CLOCK, P1_REF_Z_OR_MISO, P1_START, P1_STOP,
    P2_OUT1_OR_LATCH, P2_OUT2_OR_ENABLE,
};
use crate::reg::{self, bic, bis, set};

/// Direct wiring: sets the outputs' levels and brings the inputs', on when closed to ground.
pub fn pins(outputs: u16) -> u16 {
    let ports = reg::ports();
    for (bit, pin) in [(1, P2_OUT1_OR_LATCH), (2, P2_OUT2_OR_ENABLE)] {
        if outputs & bit != 0 {
            bis!(ports.p2out, pin);
        } else {
            bic!(ports.p2out, pin);
        }
    }
    // Not before they have their levels.
    bis!(ports.p2dir, P2_OUT1_OR_LATCH | P2_OUT2_OR_ENABLE);
    u16::from(!ports.p1in.read().bits() >> 4)
}

/// Makes port 1 the SPI master of the chain: 4 MHz, as the 74HC165 take their time, data valid at the
/// rising edge.
pub fn open() {
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

fn byte(out: u8) -> u8 {
    let spi = reg::spi();
    set!(spi.ucb0txbuf, out);
    while spi.ucb0stat.read().bits() & 1 != 0 {}
    spi.ucb0rxbuf.read().bits()
}

fn latch() {
    let ports = reg::ports();
    bic!(ports.p2out, P2_OUT1_OR_LATCH);
    bis!(ports.p2out, P2_OUT1_OR_LATCH);
}

/// Sends the outputs' levels and brings the inputs' levels.
pub fn exchange(outputs: u16) -> u16 {
    guard::lend_chain(outputs);
    latch();
    let low = byte((outputs >> 8) as u8);
    let high = byte(outputs as u8);
    latch();
    bic!(reg::ports().p2out, P2_OUT2_OR_ENABLE);
    u16::from_le_bytes([low, high])
}

/// Level of the probe pin: on when closed to ground.
pub fn probe() -> bool {
    reg::ports().p1in.read().bits() & P1_REF_X_OR_PROBE == 0
}

/// Bit 0 Stop, bit 1 Start, on when closed to ground.
pub fn buttons() -> u16 {
    let pins = reg::ports().p1in.read().bits();
    u16::from(pins & P1_STOP == 0) | u16::from(pins & P1_START == 0) << 1
}
