//! State that all pages share: script, simulation, board, and who has control.

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use lang::axis::Axis;
use lang::front::ProfileChoice;
use lang::profile::Profile;
use serde_json::{Value, json};

use super::around::Drawn;
use super::client::Client;
use super::desk::Desk;
use super::gate::Gate;
use super::message::{self, State, ToPage, Welcome};
use super::programs::{OnBoard, Programs};
use super::setup::Setup;
use super::simulation::send_trial;
use super::streamed::Streamed;
use crate::board::Build;
use crate::board::live::{Live, Touch};
use crate::helm::{Entry, Helm, Picture};
use crate::input;
use crate::sim::world::World;
use crate::trial::{self, Loaded, Trial};

/// Between two looks at the script's file.
const FILE_LOOK: Duration = Duration::from_millis(500);
/// States leave at most this often, and this seldom.
const STATE_SOON: Duration = Duration::from_millis(50);

/// What a start is given.
pub struct Setting {
    /// The machine that `--profile` names.
    pub profile: Option<Profile>,
    /// Where simulations look for switches and people.
    pub world: World,
    /// The part that simulations and the virtual board are.
    pub part: &'static Build,
    /// The virtual board, if it is one.
    pub live: Option<Arc<Live>>,
    /// Its name, or the port's.
    pub board: String,
    /// Which page it opens; the operator's serves nothing else.
    pub opens: Opens,
    /// Modbus address of the board, which a set-up may change.
    pub address: Arc<AtomicU8>,
}

/// The page that is opened first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Opens {
    /// All of it.
    Workbench,
    /// Only what a person at the machine needs.
    Operator,
    /// The set-up of a machine.
    Setup,
}

impl Setting {
    /// Whether pages get only what a person at the machine needs.
    pub fn is_operators(&self) -> bool {
        self.opens == Opens::Operator
    }
}

/// The shared state.
pub struct Bench {
    /// Who may come in.
    pub gate: Gate,
    /// The way to the board.
    pub helm: Helm,
    /// What it was started with.
    pub setting: Setting,
    /// The script.
    pub desk: Mutex<Desk>,
    /// Pages that have come in.
    pub(super) clients: Arc<Mutex<Vec<Arc<Client>>>>,
    /// Number of the page that has the helm.
    holder: Mutex<Option<u64>>,
    /// See [`Programs`].
    pub(super) programs: Mutex<Programs>,
    /// Inputs of the virtual board whose contact a hand has closed.
    closed: Mutex<Vec<u16>>,
    /// The newest simulation.
    pub(super) newest: Mutex<Option<Arc<Trial>>>,
    /// A simulation of the text is wanted; `true`: all of it.
    pub(super) wanted: Mutex<Option<bool>>,
    /// A simulation is wanted.
    pub(super) called: Condvar,
    /// The job that is fed to the board, if one is.
    pub(super) streamed: Mutex<Option<Streamed>>,
    /// See [`Drawn`].
    pub(super) drawn: Mutex<Drawn>,
    over: AtomicBool,
    /// A sequence of reference runs or a trial is under way.
    pub homing: AtomicBool,
    /// The trial of a set-up that is under way, in words.
    pub trial: Mutex<Option<String>>,
    /// The set-up that goes on.
    pub setup: Mutex<Option<Setup>>,
}

pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Bench {
    /// Puts everything together and starts the threads that simulate, look at the file and tell the
    /// pages how things stand.
    ///
    /// # Errors
    /// The script cannot be read.
    pub fn start(
        gate: Gate,
        helm: Helm,
        setting: Setting,
        file: Option<&str>,
    ) -> Result<Arc<Bench>, String> {
        let clients: Arc<Mutex<Vec<Arc<Client>>>> = Arc::default();
        let heard = clients.clone();
        let desk = Desk::open(file, setting.profile.clone(), move |message| {
            tell_of_language(&lock(&heard), message);
        })?;
        let bench = Arc::new(Bench {
            gate,
            helm,
            setting,
            desk: Mutex::new(desk),
            clients,
            holder: Mutex::default(),
            programs: Mutex::default(),
            closed: Mutex::default(),
            newest: Mutex::default(),
            wanted: Mutex::new(Some(false)),
            called: Condvar::new(),
            drawn: Mutex::default(),
            streamed: Mutex::default(),
            over: AtomicBool::new(false),
            homing: AtomicBool::new(false),
            trial: Mutex::default(),
            setup: Mutex::default(),
        });
        for work in [Bench::simulate, Bench::follow_file, Bench::tell_states] {
            let own = bench.clone();
            std::thread::spawn(move || work(&own));
        }
        Ok(bench)
    }

    /// A page proved who it is: what it needs to begin. It gets the helm if nobody has it.
    pub fn join(&self, client: &Arc<Client>) {
        client.welcome();
        lock(&self.holder).get_or_insert(client.number);
        let desk = lock(&self.desk);
        let machine = self.setting.profile.clone().or_else(|| Profile::built_in("mill").ok());
        let welcome = Welcome {
            version: env!("CARGO_PKG_VERSION"),
            virtual_board: self.setting.live.is_some(),
            operator: self.setting.is_operators(),
            board: self.setting.board.clone(),
            words: trial::words(),
            lsp: desk.capabilities().clone(),
            machine: machine.as_ref().map_or(Value::Null, |own| trial::machine(own, None)),
            files: desk.files(),
            text: desk.shown(),
        };
        drop(desk);
        client.send(&ToPage::Welcome(Box::new(welcome)));
        client.send(&ToPage::Program(self.program()));
        if let Some(trial) = lock(&self.newest).clone() {
            send_trial(client, &trial);
        }
        lock(&self.clients).push(client.clone());
        // The diagnostics of the present text are told anew.
        lock(&self.desk).refresh();
    }

    /// A page is gone: it lets go of the helm, and what it held stops.
    pub fn leave(&self, client: &Client) {
        self.helm.leave(client.user);
        lock(&self.clients).retain(|own| own.number != client.number);
        let mut holder = lock(&self.holder);
        if *holder == Some(client.number) {
            *holder = None;
        }
    }

    /// Gives a page the helm, or takes it away; what another page held stops.
    pub fn take_helm(&self, client: &Client, take: bool) {
        let mut holder = lock(&self.holder);
        let before = *holder;
        if take {
            *holder = Some(client.number);
        } else if before == Some(client.number) {
            *holder = None;
        }
        drop(holder);
        if let Some(before) = before.filter(|before| !take || *before != client.number) {
            let clients = lock(&self.clients);
            if let Some(other) = clients.iter().find(|other| other.number == before) {
                self.helm.leave(other.user);
            }
        }
    }

    /// Whether a page may act on the machine.
    pub fn has_helm(&self, client: &Client) -> bool {
        *lock(&self.holder) == Some(client.number)
    }

    /// Tells every page.
    pub fn tell(&self, message: &ToPage) {
        let text: Arc<str> = message::text(message).into();
        for client in lock(&self.clients).iter() {
            client.send_text(text.clone());
        }
    }

    /// Tells every page but one.
    pub fn tell_others(&self, but: &Client, message: &ToPage) {
        let text: Arc<str> = message::text(message).into();
        for client in lock(&self.clients).iter().filter(|client| client.number != but.number) {
            client.send_text(text.clone());
        }
    }

    /// The present text, compiled.
    ///
    /// # Errors
    /// It does not compile.
    pub fn compile(&self) -> Result<Loaded, String> {
        let (text, folder) = {
            let desk = lock(&self.desk);
            (desk.text().to_owned(), desk.folder())
        };
        self.load(&text, &folder)
    }

    /// A text, compiled for the machine that was given or the one that it names: a built-in one, or
    /// one that stands beside the script.
    ///
    /// # Errors
    /// It does not compile.
    pub fn load(&self, text: &str, folder: &Path) -> Result<Loaded, String> {
        let script = folder.join("script.bas").display().to_string();
        let find = |name: &str| input::profile_beside(name, &script).map(|(profile, _)| profile);
        let choice = match &self.setting.profile {
            Some(profile) => ProfileChoice::Given(Box::new(profile.clone())),
            None => ProfileChoice::Script(&find),
        };
        trial::load(text, choice)
    }

    /// A program was brought to the board, from a file of this name.
    pub fn stored(&self, loaded: Arc<Loaded>, name: Option<String>) {
        lock(&self.programs).brought(loaded, name);
        self.tell(&ToPage::Program(self.program()));
    }

    /// The board's program, where it is known, and whether it is the present text's.
    pub fn on_board(&self, picture: &Picture) -> Option<OnBoard> {
        let identity = picture.identity.as_ref()?;
        let number = lock(&self.desk).number();
        lock(&self.programs).on_board(identity, number)
    }

    /// The machine that is being set up, the one that was given, or that of the text.
    pub fn profile(&self) -> Result<Profile, String> {
        if let Some(setup) = &*lock(&self.setup) {
            return Ok(setup.machine());
        }
        if let Some(profile) = &self.setting.profile {
            return Ok(profile.clone());
        }
        match lock(&self.programs).of_text() {
            Some(loaded) => Ok(loaded.program.profile.clone()),
            None => {
                Profile::built_in(lang::profile::DEFAULT_NAME).map_err(|error| error.to_string())
            }
        }
    }

    pub(super) fn program(&self) -> Value {
        let (_, picture) = self.helm.picture();
        self.on_board(&picture).map_or(Value::Null, |OnBoard { loaded, .. }| {
            let machine = trial::machine(&loaded.program.profile, Some(&loaded.program));
            json!({ "vars": loaded.variables(), "crc": loaded.crc, "machine": machine })
        })
    }

    /// A hand on an input of the virtual board.
    ///
    /// # Errors
    /// The board is a real one.
    pub fn touch_input(&self, n: u16, on: bool) -> Result<(), String> {
        let live = self.setting.live.as_ref().ok_or("the board is a real one")?;
        let number = u8::try_from(n).ok().filter(|n| (1..=17).contains(n));
        live.touch(Touch::Input(number.ok_or("inputs count from 1 to 17")?, on));
        let mut closed = lock(&self.closed);
        closed.retain(|own| *own != n);
        if on {
            closed.push(n);
        }
        Ok(())
    }

    /// The tool shall end.
    pub fn end(&self) {
        lock(&self.desk).keep();
        self.tell(&ToPage::Bye);
        for client in lock(&self.clients).iter() {
            client.close();
        }
        self.over.store(true, Ordering::SeqCst);
    }

    /// Whether it shall.
    pub fn is_over(&self) -> bool {
        self.over.load(Ordering::SeqCst)
    }

    /// Tells the pages when another program changes the file.
    fn follow_file(bench: &Arc<Bench>) {
        loop {
            std::thread::sleep(FILE_LOOK);
            let mut desk = lock(&bench.desk);
            if !desk.look() {
                continue;
            }
            let text = desk.shown();
            drop(desk);
            bench.tell(&ToPage::Text(text));
            bench.want_simulation(false);
        }
    }

    /// Tells every page how things stand, and what happened.
    fn tell_states(bench: &Arc<Bench>) {
        let (mut seen, mut log) = (0, bench.helm.log(0).0);
        let mut homed: Vec<char> = Vec::new();
        let mut stored = None;
        for n in 1.. {
            let (number, picture) = bench.helm.wait(seen, STATE_SOON);
            seen = number;
            let entries;
            (log, entries) = bench.helm.log(log);
            bench.pass_on(entries);
            bench.place_world(&picture, &mut homed);
            let own = picture.identity.as_ref();
            let held = own.map(|own| (own.program_bytes, own.program_crc));
            if stored != held {
                stored = held;
                if bench.on_board(&picture).is_none()
                    && let Some(own) = own.filter(|own| own.program_bytes > 0)
                {
                    Bench::recognise(bench, own.clone());
                }
                bench.tell(&ToPage::Program(bench.program()));
            }
            bench.tell_state(n, &picture);
            std::thread::sleep(STATE_SOON / 2);
        }
    }

    fn pass_on(&self, entries: Vec<Entry>) {
        if entries.is_empty() {
            return;
        }
        for entry in &entries {
            if let Entry::Hold { id, why } = entry {
                self.tell(&ToPage::Ended { id: *id, words: why.clone() });
            }
        }
        self.tell(&ToPage::Log(entries));
    }

    /// The places of a world count from where the axes were referenced.
    fn place_world(&self, picture: &Picture, homed: &mut Vec<char>) {
        let (Some(live), Some(status)) = (&self.setting.live, &picture.status) else { return };
        for axis in Axis::ALL {
            let letter = axis.letter();
            let place = status.pos.get(axis).filter(|_| status.moving.is_empty());
            if status.homed.contains(&letter)
                && !homed.contains(&letter)
                && let Some(place) = place
            {
                live.touch(Touch::Homed(axis, place));
                homed.push(letter);
            }
        }
        homed.retain(|letter| status.homed.contains(letter) && !picture.homing.contains(letter));
    }

    fn tell_state(&self, n: u64, picture: &Picture) {
        let mut picture = picture.clone();
        let stream = self.show_streamed(&mut picture);
        let picture = &picture;
        let on_board = self.on_board(picture);
        let runs = picture.status.as_ref().filter(|status| {
            matches!(status.state, "running" | "paused" | "waitstart" | "stopping")
        });
        let line = on_board
            .as_ref()
            .zip(runs)
            .map(|(own, status)| own.loaded.line_of(status.program_counter))
            .filter(|line| *line > 0);
        let holds = picture.identity.as_ref().and_then(|own| lock(&self.programs).holds(own));
        let trial = lock(&self.trial).clone();
        let holder = *lock(&self.holder);
        let clients = lock(&self.clients).clone();
        let closed = lock(&self.closed).clone();
        for client in &clients {
            // A page that takes nothing misses states, never answers.
            if !client.is_idle() {
                continue;
            }
            let mine = holder == Some(client.number);
            client.state_leaves(n);
            client.send(&ToPage::State(Box::new(State {
                n,
                picture: picture.clone(),
                line,
                mine,
                taken: holder.is_some() && !mine,
                pages: clients.len(),
                closed: closed.clone(),
                current: on_board.as_ref().is_some_and(|own| own.current),
                holds: holds.clone(),
                trial: trial.clone(),
                stream: stream.clone(),
            })));
        }
    }
}

/// An answer goes to the page that asked, a notification to all.
fn tell_of_language(clients: &[Arc<Client>], mut message: Value) {
    let id = message["id"].as_str().map(str::to_owned);
    let Some(id) = id else {
        let text: Arc<str> = message::text(&ToPage::Lsp(message)).into();
        clients.iter().for_each(|client| client.send_text(text.clone()));
        return;
    };
    let Some((page, own)) = id.split_once('/') else { return };
    let (Ok(page), Ok(own)) = (page.parse::<u64>(), serde_json::from_str::<Value>(own)) else {
        return;
    };
    message["id"] = own;
    if let Some(client) = clients.iter().find(|client| client.number == page) {
        client.send(&ToPage::Lsp(message));
    }
}
