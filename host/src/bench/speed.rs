//! Speed of the desktop: emulator, engines, compiler.

use std::time::Instant;

use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::hir::Program;

use super::code::{EXAMPLES, program};
use super::stand::{Stand, fast_mill, image_for};
use super::{Sink, at_least, at_most};
use crate::board::G2553;
use crate::sim::world::World;
use crate::sim::{self, Engine, Options};

const LOOP: &str =
    "DIM i, a, b\nFOR i = 1 TO 200000\n  a = b + i\n  IF a > 1000 THEN b = -i\nNEXT\n";

/// Lines of the long job.
const LINES: u32 = 100_000;
/// Runs of an example; the quickest counts.
const RUNS: u32 = 5;

/// Figures `emulator_speed`, `rhai_speed`, `vm_speed`, `sim_dil14`, `sim_pick_place`, `sim_100k_lines`, `compile_10k`.
///
/// # Errors
/// An engine does not run its script.
pub fn run(sink: Sink<'_>) -> Result<(), String> {
    let profile = fast_mill(8_000, 25_000)?;
    let (_, image) = image_for(&profile, "G1 X300 Y200 Z-100 F4000\n")?;
    let mut stand = Stand::on(&G2553, &profile)?;
    stand.upload(&image)?;
    let (before, began) = (stand.seconds(), Instant::now());
    stand.run(std::time::Duration::from_secs(30))?;
    let speed = (stand.seconds() - before) / began.elapsed().as_secs_f64();
    sink(at_least("emulator_speed", "x", speed, 5.0, 20.0))?;
    let rhai = engine(Engine::Rhai)?;
    sink(at_least("rhai_speed", "statements/s", rhai, 500_000.0, 2_000_000.0))?;
    let vm = engine(Engine::Vm)?;
    sink(at_least("vm_speed", "statements/s", vm, 500_000.0, 2_000_000.0))?;
    sink(at_most("sim_dil14", "ms", example("dil14")? * 1e3, 100.0, 20.0))?;
    sink(at_most("sim_pick_place", "ms", example("pick_place")? * 1e3, 2_000.0, 400.0))?;
    sink(at_most("sim_100k_lines", "s", long_job()?, 15.0, 4.0))?;
    sink(at_most("compile_10k", "s", compile_time()?, 0.3, 0.1))
}

fn engine(engine: Engine) -> Result<f64, String> {
    let (program, _) = program("loop", LOOP)?;
    let (time, statements) = simulated(&program, engine, &World::empty())?;
    Ok(statements as f64 / time)
}

/// Time of the quickest of some runs of an example in its world, s.
fn example(name: &str) -> Result<f64, String> {
    let read = |extension: &str| {
        let file = format!("{EXAMPLES}/{name}.{extension}");
        std::fs::read_to_string(&file).map_err(|error| format!("{file}: {error}"))
    };
    let (program, _) = program(name, &read("bas")?)?;
    let world = match read("rhai") {
        Ok(text) => World::parse(name, &text).map_err(|error| error.to_string())?,
        Err(_) => World::unattended(),
    };
    let mut best = f64::INFINITY;
    for _ in 0..RUNS {
        best = best.min(simulated(&program, Engine::Vm, &world)?.0);
    }
    Ok(best)
}

/// Time to simulate a path of short lines, s.
fn long_job() -> Result<f64, String> {
    let mut text = String::from("G1 X0 Y0 F1200\n");
    for i in 0..LINES {
        let angle = f64::from(i) * 0.01;
        let radius = 20.0 + 10.0 * (angle * 0.013).sin();
        let (x, y) = (50.0 + radius * angle.cos(), 50.0 + radius * angle.sin());
        text += &format!("G1 X{x:.3} Y{y:.3}\n");
    }
    let source = Source::new("long", text);
    let (program, diags) = compile(&source, ProfileChoice::built_in());
    let program = program.ok_or_else(|| diags.render(&source))?;
    // No board has room for an image of it, and `rhai` needs none.
    Ok(simulated(&program, Engine::Rhai, &World::unattended())?.0)
}

/// Time of a run, s, and the statements that it executed.
fn simulated(program: &Program, engine: Engine, world: &World) -> Result<(f64, u64), String> {
    let options = Options { record: false, ..Options::default() };
    let began = Instant::now();
    let outcome = sim::run(program, engine, world, &options, Box::new(|_| {}))
        .map_err(|error| error.to_string())?;
    Ok((began.elapsed().as_secs_f64(), outcome.summary.statements))
}

/// Time to check and compile a script of 10 000 lines.
fn compile_time() -> Result<f64, String> {
    let mut text = String::from("DIM a, b\n");
    for i in 0..9_999 {
        text += match i % 4 {
            0 => "a = a * 3 + b\n",
            1 => "IF a > 100 THEN b = a MOD 7\n",
            2 => "G1 X[a * 1mm] Y2 F300\n",
            _ => "SetOut 1, a > b\n",
        };
    }
    let source = Source::new("long", text);
    let began = Instant::now();
    let (program, diags) = compile(&source, ProfileChoice::built_in());
    let program = program.ok_or_else(|| diags.render(&source))?;
    lang::back::compile(&program).map_err(|excesses| format!("{excesses:?}"))?;
    Ok(began.elapsed().as_secs_f64())
}
