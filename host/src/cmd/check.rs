//! `pasapas check`: diagnostics only.

use clap::Args;

use super::console::{Console, Options};
use super::others::Others;
use super::part::Choice;
use super::script;
use crate::failure::Failure;

/// `pasapas check`
#[derive(Debug, Args)]
pub struct Check {
    /// Scripts and cells (NAME.cell.toml); `-` is standard input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<String>,
    #[command(flatten)]
    part: Choice,
}

impl Check {
    /// Checks every file, also after one that is wrong.
    ///
    /// # Errors
    /// A script has errors or cannot be read.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        each(&self.files, |file| {
            if crate::scene::is_cell(file) {
                return super::cell::check(file, options, console);
            }
            let mut script = script::load(file, options, console)?;
            let compiled = script::compile_any(&script, console)?;
            Others::find(file, &script, options, console)?;
            self.part.fit(&mut script, compiled, console).map(drop)
        })
    }
}

/// Does `action` for every file; input that is wrong does not keep it from the next.
///
/// # Errors
/// One of the files was wrong, or something else failed.
pub fn each(
    files: &[String],
    mut action: impl FnMut(&str) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let mut wrong = false;
    for file in files {
        match action(file) {
            Ok(()) => {}
            Err(Failure::Input) => wrong = true,
            Err(failure) => return Err(failure),
        }
    }
    if wrong { Err(Failure::Input) } else { Ok(()) }
}
