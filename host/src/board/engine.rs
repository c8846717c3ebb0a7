//! Engine `board`: a script on the emulated board, through the same client as on a real one.

use std::cell::RefCell;
use std::fmt;
use std::io::Write;
use std::rc::Rc;
use std::time::Duration;

use emulator::{LoadError, VcdWriter};
use firmware::motion::physics::Count;
use lang::axis::Axis;
use lang::back::Sidecar;
use lang::fault::Fault;
use lang::hir::Program;
use lang::record::BoardRecord;
use lang::wire::{self, Control, RunState};

use super::Build;
use super::health::Health;
use super::judge::Judge;
use super::link::InProcess;
use super::path::PathRecorder;
use super::rig::{HostAction, Rig, TICKS_PER_US};
use super::stuck;
use crate::client::trace::Tracer;
use crate::client::upload::UploadError;
use crate::client::{Client, ClientError, Patience};
use crate::link::Link;
use crate::sim::record::{Edge, OutputUse, Record, Summary};
use crate::sim::trace::{Event, Status, What};
use crate::sim::world::{Registers, World, WorldError};
use crate::sim::{End, Options, Outcome};

/// Simulated time between two looks for an event.
const LOOK: Duration = Duration::from_millis(1);
/// A request that the board loses while it erases flash is asked again soon.
const RUN_PATIENCE: Patience = Patience { reply: Duration::from_millis(50), attempts: 20 };
/// How long Start is held.
const PRESS: Duration = Duration::from_millis(100);
/// Longest time from the press to the first statement: filter and image check.
const START_PATIENCE: Duration = Duration::from_secs(2);
/// Longest time that a stop may take: a ramp from the top rate of a slow machine.
const STOP_PATIENCE: Duration = Duration::from_secs(60);

/// What is to run.
pub struct Job<'a> {
    /// The firmware that is to run it.
    pub build: &'a Build,
    /// The checked script, for its machine.
    pub program: &'a Program,
    /// Its image.
    pub image: &'a [u8],
    /// Line of an address in its code.
    pub line_of: &'a dyn Fn(u16) -> u32,
    /// Everything around the board.
    pub world: &'a World,
    /// Limits of the run.
    pub options: &'a Options,
}

/// Where a run writes while it runs.
pub struct Sinks<'a> {
    /// Gets each line of the trace.
    pub trace: &'a mut dyn FnMut(&Event),
    /// Gets every edge at the pins as a Value Change Dump.
    pub vcd: Option<&'a mut dyn Write>,
    /// Hears the simulated time, us.
    pub progress: &'a mut dyn FnMut(u64),
}

/// A run on the board.
pub struct BoardRun {
    /// As of every engine.
    pub outcome: Outcome,
    /// What the emulator noticed: broken driver limits, accesses that the chip forbids.
    pub remarks: Vec<String>,
    /// How the board fared.
    pub health: Health,
    /// Moves and steps that were held to the profile's ramps and rates; what broke them is among the
    /// outcome's failures.
    pub judged: Count,
}

/// Why there is no run.
#[derive(Debug)]
pub enum BoardError {
    /// The shipped firmware is damaged.
    Firmware(LoadError),
    /// The world's script fails.
    World(WorldError),
    /// The board did not take the program.
    Upload(UploadError),
    /// The link to the board fails.
    Client(ClientError),
    /// The board did not do what it was told.
    Board(String),
    /// The VCD cannot be written.
    Vcd(std::io::Error),
}

impl fmt::Display for BoardError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BoardError::Firmware(error) => write!(f, "the firmware image is damaged: {error}"),
            BoardError::World(error) => error.fmt(f),
            BoardError::Upload(error) => error.fmt(f),
            BoardError::Client(error) => error.fmt(f),
            BoardError::Board(text) => f.write_str(text),
            BoardError::Vcd(error) => write!(f, "the VCD cannot be written: {error}"),
        }
    }
}

impl std::error::Error for BoardError {}

impl From<ClientError> for BoardError {
    fn from(error: ClientError) -> BoardError {
        BoardError::Client(error)
    }
}

impl From<WorldError> for BoardError {
    fn from(error: WorldError) -> BoardError {
        BoardError::World(error)
    }
}

impl From<UploadError> for BoardError {
    fn from(error: UploadError) -> BoardError {
        BoardError::Upload(error)
    }
}

/// Starts a board, brings it profile and program, presses Start and follows the run to its end.
///
/// # Errors
/// See [`BoardError`]. A fault of the script is no error: it is the outcome's end.
pub fn run<'a>(job: &'a Job<'_>, sinks: Sinks<'a>) -> Result<BoardRun, BoardError> {
    let firmware = job.build.image().map_err(BoardError::Firmware)?;
    let registers = Registers::on_board(job.program);
    let rig = Rig::new(job.build, &firmware, &job.program.profile, job.world, &registers)?;
    let rig = Rc::new(RefCell::new(rig));
    let mut client = Client::new(InProcess::new(Rc::clone(&rig)), 1);
    client.find()?;
    prepare(&mut client, &rig, job)?;
    let mut run = Run::new(job, sinks, rig, client)?;
    run.start()?;
    let end = run.follow()?;
    run.finish(end)
}

/// Runs a program of which nothing but the trace is wanted on the way; `sidecar` tells the lines of
/// `image`.
///
/// # Errors
/// Those of [`run`].
pub fn run_traced(
    build: &Build,
    program: &Program,
    image: &[u8],
    sidecar: &Sidecar,
    world: &World,
    options: &Options,
) -> Result<(BoardRun, Vec<Event>), BoardError> {
    let line_of = |pc: u16| sidecar.at(usize::from(pc)).map_or(0, |mark| mark.line);
    let job = Job { build, program, image, line_of: &line_of, world, options };
    let mut trace = Vec::new();
    let sinks = Sinks {
        trace: &mut |event: &Event| trace.push(event.clone()),
        vcd: None,
        progress: &mut |_| {},
    };
    let run = run(&job, sinks)?;
    Ok((run, trace))
}

/// Profile, program and trace mode.
fn prepare(
    client: &mut Client<InProcess>,
    rig: &RefCell<Rig>,
    job: &Job<'_>,
) -> Result<(), BoardError> {
    let held = client.board_record()?;
    let wanted = BoardRecord::of(&job.program.profile, held.sequence.wrapping_add(1));
    if !crate::client::identity::differences(&held, &wanted).is_empty() {
        client.set_board_record(&wanted)?;
        client.restart()?;
        // The chip restarts by a wrong watchdog key, which the emulator would mention.
        rig.borrow_mut().board().clear_warnings();
        rig.borrow_mut().follow_uart();
        client.set_address(wanted.address);
        client.find()?;
    }
    client.upload(job.image, false, &mut |_| {})?;
    client.write(wire::TRACE_MODE, 1)?;
    client.set_patience(RUN_PATIENCE);
    Ok(())
}

/// A run under way.
struct Run<'a, 'b> {
    job: &'a Job<'b>,
    rig: Rc<RefCell<Rig>>,
    client: Client<InProcess>,
    trace: &'a mut dyn FnMut(&Event),
    progress: &'a mut dyn FnMut(u64),
    vcd: Option<VcdWriter<&'a mut dyn Write>>,
    path: PathRecorder,
    judge: Judge,
    outputs: Vec<Edge>,
    inputs: Vec<Edge>,
}

impl<'a, 'b> Run<'a, 'b> {
    fn new(
        job: &'a Job<'b>,
        sinks: Sinks<'a>,
        rig: Rc<RefCell<Rig>>,
        client: Client<InProcess>,
    ) -> Result<Run<'a, 'b>, BoardError> {
        let vcd = match sinks.vcd {
            None => None,
            Some(out) => {
                let mut rig = rig.borrow_mut();
                let signals = rig.board().plant().signals();
                let now = rig.now();
                Some(VcdWriter::new(out, &signals, now).map_err(BoardError::Vcd)?)
            }
        };
        rig.borrow_mut().board().record(true);
        let judge = Judge::new(&job.program.profile, rig.borrow().plant());
        let Sinks { trace, progress, .. } = sinks;
        let path = PathRecorder::default();
        let (outputs, inputs) = (Vec::new(), Vec::new());
        Ok(Run { job, rig, client, trace, progress, vcd, path, judge, outputs, inputs })
    }

    /// Presses Start until the program runs; the world's time begins there.
    fn start(&mut self) -> Result<(), BoardError> {
        if self.job.build.part.keeps_at {
            let written = self.rig.borrow_mut().take_registers();
            for (register, value) in written {
                self.write_register(register, value)?;
            }
        }
        let (_, runs) = self.client.run_state()?;
        let pressed = self.client.link().now();
        self.rig.borrow_mut().board().plant_mut().press_start(true);
        loop {
            let (_, now) = self.client.run_state()?;
            if now != runs {
                break;
            }
            if self.client.link().now() > pressed + START_PATIENCE {
                let status = self.client.status()?;
                let fault = status.fault.unwrap_or_default();
                return Err(BoardError::Board(format!(
                    "the program did not start; the board is {} {fault}",
                    status.state
                )));
            }
        }
        self.rig.borrow_mut().begin();
        self.release_start_after(pressed + PRESS)
    }

    /// Start is let go at its time, by hand: the scenario has buttons of its own.
    fn release_start_after(&mut self, time: Duration) -> Result<(), BoardError> {
        self.path.start(&self.rig.borrow());
        let left = time.saturating_sub(self.client.link().now());
        self.path.release_start_at =
            Some(self.rig.borrow().now() + left.as_micros() as u64 * TICKS_PER_US);
        Ok(())
    }

    /// Takes events until the last one.
    fn follow(&mut self) -> Result<What, BoardError> {
        let profile = &self.job.program.profile;
        let mut tracer = Tracer::new(profile, self.job.line_of);
        let mut watch = stuck::Watch::default();
        let mut stopping: Option<Duration> = None;
        let mut idle = false;
        loop {
            let what = tracer.poll(&mut self.client)?;
            self.look()?;
            match what {
                Some(what) => {
                    idle = false;
                    watch.something_happened(self.rig.borrow().us());
                    if let What::Home { axis, pos, .. } = what {
                        self.rig.borrow_mut().homed(axis.0, pos);
                    }
                    self.path.event(&what);
                    let us = self.job.options.times.then(|| self.rig.borrow().us());
                    let event = Event { what, us };
                    (self.trace)(&event);
                    if matches!(event.what, What::End { .. }) {
                        return Ok(event.what);
                    }
                }
                // The first look after an event only tells the board that it was received.
                None if !idle => idle = true,
                None => {
                    self.client.link().pause(LOOK);
                    self.look()?;
                }
            }
            self.host_actions()?;
            let now = self.client.link().now();
            match stopping {
                Some(since) if now > since + STOP_PATIENCE => {
                    let status = self.client.status()?;
                    return Err(BoardError::Board(format!(
                        "the board does not end the run: it is {}, axes {:?} move, {} of the \
                         statements' code",
                        status.state, status.moving, status.program_counter
                    )));
                }
                Some(_) => {}
                None if self.is_over(&mut watch)? => {
                    self.client.control(Control::Stop)?;
                    stopping = Some(now);
                }
                None => {}
            }
        }
    }

    /// The limit is reached, or nothing can happen any more.
    fn is_over(&mut self, watch: &mut stuck::Watch) -> Result<bool, BoardError> {
        let us = self.rig.borrow().us();
        if us >= self.job.options.limit_us || (self.job.options.interrupted)() {
            return Ok(true);
        }
        let world_is_over = self.rig.borrow().world_is_over();
        let pulses = self.rig.borrow().pulses();
        if !world_is_over {
            // What the world does last may still be on its way through the input's filter.
            watch.something_happened(us);
            return Ok(false);
        }
        if !watch.is_quiet(us, pulses) {
            return Ok(false);
        }
        let status = self.client.status()?;
        if !status.moving.is_empty() {
            return Ok(false);
        }
        let line = (self.job.line_of)(status.program_counter);
        Ok(match status.run_state {
            Some(RunState::Paused) => true,
            Some(RunState::WaitStart) => !stuck::has_ticks(self.job.program),
            Some(RunState::Running) => stuck::waits_for_ever(self.job.program, line),
            _ => false,
        })
    }

    /// What happened at the pins since the last look.
    fn look(&mut self) -> Result<(), BoardError> {
        let mut rig = self.rig.borrow_mut();
        let zero = rig.now().saturating_sub(rig.us() * TICKS_PER_US);
        let us = |tick: u64| tick.saturating_sub(zero) / TICKS_PER_US;
        if self.job.options.record {
            let edge = |(tick, n, on)| Edge { us: us(tick), n, on };
            self.outputs.extend(rig.take_output_edges().into_iter().map(edge));
            self.inputs.extend(rig.take_input_edges().into_iter().map(edge));
            self.path.sample(&rig);
        }
        if self.path.release_start_at.is_some_and(|tick| tick <= rig.now()) {
            self.path.release_start_at = None;
            rig.board().plant_mut().press_start(false);
        }
        let edges = rig.board().take_edges();
        self.judge.take(&edges);
        if let Some(vcd) = &mut self.vcd {
            vcd.write(&edges).map_err(BoardError::Vcd)?;
        }
        let now = rig.us();
        drop(rig);
        (self.progress)(now);
        Ok(())
    }

    fn host_actions(&mut self) -> Result<(), BoardError> {
        let actions = self.rig.borrow_mut().take_host_actions();
        for action in actions {
            match action {
                HostAction::Char(c) => {
                    let value = u16::try_from(c).unwrap_or(0);
                    self.client.write(wire::CHAR_IN, value)?;
                }
                HostAction::EmergencyStop => self.client.control(Control::EmergencyStop)?,
                HostAction::Register(register, value) => self.write_register(register, value)?,
            }
        }
        Ok(())
    }

    /// Both halves of an AT variable.
    fn write_register(&mut self, register: u16, value: i32) -> Result<(), BoardError> {
        let halves = [value as u16, (value >> 16) as u16];
        Ok(self.client.write_all(register, &halves)?)
    }

    /// Lets the machine come to rest, compares pulses with positions, and adds up.
    fn finish(mut self, end: What) -> Result<BoardRun, BoardError> {
        let us = self.rig.borrow().us();
        self.client.link().pause(Duration::from_millis(20));
        self.look()?;
        let What::End { status, fault, line, pos, .. } = end else {
            return Err(BoardError::Board("the trace has no end".to_owned()));
        };
        let identity = self.client.identity()?;
        let mut rig = self.rig.borrow_mut();
        let health = Health::of(rig.board(), &identity);
        let mut failures = rig.failures(&pos);
        for axis in Axis::ALL {
            let i = axis.index();
            let there = rig.motors()[i] + rig.offset()[i];
            if let Some(told) = pos.get(axis)
                && rig.lost()[i] == 0
                && there != i64::from(told)
            {
                failures.push(format!(
                    "{} made step pulses to {there}, but the trace ends at {told}",
                    axis.letter()
                ));
            }
        }
        let number = fault.as_ref().and_then(|code| code.get(1..)?.parse().ok());
        let fault_number = number.and_then(Fault::from_number);
        let abrupt = matches!(fault_number, Some(Fault::EmergencyStop | Fault::LimitSwitch));
        let judged = self.judge.judge(rig.plant(), abrupt);
        let judged = judged.unwrap_or_else(|text| {
            failures.push(text);
            Count::default()
        });
        let pulses = self.path.pulses(&rig);
        let profile = &self.job.program.profile;
        let travel_um = Axis::ALL.map(|axis| {
            profile.axis(axis).map_or(0, |own| {
                pulses[axis.index()] * u64::from(own.scale.um) / u64::from(own.scale.steps)
            })
        });
        let summary = Summary {
            status,
            fault: fault.clone(),
            stopped: None,
            line,
            us,
            statements: 0,
            steps: pulses,
            travel_um,
            outputs: output_uses(&self.outputs, us),
        };
        let outcome = Outcome {
            end: End { status, fault: fault_number, line },
            summary,
            record: Record::default(),
            vars: Vec::new(),
            failures,
        };
        let mut remarks = remarks(&rig);
        if status == Status::Stopped && !(self.job.options.interrupted)() {
            remarks.push("the run was stopped: limit reached, or nothing could happen".to_owned());
        }
        let tick = rig.now();
        drop(rig);
        if let Some(vcd) = self.vcd.take() {
            vcd.finish(tick).map_err(BoardError::Vcd)?;
        }
        let record = self.path.record(self.inputs, self.outputs);
        Ok(BoardRun { outcome: Outcome { record, ..outcome }, remarks, health, judged })
    }
}

/// What each output did, ascending.
fn output_uses(edges: &[Edge], end_us: u64) -> Vec<OutputUse> {
    let mut uses: std::collections::BTreeMap<i32, (OutputUse, Option<u64>)> =
        std::collections::BTreeMap::new();
    for edge in edges {
        let entry =
            uses.entry(edge.n).or_insert((OutputUse { n: edge.n, switched_on: 0, on_us: 0 }, None));
        match (edge.on, entry.1) {
            (true, None) => {
                entry.0.switched_on += 1;
                entry.1 = Some(edge.us);
            }
            (false, Some(since)) => {
                entry.0.on_us += edge.us.saturating_sub(since);
                entry.1 = None;
            }
            _ => {}
        }
    }
    let whole = uses.into_values().map(|(mut used, since)| {
        used.on_us += since.map_or(0, |since| end_us.saturating_sub(since));
        used
    });
    whole.filter(|used| used.switched_on > 0).collect()
}

fn remarks(rig: &Rig) -> Vec<String> {
    let warnings = rig.warnings().iter().take(5);
    warnings.map(|warning| format!("the emulator warns: {warning:?}")).collect()
}
