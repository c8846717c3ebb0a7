//! `pasapas bench`: measures what the project promises.

use std::path::PathBuf;

use clap::Args;
use clap::builder::PossibleValuesParser;

use super::console::{Console, Options};
use crate::bench::{Figure, GROUPS, SHORT, Want, paths};
use crate::failure::Failure;

/// `pasapas bench`
#[derive(Debug, Args)]
pub struct Bench {
    /// Measure one group only
    #[arg(value_parser = PossibleValuesParser::new(GROUPS.iter().map(|(name, _)| *name)))]
    group: Option<String>,
    /// Of groups that take long, `paths`, the few jobs that stand for all
    #[arg(long)]
    short: bool,
    /// Instead of measuring `paths`, draw two of its jobs into a folder that is there: speed over time, resting at every
    /// corner, as the F5529 runs it, and as a planner would that knows the whole path
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,
}

impl Bench {
    /// Prints each figure as it is had. A figure that is not met is shown, not an error.
    ///
    /// # Errors
    /// A figure cannot be measured.
    pub fn run(&self, _options: &Options, console: &Console) -> Result<(), Failure> {
        if let Some(folder) = &self.pictures {
            return paths::pictures::draw(folder).map_err(Failure::Board);
        }
        let mut failed = Vec::new();
        for &(name, measure) in GROUPS {
            if self.group.as_ref().is_some_and(|group| group != name) {
                continue;
            }
            let short = SHORT.iter().find(|(own, _)| self.short && *own == name);
            let measure = short.map_or(measure, |(_, measure)| *measure);
            let mut closed = None;
            let result = measure(&mut |figure| {
                show(&figure, console).map_err(|failure| {
                    let text = failure.message().unwrap_or_default().to_owned();
                    closed = Some(failure);
                    text
                })
            });
            if let Some(failure) = closed {
                return Err(failure);
            }
            if let Err(error) = result {
                failed.push(format!("{name}: {error}"));
            }
        }
        if failed.is_empty() {
            return Ok(());
        }
        Err(Failure::Board(format!("not everything could be measured: {}", failed.join("; "))))
    }
}

fn show(figure: &Figure, console: &Console) -> Result<(), Failure> {
    if console.json() {
        return console.json_line(figure);
    }
    let Figure { figure: name, value, unit, want, must, aim, note } = figure;
    let sign = match want {
        Want::AtLeast => ">=",
        Want::AtMost => "<=",
    };
    let verdict = if figure.is_met() { "ok" } else { "MISSED" };
    let note = if note.is_empty() { String::new() } else { format!("; {note}") };
    console.result(&format!(
        "{name:20} {value:12} {unit:13} must {sign} {must}, aim {aim}: {verdict}{note}\n"
    ))
}
