//! KEEP values: a ring of records in the last two flash segments.
//!
//! A record holds all values that a program keeps: first a word with a mark of the program's KEEP declarations
//! ([`MachineRecord::keeps`](lang::record::MachineRecord::keeps)) and, in the low byte, the record's number; then the values;
//! then the CRC of the bytes before. Records follow one another to the end of the area and then begin anew. The newest
//! record with a right CRC counts; a record with another mark is another program's. The segment that a new record crosses
//! into is erased first; the newest record never lies in it. Each word is written once between two erases. A single
//! value that changes once a second takes 128 records for both segments, so their 10^4 erases last
//! two weeks of steady change, and two years if it changes once a minute (firmware/README.md).

use crate::store::{Flash, SEGMENT};
use lang::wire::{CRC_START, crc16};

/// Start of the two segments.
const fn first<F: Flash>() -> u16 {
    second::<F>() - SEGMENT
}

const fn second<F: Flash>() -> u16 {
    end::<F>() - SEGMENT
}

const fn end<F: Flash>() -> u16 {
    F::SEGMENTS as u16 * SEGMENT
}

/// KEEP values of a program.
pub const KEEPS: u16 = 8;

/// What a program keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kept {
    /// Values, up to [`KEEPS`].
    pub count: u16,
    /// [`MachineRecord::keeps`](lang::record::MachineRecord::keeps)
    pub mark: u8,
}

/// Bytes of a record of so many values.
const fn record(keeps: u16) -> u16 {
    4 * keeps + 4
}

/// CRC of `bytes` bytes from `offset` on, 0 when their last word is the CRC of the others.
fn check<F: Flash>(flash: &F, offset: u16, bytes: u16) -> u16 {
    let mut crc = CRC_START;
    let mut at = 0;
    while at < bytes {
        let word = flash.read(offset + at);
        crc = crc16(crc, word as u8);
        crc = crc16(crc, (word >> 8) as u8);
        at += 2;
    }
    crc
}

/// The newest record of these values, if there is one, and where the first of the ring lies.
fn newest<F: Flash>(flash: &F, kept: Kept) -> (Option<u16>, u16) {
    let size = record(kept.count);
    let mut found: Option<u16> = None;
    // From the last one down, so that most need no CRC, which takes 130 cycles a byte.
    let mut at = end::<F>();
    while at >= first::<F>() + size {
        at -= size;
        let head = flash.read(at);
        let later = found.is_none_or(|old| {
            // The numbers of the ring differ by 127 at most: the signed difference says which is later.
            (head as u8).wrapping_sub(flash.read(old) as u8) as i8 > 0
        });
        if head >> 8 == u16::from(kept.mark) && later && check(flash, at, size) == 0 {
            found = Some(at);
        }
    }
    (found, at)
}

fn value<F: Flash>(flash: &F, record: u16, index: u16) -> i32 {
    let at = record + 2 + 4 * index;
    (u32::from(flash.read(at + 2)) << 16 | u32::from(flash.read(at))) as i32
}

/// Value `index` of a program that keeps these, 0 for one that was never written.
pub fn read<F: Flash>(flash: &F, kept: Kept, index: u16) -> i32 {
    match newest(flash, kept).0 {
        Some(record) if index < kept.count => value(flash, record, index),
        _ => 0,
    }
}

/// Writes the values of a program if they are not what flash holds; the values of another program go.
/// What flash does not hold then, the next call writes to another place.
pub fn save<F: Flash>(flash: &mut F, mark: u8, values: &[i32]) {
    let kept = Kept { count: values.len() as u16, mark };
    if !held(flash, kept, values) {
        put(flash, kept, values);
    }
}

fn held<F: Flash>(flash: &F, kept: Kept, values: &[i32]) -> bool {
    let Some(record) = newest(flash, kept).0 else { return false };
    (0..).zip(values).all(|(index, &wanted)| value(flash, record, index) == wanted)
}

/// Writes a record behind the newest one.
fn put<F: Flash>(flash: &mut F, kept: Kept, values: &[i32]) {
    let size = record(kept.count);
    let (newest, start) = newest(flash, kept);
    let mut number = 0u8;
    let mut at = end::<F>() - size;
    match newest {
        Some(old) => {
            number = flash.read(old) as u8;
            at = old;
        }
        None => flash.erase(second::<F>()),
    }
    // A place where a cut has left something is passed over, with its number.
    loop {
        at += size;
        number = number.wrapping_add(1);
        if at == end::<F>() {
            at = start;
            flash.erase(first::<F>());
            break;
        }
        let behind = at + size;
        if at < second::<F>() && behind >= second::<F>() {
            flash.erase(second::<F>());
        }
        if flash.read(at) == 0xFFFF {
            break;
        }
    }
    flash.write(at, u16::from(kept.mark) << 8 | u16::from(number));
    for (&value, at) in values.iter().zip((at + 2..).step_by(4)) {
        flash.write(at, value as u16);
        flash.write(at + 2, (value >> 16) as u16);
    }
    let crc = check(flash, at, size - 2);
    flash.write(at + size - 2, crc);
}

#[cfg(test)]
mod tests {
    use super::{Kept, read, save};
    use crate::store::tests::Chip;

    const MARK: u8 = 0xA5;

    fn marked(chip: &Chip, count: u16, mark: u8) -> Vec<i32> {
        (0..count).map(|index| read(chip, Kept { count, mark }, index)).collect()
    }

    fn values(chip: &Chip, keeps: u16) -> Vec<i32> {
        marked(chip, keeps, MARK)
    }

    #[test]
    fn values_survive_many_rounds() {
        for keeps in 1..=8 {
            let mut chip = Chip::new();
            for round in 1..500 {
                let mut new = vec![-round * 70_000; keeps];
                new[0] = round;
                save(&mut chip, MARK, &new);
                assert_eq!(values(&chip, keeps as u16), new);
            }
            let before = chip.operations;
            let same = values(&chip, keeps as u16);
            save(&mut chip, MARK, &same);
            assert_eq!(chip.operations, before, "unchanged values are not written");
            // As many under other names, or one less or more.
            for others in [keeps as u16, 9 - keeps as u16] {
                assert_eq!(marked(&chip, others, MARK + 1), vec![0; usize::from(others)]);
            }
            save(&mut chip, MARK + 1, &vec![0; keeps]);
            assert_eq!(values(&chip, keeps as u16), vec![0; keeps], "another program's are gone");
        }
    }

    #[test]
    fn a_cut_at_every_operation_keeps_the_old_values_or_the_new() {
        for keeps in [1, 3, 8] {
            for filled in 1..200 {
                let mut before = Chip::new();
                let mut new = vec![0; keeps];
                for round in 1..=filled {
                    new[0] = round;
                    save(&mut before, MARK, &new);
                }
                before.operations = 0;
                let old = new.clone();
                new[keeps - 1] = 0x1234_5678;
                let mut whole = before.clone();
                save(&mut whole, MARK, &new);
                for cut_at in 1..=whole.operations {
                    let mut chip = Chip { cut_at, noise: cut_at as u16, ..before.clone() };
                    save(&mut chip, MARK, &new);
                    chip.cut_at = u32::MAX;
                    let found = values(&chip, keeps as u16);
                    assert!(found == old || found == new, "cut at {cut_at}: {found:x?}");
                    let next = vec![7; keeps];
                    save(&mut chip, MARK, &next);
                    assert_eq!(values(&chip, keeps as u16), next, "after a cut at {cut_at}");
                }
            }
        }
    }
}
