//! The back end: from the checked program to an image.
//!
//! [`lower`] turns statements into [`ir`], instructions on variables and labels; [`opt`] shortens
//! them; [`graph`] follows calls to find depths, contexts and dead code; [`cells`] gives variables
//! their cells; [`emit`] chooses the shortest forms, lays out code and data and writes the image.

pub mod cells;
mod courses;
mod data;
pub mod disasm;
mod emit;
mod graph;
pub mod ir;
mod lower;
mod opt;
mod places;
mod report;

#[cfg(test)]
mod tests;

pub use courses::Courses;
pub use data::column;
pub use emit::constant;
pub use report::{Compiled, Excess, MAX_DEPTH, Mark, MarkKind, Resource, Sidecar, VarPlace};

use crate::hir::Program;
use crate::record::feature;

/// Compiles a checked program.
///
/// # Errors
/// The program wants more cells, KEEP values, stack or calls than an image can say and the largest part has;
/// each with a place in the source. What smaller parts lack is [`crate::part::Part::all_lacks`]'s. The size of
/// code and tables is no reason: compare [`Compiled::image`]'s length with what a board offers.
pub fn compile(program: &Program) -> Result<Compiled, Vec<Excess>> {
    compile_with(program, &Courses::default())
}

/// The same with slow points, which stand in front of the lines that begin their courses.
///
/// # Errors
/// As [`compile`].
pub fn compile_with(program: &Program, courses: &Courses) -> Result<Compiled, Vec<Excess>> {
    let mut unit = lower::lower(program);
    let resumes = unit.features & feature::LINES != 0;
    for routine in &mut unit.routines {
        opt::peephole(&mut routine.items, resumes);
    }
    let graph = graph::analyse(program, &mut unit);
    let cells = cells::allocate(program, &unit, &graph);
    let excesses = report::excesses(program, &unit, &graph, &cells);
    if !excesses.is_empty() {
        return Err(excesses);
    }
    Ok(emit::emit(program, unit, &graph, &cells, courses))
}
