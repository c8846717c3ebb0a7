//! A run that is followed effect by effect: breakpoints and steps.
//!
//! In trace mode the board waits with its next effect until the last one has been taken, so an owner
//! that takes none halts the program. A part whose [halts](lang::part::Part::halts) are exact completes the
//! effect under way, and reports which one is next and who called for it; on another part
//! only the effect after it is known.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::{Duration, Instant};

use lang::profile::Profile;
use lang::wire::{self, Control, RunState};
use serde::Serialize;

use super::Board;
use crate::client::ClientError;
use crate::client::standing::Standing;
use crate::client::trace::Tracer;
use crate::sim::trace::What;

/// Line of an address in the stored program's code.
pub type LineOf = Arc<dyn Fn(u16) -> u32 + Send + Sync>;

/// Without an event for so long the board's state is asked for, and told that its reader is there.
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
        /// Lines to halt at: before their effects, where the board does not tell behind them.
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
    /// The line whose effect is done, 0 before the first one.
    pub behind: u32,
    /// The line that comes next, where it is known.
    pub next: u32,
    /// It is known, and its effect has not begun.
    pub exact: bool,
    /// Where exactly, and who called for it; `None` where the board does not tell.
    #[serde(skip)]
    pub standing: Option<Standing>,
}

/// How far a followed run has come.
enum Stage {
    /// It has not begun: the number of runs before it.
    Before(u16),
    /// Events come.
    Runs,
    /// An effect of this line was told; the next one is awaited, to halt before it.
    Arrives(u32),
    /// It stands.
    Halted(Halt),
}

/// A followed run.
pub struct Follow {
    tracer: Tracer<'static>,
    line_of: LineOf,
    breaks: BTreeSet<u32>,
    pace: Pace,
    stage: Stage,
    exact: bool,
    /// Where it would have halted last: line, place, open calls.
    last: Option<(u32, u16, usize)>,
    /// When the last event came, or the board's state was asked for.
    heard: Instant,
    /// It ends, and nothing moves any more.
    ending: bool,
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
        let exact = board.identity()?.part().halts;
        board.drop_print()?;
        board.write(wire::TRACE_MODE, 1)?;
        if let Err(error) = board.control(Control::Start) {
            let _ = board.write(wire::TRACE_MODE, 0);
            return Err(error);
        }
        let lines = line_of.clone();
        let tracer = Tracer::new(profile, Box::new(move |pc| lines(pc)));
        let mut follow = Follow::new(tracer, line_of, breaks, pace, Stage::Runs, exact);
        if exact && follow.may_halt() {
            follow.stage = Stage::Arrives(0);
        }
        Ok(follow)
    }

    /// Follows the run that goes on, or the one that begins next. It halts before the next effect, on
    /// a board whose halts are not exact behind it.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn join(
        board: &mut Board,
        profile: Profile,
        line_of: LineOf,
    ) -> Result<Follow, ClientError> {
        let exact = board.identity()?.part().halts;
        // One of the slots has the number of the newest event of this run, the other one shows 0.
        let mut last = board.holding(wire::TRACE_EVEN, 1)?[0];
        last |= board.holding(wire::TRACE_ODD, 1)?[0];
        board.write(wire::TRACE_MODE, 1)?;
        let (state, runs) = board.run_state()?;
        let lines = line_of.clone();
        let line_at = Box::new(move |pc| lines(pc));
        let (tracer, stage) = if is_active(state) {
            (Tracer::behind(profile, line_at, last), Stage::Runs)
        } else {
            (Tracer::new(profile, line_at), Stage::Before(runs))
        };
        Ok(Follow::new(tracer, line_of, BTreeSet::new(), Pace::Step, stage, exact))
    }

    fn new(
        tracer: Tracer<'static>,
        line_of: LineOf,
        breaks: BTreeSet<u32>,
        pace: Pace,
        stage: Stage,
        exact: bool,
    ) -> Follow {
        let heard = Instant::now();
        let (last, ending, over) = (None, false, false);
        Follow { tracer, line_of, breaks, pace, stage, exact, last, heard, ending, over }
    }

    fn may_halt(&self) -> bool {
        self.pace == Pace::Step || !self.breaks.is_empty()
    }

    /// The program waits there, behind the effect of a line: whether it halts.
    fn arrive(&mut self, behind: u32, standing: Standing) -> Stage {
        let next = (self.line_of)(standing.place);
        let here = (next, standing.place, standing.calls.len());
        // A line's second effect is no new arrival.
        let begins = self.last.replace(here).is_none_or(|(line, place, calls)| {
            line != next || calls != here.2 || standing.place <= place
        });
        if self.pace == Pace::Go && !(begins && self.breaks.contains(&next)) {
            return Stage::Runs;
        }
        Stage::Halted(Halt { behind, next, exact: true, standing: Some(standing) })
    }

    /// Where it is halted.
    pub fn halt(&self) -> Option<&Halt> {
        match &self.stage {
            Stage::Halted(halt) => Some(halt),
            _ => None,
        }
    }

    /// Whether it waits for a run to begin.
    pub fn is_before(&self) -> bool {
        matches!(self.stage, Stage::Before(_))
    }

    /// Whether the board tells where exactly it halts, and the open calls.
    pub fn is_exact(&self) -> bool {
        self.exact
    }

    /// Does what a user asks.
    pub fn ask(&mut self, debug: Debug) {
        match debug {
            Debug::Start { .. } => {}
            Debug::Pace(pace) => self.pace = pace,
            Debug::Breaks(breaks) => {
                self.breaks = breaks;
                return;
            }
            Debug::Leave => {
                self.breaks.clear();
                self.pace = Pace::Go;
            }
        }
        if !self.is_before() {
            self.stage = Stage::Runs;
        }
        self.heard = Instant::now();
    }

    /// Looks for the next event. `None` within: the run is over and all is told.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn look(&mut self, board: &mut Board) -> Result<Option<Vec<What>>, ClientError> {
        let quiet = self.heard.elapsed() > QUIET;
        if quiet {
            self.heard = Instant::now();
        }
        match self.stage {
            Stage::Before(runs) => {
                if quiet {
                    self.tracer.hold(board)?;
                }
                let (state, now) = board.run_state()?;
                if now != runs && is_active(state) {
                    self.stage = if self.exact { Stage::Arrives(0) } else { Stage::Runs };
                }
            }
            Stage::Runs => return self.event(board, quiet),
            Stage::Arrives(behind) => {
                let standing = board.standing()?;
                if standing.waits {
                    self.stage = self.arrive(behind, standing);
                } else if quiet {
                    self.keep(board)?;
                }
            }
            Stage::Halted(_) if quiet => self.keep(board)?,
            Stage::Halted(_) => {}
        }
        Ok(Some(Vec::new()))
    }

    /// Nothing is taken meanwhile: the board is told that its reader is there. A run that somebody
    /// ends tells so behind that event alone.
    fn keep(&mut self, board: &mut Board) -> Result<(), ClientError> {
        self.tracer.hold(board)?;
        let (state, _) = board.run_state()?;
        let stops =
            state == Some(RunState::Stopping) && board.input(wire::MOVING, 1)?[0] & 0xFF == 0;
        let before = std::mem::replace(&mut self.ending, stops);
        if stops && before || !is_active(state) {
            self.stage = Stage::Runs;
        }
        Ok(())
    }

    fn event(&mut self, board: &mut Board, quiet: bool) -> Result<Option<Vec<What>>, ClientError> {
        let Some(what) = self.tracer.poll(board)? else {
            if quiet {
                if self.over {
                    return Ok(None);
                }
                // The last event may have come since that look: it is asked for once more.
                self.over = !is_active(board.run_state()?.0);
            }
            return Ok(Some(Vec::new()));
        };
        self.heard = Instant::now();
        self.over = matches!(what, What::End { .. });
        let behind = what.line();
        if let What::Run { .. } = what {
            // The lines of the other program are not known here.
            self.line_of = Arc::new(|_| 0);
        }
        if self.over {
            return Ok(Some(vec![what]));
        }
        if self.exact && self.may_halt() {
            self.stage = Stage::Arrives(behind);
        } else if !self.exact && (self.pace == Pace::Step || self.breaks.contains(&behind)) {
            let next = (self.line_of)(board.status()?.program_counter);
            self.stage = Stage::Halted(Halt { behind, next, exact: false, standing: None });
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

/// Whether a run was begun and has not ended.
fn is_active(state: Option<RunState>) -> bool {
    !matches!(state, Some(RunState::Empty | RunState::Ready | RunState::Fault))
}
