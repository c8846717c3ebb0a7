//! `pasapas profile`: built-in profiles, profile files, and the profile of a board.

use clap::{Args, Subcommand};
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::profile::{BUILT_IN, Profile as Machine};
use lang::record::{BoardRecord, MachineRecord};
use lang::wire::{self, Exception};
use serde_json::json;

use super::console::{Console, Options};
use super::port::{Board, Port};
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
    /// Print the profile that a board holds, as TOML: its axes are those of the program on it, or of --profile
    Get {
        #[command(flatten)]
        port: Port,
    },
    /// Bring a profile to a board: link, wiring, polarity, roles, safe states; and its axes, in a program that does
    /// nothing, unless the board holds another one
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
    let mut board = port.connect(options, console)?;
    let given = options.profile(console)?;
    let record = board.board_record()?;
    let axes = board.axes()?;
    let held = match given {
        Some(base) => Some(base),
        None => axes.profile(),
    };
    // Without axes all the same what the board has: nobody goes on with another machine's by mistake.
    let known = held.is_some();
    let base = held.map_or_else(|| nobody().map_err(Failure::Usage), Ok)?;
    let held = record.into_profile(&base);
    if console.json() {
        return console.json_line(&held);
    }
    let mut text = to_toml(&held)?;
    if record.flags & BoardRecord::UNWIRED != 0 {
        text.insert_str(
            0,
            "# the board was never told how it is wired and drives no output until `profile set FILE` says so: what stands \
             here is what it assumes\n",
        );
    }
    if known {
        return console.result(&text);
    }
    console.result(&format!(
        "# {axes}: the axes are missing here, `profile set FILE` brings them\n{text}"
    ))
}

/// A machine without axes.
fn nobody() -> Result<Machine, String> {
    let mill = Machine::built_in(lang::profile::DEFAULT_NAME).map_err(|error| error.to_string())?;
    Ok(Machine {
        name: "unknown".to_owned(),
        x: None,
        y: None,
        z: None,
        home_order: Vec::new(),
        inputs: Vec::new(),
        outputs: Vec::new(),
        ..mill
    })
}

/// The axes of a profile on a board, in a program that does nothing, where none other is: `jog` and `home` move by them.
/// What there is to tell.
fn bring_axes(board: &mut Board, profile: &Machine) -> Result<Option<String>, Failure> {
    let axes = MachineRecord::of(profile).hash();
    let image = image_of(profile)?;
    let there = board.identity()?;
    if there.program_bytes != 0 {
        if board.holding(wire::PROGRAM_PROFILE, 1)?[0] == axes {
            return Ok(None);
        }
        // One that does nothing has this length, whatever the axes.
        if usize::from(there.program_bytes) != image.len() {
            return Ok(Some(format!(
                "the program on the board was made for other axes than those of `{}`, and jog and home go by its: \
                 upload it again, or name --profile",
                profile.name
            )));
        }
    }
    board
        .bring(&image, (None, AXES), true, &mut |_| ())
        .map_err(|error| Failure::Board(error.to_string()))?;
    Ok(None)
}

/// Name of the program that holds axes alone.
const AXES: &str = "axes";

/// That program.
fn image_of(profile: &Machine) -> Result<Vec<u8>, Failure> {
    let source = Source::new(AXES, "END\n".to_owned());
    let (program, _) = compile(&source, ProfileChoice::Given(Box::new(profile.clone())));
    let compiled = program.and_then(|program| lang::back::compile(&program).ok());
    compiled.map(|compiled| compiled.image).ok_or(Failure::Input)
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
    // Before a lock may close.
    let told = bring_axes(&mut board, &profile)?;
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
    if let Some(told) = &told {
        console.complain(told);
    }
    if console.json() {
        let axes = told.is_none();
        return console
            .json_line(&json!({ "profile": profile.name, "changed": changes, "axes": axes }));
    }
    console.result(&match changes.as_slice() {
        [] => format!("the board held its part of the profile `{}` already\n", profile.name),
        changes => format!("the board holds `{}` now: {}\n", profile.name, changes.join(", ")),
    })
}
