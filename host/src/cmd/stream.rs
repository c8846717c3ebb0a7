//! `pasapas stream`: runs a job larger than the board's memory, piece by piece.

use std::io::{BufRead, IsTerminal};
use std::sync::mpsc::{self, Receiver};
use std::time::{Duration, Instant};

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use lang::wire::{Control, RunState};
use serde_json::json;

use super::port::{Board, Port};
use super::script::{self, Script};
use super::upload::compare;
use super::{Console, Options};
use crate::failure::Failure;
use crate::render::Note;
use crate::sim::trace::{Event, PerAxis, What};
use crate::sim::world::World;
use crate::sim::{self, Engine};
use crate::stream::{Piece, cut};

/// How often the board is asked while a piece runs.
const POLL: Duration = Duration::from_millis(40);

/// Longest piece, bytes: half of the board's area. What runs on when the cable is cut stays short,
/// and the board's check of a piece takes less than its watchdog's time.
const MAX_PIECE: usize = 1530;

/// `pasapas stream`
#[derive(Debug, Args)]
pub struct Stream {
    /// A script, or a program of another system
    file: String,
    #[command(flatten)]
    port: Port,
    /// Begin at this line: what the lines before it set holds, but nothing moves for them
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    from_line: u32,
    /// Run the job although the board's profile is another one
    #[arg(long)]
    any_profile: bool,
    /// Do not ask whether the tool stands where the job begins
    #[arg(long)]
    yes: bool,
}

/// How a job went.
struct Tally {
    pieces: usize,
    lines: u32,
    time: Duration,
}

impl Stream {
    /// Checks and cuts the whole job, then runs it.
    ///
    /// # Errors
    /// The job is wrong or cannot be cut; the board does not answer; the run faults or is stopped.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let script = script::load(&self.file, options, console)?;
        let mut board = self.port.connect(options, console)?;
        let identity = board.identity()?;
        identity.check().map_err(Failure::Board)?;
        if !self.any_profile {
            compare(&mut board, &script.program.profile)?;
        }
        let expected = if self.from_line > 1 { Some(self.position(&script)?) } else { None };
        let last = script.program.last_line;
        let room = usize::from(identity.area_bytes).min(MAX_PIECE);
        let pieces = cut(script.program, room, self.from_line).map_err(|refused| {
            let note = Note::error(&self.file, "B007", refused.text).at((refused.line, 1));
            console.refuse(&note.hint(refused.hint))
        })?;
        let keys = keys();
        if let Some(expected) = expected {
            self.confirm(&mut board, &expected, &keys, console)?;
        }
        if pieces.len() > 1 {
            console.complain(&format!(
                "{}: checked; {} pieces, motion stands between them; the board's stored program \
                 is replaced",
                self.file,
                pieces.len()
            ));
        }
        let bar = bar(last, console);
        let begun = Instant::now();
        for piece in &pieces {
            bar.set_position(piece.first_line.into());
            self.piece(&mut board, piece, &keys, console)?;
        }
        bar.finish_and_clear();
        let lines = last.saturating_sub(self.from_line - 1);
        self.tell(&Tally { pieces: pieces.len(), lines, time: begun.elapsed() }, console)
    }

    /// Stores a piece, starts it and waits for its end.
    fn piece(
        &self,
        board: &mut Board,
        piece: &Piece,
        keys: &Receiver<String>,
        console: &Console,
    ) -> Result<(), Failure> {
        board
            .upload(&piece.image, true, &mut |_| ())
            .map_err(|error| Failure::Board(error.to_string()))?;
        let (_, runs) = board.run_state()?;
        board.control(Control::Start)?;
        let mut told = None;
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
                console.complain("the job waits: Start, or `r` and Enter, goes on");
            }
            told = state;
            match state {
                Some(RunState::Ready | RunState::Fault) if count != runs => {
                    return self.ended(board, piece, console);
                }
                _ => {}
            }
            if let Ok(key) = keys.try_recv() {
                let control = match key.trim() {
                    "p" => Some(Control::Pause),
                    "r" if state == Some(RunState::WaitStart) => Some(Control::Start),
                    "r" => Some(Control::Resume),
                    "q" => Some(Control::Stop),
                    _ => None,
                };
                match control {
                    Some(control) => board.control(control)?,
                    None => console.complain("p pauses, r goes on, q stops"),
                }
            }
            board.link().pause(POLL);
        }
    }

    /// Tells how a piece ended; anything but its own end is the job's.
    fn ended(&self, board: &mut Board, piece: &Piece, console: &Console) -> Result<(), Failure> {
        let status = board.status()?;
        if status.last_end == Some("done") {
            return Ok(());
        }
        let mark = piece.sidecar.at(usize::from(status.program_counter));
        let line = status.line.map_or(mark.map_or(piece.first_line, |mark| mark.line), u32::from);
        let what = match (&status.fault, status.text) {
            (Some(fault), Some(text)) => format!("fault {fault}: {text}"),
            _ => "stopped here".to_owned(),
        };
        console.complain(&format!("{}:{line}:1: {what}", self.file));
        console.complain(&format!("  hint: --from-line {line} goes on from there"));
        Err(Failure::Run)
    }

    /// Where the tool stands before the first line that is run.
    fn position(&self, script: &Script) -> Result<PerAxis, Failure> {
        let place = std::rc::Rc::new(std::cell::Cell::new((false, PerAxis::default())));
        let (seen, from) = (place.clone(), self.from_line);
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

    fn confirm(
        &self,
        board: &mut Board,
        expected: &PerAxis,
        keys: &Receiver<String>,
        console: &Console,
    ) -> Result<(), Failure> {
        let there = board.status()?.pos;
        let list = |place: &PerAxis| {
            let axes = ["X", "Y", "Z"].into_iter().zip(place.values());
            let axes = axes.filter_map(|(axis, at)| Some(format!("{axis} {}", at?)));
            axes.collect::<Vec<_>>().join(", ")
        };
        console.complain(&format!(
            "line {} begins at {}; the board stands at {} (machine steps)",
            self.from_line,
            list(expected),
            list(&there)
        ));
        if self.yes {
            return Ok(());
        }
        if !std::io::stdin().is_terminal() {
            return Err(Failure::Usage(
                "--from-line needs --yes where nobody can be asked".to_owned(),
            ));
        }
        console.complain("Is the tool free to go on from there? yes, or anything else:");
        match keys.recv() {
            Ok(answer) if answer.trim() == "yes" => Ok(()),
            _ => Err(Failure::Usage("nothing was moved".to_owned())),
        }
    }

    #[expect(clippy::cast_precision_loss, reason = "a rate for people")]
    fn tell(&self, tally: &Tally, console: &Console) -> Result<(), Failure> {
        let Tally { pieces, lines, time } = tally;
        let rate = f64::from(*lines) / time.as_secs_f64().max(0.001);
        if console.json() {
            return console.json_line(&json!({
                "streamed": self.file, "lines": lines, "pieces": pieces,
                "seconds": time.as_millis() as f64 / 1000.0, "lines_per_second": rate.round(),
            }));
        }
        console.result(&format!(
            "{}: done, {lines} lines in {:.1} s, {rate:.0} lines/s, {pieces} pieces\n",
            self.file,
            time.as_secs_f64()
        ))
    }
}

/// Lines that the user types; none when nobody does.
fn keys() -> Receiver<String> {
    let (send, receive) = mpsc::channel();
    if std::io::stdin().is_terminal() {
        std::thread::spawn(move || {
            for line in std::io::stdin().lock().lines() {
                let Ok(line) = line else { return };
                if send.send(line).is_err() {
                    return;
                }
            }
        });
    }
    receive
}

/// Lines done and the time left, on a terminal only.
fn bar(lines: u32, console: &Console) -> ProgressBar {
    if !console.shows_progress() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(lines.into());
    let style = ProgressStyle::with_template("line {pos} of {len} {bar:40} {eta} left");
    if let Ok(style) = style {
        bar.set_style(style);
    }
    bar
}
