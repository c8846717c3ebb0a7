//! `pasapas profile`: the machine descriptions that the host knows and that a board holds.

use clap::{Args, Subcommand};
use lang::profile::{BUILT_IN, Profile as Machine};
use lang::record::{BoardRecord, MachineRecord};
use lang::wire::Exception;
use serde_json::json;

use super::port::Port;
use super::{Console, Options};
use crate::client::identity::differences;
use crate::client::lock::words_of;
use crate::failure::Failure;
use crate::input;

/// `pasapas profile ...`
#[derive(Debug, Args)]
pub struct Profile {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// List the built-in profiles
    List,
    /// Print a profile, a built-in one or a file, as TOML
    Show {
        /// A name or a file
        name: String,
    },
    /// Print the profile that a board holds, as TOML; its axes are those of --profile
    Get {
        #[command(flatten)]
        port: Port,
    },
    /// Bring the board's part of a profile to a board: link, wiring, polarity, roles, safe states
    Set {
        /// A file or the name of a built-in profile
        name: String,
        #[command(flatten)]
        port: Port,
        /// Lock program and profile from now on: only --unlock CODE replaces them or reads the
        /// profile
        #[arg(long, value_name = "CODE")]
        lock: Option<String>,
        /// Give up the lock that --unlock has opened; without this it holds on
        #[arg(long, conflicts_with = "lock")]
        no_lock: bool,
    },
}

impl Profile {
    /// Runs it.
    ///
    /// # Errors
    /// A profile does not exist or is wrong.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        match &self.action {
            Action::List => list(console),
            Action::Show { name } => show(name, console),
            Action::Get { port } => get(port, options, console),
            Action::Set { name, port, lock, no_lock } => {
                let lock = match lock {
                    Some(code) => Some(words_of(code)),
                    None if *no_lock => Some([0; 2]),
                    None => None,
                };
                set(name, port, lock, options, console)
            }
        }
    }
}

fn list(console: &Console) -> Result<(), Failure> {
    for (name, text) in BUILT_IN {
        let about = text.lines().next().unwrap_or_default().trim_start_matches(['#', ' ']);
        if console.json() {
            console.json_line(&serde_json::json!({ "name": name, "about": about }))?;
        } else {
            console.result(&format!("{name:8} {about}\n"))?;
        }
    }
    Ok(())
}

fn show(name: &str, console: &Console) -> Result<(), Failure> {
    let profile = input::profile(name).map_err(|note| console.refuse(&note))?;
    if console.json() {
        return console.json_line(&profile);
    }
    // A built-in one with its comments: they say what to adapt.
    let text = match BUILT_IN.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)) {
        Some((_, text)) => (*text).to_owned(),
        None => to_toml(&profile)?,
    };
    console.result(&text)
}

fn to_toml(profile: &Machine) -> Result<String, Failure> {
    toml::to_string(profile)
        .map_err(|error| Failure::Output(format!("the profile cannot be written: {error}")))
}

fn get(port: &Port, options: &Options, console: &Console) -> Result<(), Failure> {
    let base = options.machine(console)?;
    let mut board = port.connect(options, console)?;
    let held = board.board_record()?.into_profile(&base);
    if console.json() {
        return console.json_line(&held);
    }
    console.result(&to_toml(&held)?)
}

/// Writes the board's part of a profile; `lock` is the code that holds from then on, if another one
/// than before.
fn set(
    name: &str,
    port: &Port,
    lock: Option<[u16; 2]>,
    options: &Options,
    console: &Console,
) -> Result<(), Failure> {
    let profile = input::profile(name).map_err(|note| console.refuse(&note))?;
    let mut board = port.connect(options, console)?;
    let held = board.board_record()?;
    let part = board.identity()?.part();
    let machine = MachineRecord::of(&profile).to_bytes();
    if let Some(lack) = part.signal_lacks((&profile).into(), &machine).next() {
        return Err(Failure::Board(format!(
            "`{}` for the {} lacks what this profile wants: {lack}",
            part.name, part.chip.name
        )));
    }
    let wanted = BoardRecord {
        lock: lock.unwrap_or(held.lock),
        ..BoardRecord::of(&profile, held.sequence.wrapping_add(1))
    }
    .sealed();
    let mut changes = differences(&held, &wanted);
    if wanted.lock != held.lock {
        changes.push("lock");
    }
    if !changes.is_empty() {
        let written = board.set_board_record(&wanted).and_then(|()| board.restart());
        written.map_err(|error| match error {
            error if error.is_exception(Exception::Busy) => Failure::Board(
                "the board refuses while a program runs or an axis moves; `pasapas stop` first"
                    .to_owned(),
            ),
            error => error.into(),
        })?;
        board.set_address(wanted.address);
        board.find()?;
        if board.is_locked()? != (wanted.lock[0] != 0) {
            return Err(Failure::Board("the board came back with another lock".to_owned()));
        }
        // What a locked board holds, no one reads.
        if wanted.lock[0] == 0 {
            let left = differences(&board.board_record()?, &wanted);
            if !left.is_empty() {
                let text = format!("the board came back with another {}", left.join(", "));
                return Err(Failure::Board(text));
            }
        }
    }
    if console.json() {
        return console.json_line(&json!({ "profile": profile.name, "changed": changes }));
    }
    console.result(&match changes.as_slice() {
        [] => format!("the board held the profile `{}` already\n", profile.name),
        changes => format!("the board holds `{}` now: {}\n", profile.name, changes.join(", ")),
    })
}
