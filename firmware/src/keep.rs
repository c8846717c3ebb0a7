//! KEEP values: a journal in two flash segments, one of them current.
//!
//! A segment begins with a commit word that carries a sequence number and a word that says whose
//! values these are; records of four words follow: index, value, CRC. The newest record of an
//! index counts. When a segment is full, the newest values go to the other one, whose commit word
//! is written last. Each word is written once between two erases, so at one change a second a
//! segment lasts a minute and 10^4 erases of both last two weeks of steady change; what changes
//! once a minute lasts two years.

use crate::store::{Flash, SEGMENT};
use lang::wire::{CRC_START, crc16};

/// The journal's two segments are the last ones.
const fn first<F: Flash>() -> u16 {
    (F::SEGMENTS as u16 - 2) * SEGMENT
}

const fn second<F: Flash>() -> u16 {
    first::<F>() + SEGMENT
}

const HEAD: u16 = 8;
const RECORD: u16 = 8;
const COMMITTED: u16 = 0x5A00;
const ERASED: u16 = 0xFFFF;
/// KEEP values of a program.
pub const KEEPS: u16 = 8;

/// The journal: offset of its current segment, 0 for none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Keep {
    current: u16,
}

fn check(words: [u16; 3]) -> u16 {
    let mut crc = CRC_START;
    for word in words {
        crc = crc16(crc, word as u8);
        crc = crc16(crc, (word >> 8) as u8);
    }
    crc
}

impl Keep {
    /// Finds the journal after a reset.
    pub fn mount<F: Flash>(&mut self, flash: &F) {
        let (a, b) = (flash.read(first::<F>()), flash.read(second::<F>()));
        let valid = |word: u16| word & 0xFF00 == COMMITTED;
        self.current = match (valid(a), valid(b)) {
            (true, true) if (b as u8).wrapping_sub(a as u8) as i8 > 0 => second::<F>(),
            (true, _) => first::<F>(),
            (false, true) => second::<F>(),
            (false, false) => 0,
        };
    }

    /// Whether the journal holds values of this owner; otherwise it begins anew, all 0.
    pub fn claim<F: Flash>(&mut self, flash: &mut F, owner: u16) {
        self.mount(flash);
        if self.current == 0 || flash.read(self.current + 2) != owner {
            self.turn(flash, owner, |_| 0);
        }
    }

    fn record<F: Flash>(&self, flash: &F, at: u16) -> Option<(u16, i32)> {
        let words = [flash.read(at), flash.read(at + 2), flash.read(at + 4)];
        if flash.read(at + 6) != check(words) {
            return None;
        }
        let value = u32::from(words[2]) << 16 | u32::from(words[1]);
        Some((words[0], value as i32))
    }

    /// The value of an index, 0 for one that was never written.
    pub fn read<F: Flash>(&self, flash: &F, index: u16) -> i32 {
        if self.current == 0 {
            return 0;
        }
        let mut at = self.current + SEGMENT;
        while at > self.current + HEAD {
            at -= RECORD;
            // The CRC takes 1000 cycles, so only of records that may be the one.
            if flash.read(at) == index
                && let Some((_, value)) = self.record(flash, at)
            {
                return value;
            }
        }
        0
    }

    /// Writes a value if it differs from what the journal holds.
    pub fn write<F: Flash>(&mut self, flash: &mut F, index: u16, value: i32) {
        if self.current == 0 || self.read(flash, index) == value {
            return;
        }
        let mut at = self.current + SEGMENT;
        // Free are the records behind the last one of which any word was written.
        while at > self.current + HEAD {
            let mut word = at - RECORD;
            while word < at && flash.read(word) == ERASED {
                word += 2;
            }
            if word < at {
                break;
            }
            at -= RECORD;
        }
        if at < self.current + SEGMENT {
            self.put(flash, at, index, value);
            if self.record(flash, at) == Some((index, value)) {
                return;
            }
        }
        let owner = flash.read(self.current + 2);
        let old = *self;
        let values: [i32; KEEPS as usize] = core::array::from_fn(|of| {
            if of as u16 == index { value } else { old.read(flash, of as u16) }
        });
        self.turn(flash, owner, |of| values.get(usize::from(of)).copied().unwrap_or(0));
    }

    fn put<F: Flash>(&self, flash: &mut F, at: u16, index: u16, value: i32) {
        let words = [index, value as u16, (value >> 16) as u16];
        flash.write(at + 2, words[1]);
        flash.write(at + 4, words[2]);
        flash.write(at, words[0]);
        flash.write(at + 6, check(words));
    }

    /// Begins the other segment with the values of `of`.
    fn turn<F: Flash>(&mut self, flash: &mut F, owner: u16, of: impl Fn(u16) -> i32) {
        let next = if self.current == first::<F>() { second::<F>() } else { first::<F>() };
        let sequence =
            if self.current == 0 { 0 } else { (flash.read(self.current) as u8).wrapping_add(1) };
        flash.erase(next);
        let mut at = next + HEAD;
        let mut index = 0;
        while index < KEEPS {
            let value = of(index);
            if value != 0 {
                self.put(flash, at, index, value);
                at += RECORD;
            }
            index += 1;
        }
        flash.write(next + 2, owner);
        flash.write(next, COMMITTED | u16::from(sequence));
        self.current = next;
    }
}

#[cfg(test)]
mod tests {
    use super::Keep;
    use crate::store::tests::Chip;

    fn values(chip: &Chip) -> [i32; 8] {
        let mut keep = Keep::default();
        keep.mount(chip);
        core::array::from_fn(|index| keep.read(chip, index as u16))
    }

    #[test]
    fn values_survive_many_turns() {
        let mut chip = Chip::new();
        let mut keep = Keep::default();
        keep.claim(&mut chip, 3);
        for round in 1..500 {
            keep.write(&mut chip, 2, round);
            keep.write(&mut chip, 5, -round * 70_000);
        }
        assert_eq!(values(&chip), [0, 0, 499, 0, 0, -499 * 70_000, 0, 0]);
        let before = chip.operations;
        keep.write(&mut chip, 2, 499);
        assert_eq!(chip.operations, before, "an unchanged value is not written");
        keep.claim(&mut chip, 3);
        assert_eq!(values(&chip)[2], 499);
        keep.claim(&mut chip, 4);
        assert_eq!(values(&chip), [0; 8], "another program begins at 0");
    }

    #[test]
    fn a_cut_at_every_operation_keeps_the_old_value_or_the_new() {
        for filled in [3, 61, 62, 63] {
            let mut before = Chip::new();
            let mut keep = Keep::default();
            keep.claim(&mut before, 1);
            for round in 1..=filled {
                keep.write(&mut before, 1, round);
            }
            before.operations = 0;
            let mut whole = before.clone();
            keep.clone().write(&mut whole, 0, 0x1234_5678);
            for cut_at in 1..=whole.operations {
                let mut chip = Chip { cut_at, noise: cut_at as u16, ..before.clone() };
                keep.clone().write(&mut chip, 0, 0x1234_5678);
                chip.cut_at = u32::MAX;
                let found = values(&chip);
                assert_eq!(found[1], filled, "cut at {cut_at} after {filled}");
                assert!(found[0] == 0 || found[0] == 0x1234_5678, "cut at {cut_at}: {found:x?}");
                let mut again = Keep::default();
                again.claim(&mut chip, 1);
                again.write(&mut chip, 7, 7);
                assert_eq!(values(&chip)[7], 7, "after a cut at {cut_at}");
            }
        }
    }
}
