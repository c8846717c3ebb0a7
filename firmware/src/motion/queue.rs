//! How far ahead of the playing segment a path is planned.
//!
//! The main loop plans nothing while it does anything else. On the F5529 the longest such stretch
//! is an arc that follows an arc: taking its words from the stack 3 ms, its corner 2 ms, its first
//! chord 3 ms, and up to three times that when the step interrupts take two thirds of the CPU. What
//! the engine holds must outlast it, or the axes stop dead between two steps. A pause, a stop and a
//! change of override take effect only after what it holds, so it holds no more than it needs.

use super::path::Path;
use super::ramp::Segment;

/// Segments that the engine holds, the playing one among them.
pub const SLOTS: usize = 16;

/// Time that the segments behind the playing one are to last while the block after the one that is
/// planned is known, ms.
const KNOWN_MS: u16 = 24;

/// The same while it is not: what is handed out ends at the start rate if the block does, so no
/// more than needed is.
const UNKNOWN_MS: u16 = 16;

/// So much is fetched at once, ms; beyond it the link is served and the program may bring the next block between two
/// segments. Below it the program waits, which takes longest: both lines ask for 100 registers each while a block is
/// planned, and the step interrupts take two thirds of the CPU. That took 11 ms at most (`firmware/tests/busy.rs`).
const LOW_MS: u16 = 16;

/// No more than so many are fetched at once: the watchdog and the link must be served, too. On a ramp a segment may be
/// shorter than 1.5 ms.
pub const FETCHES: u8 = 4;

/// A segment counts as no longer than this, some 42 ms at 25 MHz: the sum of all fits into 16 bits.
const LONGEST: u32 = u16::MAX as u32 / SLOTS as u32;

/// About how long a segment takes, 256 timer ticks; at least 1.
#[inline(always)]
pub fn time(segment: &Segment) -> u16 {
    let ticks = u32::from(segment.events) * (segment.interval >> 16);
    (ticks >> 8).min(LONGEST) as u16 | 1
}

/// Time that the segments behind the playing one are to last, 256 timer ticks.
#[inline(always)]
pub fn wanted(path: &Path, clock: u32) -> u16 {
    if path.knows_next() { units(KNOWN_MS, clock) } else { units(UNKNOWN_MS, clock) }
}

/// Time that is fetched at once, 256 timer ticks.
pub const fn low(clock: u32) -> u16 {
    units(LOW_MS, clock)
}

/// Milliseconds as units of 256 ticks of a timer of `clock` Hz.
const fn units(ms: u16, clock: u32) -> u16 {
    (ms as u32 * (clock / 1000) / 256) as u16
}
