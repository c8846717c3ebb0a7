//! Wires to pins of the chip, from others or from outputs of the chain, and what the world drives there.

use super::{Drives, Plant, Wiring};

/// A wire to a pin of the chip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Jumper {
    /// Pin that drives it.
    pub from: u8,
    /// Output of the chain that drives it in place of a pin, from 1; 0 for none.
    pub output: u8,
    /// Pin that it drives.
    pub to: u8,
    /// Of so many rising edges one does not come through, 0 for a wire in order.
    pub loses: u32,
    pub(super) edges: u32,
    pub(super) level: bool,
}

impl Jumper {
    /// A wire in order, from one pin to the other.
    #[must_use]
    pub const fn new(from: u8, to: u8) -> Jumper {
        Jumper { from, output: 0, to, loses: 0, edges: 0, level: false }
    }

    /// A wire in order from the 74HC595's output `n`.
    #[must_use]
    pub const fn of_output(n: u8, to: u8) -> Jumper {
        Jumper { output: n, ..Jumper::new(to, to) }
    }

    /// The same wire that loses one of so many rising edges.
    #[must_use]
    pub const fn losing(self, loses: u32) -> Jumper {
        Jumper { loses, ..self }
    }
}

impl Plant {
    /// Wires pins to each other, in place of those wired so far.
    pub fn wire(&mut self, jumpers: &[Jumper]) {
        self.jumpers = jumpers.to_vec();
    }

    /// What the world does to the pins; `rx` is the level of the serial line.
    #[must_use]
    pub fn drives(&self, rx: bool) -> Drives {
        let mut d = Drives::default();
        let board = &self.board;
        let on = self.on();
        let mut contact = |pin: u8, closed: bool| {
            if closed {
                d.driven |= 1 << pin;
            } else {
                d.open |= 1 << pin;
                d.rest |= 1 << pin;
            }
        };
        contact(board.stop, self.stop || self.around.buttons()[1]);
        contact(board.start, self.start || self.around.buttons()[0]);
        let closed = |n: u8| (on ^ !self.active_low) >> (n - 1) & 1 != 0;
        match self.wiring {
            Wiring::Direct => {
                (1..).zip(board.inputs).for_each(|(n, pin)| contact(pin, closed(n)));
            }
            Wiring::Chain => contact(board.probe, closed(17)),
        }
        if self.unplugged {
            d.open |= 1 << board.rx;
        } else {
            d.driven |= 1 << board.rx;
            d.level |= u64::from(rx) << board.rx;
        }
        d.rest |= 1 << board.tx | self.pulled_up;
        if self.wiring == Wiring::Chain {
            d.driven |= 1 << board.somi;
            d.level |= u64::from(self.chain.data_out()) << board.somi;
            d.rest |= 1 << board.latch | 1 << board.enable;
        }
        for wire in &self.jumpers {
            let level = if wire.output == 0 { wire.level } else { self.output(wire.output) };
            d.driven |= 1 << wire.to;
            d.level = d.level & !(1 << wire.to) | u64::from(level) << wire.to;
        }
        d
    }
}
