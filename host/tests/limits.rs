//! What the largest inputs may take of the computer's memory and time.
#![cfg(unix)]

use std::fmt::Write as _;
use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Address space of the tool in KiB: 500 MB, in which its own code of some 20 MB is contained.
const ADDRESS_SPACE: u32 = 500_000;

/// Runs `check` on a script in a bounded address space; gives its exit code, what it said and how
/// long it took.
fn check_bounded(script: &str) -> (Option<i32>, String, Duration) {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("large.bas"), script).expect("a file");
    let line = format!("ulimit -v {ADDRESS_SPACE} && exec \"$0\" check large.bas");
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
