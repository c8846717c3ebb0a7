//! What varies: each number that the check lets pass differs in the run, and parts that come later draw as others do.

mod machine;

use std::sync::Arc;

use cell::kernel::{Cell, Frame};
use cell::keys::{self, Kind};
use cell::scene::Scene;
use cell::things::Where;
use cell::vary::{self, Deviation};
use machine::{Machine, Plain, SCALE};

fn read(text: &str) -> (Scene, Vec<String>) {
    let (scene, problems) = cell::read(text, &Plain, &|_| None, &|_| Err("none".to_owned()))
        .unwrap_or_else(|problems| {
            panic!("{:?}", problems.iter().map(|own| &own.text).collect::<Vec<_>>())
        });
    let told = problems.iter().map(|own| own.render("c", text)).collect();
    (scene, told)
}

/// A machine whose cell has these deviations.
fn varied(text: &str, deviations: &[Deviation]) -> Machine {
    let mut machine = Machine::new(text);
    let scene = vary::applied(read(text).0, deviations);
    machine.cell = Cell::new(Arc::new(scene), Frame { scale: SCALE, start: [0.0; 3] });
    machine.cell.strike(deviations);
    machine
}

const ALL: &str = r##"cell = 1
TOOL
part = [{ name = "chip", size = [4, 4, 2] }, { name = "block", size = [4, 4, 2], at = [90, 90, 0] }]
feeder = [{ name = "tray", part = "chip", at = [20, 20, 0], count = [2, 1], pitch = [10, 0] }, { name = "bowl", kind = "bowl", part = "chip", at = [20, 60, 0] }]
place = [{ name = "box", at = [60, 60, 0], size = [20, 20, 10] }]
fixture = [{ name = "door", at = [150, 60, 0], size = [4, 4, 4], opens_by = 4, open_at = [150, 80, 0] }]
stock = { at = [200, 200, 0], size = [10, 10, 10] }
conveyor = [{ name = "belt", at = [100, 150, 0], size = [200, 30, 20], mm_s = 50, feeds = "chip", gap = 60 }, { name = "timed", at = [100, 190, 0], size = [200, 30, 20], mm_s = 50, feeds = "chip", every_ms = 600 }]
sensor = [{ name = "eye", kind = "beam", from = [80, 0, 25], to = [80, 100, 25], input = 2 }, { name = "look", kind = "box", at = [80, 0, 25], size = [4, 4, 4], input = 3 },
    { name = "red", kind = "colour", at = [90, 50, 25], colour = "#ff0000", input = 4 }, { name = "end", kind = "switch", axis = "X", place = 100, input = 5 }]
"##;

#[test]
fn a_number_that_passes_the_check_differs_in_the_run() {
    let tools = [
        r#"tool = [{ name = "tool", kind = "vacuum", output = 3 }]"#,
        r#"tool = [{ name = "tool", kind = "gripper", output = 3, opens = 20, grips = [5, 15] }]"#,
        r#"tool = [{ name = "tool", kind = "drill", output = 3, diameter = 1 }]"#,
        r#"tool = [{ name = "tool", kind = "dispenser", output = 3, flow_mg_s = 10 }]"#,
        r#"tool = [{ name = "tool", kind = "probe", output = 3 }]"#,
    ];
    let mut differ = 0;
    for tool in tools {
        let text = ALL.replace("TOOL", tool);
        let word = tool.split('"').nth(3).unwrap();
        let things = [
            ("tool", "tool", word),
            ("chip", "part", ""),
            ("block", "part", ""),
            ("tray", "feeder", ""),
            ("bowl", "feeder", ""),
            ("box", "place", ""),
            ("door", "fixture", ""),
            ("stock", "stock", ""),
            ("belt", "conveyor", ""),
            ("timed", "conveyor", ""),
            ("eye", "sensor", ""),
            ("look", "sensor", ""),
            ("red", "sensor", ""),
            ("end", "sensor", ""),
        ];
        let all = things.into_iter().flat_map(|(name, section, variant)| {
            keys::keys_of(section, variant)
                .filter(|key| {
                    matches!(
                        key.kind,
                        Kind::Number(..) | Kind::Point2 | Kind::Point3 | Kind::Size | Kind::Range
                    )
                })
                .map(move |key| format!("{name}.{}", key.name))
        });
        for key in all.chain(["start".to_owned()]) {
            let (scene, told) =
                read(&format!("{text}vary = [{{ key = \"{key}\", range = [0.1, 0.2] }}]\n"));
            let told = told
                .iter()
                .any(|line| line.contains("C016") && line.contains(&format!("\"{key}\"")));
            let drawn = vary::draw(&scene, 3);
            let before = format!("{scene:?}");
            let differs = format!("{:?}", vary::applied(scene, &drawn)) != before;
            assert_eq!(differs, !told, "{word} {key}: differs {differs}, told {told}: {drawn:?}");
            assert!(
                drawn.iter().all(|own| Deviation::parse(&own.text()).as_ref() == Ok(own)),
                "{key}"
            );
            differ += usize::from(differs);
        }
    }
    assert!(differ > 100, "{differ} keys");
}

#[test]
fn a_range_that_leaves_what_is_possible_is_refused_for_every_number() {
    let tool = r#"tool = [{ name = "tool", kind = "vacuum", output = 3 }]"#;
    for key in ["eye.on_ms", "timed.every_ms", "tool.hold_kpa", "bowl.advance_ms"] {
        let text = ALL.replace("TOOL", tool)
            + &format!("vary = [{{ key = \"{key}\", range = [-1e6, 1] }}]\n");
        let problems =
            cell::read(&text, &Plain, &|_| None, &|_| Err("none".to_owned())).err().unwrap();
        assert!(problems.iter().any(|own| own.text.contains("leaves what is possible")), "{key}");
    }
}

const TAPE: &str = r#"cell = 1
table = 0
tool = [{ name = "nozzle", kind = "vacuum", output = 3, build_ms = 10 }]
part = [{ name = "chip", size = [4, 4, 2] }]
feeder = [{ name = "tape", kind = "tape", part = "chip", at = [20, 20, 5], output = 5, advance_ms = 10, input = 7, length = 30 }]
conveyor = [{ name = "belt", at = [100, 150, 0], size = [200, 30, 20], drive = 6, mm_s = 50, feeds = "chip", gap = 10 }]
"#;

#[test]
fn parts_that_come_later_draw_faults_as_others_do() {
    let text = format!(
        "{TAPE}vary = [{{ fault = \"missing\", of = \"tape\", chance = 0.3 }}, {{ fault = \"missing\", of = \"belt\", chance = 0.3 }}]\n"
    );
    let drawn = vary::draw(&read(&text).0, 1);
    let of = |name: &str| drawn.iter().filter(|own| own.of.starts_with(name)).count();
    assert!((4..=15).contains(&of("tape.")), "of 30: {drawn:?}");
    assert!(of("belt.") > 30, "{drawn:?}");
    let mut machine = varied(&text, &drawn);
    machine.output(6, true);
    for _ in 1..30 {
        machine.output(5, true);
        machine.wait(100);
        machine.output(5, false);
    }
    let things = machine.cell.things();
    assert!(things.len() > 40);
    let lost = machine.said();
    for thing in things {
        let missing = thing.place == Where::Gone
            && !lost.iter().any(|line| line.contains(&format!("\"{}\"", thing.name)));
        let struck = drawn.iter().any(|own| own.of == thing.name);
        assert_eq!(missing, struck, "{thing:?}");
    }
}

#[test]
fn each_part_of_a_tape_differs_by_itself() {
    let deviations: Vec<Deviation> =
        ["tape.at tape.1 0.5 0.25", "tape.at tape.2 -1 2", "turned tape.3"]
            .into_iter()
            .map(|text| Deviation::parse(text).unwrap())
            .collect();
    let mut machine = varied(TAPE, &deviations);
    machine.go([100.0, 20.0, 30.0], 200.0);
    for _ in 1..3 {
        machine.output(5, true);
        machine.wait(100);
        machine.output(5, false);
    }
    let homes: Vec<Where> = machine
        .cell
        .things()
        .iter()
        .filter(|own| own.name.starts_with("tape"))
        .map(|own| own.home)
        .collect();
    let at = |x, y| Where::Stands([x, y, 5.0]);
    assert_eq!(homes, [at(20.5, 20.25), at(19.0, 22.0), at(20.0, 20.0)]);
    assert_eq!(machine.cell.things().last().unwrap().form.turn_deg, 90.0);
}

#[test]
fn a_tube_without_an_output_slides_on_past_a_missing_part() {
    let text = TAPE.replace("\"tape\"", "\"tube\"").replace("output = 5, ", "");
    let deviations =
        ["missing tube.1", "missing tube.2"].map(|text| Deviation::parse(text).unwrap());
    let mut machine = varied(&text, &deviations);
    machine.wait(500);
    let stand: Vec<&str> = machine
        .cell
        .things()
        .iter()
        .filter(|own| own.name.starts_with("tube") && own.place != Where::Gone)
        .map(|own| own.name.as_str())
        .collect();
    assert_eq!(stand, ["tube.3"]);
    assert_eq!(machine.inputs.iter().rfind(|own| own.1 == 7).map(|own| own.2), Some(true));
}
