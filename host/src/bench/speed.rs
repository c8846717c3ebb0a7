//! Speed of the desktop: emulator, engines, compiler.

use std::time::Instant;

use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};

use super::code::program;
use super::stand::{Stand, fast_mill, image_for};
use super::{Sink, at_least, at_most};
use crate::board::G2553;
use crate::sim::world::World;
use crate::sim::{self, Engine, Options};

const LOOP: &str =
    "DIM i, a, b\nFOR i = 1 TO 200000\n  a = b + i\n  IF a > 1000 THEN b = -i\nNEXT\n";

/// Figures `emulator_speed`, `rhai_speed`, `vm_speed`, `compile_10k`.
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
    sink(at_most("compile_10k", "s", compile_time()?, 0.3, 0.1))
}

fn engine(engine: Engine) -> Result<f64, String> {
    let (program, _) = program("loop", LOOP)?;
    let options = Options { record: false, ..Options::default() };
    let began = Instant::now();
    let outcome = sim::run(&program, engine, &World::empty(), &options, Box::new(|_| {}))
        .map_err(|error| error.to_string())?;
    Ok(outcome.summary.statements as f64 / began.elapsed().as_secs_f64())
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
