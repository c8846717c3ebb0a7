//! Cells by the command line: deviations that strike no part, proofs that prove nothing.

#[path = "cell/broken.rs"]
mod broken;
mod common;

use common::{pasapas, text};
use tempfile::TempDir;

const SCRIPT: &str = "PROFILE \"laser\"\nMoveAxe X, 5mm\n";
const VARY: &str = "vary = [{ fault = \"pause\", within_s = 1, chance = 0.5 }]\n";
const EXPECT: &str = "expect = [{ what = \"no_collision\" }]\n";

/// A script for a machine without Z, and a cell beside it with these lines.
fn folder(lines: &str) -> (TempDir, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let script = folder.path().join("a.bas");
    let part = "part = [{ name = \"chip\", size = [8, 8, 4], at = [100, 100, 0] }]";
    std::fs::write(&script, SCRIPT).expect("a script");
    std::fs::write(folder.path().join("a.cell.toml"), format!("cell = 1\n{part}\n{lines}"))
        .expect("a cell");
    let script = text(&script).to_owned();
    (folder, script)
}

#[test]
fn a_deviation_that_strikes_nobody_is_refused_by_name() {
    let (_folder, script) = folder(EXPECT);
    let sim = |deviation: &str| pasapas(&["sim", &script, "--deviate", deviation]);
    for (deviation, words) in [
        ("missing chop", "fault missing names no "),
        ("pause", "`pause` needs a time"),
        ("chop.size 3", "`chop.size` is no number of the cell"),
        // The machine has X and Y alone.
        ("stall Z 30st at 1s", "fault stall names no axis of the profile: \"Z\""),
    ] {
        let (code, said) = sim(deviation);
        assert_eq!(code, 2, "{deviation}: {said}");
        assert!(said.contains("--deviate: ") && said.contains(words), "{deviation}: {said}");
    }
    for deviation in ["missing chip", "pause at 0s", "stall Y 3st at 0.1s"] {
        let (code, said) = sim(deviation);
        assert_eq!(code, 0, "{deviation}: {said}");
    }
}

#[test]
fn a_cell_names_only_axes_of_its_machine() {
    let stall = |axis: &str| {
        let vary = format!(
            "vary = [{{ fault = \"stall\", of = \"{axis}\", steps = 3, chance = 1, within_s = 1 }}]\n"
        );
        let (_folder, script) = folder(&format!("{EXPECT}{vary}"));
        pasapas(&["prove", &script, "--runs", "1"])
    };
    let (code, said) = stall("Z");
    assert!(code == 1 && said.contains("names no axis of the profile"), "{said}");
    let (code, said) = stall("Y");
    assert_eq!(code, 0, "{said}");
}

#[test]
fn a_proof_of_nothing_says_so() {
    let prove = |lines: &str, more: &[&str]| {
        let (_folder, script) = folder(lines);
        pasapas(&[&["prove", &script, "--runs", "2"], more].concat())
    };
    let (code, said) = prove(EXPECT, &[]);
    assert_eq!(code, 1, "{said}");
    assert!(said.contains("varies nothing") && said.contains("`[[vary]]` with"), "{said}");
    let (code, said) = prove(VARY, &[]);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("expects nothing") && said.contains("`[[expect]]` with"), "{said}");
    assert!(said.contains("below 100.0 %"), "{said}");
    let all = format!("{EXPECT}{VARY}");
    let (code, said) = prove(&all, &[]);
    assert!(code == 0 && !said.contains("nothing"), "{said}");
    let (code, said) = prove(&all, &["--shard", "3/8"]);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("part 3 of 8 has no run") && !said.contains("never reached"), "{said}");
}

/// The path of a file in a folder.
fn inside(folder: &TempDir, name: &str) -> String {
    text(&folder.path().join(name)).to_owned()
}

/// What an included file says wrongly is told with its own name, line and column.
#[test]
fn a_message_names_the_included_file() {
    let (folder, script) = folder("\n");
    let cell = inside(&folder, "a.cell.toml");
    let included = "cell = 1\n\nplace = [{ name = \"box\", at = [0, 0], size = [1, 1, 1] }]\n";
    std::fs::write(inside(&folder, "more.cell.toml"), included).expect("written");
    std::fs::write(&cell, "cell = 1\ninclude = [\"more.cell.toml\", \"none.cell.toml\"]\n")
        .expect("written");
    let (code, said) = pasapas(&["check", &cell]);
    assert_eq!(code, 1, "{said}");
    assert!(
        said.contains("more.cell.toml:3:31: error[C004]: `at` of [place] has 2 numbers"),
        "{said}"
    );
    assert!(said.contains("a.cell.toml:2:30: error[C015]: include \"none.cell.toml\": "), "{said}");
    let (code, said) = pasapas(&["sim", &script]);
    assert!(code == 1 && said.contains("more.cell.toml:3:31"), "{said}");
}

/// A trace of a board is judged without the script being run, and says where board and cell disagree.
#[test]
fn a_trace_is_played_into_the_cell() {
    let (folder, script) =
        folder("expect = [{ what = \"no_collision\" }, { what = \"ends\", text = \"done\" }]\n");
    let trace = inside(&folder, "run.trace");
    let (code, said) = pasapas(&["sim", &script, "--trace", &trace]);
    assert_eq!(code, 0, "{said}");
    let (code, said) = pasapas(&["sim", &script, "--replay", &trace]);
    assert!(code == 0 && said.contains("no_collision  none    none  yes"), "{said}");
    let wait = "{\"ev\":\"waitin\",\"line\":2,\"n\":3,\"v\":1,\"ok\":true}\n";
    let told = wait.to_owned() + &std::fs::read_to_string(&trace).expect("the trace");
    std::fs::write(&trace, told).expect("written");
    let (code, said) = pasapas(&["sim", &script, "--replay", &trace]);
    assert_eq!(code, 3, "{said}");
    assert!(
        said.contains("line 1 of the trace, line 2 of the script: input 3 came on on the board"),
        "{said}"
    );
    let (code, said) = pasapas(&["sim", &script, "--no-cell", "--replay", &trace]);
    assert!(code == 2 && said.contains("--replay needs a cell"), "{said}");
    std::fs::write(&trace, "{\"ev\":\"jump\"}\n").expect("written");
    let (code, said) = pasapas(&["sim", &script, "--replay", &trace]);
    assert!(code == 1 && said.contains("line 1 of the trace"), "{said}");
}

/// Pictures of a run show its cell.
#[test]
fn pictures_show_the_cell() {
    let wall = "fixture = [{ name = \"wall\", at = [3, 0, -5], size = [1, 9, 9], turn_deg = 30 }]\n\
                tool = [{ kind = \"none\", body = [{ at = [0, 0, 0], size = [1, 1, 1] }] }]\n";
    let (folder, script) = folder(wall);
    for (name, words) in [
        (
            "a.svg",
            [
                "class=\"cell cell-fixture\"",
                "<title>wall</title>",
                "cell-hit",
                "hit wall in line 2",
            ],
        ),
        (
            "a.html",
            ["\"kind\":\"fixture\"", "\"name\":\"wall\"", "\"kind\":\"hit\"", "hit wall in line 2"],
        ),
    ] {
        let file = inside(&folder, name);
        let (code, said) = pasapas(&["sim", &script, "--plot", &file]);
        assert_eq!(code, 0, "{said}");
        let picture = std::fs::read_to_string(&file).expect("the picture").replace("\n", "");
        for words in words {
            assert!(picture.contains(words), "{name}: {words}");
        }
    }
}
