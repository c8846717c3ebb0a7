//! The thread that owns the board: it feeds a session's lines, executes real-time commands, and updates
//! the state.
//!
//! Lines that follow one another closely are one streamed run ([`crate::stream::pump`]), so motion
//! goes on from line to line. A run ends when no line has come for a while and nothing is switched on.

mod looks;
mod run;

use std::cell::{Cell, RefCell};
use std::sync::Arc;
use std::time::{Duration, Instant};

use lang::back::Compiled;
use lang::fault::Fault;
use lang::front::source::Source as Text;
use lang::front::{ProfileChoice, compile};
use lang::profile::Profile;
use lang::wire::{self, Control, End, Exception, RunState};

use super::desk::{Desk, View, Wants};
use super::settings::Machine;
use crate::client::identity::must_match;
use crate::client::stream::{Slots, Standing};
use crate::client::{Client, ClientError};
use crate::link::Link;
use crate::stream::pump::PumpError;
use looks::Looks;
use run::Run;

/// Lines of a batch: few enough that the first of them moves soon.
const BATCH: usize = 64;
/// Between two looks at a board that runs nothing of ours.
const LOOK: Duration = Duration::from_millis(60);
/// A run that rests for so long without a line is over, unless something is on.
const IDLE: Duration = Duration::from_secs(3);
/// Between two tries to open the port.
const AGAIN: Duration = Duration::from_millis(500);
/// What the job that ended left no number for.
const SETTLE: Duration = Duration::from_secs(10);

/// Opens the way to the board; called again whenever it was lost. The text says why it cannot.
pub type Open<L> = Box<dyn FnMut() -> Result<Client<L>, String> + Send>;

/// See the module.
pub struct Drive<L: Link> {
    desk: Arc<Desk>,
    profile: Profile,
    machine: Arc<Machine>,
    open: Open<L>,
    board: Option<(Client<L>, Slots)>,
    /// Stops that have been carried out.
    stops: u32,
    /// The newest line that the board got.
    handed: u32,
    /// A run of ours was lost with its board and may go on there: it is stopped as soon as the board answers. What the
    /// board counts its runs to while it is this one; another one is somebody else's.
    orphan: Option<u16>,
    looks: Looks,
    /// The board's state at the last look.
    state: Option<RunState>,
}

impl<L: Link> Drive<L> {
    /// For the machine of a profile.
    pub fn new(desk: Arc<Desk>, profile: Profile, open: Open<L>) -> Drive<L> {
        let machine = Arc::new(Machine::of(&profile));
        Drive {
            desk,
            profile,
            machine,
            open,
            board: None,
            stops: 0,
            handed: 0,
            orphan: None,
            looks: Looks::default(),
            state: None,
        }
    }

    /// Works until the desk is closed; then what it runs comes to its end as by a stop.
    pub fn run(mut self) {
        loop {
            let wants = self.desk.wants();
            if wants.closing {
                // What the last stop switches off. Nobody is left who could be told that it failed.
                if let Some((client, _)) = &mut self.board {
                    let _ = now(client, &wants, &self.desk);
                }
                return;
            }
            if self.board.is_none() && !self.connect() {
                // Without a board every stop has been carried out.
                self.stopped(&wants, |_| {});
                self.desk.lines_wait(self.stops, AGAIN);
                continue;
            }
            if let Err(error) = self.once(&wants) {
                self.lose(&error);
            }
        }
    }

    fn connect(&mut self) -> bool {
        let opened = (self.open)().and_then(|mut client| {
            let words = |error: ClientError| error.to_string();
            must_match(&client.board_record().map_err(words)?, &self.profile)?;
            let slots = client.stream_slots().map_err(words)?;
            let slots = slots.ok_or("its firmware has no feature stream: it cannot be fed")?;
            Ok((client, slots))
        });
        match opened {
            Ok(board) => {
                self.board = Some(board);
                self.desk.show(|view| view.trouble = None);
                true
            }
            Err(words) => {
                self.trouble(&words);
                false
            }
        }
    }

    fn lose(&mut self, words: &str) {
        self.board = None;
        self.trouble(words);
    }

    fn trouble(&mut self, words: &str) {
        self.desk.forget();
        let handed = self.handed;
        self.desk.show(|view| {
            if view.trouble.is_none() {
                view.epoch += 1;
                view.trouble = Some(words.to_owned());
            }
            (view.begun, view.done, view.ours, view.moving) = (handed, handed, false, false);
            view.state = None;
        });
    }

    /// One round beside a run of ours.
    fn once(&mut self, wants: &Wants) -> Result<(), String> {
        let words = |error: ClientError| error.to_string();
        let Some((client, _)) = &mut self.board else { return Ok(()) };
        now(client, wants, &self.desk).map_err(words)?;
        let standing = client.stream_standing().map_err(words)?;
        self.looks.inputs(client).map_err(words)?;
        let runs = matches!(
            standing.state,
            Some(RunState::Running | RunState::Paused | RunState::Stopping | RunState::WaitStart)
        );
        // Others that ask the board (by a gateway) keep it from ending the lost run by itself (F18).
        self.orphan = self.orphan.filter(|own| runs && *own == standing.runs);
        // Somebody else's run: what stops and holds is for it, too.
        let control = match standing.state {
            _ if (self.orphan.is_some() || wants.stops != self.stops) && runs => {
                Some(Control::Stop)
            }
            Some(RunState::Running) if wants.hold => Some(Control::Pause),
            Some(RunState::Paused) if wants.resume => Some(Control::Resume),
            Some(RunState::WaitStart) if wants.resume => Some(Control::Start),
            _ => None,
        };
        if let Some(control) = control {
            tolerant(client.control(control)).map_err(words)?;
        }
        if wants.resume {
            self.desk.settle(|wants| wants.resume = false);
        }
        let fault = standing.state == Some(RunState::Fault) && self.state != standing.state;
        self.state = standing.state;
        self.show(&standing, false, |_| {});
        if wants.stops != self.stops {
            if !runs || control.is_none() {
                self.stopped(wants, |_| {});
            }
            return Ok(());
        }
        if self.orphan.is_some() {
            return Ok(());
        }
        if fault {
            self.failed(u8::try_from(standing.fault).ok().and_then(Fault::from_number));
            return Ok(());
        }
        let waits = self.desk.has_lines();
        let free = !runs && standing.state != Some(RunState::Fault) && !wants.hold;
        self.desk.show(|view| view.blocked = waits && free && standing.blocking != 0);
        if waits && free && standing.blocking == 0 {
            return self.feed(standing.runs);
        }
        if waits && !free && !wants.hold {
            // The board is taken: the session has been told by its view.
            self.desk.forget();
            self.failed(None);
            return Ok(());
        }
        // A hold that waits with lines must not spin.
        if waits {
            std::thread::sleep(LOOK);
        } else {
            self.desk.lines_wait(self.stops, LOOK);
        }
        Ok(())
    }

    /// Shows how the machine stands, and more, in one picture.
    fn show(&mut self, standing: &Standing, ours: bool, more: impl FnOnce(&mut View)) {
        let place = self.machine.place(standing.steps);
        self.looks.pace(place);
        if !ours && !self.looks.moving {
            self.looks.speed = 0.0;
        }
        let looks = &self.looks;
        self.desk.show(|view| {
            view.steps = standing.steps;
            view.state = standing.state;
            view.ours = ours;
            view.moving = looks.moving;
            view.homed = [0, 1, 2].map(|i| standing.homed >> i & 1 != 0);
            view.speed = looks.speed;
            (view.inputs, view.limits) = (looks.inputs, looks.limits);
            more(view);
        });
    }

    /// The stops that were wanted have come to rest.
    fn stopped(&mut self, wants: &Wants, more: impl FnOnce(&mut View)) {
        if wants.stops == self.stops {
            return;
        }
        self.stops = wants.stops;
        let (stops, handed) = (self.stops, self.handed);
        self.desk.show(|view| {
            view.stops = stops;
            view.epoch += 1;
            (view.begun, view.done) = (handed, handed);
            more(view);
        });
    }

    /// What ran has ended with a fault, or by somebody else.
    fn failed(&mut self, fault: Option<Fault>) {
        self.desk.forget();
        let handed = self.handed;
        self.desk.show(|view| {
            view.faults += 1;
            view.fault = fault;
            view.epoch += 1;
            (view.begun, view.done) = (handed, handed);
        });
    }

    /// One run of the board, from the first lines to where none follow.
    fn feed(&mut self, runs: u16) -> Result<(), String> {
        let lines = self.desk.lines(BATCH, self.stops, Duration::ZERO);
        let Some((newest, _)) = lines.last() else { return Ok(()) };
        let Some((mut client, slots)) = self.board.take() else { return Ok(()) };
        self.orphan = Some(runs.wrapping_add(1));
        let handed = Cell::new(*newest);
        let run = Run {
            drive: RefCell::new(self),
            rests: Cell::new(None),
            handed: &handed,
            probes: Default::default(),
            printed: RefCell::default(),
            broken: RefCell::new(None),
        };
        let outcome = run.pump(&mut client, slots, &lines);
        let (broken, before) = (run.broken.into_inner(), handed.get());
        self.handed = before;
        match outcome {
            Ok(()) => {}
            Err(PumpError::Busy) => {
                self.board = Some((client, slots));
                self.orphan = None;
                // A button, or somebody else's program, came first.
                return self.refused(PumpError::Busy.to_string());
            }
            Err(error) => return Err(error.to_string()),
        }
        let words = |error: ClientError| error.to_string();
        let mut standing = client.stream_standing().map_err(words)?;
        self.looks.inputs(&mut client).map_err(words)?;
        let begun = Instant::now();
        while self.looks.moving && begun.elapsed() < SETTLE {
            standing = client.stream_standing().map_err(words)?;
            self.looks.inputs_now(&mut client).map_err(words)?;
        }
        self.board = Some((client, slots));
        self.orphan = None;
        self.state = standing.state;
        self.looks.speed = 0.0;
        let wants = self.desk.wants();
        let ended = standing.runs != runs;
        let end = standing.end.filter(|_| ended);
        let done = end == Some(End::Done) && broken.is_none();
        if wants.stops != self.stops && end != Some(End::Fault) {
            let stops = wants.stops;
            self.stops = stops;
            self.show(&standing, false, |view| {
                view.stops = stops;
                view.epoch += 1;
                (view.begun, view.done) = (before, before);
            });
            return Ok(());
        }
        self.show(&standing, false, |view| {
            if done {
                (view.begun, view.done) = (before, before);
            }
        });
        match (done, end) {
            (true, _) => {}
            (_, Some(End::Fault)) => {
                self.failed(u8::try_from(standing.fault).ok().and_then(Fault::from_number));
            }
            _ => self.failed(None),
        }
        if let Some(words) = broken {
            eprintln!("pasapas: grbl: {words}");
        }
        Ok(())
    }

    fn refused(&mut self, words: String) -> Result<(), String> {
        eprintln!("pasapas: grbl: {words}");
        self.failed(None);
        Ok(())
    }
}

/// What is wanted at once, whatever runs.
fn now<L: Link>(client: &mut Client<L>, wants: &Wants, desk: &Desk) -> Result<(), ClientError> {
    if let [Some(percent), _] = wants.overrides {
        tolerant(client.write(wire::OVERRIDES, percent))?;
    }
    if let [_, Some(percent)] = wants.overrides {
        tolerant(client.write(wire::OVERRIDES + 1, percent))?;
    }
    for (n, on) in &wants.coils {
        tolerant(client.set_coil(wire::COILS + n - 1, *on))?;
    }
    if wants.acknowledge {
        tolerant(client.write(wire::RUN_CONTROL, Control::Acknowledge as u16))?;
    }
    if wants.acknowledge || !wants.coils.is_empty() || wants.overrides != [None; 2] {
        let overrides = wants.overrides;
        desk.settle(|now| {
            now.acknowledge &= !wants.acknowledge;
            // What came meanwhile stays.
            now.coils.retain(|own| !wants.coils.contains(own));
            for (held, written) in now.overrides.iter_mut().zip(overrides) {
                if *held == written {
                    *held = None;
                }
            }
        });
    }
    Ok(())
}

/// A refusal of the board is no loss of it: its state tells what came of it.
fn tolerant(result: Result<(), ClientError>) -> Result<(), ClientError> {
    match result {
        Err(error)
            if error.is_exception(Exception::Busy)
                || error.is_exception(Exception::IllegalValue)
                || error.is_exception(Exception::DeviceFailure) =>
        {
            Ok(())
        }
        other => other,
    }
}

/// Compiles a text for a machine.
///
/// # Errors
/// The first thing that is wrong, in words.
pub(super) fn compiled(text: &str, profile: &Profile) -> Result<Compiled, String> {
    let source = Text::new("grbl", text.to_owned());
    let choice = ProfileChoice::Given(Box::new(profile.clone()));
    let (program, found) = compile(&source, choice);
    let program = program.ok_or_else(|| {
        let errors = found.into_sorted();
        errors.first().map_or_else(String::new, |diag| diag.message.clone())
    })?;
    lang::back::compile(&program).map_err(|_| "it is too long".to_owned())
}

#[cfg(test)]
mod tests;
