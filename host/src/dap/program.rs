//! From a file's name to a program that can be inspected while it runs.

use std::collections::{BTreeMap, BTreeSet};

use lang::back::{self, Compiled, disasm};
use lang::front::index::Index;
use lang::front::source::Source;
use lang::front::{ProfileChoice, analyse};
use lang::hir::Program;
use lang::image::Image;
use lang::isa::Op;
use lang::profile::Profile;

use super::names::Names;
use super::sim::beginnings;
use crate::input;
use crate::trial::lines;

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
    /// Those of them with an effect, before which a board halts.
    pub effects: Vec<u32>,
    /// What each routine calls itself; `None` is the main program.
    calls: Calls,
}

/// Callees of each routine.
type Calls = BTreeMap<Option<usize>, BTreeSet<Option<usize>>>;

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
    let effects = lines::with_effects(&compiled);
    let calls = calls_of(&compiled, &names);
    Ok(Loaded { file: file.to_owned(), program, compiled, names, lines, effects, calls })
}

/// Who calls whom.
fn calls_of(compiled: &Compiled, names: &Names) -> Calls {
    let mut calls = BTreeMap::new();
    let line = |pc: usize| compiled.sidecar.at(pc).map_or(0, |mark| mark.line);
    let code = Image::new(&compiled.image).map(|image| disasm::instructions(&image));
    for insn in code.unwrap_or_default() {
        let Some((op, _)) = Op::decode(insn.bytes[0]) else { continue };
        let here = line(insn.pc);
        if matches!(op, Op::Call | Op::CallFar | Op::Func) {
            let address =
                insn.bytes[1..].iter().rev().fold(0, |at, byte| at << 8 | usize::from(*byte));
            let to: &mut BTreeSet<_> = calls.entry(names.routine_at(here)).or_default();
            to.insert(names.routine_at(line(address)));
        }
    }
    calls
}

impl Loaded {
    /// The line of a breakpoint: this one, or the next of which something runs; on a board (`effects`)
    /// the next with an effect.
    pub fn line_from(&self, line: u32, effects: bool) -> Option<u32> {
        let lines = if effects { &self.effects } else { &self.lines };
        let at = lines.partition_point(|own| *own < line);
        lines.get(at).copied()
    }

    /// Whether a line is of what the routine of another line calls, or they call in turn.
    pub fn is_called_from(&self, caller: u32, line: u32) -> bool {
        let wanted = self.names.routine_at(line);
        let (mut seen, mut open) = (BTreeSet::new(), vec![self.names.routine_at(caller)]);
        while let Some(routine) = open.pop() {
            for callee in self.calls.get(&routine).into_iter().flatten() {
                if *callee == wanted {
                    return true;
                }
                if seen.insert(*callee) {
                    open.push(*callee);
                }
            }
        }
        false
    }
}
