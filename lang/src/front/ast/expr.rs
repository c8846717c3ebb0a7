//! Expressions of the syntax tree.

use super::{AxisRef, Name};
use crate::front::span::Span;
use crate::front::words::Func;
use crate::kind::Kind;
use core::fmt;

/// An expression.
#[derive(Clone, PartialEq)]
pub struct Expr {
    /// What it is.
    pub kind: ExprKind,
    /// Where it stands, its parentheses included.
    pub span: Span,
}

/// The expressions.
#[derive(Clone, Debug, PartialEq)]
pub enum ExprKind {
    /// A number with its unit; TRUE FALSE ON OFF.
    Literal {
        /// Its kind.
        kind: Kind,
        /// In the unit in which the kind is stored.
        value: i32,
    },
    /// A variable, constant, port or table; a FUNCTION without parameters.
    Name(Name),
    /// `name(a, b)`: an array, a table or a FUNCTION.
    Apply(Name, Vec<Expr>),
    /// A built-in function; the number of arguments was checked against the table of functions.
    Builtin(Func, Vec<Expr>),
    /// An axis letter: argument of a built-in function only.
    Axis(AxisRef),
    /// `-e`, `NOT e`
    Unary(UnaryOp, Box<Expr>),
    /// `a + b`
    Binary(BinaryOp, Box<Expr>, Box<Expr>),
}

/// Operators with one operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum UnaryOp {
    /// `-`
    Neg,
    /// NOT
    Not,
    /// `n.3`, bits 0 to 31: a Truth.
    Bit(u8),
}

/// Operators with two operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BinaryOp {
    /// OR
    Or,
    /// XOR
    Xor,
    /// ORELSE
    OrElse,
    /// AND
    And,
    /// ANDALSO
    AndAlso,
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
    /// `<<`
    Shl,
    /// `>>`
    Shr,
    /// `+`
    Add,
    /// `-`
    Sub,
    /// `*`
    Mul,
    /// `/`
    Div,
    /// MOD
    Mod,
}

impl BinaryOp {
    /// As it is written.
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::Or => "OR",
            Self::Xor => "XOR",
            Self::OrElse => "ORELSE",
            Self::And => "AND",
            Self::AndAlso => "ANDALSO",
            Self::Eq => "=",
            Self::Ne => "<>",
            Self::Lt => "<",
            Self::Le => "<=",
            Self::Gt => ">",
            Self::Ge => ">=",
            Self::Shl => "<<",
            Self::Shr => ">>",
            Self::Add => "+",
            Self::Sub => "-",
            Self::Mul => "*",
            Self::Div => "/",
            Self::Mod => "MOD",
        }
    }

    /// Gives a Truth.
    pub const fn is_comparison(self) -> bool {
        matches!(self, Self::Eq | Self::Ne | Self::Lt | Self::Le | Self::Gt | Self::Ge)
    }
}

/// One line, every operator with its parentheses.
impl fmt::Debug for Expr {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = |f: &mut fmt::Formatter<'_>, args: &[Self]| {
            f.write_str("(")?;
            for (n, arg) in args.iter().enumerate() {
                write!(f, "{}{arg:?}", if n > 0 { ", " } else { "" })?;
            }
            f.write_str(")")
        };
        match &self.kind {
            ExprKind::Literal { kind: Kind::Truth, value: 0 } => f.write_str("FALSE"),
            ExprKind::Literal { kind: Kind::Truth, .. } => f.write_str("TRUE"),
            ExprKind::Literal { kind, value } => write!(f, "{value}{}", kind.unit().suffix()),
            ExprKind::Name(name) => write!(f, "{name:?}"),
            ExprKind::Apply(name, args) => {
                write!(f, "{name:?}")?;
                list(f, args)
            }
            ExprKind::Builtin(func, args) => {
                f.write_str(func.text())?;
                list(f, args)
            }
            ExprKind::Axis(axis) => write!(f, "{}", axis.axis.letter()),
            ExprKind::Unary(UnaryOp::Neg, e) => write!(f, "(-{e:?})"),
            ExprKind::Unary(UnaryOp::Not, e) => write!(f, "(NOT {e:?})"),
            ExprKind::Unary(UnaryOp::Bit(bit), e) => write!(f, "{e:?}.{bit}"),
            ExprKind::Binary(op, a, b) => write!(f, "({a:?} {} {b:?})", op.symbol()),
        }
    }
}
