//! Feeds waiting lines to their boards.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use lang::back::Compiled;
use lang::front::source::Source as Text;
use lang::front::{ProfileChoice, compile};
use lang::profile::Profile;
use lang::wire::{Control, End};

use super::{GcodeSetting, Texts};
use crate::client::Client;
use crate::client::identity::must_match;
use crate::gateway::Gateway;
use crate::gateway::inside::{ADDRESS, Inside};
use crate::gateway::turns::Asker;
use crate::input;
use crate::stream::chain::Chain;
use crate::stream::feed::Feed;
use crate::stream::job::{Job, More};
use crate::stream::pump;

/// Client number of G-code over Modbus, apart from those of clients and cards.
const FIRST_ASKER: Asker = 1 << 61;
/// Longest wait for a line, between two looks whether the gateway ends.
const WAIT: Duration = Duration::from_millis(100);
/// The same while the board is fed.
const SOON: Duration = Duration::from_millis(2);
/// A run to which no line comes for so long is over; outputs go to their state at an end.
const IDLE: Duration = Duration::from_millis(1_000);
/// The same while a spindle or coolant is on.
const BUSY: Duration = Duration::from_secs(60);

/// The buffers of boards, by their numbers in the gateway's file.
pub type Buffers = Vec<(usize, Arc<Texts>)>;

/// The threads that feed.
pub struct Hosts {
    closing: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl Hosts {
    /// Starts them; the buffers that they take from come with them.
    ///
    /// # Errors
    /// A profile is none; in words.
    pub fn start(
        settings: &[GcodeSetting],
        gateway: &Arc<Gateway>,
    ) -> Result<(Hosts, Buffers), String> {
        let mut hosts = Hosts { closing: Arc::default(), threads: Vec::new() };
        let mut buffers = Vec::new();
        for (n, setting) in settings.iter().enumerate() {
            let words = |error: String| format!("[[gcode]] of {}: {error}", setting.board);
            let profile = input::profile(&setting.profile).map_err(|note| words(note.line()))?;
            let board = gateway.names.iter().position(|name| *name == setting.board);
            let board = board.ok_or_else(|| words("there is no such board".to_owned()))?;
            let texts = Arc::new(Texts::new(profile));
            let inside = Inside::new(gateway, board, FIRST_ASKER + n as Asker);
            let (own, over, name) = (texts.clone(), hosts.closing.clone(), setting.board.clone());
            hosts.threads.push(std::thread::spawn(move || {
                feed(&name, &own, Client::new(inside, ADDRESS), &over);
            }));
            buffers.push((board, texts));
        }
        Ok((hosts, buffers))
    }
}

impl Drop for Hosts {
    fn drop(&mut self) {
        self.closing.store(true, Ordering::SeqCst);
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

/// Compiles lines of G-code.
///
/// # Errors
/// The first thing that is wrong, in words.
pub fn compiled(text: &str, profile: &Profile) -> Result<Compiled, String> {
    let options = import::Options {
        from: Some(import::Format::Gcode),
        profile: Some(profile.clone()),
        plain: true,
        ..import::Options::default()
    };
    let script = import::import("gcode", text.as_bytes(), &options).map_err(|notes| {
        let error = notes.into_iter().find(|note| note.severity == import::Severity::Error);
        error.map_or_else(String::new, |error| error.text)
    })?;
    let source = Text::new("gcode", script.script);
    let choice = ProfileChoice::Given(Box::new(profile.clone()));
    let (program, found) = compile(&source, choice);
    let program = program.ok_or_else(|| {
        let errors = found.into_sorted();
        errors.first().map_or_else(String::new, |diag| diag.message.clone())
    })?;
    lang::back::compile(&program).map_err(|_| "it is too long".to_owned())
}

fn feed(name: &str, texts: &Texts, mut client: Client<Inside>, over: &AtomicBool) {
    while !over.load(Ordering::SeqCst) {
        let Some(batch) = texts.batch(WAIT) else { continue };
        if let Err(why) = run(texts, batch, &mut client, over) {
            eprintln!("pasapas: G-code for {name}: {why}");
            texts.end(&why);
        }
        texts.rest();
    }
}

/// One run of the board, from the first batch to where no more follows.
fn run(
    texts: &Texts,
    batch: super::Batch,
    client: &mut Client<Inside>,
    over: &AtomicBool,
) -> Result<(), String> {
    let words = |error: crate::client::ClientError| error.to_string();
    must_match(&client.board_record().map_err(words)?, &texts.profile)?;
    let slots = client.stream_slots().map_err(words)?;
    let slots = slots.ok_or("its firmware has no feature `stream`: it cannot be fed")?;
    let first = Chain::new(compiled(&batch.text, &texts.profile)?);
    let mut job =
        Job::new(Feed::new(first.compiled()).map_err(|flaw| flaw.text)?, slots.bytes.into());
    let (mut end, mut last, mut heard) = (&first, batch.last, Instant::now());
    job.follow_with(Box::new(move || {
        if last || texts.is_broken() || over.load(Ordering::SeqCst) {
            return More::Over;
        }
        let Some(batch) = texts.batch(SOON) else {
            let patience = if texts.is_busy() { BUSY } else { IDLE };
            return if heard.elapsed() > patience { More::Over } else { More::Wait };
        };
        (heard, last) = (Instant::now(), batch.last);
        // Each line was compiled when it came; together they are no longer than a batch.
        match compiled(&batch.text, &texts.profile) {
            Ok(compiled) => {
                end = end.push(compiled);
                match Feed::new(end.compiled()) {
                    Ok(feed) => More::Feed(feed),
                    Err(flaw) => {
                        texts.end(&flaw.text);
                        More::Over
                    }
                }
            }
            Err(why) => {
                texts.end(&why);
                More::Over
            }
        }
    }));
    let mut watch = |_: &pump::Progress| over.load(Ordering::SeqCst).then_some(Control::Stop);
    let outcome = pump::run(client, &mut job, slots, &mut watch, &mut |_| ());
    let outcome = outcome.map_err(|error| error.to_string())?;
    match (outcome.end, outcome.fault) {
        (End::Done, _) => Ok(()),
        (_, Some(fault)) => Err(format!("{fault} {}", fault.text())),
        _ => Err("it was stopped".to_owned()),
    }
}
