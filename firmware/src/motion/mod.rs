//! Motion: from targets in steps to the segments that the step engine plays.
//!
//! Everything here is integer arithmetic without hardware. The device runs it and the host's
//! simulator links it, so both get the same segments and therefore the same times.
//!
//! # Layers
//! - [`AxisRecord`](lang::record::AxisRecord): what an axis can do, from the program image.
//! - [`ramp`]: one stretch of equal events, as [`Segment`]s of 4 to 8 ms.
//! - [`arc`]: G2 and G3 as chords.
//! - [`path`]: interpolated moves (G0 to G3) with look-ahead, as [`PathSegment`]s.
//! - [`single`]: an axis on its own ramp (MoveAxe, MoveRel, START, MoveSpeed), retargeted on the fly.
//!
//! - `physics` (feature `physics`): checks a record of steps against ramps, for tests.
//!
//! # In the firmware
//! The step engine holds two segments, the playing one and the next. The main loop asks for
//! another whenever there is room, at least every 4 ms while something moves:
//! ```text
//! path.push(&axes, &block)            // false: two blocks are under way, offer it again later
//! if engine.has_room() { if let Some(s) = path.next_segment(&axes) { engine.put(s) } }
//! path.is_idle() && engine.is_idle()  // the path has ended, all axes rest
//! path.pause(true) / pause(false)     // ramps down wherever it is / goes on with the rest
//! ```
//!
//! # In a simulator
//! The same calls without an engine: [`Segment::duration`] is the exact time of a segment in
//! 1/65536 timer ticks ([`TICKS_PER_SECOND`]), so a move's time is their sum, and
//! [`PathSegment::played`] or [`Segment::steps`] move the positions. A simulator may take a
//! segment as a whole or stop inside it at any event.

pub mod arc;
pub mod math;
pub mod path;
#[cfg(any(test, feature = "physics"))]
pub mod physics;
pub mod ramp;
pub mod scaled;
pub mod single;

pub use arc::{Arc, Ends};
pub use path::{Block, Feed, Path, PathSegment};
pub use ramp::Segment;
pub use single::{Pace, Single};

/// Rate of the step timer: SMCLK without divider.
pub const TICKS_PER_SECOND: u32 = 16_000_000;

#[cfg(test)]
mod tests;
