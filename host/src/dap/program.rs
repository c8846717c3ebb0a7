//! From a file's name to a program that can be looked at while it runs.

use lang::back::{self, Compiled};
use lang::front::index::Index;
use lang::front::source::Source;
use lang::front::{ProfileChoice, analyse};
use lang::hir::Program;
use lang::profile::Profile;

use super::names::Names;
use super::sim::beginnings;
use crate::input;

/// A script that was compiled to be looked at.
pub struct Loaded {
    /// Its file.
    pub file: String,
    /// The checked program.
    pub program: Program,
    /// Its image.
    pub compiled: Compiled,
    /// Its names.
    pub names: Names,
    /// Lines of which something runs, ascending.
    pub lines: Vec<u32>,
}

/// Reads and compiles a script.
///
/// # Errors
/// It cannot be read or is wrong; every diagnostic, a line each.
pub fn load(file: &str, profile: Option<Profile>) -> Result<Loaded, String> {
    let bytes = input::read_bytes(file, import::MAX_BYTES).map_err(|note| note.line())?;
    if import::is_importable(file, &bytes) {
        return Err(format!(
            "{file} is a program of another system: `pasapas import {file} -o job.bas` makes a \
             script of it, which can be stepped"
        ));
    }
    let (source, wrong) = Source::decode(file, &bytes);
    if let Some(diag) = wrong.iter().find(|diag| diag.is_error()) {
        return Err(diag.render(&source));
    }
    let find = |name: &str| input::profile_beside(name, file).map(|(profile, _)| profile);
    let choice = match profile {
        Some(profile) => ProfileChoice::Given(Box::new(profile)),
        None => ProfileChoice::Script(&find),
    };
    let mut analysis = analyse(&source, choice);
    let Some(program) = analysis.program.take() else {
        return Err(analysis.diags.render(&source));
    };
    let compiled = back::compile(&program).map_err(|excesses| {
        let told = excesses.iter().map(|excess| {
            let back::Excess { resource, used, available, .. } = excess;
            format!("{resource:?}: {used} used, {available} available")
        });
        told.collect::<Vec<_>>().join("\n")
    })?;
    let names = Names::new(&Index::new(&analysis.script), &analysis, &program, &compiled);
    let mut lines: Vec<u32> = beginnings(&compiled.sidecar).into_values().flatten().collect();
    lines.sort_unstable();
    lines.dedup();
    Ok(Loaded { file: file.to_owned(), program, compiled, names, lines })
}

impl Loaded {
    /// The line of a breakpoint: this one, or the next of which something runs.
    pub fn line_from(&self, line: u32) -> Option<u32> {
        let at = self.lines.partition_point(|own| *own < line);
        self.lines.get(at).copied()
    }
}
