//! What goes, or turns back, before it has had its effect: a thing under the nozzle or in a sensor, jaws, a fall.

mod machine;

use cell::things::Where;
use cell::vary::Deviation;
use machine::Machine;

/// The edges of an input, ms and state.
fn edges(machine: &Machine, input: u32) -> Vec<(f64, bool)> {
    let own = machine.inputs.iter().filter(|edge| edge.1 == input);
    own.map(|&(us, _, on)| (us as f64 / 1000.0, on)).collect()
}

/// What an input is at the end.
fn last(machine: &Machine, input: u32) -> bool {
    edges(machine, input).last().is_some_and(|edge| edge.1)
}

fn takes(machine: &Machine) -> usize {
    machine.said().iter().filter(|line| line.contains("\"ev\":\"take\"")).count()
}

const NOZZLE: &str = r#"cell = 1
table = 0
tool = [{ name = "nozzle", kind = "vacuum", output = 3, build_ms = 10, body = [{ at = [0, 0, 0], size = [2, 2, 20] }] }]
part = [{ name = "chip", size = [4, 4, 2], at = [20, 20, 0] }]
"#;

/// Takes the chip and puts it down at X 60.
fn carry(machine: &mut Machine) {
    machine.go([20.0, 20.0, 30.0], 200.0);
    machine.go([20.0, 20.0, 2.0], 200.0);
    machine.output(3, true);
    machine.wait(100);
    machine.go([20.0, 20.0, 30.0], 200.0);
    machine.go([60.0, 20.0, 30.0], 200.0);
    machine.go([60.0, 20.0, 2.0], 200.0);
    machine.output(3, false);
    machine.wait(100);
    machine.go([60.0, 20.0, 30.0], 200.0);
}

#[test]
fn a_part_put_down_in_a_sensor_is_counted_once() {
    let sensors = r#"sensor = [{ name = "part", kind = "box", at = [60, 20, 0], size = [10, 10, 10], input = 5 },
    { name = "held", kind = "box", at = [60, 20, 0], size = [10, 10, 10], input = 6, sees = ["held"] }]
person = [{ name = "helper", does = "take", at_s = 5, thing = "chip" }]
"#;
    let mut machine = Machine::new(&format!("{NOZZLE}{sensors}"));
    carry(&mut machine);
    assert!(last(&machine, 5), "the chip stands there");
    assert_eq!(edges(&machine, 6).iter().map(|edge| edge.1).collect::<Vec<_>>(), [true, false]);
    machine.wait(6000);
    assert_eq!(edges(&machine, 5).last(), Some(&(5000.0, false)), "the helper took it");
}

#[test]
fn a_part_taken_in_a_sensor_is_seen_until_it_leaves() {
    let sensor = r#"sensor = [{ name = "eye", kind = "box", at = [20, 20, 0], size = [10, 10, 10], input = 5, sees = ["tool", "held"] }]
"#;
    let mut machine = Machine::new(&format!("{NOZZLE}{sensor}"));
    machine.go([20.0, 20.0, 30.0], 200.0);
    machine.go([20.0, 20.0, 2.0], 200.0);
    machine.output(3, true);
    machine.wait(100);
    // The body is above the box from 10 mm on, the chip's bottom from 12 mm on.
    machine.go([20.0, 20.0, 11.5], 10.0);
    assert!(last(&machine, 5), "{:?}", edges(&machine, 5));
    machine.go([20.0, 20.0, 12.5], 10.0);
    assert!(!last(&machine, 5), "{:?}", edges(&machine, 5));
}

#[test]
fn a_nozzle_touches_no_thing_that_went() {
    // A person takes it, a belt starts under it, a tape is advanced.
    let person = r#"person = [{ name = "helper", does = "take", at_s = 1, thing = "chip" }]
"#;
    let belt = r#"conveyor = [{ name = "belt", at = [100, 20, -5], size = [200, 30, 5], drive = 6, mm_s = 50 }]
"#;
    for (extra, output, takes_wanted) in [(person, None, 0), (belt, Some(6), 0), ("", None, 1)] {
        for early in [false, true] {
            let mut machine = Machine::new(&format!("{NOZZLE}{extra}"));
            machine.go([20.0, 20.0, 30.0], 200.0);
            machine.go([20.0, 20.0, 2.0], 200.0);
            // The pump goes on after the thing went, or 1 ms before: too late to take it.
            let left = 999 - machine.now / 1000;
            machine.wait(left);
            if early {
                machine.output(3, true);
            }
            machine.wait(1);
            if let Some(output) = output {
                machine.output(output, true);
            }
            machine.wait(500);
            machine.output(3, true);
            machine.wait(300);
            assert_eq!(takes(&machine), takes_wanted, "{extra} {early}: {:?}", machine.said());
        }
    }
    let tape = NOZZLE.replace(", at = [20, 20, 0] }]", " }]")
        + "feeder = [{ name = \"tape\", kind = \"tape\", part = \"chip\", at = [20, 20, 0], output = 5, advance_ms = 10, length = 1 }]\n";
    let mut machine = Machine::new(&tape);
    machine.go([20.0, 20.0, 30.0], 200.0);
    machine.go([20.0, 20.0, 2.0], 200.0);
    machine.output(5, true);
    machine.wait(100);
    machine.output(3, true);
    machine.wait(300);
    assert_eq!(takes(&machine), 0, "{:?}", machine.said());
}

#[test]
fn a_nozzle_takes_the_other_thing_that_it_touches() {
    // Both tops are in its reach; the first goes.
    let text = NOZZLE.replace("build_ms = 10", "build_ms = 10, reach = 5").replace(
        "at = [20, 20, 0] }]",
        "at = [18, 20, 0] }, { name = \"other\", size = [4, 4, 2], at = [22, 20, 0] }]\nperson = [{ name = \"helper\", does = \"take\", at_s = 1, thing = \"NAME\" }]",
    );
    for (gone, left) in [("chip", "other"), ("other", "chip")] {
        let mut machine = Machine::new(&text.replace("NAME", gone));
        machine.go([20.0, 20.0, 30.0], 200.0);
        machine.go([20.0, 20.0, 2.0], 200.0);
        machine.wait(2000);
        machine.output(3, true);
        machine.wait(300);
        let said = machine.said();
        assert!(said[0].contains(&format!(r#""ev":"take","thing":"{left}""#)), "{said:?}");
    }
}

/// A device that is taken away at 1 s, put back at 2 s and taken again 10 ms later.
fn short_sight(delays: &str) -> Machine {
    let text = format!(
        r#"cell = 1
part = [{{ name = "device", size = [10, 10, 10], at = [50, 50, 0] }}]
sensor = [{{ name = "eye", kind = "box", at = [50, 50, 0], size = [10, 10, 10], input = 2, {delays} }}]
person = [{{ name = "a", does = "take", at_s = 1, thing = "device" }}, {{ name = "b", does = "put", at_s = 2, thing = "device" }},
          {{ name = "c", does = "take", at_s = 2.01, thing = "device" }}]
"#
    );
    let mut machine = Machine::new(&text);
    machine.wait(4000);
    machine
}

#[test]
fn a_sight_shorter_than_its_delay_is_not_told() {
    assert_eq!(edges(&short_sight("on_ms = 50"), 2), [(50.0, true), (1000.0, false)]);
    let off = short_sight("off_ms = 50");
    assert_eq!(edges(&off, 2), [(0.0, true), (1050.0, false), (2000.0, true), (2060.0, false)]);
    let bounces = short_sight("bounce_ms = 40");
    assert_eq!(edges(&bounces, 2).last(), Some(&(2055.0, false)), "{:?}", bounces.inputs);
    let after = edges(&bounces, 2).into_iter().filter(|edge| edge.0 >= 2010.0);
    let after: Vec<bool> = after.map(|edge| edge.1).collect();
    assert_eq!(after.iter().filter(|on| **on).count(), 4, "{after:?}");
}

#[test]
fn another_look_does_not_begin_a_delay_anew() {
    let text = r#"cell = 1
part = [{ name = "device", size = [10, 10, 10], at = [50, 50, 0] }, { name = "other", size = [5, 5, 5], at = [90, 50, 0] }]
sensor = [{ name = "eye", kind = "box", at = [50, 50, 0], size = [10, 10, 10], input = 2, off_ms = 50 }]
person = [{ name = "a", does = "take", at_s = 1, thing = "device" }, { name = "b", does = "take", at_s = 1.02, thing = "other" }]
"#;
    let mut machine = Machine::new(text);
    machine.wait(2000);
    assert_eq!(edges(&machine, 2), [(0.0, true), (1050.0, false)]);
}

const GRIP: &str = r#"cell = 1
table = 0
tool = [{ name = "jaws", kind = "gripper", output = 2, opens = 20, grips = [5, 15], close_ms = 80, open_ms = 60, input_closed = 3, input_gripped = 4 }]
part = [{ name = "block", size = [10, 30, 20], at = [50, 50, 0] }]
"#;

/// Open jaws around the block.
fn around(fault: &str) -> Machine {
    let mut machine = Machine::new(GRIP);
    if !fault.is_empty() {
        machine.cell.strike(&[Deviation::parse(fault).unwrap()]);
    }
    machine.go([50.0, 50.0, 40.0], 100.0);
    machine.go([50.0, 50.0, 10.0], 100.0);
    machine
}

#[test]
fn jaws_that_close_again_need_their_whole_time() {
    let mut machine = around("");
    machine.output(2, true);
    machine.wait(50);
    machine.output(2, false);
    machine.wait(10);
    machine.output(2, true);
    let closes = machine.now;
    machine.wait(300);
    assert_eq!(machine.cell.log()[0].us, closes + 80_000, "{:?}", machine.said());
    assert_eq!((last(&machine, 3), last(&machine, 4)), (false, true), "{:?}", machine.inputs);
}

#[test]
fn jaws_that_lose_their_part_say_so() {
    let mut machine = around("lost block 100ms");
    machine.output(2, true);
    machine.wait(150);
    assert_eq!((last(&machine, 3), last(&machine, 4)), (false, true), "{:?}", machine.inputs);
    machine.wait(100);
    assert_eq!((last(&machine, 3), last(&machine, 4)), (true, false), "{:?}", machine.inputs);
    assert!(matches!(machine.cell.things()[0].place, Where::Stands(_)));
}

#[test]
fn a_fall_belongs_to_the_hold_that_it_was_planned_in() {
    // It is lost 500 ms after the first take, but was let go and taken again before.
    let mut machine = around("lost block 500ms");
    for (on, ms) in [(true, 100), (false, 100), (true, 1000)] {
        machine.output(2, on);
        machine.wait(ms);
    }
    assert!(matches!(machine.cell.things()[0].place, Where::Held(_)), "{:?}", machine.said());
    assert!(last(&machine, 4));
}

#[test]
fn jaws_that_come_back_hold_what_stuck_to_them() {
    let mut machine = around("stuck block 300ms");
    for (on, ms) in [(true, 100), (false, 50), (true, 1000)] {
        machine.output(2, on);
        machine.wait(ms);
    }
    assert!(matches!(machine.cell.things()[0].place, Where::Held(_)), "{:?}", machine.said());
    assert_eq!((last(&machine, 3), last(&machine, 4)), (false, true), "{:?}", machine.inputs);
    // And they let go of it at once the next time.
    machine.output(2, false);
    machine.wait(10);
    assert!(matches!(machine.cell.things()[0].place, Where::Stands(_)), "{:?}", machine.said());
}
