//! Motion: from targets in steps to the segments that the step engine plays.
//!
//! Everything here is integer arithmetic without hardware. The device runs it and the host's
//! simulator links it, so both get the same segments and therefore the same times: a move on the
//! emulated board takes what the simulator says to 0.01 %, and every edge falls on its tick.
//!
//! # Layers
//! - [`AxisRecord`](lang::record::AxisRecord): what an axis can do, from the program image.
//! - [`scaled`]: numbers with a 24-bit mantissa and an exponent, assembly on the chip.
//! - [`ramp`]: a run of equal events, as [`Segment`]s of 2 to 8 ms.
//! - [`path`]: interpolated moves (G0 to G3) with 81 blocks of look-ahead, as [`PathSegment`]s.
//! - [`arc`]: G2 and G3: centre, limits, chords.
//! - [`single`]: an axis on its own ramp (MoveAxe, MoveRel, START, MoveSpeed, homing, probing),
//!   retargeted on the fly.
//! - `physics` (feature `physics`): checks a record of steps against ramps, for tests.
//!
//! # Names
//! `v` is a speed, a name that ends in 2 the square of one (`exit2`, `start2`, `nominal2`), a name that ends in `_um`, `_us`,
//! `_ms` or `_s` has that unit. Path units are um, um/s and um/s2; an axis on its own counts in steps. `accel2` and
//! `decel2` are what v^2 grows and falls by over one event, `tick` is the interval in timer ticks at speed 1.
//!
//! # Speeds and ramps
//! With squared speeds a constant acceleration is a constant sum, so a segment of `n` events ends
//! at `v1^2 = min(v0^2 + 2 a n, nominal^2, exit^2 + 2 d left)`: ramp up, cruise and brake in one
//! formula, without a division for a step and without knowing the shape of the move in advance.
//! Its intervals then change linearly. Measured over windows of 20 steps on 20 000 generated
//! moves the acceleration stays within the ramp plus 5 % and one timer tick; ramps are planned
//! 1/32 lower for that. A line of two axes costs the MSP430F5529 21 000 cycles, its statement, its first
//! segment and the main loop's share of that time among them.
//!
//! # Paths
//! Path units are micrometres, so a feed holds whatever the steps per millimetre of the axes. The
//! corner speed follows from junction deviation (the path may round a corner by the profile's
//! tolerance), from what the arc that touches both blocks asks of the ramps, from what all blocks that are
//! known can brake over, and from both feeds: a circle of 5 mm in chords of 0.1 mm takes 2 % longer on the
//! `mill` profile than a planner that knows all of it would let it. Lines stay within half a step, arcs within
//! one step (0.71 for rounding two axes, 0.1 for the chord) and keep their feed within 2 %.
//!
//! # In the firmware
//! Of an axis on its own the step engine holds two segments, the playing one and the next; of a path
//! up to [`queue::SLOTS`], as many as last [`queue`]'s times: planning a block takes as long as
//! several short segments. The main loop asks for another whenever there is room:
//! ```text
//! path.push(&axes, &block)           // false: enough blocks wait already, offer it again later
//! path.push_arc(&axes, &arc, &manner)
//! while engine.ahead() < queue::wanted(&path) && path.next_segment(&axes, &mut segment) {
//!     engine.put_path(&segment)
//! }
//! path.is_idle() && !engine.is_running()  // the path has ended, all axes rest
//! path.pause(true) / pause(false)         // ramps down wherever it is / goes on with the rest
//! single.go(&axis, target, pace)          // also from a motion under way
//! if engine.axis_has_room(n) && single.next_segment(&mut segment) { engine.put_axis(...) }
//! if single.hit(&axis, caught) { engine.halt() }  // a probe or switch answered at step `caught`
//! ```
//!
//! # In a simulator
//! The same calls without an engine: [`Segment::duration`] is the exact time of a segment in
//! 1/65536 ticks of the step timer ([`lang::part::Part::clock`]), so a move's time is their sum, and
//! [`PathSegment::played`] or [`Segment::steps`] move the positions. A simulator may take a
//! segment as a whole or stop inside it at any event.

pub mod actions;
pub mod arc;
pub mod math;
pub mod path;
#[cfg(any(test, feature = "physics"))]
pub mod physics;
pub mod queue;
pub mod ramp;
pub mod scaled;
pub mod single;

pub use arc::{Arc, Ends};
pub use path::{Block, Feed, Manner, Path, PathSegment};
pub use ramp::Segment;
pub use single::{Pace, Single};

#[cfg(test)]
mod tests;
