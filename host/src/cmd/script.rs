//! From a file's name to a checked script.

use std::path::Path;

use lang::front::source::{MAX_SOURCE_BYTES, Source};
use lang::front::{ProfileChoice, compile};
use lang::hir::Program;
use lang::profile::{Profile, ProfileError};

use super::{Console, Options};
use crate::failure::Failure;
use crate::input;

/// A script that can run.
pub struct Script {
    /// Its text.
    pub source: Source,
    /// What the checker made of it.
    pub program: Program,
}

/// Reads and checks a script; every diagnostic is written.
///
/// # Errors
/// It cannot be read or has errors.
pub fn load(file: &str, options: &Options, console: &Console) -> Result<Script, Failure> {
    let given = options.profile(console)?;
    let bytes = input::read_bytes(file, MAX_SOURCE_BYTES).map_err(|note| console.refuse(&note))?;
    let (source, mut diags) = Source::decode(file, &bytes);
    let find = |name: &str| named_profile(name, file);
    let choice = match given {
        Some(profile) => ProfileChoice::Given(Box::new(profile)),
        None => ProfileChoice::Script(&find),
    };
    let mut program = None;
    let mut dropped = 0;
    if !diags.iter().any(|diag| diag.is_error()) {
        let (checked, found) = compile(&source, choice);
        dropped = found.dropped();
        diags.extend(found.into_sorted());
        program = checked;
    }
    for diag in &diags {
        console.diag(diag, &source)?;
    }
    if dropped > 0 && !console.json() {
        console.complain(&format!("{file}: {dropped} further diagnostics are not shown"));
    }
    match program {
        Some(program) => Ok(Script { source, program }),
        None => Err(Failure::Input),
    }
}

/// The profile of a PROFILE line: a built-in one, or NAME.toml beside the script.
fn named_profile(name: &str, script: &str) -> Result<Profile, ProfileError> {
    let built_in = Profile::built_in(name);
    let plain = name.chars().all(|c| c.is_alphanumeric() || c == '_' || c == '-');
    if built_in.is_ok() || !plain {
        return built_in;
    }
    let beside = Path::new(script).with_file_name(format!("{name}.toml"));
    if !beside.is_file() {
        return built_in;
    }
    let path = beside.display().to_string();
    let text = input::read_text(&path).map_err(|note| ProfileError(note.line()))?;
    Profile::parse(&text).map_err(|error| ProfileError(format!("{path}: {error}")))
}
