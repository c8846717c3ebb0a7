//! The algebra of kinds (lang/README.md, Values and kinds): which operands go together and what they give.

use crate::front::ast::BinaryOp;
use crate::front::literal::example;
use crate::front::words::Func;
use crate::kind::Kind;

/// Number, or Truth where a Number serves.
pub(super) const fn is_plain(kind: Kind) -> bool {
    matches!(kind, Kind::Number | Kind::Truth)
}

/// Kind of the result of an operator; None where the operands do not go together.
pub(super) fn binary(op: BinaryOp, left: Kind, right: Kind) -> Option<Kind> {
    let plain = is_plain(left) && is_plain(right);
    let same = left == right;
    match op {
        BinaryOp::Add | BinaryOp::Sub if plain => Some(Kind::Number),
        BinaryOp::Add | BinaryOp::Sub => same.then_some(left),
        BinaryOp::Mul if plain => Some(Kind::Number),
        BinaryOp::Mul if is_plain(right) => Some(left),
        BinaryOp::Mul if is_plain(left) => Some(right),
        BinaryOp::Mul => None,
        BinaryOp::Div if plain || same => Some(Kind::Number),
        BinaryOp::Mod if plain => Some(Kind::Number),
        BinaryOp::Div => is_plain(right).then_some(left),
        BinaryOp::Mod => (same || is_plain(right)).then_some(left),
        BinaryOp::And | BinaryOp::Or | BinaryOp::Xor if same && left == Kind::Truth => {
            Some(Kind::Truth)
        }
        BinaryOp::And | BinaryOp::Or | BinaryOp::Xor | BinaryOp::Shl | BinaryOp::Shr => {
            plain.then_some(Kind::Number)
        }
        BinaryOp::AndAlso | BinaryOp::OrElse => plain.then_some(Kind::Truth),
        _ => (plain || same).then_some(Kind::Truth),
    }
}

/// MIN and MAX: two of one kind.
pub(super) fn extreme(left: Kind, right: Kind) -> Option<Kind> {
    if left == right {
        Some(left)
    } else {
        (is_plain(left) && is_plain(right)).then_some(Kind::Number)
    }
}

/// Whether a value of kind `from` may be stored where `into` is kept.
pub(super) fn fits(into: Kind, from: Kind) -> bool {
    into == from || (into == Kind::Number && from == Kind::Truth)
}

/// What to write instead, for two operands that do not go together.
pub(super) fn remedy(op: BinaryOp, left: Kind, right: Kind) -> String {
    let lengths =
        |a, b| matches!((a, b), (Kind::Length, Kind::Steps) | (Kind::Steps, Kind::Length));
    if lengths(left, right) {
        return "convert one of them: `STEPS(X, length)` or `LENGTH(X, steps)`".to_owned();
    }
    match op {
        BinaryOp::And | BinaryOp::Or | BinaryOp::Xor | BinaryOp::AndAlso | BinaryOp::OrElse => {
            "AND, OR and XOR join Truths or Numbers: compare first, as in `a > 0mm AND b > 0mm`"
                .to_owned()
        }
        BinaryOp::Shl | BinaryOp::Shr => "only Numbers are shifted".to_owned(),
        BinaryOp::Mul => {
            format!("one side of `*` must be a Number: divide by `{}` first", unit_of(right))
        }
        BinaryOp::Div => format!(
            "a Number is divided by Numbers only: divide by a plain number, or by `{}` on both sides",
            unit_of(right)
        ),
        _ if is_plain(left) => format!("give the Number a unit, as in `{}`", example(right)),
        _ if is_plain(right) => format!("give the Number a unit, as in `{}`", example(left)),
        _ => format!(
            "both sides must be of one kind; `a / {}` makes a Number of a {left}",
            unit_of(left)
        ),
    }
}

/// One unit of a kind as a literal: what a quantity is divided by to make it a Number.
pub(super) const fn unit_of(kind: Kind) -> &'static str {
    match kind {
        Kind::Number | Kind::Truth => "1",
        Kind::Length => "1mm",
        Kind::Steps => "1st",
        Kind::Time => "1ms",
        Kind::Speed => "1mm/s",
        Kind::StepRate => "1st/s",
        Kind::Accel => "1mm/s2",
        Kind::StepAccel => "1st/s2",
        Kind::Angle => "1deg",
        Kind::Voltage => "1mV",
    }
}

/// A kind with its article, for messages.
pub(super) fn a(kind: Kind) -> String {
    let article = if matches!(kind, Kind::Accel | Kind::Angle) { "an" } else { "a" };
    if kind == Kind::Steps { "Steps".to_owned() } else { format!("{article} {kind}") }
}

/// Kind of a built-in function's result; those that keep their argument's kind count as Number.
pub(super) const fn func_kind(func: Func) -> Kind {
    match func {
        Func::Pos | Func::Probed | Func::Length => Kind::Length,
        Func::PosSt | Func::ProbedSt | Func::Steps => Kind::Steps,
        Func::Timer => Kind::Time,
        Func::Ain => Kind::Voltage,
        Func::Atan2 => Kind::Angle,
        Func::In | Func::Out | Func::ProbeOk | Func::Moving | Func::Homed | Func::TimedOut => {
            Kind::Truth
        }
        _ => Kind::Number,
    }
}
