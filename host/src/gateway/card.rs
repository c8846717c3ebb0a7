//! The interface cards of charlyrobot and isel, emulated in front of a board: their programs move it over a
//! serial line, a pseudo-terminal or TCP.
//!
//! [`import::card`] knows the card's language. Here one thread reads input and handles the bytes that
//! stop at any time ([`talk`]); another one executes lines one after the other and answers each
//! ([`worker`]), by commands with a bounded distance ([`drive`]). When a client disconnects, nothing keeps
//! moving: waiting lines are dropped, and a move under way ends at its target.

mod drive;
mod port;
mod setting;
mod stopper;
mod talk;
mod worker;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

pub use setting::CardSetting;

use super::Gateway;
use super::turns::Asker;
use crate::input;
use drive::Drive;
use port::Port;
use stopper::Stopper;
use talk::Talk;
use worker::Worker;

/// Cards are clients, too; those of Modbus TCP count from 1.
const FIRST_ASKER: Asker = 1 << 62;
/// Longest wait for what comes, between two looks at what is to go out.
const WAIT: Duration = Duration::from_millis(5);

/// Where cards answer.
pub struct Cards {
    /// Each card's board and the place where clients find it.
    pub places: Vec<(String, String)>,
    closing: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl Cards {
    /// Opens the ports of all cards and serves them until this is dropped.
    ///
    /// # Errors
    /// A port cannot be opened, or a profile is none; in words.
    pub fn start(settings: &[CardSetting], gateway: &Arc<Gateway>) -> Result<Cards, String> {
        let closing = Arc::new(AtomicBool::new(false));
        let mut cards = Cards { places: Vec::new(), closing, threads: Vec::new() };
        for (n, setting) in settings.iter().enumerate() {
            let words = |error: String| format!("[[card]] of {}: {error}", setting.board);
            let profile = input::profile(&setting.profile).map_err(|note| words(note.line()))?;
            let port = Port::open(setting).map_err(words)?;
            let board = gateway.names.iter().position(|name| *name == setting.board);
            let board = board.ok_or_else(|| words("there is no such board".to_owned()))?;
            cards.places.push((setting.board.clone(), port.name().to_owned()));
            let talk = Arc::new(Talk::new(setting.answer.line_end()));
            let drive = Drive::new(gateway, board, FIRST_ASKER + n as Asker, profile);
            let (stops, heard, over) = (drive.stopper(), talk.clone(), cards.closing.clone());
            cards.threads.push(std::thread::spawn(move || listen(port, &heard, &stops, &over)));
            let (mut worker, over) = (Worker::new(setting, talk, drive), cards.closing.clone());
            cards.threads.push(std::thread::spawn(move || worker.run(&over)));
        }
        Ok(cards)
    }
}

impl Drop for Cards {
    fn drop(&mut self) {
        self.closing.store(true, Ordering::SeqCst);
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

/// Reads what comes, hears stops in it, and writes what is answered.
fn listen(mut port: Port, talk: &Talk, stops: &Stopper, over: &AtomicBool) {
    let mut bytes = Vec::new();
    while !over.load(Ordering::SeqCst) {
        bytes.clear();
        let there = port.read(&mut bytes, WAIT);
        for byte in &bytes {
            if let Some(stop) = talk.take(*byte, stops.count()) {
                // The board first; then nothing that waited is carried out any more.
                stops.stop(stop);
                talk.stopped(stop);
            }
        }
        if !there {
            talk.left();
        }
        let out = talk.outgoing();
        if !out.is_empty() {
            port.write(&out);
        }
    }
    // Nobody is there any more who could stop it.
    stops.end();
}
