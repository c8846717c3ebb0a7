//! An image in the chip's memory: its parts, its CRC, and what the check of its code relies on. That check is
//! assembly, `shared/check.rs`; tests compare it with [`model`].

#[cfg(any(test, feature = "physics"))]
pub mod model;

use lang::image::{HEADER, at};
use lang::isa::Op;
use lang::record::{MachineRecord, feature};
use lang::wire::{CRC_START, crc16};

/// Bytes of code that one anchor stands for, where an image has so many bytes at most. Small blocks make the check
/// faster, large ones its scratch memory smaller.
pub const fn block(longest: usize) -> usize {
    if longest > 1 << 12 { 256 } else { 64 }
}

/// Bytes of scratch memory: one anchor for each block of code.
pub const fn anchors(longest: usize) -> usize {
    longest.div_ceil(block(longest))
}

/// Offset of the code in an image.
pub const CODE: u16 = (HEADER + MachineRecord::SIZE) as u16;
/// Offset of the axes' part of the profile in an image.
pub const MACHINE: u16 = HEADER as u16;

/// The image feature that an instruction belongs to, 0 for those that every part has.
pub const fn feature_of(code: u8) -> u16 {
    const ARC: u8 = Op::Arc as u8;
    const ARC_MIXED: u8 = Op::ArcMixed as u8;
    const ARC_BY: u8 = Op::ArcBy as u8;
    const EVENT: u8 = Op::Event as u8;
    const MOVE_SPEED: u8 = Op::MoveSpeed as u8;
    const RUN: u8 = Op::Run as u8;
    const LEAVE: u8 = Op::Leave as u8;
    const RESUME_NEXT: u8 = Op::ResumeNext as u8;
    const MORE: u8 = Op::More as u8;
    const RESUME: u8 = Op::Resume as u8;
    const SIN: u8 = Op::Sin as u8;
    const MUL_DIV: u8 = Op::MulDiv as u8;
    const SYNC: u8 = Op::Sync as u8;
    const AOUT: u8 = Op::SetAout as u8;
    const COURSE: u8 = Op::Course as u8;
    match code {
        COURSE => feature::COURSE,
        LEAVE..=RESUME_NEXT => feature::LINES,
        MORE => feature::EVENTS,
        RESUME => feature::RETRY,
        SIN..=MUL_DIV => feature::MATHS,
        SYNC => feature::ACTIONS,
        AOUT => feature::AOUT,
        ARC | ARC_MIXED | ARC_BY => feature::ARC,
        EVENT => feature::EVENTS,
        MOVE_SPEED => feature::START,
        RUN => feature::LIBRARY,
        _ => 0,
    }
}

/// Memory that holds an image.
pub trait Bytes {
    /// The byte at an offset from the image's start.
    fn byte(&self, offset: u16) -> u8;
    /// One byte more into a CRC.
    fn crc(crc: u16, byte: u8) -> u16 {
        crc16(crc, byte)
    }
    /// The number at an offset, least byte first.
    fn word(&self, offset: u16) -> u16 {
        u16::from_le_bytes([self.byte(offset), self.byte(offset + 1)])
    }
}

/// Length of the image, if its CRC is right.
pub fn sound<B: Bytes>(image: &B, limit: u16) -> Option<u16> {
    let length = image.word(at::LEN as u16);
    if length < CODE || length > limit {
        return None;
    }
    let crc = (0..length).fold(CRC_START, |crc, at| B::crc(crc, image.byte(at)));
    (crc == 0).then_some(length)
}
