//! Scripts in their cells, on the native machine and on the emulated board.

use std::path::{Path, PathBuf};

use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::hir::Program;
use lang::profile::Profile;
use pasapas::board::engine::{self, BoardRun, run_native_traced};
use pasapas::board::{DEFAULT, F5529};
use pasapas::scene::{self, Report, Scene};
use pasapas::sim::trace::{Event, to_text};
use pasapas::sim::world::World;
use pasapas::sim::{Engine, Options, run_traced};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples")
}

fn program(text: &str) -> Program {
    let source = Source::new("job.bas", text.to_owned());
    let (program, diags) = compile(&source, ProfileChoice::built_in());
    program.unwrap_or_else(|| panic!("{}", diags.render(&source)))
}

fn example(name: &str) -> Program {
    program(&std::fs::read_to_string(folder().join(format!("{name}.bas"))).unwrap())
}

/// A cell of this text, beside the examples' files.
fn cell(text: &str, program: &Program) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("job.cell.toml");
    std::fs::write(&file, text).unwrap();
    read(&file, program)
}

fn read(file: &Path, program: &Program) -> Scene {
    let read = scene::read(&file.display().to_string(), &program.profile, Some(program));
    let (scene, notes) = read.unwrap_or_else(|notes| panic!("{notes:#?}"));
    assert!(notes.is_empty(), "{notes:#?}");
    scene
}

fn native(program: &Program, world: &World) -> (BoardRun, Vec<Event>) {
    let compiled = lang::back::compile(program).unwrap();
    run_native_traced(DEFAULT, program, &compiled, world, &Options::default()).unwrap()
}

fn board(program: &Program, world: &World) -> (BoardRun, Vec<Event>) {
    let own = lang::back::compile(program).unwrap();
    engine::run_traced(&F5529, program, &own.image, &own.sidecar, world, &Options::default())
        .unwrap()
}

fn report(run: BoardRun) -> Report {
    run.outcome.cell.expect("the run had a cell")
}

/// What happened, without its times.
fn words(report: &Report) -> Vec<String> {
    let without_time = |line: String| line.split_once(',').unwrap().1.to_owned();
    report.log.iter().map(|event| without_time(event.json())).collect()
}

/// The same without the masses of beads: a valve is open a millisecond less where its pulse begins in another phase of one.
fn shapes(report: &Report) -> Vec<String> {
    let without_mass = |line: String| match line.split_once(",\"mg\":") {
        Some((shape, _)) => shape.to_owned(),
        None => line,
    };
    words(report).into_iter().map(without_mass).collect()
}

const MOVES: &str = "OUTPUT pump = 3\nHome\nG0 X30 Y20\nSetOut pump, ON\nMoveAxe Z, -8mm, 40mm/s\nWait 100ms\n\
                     MoveAxe Z, 0mm\nG1 X55 Y35 F1500\nSetOut pump, OFF\nG2 X40 Y20 R15\nWait 50ms\n";

/// Things everywhere, and no input bound.
const DUMB: &str = r#"cell = 1
table = -40
tool = [{ name = "nozzle", kind = "vacuum", output = "pump", body = [{ at = [0, 0, 2], size = [10, 10, 30] }] }]
part = [{ name = "chip", size = [8, 8, 4] }]
feeder = [{ name = "tray", part = "chip", at = [30, 20, -12], pitch = [12, 12], count = [3, 3] }]
fixture = [{ name = "wall", at = [48, 30, -20], size = [2, 40, 60] }, { name = "lid", at = [80, 80, -20], size = [9, 9, 9], opens_by = "pump", open_at = [99, 80, -20] }]
"#;

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(12))]

    /// A cell changes what a script does through inputs alone: one that drives none leaves the trace as it is, to the
    /// microsecond.
    #[test]
    fn a_cell_without_inputs_leaves_the_trace_as_it_is(
        x in 5..60i32, y in 5..60i32, wall in 10..70i32, high in 1..40i32, wide in 1..30i32,
    ) {
        let text = MOVES.replace("X30 Y20", &format!("X{x} Y{y}"));
        let program = program(&text.replace("G2 X40 Y20 R15\n", ""));
        let cell_text = DUMB.replace("[48, 30, -20], size = [2, 40, 60]", &format!("[{wall}, 30, -30], size = [{wide}, 40, {high}]"));
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("job.cell.toml");
        std::fs::write(&file, cell_text).unwrap();
        // What stands in one another at the start is refused, and is another test's.
        if let Ok((scene, _)) = scene::read(&file.display().to_string(), &program.profile, Some(&program)) {
            let (_, without) = native(&program, &World::empty());
            let (run, with) = native(&program, &World::empty().with_scene(Some(scene)));
            proptest::prop_assert_eq!(to_text(&with), to_text(&without));
            let us = |events: &[Event]| events.iter().map(|event| event.us).collect::<Vec<_>>();
            proptest::prop_assert_eq!(us(&with), us(&without));
            proptest::prop_assert!(run.outcome.cell.is_some());
        }
    }
}

#[test]
fn parts_are_picked_and_placed_by_the_true_vacuum() {
    let program = example("pick_place");
    let scene = read(&folder().join("pick_place.cell.toml"), &program);
    let (run, events) = native(&program, &World::unattended().with_scene(Some(scene)));
    let report = report(run);
    assert!(report.holds(), "{}", report.table());
    let trace = to_text(&events);
    assert!(
        trace.contains("no part in row 1, column 1") && trace.contains("11 parts placed"),
        "{trace}"
    );
    // The first contact is made on the way down; the pump goes on at the end of it.
    let out = events
        .iter()
        .find(|event| matches!(event.what, pasapas::sim::trace::What::Out { v: 1, .. }));
    let (on, taken) = (out.unwrap().us.unwrap(), report.log[0].us);
    // 90 ms * ln(60 / 40) after the output's edge, which is within the millisecond of the event: the chain is written then.
    assert!((36_492..37_600).contains(&(taken - on)), "taken {} us after the output", taken - on);
}

#[test]
fn a_part_carried_too_low_is_reported_with_its_line() {
    let text = std::fs::read_to_string(folder().join("pick_place.bas")).unwrap();
    // The second lift of the loop, over the wall, is too low.
    let low =
        text.replacen("MoveAxe Z, 0mm\n    IF TIMEDOUT", "MoveAxe Z, -14mm\n    IF TIMEDOUT", 1);
    assert_ne!(low, text);
    let program = program(&low);
    let scene = read(&folder().join("pick_place.cell.toml"), &program);
    let (run, _) = native(&program, &World::unattended().with_scene(Some(scene)));
    let report = report(run);
    let table = report.table();
    let line = low.lines().position(|line| line.contains("G0 X[BELT_X]")).unwrap() + 1;
    // The wall begins at X 98 and the part is 8 wide: the first step after 94.
    assert!(
        table.contains(&format!("tray.1 hit wall at 94.01 47.08 -14.00 in line {line}")),
        "{table}"
    );
}

/// The same events in the same order on the real image; times are those that language.md promises.
#[test]
fn the_board_sees_the_same_cell() {
    let program = program(
        "OUTPUT pump = 3\nINPUT held = 3\nHome\nG0 X20 Y30\nMoveAxe Z, -22mm, 40mm/s\nSetOut pump, ON\n\
         WaitIn? held, ON, 400ms\nMoveAxe Z, 0mm\nIF TIMEDOUT THEN\nPRINT \"nothing\"\nEND IF\nG0 X60 Y60\n\
         MoveAxe Z, -12mm, 40mm/s\nSetOut pump, OFF\nWaitIn held, OFF, 500ms\nMoveAxe Z, 0mm\n",
    );
    let text = r#"cell = 1
table = -60
tool = [{ name = "nozzle", kind = "vacuum", output = "pump", input = "held", reach = 1.5 }]
part = [{ name = "chip", size = [8, 8, 4] }]
feeder = [{ name = "tray", part = "chip", at = [20, 30, -26] }]
place = [{ name = "belt", at = [60, 60, -16.5], size = [20, 20, 10] }]
sensor = [{ name = "eye", kind = "beam", from = [40, 0, -2], to = [40, 100, -2], input = 5, sees = ["held"], on_ms = 2 }]
expect = [{ what = "in_place", place = "belt" }, { what = "prints", text = "nothing", count = 0 }]
"#;
    let world = World::unattended().with_scene(Some(cell(text, &program)));
    let (on_machine, machine_trace) = native(&program, &world);
    let (on_board, board_trace) = board(&program, &world);
    assert_eq!(to_text(&machine_trace), to_text(&board_trace));
    let [machine, board] = [on_machine, on_board].map(report);
    assert!(machine.holds() && board.holds(), "{}\n{}", machine.table(), board.table());
    assert_eq!(words(&machine), words(&board));
    assert!(words(&machine).len() >= 5, "{:?}", words(&machine));
    for (machine, board) in machine.log.iter().zip(&board.log) {
        let most = (board.us as f64 * 0.02).max(10_000.0);
        assert!(machine.us.abs_diff(board.us) as f64 <= most, "{machine:?} {board:?}");
    }
}

#[test]
fn the_frame_is_that_of_the_profile() {
    let program = program("Home\nG0 X5\n");
    let scene = cell("cell = 1\n", &program);
    let mill = Profile::built_in("mill").unwrap();
    let (frame, switches) = scene.frame(&mill, [None; 3]);
    assert_eq!(frame.scale, [100.0; 3]);
    // The switches close 20 mm off, as in every world: X and Y below, Z above.
    assert_eq!(switches, [Some(-2000), Some(-2000), Some(2000)]);
    assert_eq!(frame.start, [19.99, 19.99, -19.99]);
    // Z of this machine counts downward.
    let (frame, _) = scene.frame(&Profile::built_in("charly").unwrap(), [None; 3]);
    assert!(frame.scale[2] < 0.0 && frame.start[2] < 0.0, "{frame:?}");
    let given = cell("cell = 1\nstart = [1, 2, -3]\n", &program);
    assert_eq!(given.frame(&mill, [None; 3]).0.start, [1.0, 2.0, -3.0]);
}

/// What happens in each example's cell is the same on the engines that evaluate the script themselves, at the same times
/// but for those of statements.
#[test]
fn every_engine_sees_the_same_cell() {
    for name in ["glue_dots", "pcb_drill", "pick_place"] {
        let program = example(name);
        let scene = read(&folder().join(format!("{name}.cell.toml")), &program);
        let world = World::unattended().with_scene(Some(scene));
        let (on_machine, machine_trace) = native(&program, &world);
        let machine = report(on_machine);
        assert!(machine.holds(), "{name}\n{}", machine.table());
        for engine in [Engine::Vm, Engine::Rhai] {
            let (outcome, trace) =
                run_traced(&program, engine, &world, &Options::default()).unwrap();
            let own = outcome.cell.expect("the run had a cell");
            assert!(own.holds(), "{name} on {engine:?}\n{}", own.table());
            assert_eq!(to_text(&trace), to_text(&machine_trace), "{name} on {engine:?}");
            assert_eq!(shapes(&own), shapes(&machine), "{name} on {engine:?}");
            // Where a reference switch is found, a millisecond is some steps of way: times count from the first event.
            let [from, machine_from] = [&own, &machine].map(|report| report.log[0].us);
            for (own, machine) in own.log.iter().zip(&machine.log) {
                let most = (machine.us as f64 * 0.001).max(5_000.0);
                let apart = (own.us - from).abs_diff(machine.us - machine_from) as f64;
                assert!(apart <= most, "{name} on {engine:?}: {own:?} {machine:?}");
            }
        }
    }
}

mod beside;
mod examples;
mod faults;
mod generated;
mod heeded;
mod played;
mod proofs;
