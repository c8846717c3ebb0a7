//! A halted run, and the messages between an editor's session and the run.

use lang::vm::entry;

use crate::sim::view::View;

/// An open call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// The line that is about to run, or that calls.
    pub line: u32,
    /// How its routine was entered ([`entry`]); `None` for the main program.
    pub kind: Option<u8>,
}

impl Frame {
    /// What the list of calls adds to the routine's name.
    pub const fn by(self) -> &'static str {
        match self.kind {
            Some(entry::GOSUB) => " (GOSUB)",
            Some(entry::EVENT) => " (event)",
            Some(entry::ERROR | entry::ERROR_BETWEEN) => " (error handler)",
            _ => "",
        }
    }
}

/// The frames of a run at line `here` with these open calls, the newest first: kind, and where it
/// goes back to.
pub fn frames(
    mut here: u32,
    open: impl IntoIterator<Item = (u8, usize)>,
    line: impl Fn(usize) -> u32,
) -> Vec<Frame> {
    let mut frames = Vec::new();
    for (kind, back) in open {
        frames.push(Frame { line: here, kind: Some(kind) });
        // What follows a call may be another line's.
        here = match kind {
            entry::EVENT | entry::ERROR | entry::ERROR_BETWEEN => line(back),
            _ => line(back.saturating_sub(1)),
        };
    }
    frames.push(Frame { line: here, kind: None });
    frames
}

/// All that a halted run shows.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Snapshot {
    /// Open calls, the innermost first; at least the main program.
    pub frames: Vec<Frame>,
    /// These are all of them.
    pub known: bool,
    /// Cells.
    pub cells: Vec<i32>,
    /// The machine.
    pub view: View,
}

impl Snapshot {
    /// A cell's value.
    pub fn cell(&self, n: usize) -> i32 {
        self.cells.get(n).copied().unwrap_or(0)
    }
}

/// A breakpoint.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Break {
    /// Line, from 1.
    pub line: u32,
    /// Halts where this is not 0.
    pub condition: Option<String>,
    /// Halts at this hit and at later ones.
    pub hits: Option<u64>,
    /// Says this instead of halting; `{expression}` is evaluated.
    pub log: Option<String>,
}

/// How to go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// To the next breakpoint.
    Go,
    /// To the next line, calls included.
    Over,
    /// To the next statement, also of a SUB.
    Into,
    /// To the end of the present SUB.
    Out,
    /// To the statement before.
    Back,
    /// Backwards to the breakpoint before.
    Reverse,
}

/// Where a run stands: open calls, line, address.
pub type Stand = (u8, u32, usize);

impl Pace {
    /// Whether a step that began at `from` is over at `here`.
    pub fn ends(self, from: Stand, here: Stand) -> bool {
        let ((depth, line, pc), (now, at, place)) = (from, here);
        let same = at == line && place > pc;
        match self {
            Pace::Over => now < depth || (now == depth && !same),
            Pace::Into => now != depth || !same,
            Pace::Out => now < depth,
            _ => false,
        }
    }
}

/// What a session says to what runs.
#[derive(Debug)]
pub enum Order {
    /// These breakpoints, and whether to halt at faults.
    Breaks(Vec<Break>, bool),
    /// Go on.
    Go(Pace),
    /// Halt.
    Pause,
    /// Set a cell.
    Set(usize, i32),
    /// Begin anew.
    Restart,
    /// End it.
    End,
    /// Leave it alone from now on.
    Leave,
}

/// What a run says to its session.
#[derive(Debug)]
pub enum Report {
    /// It halted.
    Halted {
        /// As the protocol names it: `step`, `breakpoint`, `pause`, `entry`, `exception`.
        reason: &'static str,
        /// More, where there is more to say.
        text: Option<String>,
        /// How things stand.
        at: Box<Snapshot>,
    },
    /// It is not halted any more, though nobody here let it go on: somebody else ends it.
    GoesOn,
    /// It said something: the protocol's category, and the text.
    Said(&'static str, String),
    /// It is over; exit code as of `pasapas sim`, and why.
    Over(u8, String),
}
