//! `pasapas import`: converts programs of other systems into scripts.

use std::path::Path;

use clap::Args;
use import::{Imported, Severity};
use lang::axis::Axis;
use lang::front::source::Source;
use lang::profile::Scale;
use serde_json::json;

use super::console::{Console, Options};
use crate::failure::Failure;
use crate::input;
use crate::output;
use crate::render::Note;

/// `pasapas import`
#[derive(Debug, Args)]
pub struct Import {
    /// The program; `-` is standard input
    file: String,
    /// What it is: isel, charlysoft, cde, laser, gcode, excellon, ncp, points; found by content without
    /// it
    #[arg(long, value_name = "FORMAT", value_parser = format)]
    from: Option<import::Format>,
    /// Refuse what would be done otherwise than it stands there
    #[arg(long)]
    strict: bool,
    /// Write the script here instead of to standard output
    #[arg(short, value_name = "OUT.bas")]
    output: Option<String>,
    /// Scale of a source that counts in steps: steps per millimetre, such as 100 or 400/5
    #[arg(long, value_name = "STEPS", value_parser = scale)]
    steps_per_mm: Option<Scale>,
    /// The S word of full laser power; without it 100, 255 or 1000, by the largest that stands there
    #[arg(long, value_name = "S", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    s_max: Option<u32>,
    /// Machining frequency of a JeDiV card, steps/s; without it the profile's top rate
    #[arg(long, value_name = "HZ", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    feed: Option<u32>,
    /// Travel frequency of a JeDiV card, steps/s, at and above `--threshold`
    #[arg(long, value_name = "HZ", requires = "feed", requires = "threshold",
        value_parser = clap::value_parser!(u32).range(1..=100_000))]
    travel: Option<u32>,
    /// Z in steps from which on up a JeDiV card travels
    #[arg(long, value_name = "STEPS", requires = "travel", allow_negative_numbers = true)]
    threshold: Option<i64>,
    /// Let M3 and M5 follow a laser's S, for a board that has no feature for its power
    #[arg(long)]
    on_off: bool,
    /// Of a drill file or a list of points: X or Y changes its sign, as a board's bottom side wants it
    #[arg(long, value_name = "AXIS", ignore_case = true, value_parser = ["x", "y"])]
    mirror: Option<String>,
    /// Of a drill file or a list of points: move all places, after the mirror, by so many mm, such as 10,-5.5
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = shift)]
    shift: Option<Shift>,
}

/// X and Y, um.
type Shift = [i64; 2];

/// `10,-5.5`: mm.
fn shift(text: &str) -> Result<Shift, String> {
    /// Further apart nothing lies that a drill file holds, mm.
    const MOST: f64 = 10_000.0;
    let wrong = || {
        "write X and Y in mm with a comma between them, such as 10,-5.5; 10 m at most".to_owned()
    };
    let um = |text: &str| {
        let mm = text.trim().trim_end_matches("mm").trim().parse::<f64>().ok()?;
        (mm.abs() <= MOST).then(|| (mm * 1000.0).round() as i64)
    };
    let (x, y) = text.split_once(',').ok_or_else(wrong)?;
    Ok([um(x).ok_or_else(wrong)?, um(y).ok_or_else(wrong)?])
}

fn format(name: &str) -> Result<import::Format, String> {
    import::Format::by_name(name).ok_or_else(|| {
        format!("no format is called `{name}`; known are {}", import::Format::list())
    })
}

/// `100`, or steps of a turn over millimetres of a turn.
fn scale(text: &str) -> Result<Scale, String> {
    let (steps, mm) = text.split_once('/').unwrap_or((text, "1"));
    let steps: u16 =
        steps.trim().parse().map_err(|_| format!("`{steps}` is no number of steps"))?;
    let um = mm.trim().parse::<f64>().ok().map(|mm| (mm * 1000.0).round());
    match um.filter(|um| (1.0..=65_535.0).contains(um)) {
        Some(um) if steps > 0 => Ok(Scale { steps, um: um as u16 }),
        _ => Err("write steps per millimetre, 100, or steps over millimetres, 400/5".to_owned()),
    }
}

impl Import {
    /// Reads the program and writes the script.
    ///
    /// # Errors
    /// The file cannot be read, is no program, or holds what cannot be kept.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let profile = options.profile.clone();
        let options = import::Options {
            from: self.from,
            strict: self.strict,
            plain: false,
            profile: options.profile(console)?,
            scale: self.steps_per_mm,
            s_max: self.s_max,
            card: self.feed.map(|feed| import::CardRates {
                feed,
                travel: self.travel.unwrap_or(feed),
                threshold: self.threshold,
            }),
            on_off: self.on_off,
            turn: import::Turn {
                mirror: self.mirror.as_deref().map(|axis| match axis.eq_ignore_ascii_case("x") {
                    true => Axis::X,
                    false => Axis::Y,
                }),
                shift: self.shift.unwrap_or_default(),
            },
        };
        let inputs = [Some(self.file.as_ref()), profile.as_deref().map(Path::new)];
        output::keep_inputs(&[("-o", self.output.as_ref())], &inputs)?;
        let bytes = input::read_bytes(&self.file, import::MAX_BYTES)
            .map_err(|note| console.refuse(&note))?;
        let imported = read(&self.file, &bytes, &options, console)?;
        let Some(path) = &self.output else { return console.result(&imported.script) };
        output::write(path, &imported.script)?;
        let lines = imported.script.lines().count();
        if console.json() {
            return console.json_line(&json!({
                "imported": self.file, "format": imported.format.name(), "script": path,
                "lines": lines, "profile": imported.profile,
            }));
        }
        console.complain(&format!(
            "{path}: {lines} lines from {} ({})",
            self.file,
            imported.format.name()
        ));
        Ok(())
    }
}

/// Makes a script of a program; every diagnostic is written.
///
/// # Errors
/// The program cannot be kept.
pub fn read(
    file: &str,
    bytes: &[u8],
    options: &import::Options,
    console: &Console,
) -> Result<Imported, Failure> {
    let made = import::import(file, bytes, options);
    let (Ok(Imported { notes, .. }) | Err(notes)) = &made;
    let shown = Source::new(file, String::from_utf8_lossy(bytes).into_owned());
    for diag in notes {
        if diag.severity == Severity::Note {
            if !console.json() {
                console.complain(diag.render(file).trim_end());
            }
            continue;
        }
        let mut note =
            Note::error(file, diag.code.id(), diag.text.clone()).at((diag.line, diag.col));
        if diag.severity == Severity::Warning {
            note = note.warning();
        }
        if let Some(hint) = &diag.hint {
            note = note.hint(hint.clone());
        }
        if diag.line > 0 {
            let before =
                shown.line_text(diag.line).chars().take(diag.col.saturating_sub(1) as usize);
            let at =
                shown.line_start(diag.line) as usize + before.map(char::len_utf8).sum::<usize>();
            note.span = at..at;
        }
        console.note_in(&note, &shown)?;
    }
    made.map_err(|_| Failure::Input)
}

#[cfg(test)]
mod tests {
    use super::{Scale, scale, shift};

    #[test]
    fn shifts_are_two_numbers_of_mm() {
        assert_eq!(shift("10,-5.5"), Ok([10_000, -5_500]));
        assert_eq!(shift("-0.0004mm, 2mm"), Ok([0, 2_000]));
        for wrong in ["", "10", "10;5", "a,5", "1,2,3", "10001,0", "nan,0", "inf,1"] {
            assert!(shift(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn scales_are_steps_over_millimetres() {
        assert_eq!(scale("100"), Ok(Scale { steps: 100, um: 1000 }));
        assert_eq!(scale("400/2.5"), Ok(Scale { steps: 400, um: 2500 }));
        for wrong in ["", "0", "5/0", "a", "100/1000"] {
            assert!(scale(wrong).is_err(), "{wrong}");
        }
    }
}
