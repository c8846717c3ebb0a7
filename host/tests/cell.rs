//! Cells on the command line: sim, check, test, prove; names, exit codes, formats.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value;

const SCRIPT: &str = "OUTPUT pump = 3\nINPUT held = 3\nHome\nG0 X20 Y30\nMoveAxe Z, -6.5mm, 40mm/s\nSetOut pump, ON\n\
                      WaitIn held, ON, 400ms\nMoveAxe Z, 0mm\nG0 X30 Y40\nSetOut pump, OFF\nWaitIn held, OFF, 500ms\n";
const CELL: &str = r#"cell = 1
table = -10
tool = [{ name = "nozzle", kind = "vacuum", output = "pump", input = "held" }]
part = [{ name = "chip", size = [8, 8, 4], at = [20, 30, -10] }]
place = [{ name = "box", at = [30, 40, -10], size = [12, 12, 10] }]
expect = [{ what = "in_place", place = "box" }, { what = "no_drop", within = 10 }]
vary = [{ key = "nozzle.build_ms", share = 0.1 }, { fault = "missing", of = "chip", chance = 0.3 }]
"#;

/// Exit code, standard output and standard error.
fn run(folder: &Path, args: &[&str]) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pasapas"));
    let given = command.args(args).current_dir(folder).stdin(Stdio::null()).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (given.status.code().unwrap_or(-1), text(given.stdout), text(given.stderr))
}

fn bench(cell: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("job.bas"), SCRIPT).unwrap();
    fs::write(folder.path().join("job.cell.toml"), cell).unwrap();
    folder
}

#[test]
fn sim_takes_the_cell_that_stands_beside() {
    let folder = bench(CELL);
    let (code, out, err) =
        run(folder.path(), &["sim", "job.bas", "--cell-log", "log.jsonl", "--report", "r.xml"]);
    assert_eq!(code, 0, "{out}{err}");
    assert!(out.contains("in_place box  1                      1                    yes"), "{out}");
    assert!(out.contains("not modelled: friction"), "{out}");
    let log = fs::read_to_string(folder.path().join("log.jsonl")).unwrap();
    let events: Vec<Value> = log.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(
        events.iter().map(|event| event["ev"].as_str().unwrap()).collect::<Vec<_>>(),
        ["take", "drop", "rest"]
    );
    let xml = fs::read_to_string(folder.path().join("r.xml")).unwrap();
    assert!(
        xml.contains(r#"<testsuite name="job.bas" tests="3""#)
            && xml.contains(r#"classname="job.bas""#),
        "{xml}"
    );
    // Without it nothing holds the part, and the vacuum switch never answers.
    let (code, out, _) = run(folder.path(), &["sim", "job.bas", "--no-cell"]);
    assert!(code == 3 && !out.contains("in_place"), "{out}");
    let (code, _, err) = run(folder.path(), &["sim", "job.bas", "--no-cell", "--report", "r.xml"]);
    assert!(code == 2 && err.contains("--report needs a cell"), "{err}");
}

#[test]
fn an_expectation_that_does_not_hold_ends_with_3() {
    let folder = bench(&CELL.replace("within = 10", "within = 2"));
    let (code, out, _) = run(folder.path(), &["sim", "job.bas"]);
    assert!(code == 3 && out.contains("chip fell 5.50 mm"), "{out}");
    assert!(out.lines().any(|line| line.starts_with("no_drop") && line.ends_with("NO")), "{out}");
    let (code, out, _) = run(folder.path(), &["sim", "job.bas", "--format", "json"]);
    let rows: Vec<Value> = out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let row = rows.iter().find(|row| row["expect"] == "no_drop").unwrap();
    assert_eq!((code, &row["ok"]), (3, &Value::Bool(false)));
    assert_eq!(rows[0]["engine"], "vm", "the engine that runs it is named");
    // The same on a cell that is given by name.
    fs::rename(folder.path().join("job.cell.toml"), folder.path().join("other.cell.toml")).unwrap();
    assert_eq!(run(folder.path(), &["sim", "job.bas", "--cell", "other.cell.toml"]).0, 3);
}

#[test]
fn check_tells_what_is_wrong_with_a_cell() {
    let folder = bench(&CELL.replace("output = \"pump\"", "output = \"pumpe\""));
    for args in [["check", "job.cell.toml"], ["sim", "job.bas"]] {
        let (code, _, err) = run(folder.path(), &args);
        assert_eq!(code, 1, "{err}");
        assert!(err.starts_with("job.cell.toml:3:"), "{err}");
        assert!(
            err.contains("error[C006]: output \"pumpe\": the profile \"mill\" has outputs"),
            "{err}"
        );
        assert!(err.contains("\"pump\" is meant?"), "{err}");
    }
    let inert = CELL.replace("input = \"held\"", "input = \"held\", analog = 1, hold_n = 2");
    fs::write(folder.path().join("job.cell.toml"), inert).unwrap();
    let (code, _, err) = run(folder.path(), &["check", "job.cell.toml"]);
    assert_eq!(code, 0, "{err}");
    for words in [
        "warning[C016]: `analog` of tool \"nozzle\" waits for analog inputs",
        "`hold_n` of tool \"nozzle\" has no effect yet",
    ] {
        assert!(err.contains(words), "{err}");
    }
    fs::write(folder.path().join("alone.cell.toml"), "cell = 1\nprofile = \"charly\"\nplace = [{ name = \"box\", at = [900, 0, 0], size = [9, 9, 9] }]\n").unwrap();
    let (code, _, err) = run(folder.path(), &["check", "alone.cell.toml"]);
    assert!(code == 0 && err.contains("warning[C008]") && err.contains("\"charly\""), "{err}");
}

#[test]
fn test_runs_what_stands_beside_scripts() {
    let folder = bench(CELL);
    let path = folder.path();
    fs::write(path.join("plain.bas"), "Home\n").unwrap();
    fs::write(path.join("traced.bas"), "PRINT 1\n").unwrap();
    fs::write(path.join("traced.trace"), "{\"ev\":\"print\",\"line\":1,\"text\":\"2\"}\n").unwrap();
    let (code, out, err) = run(path, &["test", "--report", "r.xml"]);
    assert_eq!(code, 3, "{out}{err}");
    assert!(out.starts_with("right ./job.bas after "), "{out}");
    assert!(out.contains(", 2 expectations\nWRONG ./traced.bas"), "{out}");
    assert!(
        out.contains(
            "  ./traced.trace:1: wanted {\"ev\":\"print\",\"line\":1,\"text\":\"2\"}, was {"
        ),
        "{out}"
    );
    assert!(out.ends_with("1 of 2 runs are right\n") && !out.contains("plain"), "{out}");
    let xml = fs::read_to_string(path.join("r.xml")).unwrap();
    assert!(xml.contains(r#"failures="1""#) && xml.contains("traced.trace:1: wanted"), "{xml}");
    let (code, out, _) = run(path, &["test", "job.bas", "--format", "json"]);
    let line: Value = serde_json::from_str(out.lines().next().unwrap()).unwrap();
    assert_eq!((code, &line["ok"], &line["expectations"]), (0, &Value::Bool(true), &2.into()));
    let empty = tempfile::tempdir().unwrap();
    let (code, _, err) = run(empty.path(), &["test"]);
    assert!(code == 1 && err.contains("there is no script with a cell"), "{err}");
}

#[test]
fn prove_tells_outcomes_and_ends_with_3_when_one_fails() {
    let folder = bench(CELL);
    let path = folder.path();
    // A part that is missing makes the script fail with F13, which nothing handles.
    let (code, out, err) =
        run(path, &["prove", "job.bas", "--runs", "6", "--seed", "1", "--report", "r.json"]);
    assert_eq!(code, 3, "{out}{err}");
    assert!(out.contains("\nfault: seed ") && out.contains("  fault with missing chip\n"), "{out}");
    assert!(out.contains("again: pasapas sim job.bas --deviate \"missing chip\"\n"), "{out}");
    let report = fs::read_to_string(path.join("r.json")).unwrap();
    let lines: Vec<Value> =
        report.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines.last().unwrap()["runs"], 6);
    let fault = lines.iter().find(|line| line["outcome"] == "fault").unwrap();
    assert_eq!((&fault["end"], &fault["line"]), (&Value::from("F13"), &Value::from(7)));
    // What it prints is repeated by `sim`.
    let (code, _, err) = run(path, &["sim", "job.bas", "--deviate", "missing chip"]);
    assert!(code == 3 && err.contains("F13"), "{err}");
    let (code, _, err) = run(path, &["sim", "job.bas", "--deviate", "mising chip"]);
    assert!(code == 2 && err.contains("`missing` is meant?"), "{err}");
    fs::remove_file(path.join("job.cell.toml")).unwrap();
    let (code, _, err) = run(path, &["prove", "job.bas"]);
    assert!(code == 1 && err.contains("there is no cell to vary"), "{err}");
}
