use super::{Denied, Flash, NAME, SEGMENT, Store, Upload};
use lang::part::slot_head;

mod library;

const SLOT_HEAD: u16 = slot_head(1) as u16;
const SEGMENTS: u8 = 6;

/// Flash that can lose power in the middle of an operation: that one leaves some of its bits
/// undone, the later ones do nothing.
#[derive(Clone)]
pub(crate) struct Chip {
    pub words: Vec<u16>,
    pub operations: u32,
    pub cut_at: u32,
    pub noise: u16,
}

impl Chip {
    pub fn new() -> Chip {
        Chip::of(SEGMENTS)
    }

    fn of(segments: u8) -> Chip {
        let words = vec![0xFFFF; usize::from(segments) * usize::from(SEGMENT) / 2];
        Chip { words, operations: 0, cut_at: u32::MAX, noise: 0x5A3C }
    }

    fn partial(&mut self) -> u16 {
        self.noise = self.noise.rotate_left(3).wrapping_mul(0x9E37).wrapping_add(0x79B9);
        self.noise
    }
}

impl Flash for Chip {
    const SEGMENTS: u8 = SEGMENTS;

    fn read(&self, offset: u16) -> u16 {
        self.words[usize::from(offset) / 2]
    }
    fn write(&mut self, offset: u16, word: u16) {
        self.operations += 1;
        let mask = if self.operations == self.cut_at { self.partial() } else { 0 };
        if self.operations <= self.cut_at {
            self.words[usize::from(offset) / 2] &= word | mask;
        }
    }
    fn erase(&mut self, offset: u16) {
        self.operations += 1;
        let first = usize::from(offset / SEGMENT * SEGMENT) / 2;
        for at in first..first + usize::from(SEGMENT) / 2 {
            let mask = if self.operations == self.cut_at { self.partial() } else { 0xFFFF };
            if self.operations <= self.cut_at {
                self.words[at] |= mask;
            }
        }
    }
    /// A test image: length in words, then words that sum up to 0.
    fn image(&self, offset: u16) -> Option<u16> {
        let first = usize::from(offset) / 2;
        let length = usize::from(*self.words.get(first)?);
        let body = self.words.get(first..first.checked_add(length)?)?;
        (length > 1 && body.iter().fold(0u16, |sum, word| sum.wrapping_add(*word)) == 0)
            .then_some(2 * length as u16)
    }
    fn length(&self, offset: u16) -> u16 {
        2 * self.read(offset)
    }
}

fn image(words: u16, seed: u16) -> Vec<u16> {
    let mut image = vec![words];
    image.extend((2..words).map(|at| at.wrapping_mul(seed)));
    let sum = image.iter().fold(0u16, |sum, word| sum.wrapping_add(*word));
    image.push(sum.wrapping_neg());
    image
}

fn upload(store: &mut Store, chip: &mut Chip, image: &[u16], replace: bool) -> Result<(), Denied> {
    store.begin(chip, alone(2 * image.len() as u16), replace)?;
    for (at, &word) in image.iter().enumerate() {
        store.write(chip, 2 * at as u16, word)?;
    }
    store.commit(chip, &[0; NAME])
}

fn alone(length: u16) -> Upload {
    Upload { number: 1, length, keeps: false }
}

fn stored(store: &Store, chip: &Chip) -> Option<Vec<u16>> {
    let first = usize::from(store.image::<Chip>()?) / 2;
    Some(chip.words[first..first + usize::from(store.length(chip)) / 2].to_vec())
}

#[test]
fn a_program_survives_a_reset() {
    let (mut store, mut chip) = (Store::new(), Chip::new());
    let first = image(300, 7);
    upload(&mut store, &mut chip, &first, false).unwrap();
    store.mount(&mut chip);
    assert_eq!(stored(&store, &chip), Some(first));
}

#[test]
fn a_repeated_commit_is_answered_as_the_first_until_something_else_begins() {
    let (mut store, mut chip) = (Store::new(), Chip::new());
    let commit = |store: &mut Store, chip: &mut Chip| store.commit(chip, &[0; NAME]);
    assert_eq!(commit(&mut store, &mut chip), Err(Denied::NotBegun), "nothing was ever begun");
    upload(&mut store, &mut chip, &image(300, 7), false).unwrap();
    let operations = chip.operations;
    assert_eq!(commit(&mut store, &mut chip), Ok(()));
    assert_eq!(chip.operations, operations, "and flash stays as it is");
    assert!(store.begin(&mut chip, alone(0), false).is_err());
    assert_eq!(commit(&mut store, &mut chip), Err(Denied::NotBegun));
    upload(&mut store, &mut chip, &image(200, 9), false).unwrap();
    store.discard(&mut chip, 1);
    assert_eq!(commit(&mut store, &mut chip), Err(Denied::NotBegun), "it was given up");
    upload(&mut store, &mut chip, &image(200, 9), false).unwrap();
    store.mount(&mut chip);
    assert_eq!(commit(&mut store, &mut chip), Err(Denied::NotBegun), "the reset forgot it");
}

#[test]
fn what_does_not_fit_beside_the_old_program_is_refused() {
    let (mut store, mut chip) = (Store::new(), Chip::new());
    let large = image(Store::area::<Chip>() / 2, 3);
    upload(&mut store, &mut chip, &large, false).unwrap();
    assert_eq!(store.free(&chip), 0);
    assert_eq!(upload(&mut store, &mut chip, &image(10, 5), false), Err(Denied::TooLong));
    assert_eq!(stored(&store, &chip), Some(large));
    upload(&mut store, &mut chip, &image(10, 5), true).unwrap();
    assert_eq!(stored(&store, &chip), Some(image(10, 5)));
    assert_eq!(
        store.begin(&mut chip, alone(Store::area::<Chip>() + 2), true),
        Err(Denied::TooLong)
    );
}

#[test]
fn a_damaged_upload_leaves_the_old_program() {
    let (mut store, mut chip) = (Store::new(), Chip::new());
    upload(&mut store, &mut chip, &image(200, 9), false).unwrap();
    let mut damaged = image(200, 11);
    damaged[17] ^= 4;
    assert_eq!(upload(&mut store, &mut chip, &damaged, false), Err(Denied::Image));
    assert_eq!(stored(&store, &chip), Some(image(200, 9)));
    assert_eq!(store.write(&mut chip, 6, 0x1234), Err(Denied::Flash), "a word is written once");
}

#[test]
fn a_cut_at_every_operation_leaves_old_or_new() {
    let old = image(700, 13);
    let new = image(600, 17);
    let mut before = Chip::new();
    let mut store = Store::new();
    upload(&mut store, &mut before, &old, false).unwrap();
    before.operations = 0;
    let mut whole = before.clone();
    upload(&mut store.clone(), &mut whole, &new, false).unwrap();
    for cut_at in 1..=whole.operations {
        let mut chip = Chip { cut_at, noise: cut_at as u16, ..before.clone() };
        let _ = upload(&mut store.clone(), &mut chip, &new, false);
        chip.cut_at = u32::MAX;
        let mut after = Store::new();
        after.mount(&mut chip);
        let found = stored(&after, &chip);
        assert!(found == Some(old.clone()) || found == Some(new.clone()), "cut at {cut_at}");
        // And the board takes the next upload.
        upload(&mut after, &mut chip, &image(20, 3), false).unwrap();
        after.mount(&mut chip);
        assert_eq!(stored(&after, &chip), Some(image(20, 3)), "after a cut at {cut_at}");
    }
}

#[test]
fn a_cut_while_replacing_leaves_new_or_none() {
    let old = image(Store::area::<Chip>() / 2, 13);
    let new = image(1400, 17);
    let mut before = Chip::new();
    let mut store = Store::new();
    upload(&mut store, &mut before, &old, false).unwrap();
    before.operations = 0;
    let mut whole = before.clone();
    upload(&mut store.clone(), &mut whole, &new, true).unwrap();
    for cut_at in 1..=whole.operations {
        let mut chip = Chip { cut_at, noise: cut_at as u16, ..before.clone() };
        let _ = upload(&mut store.clone(), &mut chip, &new, true);
        chip.cut_at = u32::MAX;
        let mut after = Store::new();
        after.mount(&mut chip);
        let found = stored(&after, &chip);
        let erased_nothing_yet = cut_at == 1 && found == Some(old.clone());
        assert!(
            found.is_none() || found == Some(new.clone()) || erased_nothing_yet,
            "cut at {cut_at}"
        );
    }
    assert_eq!(SLOT_HEAD % 2, 0);
}

#[test]
fn a_commit_word_that_wavers_is_settled_at_the_first_reset() {
    const NOT_YET: u16 = 0xE7FF;
    for (first, later) in [(NOT_YET, 0xA501), (0xA501, NOT_YET)] {
        let (mut store, mut chip) = (Store::new(), Chip::new());
        let (old, new) = (image(200, 9), image(200, 11));
        upload(&mut store, &mut chip, &old, false).unwrap();
        upload(&mut store, &mut chip, &new, false).unwrap();
        // As if the second commit had been cut short: the older slot is there still.
        let slot = usize::from(store.image::<Chip>().unwrap() - SLOT_HEAD) / 2;
        chip.words[0] = 0xA500;
        chip.words[2..2 + old.len()].copy_from_slice(&old);
        chip.words[slot] = first;
        store.mount(&mut chip);
        let held = stored(&store, &chip);
        assert_eq!(held, Some(if first == NOT_YET { old } else { new }));
        // The word reads otherwise now, unless it was written again or erased.
        if chip.words[slot] != 0xFFFF && chip.words[slot + 1] != 0 {
            chip.words[slot] = later;
        }
        store.mount(&mut chip);
        assert_eq!(stored(&store, &chip), held);
    }
}
