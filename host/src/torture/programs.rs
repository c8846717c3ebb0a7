//! Generated programs on `rhai`, on the device's VM and on the board: the real image, emulated.
//! Traces, ends with fault and line, and variables must be the same.

use std::collections::BTreeMap;
use std::sync::Mutex;

use lang::back::Compiled;
use lang::front::compile;
use lang::front::source::Source;
use lang::hir::Program;
use lang::image::Image;
use lang::part::{F5529, Part};
use lang::record::feature;

use super::compare::{
    Run, difference, hangs_on_an_instant, on_rhai, on_vm, trace_difference, varied,
};
use super::generate::{Case, generate, generate_still};
use super::{Row, Settings, Sink, Verdict};
use crate::board::engine::{self, BoardError, BoardRun};
use crate::board::health::Health;
use crate::board::{Build, F5529 as BOARD_F5529};
use crate::chords;
use crate::course;
use crate::sim::trace::{Event, Status, What, to_text};
use crate::sim::world::World;
use crate::sim::{Options, STATEMENT_US, SimError};

/// Ends runaway programs; the engines count statements alike. Blocks run into one another as on the
/// part that has all of the language.
const OPTIONS: Options = Options {
    limit_us: 60_000_000,
    times: true,
    record: false,
    judged: true,
    statements: 4_000,
    statement_us: STATEMENT_US,
    part: F5529,
    interrupted: || false,
};
/// Longest program that goes to the board, us: emulated time is dear.
const LONGEST_US: u64 = 8_000_000;
/// A statement that the host is told of takes at most so long, us: 11.2 ms for a line of the trace,
/// 24.1 ms for one that brings up to 32 characters of PRINT (measured on the emulated board).
const LINE_US: u64 = 25_000;
/// How much later an effect may come on the board, ms: the promise is 10 ms, and this is what a
/// world is moved by to see whether a trace hangs on instants.
const LATER: u32 = 13;

/// A program, ready for every engine.
pub struct Made {
    /// What it was made from.
    pub case: Case,
    /// Checked.
    pub program: Program,
    /// Compiled.
    pub compiled: Compiled,
    /// Its world.
    pub world: World,
}

/// Compiles a case; `None` when the compiler refuses it.
pub fn make(case: Case) -> Option<Made> {
    let source = Source::new("g.bas", case.script.clone());
    let (program, _) = compile(&source, case.machine());
    let program = program?;
    let compiled = lang::back::compile(&program).ok()?;
    let world = World::parse("g.rhai", &case.world).ok()?;
    Some(Made { case, program, compiled, world })
}

/// The same for a board, with chords where its part draws no arcs; `None` also when that has no room for
/// the program.
pub fn make_for(build: &Build, case: Case) -> Option<Made> {
    let made = drawn(make(case)?, build.part)?;
    let image = Image::new(&made.compiled.image).ok()?;
    build.part.lacks(&image, &made.program.profile).is_none().then_some(made)
}

/// With chords for a part that draws no arcs, and slow points for one that does not look ahead.
fn drawn(mut made: Made, part: Part) -> Option<Made> {
    let wants = Image::new(&made.compiled.image).ok()?.header.features;
    if u16::from(wants) & !part.features & feature::ARC != 0 {
        made.program = chords::drawn(&made.program).ok()?.0;
        made.compiled = lang::back::compile(&made.program).ok()?;
    }
    made.compiled = course::put_into(made.compiled, &made.program, &part);
    Some(made)
}

/// The choices of case `n`.
pub fn tape(settings: &Settings, fault: &str, n: u64) -> Vec<u16> {
    let mut rng = settings.rng(fault, n);
    let length = 20 + rng.below(240);
    (0..length).map(|_| rng.bits() as u16).collect()
}

/// Runs a program on the board.
///
/// # Errors
/// The board does not do what it is told.
pub fn on_board(build: &Build, made: &Made, image: &[u8]) -> Result<(Run, BoardRun), BoardError> {
    let options = Options { times: false, part: build.part, ..OPTIONS };
    let sidecar = &made.compiled.sidecar;
    let (run, trace) =
        engine::run_traced(build, &made.program, image, sidecar, &made.world, &options)?;
    Ok((Run { trace, outcome: run.outcome.clone() }, run))
}

/// Events of a program on the engine `vm`, with their times.
///
/// # Errors
/// As of [`on_vm`].
pub fn on_host_timed(made: &Made) -> Result<Vec<Event>, SimError> {
    on_vm(&made.program, &made.compiled, &made.world, &OPTIONS).map(|run| run.trace)
}

/// Events of a program on the emulated board, which nobody traces, with their times.
///
/// # Errors
/// As of [`on_board`].
pub fn on_board_timed(build: &Build, made: &Made) -> Result<Vec<Event>, BoardError> {
    let options = Options { part: build.part, ..OPTIONS };
    let (image, sidecar) = (&made.compiled.image, &made.compiled.sidecar);
    engine::run_traced(build, &made.program, image, sidecar, &made.world, &options)
        .map(|(_, trace)| trace)
}

fn told(case: &Case, text: &str, runs: [(&str, &Run); 2]) -> Verdict {
    let [(a, one), (b, other)] = runs;
    Verdict::Lost(format!(
        "{text}\n{}\n// {}\n{a}:\n{}{b}:\n{}",
        case.script,
        case.world,
        to_text(&one.trace),
        to_text(&other.trace)
    ))
}

/// Compares `rhai` with the VM, which runs `image`.
pub fn on_the_host(made: &Made, spoilt: Option<&Compiled>) -> Verdict {
    let compiled = spoilt.unwrap_or(&made.compiled);
    let both = |made: &Made| {
        let rhai = on_rhai(&made.program, &made.compiled, &made.world, &OPTIONS);
        let vm = on_vm(&made.program, compiled, &made.world, &OPTIONS);
        (rhai, vm)
    };
    let (rhai, vm) = match both(made) {
        (Ok(rhai), Ok(vm)) => (rhai, vm),
        (Err(error), _) | (_, Err(error)) => return Verdict::Lost(error.to_string()),
    };
    let timeless = |run: &Run| Run {
        trace: run.trace.iter().map(|event| Event { us: None, ..event.clone() }).collect(),
        outcome: run.outcome.clone(),
    };
    let (rhai, vm) = (timeless(&rhai), timeless(&vm));
    match difference(&made.case, &rhai, &vm) {
        None => Verdict::Survived,
        // An edge or a tick may come at the very statement.
        Some(_) if spoilt.is_none() && hangs_on_an_instant(&made.case, &rhai, on_both) => {
            Verdict::Skipped
        }
        Some(text) => told(&made.case, &text, [("rhai", &rhai), ("vm", &vm)]),
    }
}

fn on_both(case: &Case, statement_us: u64) -> Option<(Run, Run)> {
    let made = make(case.clone())?;
    let options = Options { statement_us, ..OPTIONS };
    let rhai = on_rhai(&made.program, &made.compiled, &made.world, &options).ok()?;
    Some((rhai, on_vm(&made.program, &made.compiled, &made.world, &options).ok()?))
}

/// What `rhai` says of a program that a board with `part` can be held to: it ends in time and by
/// itself, and its trace is the same when the world comes later and when statements take longer, as
/// they do with a host that takes each line of the trace.
pub fn reference(part: Part, made: &Made) -> Option<Run> {
    let run = |made: &Made, statement_us: u64| {
        // Slower statements take longer in all.
        let limit_us = OPTIONS.limit_us + OPTIONS.statements * statement_us;
        let options = Options { statement_us, limit_us, part, ..OPTIONS };
        let run = on_rhai(&made.program, &made.compiled, &made.world, &options).ok()?;
        (run.outcome.end.status != Status::Stopped).then_some(run)
    };
    let first = run(made, STATEMENT_US)?;
    if first.trace.last().and_then(|event| event.us).is_none_or(|us| us >= LONGEST_US) {
        return None;
    }
    let mut later = varied(&made.case, LATER);
    // How far an axis runs by MoveSpeed hangs on the wait behind it.
    later.script = later.script.replace("Wait 40ms", "Wait 50ms");
    let later = drawn(make(later)?, part)?;
    let same = |mut other: Run| {
        for event in &mut other.trace {
            if let What::Wait { ms, .. } = &mut event.what {
                *ms = if *ms == 50 { 40 } else { *ms };
            }
        }
        trace_difference(&first.trace, &other.trace, margin(&first)).is_none()
    };
    for statement_us in [1_000, LINE_US] {
        if !run(made, statement_us).is_some_and(&same)
            || !run(&later, statement_us).is_some_and(&same)
        {
            return None;
        }
    }
    Some(first)
}

/// Compares the firmware's machine without an emulator, which runs `image`, with what `rhai` says.
pub fn against_the_machine(made: &Made, image: &[u8], wanted: &Run) -> Verdict {
    let options = Options { times: false, ..OPTIONS };
    let compiled = Compiled { image: image.to_vec(), ..made.compiled.clone() };
    let run =
        engine::run_native_traced(&BOARD_F5529, &made.program, &compiled, &made.world, &options);
    let (run, trace) = match run {
        Ok(both) => both,
        Err(error) => {
            return Verdict::Lost(format!("{error}\n{}\n// {}", made.case.script, made.case.world));
        }
    };
    let machine = Run { trace, outcome: run.outcome };
    let difference = trace_difference(&wanted.trace, &machine.trace, margin(wanted));
    match difference.or_else(|| machine.outcome.failures.first().cloned()) {
        None => Verdict::Survived,
        Some(text) => told(&made.case, &text, [("rhai", wanted), ("machine", &machine)]),
    }
}

/// Compares the board, which runs `image`, with what `rhai` says.
pub fn against_the_board(
    build: &Build,
    made: &Made,
    image: &[u8],
    wanted: &Run,
) -> (Verdict, Option<Health>) {
    let (board, run) = match on_board(build, made, image) {
        Ok(both) => both,
        Err(error) => {
            let text = format!("{error}\n{}\n// {}", made.case.script, made.case.world);
            return (Verdict::Lost(text), None);
        }
    };
    let health = Some(run.health.clone());
    if let Some(text) = trace_difference(&wanted.trace, &board.trace, margin(wanted)) {
        return (told(&made.case, &text, [("rhai", wanted), ("board", &board)]), health);
    }
    let remark = run.remarks.first().or(run.outcome.failures.first());
    if let Some(remark) = remark {
        return (told(&made.case, remark, [("rhai", wanted), ("board", &board)]), health);
    }
    (Verdict::Survived, health)
}

/// Top rate of the machine that programs are made for, steps/s.
const TOP_RATE: i32 = 8_000;
/// A switch on the shift registers is seen so late, us: they are read each millisecond, by a pass of
/// the main loop that may have begun before.
const SWITCH_US: i32 = 1_250;

/// How far positions may lie apart, steps.
fn margin(wanted: &Run) -> i32 {
    let met_a_switch = |event: &Event| match &event.what {
        What::End { fault, .. } => fault.as_deref() == Some(LIMIT_SWITCH),
        What::Print { text, .. } => text.starts_with("F6 "),
        _ => false,
    };
    if wanted.trace.iter().any(met_a_switch) { TOP_RATE * SWITCH_US / 1_000_000 } else { 0 }
}

/// F06.
const LIMIT_SWITCH: &str = "F06";

/// Programs on `rhai` and the VM, then on the board too.
///
/// # Errors
/// The table cannot be written.
pub fn run(settings: &Settings, sink: Sink<'_>) -> Result<(), String> {
    let fault = "generated, rhai and vm";
    let mut row = Row::new("programs", fault, settings);
    row.run(settings, settings.count(300, 5_000, 100_000), |n| {
        make(generate(&tape(settings, fault, n)))
            .map_or(Verdict::Skipped, |made| on_the_host(&made, None))
    });
    sink(row)?;
    if settings.builds.iter().any(|build| build.part == F5529) {
        sink(on_machine(settings))?;
    }
    settings.builds.iter().try_for_each(|build| on_boards(build, settings, sink))
}

/// The same programs as those of the board, on the firmware's machine without an emulator.
fn on_machine(settings: &Settings) -> Row {
    let fault = "generated, rhai and machine";
    let mut row = Row::new("programs", fault, settings);
    row.run(settings, settings.count(60, 5_000, 100_000), |n| {
        let made = make(generate_still(F5529, &tape(settings, fault, n)));
        let both = made.and_then(|made| reference(F5529, &made).map(|run| (made, run)));
        both.map_or(Verdict::Skipped, |(made, wanted)| {
            against_the_machine(&made, &made.compiled.image, &wanted)
        })
    });
    row
}

fn on_boards(build: &Build, settings: &Settings, sink: Sink<'_>) -> Result<(), String> {
    let fault = "generated, rhai and board";
    let mut row = Row::on(build, "programs", fault, settings);
    let ends = Mutex::new(BTreeMap::<String, u64>::new());
    // Somewhat more than half of the tapes make a program that the board can be held to.
    row.run(settings, settings.count(16, 500, 12_000), |n| {
        let made = make_for(build, generate_still(build.part, &tape(settings, fault, n)));
        let Some((made, wanted)) =
            made.and_then(|made| reference(build.part, &made).map(|run| (made, run)))
        else {
            return Verdict::Skipped;
        };
        let (verdict, _) = against_the_board(build, &made, &made.compiled.image, &wanted);
        let end = wanted.outcome.summary.fault.unwrap_or_else(|| "done".to_owned());
        if let Ok(mut ends) = ends.lock() {
            *ends.entry(end).or_default() += 1;
        }
        verdict
    });
    let ends = ends.into_inner().unwrap_or_default();
    row.note =
        ends.iter().map(|(end, count)| format!("{end} {count}")).collect::<Vec<_>>().join(", ");
    sink(row)
}
