//! Harness of the cross-crate suites.

use lang::hir::Program;
use pasapas::board::{DEFAULT, engine};
use pasapas::sim::trace::Event;
use pasapas::sim::world::World;
use pasapas::sim::{Engine, Options, Outcome, run_traced};

/// A program of the MSP430F5529 on both simulators, on its machine without an emulator, and on the shipped image: the engine,
/// how the run ended, its trace. At most 30 s are simulated.
///
/// # Panics
/// The world is wrong, the program does not fit, or an engine cannot run it.
pub fn on_every_engine(program: &Program, world: &str) -> Vec<(&'static str, Outcome, Vec<Event>)> {
    let world = World::parse("w.rhai", world).expect("a world");
    let options = Options { part: DEFAULT.part, limit_us: 30_000_000, ..Options::default() };
    let mut all = Vec::new();
    for (name, engine) in [("rhai", Engine::Rhai), ("vm", Engine::Vm)] {
        let (outcome, events) = run_traced(program, engine, &world, &options).expect("a run");
        all.push((name, outcome, events));
    }
    let compiled = lang::back::compile(program).expect("an image");
    let (run, events) =
        engine::run_native_traced(DEFAULT, program, &compiled, &world, &options).expect("a run");
    all.push(("native", run.outcome, events));
    let (image, sidecar) = (&compiled.image, &compiled.sidecar);
    let (run, events) =
        engine::run_traced(DEFAULT, program, image, sidecar, &world, &options).expect("a run");
    all.push(("board", run.outcome, events));
    all
}
