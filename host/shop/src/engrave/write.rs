//! A laser's job as a script, or as G-code.

use std::fmt::Write;

use super::{Job, Laser, MAX_TEXT};
use crate::Wrong;
use crate::text::{comment, plain};

/// What is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// A script of this language.
    Script,
    /// G-code, as `stream` and other controllers take it.
    Gcode,
}

/// Writes a job: dark and at rest at its end. `speed` is in mm/s, `profile` the machine's name.
///
/// # Errors
/// The job is too long.
pub fn write(
    job: &Job,
    form: Form,
    laser: &Laser,
    speed: f64,
    (profile, from): (&str, &str),
) -> Result<String, Wrong> {
    let sign = if form == Form::Script { "'" } else { ";" };
    let mut out = format!("{sign} By pasapas engrave of {}.\n", comment(from));
    for line in &job.head {
        let _ = writeln!(out, "{sign} {}", comment(line));
    }
    match form {
        Form::Script => drop(writeln!(out, "PROFILE \"{profile}\"\nG90")),
        Form::Gcode => out.push_str("G90\nG21\n"),
    }
    let on = if laser.follows { "M4" } else { "M3" };
    let _ = writeln!(out, "{on} S0\nF{}", plain(speed * 60.0));
    // What holds: places as they are written, whether G1 holds, and S.
    let (mut at, mut burns, mut power) = ([String::new(), String::new()], None, None);
    for step in &job.steps {
        let places = step.to.map(plain);
        let mut line = String::new();
        if burns != Some(step.power.is_some()) {
            line.push_str(if step.power.is_some() { " G1" } else { " G0" });
        }
        let moved = places != at;
        for (letter, (new, old)) in "XY".chars().zip(places.iter().zip(&at)) {
            if new != old {
                let _ = write!(line, " {letter}{new}");
            }
        }
        if !moved {
            continue;
        }
        burns = Some(step.power.is_some());
        if step.power.is_some() && step.power != power {
            let _ = write!(line, " S{}", step.power.unwrap_or(0));
            power = step.power;
        }
        at = places;
        out.push_str(line.trim_start());
        out.push('\n');
        if out.len() > MAX_TEXT {
            let words = format!("the job is longer than {} MB", MAX_TEXT >> 20);
            return Err(Wrong::whole(words, "fewer --lines, or a smaller --size"));
        }
    }
    out.push_str("M5\nG0 X0 Y0\n");
    Ok(out)
}
