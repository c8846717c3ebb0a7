//! Wear: KEEP writes to a flash that counts, some of them cut.

use firmware::keep::{self, Kept};
use firmware::store::{Flash, SEGMENT};
use lang::part;

use super::super::{Row, Settings, Verdict};

/// Segments of the program area of the fake flash.
const SEGMENTS: usize = part::F5529.segments as usize;

/// A flash memory that counts.
#[derive(Clone)]
pub struct Counted {
    words: Vec<u16>,
    erases: [u64; SEGMENTS],
    /// Operations until power fails; that one leaves some of its bits undone.
    left: u64,
    noise: u16,
}

impl Counted {
    fn new() -> Counted {
        let words = SEGMENTS * usize::from(SEGMENT) / 2;
        let erases = [0; SEGMENTS];
        Counted { words: vec![0xFFFF; words], erases, left: u64::MAX, noise: 0 }
    }
}

impl Counted {
    /// The word that a record ends with is lost, as by a flash that does not hold what was written.
    pub fn forget(&mut self) {
        if let Some(last) = self.words.iter_mut().rev().find(|word| **word != 0xFFFF) {
            *last = 0xFFFF;
        }
    }

    /// One segment is erased more often than the other.
    pub fn wear_out(&mut self) {
        self.erases[SEGMENTS - 1] += 1;
    }
}

impl Flash for Counted {
    const SEGMENTS: u8 = SEGMENTS as u8;

    fn read(&self, offset: u16) -> u16 {
        self.words[usize::from(offset) / 2]
    }
    fn write(&mut self, offset: u16, word: u16) {
        let undone = if self.left == 1 { self.noise } else { 0 };
        if self.left > 0 {
            self.words[usize::from(offset) / 2] &= word | undone;
        }
        self.left = self.left.saturating_sub(1);
    }
    fn erase(&mut self, offset: u16) {
        let segment = usize::from(offset / SEGMENT);
        let done = if self.left == 1 { self.noise } else { 0xFFFF };
        if self.left > 0 {
            let words = usize::from(SEGMENT) / 2;
            self.words[segment * words..][..words].iter_mut().for_each(|word| *word |= done);
            self.erases[segment] += 1;
        }
        self.left = self.left.saturating_sub(1);
    }
    fn image(&self, _offset: u16) -> Option<u16> {
        None
    }
    fn length(&self, _offset: u16) -> u16 {
        0
    }
}

/// KEEP writes, one in eight of them cut if `cuts`: each value is the old or the new one, and where
/// nothing is cut the two segments are erased alike. `spoil` may do to the flash what KEEP must not.
pub fn wear(settings: &Settings, cuts: bool, spoil: &dyn Fn(&mut Counted)) -> Row {
    let fault = if cuts { "KEEP writes, one in 8 cut" } else { "wear by KEEP writes" };
    let mut row = Row::new("power", fault, settings);
    let mut rng = settings.rng(fault, 0);
    let mut flash = Counted::new();
    let kept = Kept { count: 8, mark: 1 };
    let mut values = [0; 8];
    for n in 0..settings.count(20_000, 100_000, 1_000_000) {
        let (index, value) = (rng.below(8) as usize, rng.bits() as i32);
        let cut = cuts && rng.below(8) == 0;
        flash.left = if cut { 1 + rng.below(40) } else { u64::MAX };
        flash.noise = rng.bits() as u16;
        let mut wanted = values;
        wanted[index] = value;
        keep::save(&mut flash, kept.mark, &wanted);
        spoil(&mut flash);
        flash.left = u64::MAX;
        let found: [i32; 8] = std::array::from_fn(|of| keep::read(&flash, kept, of as u16));
        let held = found == wanted || cut && found == values;
        values = found;
        row.count(
            n,
            match held {
                true => Verdict::Survived,
                false => Verdict::Lost(format!("{found:X?}, not {wanted:X?}")),
            },
        );
    }
    let [.., a, b] = flash.erases;
    let others: u64 = flash.erases[..SEGMENTS - 2].iter().sum();
    if others > 0 || !cuts && a.abs_diff(b) > 1 {
        row.count(u64::MAX, Verdict::Lost(format!("erases by segment {:?}", flash.erases)));
    }
    row.note = format!("{a} and {b} erases of the two segments");
    row
}
