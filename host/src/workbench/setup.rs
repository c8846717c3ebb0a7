//! The set-up of a new machine: a profile that grows step by step, each tried on the machine.
//!
//! What was found stands in NAME.setup.json beside the script, so that the set-up can be left and
//! taken up again; its end is NAME.toml and a report. Every change goes through the profile's checker.

mod pins;
mod report;
mod steps;
#[cfg(test)]
mod tests;
mod trial;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use lang::profile::{BUILT_IN, Profile};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

pub use trial::{TrialWish, run as try_rate, stub};

use super::file::write;
use crate::input;

/// Longest profile or state that is read, bytes.
const LONGEST: usize = 256 << 10;
/// Longest words that a step keeps.
const LONGEST_WORDS: usize = 500;
/// Set-ups and profiles of a folder that are listed.
const MOST_FILES: usize = 100;

/// A step that was done.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Done {
    /// What was found.
    pub words: String,
    /// When, seconds of the Unix clock.
    pub at: u64,
    /// The part of the profile that it was tried with: where that changed, it is to be tried again.
    basis: Value,
}

/// What the file keeps.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    profile: Profile,
    done: BTreeMap<String, Done>,
    /// Text of the profile's file when it was last read or written here.
    file: Option<String>,
}

/// A set-up that goes on.
#[derive(Debug)]
pub struct Setup {
    name: String,
    folder: PathBuf,
    saved: Saved,
    /// The profile that the board has, as this set-up brought it.
    applied: Option<Profile>,
}

/// Set-ups and machines that one can begin with.
pub fn choices(folder: &Path) -> Value {
    let names = |end: &str| {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        let names = entries.filter_map(|entry| {
            let name = entry.file_name().to_string_lossy().into_owned();
            name.strip_suffix(end).filter(|name| is_name(name)).map(str::to_owned)
        });
        let mut names: Vec<String> = names.take(MOST_FILES).collect();
        names.sort();
        names
    };
    let built_in: Vec<&str> = BUILT_IN.iter().map(|(name, _)| *name).collect();
    json!({ "begun": names(".setup.json"), "profiles": names(".toml"), "built_in": built_in })
}

/// A name that is one of a script's PROFILE line and of a file.
fn is_name(name: &str) -> bool {
    (1..=40).contains(&name.len())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-')
}

impl Setup {
    /// Takes up the set-up of this name, or begins one from a machine: a file of the folder or a
    /// built-in one.
    ///
    /// # Errors
    /// A name or a file is wrong; in words.
    pub fn open(folder: &Path, name: &str, base: Option<&str>) -> Result<Setup, String> {
        if !is_name(name) || BUILT_IN.iter().any(|(known, _)| known.eq_ignore_ascii_case(name)) {
            return Err(format!(
                "`{name}` is no name for a machine: letters, digits, `_` and `-`, and none that is \
                 built in"
            ));
        }
        let state = folder.join(format!("{name}.setup.json"));
        let own = folder.join(format!("{name}.toml"));
        let on_disk = own.is_file().then(|| read(&own)).transpose()?;
        let saved = if state.is_file() {
            let text = read(&state)?;
            let saved: Saved = serde_json::from_str(&text)
                .map_err(|error| format!("{}: {error}; take another name", state.display()))?;
            checked(saved.profile.clone())
                .map_err(|error| format!("{}: {error}", state.display()))?;
            saved
        } else {
            let profile = match (&on_disk, base) {
                (Some(text), _) => {
                    Profile::parse(text).map_err(|error| format!("{}: {error}", own.display()))?
                }
                (None, Some(base)) if is_name(base) && !is_built_in(base) => {
                    let file = folder.join(format!("{base}.toml"));
                    Profile::parse(&read(&file)?)
                        .map_err(|error| format!("{}: {error}", file.display()))?
                }
                (None, base) => {
                    let base = base.unwrap_or(lang::profile::DEFAULT_NAME);
                    Profile::built_in(base).map_err(|error| error.to_string())?
                }
            };
            let profile = Profile { name: name.to_owned(), ..profile };
            Saved { profile, done: BTreeMap::new(), file: on_disk }
        };
        let setup =
            Setup { name: name.to_owned(), folder: folder.to_owned(), saved, applied: None };
        setup.save()?;
        Ok(setup)
    }

    /// The machine as it is known so far.
    pub const fn profile(&self) -> &Profile {
        &self.saved.profile
    }

    /// The machine for moves by hand: where the travel is not known yet, the switch alone ends it, and
    /// a look at the switch goes beyond.
    pub fn machine(&self) -> Profile {
        steps::opened(&self.saved.profile, |axis| self.holds(&format!("travel_{axis}")))
    }

    /// What a page shows.
    pub fn shown(&self) -> Value {
        let profile = &self.saved.profile;
        let list = steps::list(profile).into_iter().map(|id| {
            let done = self.saved.done.get(&id);
            json!({
                "id": id, "done": self.holds(&id), "stale": done.is_some() && !self.holds(&id),
                "words": done.map(|done| done.words.as_str()), "at": done.map(|done| done.at),
            })
        });
        json!({
            "name": self.name,
            "profile": profile,
            "steps": list.collect::<Vec<_>>(),
            "applied": self.applied.as_ref() == Some(profile),
            "board": self.applied.as_ref().map(|profile| &profile.inputs),
            "references": steps::references(profile),
            "inputs": profile.wiring.inputs(),
            "outputs": profile.wiring.outputs(),
            "pins": pins::tables(profile.wiring),
            "roles": steps::roles(),
        })
    }

    /// Whether a step was done with the machine as it is now.
    fn holds(&self, id: &str) -> bool {
        let done = self.saved.done.get(id);
        done.is_some_and(|done| done.basis == steps::basis(&self.saved.profile, id))
    }

    /// Changes the profile by a JSON merge patch (RFC 7396).
    ///
    /// # Errors
    /// What comes of it is no profile; nothing is changed.
    pub fn change(&mut self, patch: &Value) -> Result<(), String> {
        let mut value =
            serde_json::to_value(&self.saved.profile).map_err(|error| error.to_string())?;
        steps::merge(&mut value, patch);
        let draft: Profile = serde_json::from_value(value).map_err(|error| error.to_string())?;
        if draft.name != self.name {
            return Err(
                "the machine keeps its name; begin another set-up for another one".to_owned()
            );
        }
        self.saved.profile = checked(draft)?;
        self.save()
    }

    /// A step is done; what was found.
    ///
    /// # Errors
    /// There is no such step, or the state cannot be written.
    pub fn done(&mut self, id: &str, words: &str) -> Result<(), String> {
        if !steps::list(&self.saved.profile).iter().any(|own| own == id) {
            return Err(format!("this set-up has no step `{id}`"));
        }
        let words = words.chars().filter(|c| !c.is_control()).take(LONGEST_WORDS).collect();
        let at = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_secs());
        let basis = steps::basis(&self.saved.profile, id);
        self.saved.done.insert(id.to_owned(), Done { words, at, basis });
        self.save()
    }

    /// The board was brought this machine.
    pub fn applied(&mut self, profile: Profile) {
        self.applied = Some(profile);
    }

    /// Steps per millimetre from what was asked for and what was measured, both in um.
    ///
    /// # Errors
    /// The lengths are wrong, or no scale of the profile's range comes of them.
    pub fn scale(&mut self, axis: char, asked: i64, measured: i64) -> Result<String, String> {
        let (profile, words) = steps::scaled(&self.saved.profile, axis, asked, measured)?;
        self.saved.profile = checked(profile)?;
        self.done(&format!("scale_{}", axis.to_ascii_lowercase()), &words)?;
        Ok(words)
    }

    /// Writes the profile and the report; the names of both files. `untried_stop`: also with an
    /// emergency stop that was not tried.
    ///
    /// # Errors
    /// The emergency stop was not tried, the board does not have this machine, or another program changed the profile's file meanwhile.
    pub fn finish(&mut self, when: &str, untried_stop: bool) -> Result<Value, String> {
        if self.applied.as_ref() != Some(&self.saved.profile) {
            return Err(
                "the board does not have this machine yet: bring it to the board first".to_owned()
            );
        }
        let file = self.folder.join(format!("{}.toml", self.name));
        let on_disk = file.is_file().then(|| read(&file)).transpose()?;
        if on_disk != self.saved.file {
            return Err(format!(
                "{} was changed by another program meanwhile: put it aside, or begin a set-up of \
                 another name from it",
                file.display()
            ));
        }
        let steps = steps::list(&self.saved.profile);
        let open: Vec<String> =
            steps.iter().filter(|id| !self.holds(id)).map(|id| report::title(id)).collect();
        if !self.holds("stop") && !untried_stop {
            return Err("the emergency stop was not tried: try it, or say that you go without it"
                .to_owned());
        }
        let body = toml::to_string(&self.saved.profile).map_err(|error| error.to_string())?;
        let tried = steps.len() - open.len();
        let mut text = format!(
            "# Written by the set-up of the workbench: {tried} of {} steps were tried on the machine.\n",
            steps.len()
        );
        if !open.is_empty() {
            text.push_str(&format!("# Not tried: {}.\n", open.join(", ")));
        }
        if !self.holds("stop") {
            text.push_str("# THE EMERGENCY STOP WAS NOT TRIED.\n");
        }
        text.push_str(&body);
        Profile::parse(&text).map_err(|error| error.to_string())?;
        put(&file, &text)?;
        self.saved.file = Some(text.clone());
        self.save()?;
        let report = self.folder.join(format!("{}.report.html", self.name));
        let rows: Vec<_> = steps
            .iter()
            .map(|id| (id.as_str(), self.saved.done.get(id).filter(|_| self.holds(id))))
            .collect();
        put(&report, &report::page(&self.saved.profile, &rows, &text, when))?;
        let name = |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned());
        Ok(json!({ "profile": name(&file), "report": name(&report) }))
    }

    fn save(&self) -> Result<(), String> {
        let text = serde_json::to_string_pretty(&self.saved).map_err(|error| error.to_string())?;
        put(&self.folder.join(format!("{}.setup.json", self.name)), &text)
    }
}

fn is_built_in(name: &str) -> bool {
    BUILT_IN.iter().any(|(known, _)| known.eq_ignore_ascii_case(name))
}

/// The profile as its file would have it, through the checker.
fn checked(profile: Profile) -> Result<Profile, String> {
    let text = toml::to_string(&profile).map_err(|error| error.to_string())?;
    Profile::parse(&text).map_err(|error| error.to_string())
}

fn read(file: &Path) -> Result<String, String> {
    let name = file.display().to_string();
    let bytes = input::read_bytes(&name, LONGEST).map_err(|note| note.line())?;
    String::from_utf8(bytes).map_err(|_| format!("{name} is not UTF-8 text"))
}

fn put(file: &Path, text: &str) -> Result<(), String> {
    write(file, text).map_err(|error| format!("{}: {error}", file.display()))
}
