//! Expressions of the checked program.

use super::{RoutineId, Span, TableId, VarId};
use crate::axis::Axis;
use crate::kind::Kind;

/// An expression with its kind.
#[derive(Clone, Debug)]
pub struct Expr {
    /// Kind of the result.
    pub kind: Kind,
    /// Its text.
    pub span: Span,
    /// What it is.
    pub node: ExprKind,
}

impl Expr {
    /// Whether it is known before the run.
    pub const fn constant(&self) -> Option<i32> {
        match self.node {
            ExprKind::Const(value) => Some(value),
            _ => None,
        }
    }

    /// Whether it is a constant or a variable: to evaluate it changes nothing and never fails.
    pub const fn is_simple(&self) -> bool {
        matches!(self.node, ExprKind::Const(_) | ExprKind::Var(_))
    }

    /// Whether a FUNCTION is called anywhere in it.
    pub fn has_call(&self) -> bool {
        match &self.node {
            ExprKind::Const(_) | ExprKind::Var(_) | ExprKind::Err | ExprKind::Erl => false,
            ExprKind::Elem(_, x)
            | ExprKind::Unary(_, x)
            | ExprKind::ToSteps(_, x)
            | ExprKind::ToLength(_, x)
            | ExprKind::Read(ReadKind::In(x) | ReadKind::Out(x)) => x.has_call(),
            ExprKind::Read(_) => false,
            ExprKind::Table { row: a, column: b, .. }
            | ExprKind::Binary(_, a, b)
            | ExprKind::AndAlso(a, b)
            | ExprKind::OrElse(a, b) => a.has_call() || b.has_call(),
            ExprKind::MulDiv(parts) => parts.iter().any(Expr::has_call),
            ExprKind::Call(..) => true,
        }
    }
}

/// Nodes of expressions. Operands are evaluated left to right.
#[derive(Clone, Debug)]
pub enum ExprKind {
    /// A literal, a CONST or the folded result of such.
    Const(i32),
    /// A scalar variable.
    Var(VarId),
    /// An array element; F03 outside.
    Elem(VarId, Box<Expr>),
    /// A table value; F03 when row or column lie outside.
    Table {
        /// The table.
        table: TableId,
        /// Row, from 0.
        row: Box<Expr>,
        /// Column, from 0.
        column: Box<Expr>,
    },
    /// One operand.
    Unary(UnOp, Box<Expr>),
    /// Two operands, both evaluated.
    Binary(BinOp, Box<Expr>, Box<Expr>),
    /// ANDALSO; gives 1 or 0.
    AndAlso(Box<Expr>, Box<Expr>),
    /// ORELSE; gives 1 or 0.
    OrElse(Box<Expr>, Box<Expr>),
    /// A FUNCTION.
    Call(RoutineId, Vec<Expr>),
    /// `STEPS(axis, length)`: um to steps by the profile, half away from zero; F01.
    ToSteps(Axis, Box<Expr>),
    /// `LENGTH(axis, steps)`: steps to um by the profile, half away from zero; F01.
    ToLength(Axis, Box<Expr>),
    /// `value * times / over` of SCALE, half away from zero; F02, F01.
    MulDiv(Box<[Expr; 3]>),
    /// A look at the machine.
    Read(ReadKind),
    /// ERR: number of the last fault, 0 before one.
    Err,
    /// ERL: its line.
    Erl,
}

/// Functions that look at the machine, with their argument.
#[derive(Clone, Debug)]
pub enum ReadKind {
    /// `IN(n)`
    In(Box<Expr>),
    /// `INPORT()`
    InPort,
    /// `OUT(n)`
    Out(Box<Expr>),
    /// `POS(axis)`
    Pos(Axis),
    /// `POSST(axis)`
    PosSteps(Axis),
    /// `PROBED(axis)`
    Probed(Axis),
    /// `PROBEDST(axis)`
    ProbedSteps(Axis),
    /// `PROBEOK(axis)`
    ProbeOk(Axis),
    /// `MOVING(axis)`
    Moving(Axis),
    /// `HOMED(axis)`
    Homed(Axis),
    /// `TIMER()`
    Timer,
    /// `TIMEDOUT`
    TimedOut,
    /// `CHARIN()`
    CharIn,
    /// `AIN(n)`, 1 to 4
    Analog(u8),
}

/// Operators and functions of one operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnOp {
    /// `-`; F01 for the least number.
    Neg,
    /// NOT of a Number: bitwise.
    BitNot,
    /// NOT of a Truth: 1 or 0.
    LogNot,
    /// ABS; F01 for the least number.
    Abs,
    /// SGN: -1, 0, 1.
    Sgn,
    /// SQR: integer root; negative F20.
    Sqr,
    /// SIN of an Angle.
    Sin,
    /// COS of an Angle.
    Cos,
}

/// Operators and functions of two operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BinOp {
    /// `+`; F01.
    Add,
    /// `-`; F01.
    Sub,
    /// `*`; F01.
    Mul,
    /// `/` toward zero; F02, F01.
    Div,
    /// MOD with the dividend's sign; F02.
    Mod,
    /// AND, bitwise.
    And,
    /// OR, bitwise.
    Or,
    /// XOR, bitwise.
    Xor,
    /// `<<` drops bits; F04 for a count outside 0..31.
    Shl,
    /// `>>` arithmetic; F04.
    Shr,
    /// `=`
    Eq,
    /// `<>`
    Ne,
    /// `<`
    Lt,
    /// `<=`
    Le,
    /// `>`
    Gt,
    /// `>=`
    Ge,
    /// MIN
    Min,
    /// MAX
    Max,
    /// ATAN2(y, x)
    Atan2,
}
