//! Times that the MSP430F5529 needs for work that the desktop does in no simulated time, in cycles of its 25 MHz clock.
//!
//! Simulated times agree with the board's by these numbers alone. They are cycles of instructions and of
//! flash operations, not times of statements.

use lang::isa::{first, last};

/// A pass of the main loop in which nothing happens but what is looked at in every pass.
pub const PASS: u64 = 2_500;
/// What a millisecond's turn takes in addition: filters, counters, the registers of the chain.
pub const MILLISECOND: u64 = 3_000;
/// An instruction of the VM: dispatch and a typical operation (firmware/shared/vm_core.rs).
pub const INSTRUCTION: u64 = 26;
/// G0 or G1 until it is a block: its words and limits (`pasapas bench passes`: `line_rules_f5529`).
pub const LINE: u64 = 6_000;
/// G2 or G3: words, angles, extremes.
pub const ARC: u64 = 60_000;
/// The corner and the ramps of a block of a path.
pub const BLOCK: u64 = 4_000;
/// A path that begins or ends.
pub const PATH: u64 = 5_000;
/// A segment of a path: two roots, three divisions, and its place in the ring.
pub const SEGMENT: u64 = 9_000;
/// A segment of an axis of its own.
pub const AXIS_SEGMENT: u64 = 8_000;
/// A byte of an image whose check is run: CRC and code.
pub const CHECK: u64 = 1_400;
/// Writing a word of flash, 75 us.
pub const WRITE: u64 = 75 * 25;
/// Erasing a segment of flash, 27 ms.
pub const ERASE: u64 = 27_000 * 25;

/// What the effect takes with which the VM leaves, before its first segment.
pub fn of_effect(exit: u16) -> u64 {
    match u8::try_from(exit) {
        Ok(first::Linear..=last::Line) => LINE,
        Ok(first::Arc..=last::ArcBy) => ARC,
        _ => 0,
    }
}
