//! `--part`: what a chip runs, what it lacks, what becomes of arcs.

use serde_json::Value;

use super::Bench;

#[test]
fn build_tells_the_limits_of_the_part_that_it_names() {
    let bench = Bench::new();
    bench.file("a.bas", "KEEP n\nON EVERY 1s GOSUB t\nWait 3s\nEND\nt:\nn = n + 1\nRETURN\n");
    for (part, image, cells) in [("g2553-handlers", 508, 9), ("f5529", 32_767, 256)] {
        let (_, lines) = bench.json(&["build", "a.bas", "--part", part, "--format", "json"]);
        let limits = [&lines[0]["image_limit"], &lines[0]["cells_limit"]];
        assert_eq!(limits, [image, cells], "{part}: {}", lines[0]);
    }
}

/// Nobody asked for a part: the one that has room is named, with the array that wants it.
#[test]
fn the_part_that_has_room_for_an_array_is_named() {
    let bench = Bench::new();
    bench.file("large.bas", "DIM i\nDIM a(200)\nFOR i = 0 TO 199\n  a(i) = i\nNEXT\n");
    for command in ["check", "build"] {
        let done = bench.run(&[command, "large.bas"]);
        assert_eq!(done.code, 0, "{}", done.err);
        let told = done.err.lines().find(|line| line.contains("note[B014]")).unwrap_or_default();
        assert!(told.starts_with("large.bas:2:5: "), "{command}: {}", done.err);
        assert!(told.contains("`f5529` (MSP430F5529)") && told.contains("`g2553`"), "{told}");
        assert!(told.contains("bytes of RAM"), "{told}");
    }
    // Who names a part knows; a simulation buys none; a small program runs anywhere.
    bench.file("small.bas", "DIM a(4)\na(1) = 2\n");
    for args in [
        &["check", "large.bas", "--part", "f5529"][..],
        &["sim", "large.bas"],
        &["check", "small.bas"],
    ] {
        let done = bench.run(args);
        assert_eq!(done.code, 0, "{args:?}: {}", done.err);
        assert!(!done.err.contains("B014"), "{args:?}: {}", done.err);
    }
}

#[test]
fn sim_shows_the_speeds_of_the_part_that_runs_the_script() {
    let bench = Bench::new();
    bench.file("corners.bas", "G1 X10 F1500\nG1 X20 Y1\nG1 X30 Y4\n");
    let us = |more: &[&str]| {
        let args = [&["sim", "corners.bas", "--format", "json"], more].concat();
        let done = bench.run(&args);
        assert_eq!(done.code, 0, "{}", done.err);
        let last = done.out.lines().last().expect("a summary");
        let summary: Value = serde_json::from_str(last).expect("JSON");
        summary["us"].as_u64().expect("a time")
    };
    let (small, large) = (us(&["--part", "g2553"]), us(&["--part", "f5529"]));
    // The corners are flat: with look-ahead the second and third line need no ramps.
    assert!(small > large + 100_000, "{small} us without look-ahead, {large} us with it");
    assert_eq!(us(&[]), large, "nobody asked for a part");
    // All that a part lacks, each at its line, with what to do.
    bench.file(
        "all.bas",
        "DIM a(20)\nON ERROR GOTO h\nG1 X10 F1500\nG2 X20 Y10 I10\nEND\nh: PRINT ERR\nEND\n",
    );
    let refused = bench.run(&["check", "all.bas", "--part", "g2553"]);
    let places: Vec<&str> = refused
        .err
        .lines()
        .filter_map(|line| line.split_once(": error[B008]"))
        .map(|(place, _)| place)
        .collect();
    assert_eq!(places, ["all.bas:4:1", "all.bas:2:1", "all.bas:1:1"], "{}", refused.err);
    assert!(refused.err.contains("`--part g2553-handlers` has it"), "{}", refused.err);
    assert!(refused.err.contains("`--part f5529` has it"), "{}", refused.err);
    bench.file("turn.bas", "DIM a AS ANGLE\nON ERROR GOTO h\nPRINT SIN(a)\nEND\nh: RESUME\n");
    let refused = bench.run(&["check", "turn.bas", "--part", "g2553-handlers"]);
    assert!(refused.err.contains("turn.bas:3:1: error[B008]"), "{}", refused.err);
    assert!(refused.err.contains("SIN, COS, ATAN2 and SCALE"), "{}", refused.err);
    assert!(
        refused.err.contains("turn.bas:5:") && refused.err.contains("RESUME, which"),
        "{}",
        refused.err
    );
    assert_eq!(bench.run(&["check", "turn.bas"]).code, 0, "another part runs it");
    let long = (0..600).map(|n| format!("MoveAxe X, {}.{}37mm, {}st/s\n", n % 90, n % 9, 1001 + n));
    bench.file("long.bas", long.collect::<String>());
    let refused = bench.run(&["check", "long.bas", "--part", "g2553"]);
    assert!(refused.err.contains("`pasapas stream` runs jobs of any length"), "{}", refused.err);
    // An arc is what only the large part does: with it the script looks ahead.
    bench.file("arc.bas", "G1 X10 F1500\nG2 X20 Y10 I10\n");
    let refused = bench.run(&["sim", "arc.bas", "--part", "g2553"]);
    assert!(refused.code == 1 && refused.err.contains("arcs (G2, G3)"), "{}", refused.err);
    assert!(refused.err.contains("where Y is when it begins"), "{}", refused.err);
    assert!(refused.err.contains("arc.bas:2:1: error[B008]"), "{}", refused.err);
    assert!(refused.err.contains("write a G0 or G1 with a number for Y"), "{}", refused.err);
}

/// A part without arcs runs chords of them, which all engines show alike; what they cost is told.
#[test]
fn arcs_become_chords_for_a_part_that_has_none() {
    let bench = Bench::new();
    bench.file("arc.bas", "G1 X10 Y0 F1500\nG2 X20 Y10 I10\nG1 X0\n");
    let mut traces = Vec::new();
    for engine in ["rhai", "vm", "board"] {
        let args = ["sim", "arc.bas", "--part", "g2553", "--engine", engine, "--trace", "-"];
        let done = bench.run(&args);
        assert_eq!(done.code, 0, "{}", done.err);
        let told = "arc.bas:2:1: note[B011]: `g2553` for the MSP430G2553 draws no arcs: 1 arc became 13 lines, at most 20um off";
        assert!(done.err.contains(told), "{}", done.err);
        let mut lines: Vec<Value> =
            done.out.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
        for line in &mut lines {
            line.as_object_mut().expect("an object").remove("us");
        }
        traces.push(lines);
    }
    assert!(traces[0] == traces[1] && traces[0] == traces[2], "{traces:?}");
    assert_eq!(traces[0].len(), 1 + 13 + 1 + 1);
    assert_eq!(traces[0][13]["to"], serde_json::json!({ "X": 2000, "Y": 1000, "Z": 0 }));
    // A part with arcs keeps them.
    let done = bench.run(&["sim", "arc.bas", "--trace", "-"]);
    assert!(done.out.contains("\"kind\":\"arc\"") && !done.err.contains("B011"), "{}", done.err);
    // Too many for the flash: who does without, and what makes fewer.
    bench.file("many.bas", format!("F900\nG91\n{}", "G2 I20\n".repeat(12)));
    let refused = bench.run(&["build", "many.bas", "--part", "g2553"]);
    assert_eq!(refused.code, 1);
    assert!(refused.err.contains("`--part f5529` draws arcs itself"), "{}", refused.err);
    let (code, lines) = bench.json(&["check", "arc.bas", "--part", "g2553", "--format", "json"]);
    assert_eq!((code, lines[0]["severity"].as_str()), (0, Some("note")));
}

/// Times in us at which a signal changes, as a VCD has them.
fn changes(vcd: &str, name: &str) -> Vec<(u64, bool)> {
    let mut words = vcd.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    let unit = words.clone().find(|line| line.first() == Some(&"$timescale")).expect("a unit");
    assert_eq!(unit[1..3], ["100", "ps"]);
    let var = words.find(|line| line.first() == Some(&"$var") && line[4] == name);
    let id = var.expect("the signal")[3];
    let (mut now, mut found) = (0_u64, Vec::new());
    for line in vcd.lines() {
        if let Some(time) = line.strip_prefix('#') {
            now = time.parse().expect("a time");
        } else if line.len() == 1 + id.len() && line.ends_with(id) {
            found.push((now / 10_000, line.starts_with('1')));
        }
    }
    found
}

#[test]
fn the_edges_of_each_parts_pins_come_at_the_times_of_the_trace() {
    let bench = Bench::new();
    bench.file(
        "blink.bas",
        "SetOut 2, ON\nWait 100ms\nSetOut 2, OFF\nWait 250ms\nSetOut 2, ON\nWait 40ms\nSetOut 2, OFF\n",
    );
    for part in lang::part::PARTS {
        let args =
            ["--engine", "board", "--part", part.name, "--vcd", "p.vcd", "--trace", "t.jsonl"];
        let done = bench.run(&[&["sim", "blink.bas"][..], &args].concat());
        assert_eq!(done.code, 0, "{}: {}", part.name, done.err);
        let trace = std::fs::read_to_string(bench.path("t.jsonl")).expect("a trace");
        let waits: Vec<u64> = trace
            .lines()
            .map(|line| serde_json::from_str::<Value>(line).expect("JSON"))
            .filter(|event| event["ev"] == "wait")
            .map(|event| event["ms"].as_u64().expect("a time"))
            .collect();
        assert_eq!(waits, [100, 250, 40], "{}", part.name);
        let vcd = std::fs::read_to_string(bench.path("p.vcd")).expect("a recording");
        // The first one is the level at the beginning.
        let edges = changes(&vcd, "out_2");
        let edges = &edges[edges.len() - 4..];
        assert_eq!(edges.iter().map(|edge| edge.1).collect::<Vec<_>>(), [true, false, true, false]);
        for (pair, ms) in edges.windows(2).zip(waits) {
            let us = pair[1].0 - pair[0].0;
            assert!(us.abs_diff(1000 * ms) <= 5_000, "{}: {us} us for {ms} ms", part.name);
        }
    }
}
