//! Programs that a script starts by RUN: the scripts in the same folder, by the names that `upload` gives them.

use std::path::{Path, PathBuf};

use lang::back::{self, Compiled};
use lang::called;
use lang::part::F5529;

use super::console::{Console, Options};
use super::script::{self, Script};
use crate::client::library::name_of;
use crate::failure::Failure;
use crate::render::Note;
use crate::sim::chain::{self, Call, Chain};

/// What a script's name ends in.
const SCRIPT: &str = "bas";

/// A script beside another.
pub struct Other {
    /// Its name in a library.
    pub name: String,
    /// Its file.
    pub file: String,
    /// What it says.
    pub script: Script,
    /// Its image.
    pub compiled: Compiled,
}

/// The programs that a script runs, and those that these run.
#[derive(Default)]
pub struct Others {
    /// The name of the script itself in a library.
    name: String,
    /// Each of the others once.
    pub list: Vec<Other>,
}

impl Others {
    /// Finds what the script in `file` runs; a warning names each RUN that leads nowhere.
    ///
    /// # Errors
    /// Standard output is full or gone.
    pub fn find(
        file: &str,
        script: &Script,
        options: &Options,
        console: &Console,
    ) -> Result<Others, Failure> {
        let mut others = Others { name: name_of(file), list: Vec::new() };
        others.follow(file, script, options, console)?;
        let mut at = 0;
        while let Some(other) = others.list.get(at) {
            let (file, script) = (other.file.clone(), other.script.clone());
            others.follow(&file, &script, options, console)?;
            at += 1;
        }
        Ok(others)
    }

    /// Adds what a script runs.
    fn follow(
        &mut self,
        file: &str,
        script: &Script,
        options: &Options,
        console: &Console,
    ) -> Result<(), Failure> {
        for call in chain::calls(&script.program) {
            let known = self.list.iter().map(|other| &other.name).chain([&self.name]);
            if known.into_iter().any(|name| called::same(name, &call.name)) {
                continue;
            }
            match self.take(file, script, &call, options, console) {
                Ok(other) => self.list.push(other),
                Err((text, hint)) => {
                    let text = format!("RUN \"{}\" ends with F21: {text}", call.name);
                    let note = Note::in_source(&script.source, call.span, "B013", text);
                    console.note_in(&note.hint(hint).warning(), &script.source)?;
                }
            }
        }
        Ok(())
    }

    /// The script that a RUN of `file` begins, or why there is none, and the remedy.
    fn take(
        &self,
        file: &str,
        script: &Script,
        call: &Call,
        options: &Options,
        console: &Console,
    ) -> Result<Other, (String, String)> {
        let name = &call.name;
        let Some(path) = beside(Path::new(file), name) else {
            let hint = format!("write {name}.{SCRIPT}; a board's library has its own programs");
            return Err((format!("no {name}.{SCRIPT} stands beside this script"), hint));
        };
        if self.list.len() + 1 >= usize::from(F5529.programs) {
            let text = format!("a library holds {} programs", F5529.programs);
            return Err((text, "put several of them into one".to_owned()));
        }
        let file = path.to_string_lossy().into_owned();
        let wrong = |_| {
            let hint = format!("`pasapas check {file}` says which");
            (format!("{file} has errors"), hint)
        };
        let quiet = console.quiet();
        let other = script::load(&file, options, &quiet).map_err(wrong)?;
        let compiled = back::compile(&other.program).map_err(|_| Failure::Input).map_err(wrong)?;
        let [own, its] = [script, &other].map(|script| &script.program.profile);
        if own != its {
            let text =
                format!("{file} is for the machine `{}`, this script for `{}`", its.name, own.name);
            return Err((text, "programs that run one another have one machine".to_owned()));
        }
        Ok(Other { name: name_of(&file), file, script: other, compiled })
    }

    /// With the script itself first.
    pub fn chain<'a>(&'a self, script: &'a Script) -> Chain<'a> {
        let first = (self.name.clone(), &script.program);
        let others = self.list.iter().map(|other| (other.name.clone(), &other.script.program));
        Chain::of([first].into_iter().chain(others))
    }

    /// What the script itself is called.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The file of a program of the chain, but for the first.
    pub fn file(&self, number: usize) -> Option<&str> {
        Some(self.list.get(number.checked_sub(1)?)?.file.as_str())
    }
}

/// The script beside a file that has this name in a library, the first of several in the order of their files' names.
fn beside(file: &Path, name: &str) -> Option<PathBuf> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
    let entries = std::fs::read_dir(folder.unwrap_or(Path::new("."))).ok()?;
    let script = |path: &PathBuf| {
        let ends = path.extension().is_some_and(|own| own.eq_ignore_ascii_case(SCRIPT));
        ends && called::same(&name_of(&path.to_string_lossy()), name)
    };
    let mut found: Vec<PathBuf> =
        entries.flatten().map(|entry| entry.path()).filter(script).collect();
    found.sort();
    let first = found.into_iter().next()?;
    // As the user writes files: without the folder where he stands.
    Some(if folder.is_none() { first.file_name().map(PathBuf::from)? } else { first })
}
