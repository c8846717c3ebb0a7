//! What the MSP430F5529 takes for what the desktop computes in no time, in cycles of its 25 MHz clock.
//!
//! These are the only numbers by which the desktop's times are like the board's. They are cycles of instructions and of
//! operations of the flash controller, not times of statements.

/// A pass of the main loop in which nothing happens but what is looked at in every pass.
pub const PASS: u64 = 2_500;
/// What a millisecond's turn takes in addition: filters, counters, the registers of the chain.
pub const MILLISECOND: u64 = 3_000;
/// An instruction of the VM: dispatch and a typical operation (firmware/shared/vm_core.rs).
pub const INSTRUCTION: u64 = 26;
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
