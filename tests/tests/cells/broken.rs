//! Scripts that are broken on purpose, each found in the words that one would want to read.

use pasapas::sim::world::World;

use super::{cell, native, program, report};

const RIGHT: &str = "OUTPUT pump = 3
INPUT held = 3
Home
G0 X20 Y30
MoveAxe Z, -22.5mm, 40mm/s
SetOut pump, ON
WaitIn held, ON, 400ms
MoveAxe Z, 0mm
G0 X60 Y60
MoveAxe Z, -12mm, 40mm/s
SetOut pump, OFF
WaitIn held, OFF, 500ms
MoveAxe Z, 0mm
PRINT \"placed\"
";

const CELL: &str = r#"cell = 1
table = -60
tool = [{ name = "nozzle", kind = "vacuum", output = "pump", input = "held", build_ms = 300, reach = 1.5, body = [{ at = [0, 0, 2], size = [12, 12, 40] }] }]
part = [{ name = "chip", size = [8, 8, 4] }]
feeder = [{ name = "tray", part = "chip", at = [20, 30, -26] }]
fixture = [{ name = "floor", at = [20, 30, -30], size = [30, 30, 4] }, { name = "clamp", at = [40, 45, -30], size = [6, 6, 18] }]
place = [{ name = "box", at = [60, 60, -16.5], size = [12, 12, 10] }]
expect = [{ what = "in_place", place = "box", within = 1 }, { what = "no_collision" }, { what = "no_drop", within = 2 }, { what = "nothing_held" },
          { what = "nothing_on" }, { what = "ends", text = "done" }, { what = "prints", text = "placed" }]
"#;

/// The table of a run of a changed script.
fn table(from: &str, to: &str) -> (bool, String) {
    let text = RIGHT.replacen(from, to, 1);
    assert!(from.is_empty() || text != RIGHT, "{from}");
    let program = program(&text);
    let world = World::unattended().with_scene(Some(cell(CELL, &program)));
    let report = report(native(&program, &world).0);
    (report.holds(), report.table())
}

#[test]
fn each_mistake_is_told_in_its_words() {
    let (holds, right) = table("", "");
    assert!(holds, "{right}");
    for (from, to, words) in [
        // Carried too low, the part meets the clamp.
        ("MoveAxe Z, 0mm\nG0 X60", "MoveAxe Z, -10mm\nG0 X60", "tray.1 hit clamp at "),
        // Down too far: the nozzle's body meets the part, which gives way by 1 mm alone.
        ("MoveAxe Z, -22.5mm", "MoveAxe Z, -25mm", "nozzle hit tray.1 at "),
        // Crossing the clamp below its top with the tool alone.
        (
            "G0 X20 Y30\n",
            "MoveAxe X, 20mm\nMoveAxe Y, 30mm\nMoveAxe Z, -20mm\nMoveAxe X, 60mm\nMoveAxe Y, 45mm\nMoveAxe X, 30mm\nEND\n",
            "nozzle hit clamp at ",
        ),
        // Too early: nobody waits for the vacuum.
        ("WaitIn held, ON, 400ms\n", "", "in_place box  1                    0"),
        // Wrong offset: the nozzle is not above the part.
        ("G0 X20 Y30", "G0 X23 Y30", "F13"),
        // Put down beside the place.
        ("G0 X60 Y60", "G0 X70 Y60", "tray.1 fell "),
        // Let go too high.
        ("MoveAxe Z, -12mm, 40mm/s", "MoveAxe Z, -2mm, 40mm/s", "tray.1 fell 11.00 mm"),
        // Nobody lets go: the end of the program switches the pump off, high above the place.
        ("SetOut pump, OFF\nWaitIn held, OFF, 500ms\n", "", "tray.1 fell 13.00 mm"),
        // Waits for an input that nobody drives.
        ("WaitIn held, ON, 400ms", "WaitIn 5, ON", "stopped"),
    ] {
        let (holds, table) = table(from, to);
        assert!(!holds && table.contains(words), "{to}: {words}: {table}");
    }
}
