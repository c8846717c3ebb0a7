//! `pasapas stream`: runs a job larger than the board's memory.

mod approach;
mod ended;
mod keep;
mod keys;
mod stored;

use std::io::Write;
use std::time::{Duration, Instant};

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use lang::back::Compiled;
use lang::hir::Storage;
use lang::wire::{Control, End, RunState};
use serde_json::json;

use ended::Ended;
use keep::KeepFile;
use keys::{Key, Keys};

use super::arcs;
use super::console::{Console, Options};
use super::port::{Board, Port};
use super::script::{self, Script};
use super::upload::compare;
use crate::client::identity::Identity;
use crate::client::stream::Slots;
use crate::failure::Failure;
use crate::render::Note;
use crate::stream::check::{self, Checked};
use crate::stream::feed::{Feed, Refused};
use crate::stream::job::Job;
use crate::stream::late;
use crate::stream::pump::{self, Outcome, Progress, PumpError};
use crate::track::Track;

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
    /// In a loop: begin where the job comes to that line the K-th time
    #[arg(long, value_name = "K", default_value_t = 1, requires = "from_line")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..))]
    pass: u32,
    /// Begin with the first line that is drawn through this place, work positions in mm, or passes nearest to it
    #[arg(long, value_name = "X,Y", conflicts_with_all = ["from_line", "pass"], allow_hyphen_values = true)]
    #[arg(value_parser = approach::place)]
    from_place: Option<[i32; 2]>,
    /// With --from-line or --from-place: Z goes up to this work position, mm, on the way there, not as high as the job
    /// has ever sent it
    #[arg(long, value_name = "Z", allow_hyphen_values = true, value_parser = approach::mm)]
    lift: Option<i32>,
    /// Lay a job of G-code onto the surface that this file of heights describes, as `pasapas level` does
    #[arg(long, value_name = "HEIGHTS")]
    level: Option<String>,
    /// Run the job although the board's profile is another one
    #[arg(long)]
    any_profile: bool,
    /// Do not ask whether the way to where the job begins is free
    #[arg(long)]
    yes: bool,
    /// Store the job in pieces, as for a board that cannot stream
    #[arg(long)]
    stored: bool,
}

impl Stream {
    /// Checks the whole job, then runs it.
    ///
    /// # Errors
    /// The job is wrong or cannot be streamed; the board does not answer; the run faults or is
    /// stopped.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let mut script = match &self.level {
            Some(heights) => script::load_levelled(&self.file, heights, options, console)?,
            None => script::load_plain(&self.file, options, console)?,
        };
        let keeps = [("the file of KEEP values", Some(format!("{}.keep", self.file)))];
        script.keep_inputs(&self.file, options, self.level.as_deref(), &keeps)?;
        let mut compiled = script::compile_any(&script, console)?;
        let mut board = self.port.connect(options, console)?;
        let identity = board.identity()?;
        identity.check().map_err(Failure::Board)?;
        if !self.any_profile {
            compare(&mut board, &script.program.profile)?;
        }
        if arcs::are_missing(&compiled, identity.features) {
            compiled = arcs::without(&mut script, &compiled, "this board", console)?;
        }
        let before = board.late_events()?;
        let result = self.run_on(&mut board, script, compiled, &identity, console);
        // A board that has not answered is not asked again.
        if matches!(result, Ok(()) | Err(Failure::Run))
            && let Some(late) = board.late_since(before)?
        {
            console.complain(&format!("{}: {late}", self.file));
        }
        result
    }

    /// Runs a job on a board of its profile.
    fn run_on(
        &self,
        board: &mut Board,
        script: Script,
        mut compiled: Compiled,
        identity: &Identity,
        console: &Console,
    ) -> Result<(), Failure> {
        // What is told and asked for are lines of the file, also of another system's.
        for mark in &mut compiled.sidecar.marks {
            mark.line = script.line_of_file(mark.line);
        }
        let slots = if self.stored { None } else { board.stream_slots()? };
        let Some(slots) = slots else {
            if self.pass > 1 || self.from_place.is_some() {
                return Err(Failure::Usage(
                    "--pass and --from-place need a board that can be fed: pieces of a job begin outside of loops"
                        .to_owned(),
                ));
            }
            if !self.stored {
                console.complain(
                    "this board's firmware has no feature `stream` (the MSP430G2553 has no RAM for \
                     it): the job is stored piece by piece and motion stands between the pieces",
                );
            }
            return self.run_stored(board, script, &compiled, identity, console);
        };
        stored::startable(&board.status()?)?;
        let fits = self.from_line == 1
            && self.from_place.is_none()
            && compiled.image.len() <= script::room_for(true);
        let feed = match Feed::new(&compiled) {
            Ok(feed) if fits && !feed.keeps().is_empty() => {
                console.complain("KEEP values belong to a stored program; it fits and is stored");
                return self.run_stored(board, script, &compiled, identity, console);
            }
            Ok(feed) if fits && feed.has_events() => {
                console.complain(
                    "a stored program serves ON IN and ON EVERY within 2 ms; it fits and is stored",
                );
                return self.run_stored(board, script, &compiled, identity, console);
            }
            Ok(feed) => feed,
            Err(refused) => return Err(self.refuse(refused, console)),
        };
        if feed.has_events() {
            let late = late::handler_ms(board.mode().rate);
            let mut text = format!(
                "handlers of ON IN and ON EVERY begin up to {late} ms late: they go over the link \
                 (2 ms in a stored program); edges and ticks that come meanwhile count once"
            );
            let mut line = 1;
            if let Some((at, ms)) = late::too_fast(&script.program, late) {
                line = script.line_of_file(at);
                text.push_str(&format!("; every {ms} ms leaves no time for anything else"));
            }
            let note = Note::error(&self.file, "B010", text).at((line, 1));
            console.note(&note.warning())?;
        }
        self.feed(board, &script, &compiled, feed, slots, console)
    }

    fn refuse(&self, refused: Refused, console: &Console) -> Failure {
        let note = Note::error(&self.file, "B008", refused.text).at((refused.line, 1));
        console.refuse(&note.hint(refused.hint))
    }

    /// Feeds a board that can stream.
    fn feed(
        &self,
        board: &mut Board,
        script: &Script,
        compiled: &Compiled,
        mut feed: Feed<'_>,
        slots: Slots,
        console: &Console,
    ) -> Result<(), Failure> {
        let profile = &script.program.profile;
        let standing = board.stream_standing()?;
        let track = Track::new(profile, standing.steps, standing.homed);
        let mut keeps = KeepFile::open(&self.file, &script.program);
        if let Some(told) = keeps.told() {
            console.complain(&told);
        }
        feed.set_keeps(keeps.values());
        let whole = feed.clone();
        let mut job = Job::new(feed, slots.bytes.into());
        let checked = if self.from_line > 1 || self.from_place.is_some() {
            let goal = self.goal(&whole, profile, console)?;
            let mut track = Track::new(profile, [0; 3], 0);
            job.skip(goal, &mut track).map_err(|refused| self.refuse(refused, console))?;
            let way = self.approach(&track, goal, board, console)?;
            job.lead(track.darkens(way.on));
            job.lead(way.approach.instructions());
            let restored = track.restore().map_err(|fault| self.wrong_place(fault))?;
            job.lead(restored);
            Checked::default()
        } else {
            check::check(whole, track).map_err(|refused| self.refuse(refused, console))?
        };
        if let Some(line) = checked.open {
            console.complain(&format!(
                "{}:{line}:1: checked up to here; what follows hangs on what the machine answers",
                self.file
            ));
        }
        if script.program.vars.iter().any(|var| matches!(var.storage, Storage::At(_))) {
            console.complain(
                "variables with AT live on this computer while a job is streamed: no HMI sees them",
            );
        }
        let bar = bar(checked.count, compiled.statements.into(), console);
        let mut keys = self.keys(console);
        let mut diary = Diary { last: Instant::now(), all: checked.count };
        let mut told = None;
        let mut watch = |progress: &Progress| {
            bar.set_position(progress.count);
            bar.set_message(progress.line.to_string());
            if !console.shows_progress()
                && !console.json()
                && let Some(entry) = diary.entry(Instant::now(), progress)
            {
                console.complain(&entry);
            }
            if told != progress.state {
                match progress.state {
                    Some(RunState::Paused) => console.complain("paused; r goes on"),
                    Some(RunState::WaitStart) => {
                        console.complain("the job waits: Start, or r, goes on");
                    }
                    _ => {}
                }
            }
            told = progress.state;
            keeps.note(&progress.keeps);
            self.key(&mut keys, progress.state, console)
        };
        let mut print = |bytes: &[u8]| {
            let mut out = std::io::stdout().lock();
            // Nobody to tell when standard output is gone; the job goes on.
            let _ = out.write_all(bytes).and_then(|()| out.flush());
        };
        let result = pump::run(board, &mut job, slots, &mut watch, &mut print);
        bar.finish_and_clear();
        if let Ok(outcome) = &result {
            keeps.note(&outcome.keeps);
        }
        keeps.write();
        if let Some(path) = keeps.lost() {
            console.complain(&format!(
                "{} cannot be written: the KEEP values are lost",
                path.display()
            ));
        }
        match result {
            Ok(outcome) => {
                // The input is asked for where a fault may have one.
                let status = outcome.fault.and_then(|_| board.status().ok());
                let Outcome { line, fault, .. } = outcome;
                self.tell(&outcome, &Ended::new(line, fault, status.as_ref(), profile), console)
            }
            Err(error @ (PumpError::Link(..) | PumpError::Refused(_) | PumpError::Busy)) => {
                Err(Failure::Board(error.to_string()))
            }
        }
    }

    /// Listens to the user, and says so.
    fn keys(&self, console: &Console) -> Keys {
        let keys = Keys::open(self.file == "-");
        if let Some(help) = keys.help() {
            console.complain(help);
        }
        keys
    }

    /// What the user has typed.
    fn key(&self, keys: &mut Keys, state: Option<RunState>, console: &Console) -> Option<Control> {
        match keys.next()? {
            Key::Pause => Some(Control::Pause),
            Key::Resume if state == Some(RunState::WaitStart) => Some(Control::Start),
            Key::Resume => Some(Control::Resume),
            Key::Stop => {
                console.complain("stopping");
                Some(Control::Stop)
            }
            Key::Unknown => {
                if let Some(help) = keys.help() {
                    console.complain(help);
                }
                None
            }
        }
    }

    /// Says how the job ended.
    #[expect(clippy::cast_precision_loss, reason = "rates for people")]
    fn tell(&self, outcome: &Outcome, ended: &Ended, console: &Console) -> Result<(), Failure> {
        let seconds = outcome.time.as_millis() as f64 / 1000.0;
        let rate = outcome.count as f64 / seconds.max(0.001);
        let Outcome { end, line, count, pieces, starved, .. } = *outcome;
        if console.json() {
            console.json_line(&json!({
                "streamed": self.file, "statements": count, "pieces": pieces, "seconds": seconds,
                "statements_per_second": rate.round(), "starved": starved, "line": line,
                "end": match end { End::Done => "done", End::Stopped => "stopped", _ => "fault" },
            }))?;
        }
        if end == End::Done {
            if !console.json() {
                console.result(&format!(
                    "{}: done, {count} statements of the machine in {seconds:.1} s, {rate:.0} a \
                     second, {pieces} pieces; motion stood {starved} times for want of one\n",
                    self.file
                ))?;
            }
            return Ok(());
        }
        ended.tell(&self.file, line, console);
        Err(Failure::Run)
    }
}

/// Tells a log how far the job is, where no terminal shows it.
struct Diary {
    last: Instant,
    /// Statements that are known to come, 0 for not.
    all: u64,
}

impl Diary {
    /// Time between two entries.
    const EVERY: Duration = Duration::from_secs(30);

    /// What to write now, if it is time.
    fn entry(&mut self, now: Instant, progress: &Progress) -> Option<String> {
        if now.duration_since(self.last) < Diary::EVERY {
            return None;
        }
        self.last = now;
        let Progress { line, count, .. } = progress;
        Some(match (count * 100).checked_div(self.all) {
            Some(percent) => format!("line {line}, {percent} %"),
            None => format!("line {line}, {count} statements"),
        })
    }
}

/// Progress and the time left, on a terminal only. `count` statements are known to come, otherwise
/// `guess`.
fn bar(count: u64, guess: u64, console: &Console) -> ProgressBar {
    if !console.shows_progress() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(if count > 0 { count } else { guess });
    let style = ProgressStyle::with_template("line {msg}, {percent} % {bar:40} {eta} left");
    if let Ok(style) = style {
        bar.set_style(style);
    }
    bar
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::{Diary, Progress};

    #[test]
    fn a_log_hears_of_a_long_job_now_and_then() {
        let begun = Instant::now();
        let mut diary = Diary { last: begun, all: 400 };
        let progress =
            Progress { state: None, line: 17, count: 100, keeps: Vec::new(), dry: false };
        let mut at = |s| diary.entry(begun + Duration::from_secs(s), &progress);
        assert_eq!([at(1), at(29)], [None, None]);
        assert_eq!(at(31).as_deref(), Some("line 17, 25 %"));
        assert_eq!(at(60), None);
        let mut diary = Diary { last: begun, all: 0 };
        let later = begun + Duration::from_secs(90);
        assert_eq!(diary.entry(later, &progress).as_deref(), Some("line 17, 100 statements"));
    }
}
