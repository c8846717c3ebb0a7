//! The world of the simulations: what a start was given, or the script's own beside it, and the pulses that a person
//! has drawn on the timeline.

use std::path::{Path, PathBuf};

use super::bench::{Bench, lock};
use crate::input;
use crate::output;
use crate::sim::world::World;
use crate::trial::pulses::{self, Pulse};

/// Pulses that are in no file yet.
#[derive(Debug, Default)]
pub struct Drawn {
    /// Name of their script; none of one without a name.
    script: Option<String>,
    /// Drawn since the world was last read; none: those of the file hold.
    pulses: Option<Vec<Pulse>>,
}

/// What is around the machine in a simulation.
pub(super) struct Around {
    pub world: World,
    /// What to say of it.
    pub words: Option<String>,
    pub pulses: Vec<Pulse>,
    /// Name of the world's file, and its text with the pulses; none: nothing is around the machine.
    pub file: Option<(String, String)>,
}

/// NAME.rhai beside NAME.bas.
fn beside(script: Option<&str>, folder: &Path) -> Option<PathBuf> {
    script.map(|name| folder.join(Path::new(name).with_extension("rhai")))
}

fn read(file: &Path) -> Result<String, String> {
    input::read_text(&file.display().to_string()).map_err(|note| note.line())
}

impl Bench {
    /// The world of simulations: the one that was given, or NAME.rhai beside the script NAME.bas, each with the pulses
    /// that were drawn.
    ///
    /// # Errors
    /// The one beside it cannot be read, or is wrong; in words.
    pub(super) fn around(&self, script: Option<&str>, folder: &Path) -> Result<Around, String> {
        let drawn = {
            let mut drawn = lock(&self.drawn);
            if drawn.script.as_deref() != script {
                *drawn = Drawn { script: script.map(str::to_owned), pulses: None };
            }
            drawn.pulses.clone()
        };
        let unsaved = drawn.is_some();
        let file = beside(script, folder).filter(|file| file.is_file());
        let given = &self.setting.world;
        let (name, text) = match &file {
            _ if !given.is_empty() => (given.file().to_owned(), given.source().to_owned()),
            Some(file) => (name_of(file), read(file)?),
            None => ("pulses".to_owned(), String::new()),
        };
        let (rest, kept) = pulses::split(&text);
        let pulses = drawn.unwrap_or(kept);
        let text = pulses::join(&rest, &pulses);
        let world = World::parse(&name, &text)
            .map_err(|error| format!("{}:{}: {}", error.file, error.line, error.text))?;
        let many = match pulses.len() {
            1 => "1 drawn pulse".to_owned(),
            n => format!("{n} drawn pulses"),
        };
        let keeps = match beside(script, folder) {
            _ if !unsaved => String::new(),
            Some(own) if given.is_empty() => match pulses.len() {
                1 => format!("; Save writes it to {}", name_of(&own)),
                _ => format!("; Save writes them to {}", name_of(&own)),
            },
            _ => "; not kept in a file".to_owned(),
        };
        let words = match (given.is_empty() && file.is_none(), pulses.is_empty() && !unsaved) {
            (true, true) => None,
            (true, false) => Some(format!("with {many}{keeps}")),
            (false, true) => given.is_empty().then(|| format!("with the world {name}")),
            (false, false) => Some(format!("with the world {name} and {many}{keeps}")),
        };
        let own = beside(script, folder).filter(|_| given.is_empty());
        let name = own.map_or(name, |own| name_of(&own));
        let file = (!text.trim().is_empty()).then(|| (name_of(Path::new(&name)), text));
        Ok(Around { world: world.with_switches(given.switches()), words, pulses, file })
    }

    /// These pulses are drawn now, all of them.
    ///
    /// # Errors
    /// One of them is none; in words.
    pub(super) fn draw(&self, drawn: Vec<Pulse>) -> Result<(), String> {
        let drawn = pulses::tidy(drawn)?;
        let script = lock(&self.desk).name();
        *lock(&self.drawn) = Drawn { script, pulses: Some(drawn) };
        self.want_simulation(false);
        Ok(())
    }

    /// Writes what was drawn since to the script's world; `before`: the script's name until now.
    ///
    /// # Errors
    /// It cannot be read or written; in words.
    pub(super) fn keep_drawn(&self, before: Option<&str>) -> Result<(), String> {
        let (script, folder) = {
            let desk = lock(&self.desk);
            (desk.name(), desk.folder())
        };
        let mut drawn = lock(&self.drawn);
        if !self.setting.world.is_empty() || drawn.script.as_deref() != before {
            return Ok(());
        }
        let (Some(own), Some(file)) = (&drawn.pulses, beside(script.as_deref(), &folder)) else {
            return Ok(());
        };
        let old = if file.is_file() { read(&file)? } else { String::new() };
        let text = pulses::join(&pulses::split(&old).0, own);
        if text != old {
            output::replace(&file, text.as_bytes())
                .map_err(|error| format!("{}: {error}", file.display()))?;
        }
        *drawn = Drawn { script, pulses: None };
        drop(drawn);
        self.want_simulation(false);
        Ok(())
    }
}

fn name_of(file: &Path) -> String {
    file.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
