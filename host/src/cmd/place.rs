//! `pasapas place`: makes a job from a circuit board's placement file.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use clap::{Args, ValueEnum};
use import::placement::{self, List, Part, Side as PartSide, Unit};
use lang::profile::Profile;
use serde_json::json;

use super::console::{Console, Options};
use super::paste;
use crate::failure::Failure;
use crate::output;
use crate::place::Placed;
use crate::place::feeders::Feeders;
use crate::place::frame::{Mark, Onto, onto};
use crate::place::job;
use crate::render::Note;

/// Angles that differ by less are the same, degrees: what a board that lies a little turned costs its parts.
const SAME_ANGLE: f64 = 2.0;
/// Degrees off that are told.
const TOLD_ANGLE: f64 = 0.1;

/// `pasapas place`
#[derive(Debug, Args)]
pub struct Place {
    /// Placement files of KiCad, Altium, Eagle, EasyEDA, JLC or Proteus
    #[arg(required = true, value_name = "FILE")]
    files: Vec<String>,
    /// Where parts lie
    #[arg(long, value_name = "F.toml")]
    feeders: String,
    /// A bill of material: values and packages, and what is not fitted
    #[arg(long, value_name = "B.csv")]
    bom: Option<String>,
    /// The side that lies upward
    #[arg(long, value_enum, default_value_t = Side::Top)]
    side: Side,
    /// How the file gives the bottom's X: mirrored, as seen from below; through, as seen from above
    #[arg(long, value_enum)]
    bottom: Option<Bottom>,
    /// A part or fiducial of the file, and where the machine has it, mm: FID1=103.02,52.9. One shifts,
    /// two or more turn too
    #[arg(long, value_name = "REF=X,Y")]
    at: Vec<String>,
    /// Only these references
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    only: Vec<String>,
    /// Without these references
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    skip: Vec<String>,
    /// The unit of files that do not tell it
    #[arg(long, value_enum)]
    unit: Option<FileUnit>,
    /// The script; without it standard output
    #[arg(short, long, value_name = "JOB.bas")]
    output: Option<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Side {
    Top,
    Bottom,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Bottom {
    Mirrored,
    Through,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FileUnit {
    Mm,
    In,
}

impl Place {
    /// Reads the files and writes the script.
    ///
    /// # Errors
    /// A file is wrong, or a part cannot be placed; that was written.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let inputs: Vec<Option<&Path>> = self
            .files
            .iter()
            .chain([&self.feeders])
            .chain(&self.bom)
            .map(|file| Some(Path::new(file)))
            .collect();
        output::keep_inputs(&[("-o", self.output.as_ref())], &inputs)?;
        let profile = options.machine(console)?;
        let feeders = self.feeders(&profile, console)?;
        let mut list = Vec::new();
        for file in &self.files {
            let read = self.read(file, console)?;
            list.extend(read.parts.into_iter().map(|part| (file.clone(), part)));
        }
        self.join(&mut list, console)?;
        let wanted = if self.side == Side::Top { PartSide::Top } else { PartSide::Bottom };
        self.seen(&mut list, console)?;
        let onto = self.frame(&list, console)?;
        let chosen = |part: &Part| {
            let named = |names: &[String]| names.contains(&part.name);
            part.side == wanted
                && !named(&self.skip)
                && (self.only.is_empty() && !part.is_fiducial() || named(&self.only))
        };
        for name in self.only.iter().chain(&self.skip) {
            if !list.iter().any(|(_, part)| part.name == *name) {
                return Err(Failure::Usage(format!("no part is called {name}")));
            }
        }
        let mut parts = Vec::new();
        let mut wrong = false;
        for (file, part) in list.iter().filter(|(_, part)| chosen(part)) {
            match placed(part, &feeders, &onto, &profile) {
                Ok(one) => parts.push(one),
                Err((words, hint)) => {
                    wrong = true;
                    let note = Note::error(file, "X031", words).at((part.line, 1));
                    console.note(&note.hint(hint))?;
                }
            }
        }
        if wrong {
            return Err(Failure::Input);
        }
        let other = list.iter().filter(|(_, part)| part.side != wanted).count();
        if other > 0 {
            let side = if self.side == Side::Top { "bottom" } else { "top" };
            console
                .complain(&format!("{other} parts lie on the {side}; --side {side} places them"));
        }
        if parts.is_empty() {
            return Err(Failure::Usage("no part is left to place".to_owned()));
        }
        let parts = job::order(parts, &feeders);
        let text = job::script(&parts, &feeders, &profile, &self.files.join(" "))
            .map_err(Failure::Usage)?;
        match &self.output {
            Some(path) => output::write(path, text.as_bytes())?,
            None => console.result(&text)?,
        }
        self.tell(&parts, &feeders, &onto, console)
    }

    fn feeders(&self, profile: &Profile, console: &Console) -> Result<Feeders, Failure> {
        let text = fs::read_to_string(&self.feeders)
            .map_err(|error| Failure::Usage(format!("{}: {error}", self.feeders)))?;
        Feeders::parse(&text, profile)
            .map_err(|wrong| console.refuse(&paste::note(&self.feeders, "X032", &wrong)))
    }

    fn read(&self, file: &str, console: &Console) -> Result<List, Failure> {
        let bytes = fs::read(file).map_err(|error| Failure::Usage(format!("{file}: {error}")))?;
        let unit = self.unit.map(|unit| match unit {
            FileUnit::Mm => Unit::Mm,
            FileUnit::In => Unit::Inch,
        });
        let say = |diag: &import::Diag| console.note(&note_of(diag, file));
        match placement::read(file, &bytes, unit) {
            Ok(list) => {
                list.notes.iter().try_for_each(say)?;
                if !list.left_out.is_empty() {
                    console.complain(&format!(
                        "{file}: columns left out: {}",
                        list.left_out.join(", ")
                    ));
                }
                Ok(list)
            }
            Err(diags) => {
                diags.iter().try_for_each(say)?;
                Err(Failure::Input)
            }
        }
    }

    /// Takes over what the bill says.
    fn join(&self, list: &mut Vec<(String, Part)>, console: &Console) -> Result<(), Failure> {
        let Some(file) = &self.bom else { return Ok(()) };
        let bytes = fs::read(file).map_err(|error| Failure::Usage(format!("{file}: {error}")))?;
        let bom = match placement::read_bom(&bytes) {
            Ok(bom) => bom,
            Err(diags) => {
                diags.iter().try_for_each(|diag| console.note(&note_of(diag, file)))?;
                return Err(Failure::Input);
            }
        };
        let entries: BTreeMap<&str, &placement::Entry> =
            bom.entries.iter().map(|entry| (entry.name.as_str(), entry)).collect();
        let mut wrong = false;
        for entry in &bom.entries {
            if !entry.out && !list.iter().any(|(_, part)| part.name == entry.name) {
                let words = format!("{} is in no placement file", entry.name);
                console.note(&Note::error(file, "X033", words).at((entry.line, 1)))?;
                wrong = true;
            }
        }
        for (placed, part) in list.iter_mut() {
            match entries.get(part.name.as_str()) {
                Some(entry) => {
                    for (held, new) in
                        [(&mut part.value, &entry.value), (&mut part.package, &entry.package)]
                    {
                        if !new.is_empty() {
                            held.clone_from(new);
                        }
                    }
                }
                None if part.is_fiducial() || self.skip.contains(&part.name) => {}
                None => {
                    let words = format!("{} is not in {file}", part.name);
                    let hint = format!("--skip {} leaves it out", part.name);
                    let note = Note::error(placed, "X033", words).at((part.line, 1));
                    console.note(&note.hint(hint))?;
                    wrong = true;
                }
            }
        }
        if wrong {
            return Err(Failure::Input);
        }
        list.retain(|(_, part)| !entries.get(part.name.as_str()).is_some_and(|entry| entry.out));
        Ok(())
    }

    /// Turns the bottom so that it is as it is seen from below: that side lies upward.
    fn seen(&self, list: &mut [(String, Part)], console: &Console) -> Result<(), Failure> {
        if self.side == Side::Top {
            return Ok(());
        }
        let bottom = || list.iter().filter(|(_, part)| part.side == PartSide::Bottom);
        let top = || list.iter().filter(|(_, part)| part.side == PartSide::Top);
        let negated = bottom().all(|(_, part)| part.at[0] <= 0)
            && top().all(|(_, part)| part.at[0] >= 0)
            && bottom().any(|(_, part)| part.at[0] < 0);
        let mirrored = match self.bottom {
            Some(way) => way == Bottom::Mirrored,
            None if top().next().is_none() => {
                return Err(Failure::Usage(
                    "the file has one side only, so nothing tells whether its X is mirrored: --bottom \
                     mirrored, or --bottom through"
                        .to_owned(),
                ));
            }
            None => {
                let how = if negated { "mirrored" } else { "through" };
                console.complain(&format!("the bottom's X is taken as {how}; --bottom says it"));
                negated
            }
        };
        for (_, part) in list.iter_mut() {
            // A mark of the top is seen from below at the mirrored place, too.
            if !(mirrored && part.side == PartSide::Bottom) {
                part.at[0] = -part.at[0];
            }
            if part.side == PartSide::Bottom {
                part.turned = part.turned.map(|turned| (180_000 - turned).rem_euclid(360_000));
            }
        }
        Ok(())
    }

    fn frame(&self, list: &[(String, Part)], console: &Console) -> Result<Onto, Failure> {
        let mut marks = Vec::new();
        for text in &self.at {
            let wrong =
                || Failure::Usage(format!("--at {text}: it is REF=X,Y, as FID1=103.02,52.9"));
            let (name, place) = text.split_once('=').ok_or_else(wrong)?;
            let (x, y) = place.split_once(',').ok_or_else(wrong)?;
            let number = |text: &str| {
                let value: f64 = text.trim().parse().map_err(|_| wrong())?;
                if value.abs() < 10_000.0 {
                    Ok((value * 1000.0).round() as i64)
                } else {
                    Err(wrong())
                }
            };
            let found = list.iter().find(|(_, part)| part.name == name);
            let (_, part) = found
                .ok_or_else(|| Failure::Usage(format!("--at {text}: no part is called {name}")))?;
            let taught = [number(x)?, number(y)?];
            marks.push(Mark { name: name.to_owned(), drawn: part.at, taught });
        }
        if marks.is_empty() {
            let marks: Vec<&str> = list
                .iter()
                .filter(|(_, part)| part.is_fiducial())
                .map(|(_, part)| part.name.as_str())
                .collect();
            let proposed =
                if marks.is_empty() { String::new() } else { format!(" {}", marks.join(", ")) };
            console.complain(&format!(
                "without --at the file's places are the machine's; marks to measure:{proposed}"
            ));
        }
        onto(&marks).map_err(Failure::Usage)
    }

    /// The table of what comes from where.
    fn tell(
        &self,
        parts: &[Placed],
        feeders: &Feeders,
        onto: &Onto,
        console: &Console,
    ) -> Result<(), Failure> {
        let angles =
            parts.iter().map(|part| apart(part.turned, feeders.feeders[part.feeder].turned));
        let most = angles.fold(0.0, f64::max);
        let off = &onto.off;
        let mut counts: BTreeMap<(String, usize, i64), usize> = BTreeMap::new();
        for part in parts {
            let angle = part.turned.round() as i64;
            *counts.entry((part.what.clone(), part.feeder, angle)).or_default() += 1;
        }
        let way: f64 = parts
            .iter()
            .map(|part| {
                let first = feeders.feeders[part.feeder].grid().0;
                2.0 * (part.at[0] as f64 / 1000.0 - first[0])
                    .hypot(part.at[1] as f64 / 1000.0 - first[1])
            })
            .sum();
        if console.json() {
            let rows: Vec<_> = counts
                .iter()
                .map(|((what, feeder, angle), count)| {
                    let feeder = &feeders.feeders[*feeder].name;
                    json!({ "part": what, "count": count, "feeder": feeder, "angle": angle })
                })
                .collect();
            let off: Vec<_> = off
                .iter()
                .map(|(name, um)| json!({ "mark": name, "off_um": um.round() }))
                .collect();
            return match &self.output {
                Some(_) => console.json_line(&json!({
                    "parts": parts.len(), "rows": rows, "marks": off, "way_mm": way.round(),
                    "angle_off_deg": (most * 10.0).round() / 10.0,
                })),
                None => Ok(()),
            };
        }
        let mut text = format!("{:<40} {:>5}  {:<20} {:>5}\n", "part", "count", "feeder", "angle");
        for ((what, feeder, angle), count) in &counts {
            let feeder = &feeders.feeders[*feeder].name;
            text += &format!("{what:<40} {count:>5}  {feeder:<20} {angle:>5}\n");
        }
        text += &format!("{} parts, way {:.1} m", parts.len(), way / 1000.0);
        for (name, um) in off {
            text += &format!("; {name} is {um:.0} um off");
        }
        if most >= TOLD_ANGLE {
            text += &format!(
                "; the board lies turned by {:.1} degrees, and parts up to {most:.1} degrees off their angle: the \
                 machine does not turn them",
                onto.angle
            );
        }
        console.complain(&text);
        Ok(())
    }
}

/// What the reader says of a file.
fn note_of(diag: &import::Diag, file: &str) -> Note {
    let note = Note::error(file, diag.code.id(), diag.text.clone()).at((diag.line, diag.col));
    let note = match diag.severity {
        import::Severity::Error => note,
        import::Severity::Warning => note.warning(),
        import::Severity::Note => note.note(),
    };
    match &diag.hint {
        Some(hint) => note.hint(hint),
        None => note,
    }
}

/// Degrees between two angles, 0 to 180.
fn apart(a: f64, b: f64) -> f64 {
    let apart = (a - b).rem_euclid(360.0);
    apart.min(360.0 - apart)
}

/// A part with its feeder and its place on the machine.
fn placed(
    part: &Part,
    feeders: &Feeders,
    onto: &Onto,
    profile: &Profile,
) -> Result<Placed, (String, String)> {
    let (name, value, package) = (&part.name, &part.value, &part.package);
    let fitting = feeders.fitting(value, package);
    if fitting.is_empty() {
        return Err((
            format!("{name} ({package}, {value}) has no feeder"),
            format!(
                "add [[feeder]] with value = \"{value}\", package = \"{package}\", or leave it out with \
                 --skip {name}"
            ),
        ));
    }
    let drawn = f64::from(part.turned.unwrap_or(0)) / 1000.0 + feeders.rotation(package);
    let turned = (drawn + onto.angle).rem_euclid(360.0);
    let gives = |angle: f64| {
        let same = |feeder: &usize| apart(angle, feeders.feeders[*feeder].turned) < SAME_ANGLE;
        fitting.iter().copied().find(same)
    };
    let Some(feeder) = gives(turned) else {
        let angles: Vec<String> =
            fitting.iter().map(|n| feeders.feeders[*n].turned.to_string()).collect();
        let wanted = (turned * 10.0).round() / 10.0;
        let hint = match gives(drawn.rem_euclid(360.0)) {
            // On a board that lies straight it would fit.
            Some(_) => format!(
                "the board lies turned by {:.1} degrees: lay it straight, within {SAME_ANGLE} degrees, or give a \
                 feeder with turned = {wanted}",
                onto.angle
            ),
            None => format!("a feeder with turned = {wanted}"),
        };
        return Err((
            format!(
                "{name} is to lie at {wanted} degrees, its feeder gives {}, and the machine cannot turn it",
                angles.join(", ")
            ),
            hint,
        ));
    };
    let at = onto.place(part.at);
    for (axis, um, letter) in [(&profile.x, at[0], 'X'), (&profile.y, at[1], 'Y')] {
        let good = axis
            .as_ref()
            .is_some_and(|axis| (i64::from(axis.min_um)..=i64::from(axis.max_um)).contains(&um));
        if !good {
            return Err((
                format!(
                    "{name} comes to {letter} {:.3} mm, outside the travel",
                    um as f64 / 1000.0
                ),
                "--at REF=X,Y says where the board lies on the machine".to_owned(),
            ));
        }
    }
    let what = format!("{value} {package}").trim().to_owned();
    Ok(Placed { name: name.clone(), what, at, turned, feeder })
}
