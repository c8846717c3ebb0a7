//! `pasapas sim --engine board`: the engine's run with a progress bar and a VCD.

use std::io::Write;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use lang::part::F5529;

use super::console::Console;
use super::others::Others;
use super::part::Choice;
use super::script::{self, Script};
use super::world;
use crate::board::engine::{self, BoardError, Job, Sinks};
use crate::client::identity::late_clause;
use crate::failure::Failure;
use crate::output::OutputFile;
use crate::plot::time;
use crate::sim::chain;
use crate::sim::world::World;
use crate::sim::{self, Options, Outcome, Sink};

/// Runs a script on the emulated board, or on the firmware's machine without an emulator; what the emulator noticed is
/// written.
///
/// # Errors
/// The script does not fit, the world is wrong, the board fails, or the VCD cannot be written.
pub fn run(
    script: &mut Script,
    others: &Others,
    part: Choice,
    (world, vcd, native): (&World, Option<&str>, bool),
    options: &Options,
    mut sink: Sink,
    console: &Console,
) -> Result<Outcome, Failure> {
    let compiled = script::compile_for_device(script, console)?;
    let (compiled, build) = part.fit(script, compiled, console)?;
    if native && build.part != F5529 {
        let text = "without an emulator the f5529 is simulated: `--engine board` runs other parts";
        return Err(Failure::Usage(text.to_owned()));
    }
    let line_of = |pc: u16| compiled.sidecar.at(usize::from(pc)).map_or(0, |mark| mark.line);
    for other in &others.list {
        script::must_fit(&other.script, &other.compiled, console)?;
    }
    let lines: Vec<_> = others
        .list
        .iter()
        .map(|other| {
            |pc: u16| other.compiled.sidecar.at(usize::from(pc)).map_or(0, |mark| mark.line)
        })
        .collect();
    let library: Vec<engine::Other<'_>> = others
        .list
        .iter()
        .zip(&lines)
        .map(|(other, line_of)| engine::Other {
            name: &other.name,
            program: &other.script.program,
            image: &other.compiled.image,
            line_of,
        })
        .collect();
    let runs = !chain::calls(&script.program).is_empty();
    // The emulated machine has its switches from power-up on.
    let placed = if world.is_unattended() && world.scene().is_none() {
        let switches = sim::unattended::switches(&others.chain(script), options);
        let switches = switches.map_err(|error| Failure::Board(error.to_string()))?;
        Some(world.clone().with_switches(switches))
    } else {
        None
    };
    let world = placed.as_ref().unwrap_or(world);
    let job = Job {
        build,
        program: &script.program,
        image: &compiled.image,
        line_of: &line_of,
        name: if runs { others.name() } else { "" },
        others: &library,
        world,
        options,
    };
    let vcd_name = vcd.unwrap_or_default();
    let vcd = vcd.map(|path| OutputFile::create(path.as_ref())).transpose();
    let mut vcd = vcd.map_err(|error| Failure::writing(vcd_name, &error))?;
    let bar = bar(console);
    let mut shown = Instant::now();
    let mut progress = |us: u64| {
        if shown.elapsed() > Duration::from_millis(100) {
            shown = Instant::now();
            bar.set_message(time(us));
            bar.tick();
        }
    };
    let sinks = Sinks {
        trace: &mut *sink,
        vcd: vcd.as_mut().map(|file| file as &mut dyn Write),
        progress: &mut progress,
    };
    let result = if native { engine::run_native(&job, sinks) } else { engine::run(&job, sinks) };
    bar.finish_and_clear();
    let run = result.map_err(|error| match error {
        BoardError::World(error) => world::wrong(&error, console),
        BoardError::Vcd(error) => Failure::writing(vcd_name, &error),
        error => Failure::Board(error.to_string()),
    })?;
    if let Some(file) = vcd {
        file.finish().map_err(|error| Failure::writing(vcd_name, &error))?;
    }
    for remark in &run.remarks {
        console.complain(remark);
    }
    if let Some(late) = late_clause(run.health.late_events) {
        console.complain(&format!("the board counts: {late}"));
    }
    Ok(run.outcome)
}

/// Shown on a terminal only.
fn bar(console: &Console) -> ProgressBar {
    if !console.shows_progress() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{spinner} board: {msg} of simulated time") {
        bar.set_style(style);
    }
    bar
}
