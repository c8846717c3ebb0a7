//! Grippers, feeders, belts, colours and people: what acts beside the nozzle.

mod machine;

use cell::things::Where;
use machine::Machine;

/// The edges of an input, ms and state.
fn edges(machine: &Machine, input: u32) -> Vec<(f64, bool)> {
    machine
        .inputs
        .iter()
        .filter(|edge| edge.1 == input)
        .map(|&(us, _, on)| (us as f64 / 1000.0, on))
        .collect()
}

const GRIP: &str = r#"cell = 1
table = 0
tool = [{ name = "jaws", kind = "gripper", output = 2, opens = 20, grips = [5, 15], close_ms = 80, open_ms = 60, input_closed = 3, input_gripped = 4 }]
part = [{ name = "block", size = [10, 30, 20], at = [50, 50, 0] }]
"#;

fn grip(text: &str, at: [f64; 3]) -> Machine {
    let mut machine = Machine::new(text);
    machine.go([at[0], at[1], 40.0], 100.0);
    machine.go(at, 100.0);
    machine.output(2, true);
    machine.wait(200);
    machine
}

#[test]
fn a_gripper_holds_what_lies_between_its_jaws() {
    let mut machine = grip(GRIP, [51.0, 50.0, 10.0]);
    assert!(
        machine.said()[0].contains(r#""ev":"take","thing":"block","by":"jaws""#),
        "{:?}",
        machine.said()
    );
    assert_eq!((edges(&machine, 4).len(), edges(&machine, 3).len()), (1, 0));
    machine.go([51.0, 50.0, 60.0], 100.0);
    machine.go([80.0, 50.0, 60.0], 100.0);
    machine.output(2, false);
    machine.wait(10);
    // The offset of the grip is kept.
    assert_eq!(machine.cell.things()[0].place, Where::Stands([79.0, 50.0, 0.0]));
    assert!(!edges(&machine, 4).last().unwrap().1);
}

#[test]
fn jaws_that_find_nothing_meet() {
    let wide = GRIP.replace("size = [10, 30, 20]", "size = [16, 30, 20]");
    // Too far aside, too high above it, too wide for the jaws' hold, beside it in the other direction.
    for (text, at) in [
        (GRIP, [57.0, 50.0, 10.0]),
        (GRIP, [50.0, 50.0, 25.0]),
        (wide.as_str(), [50.0, 50.0, 10.0]),
        (GRIP, [50.0, 66.0, 10.0]),
    ] {
        let machine = grip(text, at);
        assert!(machine.said().is_empty(), "{at:?}: {:?}", machine.said());
        assert_eq!((edges(&machine, 4).len(), edges(&machine, 3).len()), (0, 1), "{at:?}");
    }
    // Who opens before they have closed has closed nothing.
    let mut machine = Machine::new(GRIP);
    machine.output(2, true);
    machine.wait(50);
    machine.output(2, false);
    machine.wait(200);
    assert!(edges(&machine, 3).iter().all(|edge| !edge.1), "{:?}", machine.inputs);
}

const TAPE: &str = r#"cell = 1
table = 0
tool = [{ name = "nozzle", kind = "vacuum", output = 3, build_ms = 10 }]
part = [{ name = "chip", size = [4, 4, 2] }]
feeder = [{ name = "tape", kind = "tape", part = "chip", at = [20, 20, 5], output = 5, advance_ms = 150, input = 7, length = 3 }]
place = [{ name = "box", at = [60, 60, 0], size = [20, 20, 10], room = 2 }]
person = [{ name = "helper", does = "input", when = "box full", input = 9, hold_ms = 50 }]
"#;

fn pick(machine: &mut Machine) {
    machine.go([20.0, 20.0, 30.0], 200.0);
    machine.go([20.0, 20.0, 7.0], 200.0);
    machine.output(3, true);
    machine.wait(100);
    machine.go([20.0, 20.0, 30.0], 200.0);
    machine.go([60.0, 60.0, 30.0], 200.0);
    machine.output(3, false);
    machine.wait(100);
}

#[test]
fn a_tape_brings_the_next_part_when_it_is_advanced() {
    let mut machine = Machine::new(TAPE);
    pick(&mut machine);
    assert_eq!(edges(&machine, 7).iter().map(|edge| edge.1).collect::<Vec<_>>(), [true, false]);
    machine.output(5, true);
    let advanced = machine.now as f64 / 1000.0;
    machine.wait(200);
    let ready = *edges(&machine, 7).last().unwrap();
    assert_eq!(ready, (advanced + 150.0, true));
    machine.output(5, false);
    assert!(edges(&machine, 9).is_empty());
    pick(&mut machine);
    assert_eq!(edges(&machine, 9).len(), 2, "two parts fill the box");
    let names: Vec<&str> = machine.cell.things().iter().map(|thing| thing.name.as_str()).collect();
    assert_eq!(names, ["tape.1", "tape.2"]);
    // The third comes, is not taken, and goes on with the tape; there is no fourth.
    for _ in 0..2 {
        machine.output(5, true);
        machine.wait(200);
        machine.output(5, false);
    }
    let said = machine.said();
    assert!(said.last().unwrap().contains(r#""ev":"lost","thing":"tape.3""#), "{said:?}");
    assert!(!edges(&machine, 7).last().unwrap().1);
}

#[test]
fn a_tube_sends_the_next_part_by_itself() {
    let text = TAPE.replace("kind = \"tape\"", "kind = \"tube\"").replace("output = 5, ", "");
    let mut machine = Machine::new(&text);
    pick(&mut machine);
    pick(&mut machine);
    pick(&mut machine);
    pick(&mut machine);
    let takes = machine.said().iter().filter(|line| line.contains("take")).count();
    assert_eq!(takes, 3, "its length: {:?}", machine.said());
}

#[test]
fn a_belt_brings_parts_past_an_eye_at_their_times() {
    let text = r##"cell = 1
part = [{ name = "can", size = [10, 10, 10], colour = "#ff0000" }]
conveyor = [{ name = "belt", at = [100, 50, 0], size = [200, 30, 20], drive = 6, mm_s = 50, feeds = "can", gap = 60, takes = "bin" }]
place = [{ name = "bin", at = [250, 50, 0], size = [40, 40, 40], room = 0 }]
sensor = [{ name = "eye", kind = "beam", from = [80, 0, 25], to = [80, 100, 25], input = 2 },
          { name = "red", kind = "colour", at = [90, 50, 25], colour = "#FF0000", input = 3 },
          { name = "blue", kind = "colour", at = [90, 50, 25], colour = "#0000ff", input = 4 }]
"##;
    let mut machine = Machine::new(text);
    machine.wait(1000);
    assert!(edges(&machine, 2).iter().all(|edge| !edge.1), "it stands: {:?}", machine.inputs);
    machine.output(6, true);
    machine.wait(2000);
    // 100 mm have run: the first can, from 0 on the belt, was in the beam from 75 to 85 mm.
    let seen = edges(&machine, 2);
    assert_eq!(seen.first(), Some(&(2500.0, true)), "{seen:?}");
    assert!((2700.0..2700.1).contains(&seen[1].0) && !seen[1].1, "{seen:?}");
    assert_eq!(edges(&machine, 3).first(), Some(&(2700.0, true)));
    assert!(edges(&machine, 4).iter().all(|edge| !edge.1));
    let Where::Stands(at) = machine.cell.things()[0].place else { panic!() };
    assert!(at[0] <= 100.0 + 1e-9 && at[0] > 80.0, "{at:?}");
    // A belt that stops stands; then it runs to its end.
    machine.output(6, false);
    machine.wait(5000);
    let Where::Stands(at) = machine.cell.things()[0].place else { panic!() };
    assert!((at[0] - 100.0).abs() < 1e-3, "{at:?}");
    machine.output(6, true);
    machine.wait(2100);
    let said = machine.said();
    assert!(
        said.iter().any(|line| line.contains(r#""ev":"rest","thing":"belt.1","in":"bin""#)),
        "{said:?}"
    );
}

#[test]
fn people_take_and_put_things() {
    let text = r#"cell = 1
part = [{ name = "device", size = [10, 10, 10], at = [50, 50, 0] }]
sensor = [{ name = "there", kind = "box", at = [50, 50, 0], size = [10, 10, 10], input = 2 }]
person = [{ name = "a", does = "take", at_s = 1, thing = "device" }, { name = "b", does = "put", at_s = 2, thing = "device" }]
"#;
    let mut machine = Machine::new(text);
    machine.wait(3000);
    assert_eq!(edges(&machine, 2), [(0.0, true), (1000.0, false), (2000.0, true)]);
}
