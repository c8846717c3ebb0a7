//! Statements that wait, and what they leave.

use lang::effect::Want;

/// What a statement waits for.
#[derive(Clone, Copy, Debug)]
pub enum Until {
    /// The run clock.
    Clock,
    /// An input.
    Input {
        /// Its number.
        n: i32,
        /// What it must do.
        want: Want,
        /// State when last looked at, for edges.
        before: bool,
    },
    /// Start was pressed so many times before.
    Start(u64),
    /// A character.
    Char(i32),
    /// Axes of their own.
    Axes([bool; 3]),
    /// Simulated time, whatever is paused.
    Pulse(u64),
}

/// A statement that waits.
#[derive(Clone, Copy, Debug)]
pub struct Wait {
    /// Its line.
    pub line: u32,
    /// What ends it.
    pub until: Until,
    /// us of the run clock.
    pub deadline: Option<u64>,
    /// The end of its time is no fault.
    pub query: bool,
}

/// Waits under way, and what they leave.
#[derive(Debug, Default)]
pub struct Waits {
    /// The innermost last: those before it are interrupted by handlers.
    pub open: Vec<Wait>,
    /// TIMEDOUT: the last wait with a query ended by its time.
    pub timed_out: bool,
    /// The character that came last, 0 when it has been taken.
    pub char_in: i32,
    /// Lines whose wait for Start an unattended world ended.
    pub released: Vec<u32>,
}

impl Waits {
    /// A GOTO left every handler: what they interrupted is dropped.
    pub fn drop_all(&mut self) {
        self.open.clear();
    }
}
