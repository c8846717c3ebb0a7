//! Worlds beside cells: what they ask and move, on every engine.

use pasapas::sim::trace::{Event, What};
use pasapas::sim::world::World;
use pasapas::sim::{Engine, Options, run_traced};

use super::{board, cell, native, program};

const SCRIPT: &str = "OUTPUT pump = 3
INPUT held = 3, told = 5, carried = 6, lies = 7
Home
G0 X20 Y30
pick
IF IN(told) THEN PRINT \"told\"
IF IN(carried) THEN PRINT \"carried\"
G0 X60 Y60
MoveAxe Z, -12mm, 40mm/s
SetOut pump, OFF
WaitIn held, OFF, 500ms
Wait 300ms
IF IN(lies) THEN PRINT \"lies in the box\"
MoveAxe Z, 0mm
G0 X35 Y30
pick
SetOut pump, OFF
Wait 300ms
pick
SetOut pump, OFF
Wait 300ms
G0 X50 Y30
pick
END

SUB pick
  MoveAxe Z, -22.5mm, 40mm/s
  SetOut pump, ON
  WaitIn? held, ON, 400ms
  IF TIMEDOUT THEN
    PRINT \"no part\"
  ELSE
    PRINT \"part\"
  END IF
  MoveAxe Z, 0mm
END SUB
";

const CELL: &str = r#"cell = 1
table = -60
tool = [{ name = "nozzle", kind = "vacuum", output = "pump", input = "held", reach = 1.5 }]
part = [{ name = "chip", size = [8, 8, 4] }]
feeder = [{ name = "tray", part = "chip", at = [20, 30, -26], pitch = [15, 15], count = [3, 1] }]
fixture = [{ name = "floor", at = [35, 30, -30], size = [60, 30, 4] }]
place = [{ name = "box", at = [60, 60, -16.5], size = [12, 12, 10] }]
"#;

/// Pocket 2 is emptied before the run and filled while the nozzle waits over it; the switch hangs at the third part.
const WORLD: &str = r#"
remove("tray.2");
let picks = 0;
at_take("tray.1", || {
    set_in(5, true);
    after(100, || {
        let thing = where_is("tray.1");
        if thing.state == "held" && thing.place == "" && where_is("tray.2").state == "gone" { set_in(6, true); }
    });
});
after_out(3, false, 100, || {
    let thing = where_is("tray.1");
    if thing.state == "stands" && thing.place == "box" && thing.x > 59900 && thing.x < 60100 && thing.z == -16500 { set_in(7, true); }
});
after_out(3, true, 50, || {
    picks += 1;
    if picks == 3 { put("tray.2"); }
});
after_out(3, false, 200, || {
    if picks == 3 { force_in(3, false); after(3000, || free_in(3)); }
});
"#;

const SAID: [&str; 7] =
    ["part", "told", "carried", "lies in the box", "no part", "part", "no part"];

fn said(events: &[Event]) -> Vec<&str> {
    let texts = events.iter().filter_map(|event| match &event.what {
        What::Print { text, .. } => Some(text.as_str()),
        _ => None,
    });
    texts.collect()
}

#[test]
fn a_world_asks_and_moves_the_things_of_its_cell() {
    let program = program(SCRIPT);
    let world = World::parse("job.rhai", WORLD).unwrap();
    let world = world.with_scene(Some(cell(CELL, &program)));
    let (_, events) = native(&program, &world);
    assert_eq!(said(&events), SAID, "native");
    for engine in [Engine::Vm, Engine::Rhai] {
        let options = Options::default();
        let (_, events) = run_traced(&program, engine, &world, &options).unwrap();
        assert_eq!(said(&events), SAID, "{engine:?}");
    }
    let (_, events) = board(&program, &world);
    assert_eq!(said(&events), SAID, "board");
}

/// A world that names what is not there is told so, with the nearest name.
#[test]
fn a_world_that_names_nothing_is_told() {
    let program = program("OUTPUT pump = 3\nINPUT held = 3\nWait 10ms\n");
    let told = |text: &str, cell_text: Option<&str>| {
        let world = World::parse("job.rhai", text).unwrap();
        let world = world.with_scene(cell_text.map(|text| cell(text, &program)));
        let options = Options::default();
        match run_traced(&program, Engine::Vm, &world, &options) {
            Ok(_) => String::new(),
            Err(error) => error.to_string(),
        }
    };
    for call in
        ["at_take(\"trai\", || 1)", "remove(\"tray.4\")", "put(\"tray\")", "where_is(\"tray.0\")"]
    {
        let text = told(call, Some(CELL));
        assert!(
            text.contains("job.rhai:1:")
                && text.contains("the cell has no \"")
                && text.contains("is meant?"),
            "{text}"
        );
    }
    assert!(told("where_is(\"tray.1\")", None).contains("there is no cell"));
}
