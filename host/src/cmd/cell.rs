//! `--cell`: the cell around a simulated machine, and its report.

use std::path::Path;

use clap::Args;
use lang::front::source::Source;
use lang::profile::Profile;

use super::console::{Console, Options};
use super::script::{self, Script};
use crate::failure::Failure;
use crate::input;
use crate::output;
use crate::render::{Note, Severity};
use crate::scene::{self, Report, Scene, junit};

/// Which cell.
#[derive(Clone, Debug, Args)]
pub struct CellChoice {
    /// The things around the machine; without it FILE's NAME.cell.toml, if that stands beside it
    #[arg(long, value_name = "C.cell.toml")]
    pub cell: Option<String>,
    /// Run without the cell that stands beside FILE
    #[arg(long, conflicts_with = "cell")]
    pub no_cell: bool,
}

impl CellChoice {
    /// The cell's file, if there is one.
    pub fn file(&self, script: &str) -> Option<String> {
        if self.no_cell { None } else { self.cell.clone().or_else(|| scene::beside(script)) }
    }

    /// Reads the cell of a script.
    ///
    /// # Errors
    /// It is wrong; that was written.
    pub fn find(
        &self,
        file: &str,
        script: &Script,
        console: &Console,
    ) -> Result<Option<Scene>, Failure> {
        let Some(cell) = self.file(file) else { return Ok(None) };
        let read = scene::read(&cell, &script.program.profile, Some(&script.program));
        shown(read, console).map(Some)
    }
}

/// Writes the notes of a cell that was read.
fn shown(read: Result<(Scene, Vec<Note>), Vec<Note>>, console: &Console) -> Result<Scene, Failure> {
    let (scene, notes) = match read {
        Ok((scene, notes)) => (Some(scene), notes),
        Err(notes) => (None, notes),
    };
    for note in &notes {
        // A note may be about a file that the cell includes.
        let source = input::read_text(&note.file).ok().map(|text| Source::new(&note.file, text));
        match &source {
            Some(source) => console.note_in(note, source)?,
            None => console.note(note)?,
        }
    }
    debug_assert!(scene.is_some() || notes.iter().any(|note| note.severity == Severity::Error));
    scene.ok_or(Failure::Input)
}

/// Checks a cell file: with the names of the script beside it, or with those of a profile alone.
///
/// # Errors
/// It is wrong; that was written.
pub fn check(file: &str, options: &Options, console: &Console) -> Result<(), Failure> {
    let beside = file.trim_end_matches(".cell.toml").to_owned() + ".bas";
    if Path::new(&beside).is_file() {
        let script = script::load(&beside, options, &console.quiet()).map_err(|_| {
            console.refuse(&Note::error(
                &beside,
                input::code::ENGINE,
                format!("the script of {file} is wrong: `pasapas check {beside}` says where"),
            ))
        })?;
        let read = scene::read(file, &script.program.profile, Some(&script.program));
        return shown(read, console).map(drop);
    }
    let profile = match options.profile(console)? {
        Some(profile) => profile,
        None => own_profile(file, console)?,
    };
    shown(scene::read(file, &profile, None), console).map(drop)
}

/// The profile that a cell names, else the usual one.
fn own_profile(file: &str, console: &Console) -> Result<Profile, Failure> {
    let text = input::read_text(file).map_err(|note| console.refuse(&note))?;
    let table: Option<toml::Table> = text.parse().ok();
    let name = table.and_then(|table| Some(table.get("profile")?.as_str()?.to_owned()));
    let name = name.unwrap_or_else(|| lang::profile::DEFAULT_NAME.to_owned());
    let found = input::profile_beside(&name, file);
    found
        .map(|(profile, _)| profile)
        .map_err(|error| console.refuse(&Note::error(file, input::code::PROFILE, error.0)))
}

/// Where a report goes beside the terminal.
#[derive(Clone, Debug, Args)]
pub struct CellOutput {
    /// Write what happened in the cell, one JSON line for each event; `-` is standard output
    #[arg(long, value_name = "L")]
    pub cell_log: Option<String>,
    /// Write the expectations: JSON lines, or JUnit XML
    #[arg(long, value_name = "R.json|R.xml", value_parser = report_file)]
    pub report: Option<String>,
}

/// A report's name says its form.
pub fn report_file(name: &str) -> Result<String, String> {
    if [".json", ".jsonl", ".xml"].iter().any(|end| name.ends_with(end)) {
        Ok(name.to_owned())
    } else {
        Err("a report's name ends in .json or .xml".to_owned())
    }
}

impl CellOutput {
    /// Writes what was asked for of a run in a cell, and its table.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(
        &self,
        file: &str,
        report: &Report,
        to_stderr: bool,
        console: &Console,
    ) -> Result<(), Failure> {
        if let Some(log) = &self.cell_log {
            let lines: String = report.log.iter().map(|event| event.json() + "\n").collect();
            if log == "-" { console.result(&lines)? } else { output::write(log, lines)? }
        }
        if let Some(path) = &self.report {
            let text = if path.ends_with(".xml") {
                junit::write(&[junit::Run { file, report, differences: &[] }])
            } else {
                report.json().iter().map(|line| line.clone() + "\n").collect()
            };
            output::write(path, text)?;
        }
        if console.json() {
            return report.json().iter().try_for_each(|line| console.result(&format!("{line}\n")));
        }
        let table = report.table();
        if to_stderr || self.cell_log.as_deref() == Some("-") {
            console.complain(table.trim_end());
            Ok(())
        } else {
            console.result(&table)
        }
    }
}
