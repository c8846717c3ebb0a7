//! Runs a checked script on a simulated machine.
//!
//! An engine follows the program; the machine carries out its effects in simulated microseconds: the firmware's own on a
//! simulated MSP430F5529 ([`native`]), a model of the MSP430G2553's ([`machine`]). The [`world`] is everything around the
//! controller.

pub mod chain;
mod controlled;
mod log;
pub mod machine;
pub mod native;
pub mod record;
pub mod rhai_engine;
pub mod scene;
pub mod step;
pub mod told;
pub mod trace;
pub mod unattended;
pub mod view;
pub mod vm_engine;
pub mod world;

use std::cell::RefCell;
use std::rc::Rc;

use lang::back::{self, Compiled};
use lang::fault::Fault;
use lang::hir::Program;
use lang::part::{F5529, Part};

use crate::scene::Report;
use chain::Chain;
use record::{Record, Summary};
use trace::{Event, Status};
use unattended::Unattended;
use world::{World, WorldError};

/// Simulated time that a run may take unless told otherwise: 24 h, in us.
pub const DEFAULT_LIMIT_US: u64 = 24 * 3600 * 1_000_000;

/// Simulated time that a statement takes, us (lang/README.md, The machine).
pub const STATEMENT_US: u64 = 20;

/// Calls that any image may have open at once.
const MAX_CALLS: usize = 15;

/// Who executes the statements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// Translated to Rhai.
    Rhai,
    /// The device's VM on the host.
    Vm,
}

/// How a run is to be made.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// End after this simulated time, us.
    pub limit_us: u64,
    /// Write `us` into the trace.
    pub times: bool,
    /// Keep path and edges.
    pub record: bool,
    /// End after so many statements: a loop that never does anything would otherwise take hours
    /// to reach the limit of simulated time.
    pub statements: u64,
    /// Simulated time of a statement, us.
    pub statement_us: u64,
    /// The chip that is simulated and whose times are shown.
    pub part: Part,
    /// Hold every edge of a board's pins to the ramps and rates of the profile.
    pub judged: bool,
    /// Asked now and then: `true` ends the run as [`record::StopReason::Interrupted`].
    pub interrupted: fn() -> bool,
}

/// Statements that a run may execute unless told otherwise: minutes of a desktop.
pub const DEFAULT_STATEMENTS: u64 = 200_000_000;

impl Default for Options {
    fn default() -> Options {
        Options {
            limit_us: DEFAULT_LIMIT_US,
            times: true,
            record: true,
            statements: DEFAULT_STATEMENTS,
            statement_us: STATEMENT_US,
            part: F5529,
            judged: true,
            interrupted: || false,
        }
    }
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct End {
    /// How.
    pub status: Status,
    /// The fault, with [`Status::Fault`].
    pub fault: Option<Fault>,
    /// END's line or the last, the failing statement's, or that of the one interrupted.
    pub line: u32,
}

/// Final values of a variable of the script.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VarValue {
    /// Name as declared; variables that the compiler adds are left out.
    pub name: String,
    /// One value, or those of an array.
    pub values: Vec<i32>,
}

/// What a run gives.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// How it ended.
    pub end: End,
    /// Its F14 is a line of a path that came too late ([`lang::fault::LATE_LINE`]), no emergency stop.
    pub late_line: bool,
    /// The run in numbers.
    pub summary: Summary,
    /// For plots.
    pub record: Record,
    /// Globals and KEEPs in order of declaration.
    pub vars: Vec<VarValue>,
    /// `expect_` lines of the world that did not hold, each with its line and what was there.
    pub failures: Vec<String>,
    /// What the run took upon itself where nobody was there.
    pub unattended: Unattended,
    /// Number of the program in which it ended, in the [`Chain`]; the record has the first one's lines.
    pub program: usize,
    /// The program that RUN would begin, where nobody knows what stands beside this one.
    pub onward: Option<String>,
    /// What the cell around the machine gave, if there is one.
    pub cell: Option<Report>,
}

/// Why a run could not be made, or not to its end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SimError {
    /// The world's script is wrong.
    World(WorldError),
    /// The engine refuses the program; the text says why.
    Engine(String),
}

impl std::fmt::Display for SimError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            SimError::World(error) => error.fmt(f),
            SimError::Engine(text) => f.write_str(text),
        }
    }
}

impl std::error::Error for SimError {}

impl From<WorldError> for SimError {
    fn from(error: WorldError) -> SimError {
        SimError::World(error)
    }
}

/// Takes each line of a trace as it is written.
pub type Sink = Box<dyn FnMut(&Event)>;

/// Runs `program` from its first statement to its end; `sink` gets each line of the trace as it
/// is written, `end` included.
///
/// # Errors
/// The world's script fails, or the engine cannot take the program. A fault of the script is no
/// error: it is the outcome's end.
pub fn run(
    program: &Program,
    engine: Engine,
    world: &World,
    options: &Options,
    sink: Sink,
) -> Result<Outcome, SimError> {
    run_chain(&Chain::alone(program), engine, world, options, sink)
}

/// The same of the first program of a chain, and of those that RUN begins.
///
/// # Errors
/// As [`run`].
pub fn run_chain(
    chain: &Chain<'_>,
    engine: Engine,
    world: &World,
    options: &Options,
    sink: Sink,
) -> Result<Outcome, SimError> {
    let compiled = chain.programs().iter().map(|program| back::compile(program));
    let mut outcome = match engine {
        Engine::Rhai => {
            let depth = |compiled: Result<Compiled, _>| compiled.map_or(MAX_CALLS, |own| own.calls);
            let depths: Vec<usize> = compiled.map(depth).collect();
            rhai_engine::run_chain(chain, world, options, &depths, sink)?
        }
        Engine::Vm => {
            let compiled = compiled.collect::<Result<Vec<_>, _>>().map_err(too_much)?;
            vm_engine::run_chain(chain, &compiled, world, options, sink, None)?
        }
    };
    if outcome.program != 0 {
        outcome.summary.program = chain.names().get(outcome.program).cloned();
    }
    Ok(outcome)
}

fn too_much(excesses: Vec<back::Excess>) -> SimError {
    let list: Vec<String> = excesses
        .iter()
        .map(|excess| {
            let back::Excess { resource, used, available, .. } = excess;
            format!("{resource:?}: {used} used, {available} available")
        })
        .collect();
    SimError::Engine(format!(
        "no image can hold this program: {}; `--engine rhai` runs it",
        list.join("; ")
    ))
}

/// Ends a run on the machine and collects what it leaves.
fn outcome(
    machine: &mut controlled::Machine,
    fault: Option<Fault>,
    line: u32,
    vars: Vec<VarValue>,
) -> Result<Outcome, SimError> {
    let end = machine.finish(fault, line)?;
    let (summary, record, failures) = machine.results(&end);
    let unattended = machine.unattended();
    let cell = machine.report(&end);
    Ok(Outcome {
        end,
        summary,
        record,
        vars,
        failures,
        unattended,
        program: 0,
        onward: None,
        late_line: false,
        cell,
    })
}

/// As [`run`], with the whole trace in memory.
///
/// # Errors
/// As [`run`].
pub fn run_traced(
    program: &Program,
    engine: Engine,
    world: &World,
    options: &Options,
) -> Result<(Outcome, Vec<Event>), SimError> {
    run_chain_traced(&Chain::alone(program), engine, world, options)
}

/// As [`run_chain`], with the whole trace in memory.
///
/// # Errors
/// As [`run`].
pub fn run_chain_traced(
    chain: &Chain<'_>,
    engine: Engine,
    world: &World,
    options: &Options,
) -> Result<(Outcome, Vec<Event>), SimError> {
    let events = Rc::new(RefCell::new(Vec::new()));
    let sink = events.clone();
    let sink = Box::new(move |event: &Event| sink.borrow_mut().push(event.clone()));
    let outcome = run_chain(chain, engine, world, options, sink)?;
    Ok((outcome, events.take()))
}
