//! `pasapas paste`: makes a job of dots from a paste layer or a list of pads.

use std::collections::BTreeMap;
use std::path::Path;

use clap::{Args, ValueEnum};
use lang::profile::Profile;
use serde_json::json;
use shop::Wrong;
use shop::paste::beads::{self, Bead};
use shop::paste::dots::{self, Dot};
use shop::paste::job::Given;
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
/// By how much of it a bead may miss what the stencil would give.
const FAIR: f64 = 0.2;
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
        let (dots, beads) = self.places(&pads, &needle, bottom, &onto, &profile, console)?;
        let given = Given { dots: &dots, beads: &beads, pads: &pads };
        let text = job::script(given, &needle, &profile, &self.file).map_err(Failure::Usage)?;
        match &self.output {
            Some(path) => output::write(path, text.as_bytes())?,
            None => console.result(&text)?,
        }
        self.small(given, &needle, console)?;
        self.tell(given, &needle, &onto, console)
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

    /// Dots and beads on the machine, in their order.
    fn places(
        &self,
        pads: &[Pad],
        needle: &Needle,
        bottom: bool,
        onto: &Onto,
        profile: &Profile,
        console: &Console,
    ) -> Result<(Vec<Dot>, Vec<Bead>), Failure> {
        let line = |pad: &Pad| needle.bead.as_ref().and_then(|asked| beads::line(pad, asked));
        let lines: Vec<_> = pads.iter().map(line).collect();
        let counts = pads.iter().zip(&lines).map(|(pad, line)| match line {
            Some(_) => 1,
            None => dots::count(pad, needle.area()),
        });
        let count: usize = counts.sum();
        if count > dots::MOST {
            let words = format!("{count} dots and beads; a job has at most {}", dots::MOST);
            let wrong = Wrong::new(1, words, "a needle with larger dots, or the layer in pieces");
            return Err(console.refuse(&note(&self.file, "X035", &wrong)));
        }
        let mut outside = 0;
        let mut place = |[x, y]: [f64; 2], pad: &Pad, what: &str| {
            let um = |mm: f64| (mm * 1000.0).round() as i64;
            let at = onto.place([um(if bottom { -x } else { x }), um(y)]);
            if let Some(words) = off(at, profile) {
                outside += 1;
                if outside <= MOST_NAMED {
                    let words = format!("a {what} of {} comes to {words}", called(pad));
                    let hint = "--at X,Y=X,Y says where the board lies on the machine";
                    let wrong = Wrong::new(pad.line, words, hint);
                    console.note(&note(&self.file, "X035", &wrong))?;
                }
            }
            Ok::<_, Failure>(at.map(|um| um as f64 / 1000.0))
        };
        let (mut dots, mut beads) = (Vec::with_capacity(count), Vec::new());
        for (n, (pad, line)) in pads.iter().zip(lines).enumerate() {
            if let (Some([from, to]), Some(asked)) = (line, &needle.bead) {
                let ends = [place(from, pad, "bead")?, place(to, pad, "bead")?];
                beads.push(Bead { ends, speed: beads::speed(pad, ends, needle, asked), pad: n });
                continue;
            }
            for at in dots::spread(pad, dots::count(pad, needle.area())) {
                dots.push(Dot { at: place(at, pad, "dot")?, pad: n });
            }
        }
        if outside > 0 {
            console.complain(&format!("{outside} of {count} lie outside of the travel"));
            return Err(Failure::Input);
        }
        let dots = dots::order(dots);
        let last = dots.last().map_or([0.0; 2], |dot| dot.at);
        Ok((dots, beads::order(beads, last)))
    }

    /// Names the pads that get too much from one dot, and the beads that give too much or too little.
    fn small(&self, given: Given<'_>, needle: &Needle, console: &Console) -> Result<(), Failure> {
        let Given { pads, beads, .. } = given;
        for bead in beads {
            let (pad, part) = (&pads[bead.pad], beads::given(bead, &pads[bead.pad], needle));
            if (1.0 - FAIR..=1.0 + FAIR).contains(&part) {
                continue;
            }
            let words = format!("{}: its bead gives {:.0} %", called(pad), part * 100.0);
            let hint = match part > 1.0 {
                true => "a greater `fastest`, or less pressure and a greater `ms`",
                false => "a smaller `slowest`, or more pressure and a smaller `ms`",
            };
            let wrong = Wrong::new(pad.line, words, hint).warning();
            console.note(&note(&self.file, "X035", &wrong))?;
        }
        let dotted = |n: usize| beads.iter().all(|bead| bead.pad != n);
        let pads: Vec<&Pad> =
            pads.iter().enumerate().filter(|(n, _)| dotted(*n)).map(|(_, pad)| pad).collect();
        let small = |pad: &&&Pad| pad.area.is_some_and(|area| area < SMALL * needle.area());
        let small: Vec<&&Pad> = pads.iter().filter(small).collect();
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
        given: Given<'_>,
        needle: &Needle,
        onto: &Onto,
        console: &Console,
    ) -> Result<(), Failure> {
        let Given { dots, beads, pads } = given;
        // By area, and how many dots it gets: 0 for a bead.
        let mut rows: BTreeMap<(i64, usize), (usize, f64)> = BTreeMap::new();
        for (n, pad) in pads.iter().enumerate() {
            let own = pad.area.unwrap_or_default();
            let (count, part) = match beads.iter().find(|bead| bead.pad == n) {
                Some(bead) => (0, beads::given(bead, pad, needle)),
                None => {
                    let count = dots::count(pad, needle.area());
                    (count, count as f64 * needle.area() / own)
                }
            };
            let row = rows.entry(((own * 100.0).round() as i64, count)).or_default();
            *row = (row.0 + 1, part);
        }
        let wanted: f64 = pads.iter().filter_map(|pad| pad.area).sum();
        let way = dots::way(dots) + beads::way(beads);
        if console.json() {
            let rows: Vec<_> = rows
                .iter()
                .map(|((area, dots), (pads, _))| {
                    let area = *area as f64 / 100.0;
                    json!({ "area_mm2": area, "pads": pads, "dots": dots, "bead": *dots == 0 })
                })
                .collect();
            return match &self.output {
                Some(_) => console.json_line(&json!({
                    "pads": pads.len(), "dots": dots.len(), "beads": beads.len(), "rows": rows,
                    "way_mm": way.round(),
                })),
                None => Ok(()),
            };
        }
        let mut text =
            format!("{:>9} {:>6} {:>10} {:>7}\n", "pad, mm2", "pads", "dots each", "given");
        for ((area, count), (pads, part)) in &rows {
            let each = if *count == 0 { "a bead".to_owned() } else { count.to_string() };
            let part = match *area > 0 {
                true => format!("{:.0} %", 100.0 * part),
                false => "-".to_owned(),
            };
            let area = *area as f64 / 100.0;
            text += &format!("{area:>9.2} {pads:>6} {each:>10} {part:>7}\n");
        }
        text += &format!(
            "{} on {} pads of {wanted:.1} mm2, a dot for {:.2} mm2, way {:.2} m",
            job::counted(dots.len(), beads.len()),
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
