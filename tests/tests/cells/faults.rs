//! Each fault that a cell may vary by, on a scene: what it does to a run, and what the run is called. The same on the
//! engines that evaluate the script themselves.

use cell::vary::Deviation;
use lang::hir::Program;
use lang::profile::{Input, InputRole};
use pasapas::scene::proof::{Case, Class};
use pasapas::sim::world::World;
use pasapas::sim::{Engine, Options, run_traced};

use super::{cell, program};

const SCRIPT: &str = r#"OUTPUT pump = 3
INPUT held = 3, eye = 5
DIM n, seen
Home
WaitStart
FOR n = 0 TO 1
  IF IN(eye) THEN PRINT "eye hangs"
  G0 X[20mm + n * 15mm] Y30
  MoveAxe Z, -22.5mm, 40mm/s
  SetOut pump, ON
  WaitIn? held, ON, 300ms
  IF TIMEDOUT THEN
    PRINT "no part "; n + 1
    SetOut pump, OFF
    MoveAxe Z, 0mm
  ELSE
    MoveAxe Z, 0mm
    G0 X45
    Wait 100ms
    IF IN(eye) THEN seen = seen + 1
    G0 X[60mm + n * 15mm] Y60
    MoveAxe Z, -12mm, 40mm/s
    SetOut pump, OFF
    WaitIn held, OFF, 500ms
    MoveAxe Z, 0mm
  END IF
NEXT
PRINT seen; " seen"
"#;

const CELL: &str = r#"cell = 1
table = -60
tool = [{ name = "nozzle", kind = "vacuum", output = "pump", input = "held", build_ms = 60, reach = 1.5, body = [{ at = [0, 0, 2], size = [6, 6, 40] }] }]
part = [{ name = "chip", size = [8, 8, 4] }]
feeder = [{ name = "tray", part = "chip", at = [20, 30, -26], pitch = [15, 0], count = [2, 1] }]
place = [{ name = "box", at = [67.5, 60, -16.5], size = [30, 12, 10], room = 0 }]
sensor = [{ name = "eye", kind = "beam", from = [45, 0, -2], to = [45, 120, -2], input = "eye", sees = ["held"], on_ms = 2 }]
person = [{ name = "helper", does = "start", when = "wait_start" }]
expect = [{ what = "in_place", place = "box", of = "tray", turn_within_deg = 5 }, { what = "no_collision" }, { what = "no_drop", within = 1.5 }, { what = "time", below_s = 30 }]
"#;

/// What becomes of a run: its outcome, what it prints, and how long it takes, s.
type Became = (Class, Vec<String>, f64);

/// The machine has a safety door at input 6.
fn with_door() -> Program {
    let mut program = program(SCRIPT);
    let door = Input { n: 6, name: None, role: Some(InputRole::Door), invert: false, filter_ms: 5 };
    program.profile.inputs.retain(|input| input.n != 6);
    program.profile.inputs.push(door);
    program
}

fn became(deviations: &[Deviation]) -> Became {
    let program = with_door();
    let compiled = lang::back::compile(&program).unwrap();
    let scene = cell(CELL, &program);
    let (world, options) = (World::unattended(), Options::default());
    let case = Case {
        program: &program,
        compiled: &compiled,
        world: &world,
        scene: &scene,
        options: &options,
    };
    let ran = case.run(deviations).unwrap();
    let around = world.clone().with_scene(Some(scene.deviating(deviations.to_vec())));
    let (rhai, _) = run_traced(&program, Engine::Rhai, &around, &options).unwrap();
    let other = rhai.cell.expect("a cell");
    let was = |report: &pasapas::scene::Report| {
        let rows = report.rows.iter().map(|row| (row.name.clone(), row.holds));
        (rows.collect::<Vec<_>>(), report.end.printed.clone(), report.end.on.clone())
    };
    assert_eq!(was(&other), was(&ran.report), "{deviations:?}");
    assert_eq!((rhai.end.status, rhai.end.fault), (ran.end.status, ran.end.fault));
    (ran.class, ran.report.end.printed.clone(), ran.report.end.us as f64 / 1e6)
}

const RIGHT: &[&str] = &["2 seen"];
const ONE: &[&str] = &["1 seen"];
const NONE: &[&str] = &["0 seen"];
const NO_PART: &[&str] = &["no part 1", "1 seen"];
const NO_PARTS: &[&str] = &["no part 1", "no part 2", "0 seen"];

/// A fault, the outcome, what is printed, and how much longer the run takes at least, s.
type Row = (&'static str, Class, &'static [&'static str], f64);

const ROWS: &[Row] = &[
    ("missing tray.1", Class::Handled, NO_PART, -9.0),
    ("stuck tray.1 900ms", Class::Wrong, RIGHT, -9.0),
    ("stuck tray.2 9000ms", Class::Unsafe, RIGHT, -9.0),
    ("lost tray.1 200ms", Class::Wrong, ONE, -9.0),
    ("double tray.1", Class::Wrong, RIGHT, -9.0),
    ("turned tray.1", Class::Wrong, RIGHT, -9.0),
    ("slow nozzle 350ms", Class::Wrong, NO_PARTS, -9.0),
    ("slow eye 400ms", Class::Passed, NONE, -9.0),
    ("bounce eye 200ms", Class::Passed, RIGHT, -9.0),
    ("dead_on eye", Class::Passed, &["eye hangs", "eye hangs", "2 seen"], -9.0),
    ("dead_off eye", Class::Passed, NONE, -9.0),
    ("dead_off nozzle", Class::Wrong, NO_PARTS, -9.0),
    ("dead_on nozzle", Class::Fault, &[], -9.0),
    ("stall X 300st at 8s", Class::Wrong, NO_PARTS, -9.0),
    ("stall Z 300st at 8s", Class::Fault, &["no part 1"], -9.0),
    ("pause at 5s", Class::Passed, RIGHT, 1.9),
    ("stop at 5s", Class::Handled, &[], -9.0),
    ("estop at 5s", Class::Handled, &[], -10.0),
    ("door at 9s", Class::Passed, RIGHT, 0.5),
    ("late helper 5000ms", Class::Passed, RIGHT, 4.9),
    ("late helper 25000ms", Class::Handled, RIGHT, 24.9),
    ("gone at 5s", Class::Passed, RIGHT, -0.1),
];

#[test]
fn each_fault_does_what_it_says() {
    let (class, printed, takes) = became(&[]);
    assert_eq!((class, printed), (Class::Passed, vec!["2 seen".to_owned()]));
    let mut wrong = Vec::new();
    for (text, wanted, says, longer) in ROWS {
        let (class, printed, us) = became(&[Deviation::parse(text).unwrap()]);
        if class != *wanted || printed != *says || us < takes + longer {
            wrong.push(format!("{text}: {class:?} {printed:?} {us:.2} s for {takes:.2} s"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    // Each fault of the format is in the table, but the one that strikes nobody yet.
    for fault in cell::keys::FAULTS {
        let known = ROWS.iter().any(|row| row.0.split(' ').next() == Some(fault));
        assert_eq!(known, *fault != "power", "{fault}");
    }
}
