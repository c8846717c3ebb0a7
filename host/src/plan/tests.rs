//! Slow points of small programs.

use lang::back::{self, SlowPoints};
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::hir::Program;

use super::slow_points;
use crate::sim::world::World;
use crate::sim::{Engine, Options, run};

fn program(text: &str) -> Program {
    let choice = ProfileChoice::Script(&lang::profile::Profile::built_in);
    let (program, found) = compile(&Source::new("a.bas", text.to_owned()), choice);
    program.unwrap_or_else(|| panic!("{:?}", found.into_sorted()))
}

fn points(text: &str) -> SlowPoints {
    let program = program(text);
    slow_points(&program, &back::compile(&program).expect("it fits"))
}

/// Simulated seconds that a program takes on an engine that looks ahead.
fn seconds(text: &str, engine: Engine) -> f64 {
    let sink = Box::new(|_: &crate::sim::trace::Event| {});
    let far = World::parse("w", "switch_at(\"X\", -2000000); switch_at(\"Y\", -2000000);");
    let world = far.expect("the world is sound");
    let outcome = run(&program(text), engine, &world, &Options::default(), sink);
    outcome.expect("it runs").summary.us as f64 / 1e6
}

/// 100 mm in chords of 0.1 mm.
const CHORDS: &str = "DIM i\nG0 X0\nG91\nF3000\nFOR i = 1 TO 1000\nG1 X0.1\nNEXT\nG90\n";

#[test]
fn a_thousand_chords_take_two_slow_points() {
    let points = points(CHORDS);
    assert!((1..=2).contains(&points.len()), "{points:?}");
    for engine in [Engine::Vm, Engine::Rhai] {
        let seconds = seconds(CHORDS, engine);
        // 2.17 s are possible, 2.75 with what the chip takes to plan 1000 blocks.
        assert!(seconds < 2.9, "{seconds} s on {engine:?}");
    }
}
