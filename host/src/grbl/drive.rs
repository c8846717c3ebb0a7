//! The thread that owns the board: it feeds it with a session's lines, carries out what is wanted at
//! once, and shows how it stands.
//!
//! All lines that follow one another closely are one streamed run ([`crate::stream::pump`]), so motion
//! goes on from line to line. A run ends when nothing has come for a while and nothing is switched on.

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
use super::order::{Order, Writer};
use super::settings::Machine;
use crate::client::identity::must_match;
use crate::client::stream::{Slots, Standing};
use crate::client::{Client, ClientError};
use crate::link::Link;
use crate::stream::chain::Chain;
use crate::stream::feed::Feed;
use crate::stream::job::{Job, More};
use crate::stream::pump::{self, PumpError};

/// Lines of a batch: few enough that the first of them moves soon.
const BATCH: usize = 64;
/// Longest wait for a line while the board runs.
const SOON: Duration = Duration::from_millis(4);
/// Between two looks at a board that runs nothing of ours.
const LOOK: Duration = Duration::from_millis(60);
/// Between two looks at inputs while it runs.
const INPUTS: Duration = Duration::from_millis(120);
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
    looks: Looks,
    /// The board's state at the last look.
    state: Option<RunState>,
}

/// What is remembered from look to look.
#[derive(Default)]
struct Looks {
    /// When and where the last one was.
    place: Option<(Instant, [f64; 3])>,
    speed: f64,
    inputs_at: Option<Instant>,
    inputs: u32,
    limits: u8,
    moving: bool,
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
            looks: Looks::default(),
            state: None,
        }
    }

    /// Works until the desk is closed; then what it runs comes to its end as by a stop.
    pub fn run(mut self) {
        loop {
            let wants = self.desk.wants();
            if wants.closing {
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
        // Somebody else's run: what stops and holds is for it, too.
        let control = match standing.state {
            _ if wants.stops != self.stops && runs => Some(Control::Stop),
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
        let handed = Cell::new(*newest);
        let run = Run {
            drive: RefCell::new(self),
            rests: Cell::new(None),
            handed: &handed,
            broken: RefCell::new(None),
        };
        let outcome = run.pump(&mut client, slots, &lines);
        let (broken, before) = (run.broken.into_inner(), handed.get());
        self.handed = before;
        match outcome {
            Ok(()) => {}
            Err(PumpError::Busy) => {
                self.board = Some((client, slots));
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

/// A run of the board.
struct Run<'a, L: Link> {
    drive: RefCell<&'a mut Drive<L>>,
    /// Since when all that came is done.
    rests: Cell<Option<Instant>>,
    handed: &'a Cell<u32>,
    /// Why lines could not be made a program; none of them can be wrong, so this is a defect.
    broken: RefCell<Option<String>>,
}

impl<L: Link> Run<'_, L> {
    fn pump(
        &self,
        client: &mut Client<L>,
        slots: Slots,
        lines: &[(u32, Vec<Order>)],
    ) -> Result<(), PumpError> {
        let profile = self.drive.borrow().profile.clone();
        let desk = self.drive.borrow().desk.clone();
        let stops = self.drive.borrow().stops;
        let broke = |words: String| *self.broken.borrow_mut() = Some(words);
        let first = match made(lines, &profile) {
            Ok(compiled) => Chain::new(compiled),
            Err(words) => {
                broke(words);
                return Ok(());
            }
        };
        let feed = match Feed::new(first.compiled()) {
            Ok(feed) => feed,
            Err(flaw) => {
                broke(flaw.text);
                return Ok(());
            }
        };
        let (source, profile, broke) = (&desk, &profile, &broke);
        let mut end = &first;
        let mut job = Job::new(feed, slots.bytes.into());
        job.follow_with(Box::new(move || {
            let wants = source.wants();
            if wants.stops != stops || wants.closing || self.broken.borrow().is_some() {
                return More::Over;
            }
            // A hold begins at once: what has not gone to the board yet stays here.
            if wants.hold {
                std::thread::sleep(SOON);
                return More::Wait;
            }
            let lines = source.lines(BATCH, stops, SOON);
            let Some((newest, _)) = lines.last() else {
                let rested = self.rests.get().is_some_and(|since| since.elapsed() > IDLE);
                return if rested && !wants.stay { More::Over } else { More::Wait };
            };
            self.rests.set(None);
            self.handed.set(*newest);
            let compiled = match made(&lines, profile) {
                Ok(compiled) => compiled,
                Err(words) => {
                    broke(words);
                    return More::Over;
                }
            };
            end = end.push(compiled);
            match Feed::new(end.compiled()) {
                Ok(feed) => More::Feed(feed),
                Err(flaw) => {
                    broke(flaw.text);
                    More::Over
                }
            }
        }));
        let mut watch = |progress: &pump::Progress| {
            let wants = desk.wants();
            let state = progress.state;
            if wants.closing || wants.stops != stops || self.broken.borrow().is_some() {
                return Some(Control::Stop);
            }
            if wants.resume {
                let control = match state {
                    Some(RunState::Paused) => Some(Control::Resume),
                    Some(RunState::WaitStart) => Some(Control::Start),
                    _ => None,
                };
                // While it still ramps down the wish stays.
                if state != Some(RunState::Stopping) {
                    desk.settle(|wants| wants.resume = false);
                }
                return control;
            }
            // Said until it holds: before the first piece has begun a board does not hear it.
            (wants.hold && state == Some(RunState::Running)).then_some(Control::Pause)
        };
        let mut observe = |client: &mut Client<L>, standing: &Standing, at: &pump::Progress| {
            now(client, &desk.wants(), &desk)?;
            self.observe(client, standing, at)
        };
        let print: pump::Printer<'_> = &mut |_| ();
        pump::run_observed(client, &mut job, slots, &mut watch, Some(print), &mut observe)
            .map(drop)
    }

    fn observe(
        &self,
        client: &mut Client<L>,
        standing: &Standing,
        at: &pump::Progress,
    ) -> Result<(), ClientError> {
        let mut drive = self.drive.borrow_mut();
        drive.looks.inputs(client)?;
        let mut rests = at.dry && standing.commanded == standing.steps;
        if at.dry && !rests {
            // Behind a probe or a correction the two may differ for good.
            let moved = drive.looks.moving;
            drive.looks.inputs_now(client)?;
            rests = !moved && !drive.looks.moving && drive.looks.stands(standing.steps, &drive.machine);
        }
        let handed = self.handed.get();
        let mut probed = None;
        if rests && self.rests.get().is_none() {
            self.rests.set(Some(Instant::now()));
            drive.looks.speed = 0.0;
            let words = client.input(wire::PROBE_RESULT, 6)?;
            let miss = client.input(wire::PROBE_ERROR, 1)?[0] & 0xFF;
            let long = |n: usize| crate::client::status::long(words[2 * n], words[2 * n + 1]);
            probed = Some(([0, 1, 2].map(long), miss == 0));
        }
        let begun = if standing.begun > 0 { at.line } else { 0 };
        drive.show(standing, true, |view| {
            view.begun = view.begun.max(begun.min(handed));
            if rests {
                (view.begun, view.done) = (handed, handed);
            }
            if let Some((place, met)) = probed {
                (view.probed, view.met) = (place, met);
            }
        });
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
        let done = wants.coils.len();
        let overrides = wants.overrides;
        desk.settle(|now| {
            now.acknowledge &= !wants.acknowledge;
            now.coils.drain(..done);
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

impl Looks {
    /// Speed from two places and their times, mm/min.
    fn pace(&mut self, place: [f64; 3]) {
        let now = Instant::now();
        if let Some((then, before)) = self.place {
            let time = now.duration_since(then).as_secs_f64();
            if time < 0.04 {
                return;
            }
            let way: f64 = place.iter().zip(before).map(|(a, b)| (a - b).powi(2)).sum();
            self.speed = if time < 1.0 { way.sqrt() / time * 60.0 } else { 0.0 };
        }
        self.place = Some((now, place));
    }

    /// Whether the axes were there at the last look, too.
    fn stands(&self, steps: [i32; 3], machine: &Machine) -> bool {
        self.place.is_some_and(|(_, before)| before == machine.place(steps))
    }

    /// Reads inputs and what moves, if it is time.
    fn inputs<L: Link>(&mut self, client: &mut Client<L>) -> Result<(), ClientError> {
        if self.inputs_at.is_none_or(|at| at.elapsed() > INPUTS) {
            self.inputs_now(client)?;
        }
        Ok(())
    }

    fn inputs_now<L: Link>(&mut self, client: &mut Client<L>) -> Result<(), ClientError> {
        let count = wire::LIMITS - wire::INPUTS + 1;
        let words = client.input(wire::INPUTS, count)?;
        let at = |register: u16| words[usize::from(register - wire::INPUTS)];
        self.inputs = u32::from(at(wire::INPUTS)) | u32::from(at(wire::INPUTS_HIGH)) << 16;
        self.moving = (at(wire::MOVING) | at(wire::HOMING)) & 0xFF != 0;
        let limits = at(wire::LIMITS);
        self.limits = (limits | limits >> 8) as u8;
        self.inputs_at = Some(Instant::now());
        Ok(())
    }
}

/// Makes a program of lines; its statements have the numbers of the client's lines.
fn made(lines: &[(u32, Vec<Order>)], profile: &Profile) -> Result<Compiled, String> {
    let mut writer = Writer::new();
    for (number, orders) in lines {
        for order in orders {
            writer.put(*number, order);
        }
    }
    let (text, numbers) = writer.finish();
    let mut compiled = compiled(&text, profile)?;
    for mark in &mut compiled.sidecar.marks {
        let line = usize::try_from(mark.line).unwrap_or(0).saturating_sub(1);
        mark.line = numbers.get(line).copied().unwrap_or(0);
    }
    Ok(compiled)
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
