//! `pasapas selftest` with a virtual board at a pseudo-terminal: its table, its report, its exit codes.
#![cfg(unix)]

mod common;

use std::process::{Command, Output};

use common::Board;
use serde_json::Value;

fn selftest(board: &Board, more: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pasapas"))
        .args(["selftest", "--listen", "3", "--port"])
        .arg(board.port())
        .args(more)
        .output()
        .expect("the tool starts")
}

#[test]
fn a_table_and_a_report_are_made() {
    // Its clock is held to 3 %, which a busy computer keeps.
    let board = Board::start(&["--part", "g2553"]);
    let path = board.folder.path().join("report.json");
    let output = selftest(&board, &["--report", &path.display().to_string()]);
    let said = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{said}{}", String::from_utf8_lossy(&output.stderr));
    assert!(said.contains("ok    millisecond") && said.contains(" 0 not as expected"), "{said}");
    assert!(said.contains("-     motion") && said.contains("--unplugged"), "{said}");
    let report = std::fs::read_to_string(&path).expect("the report");
    let report: Value = serde_json::from_str(&report).expect("JSON");
    assert_eq!((&report["part"], &report["bad"]), (&Value::from("g2553"), &Value::from(0)));
    let rows = report["rows"].as_array().expect("rows");
    assert!(rows.iter().all(|row| row["check"].is_string() && row["expected"].is_string()));
    let left = rows.iter().filter(|row| row["result"] == "left").count();
    assert_eq!(report["left"], Value::from(left));
    assert!(rows.iter().any(|row| row["result"] == "good") && left > 0);
}

#[test]
fn what_it_does_not_do_is_told() {
    let board = Board::start(&[]);
    let program = board.folder.path().join("a.bas");
    std::fs::write(&program, "PRINT 1\n").expect("a file");
    let uploaded = Command::new(env!("CARGO_BIN_EXE_pasapas"))
        .arg("upload")
        .arg(&program)
        .arg("--port")
        .arg(board.port())
        .status();
    assert!(uploaded.expect("the tool starts").success());
    let output = selftest(&board, &[]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(4) && said.contains("--replace gives it up"), "{said}");
    // Wires without leave to switch what they hang on.
    assert_eq!(selftest(&board, &["--jumpers"]).status.code(), Some(2));
}
