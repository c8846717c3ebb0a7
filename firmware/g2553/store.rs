//! Flash: the program store, the KEEP values, the profile, the last fault.

use crate::consts::constants;
use crate::vm::PART;
use firmware::store::SEGMENT;
use lang::image::at;
use lang::record::{BoardRecord, RECORD_VERSION};
use lang::wire::{Refusal, Upload};

/// Start of the program area.
const AREA: u16 = AREA_END - SEGMENT * PART.segments as u16;
/// Its end: the linker's TAIL, with the vectors, follows.
const AREA_END: u16 = 0xFE00;

constants! {
    // Where the check leaves the addresses of code and data in its scratch memory.
    CHECK_CODE = crate::check::CODE_START;
    CHECK_DATA = crate::check::CODE_END;
    AREA = AREA;
    AREA_END = AREA_END;
    AREA_BYTES = PART.room_for(false);
    SEGMENT = SEGMENT;
    SLOT_HEAD = lang::part::slot_head(PART.programs);
    // Where an image's header says how many KEEP values there are, and where.
    IMAGE_KEEPS = at::KEEPS;
    IMAGE_KEEP_BASE = at::KEEP_BASE;
    // The two segments of the KEEP values.
    KEEP_FIRST = AREA_END - 2 * SEGMENT;
    KEEP_SECOND = AREA_END - SEGMENT;
    // High byte of a commit word.
    SLOT_COMMITTED = 0xA500;
    // Information memory: D holds the faults' log, C and B the copies of the profile.
    LOG = 0x1000;
    PROFILE_FIRST = crate::vm::PART.profiles[0];
    PROFILE_SECOND = crate::vm::PART.profiles[1];
    RECORD_VERSION = RECORD_VERSION;
    FEATURES = PART.features;
    UPLOAD_REPLACE = Upload::Replace;
    UPLOAD_COMMIT = Upload::Commit;
    UPLOAD_ERASE = Upload::Erase;
    REFUSAL_NOT_BEGUN = Refusal::NotBegun;
    REFUSAL_TOO_LONG = Refusal::TooLong;
    REFUSAL_CRC = Refusal::Crc;
    REFUSAL_FLASH = Refusal::Flash;
}

/// What a board that was never given a profile assumes.
#[unsafe(no_mangle)]
#[unsafe(link_section = ".tail.board")]
#[used]
static BOARD_DEFAULT: [u16; BoardRecord::SIZE / 2] = {
    let default = BoardRecord::DEFAULT;
    // SAFETY: the record begins with so many words without a gap.
    unsafe { *(&raw const default).cast() }
};

// In this order, so that the link reaches what it asks for by near jumps.
core::arch::global_asm!(include_str!("store/flash.s"), options(raw));
core::arch::global_asm!(include_str!("store/store.s"), options(raw));
core::arch::global_asm!(include_str!("store/profile.s"), options(raw));
core::arch::global_asm!(include_str!("store/keep.s"), options(raw));
