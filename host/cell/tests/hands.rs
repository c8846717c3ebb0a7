//! Several tools on one head, each at its own tip with its own output.

mod machine;

use cell::things::Where;
use cell::vary::Deviation;
use machine::Machine;
use proptest::prelude::*;

const THINGS: &str = r#"part = [{ name = "chip", size = [4, 4, 2] }]
feeder = [{ name = "tray", part = "chip", at = [20, 20, 4], count = [2, 1], pitch = [10, 0] }]
fixture = [{ name = "floor", at = [25, 20, 0], size = [30, 10, 4] }]
place = [{ name = "box", at = [60, 20, 0], size = [40, 20, 10], room = 0 }]
"#;

const LEFT: &str = r#"{ name = "left", kind = "vacuum", output = 3, input = 3, build_ms = 10, reach = 1, body = [{ at = [0, 0, 0], size = [2, 2, 20] }] }"#;
/// 30 mm to the right of the first one and 5 mm higher.
const RIGHT: &str = r#"{ name = "right", kind = "vacuum", output = 4, input = 4, build_ms = 10, reach = 1, tip = [30, 0, 5], body = [{ at = [0, 0, 0], size = [2, 2, 20] }] }"#;

fn scene(tools: &[&str]) -> String {
    format!("cell = 1\ntable = 0\ntool = [{}]\n{THINGS}", tools.join(", "))
}

fn place(machine: &Machine, name: &str) -> Where {
    machine.cell.things().iter().find(|thing| thing.name == name).unwrap().place
}

/// Takes the first chip with the left tool and the second one with the right tool, and puts both down.
fn both(machine: &mut Machine) {
    machine.go([20.0, 20.0, 30.0], 200.0);
    machine.go([20.0, 20.0, 6.0], 200.0);
    machine.output(3, true);
    machine.wait(100);
    machine.go([20.0, 20.0, 30.0], 200.0);
    // The right tip is at the second chip where the head is 30 mm before it.
    machine.go([0.0, 20.0, 30.0], 200.0);
    machine.go([0.0, 20.0, 1.0], 200.0);
    machine.output(4, true);
    machine.wait(100);
    machine.go([0.0, 20.0, 30.0], 200.0);
}

#[test]
fn two_tools_carry_two_parts() {
    let mut machine = Machine::new(&scene(&[LEFT, RIGHT]));
    both(&mut machine);
    assert!(matches!(place(&machine, "tray.1"), Where::Held(_)), "{:?}", machine.said());
    assert!(matches!(place(&machine, "tray.2"), Where::Held(_)), "{:?}", machine.said());
    let by: Vec<String> =
        machine.said().into_iter().filter(|line| line.contains("\"take\"")).collect();
    assert!(by.len() == 2 && by[0].contains("\"by\":\"left\""), "{by:?}");
    assert!(by[1].contains("\"tray.2\"") && by[1].contains("\"by\":\"right\""), "{by:?}");
    machine.go([45.0, 20.0, 30.0], 200.0);
    machine.go([45.0, 20.0, 4.0], 200.0);
    machine.output(3, false);
    machine.wait(100);
    machine.output(4, false);
    machine.wait(100);
    assert_eq!(place(&machine, "tray.1"), Where::Stands([45.0, 20.0, 0.0]));
    assert_eq!(place(&machine, "tray.2"), Where::Stands([75.0, 20.0, 0.0]));
    // Each switch is its own.
    let inputs: Vec<(u32, bool)> = machine.inputs.iter().map(|&(_, n, on)| (n, on)).collect();
    assert_eq!(inputs, [(3, true), (4, true), (3, false), (4, false)]);
}

#[test]
fn what_the_second_tool_carries_hits_what_is_in_its_way() {
    // The right tip goes at 35, and its chip from 33 to 35; the nozzle gives way by 1 mm.
    let wall = "fixture = [{ name = \"wall\", at = [60, 20, 0], size = [2, 10, 34.5] }, ";
    let text = scene(&[LEFT, RIGHT]).replace("fixture = [", wall);
    let mut machine = Machine::new(&text);
    both(&mut machine);
    machine.go([25.0, 20.0, 30.0], 200.0);
    machine.go([35.0, 20.0, 30.0], 200.0);
    let hits: Vec<String> =
        machine.said().into_iter().filter(|line| line.contains("\"hit\"")).collect();
    assert!(
        hits.len() == 1 && hits[0].contains("\"thing\":\"tray.2\",\"with\":\"wall\""),
        "{hits:?}"
    );
}

#[test]
fn one_tool_is_slow_and_the_other_is_not() {
    let mut machine = Machine::new(&scene(&[LEFT, RIGHT]));
    machine.cell.strike(&[Deviation::parse("slow right 2000ms").unwrap()]);
    both(&mut machine);
    assert!(matches!(place(&machine, "tray.1"), Where::Held(_)));
    assert!(matches!(place(&machine, "tray.2"), Where::Stands(_)));
}

#[test]
fn a_nozzle_and_a_needle_share_a_head() {
    let needle = r#"{ name = "needle", kind = "dispenser", output = 4, flow_mg_s = 10, reach = 1, tip = [30, 0, 5] }"#;
    let mut machine = Machine::new(&scene(&[LEFT, needle]));
    machine.go([20.0, 20.0, 30.0], 200.0);
    machine.go([20.0, 20.0, 6.0], 200.0);
    machine.output(3, true);
    machine.wait(100);
    machine.go([20.0, 20.0, 30.0], 200.0);
    machine.go([20.0, 40.0, 30.0], 200.0);
    machine.go([20.0, 40.0, -4.5], 200.0);
    machine.output(4, true);
    machine.go([30.0, 40.0, -4.5], 100.0);
    machine.output(4, false);
    let said = machine.said();
    let bead = said.iter().find(|line| line.contains("\"bead\"")).expect("a bead");
    assert!(bead.contains("\"mg\":1.0") || bead.contains("\"mg\":1}"), "{bead}");
    assert!(!said.iter().any(|line| line.contains("\"drip\"")), "{said:?}");
    assert!(matches!(place(&machine, "tray.1"), Where::Held(_)));
}

proptest! {
    /// A tool that stays off and has no body changes nothing, whichever of the two is named first.
    #[test]
    fn a_tool_that_does_nothing_changes_nothing(
        x in 19.0..21.0f64, down in 3.0..7.0f64, to in 40.0..80.0f64, ms in 0u64..100, first in any::<bool>(),
    ) {
        let idle = r#"{ name = "pen", kind = "pen", output = 9, flow_mg_s = 1, tip = [-7, 3, 2] }"#;
        let run = |tools: &[&str]| {
            let mut machine = Machine::new(&scene(tools));
            machine.go([x, 20.0, 30.0], 200.0);
            machine.go([x, 20.0, down], 100.0);
            machine.output(3, true);
            machine.wait(ms);
            machine.go([x, 20.0, 30.0], 200.0);
            machine.go([to, 20.0, 30.0], 200.0);
            machine.go([to, 20.0, 8.0], 200.0);
            machine.output(3, false);
            machine.wait(100);
            (machine.said(), machine.inputs.clone(), format!("{:.6?}", place(&machine, "tray.1")))
        };
        let both: &[&str] = if first { &[idle, LEFT] } else { &[LEFT, idle] };
        prop_assert_eq!(run(&[LEFT]), run(both));
    }
}
