//! The checked program: what the front end hands to the back end, to the Rhai translator and to
//! the language server.
//!
//! Names are resolved, kinds are checked and gone except where they change what happens (a Length
//! or a Steps target), units are applied, constants are folded, and G-code blocks are taken apart
//! into statements with their modal state (plane, units, distance mode, motion mode, exact stop)
//! already applied. Control flow is still structured, so each engine lowers it in its own way.

mod expr;
mod parts;
mod stmt;

pub use expr::{BinOp, Expr, ExprKind, ReadKind, UnOp};
pub use stmt::{
    ArcCenter, Arm, Block, Case, CaseTest, Cycle, CycleKind, DoTest, GosubTarget, InWant, LoopKind,
    Place, PrintPart, ProbeSensor, Stmt, StmtKind, Sync, Word,
};

use crate::kind::Kind;
use crate::profile::Profile;

/// Byte range in the source.
pub type Span = core::ops::Range<usize>;

/// Index into [`Program::vars`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct VarId(pub u32);

/// Index into [`Program::tables`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TableId(pub u32);

/// Index into [`Program::routines`]; 0 is the main program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct RoutineId(pub u32);

/// Index into [`Program::labels`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LabelId(pub u32);

/// A whole checked script.
#[derive(Clone, Debug)]
pub struct Program {
    /// The machine that it was checked for.
    pub profile: Profile,
    /// Every variable, parameter, local and hidden variable.
    pub vars: Vec<Var>,
    /// Tables, in order of declaration.
    pub tables: Vec<Table>,
    /// Main program first, then SUBs and FUNCTIONs in text order.
    pub routines: Vec<Routine>,
    /// Labels of all routines.
    pub labels: Vec<Label>,
    /// Names that the script gives to inputs and outputs.
    pub ports: Vec<Port>,
    /// Names that `ANALOG` gives to analog inputs, with their numbers, from 1.
    pub analogs: Vec<(String, i32)>,
    /// Statements of the source that count for bytes per statement: every executable statement,
    /// that is neither a declaration nor a label nor a line that only closes a block.
    pub statements: u32,
    /// The last line of the source, from 1: where a run that falls off the end ends.
    pub last_line: u32,
}

/// `INPUT name = n` or `OUTPUT name = n`.
#[derive(Clone, Debug)]
pub struct Port {
    /// An output.
    pub output: bool,
    /// Its number, from 1.
    pub n: i32,
    /// As written.
    pub name: String,
}

/// A variable.
#[derive(Clone, Debug)]
pub struct Var {
    /// As written at its declaration; hidden ones have a name with a blank in it.
    pub name: String,
    /// Its kind.
    pub kind: Kind,
    /// Cells: 1, or the size of an array.
    pub len: u32,
    /// Whether it was declared with a size.
    pub array: bool,
    /// Where it lives.
    pub storage: Storage,
    /// What a panel shows of it; of AT variables.
    pub panel: Panel,
    /// Its declaration.
    pub span: Span,
}

/// What an operator panel shows of a variable.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Panel {
    /// LABEL.
    pub label: Option<String>,
    /// MIN and MAX.
    pub limits: Limits,
}

/// Values that an operator may give a variable, in the unit of its cells. The program itself is not
/// bound by them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// The least.
    pub least: i32,
    /// The greatest.
    pub greatest: i32,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits { least: i32::MIN, greatest: i32::MAX }
    }
}

/// Where a variable lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// Visible everywhere, 0 at the start of a run.
    Global,
    /// `DIM name AT register`: a global that the link sees at this register. It is 0 after power-up and
    /// after an upload, not at the start of a run.
    At(u16),
    /// KEEP number 0..=7: a global with a life after power loss.
    Keep(u8),
    /// Local of a routine, parameters included; locals are 0 at each call.
    Local(RoutineId),
}

/// A TABLE.
#[derive(Clone, Debug)]
pub struct Table {
    /// Its name.
    pub name: String,
    /// Columns; 1 for a plain list.
    pub columns: u32,
    /// Their names in lower case, where the script names them.
    pub names: Vec<String>,
    /// Kind of each column.
    pub kinds: Vec<Kind>,
    /// Row by row.
    pub values: Vec<i32>,
    /// Its declaration.
    pub span: Span,
}

/// The main program, a SUB or a FUNCTION.
#[derive(Clone, Debug)]
pub struct Routine {
    /// Its name; empty for the main program.
    pub name: String,
    /// Parameters in order.
    pub params: Vec<VarId>,
    /// Locals that are not parameters.
    pub locals: Vec<VarId>,
    /// Result of a FUNCTION.
    pub result: Option<Kind>,
    /// Statements. Event handlers that are labels are reached by their label.
    pub body: Block,
    /// Its head.
    pub span: Span,
    /// Whether anything can reach it.
    pub reachable: bool,
}

/// A label.
#[derive(Clone, Debug)]
pub struct Label {
    /// Its name.
    pub name: String,
    /// The routine that it stands in.
    pub routine: RoutineId,
    /// Its place.
    pub span: Span,
}
