//! `pasapas torture`: injects faults and counts the cases that survive.

use clap::Args;
use clap::builder::PossibleValuesParser;

use super::console::{Console, Options};
use super::part::named;
use crate::board::{BUILDS, Build};
use crate::failure::Failure;
use crate::torture::{KINDS, Length, NAMED, Row, Settings};

/// `pasapas torture`
#[derive(Debug, Args)]
pub struct Torture {
    /// Kinds of faults; without one all of them but `times`
    #[arg(value_name = "KIND", value_parser = PossibleValuesParser::new(KINDS.iter().map(|(name, _)| *name)))]
    kinds: Vec<String>,
    /// Few cases: all kinds within a minute
    #[arg(long, conflicts_with = "long")]
    short: bool,
    /// As many cases as the project promises: hours
    #[arg(long)]
    long: bool,
    /// As many cases of each fault
    #[arg(long, value_name = "N")]
    count: Option<u64>,
    /// What the cases are made of
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Number of the first case: with `--count 1` it repeats a single one
    #[arg(long, value_name = "N", default_value_t = 0)]
    from: u64,
    /// The chip of the boards that are tried; without it every one
    #[arg(long, value_name = "NAME", value_parser = named)]
    part: Option<&'static Build>,
}

impl Torture {
    /// Prints each line of the table as it is had.
    ///
    /// # Errors
    /// Something was lost, or a kind could not be tried.
    pub fn run(&self, _options: &Options, console: &Console) -> Result<(), Failure> {
        let length = match (self.short, self.long) {
            (true, _) => Length::Short,
            (_, true) => Length::Long,
            _ => Length::Usual,
        };
        let builds = self.part.map_or(&BUILDS[..], Build::alone);
        let settings =
            Settings { length, count: self.count, seed: self.seed, from: self.from, builds };
        let mut lost = 0;
        if !console.json() {
            console.result(&format!(
                "{:9} {:14} {:34} {:>10} {:>10} {:>6} {:>6} {:>8}\n",
                "kind", "part", "fault", "tried", "survived", "lost", "seed", "s"
            ))?;
        }
        for &(name, kind) in KINDS {
            let named = self.kinds.iter().any(|wanted| wanted == name);
            if !named && (!self.kinds.is_empty() || NAMED.contains(&name)) {
                continue;
            }
            let mut closed = None;
            let result = kind(&settings, &mut |row| {
                lost += row.lost;
                show(&row, console).map_err(|failure| {
                    let text = failure.message().unwrap_or_default().to_owned();
                    closed = Some(failure);
                    text
                })
            });
            if let Some(failure) = closed {
                return Err(failure);
            }
            result.map_err(|error| Failure::Board(format!("{name}: {error}")))?;
        }
        if lost > 0 { Err(Failure::Input) } else { Ok(()) }
    }
}

fn show(row: &Row, console: &Console) -> Result<(), Failure> {
    if console.json() {
        return console.json_line(row);
    }
    for loss in &row.losses {
        console.complain(&format!("{} {} {}: {loss}", row.kind, row.part, row.fault));
    }
    let Row { kind, part, fault, tried, survived, lost, seed, seconds, note, .. } = row;
    let line = format!(
        "{kind:9} {part:14} {fault:34} {tried:>10} {survived:>10} {lost:>6} {seed:>6} {seconds:>8.1}  {note}"
    );
    console.result(&format!("{}\n", line.trim_end()))
}
