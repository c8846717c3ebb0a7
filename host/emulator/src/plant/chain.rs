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

use crate::rng::Rng;

/// From the clock's rising edge to data that the chip may sample, ns: a 74HC165's delay at 3.3 V (about
/// twice its 33 ns at 4.5 V) and the USCI's set-up time (SLAS735, tSU,MI at 3 V).
pub const DATA_NS: u64 = 60 + 75;

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
    /// When the data output changed last, in ticks.
    changed: u64,
}

impl Chain {
    /// Signals from the chip at the time `now`: clock, data and latch.
    pub fn signals(&mut self, now: u64, clk: bool, data: bool, latch: bool) {
        let before = self.data_out();
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
        if self.data_out() != before {
            self.changed = now;
        }
    }

    /// Whether what the chip samples at the time `now` is not there for certain yet.
    #[must_use]
    pub fn unsettled(&self, now: u64, ticks_per_second: u64) -> bool {
        now - self.changed.min(now) < (DATA_NS * ticks_per_second).div_ceil(1_000_000_000)
    }

    /// Level at the data output of the 165s.
    #[must_use]
    pub fn data_out(&self) -> bool {
        self.shift_in & 0x8000 != 0
    }

    /// The registers lost power: their content is arbitrary.
    pub fn power_up(&mut self, noise: &mut Rng) {
        let [latched, shift_out, shift_in, _] =
            [0, 16, 32, 48].map(|at| (noise.bits() >> at) as u16);
        *self = Chain { inputs: self.inputs, latched, shift_out, shift_in, ..Chain::default() };
    }
}
