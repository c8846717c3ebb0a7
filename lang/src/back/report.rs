//! What a compilation gives besides code: places, amounts, excesses.

use crate::back::cells::Cells;
use crate::back::graph::Graph;
use crate::back::ir::Unit;
use crate::hir::{Program, RoutineId, Span, VarId};
use crate::image::MAX_CELLS;

/// What begins at a mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarkKind {
    /// A statement of the source.
    Statement,
    /// The end of a pass of a loop: NEXT, WEND, LOOP, END REPEAT.
    LoopEnd,
    /// A later test of a block: ELSEIF, CASE, the condition of a WHILE after its first pass.
    Test,
    /// Code that no statement asked for; its place is that of the block around it.
    Glue,
}

/// Code from `pc` to the next mark belongs to one place in the source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mark {
    /// Address of the first instruction.
    pub pc: usize,
    /// Line, from 1.
    pub line: u32,
    /// Text.
    pub span: Span,
    /// What begins here.
    pub kind: MarkKind,
}

/// From code to source; stays on the host.
#[derive(Clone, Debug, Default)]
pub struct Sidecar {
    /// In ascending order of addresses, the first at 0.
    pub marks: Vec<Mark>,
}

impl Sidecar {
    /// The mark whose code holds `pc`.
    pub fn at(&self, pc: usize) -> Option<&Mark> {
        let after = self.marks.partition_point(|mark| mark.pc <= pc);
        self.marks.get(after.checked_sub(1)?)
    }

    /// The mark that begins at exactly `pc`.
    pub fn starting_at(&self, pc: usize) -> Option<&Mark> {
        self.marks.binary_search_by_key(&pc, |mark| mark.pc).ok().map(|i| &self.marks[i])
    }
}

/// Where a variable lives.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VarPlace {
    /// Which.
    pub var: VarId,
    /// First cell.
    pub cell: u32,
    /// Number of cells.
    pub len: u32,
}

/// A compiled program.
#[derive(Clone, Debug)]
pub struct Compiled {
    /// The image.
    pub image: Vec<u8>,
    /// From code to source.
    pub sidecar: Sidecar,
    /// Cells of every variable that is alive.
    pub vars: Vec<VarPlace>,
    /// Statements that count.
    pub statements: u32,
    /// Bytes of code.
    pub code_bytes: usize,
    /// Bytes of tables, texts and of the statement table.
    pub table_bytes: usize,
    /// Cells used.
    pub cells: usize,
    /// Cells that there are beside this stack and these calls.
    pub cells_available: usize,
    /// Expression depth used.
    pub stack: usize,
    /// Call depth used.
    pub calls: usize,
    /// KEEP values used.
    pub keeps: usize,
}

/// What a program can have too much of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resource {
    /// Cells of variables.
    Cells,
    /// Values on the expression stack.
    Stack,
    /// Calls open at once.
    Calls,
    /// KEEP values.
    Keeps,
    /// Rows of a table: at most 65535.
    Rows,
    /// Bytes of all texts: their places have 16 bits.
    Texts,
}

/// A program wants more than the device has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Excess {
    /// Of what.
    pub resource: Resource,
    /// How much it wants.
    pub used: usize,
    /// How much there is.
    pub available: usize,
    /// The declaration, statement or call that goes too far.
    pub span: Span,
}

/// KEEP values of a program at most.
const MAX_KEEPS: usize = 8;
/// Bytes of texts at most: short columns may lie before them.
const MAX_TEXTS: usize = 0x8000;
/// Cells of an array at most: an instruction has its length in a byte.
const MAX_ARRAY: usize = u8::MAX as usize;
/// Values on the expression stack and entries of the call stack at most: what parts promise.
pub const MAX_DEPTH: usize = 16;

/// Everything that the program has too much of for an image, which the largest part runs.
pub fn excesses(program: &Program, unit: &Unit, graph: &Graph, cells: &Cells) -> Vec<Excess> {
    let mut found = Vec::new();
    let mut check = |resource, used: usize, available: usize, span: &Span| {
        if used > available {
            found.push(Excess { resource, used, available, span: span.clone() });
        }
    };
    let (stack, calls) = (graph.stack(), graph.calls);
    if cells.count > MAX_CELLS {
        let span = cells.beyond(program, MAX_CELLS);
        check(Resource::Cells, cells.count, MAX_CELLS, &span);
    }
    let long = |var: &&VarId| program.var(**var).len as usize > MAX_ARRAY;
    if let Some(var) = cells.of.keys().filter(long).min() {
        let var = program.var(*var);
        check(Resource::Cells, var.len as usize, MAX_ARRAY, &var.span);
    }
    check(Resource::Stack, stack, MAX_DEPTH, &graph.stack_span);
    check(Resource::Calls, calls, MAX_DEPTH, &graph.calls_span);
    if let Some(keep) = cells.keeps.last().filter(|_| cells.kept > MAX_KEEPS) {
        check(Resource::Keeps, cells.kept, MAX_KEEPS, &program.var(*keep).span);
    }
    let texts: usize = unit.texts.iter().map(|text| text.len() + 1).sum();
    check(Resource::Texts, texts, MAX_TEXTS, &program.routine(RoutineId(0)).span);
    for table in &program.tables {
        let rows = table.values.len() / (table.columns.max(1) as usize);
        check(Resource::Rows, rows, usize::from(u16::MAX), &table.span);
    }
    found
}
