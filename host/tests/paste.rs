//! `pasapas paste` as a user has it: a layer to a job that runs on the simulator, on two machines.

mod common;

use std::collections::BTreeSet;
use std::path::Path;

use common::{pasapas, text};

/// A paste layer in inch: two pads of a part, and a longer one.
const LAYER: &str = "%TF.FileFunction,Paste,Top*%\n%FSLAX34Y34*%\n%MOIN*%\n%ADD10R,0.04X0.04*%\n\
    %ADD11R,0.02X0.1*%\nD10*\n%TO.C,R2*%\nX20000Y20000D03*\nX22000Y20000D03*\n%TD*%\nD11*\n\
    X30000Y20000D03*\nM02*\n";
const NEEDLE: &str = "diameter = 0.4\ndot = 0.6\nstencil = 0.12\noutput = 3\nms = 80\nclearance = 0\n\
    board = -30\nsuck_ms = 20\npurge = [10, 10]\npurge_ms = 500\n";

fn write(folder: &Path, name: &str, content: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, content).expect("a file");
    text(&path).to_owned()
}

#[test]
fn a_layer_becomes_a_job_that_gives_its_dots_on_two_machines() {
    let folder = tempfile::tempdir().expect("a folder");
    let layer = write(folder.path(), "a.gtp", LAYER);
    let job = text(&folder.path().join("dots.bas")).to_owned();
    let trace = text(&folder.path().join("run.trace")).to_owned();
    // Z counts upward and downward: the needle stands 0.2 mm above the board and goes up by 1 mm from there.
    for (profile, board, low, lifted) in [("mill", -30, -2980, -2880), ("charly", 30, 2980, 2880)] {
        let file = NEEDLE.replace("board = -30", &format!("board = {board}"));
        let needle = write(folder.path(), "needle.toml", &file);
        let args = ["paste", &layer, "--needle", &needle, "--profile", profile, "-o", &job];
        let (code, said) = pasapas(&[&args[..], &["--at", "50.8,50.8=100,60"]].concat());
        assert_eq!(code, 0, "{said}");
        assert!(said.contains("7 dots on 3 pads of 3.4 mm2"), "{said}");
        let script = std::fs::read_to_string(&job).expect("a script");
        assert!(script.contains("' R2\n"), "{script}");
        let (code, said) = pasapas(&["sim", &job, "--trace", &trace]);
        assert_eq!(code, 0, "{said}");
        assert!(said.contains("the board is done"), "{said}");
        let lines = std::fs::read_to_string(&trace).expect("a trace");
        let heights: BTreeSet<i64> = lines
            .lines()
            .filter_map(|line| {
                serde_json::from_str::<serde_json::Value>(line).ok()?["to"]["Z"].as_i64()
            })
            .collect();
        assert_eq!(heights, BTreeSet::from([0, low, lifted]), "{profile}");
        // Each dot, and once to purge.
        assert!(said.contains("on 8 times"), "{said}");
    }
}

/// The valve is open along the bead: from its begin until the thread before its end, on the desktop and on the
/// board, on two machines.
#[test]
fn a_long_pad_gets_a_bead_whose_valve_closes_on_the_way() {
    let folder = tempfile::tempdir().expect("a folder");
    let layer = write(folder.path(), "a.gtp", LAYER);
    let job = text(&folder.path().join("dots.bas")).to_owned();
    let trace = text(&folder.path().join("run.trace")).to_owned();
    // The second has other steps to the millimetre, and Z counts downward.
    let odd = include_str!("../../examples/profiles/charly.toml");
    let odd = odd.replace("name = \"charly\"", "name = \"odd\"");
    let odd =
        odd.replace("scale = { steps = 400, um = 4000 }", "scale = { steps = 127, um = 1000 }");
    let odd = write(folder.path(), "odd.toml", &odd);
    for (profile, steps_per_mm, board, clearance) in
        [("mill", 100.0, -30, 0), (&*odd, 127.0, 30, 0)]
    {
        let bead = "[bead]\nfrom = 2\nslowest = 2\nfastest = 30\nopens_ms = 15\nthread = 0.5\n";
        let file = NEEDLE.replace("board = -30", &format!("board = {board}"));
        let file = file.replace("clearance = 0", &format!("clearance = {clearance}")) + bead;
        let needle = write(folder.path(), "needle.toml", &file);
        let args = ["paste", &layer, "--needle", &needle, "--profile", profile, "-o", &job];
        let (code, said) = pasapas(&[&args[..], &["--at", "50.8,50.8=100,60"]].concat());
        assert_eq!(code, 0, "{said}");
        assert!(said.contains("4 dots and 1 bead on 3 pads"), "{said}");
        for engine in ["vm", "rhai", "board"] {
            let (code, said) = pasapas(&["sim", &job, "--engine", engine, "--trace", &trace]);
            assert_eq!(code, 0, "{said}");
            let lines = std::fs::read_to_string(&trace).expect("a trace");
            let events: Vec<serde_json::Value> =
                lines.lines().map(|line| serde_json::from_str(line).expect("an event")).collect();
            let shut = events.iter().position(|event| event["sync"] == true).expect("it closes");
            let line = events[..shut].iter().rposition(|event| event["kind"] == "line");
            let line = line.expect("a bead");
            let on = &events[line - 2];
            assert_eq!(
                (&on["ev"], &on["n"], &on["v"]),
                (&"out".into(), &3.into(), &1.into()),
                "{on}"
            );
            let waited = (events[line]["us"].as_u64()).zip(on["us"].as_u64()).map(|(a, b)| a - b);
            assert!(waited.is_some_and(|us| (15_000..16_000).contains(&us)), "{waited:?}");
            let y =
                |event: &serde_json::Value, key: &str| event[key]["Y"].as_f64().expect("a place");
            let left = (y(&events[line], "to") - y(&events[shut], "pos")).abs();
            // Within a millisecond of its place.
            assert!((left / steps_per_mm - 0.5).abs() < 0.05, "{profile}, {engine}: {left} steps");
        }
    }
}

#[test]
fn what_cannot_be_given_is_told_with_its_remedy_and_nothing_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let layer = write(folder.path(), "a.gtp", LAYER);
    let needle = write(folder.path(), "needle.toml", NEEDLE);
    let job = folder.path().join("dots.bas");
    let empty = write(folder.path(), "empty.gtp", "%FSLAX46Y46*%\n%MOMM*%\nM02*\n");
    let typing = write(folder.path(), "typing.toml", &NEEDLE.replace("stencil", "stensil"));
    let list = write(folder.path(), "pads.csv", "x,y,width,height\n10,10,-1,1\n");
    for (file, needle, more, words) in [
        (&empty, &needle, &[][..], "without a pad"),
        (
            &layer,
            &typing,
            &[],
            "typing.toml:3:1: error[X034]: there is no key `stensil` here\n  hint: `stencil` is",
        ),
        (&list, &needle, &[], "pads.csv:2:1: error[X035]: width is -1 mm"),
        (&layer, &needle, &["--at", "50.8,50.8=299,60"], "outside the travel"),
        (&layer, &needle, &["--at", "0,0=10"], "it is X,Y=X,Y in mm"),
        (&layer, &needle, &["--at", "0,0=0,0", "--at", "0,10=0,11"], "wrong point, or wrong unit?"),
        (&layer, &needle, &["--profile", "laser"], "the machine laser has no Z"),
    ] {
        let args = ["paste", file, "--needle", needle, "-o", text(&job)];
        let (code, said) = pasapas(&[&args[..], more].concat());
        assert!(matches!(code, 1 | 2), "{words}: {code} {said}");
        assert!(said.contains(words), "{words}: {said}");
        assert!(!job.exists(), "{words}");
    }
    let (code, said) = pasapas(&["paste", &layer, "--needle", &needle, "-o", &needle]);
    assert_eq!(code, 2, "{said}");
    assert_eq!(std::fs::read_to_string(&needle).expect("it is there"), NEEDLE);
}

#[test]
fn the_tool_takes_the_commands_of_the_shops_pages() {
    let mut count = 0;
    for page in
        [include_str!("../paste.md"), include_str!("../engrave.md"), include_str!("../level.md")]
    {
        let shown = page.split("```sh\n").skip(1).filter_map(|part| part.split("```").next());
        for line in shown.flat_map(str::lines).flat_map(|line| line.split("&&")) {
            let words = line.split('>').next().unwrap_or_default().split_whitespace();
            let taken = pasapas::cmd::command_line().try_get_matches_from(words);
            assert!(taken.is_ok(), "{line}\n{}", taken.unwrap_err());
            count += 1;
        }
    }
    assert_eq!(count, 10);
}
