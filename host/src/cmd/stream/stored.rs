//! Streaming to a board that cannot: the job is stored and run piece by piece.

use std::time::{Duration, Instant};

use lang::fault::Fault;
use lang::profile::Profile;
use lang::wire::{Control, RunState};
use serde_json::json;

use super::Stream;
use super::ended::Ended;
use super::keys::Keys;
use crate::client::identity::Identity;
use crate::client::status::Status;
use crate::cmd::Console;
use crate::cmd::port::Board;
use crate::cmd::script::Script;
use crate::failure::Failure;
use crate::sim::trace::{Event, PerAxis, What};
use crate::sim::world::World;
use crate::sim::{self, Engine};
use crate::stream::cut::{Piece, cut};

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
fn startable(status: &Status) -> Result<(), Failure> {
    let why = match (status.run_state, &status.fault, status.blocked_by) {
        (Some(RunState::Fault), Some(fault), _) => {
            let text = status.text.unwrap_or_default();
            format!("{fault} is latched ({text}): `pasapas start` acknowledges it")
        }
        (_, _, Some(input)) => format!("input {input} holds it"),
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
        identity: &Identity,
        console: &Console,
    ) -> Result<(), Failure> {
        let expected = if self.from_line > 1 { Some(self.position(&script)?) } else { None };
        let last = script.program.last_line;
        let room = usize::from(identity.area_bytes).min(MAX_PIECE);
        let from = script.line_of_text(self.from_line);
        let mut pieces =
            cut(script.program.clone(), identity.part(), room, from).map_err(|mut refused| {
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
        if let Some(expected) = expected {
            let there = board.status()?.pos;
            let steps = |place: &PerAxis| place.values().map(Option::unwrap_or_default);
            self.confirm(steps(&expected), steps(&there), console)?;
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
            self.piece(board, piece, (&mut keys, &script.program.profile), console)?;
        }
        bar.finish_and_clear();
        let lines = last.saturating_sub(self.from_line - 1);
        told(&self.file, &Tally { pieces: pieces.len(), lines, time: begun.elapsed() }, console)
    }

    /// Stores a piece, starts it and waits for its end.
    fn piece(
        &self,
        board: &mut Board,
        piece: &Piece,
        (keys, profile): (&mut Keys, &Profile),
        console: &Console,
    ) -> Result<(), Failure> {
        board
            .bring(&piece.image, (None, "stream"), true, &mut |_| ())
            .map_err(|error| Failure::Board(error.to_string()))?;
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

    /// Where the tool stands before the first line that is run.
    fn position(&self, script: &Script) -> Result<PerAxis, Failure> {
        let place = std::rc::Rc::new(std::cell::Cell::new((false, PerAxis::default())));
        let (seen, from) = (place.clone(), script.line_of_text(self.from_line));
        let sink = Box::new(move |event: &Event| match &event.what {
            What::Move { line, to, .. } if !seen.get().0 => {
                let reached = *line >= from;
                seen.set((reached, if reached { seen.get().1 } else { *to }));
            }
            _ => {}
        });
        let options = sim::Options { record: false, times: false, ..sim::Options::default() };
        sim::run(&script.program, Engine::Rhai, &World::empty(), &options, sink)
            .map_err(|error| Failure::Board(error.to_string()))?;
        Ok(place.get().1)
    }
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
