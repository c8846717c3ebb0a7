//! Instructions on variables, labels and routines, before they have addresses.

use crate::back::report::MarkKind;
use crate::hir::{RoutineId, Span, TableId, VarId};
use crate::isa::Op;

/// A place in the code that jumps lead to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Label(pub u32);

/// Index into [`Unit::texts`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TextId(pub u32);

/// When a branch is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cond {
    /// pop = 0
    Zero,
    /// pop <> 0
    Nonzero,
    /// left = right
    Eq,
    /// left <> right
    Ne,
    /// left < right
    Lt,
    /// left <= right
    Le,
    /// left > right
    Gt,
    /// left >= right
    Ge,
}

impl Cond {
    /// The condition that holds when this one does not.
    pub const fn inverse(self) -> Cond {
        match self {
            Cond::Zero => Cond::Nonzero,
            Cond::Nonzero => Cond::Zero,
            Cond::Eq => Cond::Ne,
            Cond::Ne => Cond::Eq,
            Cond::Lt => Cond::Ge,
            Cond::Ge => Cond::Lt,
            Cond::Le => Cond::Gt,
            Cond::Gt => Cond::Le,
        }
    }

    /// The jump with a relative distance.
    pub const fn op(self) -> Op {
        match self {
            Cond::Zero => Op::JumpZero,
            Cond::Nonzero => Op::JumpNonzero,
            Cond::Eq => Op::JumpEq,
            Cond::Ne => Op::JumpNe,
            Cond::Lt => Op::JumpLt,
            Cond::Le => Op::JumpLe,
            Cond::Gt => Op::JumpGt,
            Cond::Ge => Op::JumpGe,
        }
    }

    /// The branch after a comparison that leaves 1 or 0.
    pub const fn of(op: Op) -> Option<Cond> {
        Some(match op {
            Op::Eq => Cond::Eq,
            Op::Ne => Cond::Ne,
            Op::Lt => Cond::Lt,
            Op::Le => Cond::Le,
            Op::Gt => Cond::Gt,
            Op::Ge => Cond::Ge,
            _ => return None,
        })
    }
}

/// Code of an instruction with millimetres, its small operand included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InlineOp(u8);

impl InlineOp {
    /// The instruction that stands for effect code `effect` with `values` values in the code.
    pub fn of(effect: u8, values: usize) -> Option<InlineOp> {
        let fits = |code: &u8| {
            crate::isa::inline(*code)
                .is_some_and(|inline| inline.code == effect && usize::from(inline.values) == values)
        };
        (crate::isa::EFFECTS..=u8::MAX).find(fits).map(InlineOp)
    }

    /// Its code.
    pub const fn code(self) -> u8 {
        self.0
    }
}

/// One instruction, label or mark.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// Push a number, in its shortest form.
    Const(i32),
    /// A variable becomes 0.
    Zero(VarId),
    /// An effect with whole millimetres, then flags in the code.
    Inline(InlineOp, Box<[i8]>, Box<[u8]>),
    /// Push a variable.
    Load(VarId),
    /// Pop into a variable.
    Store(VarId),
    /// `inc`, `addcell`.
    Change(Op, VarId),
    /// Index to value.
    LoadElem(VarId),
    /// Index and value to nothing.
    StoreElem(VarId),
    /// Sets a cell of an array: its index is known.
    StoreAt(VarId, u32),
    /// An instruction without operands.
    Plain(Op),
    /// An instruction whose code carries a small number.
    Short(Op, u8),
    /// An instruction with bytes of flags or an axis; as many as its row says.
    Flags(Op, [u8; 3]),
    /// Unconditional jump.
    Jump(Label),
    /// Conditional jump.
    Branch(Cond, Label),
    /// `forstep`, `nextstep`.
    Turn(Op, VarId, Label),
    /// `nextshort` or `nextword` with its limit.
    NextLimit(VarId, i16, Label),
    /// `call`, `func`.
    Call(Op, RoutineId),
    /// GOSUB.
    Gosub(Label),
    /// ON ERROR GOTO.
    OnError(Label),
    /// Row to value of a column; `None` is the whole table, row by row, as one column.
    Table(TableId, Option<u32>),
    /// A text of PRINT.
    Text(TextId),
    /// RUN of the program that this text names.
    Run(TextId),
    /// The slow points of the course that begins with the next effect.
    Course(TextId),
    /// Jumps lead here.
    Label(Label),
    /// What follows belongs to this place in the source.
    Mark(SourceMark),
}

/// Where code comes from, and where RESUME NEXT goes on after it.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceMark {
    /// Line, from 1.
    pub line: u32,
    /// Text.
    pub span: Span,
    /// What begins here.
    pub kind: MarkKind,
    /// Where RESUME NEXT goes on; `None` is the code behind.
    pub resume: Option<Label>,
}

impl Item {
    /// Values taken and left, as [`crate::isa::ROWS`] has them for the instruction it becomes.
    pub fn effect(&self) -> (u8, u8) {
        let op = match self {
            Item::Const(_) | Item::Load(_) => return (0, 1),
            Item::Store(_) | Item::StoreAt(..) => return (1, 0),
            Item::LoadElem(_) => Op::LoadElem,
            Item::StoreElem(_) => Op::StoreElem,
            Item::Table(..) => Op::Table,
            Item::NextLimit(..) => Op::NextWord,
            Item::Branch(cond, _) => cond.op(),
            Item::Change(op, _) | Item::Plain(op) | Item::Turn(op, ..) | Item::Call(op, _) => *op,
            Item::Short(op, n) => {
                let row = op.row();
                return (row.pops + crate::isa::arguments(row.code + n, 0, 0), row.pushes);
            }
            Item::Flags(op, bytes) => {
                let row = op.row();
                let more = crate::isa::arguments(row.code, bytes[0], bytes[1]);
                return (row.pops + more, row.pushes);
            }
            Item::Zero(_)
            | Item::Inline(..)
            | Item::Jump(_)
            | Item::Gosub(_)
            | Item::OnError(_)
            | Item::Text(_)
            | Item::Run(_)
            | Item::Course(_)
            | Item::Label(_)
            | Item::Mark(_) => return (0, 0),
        };
        let row = op.row();
        (row.pops, row.pushes)
    }

    /// Whether the next item is never reached through this one.
    pub fn ends(&self) -> bool {
        match self {
            Item::Jump(_) => true,
            Item::Plain(op) => op.row().class == crate::isa::Class::Ends,
            _ => false,
        }
    }

    /// The label that it jumps to, calls or registers.
    pub const fn target(&self) -> Option<Label> {
        match self {
            Item::Jump(label)
            | Item::Branch(_, label)
            | Item::Turn(_, _, label)
            | Item::NextLimit(_, _, label)
            | Item::Gosub(label)
            | Item::OnError(label) => Some(*label),
            _ => None,
        }
    }

    /// The same, to be changed.
    pub fn target_mut(&mut self) -> Option<&mut Label> {
        match self {
            Item::Jump(label)
            | Item::Branch(_, label)
            | Item::Turn(_, _, label)
            | Item::NextLimit(_, _, label)
            | Item::Gosub(label)
            | Item::OnError(label) => Some(label),
            _ => None,
        }
    }
}

/// Where the handler of an event begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handler {
    /// A label of the main program.
    Label(Label),
    /// A SUB.
    Routine(RoutineId),
}

/// The code of one routine.
#[derive(Clone, Debug)]
pub struct RoutineCode {
    /// Which.
    pub id: RoutineId,
    /// Its code. Its entry is the first item.
    pub items: Vec<Item>,
}

/// The code of a program.
#[derive(Clone, Debug)]
pub struct Unit {
    /// Main program first; routines that nothing reaches are left out.
    pub routines: Vec<RoutineCode>,
    /// Texts, each once.
    pub texts: Vec<Vec<u8>>,
    /// Handlers in order of their event slots.
    pub events: Vec<Handler>,
    /// [`crate::record::feature`] bits.
    pub features: u16,
    /// Labels given out.
    pub labels: u32,
}
