//! A run that is followed effect by effect: breakpoints and steps.
//!
//! In trace mode the board waits with its next effect until the last one has been taken, so an owner
//! that takes none halts the program.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::{Duration, Instant};

use lang::profile::Profile;
use lang::wire::{self, Control, RunState};
use serde::Serialize;

use super::Board;
use crate::client::ClientError;
use crate::client::trace::Tracer;
use crate::sim::trace::What;

/// Line of an address in the stored program's code.
pub type LineOf = Arc<dyn Fn(u16) -> u32 + Send + Sync>;

/// Without an event for so long the board's state is asked for.
const QUIET: Duration = Duration::from_millis(250);

/// How a followed run goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// To the next breakpoint.
    Go,
    /// To the next effect.
    Step,
}

/// What a user asks of a followed run.
pub enum Debug {
    /// Start the stored program and follow it.
    Start {
        /// The machine.
        profile: Box<Profile>,
        /// From code to text.
        line_of: LineOf,
        /// Lines to halt behind.
        breaks: BTreeSet<u32>,
        /// How to begin.
        pace: Pace,
    },
    /// Go on.
    Pace(Pace),
    /// Other breakpoints from now on.
    Breaks(BTreeSet<u32>),
    /// Nothing halts it any more.
    Leave,
}

/// Where a run is halted.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Halt {
    /// The line whose effect is done.
    pub behind: u32,
    /// The line that comes next, where it is known.
    pub next: u32,
}

/// A followed run.
pub struct Follow {
    tracer: Tracer<'static>,
    line_of: LineOf,
    breaks: BTreeSet<u32>,
    pace: Pace,
    halt: Option<Halt>,
    /// When the last event came.
    heard: Instant,
    over: bool,
}

impl Follow {
    /// Starts the stored program in trace mode.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn start(
        board: &mut Board,
        profile: Profile,
        line_of: LineOf,
        breaks: BTreeSet<u32>,
        pace: Pace,
    ) -> Result<Follow, ClientError> {
        board.drop_print()?;
        board.write(wire::TRACE_MODE, 1)?;
        if let Err(error) = board.control(Control::Start) {
            let _ = board.write(wire::TRACE_MODE, 0);
            return Err(error);
        }
        let lines = line_of.clone();
        let tracer = Tracer::new(profile, Box::new(move |pc| lines(pc)));
        let heard = Instant::now();
        Ok(Follow { tracer, line_of, breaks, pace, halt: None, heard, over: false })
    }

    /// Where it is halted.
    pub fn halt(&self) -> Option<&Halt> {
        self.halt.as_ref()
    }

    /// Does what a user asks.
    pub fn ask(&mut self, debug: Debug) {
        match debug {
            Debug::Start { .. } => {}
            Debug::Pace(pace) => (self.pace, self.halt) = (pace, None),
            Debug::Breaks(breaks) => self.breaks = breaks,
            Debug::Leave => {
                self.breaks.clear();
                (self.pace, self.halt) = (Pace::Go, None);
            }
        }
        self.heard = Instant::now();
    }

    /// Looks for the next event. `None` within: the run is over and all is told.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn look(&mut self, board: &mut Board) -> Result<Option<Vec<What>>, ClientError> {
        if self.halt.is_some() {
            return Ok(Some(Vec::new()));
        }
        let Some(what) = self.tracer.poll(board)? else {
            if self.heard.elapsed() > QUIET {
                if self.over {
                    return Ok(None);
                }
                // The last event may have come since that look: it is asked for once more.
                let (state, _) = board.run_state()?;
                self.over =
                    matches!(state, Some(RunState::Empty | RunState::Ready | RunState::Fault));
                self.heard = Instant::now();
            }
            return Ok(Some(Vec::new()));
        };
        self.heard = Instant::now();
        self.over = matches!(what, What::End { .. });
        let behind = what.line();
        if !self.over && (self.pace == Pace::Step || self.breaks.contains(&behind)) {
            let next = (self.line_of)(board.status()?.program_counter);
            self.halt = Some(Halt { behind, next });
        }
        Ok(Some(vec![what]))
    }

    /// Nobody takes events any more: the program must not wait for that.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn end(board: &mut Board) -> Result<(), ClientError> {
        board.write(wire::TRACE_MODE, 0)
    }

    /// Whether the end was told.
    pub fn is_over(&self) -> bool {
        self.over
    }
}
