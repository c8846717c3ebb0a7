//! State that survives a reset: the profile, the last faults, the selected program, and that a program ran.

use crate::machine::chip::Chip;
use crate::machine::flash::Image;
use crate::verify::Bytes;
use lang::fault::Fault;
use lang::record::{BoardRecord, MoreRecord, RECORD_VERSION};
use lang::wire::CRC_START;

/// The profile at an address of the information memory, if it is whole with what belongs to it.
pub fn profile<C: Chip>(chip: &C, address: u16) -> Option<C::Profile> {
    let bytes = Image(chip.clone(), address);
    let mut crc = CRC_START;
    let mut at = 0;
    while at < BoardRecord::SIZE as u16 {
        crc = C::crc(crc, bytes.byte(at));
        at += 1;
    }
    if crc != 0 || bytes.word(2) != RECORD_VERSION {
        return None;
    }
    let record = chip.profile_at(address);
    if record.more_crc != 0 {
        crc = CRC_START;
        while at < (BoardRecord::SIZE + MoreRecord::SIZE) as u16 {
            crc = C::crc(crc, bytes.byte(at));
            at += 1;
        }
        if crc != 0 || record.more.crc != record.more_crc {
            return None;
        }
    }
    Some(record)
}

/// The profile in use: the later of two whole copies, else that of a board never given one.
pub fn newest_profile<C: Chip>(chip: &C) -> C::Profile {
    match (profile(chip, C::PART.profiles[0]), profile(chip, C::PART.profiles[1])) {
        (Some(a), Some(b)) => {
            if b.sequence.wrapping_sub(a.sequence) as i16 > 0 {
                b
            } else {
                a
            }
        }
        (Some(one), None) | (None, Some(one)) => one,
        _ => chip.default_profile(),
    }
}

/// What is known of the last reset and since.
pub struct Reset {
    /// IFG1 then.
    pub cause: u8,
    /// Half a second has passed since.
    pub booted: bool,
    /// The chip is to be reset once the reply is out.
    pub wanted: bool,
}

/// The fault that a reset in the middle of a run is: F17 by the watchdog, F14 by the RST pin.
pub fn interrupted<C: Chip>(chip: &C, cause: u8) -> Option<Fault> {
    let runs = chip.is_marked();
    chip.mark(false);
    if !runs || cause & 1 << 2 != 0 {
        return None;
    }
    Some(if cause & 1 != 0 { Fault::Watchdog } else { Fault::EmergencyStop })
}

/// End of the faults in their segment ([`Chip::LOG`]), and of what follows. After them stand the numbers of the programs that were selected.
const FAULTS_END: u16 = 64;
const SELECTED_END: u16 = 128;
/// Marks a number of a program.
const SELECTION: u16 = 0x5000;

/// Appends a fault to the log, records of three words and their exclusive or: number and input, place in the
/// code, line.
pub fn log<C: Chip>(chip: &C, words: [u16; 3]) {
    let mut at = C::LOG;
    while at < C::LOG + FAULTS_END && chip.word(at) != 0xFFFF {
        at += 8;
    }
    if at == C::LOG + FAULTS_END {
        let number = selected(chip);
        chip.erase(C::LOG);
        at = C::LOG;
        if number != 0 {
            select(chip, number);
        }
    }
    write_fault(chip, at, words);
}

fn write_fault<C: Chip>(chip: &C, mut at: u16, words: [u16; 3]) {
    for word in words {
        chip.write(at, word);
        at += 2;
    }
    chip.write(at, words[0] ^ words[1] ^ words[2]);
}

/// The last fault, if one was ever logged.
pub fn logged<C: Chip>(chip: &C) -> Option<[u16; 3]> {
    let mut found = None;
    let mut at = C::LOG;
    while at < C::LOG + FAULTS_END {
        let words = [chip.word(at), chip.word(at + 2), chip.word(at + 4)];
        if words[0] != 0xFFFF && chip.word(at + 6) == words[0] ^ words[1] ^ words[2] {
            found = Some(words);
        }
        at += 8;
    }
    found
}

/// Where the next number of a selected program goes, and the newest one with its place; 0 before the first.
fn selections<C: Chip>(chip: &C) -> (u16, u8, u16) {
    let (mut at, mut newest, mut place) = (C::LOG + FAULTS_END, 0, 0);
    while at < C::LOG + SELECTED_END && chip.word(at) != 0xFFFF {
        let word = chip.word(at);
        if word == selection(word as u8) {
            newest = word as u8;
            place = at;
        }
        at += 4;
    }
    (at, newest, place)
}

/// A number as its word: with the number of its zeros, so that one of which some bits were not written is none.
const fn selection(number: u8) -> u16 {
    SELECTION | (number.count_zeros() as u16) << 8 | number as u16
}

/// Number of the program that was selected last, 0 for none. A cut in the moment when their segment is full leaves none:
/// then nothing starts before one is selected again.
pub fn selected<C: Chip>(chip: &C) -> u8 {
    selections(chip).1
}

/// As at a reset: a word that was cut short and reads well now does so from now on, which the word behind it tells.
pub fn settle_selected<C: Chip>(chip: &C) -> u8 {
    let (_, number, at) = selections(chip);
    if number != 0 && chip.word(at + 2) != 0 {
        chip.write(at, selection(number));
        chip.write(at + 2, 0);
    }
    number
}

/// Remembers it over any reset.
pub fn select<C: Chip>(chip: &C, number: u8) {
    let (mut at, ..) = selections(chip);
    if at == C::LOG + SELECTED_END {
        let last = logged(chip);
        chip.erase(C::LOG);
        at = C::LOG + FAULTS_END;
        if let Some(words) = last {
            write_fault(chip, C::LOG, words);
        }
    }
    chip.write(at, selection(number));
}
