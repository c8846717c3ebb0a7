//! The summary of a run: time, travel, what each output did.

use lang::hir::Program;
use lang::part::Part;
use serde::Serialize;

use super::console::Console;
use crate::failure::Failure;
use crate::plot::time;
use crate::sim::Outcome;
use crate::sim::record::Summary;

/// Writes it to standard output, or to standard error when that has the trace. `engine` is who ran it, `part` whose times
/// it has.
///
/// # Errors
/// Standard output is full or gone.
pub fn write(
    file: &str,
    (engine, part): (&str, &Part),
    program: &Program,
    outcome: &Outcome,
    notes: &[String],
    to_stderr: bool,
    console: &Console,
) -> Result<(), Failure> {
    #[derive(Serialize)]
    struct Line<'a> {
        file: &'a str,
        engine: &'a str,
        part: &'a str,
        #[serde(flatten)]
        summary: &'a Summary,
        failures: &'a [String],
        notes: &'a [String],
    }
    let text = if console.json() {
        let (summary, failures) = (&outcome.summary, &outcome.failures);
        let line = Line { file, engine, part: part.name, summary, failures, notes };
        serde_json::to_string(&line).unwrap_or_default()
    } else {
        let mut text = describe(file, part, program, &outcome.summary);
        notes.iter().for_each(|note| text += &format!("\n  note: {note}"));
        text
    };
    if to_stderr {
        console.complain(&text);
        Ok(())
    } else {
        console.result(&format!("{text}\n"))
    }
}

fn describe(file: &str, part: &Part, program: &Program, summary: &Summary) -> String {
    let status = match summary.status {
        crate::sim::trace::Status::Done => "done",
        crate::sim::trace::Status::Stopped => "stopped",
        crate::sim::trace::Status::Fault => "fault",
    };
    let mut text = format!("{file}: {status} in line {} after {}", summary.line, time(summary.us));
    match summary.statements {
        0 => {}
        1 => text += ", 1 statement",
        n => text += &format!(", {n} statements"),
    }
    text += &format!(", times of the {}", part.chip.name);
    if let Some(reason) = summary.stopped {
        text += &format!(": {}", reason.text());
    }
    for (i, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
        if summary.steps[i] > 0 {
            let travel = summary.travel_um[i] as f64 / 1000.0;
            let steps = summary.steps[i];
            text += &format!("\n  {letter} travelled {travel:9.3} mm, {steps:9} steps");
        }
    }
    for used in &summary.outputs {
        let times = if used.switched_on == 1 { "once" } else { "times" };
        let count = match used.switched_on {
            1 => String::new(),
            n => format!("{n} "),
        };
        let name = program.port_name(true, used.n).map_or_else(String::new, |n| format!("{n} "));
        text +=
            &format!("\n  out {:<2} {name}on {count}{times}, {} in all", used.n, time(used.on_us));
    }
    text
}
