//! `pasapas paste`: makes a job of dots from a paste layer or a list of pads.

use std::collections::BTreeMap;
use std::path::Path;

use clap::{Args, ValueEnum};
use lang::profile::Profile;
use serde_json::json;
use shop::Wrong;
use shop::paste::dots::{self, Dot};
use shop::paste::needle::Needle;
use shop::paste::pads::{Pad, pads};
use shop::paste::{self, Layer, Side, job};

use super::console::{Console, Options};
use crate::failure::Failure;
use crate::input;
use crate::output;
use crate::place::frame::{Mark, Onto, onto};
use crate::render::Note;

/// Parts of a dot's area below which a pad gets too much.
const SMALL: f64 = 0.6;
/// Small pads that are named.
const MOST_NAMED: usize = 10;

/// `pasapas paste`
#[derive(Debug, Args)]
pub struct Paste {
    /// A paste layer (Gerber), or a list of pads (x, y, width, height, angle, name)
    file: String,
    /// What gives the dots
    #[arg(long, value_name = "N.toml")]
    needle: String,
    /// A place of the file, and where the machine has it, mm: 59,-159=10,10. One shifts, two or more
    /// turn too
    #[arg(long, value_name = "X,Y=X,Y", allow_hyphen_values = true)]
    at: Vec<String>,
    /// The side that lies upward; without it the file's
    #[arg(long, value_enum)]
    side: Option<Up>,
    /// The unit of a list that does not tell it
    #[arg(long, value_enum)]
    unit: Option<ListUnit>,
    /// The script; without it standard output
    #[arg(short, long, value_name = "DOTS.bas")]
    output: Option<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Up {
    Top,
    Bottom,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ListUnit {
    Mm,
    In,
}

impl Paste {
    /// Reads the files and writes the script.
    ///
    /// # Errors
    /// A file is wrong, or a dot lies outside of the machine; that was written.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let inputs = [Some(Path::new(&self.file)), Some(Path::new(&self.needle))];
        output::keep_inputs(&[("-o", self.output.as_ref())], &inputs)?;
        let profile = options.machine(console)?;
        let text = input::read_text(&self.needle).map_err(|note| console.refuse(&note))?;
        let needle = Needle::parse(&text, &profile)
            .map_err(|wrong| console.refuse(&note(&self.needle, "X034", &wrong)))?;
        let layer = self.layer(console)?;
        let pads =
            pads(&layer).map_err(|wrong| console.refuse(&note(&self.file, "X035", &wrong)))?;
        let bottom = match self.side {
            Some(side) => side == Up::Bottom,
            None => layer.side == Some(Side::Bottom),
        };
        if bottom {
            console.complain("the bottom lies upward: X is mirrored");
        }
        let onto = self.frame(bottom)?;
        let found = self.dots(&pads, &needle, bottom, &onto, &profile, console)?;
        let text =
            job::script(&found, &pads, &needle, &profile, &self.file).map_err(Failure::Usage)?;
        match &self.output {
            Some(path) => output::write(path, text.as_bytes())?,
            None => console.result(&text)?,
        }
        self.small(&pads, &needle, console)?;
        self.tell(&pads, &found, &needle, &onto, console)
    }

    fn layer(&self, console: &Console) -> Result<Layer, Failure> {
        let text = input::read_bytes(&self.file, paste::MAX_BYTES)
            .map_err(|note| console.refuse(&note))?;
        let text = String::from_utf8_lossy(&text);
        let unit = self.unit.map(|unit| if unit == ListUnit::In { 25.4 } else { 1.0 });
        let told = |wrong: &[Wrong]| {
            wrong.iter().try_for_each(|wrong| console.note(&note(&self.file, "X035", wrong)))
        };
        match paste::read(text.strip_prefix('\u{feff}').unwrap_or(&text), unit) {
            Ok(layer) => {
                told(&layer.notes)?;
                Ok(layer)
            }
            Err(wrong) => {
                told(&wrong)?;
                Err(Failure::Input)
            }
        }
    }

    /// Where the file's places lie on the machine.
    fn frame(&self, bottom: bool) -> Result<Onto, Failure> {
        let mut marks = Vec::new();
        for text in &self.at {
            let place = |text: &str| {
                let (x, y) = text.split_once(',')?;
                let um = |text: &str| {
                    let mm = text.trim().parse::<f64>().ok().filter(|mm| mm.abs() < 10_000.0)?;
                    Some((mm * 1000.0).round() as i64)
                };
                Some([um(x)?, um(y)?])
            };
            let pair = text.split_once('=').and_then(|(a, b)| Some((place(a)?, place(b)?)));
            let (mut drawn, taught) = pair.ok_or_else(|| {
                Failure::Usage(format!("--at {text}: it is X,Y=X,Y in mm, as 59,-159=10,10"))
            })?;
            if bottom {
                drawn[0] = -drawn[0];
            }
            let name = text.split('=').next().unwrap_or_default().to_owned();
            marks.push(Mark { name, drawn, taught });
        }
        onto(&marks).map_err(Failure::Usage)
    }

    /// The dots on the machine, in their order.
    fn dots(
        &self,
        pads: &[Pad],
        needle: &Needle,
        bottom: bool,
        onto: &Onto,
        profile: &Profile,
        console: &Console,
    ) -> Result<Vec<Dot>, Failure> {
        let count: usize = pads.iter().map(|pad| dots::count(pad, needle.area())).sum();
        if count > dots::MOST {
            let words = format!("{count} dots; a job has at most {}", dots::MOST);
            let wrong = Wrong::new(1, words, "a needle with larger dots, or the layer in pieces");
            return Err(console.refuse(&note(&self.file, "X035", &wrong)));
        }
        let mut found = Vec::with_capacity(count);
        let mut outside = 0;
        for (n, pad) in pads.iter().enumerate() {
            for [x, y] in dots::spread(pad, dots::count(pad, needle.area())) {
                let um = |mm: f64| (mm * 1000.0).round() as i64;
                let at = onto.place([um(if bottom { -x } else { x }), um(y)]);
                if let Some(words) = off(at, profile) {
                    outside += 1;
                    if outside <= MOST_NAMED {
                        let words = format!("a dot of {} comes to {words}", called(pad));
                        let hint = "--at X,Y=X,Y says where the board lies on the machine";
                        console.note(&note(
                            &self.file,
                            "X035",
                            &Wrong::new(pad.line, words, hint),
                        ))?;
                    }
                }
                found.push(Dot { at: at.map(|um| um as f64 / 1000.0), pad: n });
            }
        }
        match outside {
            0 => Ok(dots::order(found)),
            n => {
                console.complain(&format!("{n} of {count} dots lie outside of the travel"));
                Err(Failure::Input)
            }
        }
    }

    /// Names the pads that get too much from one dot.
    fn small(&self, pads: &[Pad], needle: &Needle, console: &Console) -> Result<(), Failure> {
        let small = |pad: &&Pad| pad.area.is_some_and(|area| area < SMALL * needle.area());
        let small: Vec<&Pad> = pads.iter().filter(small).collect();
        for pad in small.iter().take(MOST_NAMED) {
            let (area, dot) = (pad.area.unwrap_or_default(), needle.area());
            let words = format!("{}: {area:.2} mm2, and one dot is for {dot:.2} mm2", called(pad));
            let hint = "a finer needle, or less `ms`";
            console.note(&note(
                &self.file,
                "X035",
                &Wrong::new(pad.line, words, hint).warning(),
            ))?;
        }
        if small.len() > MOST_NAMED {
            console.complain(&format!("{} more pads are as small", small.len() - MOST_NAMED));
        }
        Ok(())
    }

    /// The table of what is given.
    fn tell(
        &self,
        pads: &[Pad],
        found: &[Dot],
        needle: &Needle,
        onto: &Onto,
        console: &Console,
    ) -> Result<(), Failure> {
        let mut rows: BTreeMap<(i64, usize), usize> = BTreeMap::new();
        for pad in pads {
            let area = (pad.area.unwrap_or_default() * 100.0).round() as i64;
            *rows.entry((area, dots::count(pad, needle.area()))).or_default() += 1;
        }
        let wanted: f64 = pads.iter().filter_map(|pad| pad.area).sum();
        let way = dots::way(found);
        if console.json() {
            let rows: Vec<_> = rows
                .iter()
                .map(|((area, dots), pads)| {
                    json!({ "area_mm2": *area as f64 / 100.0, "pads": pads, "dots": dots })
                })
                .collect();
            return match &self.output {
                Some(_) => console.json_line(&json!({
                    "pads": pads.len(), "dots": found.len(), "rows": rows, "way_mm": way.round(),
                })),
                None => Ok(()),
            };
        }
        let mut text =
            format!("{:>9} {:>6} {:>10} {:>7}\n", "pad, mm2", "pads", "dots each", "given");
        for ((area, dots), count) in &rows {
            let area = *area as f64 / 100.0;
            let given = match area > 0.0 {
                true => format!("{:.0} %", 100.0 * *dots as f64 * needle.area() / area),
                false => "-".to_owned(),
            };
            text += &format!("{area:>9.2} {count:>6} {dots:>10} {given:>7}\n");
        }
        text += &format!(
            "{} dots on {} pads of {wanted:.1} mm2, a dot for {:.2} mm2, way {:.2} m",
            found.len(),
            pads.len(),
            needle.area(),
            way / 1000.0
        );
        for (name, um) in &onto.off {
            text += &format!("; {name} is {um:.0} um off");
        }
        console.complain(&text);
        Ok(())
    }
}

/// A pad for people.
fn called(pad: &Pad) -> String {
    let [x, y] = pad.at;
    match pad.name.as_str() {
        "" => format!("the pad at {x:.2}, {y:.2}"),
        name => format!("{name}, the pad at {x:.2}, {y:.2}"),
    }
}

/// Where a place is, in words, when it is outside of the travel.
fn off(at: [i64; 2], profile: &Profile) -> Option<String> {
    let axes = [(&profile.x, at[0], 'X'), (&profile.y, at[1], 'Y')];
    axes.into_iter().find_map(|(axis, um, letter)| {
        let inside = axis
            .as_ref()
            .is_some_and(|axis| (i64::from(axis.min_um)..=i64::from(axis.max_um)).contains(&um));
        (!inside).then(|| format!("{letter} {:.3} mm, outside the travel", um as f64 / 1000.0))
    })
}

/// A diagnostic of one of the shop's files.
pub(super) fn note(file: &str, code: &'static str, wrong: &Wrong) -> Note {
    let note = Note::error(file, code, wrong.text.clone()).at(wrong.at);
    let note = if wrong.warning { note.warning() } else { note };
    if wrong.hint.is_empty() { note } else { note.hint(wrong.hint.clone()) }
}
