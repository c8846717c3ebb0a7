//! A list of points becomes a table and a loop that goes to each of them.
//!
//! What is done at a point stands in no list. The loop has a place for it.

use super::Job;
use super::codes::Code;
use super::diag::{Diag, Diags};
use super::pattern::{Act, Pattern, Shape, Work, points, write};
use super::script::Made;

/// Where the script says what is done at each point.
const PLACE: &str = "  ' Here: what is done at each point.";

/// Makes a script of a list.
pub(crate) fn import(job: &Job<'_>, diags: &mut Diags) -> Made {
    let (_, mut points) = points(job.name, job.lines, diags);
    for point in &mut points {
        point.at = job.options.turn.place(point.at);
    }
    if diags.has_errors() {
        return Made::default();
    }
    let pattern = Pattern {
        shape: Shape::Points(points),
        origin: [0; 2],
        frame: None,
        work: Work { down: None, spindle: false, act: Act::Nothing },
        name: "points".to_owned(),
    };
    let written = match write(&pattern, job.profile, None) {
        Ok(written) => written,
        Err(text) => {
            diags.push(Diag::new(Code::OutOfRange, 1, 1, text));
            return Made::default();
        }
    };
    let text = format!("{} points; what is done at each of them stands in no list", written.count);
    let hint = "write it behind G0 in the loop; the workbench's Pattern does it with depth, wait or output";
    diags.push(Diag::new(Code::Said, 1, 1, text).note().hint(hint));
    for note in written.notes {
        diags.push(Diag::new(Code::Said, 1, 1, note).note());
    }
    let mut text = String::new();
    if let Some(words) = job.options.turn.words() {
        text = format!("' The file's places are {words}.\n");
    }
    for line in written.text.lines() {
        text.push_str(line);
        text.push('\n');
        if line.trim_start().starts_with("G0 X[") {
            text.push_str(PLACE);
            text.push('\n');
        }
    }
    Made { places: vec![0; text.lines().count()], text }
}
