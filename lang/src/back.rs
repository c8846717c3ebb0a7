//! The back end: from the checked program to an image.
//!
//! [`lower`] turns statements into [`ir`], instructions on variables and labels; [`opt`] shortens
//! them; [`graph`] follows calls to find depths, contexts and dead code; [`cells`] gives variables
//! their cells; [`emit`] chooses the shortest forms, lays out code and data and writes the image.

pub mod cells;
mod data;
pub mod disasm;
mod emit;
mod graph;
pub mod ir;
mod lower;
mod opt;
mod report;

#[cfg(test)]
mod tests;

pub use emit::constant;
pub use report::{Compiled, Excess, Mark, MarkKind, Resource, Sidecar, VarPlace};

use ir::{Item, Unit};
use std::collections::BTreeMap;

use crate::hir::Program;
use crate::record::feature;

/// Compiles a checked program.
///
/// # Errors
/// The program wants more cells, KEEP values, stack or calls than the device has; each with a
/// place in the source. The size of code and tables is no reason: compare
/// [`Compiled::image`]'s length with what a board offers.
pub fn compile(program: &Program) -> Result<Compiled, Vec<Excess>> {
    compile_for(program, Room::Device)
}

/// Where an image is to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Room {
    /// On a device with the memory that the language promises.
    Device,
    /// On a computer: only what the image's format can say is a limit.
    Format,
}

/// [`compile`] for a place with more or less room.
///
/// # Errors
/// As those of [`compile`].
pub fn compile_for(program: &Program, room: Room) -> Result<Compiled, Vec<Excess>> {
    compile_with(program, room, &SlowPoints::new())
}

/// Operands of [`Op::Slow`](crate::isa::Op::Slow) at the beginnings of statements, by the number of the
/// statement in [`Sidecar::statements`].
pub type SlowPoints = BTreeMap<usize, [u8; 3]>;

/// As [`compile_for`], with slow points; where they lie is found by running the program on the host.
///
/// # Errors
/// As [`compile`].
pub fn compile_with(
    program: &Program,
    room: Room,
    slow: &SlowPoints,
) -> Result<Compiled, Vec<Excess>> {
    let mut unit = lower::lower(program);
    let resumes = unit.features & feature::LINES != 0;
    for routine in &mut unit.routines {
        opt::peephole(&mut routine.items, resumes);
    }
    let graph = graph::analyse(program, &mut unit);
    let cells = cells::allocate(program, &unit, &graph);
    let excesses = report::excesses(program, &unit, &graph, &cells, room);
    if !excesses.is_empty() {
        return Err(excesses);
    }
    set_slow_points(&mut unit, slow);
    Ok(emit::emit(program, unit, &graph, &cells))
}

/// Puts slow points into the code.
fn set_slow_points(unit: &mut Unit, slow: &SlowPoints) {
    let mut number = 0;
    for routine in &mut unit.routines {
        let mut items = Vec::with_capacity(routine.items.len());
        for item in core::mem::take(&mut routine.items) {
            let begins = item.begins_statement();
            items.push(item);
            if begins {
                if let Some(operand) = slow.get(&number) {
                    items.push(Item::Flags(crate::isa::Op::Slow, *operand));
                }
                number += 1;
            }
        }
        routine.items = items;
    }
}
