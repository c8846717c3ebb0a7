use lang::axis::Axis;

use super::{Action, Button, Registers, World};
use crate::sim::trace::PerAxis;

fn press(button: Button, down: bool) -> Action {
    Action::Button { button, down }
}

/// Everything that a world does until it is empty, with its times.
fn play(source: &str) -> Vec<(u64, Action)> {
    let mut scenario =
        World::parse("w.rhai", source).unwrap().start(&Registers::default()).unwrap();
    let mut seen = Vec::new();
    while let Some(us) = scenario.next_us() {
        seen.extend(scenario.advance(us).unwrap().into_iter().map(|action| (us, action)));
    }
    seen
}

fn error(source: &str) -> String {
    match World::parse("w.rhai", source) {
        Err(error) => error.to_string(),
        Ok(world) => match world.start(&Registers::default()) {
            Err(error) => error.to_string(),
            Ok(mut scenario) => {
                while let Some(us) = scenario.next_us() {
                    if let Err(error) = scenario.advance(us) {
                        return error.to_string();
                    }
                }
                panic!("no error")
            }
        },
    }
}

#[test]
fn things_happen_at_their_times_in_the_order_written() {
    let seen = play(
        "at(20, || set_in(3, true)); at(10, || { set_in(1, 1); at(15, || send_char(65)); });
         at(20, || set_in(4, false)); press_start(); hold_stop(30, 2500);
         fault_at(40, \"stall\", \"Y\", 12); at(50, || press_estop());",
    );
    let expected = [
        (0, press(Button::Start, true)),
        (10_000, Action::Input { n: 1, on: true }),
        (15_000, Action::Char(65)),
        (20_000, Action::Input { n: 3, on: true }),
        (20_000, Action::Input { n: 4, on: false }),
        (30_000, press(Button::Stop, true)),
        (40_000, Action::Stall { axis: Axis::Y, steps: 12 }),
        (50_000, Action::EmergencyStop),
        (100_000, press(Button::Start, false)),
        (2_530_000, press(Button::Stop, false)),
    ];
    assert_eq!(seen, expected);
}

#[test]
fn an_output_hook_fires_at_each_edge_and_closures_keep_their_state() {
    let world = World::parse(
        "w.rhai",
        "let count = 0; after_out(1, true, 80, || { count += 1; set_in(2, count == 2); });",
    );
    let mut scenario = world.unwrap().start(&Registers::default()).unwrap();
    scenario.output_changed(1, true, 1_000);
    scenario.output_changed(1, false, 2_000);
    assert_eq!(scenario.next_us(), Some(81_000));
    assert_eq!(scenario.advance(81_000).unwrap(), [Action::Input { n: 2, on: false }]);
    assert_eq!(scenario.next_us(), None);
    scenario.output_changed(1, true, 100_000);
    assert_eq!(scenario.advance(180_000).unwrap(), [Action::Input { n: 2, on: true }]);
}

#[test]
fn plates_have_a_side_and_expectations_name_their_line() {
    let world = World::parse(
        "w.rhai",
        "probe_at(\"Z\", -1840); switch_at(\"X\", -2000);\nexpect_out(1, false);\nexpect_pos(\"X\", 5);",
    );
    let scenario = world.unwrap().start(&Registers::default()).unwrap();
    assert_eq!(scenario.switch_place(Axis::X), Some(-2000));
    assert!(!scenario.probe_touches([0, 0, -1839]));
    assert!(scenario.probe_touches([0, 0, -1840]));
    let pos = PerAxis::new([Some(4), None, None]);
    assert_eq!(
        scenario.failures(&|n| n == 1, &pos),
        ["w.rhai:2: output 1 is on, expected off", "w.rhai:3: X is at 4, expected 5"]
    );
}

#[test]
fn mistakes_have_a_place_and_a_remedy() {
    let cases = [
        ("at(5, || set_in(0, true));", "w.rhai:1:10: error[S002]: number 0; inputs and outputs"),
        ("\nset_inn(1, true);", "w.rhai:2:1: error[S002]: there is no function `set_inn"),
        ("at(1", "w.rhai:1:5: error[S001]: "),
        ("loop {}", "w.rhai:1:6: error[S002]: a callback took more than"),
        ("probe_at(\"Q\", 3)", "w.rhai:1:1: error[S002]: `Q` is no axis"),
        ("eval(\"1\")", "w.rhai:1:1: error[S001]: "),
        ("at(-1, || 0)", "w.rhai:1:1: error[S002]: a time of -1 ms"),
        ("fn f() { at(0, || f()); at(0, || f()); } f();", "w.rhai:1:"),
        ("let s = \"x\"; loop { s += s; }", "w.rhai:1:"),
    ];
    for (source, start) in cases {
        let text = error(source);
        assert!(text.starts_with(start), "{source}: {text}");
    }
}

#[test]
fn worlds_are_bounded_in_time_and_memory() {
    let hungry = [
        "loop { }",
        "while true { at(1, || 1); }",
        "let n = 0; while n < 1000000000 { n += 1; }",
        "fn deep(n) { deep(n + 1) } deep(0);",
        "let s = \"x\"; loop { s += s; }",
        "let a = []; loop { a.push(a.len()); }",
        "let a = [1]; loop { a += a; }",
        "let m = #{}; let n = 0; loop { m[\"k\" + n] = n; n += 1; }",
        "let b = blob(2000000000);",
        "let b = blob(); b.pad(2000000000, 1);",
        "let a = []; a.pad(2000000000, 1);",
        "let s = \"x\"; s.pad(2000000000, \"y\");",
        "let r = 0..2000000000; for i in r { }",
    ];
    for source in hungry {
        let world = World::parse("w.rhai", source);
        let ended = world.and_then(|world| world.start(&Registers::default()).map(drop));
        assert!(ended.is_err(), "{source} goes on");
    }
    // A callback is bounded, too.
    let world = World::parse("w.rhai", "at(1, || { loop { } });").expect("it is sound");
    let mut scenario = world.start(&Registers::default()).expect("it starts");
    assert!(scenario.advance(2_000).is_err());
}

#[test]
fn worlds_touch_no_files_and_run_nothing() {
    let reaching = [
        "open_file(\"Cargo.toml\")",
        "import \"Cargo\" as c;",
        "eval(\"1\")",
        "let p = path(\".\");",
        "std::fs::write(\"x\", \"y\")",
        "create_file(\"x\")",
        "system(\"true\")",
        "env(\"HOME\")",
    ];
    for source in reaching {
        let ended = World::parse("w.rhai", source)
            .and_then(|world| world.start(&Registers::default()).map(drop));
        assert!(ended.is_err(), "{source} is taken");
    }
}
