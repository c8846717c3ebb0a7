//! The shift registers of the `chain` wiring.
//!
//! One place for the order of bits on the chain, most significant bit first in both directions:
//!
//! - Inputs, two 74HC165: input `n` is bit `n - 1` of a 16-bit word. The first byte that the chip
//!   reads holds inputs 1 to 8, the second 9 to 16; input 1 is bit 0 of the first byte.
//! - Outputs, one or two 74HC595: output `n` is bit `n - 1`. The first byte that the chip sends
//!   holds outputs 9 to 16, the second 1 to 8, so that with a single register the last byte counts.
//! - Both latch at one pin: while it is low the 165s load their inputs; when it rises they begin to
//!   shift and the 595s show what was shifted in. Both shift at the rising edge of the clock (SPI
//!   with UCCKPH = 1, UCCKPL = 0).

/// State of the registers.
#[derive(Debug, Clone, Default)]
pub struct Chain {
    /// Levels at the inputs of the 165s, bit `n - 1` for input `n`.
    pub inputs: u16,
    /// What the 165s will shift out; bit 15 is at the data output.
    shift_in: u16,
    /// What was shifted into the 595s.
    shift_out: u16,
    /// What the 595s show.
    pub latched: u16,
    clk: bool,
    latch: bool,
}

impl Chain {
    /// Signals from the chip: clock, data and latch.
    pub fn signals(&mut self, clk: bool, data: bool, latch: bool) {
        if latch && !self.latch {
            self.latched = self.shift_out;
        }
        self.latch = latch;
        if clk && !self.clk {
            self.shift_out = self.shift_out << 1 | u16::from(data);
            if latch {
                self.shift_in <<= 1;
            }
        }
        self.clk = clk;
        if !latch {
            // Inputs 1 to 8 stand in the register next to the chip.
            self.shift_in = self.inputs.swap_bytes();
        }
    }

    /// Level at the data output of the 165s.
    #[must_use]
    pub fn data_out(&self) -> bool {
        self.shift_in & 0x8000 != 0
    }

    /// The 595s lost power: their content is arbitrary, here zero.
    pub fn power_up(&mut self) {
        *self = Chain { inputs: self.inputs, ..Chain::default() };
    }
}
