//! What statements and expressions are like, as far as the graph asks.

use crate::front::ast::{BinaryOp, Expr, ExprKind, InputState, Machine, PrintPart};
use crate::front::words::Func;

/// Whether a statement moves an axis.
pub(in crate::front::check) fn moves(machine: &Machine) -> bool {
    matches!(
        machine,
        Machine::Move { .. }
            | Machine::MoveSpeed(..)
            | Machine::Home { .. }
            | Machine::Probe { .. }
            | Machine::ProbeMask { .. }
    )
}

/// Expressions of a machine statement in the order of evaluation.
pub(super) fn arguments(machine: &Machine) -> Vec<&Expr> {
    match machine {
        Machine::Move { target, speed, accel, decel, .. } => {
            core::iter::once(target).chain(speed).chain(accel).chain(decel).collect()
        }
        Machine::Probe { limit, speed, input, state, .. } => {
            [limit, speed].into_iter().chain(input).chain(state).collect()
        }
        Machine::ProbeMask { limit, speed, and, xor, .. } => vec![limit, speed, and, xor],
        Machine::Plain(_, list) => list.iter().collect(),
        Machine::SetAout(list) => list.iter().collect(),
        Machine::Sync { list, lead, .. } => list.iter().chain(lead).collect(),
        Machine::MoveSpeed(_, e) | Machine::SetPos(_, e) | Machine::Motors(e, _) => vec![e],
        Machine::WaitIn { input, state, timeout, .. } => {
            let level = match state {
                InputState::Level(e) => Some(e),
                InputState::Edge(_) => None,
            };
            core::iter::once(input).chain(level).chain(timeout).collect()
        }
        Machine::WaitChar { code, timeout, .. } => core::iter::once(code).chain(timeout).collect(),
        Machine::Print(parts) => parts
            .iter()
            .filter_map(|part| match part {
                PrintPart::Value(e, _) => Some(e),
                PrintPart::Text(_) => None,
            })
            .collect(),
        _ => Vec::new(),
    }
}

/// A condition that is written as true.
pub(super) fn is_true(e: &Expr) -> bool {
    matches!(e.kind, ExprKind::Literal { value, .. } if value != 0)
}

/// Whether evaluating it can raise a fault.
pub(super) fn may_fault(e: &Expr) -> bool {
    match &e.kind {
        ExprKind::Literal { .. } | ExprKind::Axis(_) | ExprKind::Name(_) => false,
        ExprKind::Apply(..) => true,
        ExprKind::Builtin(func, args) => {
            matches!(func, Func::Abs | Func::Sqr | Func::Steps | Func::Length)
                || args.iter().any(|arg| may_fault(arg) || matches!(arg.kind, ExprKind::Name(_)))
        }
        ExprKind::Unary(_, inner) => may_fault(inner),
        ExprKind::Binary(op, left, right) => {
            let safe = op.is_comparison()
                || matches!(
                    op,
                    BinaryOp::And
                        | BinaryOp::Or
                        | BinaryOp::Xor
                        | BinaryOp::AndAlso
                        | BinaryOp::OrElse
                );
            !safe || may_fault(left) || may_fault(right)
        }
    }
}
