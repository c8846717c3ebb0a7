//! What the largest inputs may take of the computer's memory and time.
#![cfg(unix)]

use std::fmt::Write as _;
use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Address space of the tool in KiB beside its own file, which has some 20 MB, and more without optimization: 500 MB in all.
const ADDRESS_SPACE: u64 = 480_000;

/// Runs `check` on a script in a bounded address space; gives its exit code, what it said and how
/// long it took.
fn check_bounded(script: &str) -> (Option<i32>, String, Duration) {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("large.bas"), script).expect("a file");
    let own = fs::metadata(env!("CARGO_BIN_EXE_pasapas")).expect("the tool").len() / 1024;
    let line = format!("ulimit -v {} && exec \"$0\" check large.bas", ADDRESS_SPACE + own);
    let begun = Instant::now();
    let output = Command::new("sh")
        .args(["-c", &line, env!("CARGO_BIN_EXE_pasapas")])
        .current_dir(folder.path())
        .stdin(Stdio::null())
        .output()
        .expect("a shell");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code(), said, begun.elapsed())
}

/// Built without optimisation the tool takes several times what is promised, 5 s.
const PATIENCE: Duration = Duration::from_secs(if cfg!(debug_assertions) { 30 } else { 5 });

/// A laser's picture of so many lines.
fn raster(lines: usize) -> String {
    let mut text = "G90\nM3 S0\nG0 X0 Y0\nF1000\n".to_owned();
    for n in 0..lines {
        let (row, column) = (n / 300, n % 300);
        let column = if row % 2 == 0 { column } else { 299 - column };
        let _ = writeln!(text, "G1 X{column} Y{:.1} S{}", row as f64 / 10.0, n * 7919 % 256);
    }
    text + "M5\n"
}

#[test]
fn a_picture_of_a_long_job_takes_no_longer_than_its_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let time = |lines: usize, plot: &[&str]| {
        fs::write(folder.path().join("raster.gco"), raster(lines)).expect("a file");
        let begun = Instant::now();
        let output = Command::new(env!("CARGO_BIN_EXE_pasapas"))
            .args(["sim", "raster.gco", "--profile", "laser"])
            .args(plot)
            .current_dir(folder.path())
            .output()
            .expect("the tool starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        begun.elapsed()
    };
    let alone = time(40_000, &[]);
    let drawn = time(40_000, &["--plot", "q.svg"]);
    assert!(drawn < alone * 2 + Duration::from_secs(2), "{drawn:?} with, {alone:?} without");
    let picture = fs::metadata(folder.path().join("q.svg")).expect("a picture");
    assert!(picture.len() > 100_000, "{} bytes", picture.len());
}

#[test]
fn a_million_statements_are_checked_in_bounded_memory() {
    let line = ["a=1"; 1000].join(":");
    let script = format!("DIM a\n{}", format!("{line}\n").repeat(1000));
    let (code, said, took) = check_bounded(&script);
    assert_eq!(code, Some(0), "{said}");
    assert!(took < PATIENCE, "it took {took:?}");
}

#[test]
fn a_hundred_thousand_subs_are_checked_in_bounded_memory() {
    let mut script = String::new();
    for n in 0..100_000 {
        let _ = writeln!(script, "work_{n}");
    }
    for n in 0..100_000 {
        let _ = writeln!(script, "SUB work_{n}\nWait 1ms\nEND SUB");
    }
    let (code, said, took) = check_bounded(&script);
    assert_eq!(code, Some(0), "{said}");
    assert!(took < PATIENCE, "it took {took:?}");
}

/// An editor that names an absurd length: the process reserved that much and aborted, or panicked.
#[test]
fn a_language_server_ends_in_words_whatever_length_it_is_told() {
    for (length, word) in [
        ("99999999999999", "at most"),
        ("18446744073709551615", "at most"),
        ("99999999999999999999999", "without its length"),
        ("-1", "without its length"),
        ("5", "expected"),
    ] {
        let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_pasapas"))
            .arg("lsp")
            .stdin(std::process::Stdio::piped())
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .expect("it starts");
        let mut input = child.stdin.take().expect("piped");
        let message = format!("Content-Length: {length}\r\n\r\nhello");
        std::io::Write::write_all(&mut input, message.as_bytes()).expect("it listens");
        // The editor's end stays open.
        let output = child.wait_with_output().expect("an end");
        drop(input);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(4), "{length}: {said}");
        assert!(said.contains(word) && !said.contains("panicked"), "{length}: {said}");
    }
}
