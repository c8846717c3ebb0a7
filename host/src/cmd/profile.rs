//! `pasapas profile`: the machine descriptions that the host knows and that a board holds.

use clap::{Args, Subcommand};
use lang::profile::{BUILT_IN, Profile as Machine};

use super::{Console, Options};
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
}

impl Profile {
    /// Runs it.
    ///
    /// # Errors
    /// A profile does not exist or is wrong.
    pub fn run(&self, _options: &Options, console: &Console) -> Result<(), Failure> {
        match &self.action {
            Action::List => list(console),
            Action::Show { name } => show(name, console),
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
