//! The language reference's scripts, streamed.

use std::path::Path;

use pasapas::sim::trace::{Status, What};

use crate::lab::{Case, compare, simulate};

/// Scripts that look at an instant, which the link shifts: by what their first line says.
const INSTANTS: [&str; 13] = [
    "the wait keeps its own end",
    "Never inside a move",
    "Handlers of errors have no F",
    "The same behind an error handler",
    "Handlers are served while a pulse",
    "WaitIn and its timeout",
    "Pulse returns when the pulse is over",
    "Probing by G-code",
    "Probe: caught at that step",
    "MoveSpeed X, 20mm/s",
    "TIMER begins with the first statement",
    "StopAll; Motors OFF",
    "F by a StepRate",
];

fn scripts() -> Vec<(String, Case)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/language");
    let mut files: Vec<_> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    let mut list = Vec::new();
    for file in files {
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        let text = std::fs::read_to_string(&file).unwrap();
        for script in text.split("'---\n") {
            let world = script.lines().filter_map(|line| line.trim_start().strip_prefix("'~ "));
            let world: String = world.map(|line| format!("{line}\n")).collect();
            let first = script.lines().next().unwrap_or_default().to_owned();
            list.push((format!("{name}: {first}"), Case { script: script.to_owned(), world }));
        }
    }
    list
}

/// Streams the scripts that `wanted` takes; gives how many.
fn compare_all(wanted: impl Fn(&str) -> bool) -> usize {
    let mut wrong = String::new();
    let mut count = 0;
    for (name, case) in scripts() {
        if !wanted(&case.script) || INSTANTS.iter().any(|instant| name.contains(instant)) {
            continue;
        }
        // What waits for ever is stopped by the simulation alone.
        let end = simulate(&case).trace.pop();
        if matches!(end, Some(What::End { status: Status::Stopped, .. })) {
            continue;
        }
        if let Err(told) = compare(&case) {
            wrong += &format!("{name}: {told}\n");
        }
        count += 1;
    }
    assert!(wrong.is_empty(), "{wrong}");
    count
}

fn has_handlers(script: &str) -> bool {
    ["ON IN ", "ON EVERY ", "ON ERROR GOTO"].iter().any(|word| script.contains(word))
}

#[test]
fn the_references_handlers_hold_for_streamed_jobs() {
    let count = compare_all(has_handlers);
    assert!(count > 20, "{count}");
}

#[test]
#[ignore = "a minute: the scripts without handlers"]
fn the_reference_holds_for_streamed_jobs() {
    let count = compare_all(|script| !has_handlers(script));
    assert!(count > 60, "{count}");
}
