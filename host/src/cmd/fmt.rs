//! `pasapas fmt`: scripts in one style.

use clap::Args;
use lang::front::fmt::format;
use lang::front::source::{MAX_SOURCE_BYTES, Source};

use super::check::each;
use super::console::{Console, Options};
use crate::failure::Failure;
use crate::input;
use crate::output;

/// `pasapas fmt`
#[derive(Debug, Args)]
pub struct Fmt {
    /// Scripts; `-` formats standard input to standard output
    #[arg(required = true, value_name = "FILE")]
    files: Vec<String>,
    /// Change nothing; exit code 1 and the names of the files that would change
    #[arg(long)]
    check: bool,
}

impl Fmt {
    /// Formats the files in place.
    ///
    /// # Errors
    /// A file does not parse or cannot be written; with `--check`, one would change.
    pub fn run(&self, _options: &Options, console: &Console) -> Result<(), Failure> {
        each(&self.files, |file| self.one(file, console))
    }

    fn one(&self, file: &str, console: &Console) -> Result<(), Failure> {
        let bytes =
            input::read_bytes(file, MAX_SOURCE_BYTES).map_err(|note| console.refuse(&note))?;
        let (source, diags) = Source::decode(file, &bytes);
        let formatted = match diags.iter().find(|diag| diag.is_error()) {
            None => format(source.text()),
            Some(_) => Err(diags),
        };
        let formatted = match formatted {
            Ok(text) => text,
            Err(diags) => {
                for diag in &diags {
                    console.diag(diag, &source)?;
                }
                return Err(Failure::Input);
            }
        };
        if self.check {
            return if formatted.as_bytes() == bytes {
                Ok(())
            } else {
                console.result(&format!("{file}\n"))?;
                Err(Failure::Input)
            };
        }
        if file == "-" {
            return console.result(&formatted);
        }
        if formatted.as_bytes() == bytes {
            return Ok(());
        }
        output::write(file, formatted)
    }
}
