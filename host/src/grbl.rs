//! A Grbl 1.1h server: programs for a Grbl controller drive a board of this project.
//!
//! [`session`] is Grbl's protocol without any input or output: bytes of a client go in, answers and
//! [orders](order::Order) for the machine come out, and a [`View`](desk::View) has the state of the
//! machine. So it can be tested with thousands of generated sessions. A session resolves everything that
//! G-code keeps between lines (units, offsets, relative words, arcs), so the machine gets plain
//! machine coordinates, as a streamed job ([`crate::stream`]): there is no second planner here.
//!
//! Two threads do the rest. [`serve`] reads the client's port ([`port`]) and runs the session; [`drive`]
//! owns the board and feeds it. They share a [`Desk`](desk::Desk): status is answered from memory, and
//! a hold or a stop does not wait for anything.

mod arc;
mod block;
pub mod desk;
pub mod drive;
mod keep;
mod modal;
pub mod order;
mod plan;
pub mod port;
mod report;
pub mod serve;
pub mod session;
mod settings;
#[cfg(test)]
mod tests;
mod words;

pub use serve::{Server, Setting};

/// Number of an answer `error:N`, as Grbl 1.1 numbers them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Error(pub u8);

impl Error {
    /// A word does not begin with a letter.
    pub const LETTER: Error = Error(1);
    /// A number is missing or cannot be read.
    pub const NUMBER: Error = Error(2);
    /// A `$` line that is not known, or may not be changed here.
    pub const STATEMENT: Error = Error(3);
    /// A value is below 0.
    pub const NEGATIVE: Error = Error(4);
    /// Homing is not set up.
    pub const HOMING_OFF: Error = Error(5);
    /// The machine must be idle for it.
    pub const NOT_IDLE: Error = Error(8);
    /// Locked: an alarm, or a jog.
    pub const LOCKED: Error = Error(9);
    /// The line is too long.
    pub const OVERFLOW: Error = Error(11);
    /// A jog leads out of the travel.
    pub const TRAVEL: Error = Error(15);
    /// No jog command.
    pub const JOG: Error = Error(16);
    /// A word without meaning here.
    pub const UNSUPPORTED: Error = Error(20);
    /// Two words of one modal group.
    pub const GROUP: Error = Error(21);
    /// No feed rate.
    pub const NO_FEED: Error = Error(22);
    /// A whole number is wanted.
    pub const INTEGER: Error = Error(23);
    /// Two words want the axis words.
    pub const AXIS_CONFLICT: Error = Error(24);
    /// A word twice in a line.
    pub const REPEATED: Error = Error(25);
    /// No axis word.
    pub const NO_AXIS: Error = Error(26);
    /// A line number beyond the range.
    pub const LINE_NUMBER: Error = Error(27);
    /// P, L or another value is missing.
    pub const MISSING: Error = Error(28);
    /// Only G54 to G59.
    pub const NO_WCS: Error = Error(29);
    /// G53 goes with G0 and G1 only.
    pub const G53: Error = Error(30);
    /// Axis words that nothing uses.
    pub const AXIS_UNUSED: Error = Error(31);
    /// An arc without axis words in its plane.
    pub const ARC_AXES: Error = Error(32);
    /// A target that cannot be reached.
    pub const TARGET: Error = Error(33);
    /// An arc of a radius that does not fit.
    pub const ARC_RADIUS: Error = Error(34);
    /// An arc without offsets in its plane.
    pub const ARC_OFFSETS: Error = Error(35);
    /// Words that nothing uses.
    pub const UNUSED: Error = Error(36);
    /// G43.1 takes Z.
    pub const TOOL_AXIS: Error = Error(37);
    /// A tool number beyond the range.
    pub const TOOL: Error = Error(38);
}
