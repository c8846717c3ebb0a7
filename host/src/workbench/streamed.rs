//! Jobs that are larger than the board's memory, run from the page: fed piece by piece, as `pasapas stream` does it.
//!
//! The job holds the board's thread until it is over. What the page shows meanwhile comes from the job itself, and
//! Pause and Resume reach it here; Stop interrupts it like everything else.

use std::sync::Arc;
use std::time::{Duration, Instant};

use lang::place::Place;
use lang::wire::{Control, End, RunState};
use serde::Serialize;
use serde_json::json;

use super::bench::{Bench, lock};
use super::machine::Ask;
use super::message::{ToPage, Wish};
use super::session::Answer;
use super::stored::compare;
use crate::client::ClientError;
use crate::client::status::{Status, state_name};
use crate::client::stream::Slots;
use crate::helm::{Board, Entry, Picture};
use crate::stream::check::check;
use crate::stream::feed::{Feed, Refused};
use crate::stream::job::{Goal, Job};
use crate::stream::pump::{self, Outcome, Progress, PumpError};
use crate::stream::way::{self, NoWay, Way};
use crate::track::Track;
use crate::trial::Loaded;

/// How often the machine's place is looked at while a job runs.
const LOOK: Duration = Duration::from_millis(200);

/// A job that runs.
#[derive(Debug, Default)]
pub struct Streamed {
    shown: Shown,
    state: Option<&'static str>,
    /// The newest look at the machine.
    status: Option<Status>,
    /// What a page wants of it.
    wanted: Option<Control>,
}

/// Where a job begins in its middle.
pub struct Middle {
    /// From 1.
    pub line: u32,
    /// How the board comes there, as it was shown.
    pub way: String,
}

/// How far it is.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Shown {
    /// Number of the text that is fed: the page may show another one by now.
    number: u64,
    /// The line that runs.
    line: u32,
    /// Statements of the machine that were begun.
    count: u64,
    /// All of them; 0 where that hangs on what the machine answers.
    all: u64,
}

fn words(error: ClientError) -> String {
    error.to_string()
}

fn refused(refused: Refused) -> String {
    format!("line {}: {} ({})", refused.line, refused.text, refused.hint)
}

impl Bench {
    /// Puts what a running job knows into a picture of the board; how far the job is.
    pub(super) fn show_streamed(&self, picture: &mut Picture) -> Option<Shown> {
        let streamed = lock(&self.streamed);
        let streamed = streamed.as_ref()?;
        if let Some(status) = &streamed.status {
            picture.status = Some(status.clone());
        }
        if let (Some(status), Some(state)) = (&mut picture.status, streamed.state) {
            status.state = state;
        }
        Some(streamed.shown.clone())
    }

    /// Whether a job has the board, or waits for it.
    pub(super) fn is_streaming(&self) -> bool {
        lock(&self.streamed).is_some()
    }

    /// Gives a running job a control; whether there is one.
    pub(super) fn control_streamed(&self, control: Control) -> bool {
        let mut streamed = lock(&self.streamed);
        let Some(streamed) = streamed.as_mut() else { return false };
        let waits = streamed.state == Some(state_name(RunState::WaitStart));
        streamed.wanted = match control {
            Control::Resume | Control::Start if waits => Some(Control::Start),
            // The board would refuse it, and that would end the job.
            Control::Start => None,
            control => Some(control),
        };
        true
    }
}

/// What a page may ask for while a job has the board; `emulated`: a contact needs no request to it.
pub(super) fn takes(wish: &Wish, emulated: bool) -> bool {
    matches!(wish, Wish::Start | Wish::Pause | Wish::Resume)
        || emulated && matches!(wish, Wish::Input(..) | Wish::Press { .. })
}

/// The job is over, however that came: also when its turn never did.
struct Ends(Arc<Bench>);

impl Drop for Ends {
    fn drop(&mut self) {
        // Nothing of the helm's here: it may be what drops a request, and holds its lock.
        *lock(&self.0.streamed) = None;
    }
}

impl Ask<'_> {
    /// How the board comes to where the present text goes on at a line; nothing moves.
    pub fn way(&self, line: u32) -> Result<Answer, String> {
        let loaded = self.bench.compile()?;
        let bench = self.bench.clone();
        self.answer(move |board| {
            let (mut job, _) = job(&bench, &loaded, board)?;
            let (_, way) = skip(&loaded, &mut job, board, line)?;
            let leg = |leg: &[Option<Place>; 3]| leg.map(|place| place.map(|place| place.um));
            let legs: Vec<_> = way.approach.legs.iter().map(leg).collect();
            Ok(Some(json!({ "way": way::told(&way.approach), "legs": legs })))
        })
    }

    /// Feeds the present text to the board, or what follows a line. The answer comes when the job is over.
    pub fn stream(&self, from: Option<Middle>) -> Result<Answer, String> {
        let number = lock(&self.bench.desk).number();
        let loaded = self.bench.compile()?;
        lock(&self.bench.streamed).get_or_insert_default();
        let ends = Ends(self.bench.clone());
        self.answer(move |board| {
            let result = run(&ends.0, (number, &loaded), from.as_ref(), board);
            ends.0.helm.refresh();
            result.map(|told| Some(json!(told)))
        })
    }
}

/// A job of a text for this board, and the board's room for its pieces.
fn job<'a>(
    bench: &Bench,
    loaded: &'a Loaded,
    board: &mut Board,
) -> Result<(Job<'a>, Slots), String> {
    let profile = &loaded.program.profile;
    compare(board, profile)?;
    let identity = board.identity().map_err(words)?;
    identity.check()?;
    let file = lock(&bench.desk).name().unwrap_or_else(|| "FILE".to_owned());
    let slots = board.stream_slots().map_err(words)?.ok_or_else(|| {
        format!("this board has no memory for a job that is fed: `pasapas stream {file}` stores it piece by piece")
    })?;
    let feed = Feed::new(&loaded.compiled).map_err(refused)?;
    if !feed.keeps().is_empty() {
        return Err(format!(
            "KEEP values of a streamed job are kept in a file: run `pasapas stream {file}`"
        ));
    }
    Ok((Job::new(feed, slots.bytes.into()), slots))
}

/// Leads a job to a line; what it has set by then, and how the board comes there.
fn skip(
    loaded: &Loaded,
    job: &mut Job<'_>,
    board: &mut Board,
    line: u32,
) -> Result<(Track, Way), String> {
    let mut track = Track::new(&loaded.program.profile, [0; 3], 0);
    job.skip(Goal::Line { line, pass: 1 }, &mut track).map_err(refused)?;
    let way = way::find(board, &track, None).map_err(|none| match none {
        NoWay::Link(error) => words(error),
        NoWay::Latched => "a fault is latched: acknowledge it first".to_owned(),
        NoWay::NotHomed(axis) => {
            let axis = axis.letter();
            format!("the job has homed {axis} before line {line}, and the board has not: home {axis} first")
        }
        NoWay::Wrong(fault) => format!("the way to line {line}: {fault} {}", fault.text()),
    })?;
    Ok((track, way))
}

/// Checks the whole job, and runs it, or what follows a line; what came of it, in words.
fn run(
    bench: &Arc<Bench>,
    (number, loaded): (u64, &Loaded),
    from: Option<&Middle>,
    board: &mut Board,
) -> Result<String, String> {
    let file = lock(&bench.desk).name().unwrap_or_else(|| "FILE".to_owned());
    let (mut job, slots) = job(bench, loaded, board)?;
    let all = if let Some(Middle { line, way: shown }) = from {
        let (track, way) = skip(loaded, &mut job, board, *line)?;
        if way::told(&way.approach) != *shown {
            return Err("the way there is another one by now: look at it again".to_owned());
        }
        job.lead(track.darkens(way.on));
        job.lead(way.approach.instructions());
        let restored = track.restore();
        job.lead(
            restored
                .map_err(|fault| format!("the way to line {line}: {fault} {}", fault.text()))?,
        );
        0
    } else {
        let standing = board.stream_standing().map_err(words)?;
        let track = Track::new(&loaded.program.profile, standing.steps, standing.homed);
        let checked = check(job.feed().clone(), track).map_err(refused)?;
        if checked.open.is_some() { 0 } else { checked.count }
    };
    *lock(&bench.streamed) =
        Some(Streamed { shown: Shown { number, all, ..Shown::default() }, ..Streamed::default() });
    let mut watch = |progress: &Progress| {
        let mut streamed = lock(&bench.streamed);
        let streamed = streamed.as_mut()?;
        (streamed.shown.line, streamed.shown.count) = (progress.line, progress.count);
        streamed.state = progress.state.map(state_name);
        streamed.wanted.take()
    };
    let mut line = Vec::new();
    let mut print = |bytes: &[u8]| {
        line.extend_from_slice(bytes);
        while let Some(end) = line.iter().position(|byte| *byte == b'\n') {
            let text: Vec<u8> = line.drain(..=end).collect();
            let text = String::from_utf8_lossy(&text[..end]).into_owned();
            bench.tell(&ToPage::Log(vec![Entry::Print(text)]));
        }
    };
    let mut looked = Instant::now();
    let mut look = |board: &mut Board, _: &_, _: &Progress| {
        if looked.elapsed() >= LOOK {
            looked = Instant::now();
            let status = board.status()?;
            if let Some(streamed) = lock(&bench.streamed).as_mut() {
                streamed.status = Some(status);
            }
        }
        Ok(())
    };
    match pump::run_observed(board, &mut job, slots, &mut watch, Some(&mut print), &mut look) {
        Ok(Outcome { end: End::Done, count, time, .. }) => {
            Ok(format!("The job is done: {count} statements in {} s.", time.as_secs()))
        }
        Ok(Outcome { fault: Some(fault), line, .. }) => Err(format!(
            "{fault} in line {line}: {}. Mend what caused it, then go on with `pasapas stream {file} --from-line {line}`",
            fault.text()
        )),
        Ok(Outcome { line, .. }) | Err(PumpError::Link(ClientError::Interrupted, line)) => {
            Err(format!(
                "stopped in line {line}: `pasapas stream {file} --from-line {line}` goes on there"
            ))
        }
        Err(error) => Err(error.to_string()),
    }
}
