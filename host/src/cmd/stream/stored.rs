//! Streaming to a board that cannot: the job is stored and run piece by piece.

use std::time::{Duration, Instant};

use lang::back::Compiled;
use lang::fault::Fault;
use lang::profile::Profile;
use lang::wire::{self, Control, RunState};
use serde_json::json;

use super::Stream;
use super::ended::Ended;
use super::keys::Keys;
use crate::client::identity::Identity;
use crate::client::orders;
use crate::client::status::{Status, holds, long};
use crate::cmd::console::Console;
use crate::cmd::port::Board;
use crate::cmd::script::Script;
use crate::failure::Failure;
use crate::stream::cut::{Piece, cut};
use crate::stream::feed::Feed;
use crate::stream::job::{Goal, Job};
use crate::track::{Approach, Instruction, Track};

/// How often the board is asked while a piece runs.
const POLL: Duration = Duration::from_millis(40);

/// Longest piece, bytes: half of the board's area. What runs on when the cable is cut stays short,
/// and the board's check of a piece takes less than its watchdog's time.
const MAX_PIECE: usize = 1530;

/// How long a piece may take to begin.
const PATIENCE: Duration = Duration::from_secs(5);

/// Refuses a board on which Start would do something else than run the piece: it would acknowledge a
/// fault, and the job would wait for ever.
///
/// # Errors
/// A fault is latched, or an input holds the board; in words.
pub(super) fn startable(status: &Status) -> Result<(), Failure> {
    let why = match (status.run_state, &status.fault, status.blocked_by) {
        (Some(RunState::Fault), Some(fault), _) => {
            let text = status.text.unwrap_or_default();
            format!("{fault} is latched ({text}): `pasapas start` acknowledges it")
        }
        (_, _, Some(input)) => holds(input),
        (Some(RunState::Running | RunState::Paused | RunState::WaitStart), ..) => {
            "a program runs: `pasapas stop` ends it".to_owned()
        }
        _ => return Ok(()),
    };
    Err(Failure::Board(format!("the board cannot start the job: {why}")))
}

/// How a job went.
struct Tally {
    pieces: usize,
    lines: u32,
    time: Duration,
}

impl Stream {
    /// Cuts the whole job, then stores and runs piece after piece.
    ///
    /// # Errors
    /// The job cannot be cut; the board does not answer; the run faults or is stopped.
    pub(super) fn run_stored(
        &self,
        board: &mut Board,
        script: Script,
        compiled: &Compiled,
        identity: &Identity,
        console: &Console,
    ) -> Result<(), Failure> {
        let last = script.program.last_line;
        let area = usize::from(identity.area_bytes);
        let from = script.line_of_text(self.from_line);
        let pieces = |room| cut(script.program.clone(), identity.part(), room, from);
        // What cannot be cut, for its KEEP values or handlers, is stored whole where the board has room for that.
        let mut pieces = pieces(area.min(MAX_PIECE))
            .or_else(|why| pieces(area).map_err(|_| why))
            .map_err(|mut refused| {
            refused.line = script.line_of_file(refused.line);
            self.refuse(refused, console)
        })?;
        for piece in &mut pieces {
            piece.first_line = script.line_of_file(piece.first_line);
            piece.last_line = script.line_of_file(piece.last_line);
            for mark in &mut piece.sidecar.marks {
                mark.line = script.line_of_file(mark.line);
            }
        }
        let last = script.line_of_file(last);
        startable(&board.status()?)?;
        let mut approach = None;
        if self.from_line > 1 {
            let refuse = |refused| self.refuse(refused, console);
            let mut job = Job::new(Feed::new(compiled).map_err(refuse)?, MAX_PIECE);
            let mut track = Track::new(&script.program.profile, [0; 3], 0);
            let goal = Goal::Line { line: self.from_line, pass: 1 };
            job.skip(goal, &mut track).map_err(refuse)?;
            let way = self.approach(&track, goal, board, console)?;
            approach = Some((way.approach, track.darkens(way.on)));
        }
        if pieces.len() > 1 {
            console.complain(&format!(
                "{}: checked; {} pieces; the board's stored program is replaced",
                self.file,
                pieces.len()
            ));
        }
        let bar = super::bar(last.into(), last.into(), console);
        let mut keys = self.keys(console);
        let begun = Instant::now();
        for piece in &pieces {
            bar.set_position(piece.first_line.into());
            bar.set_message(piece.first_line.to_string());
            board
                .bring(&piece.image, (None, "stream"), true, &mut |_| ())
                .map_err(|error| Failure::Board(error.to_string()))?;
            // The board has the job's axes from the first piece on.
            if let Some((way, dark)) = approach.take() {
                come(board, &script.program.profile, &way, &dark)?;
            }
            self.piece(board, piece, (&mut keys, &script.program.profile), console)?;
        }
        bar.finish_and_clear();
        let lines = last.saturating_sub(self.from_line - 1);
        told(&self.file, &Tally { pieces: pieces.len(), lines, time: begun.elapsed() }, console)
    }

    /// Starts the piece that is stored and waits for its end.
    fn piece(
        &self,
        board: &mut Board,
        piece: &Piece,
        (keys, profile): (&mut Keys, &Profile),
        console: &Console,
    ) -> Result<(), Failure> {
        let (_, runs) = board.run_state()?;
        board.control(Control::Start)?;
        let asked = Instant::now();
        let mut told = None;
        let mut stopped = false;
        loop {
            let (state, count) = board.run_state().map_err(|error| {
                Failure::Board(format!(
                    "{error}; the board ends the piece that it holds, lines {} to {}, then stops \
                     with its outputs off; go on with --from-line {}",
                    piece.first_line,
                    piece.last_line,
                    piece.last_line + 1
                ))
            })?;
            if told != state && matches!(state, Some(RunState::Paused | RunState::WaitStart)) {
                console.complain("the job waits: Start, or r, goes on");
            }
            told = state;
            match state {
                Some(RunState::Ready | RunState::Fault) if count != runs => {
                    return self.ended(board, piece, profile, console);
                }
                // It has not begun: Start acknowledged something, or an input holds it.
                Some(RunState::Empty | RunState::Ready | RunState::Fault)
                    if stopped || asked.elapsed() > PATIENCE =>
                {
                    startable(&board.status()?)?;
                    return Err(Failure::Board(match stopped {
                        true => "stopped before the piece began".to_owned(),
                        false => "the board does not begin: `pasapas status` tells why".to_owned(),
                    }));
                }
                _ => {}
            }
            if let Some(control) = self.key(keys, state, console) {
                stopped |= control == Control::Stop;
                board.control(control)?;
            }
            board.link().pause(POLL);
        }
    }

    /// Tells how a piece ended; anything but its own end is the job's.
    fn ended(
        &self,
        board: &mut Board,
        piece: &Piece,
        profile: &Profile,
        console: &Console,
    ) -> Result<(), Failure> {
        let status = board.status()?;
        if status.last_end == Some("done") {
            return Ok(());
        }
        let mark = piece.sidecar.at(usize::from(status.program_counter));
        let line = mark.map_or(piece.first_line, |mark| mark.line);
        let fault = status.fault.as_deref().and_then(|code| code.strip_prefix('F')?.parse().ok());
        let fault = fault.and_then(Fault::from_number);
        Ended::new(line, fault, Some(&status), profile).tell(&self.file, line, console);
        Err(Failure::Run)
    }
}

/// Brings a board to where the job goes on, by commands, with the outputs off: a job that is stored in pieces begins each
/// of them where the axes stand.
fn come(
    board: &mut Board,
    profile: &Profile,
    approach: &Approach,
    dark: &[Instruction],
) -> Result<(), Failure> {
    for (values, _) in dark {
        board.set_coil(wire::COILS + values[0] as u16 - 1, false)?;
    }
    let words = board.input(wire::WORK_POSITIONS, 6)?;
    let work = [0, 2, 4].map(|at: usize| long(words[at], words[at + 1]));
    let words = board.holding(wire::MACHINE_POSITIONS, 6)?;
    let offsets = [0, 1, 2].map(|i: usize| long(words[2 * i], words[2 * i + 1]) - work[i]);
    for leg in &approach.legs {
        for (axis, own) in profile.axes() {
            let Some(place) = leg[axis.index()] else { continue };
            let target = i64::from(place.steps) - i64::from(offsets[axis.index()]);
            let order =
                orders::move_to(axis, orders::ramps(own), own.top_rate.unsigned_abs(), target);
            let wrong = || format!("{} cannot go to where that line begins", axis.letter());
            board.order(&order, wrong).map_err(Failure::Board)?;
            while !board.status()?.moving.is_empty() {
                board.link().pause(POLL);
            }
            let words = board.holding(wire::MACHINE_POSITIONS, 6)?;
            let at = 2 * axis.index();
            if long(words[at], words[at + 1]) != place.steps {
                return Err(Failure::Board(format!(
                    "{} was stopped on its way to where that line begins",
                    axis.letter()
                )));
            }
        }
    }
    Ok(())
}

#[expect(clippy::cast_precision_loss, reason = "a rate for people")]
fn told(file: &str, tally: &Tally, console: &Console) -> Result<(), Failure> {
    let Tally { pieces, lines, time } = tally;
    let rate = f64::from(*lines) / time.as_secs_f64().max(0.001);
    if console.json() {
        return console.json_line(&json!({
            "streamed": file, "lines": lines, "pieces": pieces,
            "seconds": time.as_millis() as f64 / 1000.0, "lines_per_second": rate.round(),
        }));
    }
    console.result(&format!(
        "{}: done, {lines} lines in {:.1} s, {rate:.0} lines/s, {pieces} pieces\n",
        file,
        time.as_secs_f64()
    ))
}
