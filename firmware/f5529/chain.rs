//! Inputs and outputs at the pins: shift registers of the chain wiring, pins of the direct wiring,
//! buttons, probe.
//!
//! Bit order, as the emulator's plant has it: the first byte read holds inputs 1 to 8, the first
//! byte sent outputs 9 to 16. While the latch is low the 74HC165 load; its rise shows what the
//! 74HC595 were sent.

use crate::chip::ports::{self, PROBE, chain_byte, latch};
pub use crate::chip::ports::{buttons, open_chain as open};
use crate::guard;

/// Direct wiring: sets the outputs' levels and brings the inputs', on when closed to ground.
pub fn pins(outputs: u16) -> u16 {
    ports::set_outputs(outputs);
    u16::from(!ports::inputs() >> 4)
}

/// Sends the outputs' levels and brings the inputs' levels.
pub fn exchange(outputs: u16) -> u16 {
    guard::lend_chain(outputs);
    latch();
    let low = chain_byte((outputs >> 8) as u8);
    let high = chain_byte(outputs as u8);
    latch();
    ports::enable_chain();
    u16::from_le_bytes([low, high])
}

/// Level of the probe pin: on when closed to ground.
pub fn probe() -> bool {
    ports::inputs() & PROBE == 0
}
