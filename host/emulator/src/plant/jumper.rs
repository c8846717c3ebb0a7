//! Wires from one pin of the chip to another, whole or losing edges.

use super::pins::high;

/// A wire between two pins of the chip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Jumper {
    /// Pin that drives it.
    pub from: u8,
    /// Pin that it drives.
    pub to: u8,
    /// Of so many rising edges one does not come through, 0 for a wire in order.
    pub loses: u32,
    edges: u32,
    /// The level that it gives the pin that it drives.
    pub(super) level: bool,
}

impl Jumper {
    /// A wire in order, from one pin to the other.
    #[must_use]
    pub const fn new(from: u8, to: u8) -> Jumper {
        Jumper { from, to, loses: 0, edges: 0, level: false }
    }

    /// The same wire that loses one of so many rising edges.
    #[must_use]
    pub const fn losing(self, loses: u32) -> Jumper {
        Jumper { loses, ..self }
    }

    /// The chip's pins change their levels, which the wire takes from one to the other.
    pub(super) fn follow(&mut self, was: u64, is: u64) {
        let (is, was) = (high(is, self.from), high(was, self.from));
        if is && !was {
            self.edges += 1;
            self.level = self.loses == 0 || self.edges % self.loses != 0;
        } else if !is {
            self.level = false;
        }
    }
}
