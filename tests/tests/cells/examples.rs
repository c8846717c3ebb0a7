//! The cells of the examples: each script is right in its cell, and none has a line that no variation reaches but what its
//! page says.

use pasapas::scene::proof::{self, Case, Plan};
use pasapas::sim::Options;
use pasapas::sim::world::World;

use super::{example, folder, native, read, report};

const NAMES: [&str; 10] = [
    "pick_place",
    "vacuum_pick",
    "pcb_drill",
    "glue_dots",
    "cells/probed_holes",
    "cells/glue_path",
    "cells/tape",
    "cells/cut",
    "cells/sort",
    "cells/hasty",
];

#[test]
fn every_example_is_right_in_its_cell() {
    for name in NAMES {
        let program = example(name);
        let scene = read(&folder().join(format!("{name}.cell.toml")), &program);
        assert!(!scene.cell.expects.is_empty() && !scene.cell.varies.is_empty(), "{name}");
        let (run, _) = native(&program, &World::unattended().with_scene(Some(scene)));
        let report = report(run);
        assert!(report.holds() && report.end.how == "done", "{name}\n{}", report.table());
    }
}

/// Under variation each example but the one that is wrong on purpose is passed or handled.
#[test]
fn every_example_holds_under_variation() {
    for name in NAMES.into_iter().filter(|name| !name.ends_with("hasty")) {
        let program = example(name);
        let compiled = lang::back::compile(&program).unwrap();
        let scene = read(&folder().join(format!("{name}.cell.toml")), &program);
        let world = World::unattended();
        let options = Options { record: false, judged: false, ..Options::default() };
        let case = Case {
            program: &program,
            compiled: &compiled,
            world: &world,
            scene: &scene,
            options: &options,
        };
        let plan =
            Plan { runs: 6, seed: 1, jobs: 2, shard: (0, 1), within: None, until_fails: false };
        let proof = proof::prove(&case, &plan, &|| false, &|_| {}).unwrap();
        assert!(proof.holds(), "{}", proof.table(name, &|line| line, &|_| None));
    }
}
