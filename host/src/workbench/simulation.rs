//! The thread that simulates the newest text, and what it finds beside the script.

use std::cell::Cell;
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

use serde_json::json;

use super::around::Around;
use super::bench::{Bench, lock};
use super::client::Client;
use super::message::ToPage;
use crate::client::identity::Identity;
use crate::helm::User;
use crate::trial::budget::Budget;
use crate::trial::{self, Trial};

/// How long the simulation at a pause in typing may take; one of a loop without an end, which is over
/// after its first turns; and one that shows all, which the next key ends.
const LIVE: Duration = Duration::from_millis(500);
const TURNS: Duration = Duration::from_secs(3);
const LONG: Duration = Duration::from_secs(600);
/// How often it is told how far one is.
const TELL: Duration = Duration::from_millis(250);

impl Bench {
    /// The text is to be simulated, for a moment or (`all`) as far as it goes. One that is under way is
    /// given up.
    pub fn want_simulation(&self, all: bool) {
        *lock(&self.wanted) = Some(all);
        self.called.notify_one();
    }

    /// Simulates whenever it is wanted, the newest text only.
    pub(super) fn simulate(bench: &Arc<Bench>) {
        loop {
            let mut wanted = lock(&bench.wanted);
            let all = loop {
                if let Some(all) = wanted.take() {
                    break all;
                }
                wanted = bench.called.wait(wanted).unwrap_or_else(PoisonError::into_inner);
            };
            drop(wanted);
            let (number, text, folder, name) = {
                let desk = lock(&bench.desk);
                (desk.number(), desk.text().to_owned(), desk.folder(), desk.name())
            };
            let part = &bench.setting.part.part;
            let loaded = bench.load(&text, &folder).map(|own| Arc::new(own.for_part(part)));
            let board = bench.helm.picture().1.identity.clone();
            let own = loaded.as_ref().ok().cloned();
            lock(&bench.programs).compiled(number, own, name.clone(), board.as_ref());
            bench.tell(&ToPage::Program(bench.program()));
            let (own, begun) = (bench.clone(), Instant::now());
            let ended = move |most: Duration| begun.elapsed() > most || lock(&own.wanted).is_some();
            let budget = if all {
                Budget::long(move |_| ended(LONG))
            } else {
                Budget::live(move |endless| ended(if endless { TURNS } else { LIVE }))
            };
            let (page, lines) = (bench.clone(), text.lines().count());
            let last = Cell::new(begun);
            let furthest = Cell::new(0);
            let budget = budget.telling(move |line, us| {
                furthest.set(furthest.get().max(line));
                if last.get().elapsed() < TELL {
                    return;
                }
                last.set(Instant::now());
                let line = furthest.get();
                page.tell(&ToPage::Simulating { number, line, lines, us });
            });
            let around = bench.around(name.as_deref(), &folder).unwrap_or_else(|words| Around {
                world: bench.setting.world.clone(),
                words: Some(words),
                pulses: Vec::new(),
                file: None,
            });
            let mut trial = trial::simulate(number, &loaded, &around.world, part, &budget);
            trial.about["world"] = json!(around.words);
            trial.about["pulses"] = json!(around.pulses);
            trial.about["world_file"] = json!(around.file);
            if lock(&bench.wanted).is_some() && trial.about["cut"] == true {
                continue;
            }
            let trial = Arc::new(trial);
            *lock(&bench.newest) = Some(trial.clone());
            for client in lock(&bench.clients).iter() {
                send_trial(client, &trial);
            }
        }
    }

    /// Finds out what the board's program is when this tool did not bring it: its name in the board's
    /// library, and the script of the folder that compiles to it.
    pub(super) fn recognise(bench: &Arc<Bench>, identity: Identity) {
        let named = bench.clone();
        let board = identity.clone();
        let asked = bench.helm.ask(User::new(), move |own| {
            let library = own.ok().and_then(|own| own.library().ok().flatten());
            let Some(library) = library else { return };
            let own = library.entries.into_iter().find(|entry| entry.number == library.selected);
            if let Some(entry) = own.filter(|entry| entry.crc == board.program_crc) {
                lock(&named.programs).named(&board, entry.name);
            }
        });
        // A user of its own has no other request that waits.
        let _ = asked;
        let bench = bench.clone();
        std::thread::spawn(move || {
            let (files, folder) = {
                let desk = lock(&bench.desk);
                (desk.files(), desk.folder())
            };
            for name in files {
                let text = lock(&bench.desk).read(&name);
                let loaded = text.and_then(|text| bench.load(&text, &folder));
                let Ok(loaded) = loaded.map(|own| own.for_part(identity.part())) else { continue };
                let unknown = || bench.on_board(&bench.helm.picture().1).is_none();
                if loaded.is(identity.program_bytes, identity.program_crc) && unknown() {
                    bench.stored(Arc::new(loaded), Some(name));
                    return;
                }
            }
        });
    }
}

/// Sends a simulation, and its path behind it.
pub(super) fn send_trial(client: &Client, trial: &Trial) {
    client.send(&ToPage::Simulated(trial.about.clone()));
    client.send_bytes(trial.path.clone());
}
