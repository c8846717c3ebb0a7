//! `pasapas list` and `erase`: the programs that a board holds.

use clap::Args;
use serde_json::json;

use super::console::{Console, Options};
use super::port::{Board, Port};
use crate::client::ClientError;
use crate::client::library::{Called, Library};
use crate::client::upload::UploadError;
use crate::failure::Failure;
use lang::wire::{self, Exception};

/// `pasapas list`
#[derive(Debug, Args)]
pub struct List {
    #[command(flatten)]
    port: Port,
}

/// `pasapas erase`
#[derive(Debug, Args)]
pub struct Erase {
    /// The program: its name or number; not needed where the board holds one
    #[arg(value_name = "NAME|N")]
    program: Option<Called>,
    #[command(flatten)]
    port: Port,
    /// Erase every program
    #[arg(long, conflicts_with = "program")]
    all: bool,
}

impl List {
    /// Shows the programs.
    ///
    /// # Errors
    /// The board does not answer.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let mut board = self.port.connect(options, console)?;
        let identity = board.identity()?;
        let Some(library) = board.library()? else {
            if console.json() {
                let bytes = identity.program_bytes;
                return console
                    .json_line(&json!({ "number": 1, "bytes": bytes, "selected": bytes > 0 }));
            }
            return console.result(&match identity.program_bytes {
                0 => "the board holds no program; `pasapas upload` brings one\n".to_owned(),
                bytes => format!("the board holds one program of {bytes} bytes\n"),
            });
        };
        for entry in &library.entries {
            let selected = entry.number == library.selected;
            if console.json() {
                let mut line = json!(entry);
                line["selected"] = json!(selected);
                console.json_line(&line)?;
            } else {
                let mark = if selected { "Start runs it" } else { "" };
                let line = format!(
                    "{:>2}  {:<16} {:>6} bytes  {mark}",
                    entry.number, entry.name, entry.bytes
                );
                console.result(&format!("{}\n", line.trim_end()))?;
            }
        }
        if console.json() {
            return Ok(());
        }
        let free = identity.free_bytes;
        console.result(&match library.entries.is_empty() {
            true => format!("no program; one of {free} bytes fits\n"),
            false => format!("    one of {free} bytes fits beside them\n"),
        })
    }
}

impl Erase {
    /// Erases one, or all.
    ///
    /// # Errors
    /// There is no such program, something runs, or the board does not answer.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let mut board = self.port.connect(options, console)?;
        let Some(library) = board.library()? else {
            if let Some(called @ Called::Name(_)) = &self.program {
                return Err(Failure::Board(format!(
                    "the board holds one program without a name, no {called}; --all erases it"
                )));
            }
            board.erase().map_err(failed)?;
            return console.result("the program is erased\n");
        };
        let erased = match &self.program {
            None if self.all || library.entries.len() < 2 => library.entries.clone(),
            None => {
                return Err(Failure::Board(format!(
                    "which one? {}; --all erases them all",
                    library.names()
                )));
            }
            Some(called) => vec![known(&library, called)?.clone()],
        };
        for entry in erased {
            board.write(wire::UPLOAD_NUMBER, u16::from(entry.number))?;
            board.erase().map_err(failed)?;
            if !console.json() {
                console.result(&format!("{} {} is erased\n", entry.number, entry.name))?;
            }
        }
        Ok(())
    }
}

fn failed(error: UploadError) -> Failure {
    match error {
        UploadError::Client(error) => error.into(),
        error => Failure::Board(error.to_string()),
    }
}

/// The program that is called so.
fn known<'a>(
    library: &'a Library,
    called: &Called,
) -> Result<&'a crate::client::library::Entry, Failure> {
    library.find(called).ok_or_else(|| {
        Failure::Board(format!("the board has no program {called}: {}", library.names()))
    })
}

/// Makes the program that is called so the one that Start runs.
///
/// # Errors
/// There is none, another one runs, or the board does not answer.
pub fn select(board: &mut Board, called: &Called) -> Result<(), Failure> {
    let Some(library) = board.library()? else {
        return Err(Failure::Board(
            "the board holds one program: `pasapas start` without a name runs it".to_owned(),
        ));
    };
    let number = known(&library, called)?.number;
    if number == library.selected {
        return Ok(());
    }
    match board.select(number) {
        Err(error) if error.is_exception(Exception::Busy) => Err(Failure::Board(
            "a program runs or an axis moves: `pasapas stop` first, then choose another".to_owned(),
        )),
        Err(error @ ClientError::Exception(_)) => Err(error.into()),
        other => Ok(other?),
    }
}
