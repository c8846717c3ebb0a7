//! Options that all commands take, and the output that they write to.
//!
//! It is apart from [`cmd`](super), which imports every command, so that the commands do not import that.

use std::io::{IsTerminal, Write};

use clap::{Args, ValueEnum};
use lang::front::diag::Diag;
use lang::front::source::Source;
use lang::profile::Profile;
use serde::Serialize;

use crate::failure::Failure;
use crate::input;
use crate::render::{self, Note};

/// Options that every command takes.
#[derive(Debug, Args)]
pub struct Options {
    /// How to write diagnostics, status and summaries
    #[arg(long, global = true, value_enum, default_value_t = Format::Text)]
    pub format: Format,
    /// The machine: a file, or one of the built-in mill, charly, thesis, laser, picker. Without it the
    /// script's PROFILE line decides, else mill
    #[arg(long, global = true, value_name = "P.toml|NAME")]
    pub profile: Option<String>,
}

/// Form of what is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For people
    Text,
    /// One JSON object a line
    Json,
}

/// Where results, diagnostics and remarks go.
#[derive(Clone, Copy, Debug)]
pub struct Console {
    format: Format,
    /// Diagnostics are not shown.
    quiet: bool,
}

impl Console {
    /// One that writes in this form.
    pub fn new(format: Format) -> Console {
        Console { format, quiet: false }
    }

    /// The same for what is looked at beside: its diagnostics are not shown.
    pub fn quiet(self) -> Console {
        Console { quiet: true, ..self }
    }

    /// Whether results are JSON lines.
    pub fn json(&self) -> bool {
        self.format == Format::Json
    }

    /// Whether a progress bar would be seen.
    pub fn shows_progress(&self) -> bool {
        !self.json() && std::io::stderr().is_terminal()
    }

    /// Writes a result to standard output, as it is.
    ///
    /// # Errors
    /// Standard output is full or gone.
    pub fn result(&self, text: &str) -> Result<(), Failure> {
        self.bytes(text.as_bytes())
    }

    /// Writes bytes to standard output.
    ///
    /// # Errors
    /// Standard output is full or gone.
    pub fn bytes(&self, bytes: &[u8]) -> Result<(), Failure> {
        let mut out = std::io::stdout().lock();
        out.write_all(bytes)
            .and_then(|()| out.flush())
            .map_err(|error| Failure::writing("standard output", &error))
    }

    /// Writes one JSON line to standard output.
    ///
    /// # Errors
    /// Standard output is full or gone.
    pub fn json_line(&self, value: &impl Serialize) -> Result<(), Failure> {
        let mut line = serde_json::to_string(value)
            .map_err(|error| Failure::Output(format!("no JSON can be made of it: {error}")))?;
        line.push('\n');
        self.result(&line)
    }

    /// Writes a line to standard error. There is nobody to tell when that fails.
    pub fn complain(&self, text: &str) {
        let _ = writeln!(std::io::stderr().lock(), "{text}");
    }

    /// Writes a diagnostic: a JSON line on standard output or text on standard error.
    ///
    /// # Errors
    /// Standard output is full or gone.
    pub fn note(&self, note: &Note) -> Result<(), Failure> {
        if self.quiet {
            return Ok(());
        }
        if self.json() {
            return self.result(&format!("{}\n", note.json()));
        }
        let _ = std::io::stderr().lock().write_all(note.plain().as_bytes());
        Ok(())
    }

    /// Writes a diagnostic of a script, with its source line.
    ///
    /// # Errors
    /// Standard output is full or gone.
    pub fn note_in(&self, note: &Note, source: &Source) -> Result<(), Failure> {
        if self.quiet || self.json() {
            return self.note(note);
        }
        let shown = match render::stderr_is_rich() {
            true => render::excerpt(note, source),
            false => note.quoted(source),
        };
        let _ = std::io::stderr().lock().write_all(shown.as_bytes());
        Ok(())
    }

    /// Writes a diagnostic of the language.
    ///
    /// # Errors
    /// Standard output is full or gone.
    pub fn diag(&self, diag: &Diag, source: &Source) -> Result<(), Failure> {
        self.note_in(&Note::of(diag, source), source)
    }

    /// Writes a note that ends the command.
    pub fn refuse(&self, note: &Note) -> Failure {
        match self.note(note) {
            Ok(()) => Failure::Input,
            Err(failure) => failure,
        }
    }
}

impl Options {
    /// The profile that `--profile` names, if it is there.
    ///
    /// # Errors
    /// It does not exist or is wrong; that was written.
    pub fn profile(&self, console: &Console) -> Result<Option<Profile>, Failure> {
        match &self.profile {
            None => Ok(None),
            Some(name) => input::profile(name).map(Some).map_err(|note| match note.file.as_str() {
                "--profile" => Failure::Usage(note.text),
                _ => console.refuse(&note),
            }),
        }
    }
}
