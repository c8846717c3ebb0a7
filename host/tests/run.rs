//! RUN on the command line: scripts beside one another, on every engine and on a virtual board.

#![cfg(unix)]

mod common;

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use common::{Board, text};

/// Exit code, standard output, standard error of the tool in a folder.
fn pasapas(folder: &Path, args: &[&str]) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_pasapas"))
        .args(args)
        .current_dir(folder)
        .stdin(Stdio::null())
        .output()
        .expect("the tool starts");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().expect("no signal"), text(output.stdout), text(output.stderr))
}

const SCRIPTS: [(&str, &str); 4] = [
    ("a.bas", "SetOut 2, ON\n\nRUN \"Plate_2\"\n"),
    (
        "plate 2.BAS",
        "KEEP n\nn = n + 1\nMoveAxe X, 1mm * n\nIF n < 3 THEN RUN \"plate_2\"\nRUN \"c\"\n",
    ),
    ("c.bas", "PRINT OUT(2); POS(X)\nRUN \"nowhere\"\n"),
    ("wrong.bas", "RUN \"broken\"\nRUN \"laser\"\n"),
];

fn folder(folder: &Path) {
    for (name, script) in SCRIPTS {
        fs::write(folder.join(name), script).expect("a file");
    }
    fs::write(folder.join("broken.bas"), "DIM\n").expect("a file");
    fs::write(folder.join("laser.bas"), "PROFILE \"laser\"\nPRINT 1\n").expect("a file");
}

#[test]
fn scripts_beside_one_another_run_on_every_engine() {
    let place = tempfile::tempdir().expect("a folder");
    folder(place.path());
    let mut traces = Vec::new();
    for engine in ["rhai", "vm", "board"] {
        let args = ["sim", "a.bas", "--engine", engine, "--trace", "-", "--plot", "p.html"];
        let (code, trace, said) = pasapas(place.path(), &args);
        assert_eq!(code, 3, "{engine}: {said}");
        assert!(said.contains("c.bas:2:1: fault F21: no such program"), "{engine}: {said}");
        assert!(said.contains("c.bas:2:1: warning[B013]: RUN \"nowhere\" ends with F21"), "{said}");
        let lines = trace.lines().map(|line| {
            let mut line: serde_json::Value = serde_json::from_str(line).expect("JSON");
            line.as_object_mut().expect("an object").remove("us");
            line.to_string()
        });
        traces.push(lines.collect::<Vec<_>>());
    }
    assert_eq!(traces[0], traces[1]);
    assert_eq!(traces[0], traces[2]);
    let runs = traces[0].iter().filter(|line| line.contains("\"ev\":\"run\"")).count();
    assert_eq!((runs, traces[0].len()), (4, 10));
    // An output is not written over a script that takes part.
    let (code, _, said) = pasapas(place.path(), &["sim", "a.bas", "--trace", "c.bas"]);
    assert_eq!(code, 2, "{said}");
}

#[test]
fn check_names_what_run_does_not_find_and_parts_without_a_library() {
    let place = tempfile::tempdir().expect("a folder");
    folder(place.path());
    let (code, _, said) = pasapas(place.path(), &["check", "wrong.bas"]);
    assert_eq!(code, 0, "{said}");
    assert!(
        said.contains("wrong.bas:1:1: warning[B013]") && said.contains("broken.bas has errors")
    );
    assert!(said.contains("wrong.bas:2:1: warning[B013]") && said.contains("machine `laser`"));
    let (code, _, said) = pasapas(place.path(), &["check", "a.bas", "--part", "g2553"]);
    assert_eq!(code, 1, "{said}");
    assert!(said.contains("a.bas:3:1: error[B008]") && said.contains("RUN"), "{said}");
    assert!(said.contains("--part f5529"), "{said}");
}

#[test]
fn a_board_runs_what_it_holds_and_the_trace_follows() {
    let board = Board::start(&["--part", "f5529"]);
    folder(board.folder.path());
    let port = board.port();
    let on =
        |args: &[&str]| pasapas(board.folder.path(), &[args, &["--port", text(&port)]].concat());
    let (code, _, said) = on(&["upload", "a.bas"]);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("\"Plate_2\", which the board does not hold"), "{said}");
    for file in ["plate 2.BAS", "c.bas", "a.bas"] {
        let (code, _, said) = on(&["upload", file]);
        assert_eq!(code, 0, "{said}");
        assert!(file != "a.bas" || !said.contains("does not hold"), "{file}: {said}");
    }
    let (code, trace, said) = on(&["trace", "a.bas"]);
    assert_eq!(code, 3, "{said}");
    let (_, wanted, _) =
        pasapas(board.folder.path(), &["sim", "a.bas", "--engine", "vm", "--trace", "-"]);
    let plain = |text: &str| -> Vec<serde_json::Value> {
        let line = |line| {
            let mut line: serde_json::Value = serde_json::from_str(line).expect("JSON");
            line.as_object_mut().expect("an object").remove("us");
            line
        };
        text.lines().map(line).collect()
    };
    assert_eq!(plain(&trace), plain(&wanted));
    // A program that has changed since is not shown with lines that are not its own.
    // Start acknowledges the fault first.
    on(&["start"]);
    fs::write(board.folder.path().join("plate 2.BAS"), "PRINT 1\n").expect("a file");
    let (_, trace, said) = on(&["trace", "a.bas"]);
    assert!(said.contains("none of the scripts beside this one"), "{said}");
    let behind = plain(&trace).split_off(2);
    assert!(!behind.is_empty() && behind.iter().take(1).all(|line| line["line"] == 0), "{trace}");
}

#[test]
fn a_job_that_runs_another_is_not_streamed() {
    let board = Board::start(&["--part", "f5529"]);
    folder(board.folder.path());
    let port = board.port();
    for more in [&[][..], &["--stored"]] {
        let args = [&["stream", "a.bas", "--port", text(&port)], more].concat();
        let (code, _, said) = pasapas(board.folder.path(), &args);
        assert_eq!(code, 1, "{said}");
        assert!(
            said.contains("a.bas:3:1: error[B008]: RUN \"Plate_2\" cannot be streamed"),
            "{said}"
        );
    }
}
