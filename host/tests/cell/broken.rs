//! Scripts that are broken on purpose, each found by `pasapas test` in the words that one would want to read.

use super::common::{pasapas, text};

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
expect = [{ what = "in_place", place = "box", of = "tray", within = 1, turn_within_deg = 5 }, { what = "no_collision" }, { what = "no_drop", within = 2 }, { what = "nothing_held" },
          { what = "nothing_on" }, { what = "ends", text = "done" }, { what = "prints", text = "placed" }]
"#;

/// What `pasapas test` says of a changed script in a changed cell, and its exit code.
fn test([from, to]: [&str; 2], [cell_from, cell_to]: [&str; 2]) -> (i32, String) {
    let script = RIGHT.replacen(from, to, 1);
    assert!(from.is_empty() || script != RIGHT, "{from}");
    let cell = CELL.replacen(cell_from, cell_to, 1);
    assert!(cell_from.is_empty() || cell != CELL, "{cell_from}");
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("job.bas");
    std::fs::write(&file, script).expect("a script");
    std::fs::write(folder.path().join("job.cell.toml"), cell).expect("a cell");
    // What never ends is ended after ten minutes.
    pasapas(&["test", text(&file), "--limit", "10min"])
}

/// What is wrong with the script, from what, to what, and the words that say so.
type Mistake = (&'static str, [&'static str; 2], [&'static str; 2], &'static str);

const SAME: [&str; 2] = ["", ""];
const TRAY: &str = "feeder = [{ name = \"tray\", part = \"chip\", at = [20, 30, -26] }]";

const MISTAKES: &[Mistake] = &[
    (
        "too low: carried below the clamp's top",
        ["MoveAxe Z, 0mm\nG0 X60", "MoveAxe Z, -10mm\nG0 X60"],
        SAME,
        "tray.1 hit clamp at ",
    ),
    (
        "too low: pressed into the part",
        ["MoveAxe Z, -22.5mm", "MoveAxe Z, -25mm"],
        SAME,
        "nozzle hit tray.1 at ",
    ),
    (
        "crossing a clamp with the tool alone",
        [
            "G0 X20 Y30\n",
            "MoveAxe X, 20mm\nMoveAxe Y, 30mm\nMoveAxe Z, -20mm\nMoveAxe X, 60mm\nMoveAxe Y, 45mm\nMoveAxe X, 30mm\nEND\n",
        ],
        SAME,
        "nozzle hit clamp at ",
    ),
    (
        "too early: nobody waits for the vacuum",
        ["WaitIn held, ON, 400ms\n", ""],
        SAME,
        "tray.1: never taken; stands at 20.00 30.00 -26.00",
    ),
    (
        "not turned",
        SAME,
        [
            TRAY,
            "feeder = [{ name = \"tray\", part = \"chip\", at = [20, 30, -26], turn_deg = 90 }]",
        ],
        "turned by 90.0 deg",
    ),
    (
        "the wrong feeder",
        ["G0 X20 Y30", "G0 X20 Y60"],
        [
            TRAY,
            "feeder = [{ name = \"tray\", part = \"chip\", at = [20, 30, -26] }, { name = \"spare\", part = \"chip\", at = [20, 60, -26] }]",
        ],
        "tray.1: never taken",
    ),
    (
        "no vacuum test: the pocket is empty",
        ["WaitIn held, ON, 400ms\n", "Wait 400ms\n"],
        [
            TRAY,
            "feeder = [{ name = \"tray\", part = \"chip\", at = [20, 30, -26], pitch = [15, 0], count = [2, 1], empty = [1] }]",
        ],
        "tray.2: never taken",
    ),
    (
        "the output is left on: the part still hangs when the program ends",
        ["SetOut pump, OFF\nWaitIn held, OFF, 500ms\n", ""],
        SAME,
        "nothing_held: wanted nothing, was tray.1",
    ),
    ("a wrong offset: the nozzle is not above the part", ["G0 X20 Y30", "G0 X23 Y30"], SAME, "F13"),
    ("a wrong offset: beside the place", ["G0 X60 Y60", "G0 X70 Y60"], SAME, "tray.1 fell "),
    (
        "let go too high",
        ["MoveAxe Z, -12mm, 40mm/s", "MoveAxe Z, -2mm, 40mm/s"],
        SAME,
        "tray.1 fell 11.00 mm",
    ),
    (
        "a race with the switch: asked before it can answer",
        ["WaitIn held, ON, 400ms\n", "Wait 20ms\nIF NOT IN(held) THEN END\n"],
        SAME,
        "0 times",
    ),
    (
        "a retry that never ends",
        [
            "WaitIn held, ON, 400ms\n",
            "DO\nMoveAxe Z, 0mm\nMoveAxe Z, -22.5mm\nWaitIn? held, ON, 400ms\nLOOP WHILE TIMEDOUT\n",
        ],
        [
            TRAY,
            "feeder = [{ name = \"tray\", part = \"chip\", at = [20, 30, -26], pitch = [15, 0], count = [2, 1], empty = [1] }]",
        ],
        "stopped",
    ),
    (
        "waits for an input that nobody drives",
        ["WaitIn held, ON, 400ms", "WaitIn 5, ON"],
        SAME,
        "stopped",
    ),
];

#[test]
fn each_mistake_is_told_in_its_words() {
    let (code, right) = test(SAME, SAME);
    assert!(code == 0 && right.starts_with("right "), "{right}");
    for (name, script, cell, words) in MISTAKES {
        let (code, said) = test(*script, *cell);
        assert!(code == 3 && said.starts_with("WRONG "), "{name}: {code}: {said}");
        assert!(said.contains(words), "{name}: {words}: {said}");
    }
}
