//! Where the chip's pins meet the plant, as one table for each board.
//!
//! Levels of all pins travel as one word of 64 bits: bit `8 * (port - 1) + n` is pin n of a port.

use super::Wiring;
use crate::part::Family;

/// Number of a pin: its bit in the words of levels.
#[must_use]
pub const fn pin(port: u8, n: u8) -> u8 {
    8 * (port - 1) + n
}

/// Whether pin `n` is set in `levels`.
#[inline]
#[must_use]
pub const fn high(levels: u64, n: u8) -> bool {
    levels >> n & 1 != 0
}

/// Pins of a board by what they do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pins {
    /// STEP, X to Z.
    pub step: [u8; 3],
    /// DIR, X to Z.
    pub dir: [u8; 3],
    /// Start button.
    pub start: u8,
    /// Stop button.
    pub stop: u8,
    /// The chip's receive pin of the line to the host.
    pub rx: u8,
    /// The chip's transmit pin of the line to the host.
    pub tx: u8,
    /// Inputs at pins, input n at place n - 1: four in the `direct` wiring.
    pub inputs: [u8; 4],
    /// The probe in the `chain` wiring.
    pub probe: u8,
    /// Clock of the shift registers.
    pub clk: u8,
    /// Data of the shift registers to the chip.
    pub somi: u8,
    /// Data of the shift registers from the chip.
    pub simo: u8,
    /// Latch of the shift registers; output 1 in the `direct` wiring.
    pub latch: u8,
    /// Output enable of the shift registers, low when on; output 2 in the `direct` wiring.
    pub enable: u8,
    /// PWM of a laser, a spindle or a servo, of boards that have one.
    pub pwm: Option<u8>,
    /// Analog output, a second PWM, of boards that have one.
    pub aout: Option<u8>,
    /// RS-485: data to the transceiver, and what lets it drive.
    pub rs485: Option<[u8; 2]>,
}

impl Pins {
    /// The G2 LaunchPad with the G2553.
    pub const G2553: Pins = Pins {
        step: [pin(2, 0), pin(2, 1), pin(2, 4)],
        dir: [pin(2, 3), pin(2, 6), pin(2, 7)],
        start: pin(1, 3),
        stop: pin(1, 0),
        rx: pin(1, 1),
        tx: pin(1, 2),
        inputs: [pin(1, 4), pin(1, 5), pin(1, 6), pin(1, 7)],
        probe: pin(1, 4),
        clk: pin(1, 5),
        somi: pin(1, 6),
        simo: pin(1, 7),
        latch: pin(2, 2),
        enable: pin(2, 5),
        pwm: None,
        aout: None,
        rs485: None,
    };

    /// The F5529 LaunchPad, with the host at its back channel.
    pub const F5529: Pins = Pins {
        step: [pin(1, 2), pin(1, 3), pin(1, 4)],
        dir: [pin(6, 0), pin(6, 1), pin(6, 2)],
        start: pin(2, 1),
        stop: pin(1, 1),
        rx: pin(4, 5),
        tx: pin(4, 4),
        inputs: [pin(2, 4), pin(2, 5), pin(2, 6), pin(2, 7)],
        probe: pin(2, 4),
        clk: pin(3, 2),
        somi: pin(3, 1),
        simo: pin(3, 0),
        latch: pin(1, 6),
        enable: pin(6, 3),
        pwm: Some(pin(3, 5)),
        aout: Some(pin(3, 6)),
        rs485: Some([pin(3, 3), pin(4, 0)]),
    };

    /// The board that parts of a family sit on.
    #[must_use]
    pub fn of(family: Family) -> Pins {
        match family {
            Family::Msp430 => Pins::G2553,
            Family::Msp430X => Pins::F5529,
        }
    }

    /// Pin of input `n` (from 1), if it is at a pin in this wiring.
    #[must_use]
    pub fn input(&self, wiring: Wiring, n: u8) -> Option<u8> {
        match wiring {
            Wiring::Direct => self.inputs.get(usize::from(n).checked_sub(1)?).copied(),
            Wiring::Chain => (n == 17).then_some(self.probe),
        }
    }
}
