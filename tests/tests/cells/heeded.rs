//! Keys of a cell that a whole machine heeds, on the firmware's own machine and on the emulated board: the output of a
//! role, the place of a reference switch, `stop_on`, and `count` below the parts of a tray.

use cell::vary::Deviation;
use pasapas::scene::proof::{Case, Class};
use pasapas::sim::Options;
use pasapas::sim::record::StopReason;
use pasapas::sim::trace::Status;
use pasapas::sim::world::World;

use super::{board, cell, native, program, report};

/// A script in a cell on both, which say the same.
fn both(script: &str, text: &str) -> [(pasapas::board::engine::BoardRun, &'static str); 2] {
    let program = program(script);
    let world = World::unattended().with_scene(Some(cell(text, &program)));
    [(native(&program, &world).0, "native"), (board(&program, &world).0, "board")]
}

#[test]
fn a_drill_without_an_output_turns_with_the_spindle() {
    let script = "PROFILE \"mill\"\nM3\nG0 X10 Y10\nG1 Z-1 F100\nG0 Z0\nM5\n";
    let text = "cell = 1\ntool = [{ kind = \"drill\", diameter = 0.8 }]\nstock = { at = [10, 10, -2.5], size = [20, 20, 2] }\n\
                expect = [{ what = \"holes\", at = [[10, 10]], diameter = 0.8, depth = 0.5 }, { what = \"no_collision\" }]\n";
    for (run, on) in both(script, text) {
        let report = report(run);
        assert!(report.holds(), "{on}:\n{}", report.table());
    }
}

const HOMES: &str = "Home\nG0 X30 Y30\nPRINT \"there\"\n";

#[test]
fn a_switch_that_has_moved_moves_the_machine() {
    let text = |place: f64| {
        format!(
            "cell = 1\ntool = [{{ kind = \"none\", body = [{{ at = [0, 0, 0], size = [2, 2, 2] }}] }}]\n\
             sensor = [{{ name = \"home x\", kind = \"switch\", axis = \"X\", place = {place}, side = -1 }}, \
             {{ name = \"at 30\", kind = \"box\", at = [30, 30, -5], size = [0.2, 0.2, 20], sees = [\"tool\"] }}, \
             {{ name = \"at 32\", kind = \"box\", at = [32, 30, -5], size = [0.2, 0.2, 20], sees = [\"tool\"] }}]\n\
             expect = [{{ what = \"never\", sensor = \"at 32\" }}]\n"
        )
    };
    for (place, holds) in [(-0.01, true), (2.0, false)] {
        for (run, on) in both(HOMES, &text(place)) {
            assert_eq!(run.outcome.end.status, Status::Done, "{on}");
            let report = report(run);
            assert_eq!(report.holds(), holds, "{on} {place}:\n{}", report.table());
        }
    }
}

#[test]
fn a_collision_ends_a_run_where_the_cell_wants_that() {
    let script = "OUTPUT pump = 3\nHome\nG0 X50 Y20\nG1 X10 F600\nPRINT \"went on\"\n";
    let text = |stop: &str| {
        format!(
            "cell = 1\n{stop}tool = [{{ kind = \"none\", body = [{{ at = [0, 0, 0], size = [4, 4, 20] }}] }}]\n\
             fixture = [{{ name = \"wall\", at = [35, 20, -10], size = [2, 9, 30] }}]\n\
             expect = [{{ what = \"no_collision\" }}, {{ what = \"prints\", text = \"went on\" }}]\n"
        )
    };
    for (run, on) in both(script, &text("stop_on = [\"collision\"]\n")) {
        assert_eq!(run.outcome.end.status, Status::Stopped, "{on}");
        assert_eq!(run.outcome.summary.stopped, Some(StopReason::Collision), "{on}");
        let report = report(run);
        assert!(report.rows.iter().all(|row| !row.holds), "{on}:\n{}", report.table());
    }
    for (run, on) in both(script, &text("")) {
        assert_eq!(run.outcome.end.status, Status::Done, "{on}");
        let rows = report(run).rows;
        assert!(!rows[0].holds && rows[1].holds, "{on}: {rows:?}");
    }
}

const FIVE: &str = "OUTPUT pump = 3\nINPUT held = 3\nDIM n\nHome\nFOR n = 0 TO LAST\n  G0 X[20mm + n * 15mm] Y30\n  \
    MoveAxe Z, -22.5mm, 40mm/s\n  SetOut pump, ON\n  WaitIn? held, ON, 400ms\n  IF TIMEDOUT THEN\n    PRINT \"no part\"\n    \
    SetOut pump, OFF\n    MoveAxe Z, 0mm\n  ELSE\n    MoveAxe Z, 0mm\n    G0 X40 Y60\n    MoveAxe Z, -12mm, 40mm/s\n    \
    SetOut pump, OFF\n    WaitIn held, OFF, 500ms\n    MoveAxe Z, 0mm\n  END IF\nNEXT\n";

const TRAY: &str = r#"cell = 1
table = -60
tool = [{ name = "nozzle", kind = "vacuum", output = "pump", input = "held", build_ms = 60, reach = 1.5, body = [{ at = [0, 0, 2], size = [6, 6, 40] }] }]
part = [{ name = "chip", size = [8, 8, 4] }]
feeder = [{ name = "tray", part = "chip", at = [20, 30, -26], pitch = [15, 0], count = [4, 1] }]
place = [{ name = "box", at = [40, 60, -16.5], size = [20, 12, 10], room = 0 }]
expect = [{ what = "in_place", place = "box", of = "tray", count = 2 }]
"#;

/// The outcome with a deviation where the script goes to pockets 1 to `last + 1`.
fn outcome(last: u32, deviation: &str) -> Class {
    let program = program(&FIVE.replace("LAST", &last.to_string()));
    let compiled = lang::back::compile(&program).unwrap();
    let scene = cell(TRAY, &program);
    let (world, options) = (World::unattended(), Options::default());
    let case = Case {
        program: &program,
        compiled: &compiled,
        world: &world,
        scene: &scene,
        options: &options,
    };
    let deviations: Vec<Deviation> = deviation
        .split(", ")
        .filter(|text| !text.is_empty())
        .map(|text| Deviation::parse(text).unwrap())
        .collect();
    case.run(&deviations).unwrap().class
}

#[test]
fn parts_that_nobody_counts_excuse_nothing_and_need_no_excuse() {
    for (last, deviation, wanted) in [
        (1, "", Class::Passed),
        (1, "missing tray.1", Class::Handled),
        (1, "missing tray.1, missing tray.2", Class::Handled),
        // One too few without a reason, and one too many.
        (0, "", Class::Wrong),
        (2, "", Class::Wrong),
        (2, "missing tray.4", Class::Wrong),
        // What was taken and lost is no part that stayed.
        (1, "lost tray.1 200ms", Class::Wrong),
        // A part that nobody fetches is missing: nothing is wrong.
        (1, "missing tray.4", Class::Passed),
    ] {
        assert_eq!(outcome(last, deviation), wanted, "{last} {deviation}");
    }
}
