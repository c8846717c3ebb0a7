//! `pasapas profile`: the machine descriptions that the host knows and that a board holds.

use clap::{Args, Subcommand};
use lang::profile::{BUILT_IN, Profile as Machine};
use lang::record::BoardRecord;
use lang::wire::Exception;
use serde_json::json;

use super::port::Port;
use super::{Console, Options};
use crate::client::identity::differences;
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
            Action::Set { name, port } => set(name, port, options, console),
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

fn set(name: &str, port: &Port, options: &Options, console: &Console) -> Result<(), Failure> {
    let profile = input::profile(name).map_err(|note| console.refuse(&note))?;
    let mut board = port.connect(options, console)?;
    let held = board.board_record()?;
    let wanted = BoardRecord::of(&profile, held.sequence.wrapping_add(1));
    let changes = differences(&held, &wanted);
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
        let now = board.board_record()?;
        let left = differences(&now, &wanted);
        if !left.is_empty() {
            let text = format!("the board came back with another {}", left.join(", "));
            return Err(Failure::Board(text));
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
