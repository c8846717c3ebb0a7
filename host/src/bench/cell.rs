//! Cells: runs of a proof per second, the cell's share of the time, and the time to load a large scene.

use std::time::Instant;

use lang::back::{Compiled, compile};
use lang::hir::Program;

use super::code::program;
use super::{Sink, at_least, at_most};
use crate::scene::proof::{self, Case, Plan};
use crate::scene::{self, Scene};
use crate::sim::Options;
use crate::sim::world::World;

/// Twelve parts from a tray into a box, in some 60 s.
const SCRIPT: &str = "OUTPUT pump = 3
DIM row, column
Home
FOR row = 0 TO 3
  FOR column = 0 TO 2
    G0 X[20mm + column * 15mm] Y[30mm + row * 15mm]
    MoveAxe Z, -22.5mm, 40mm/s
    SetOut pump, ON
    Wait 300ms
    MoveAxe Z, 0mm
    G0 X150 Y60
    MoveAxe Z, -12mm, 40mm/s
    SetOut pump, OFF
    Wait 300ms
    MoveAxe Z, 0mm
  NEXT
NEXT
";

const CELL: &str = r#"cell = 1
table = -60
tool = [{ name = "nozzle", kind = "vacuum", output = "pump", build_ms = 60, reach = 1.5, body = [{ at = [0, 0, 2], size = [12, 12, 40] }] }]
part = [{ name = "chip", size = [8, 8, 4] }]
feeder = [{ name = "tray", part = "chip", at = [20, 30, -26], pitch = [15, 15], count = [3, 4] }]
fixture = [{ name = "floor", at = [35, 52.5, -30], size = [60, 75, 4] }, { name = "wall", at = [100, 60, -60], size = [4, 120, 45] }]
place = [{ name = "box", at = [150, 60, -16.5], size = [20, 20, 10], room = 0 }]
expect = [{ what = "in_place", place = "box", of = "tray" }, { what = "no_collision" }]
vary = [{ key = "tray.at", sigma = 0.2, each = true }]
"#;

/// Runs of a measurement.
const RUNS: u64 = 24;

/// Figures `cell_runs`, `cell_share`, `cell_opens`.
///
/// # Errors
/// A scene is refused, or a run fails.
pub fn run(sink: Sink<'_>) -> Result<(), String> {
    let (program, _) = program("cell", SCRIPT)?;
    let compiled = compile(&program).map_err(|excesses| format!("{excesses:?}"))?;
    let own = read(CELL, &program)?;
    // What stands nowhere and has no tool costs what the plant alone does.
    let none = read("cell = 1\nvary = [{ key = \"start\", sigma = 0 }]\n", &program)?;
    // In turns, after a warm start.
    let (first, _) = timed(&program, &compiled, &own, 1)?;
    let mut with = 0.0;
    let mut without = 0.0;
    for _ in 0..2 {
        with += timed(&program, &compiled, &own, RUNS)?.1;
        without += timed(&program, &compiled, &none, RUNS)?.1;
    }
    let a_minute = first / 60e6;
    let runs = 2.0 * RUNS as f64 / with * a_minute;
    sink(at_least("cell_runs", "runs of 60 s/s", runs, 5.0, 200.0))?;
    let share = (with - without).max(0.0) / with * 100.0;
    sink(at_most("cell_share", "%", share, 25.0, 10.0))?;
    let began = Instant::now();
    let large = read(&thousand(), &program)?;
    let opened = began.elapsed().as_secs_f64();
    let things = ::cell::things::all(&large.cell).len();
    if things != 1000 {
        return Err(format!("the large scene has {things} things"));
    }
    sink(at_most("cell_opens", "s", opened, 0.2, 0.1))
}

/// A thousand parts in a tray over a floor.
fn thousand() -> String {
    CELL.replace("pitch = [15, 15], count = [3, 4]", "pitch = [9, 9], count = [40, 25]")
        .replace("at = [20, 30, -26]", "at = [5, 5, -26]")
        .replace(
            "at = [35, 52.5, -30], size = [60, 75, 4]",
            "at = [180, 110, -30], size = [380, 240, 4]",
        )
        .replace("{ name = \"wall\", at = [100, 60, -60], size = [4, 120, 45] }", "")
}

fn read(text: &str, program: &Program) -> Result<Scene, String> {
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let file = folder.path().join("bench.cell.toml");
    std::fs::write(&file, text).map_err(|error| error.to_string())?;
    let read = scene::read(&file.display().to_string(), &program.profile, Some(program));
    let (scene, _) =
        read.map_err(|notes| notes.first().map_or_else(String::new, |note| note.text.clone()))?;
    Ok(scene)
}

/// Simulated time of a run, us, and the time that so many take on two threads, s.
fn timed(
    program: &Program,
    compiled: &Compiled,
    scene: &Scene,
    runs: u64,
) -> Result<(f64, f64), String> {
    let world = World::unattended();
    let options = Options { record: false, judged: false, ..Options::default() };
    let case = Case { program, compiled, world: &world, scene, options: &options };
    let one = case.run(&[]).map_err(|error| error.to_string())?;
    let plan = Plan { runs, seed: 1, jobs: 2, shard: (0, 1), within: None, until_fails: false };
    let began = Instant::now();
    let proof =
        proof::prove(&case, &plan, &|| false, &|_| {}).map_err(|error| error.to_string())?;
    if proof.runs != runs {
        return Err(format!("{} of {runs} runs were made", proof.runs));
    }
    Ok((one.report.end.us as f64, began.elapsed().as_secs_f64()))
}
