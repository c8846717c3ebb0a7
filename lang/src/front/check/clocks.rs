//! Readings of TIMER and what is counted from them.
//!
//! The boards count a run's milliseconds in 32 bits, which wrap after 49.7 days; sums of the language fault where
//! they do not fit into 32 bits. So that a reading can be counted from for ever, TIMER gives the low 31 bits as a number
//! with its sign, and a sum or difference with a reading in it is brought back to 31 bits the same way: the difference
//! of two readings fits into 32 bits then, and is right modulo 2^31 ms, which is 24.8 days. What fits into 12.4 days is
//! unchanged. `<< 1` drops a bit and `>> 1` brings back the sign: no part needs an instruction of its own for it, and
//! all engines compute the same.
//!
//! Sums of plain Times still fault. The text decides what is a reading: TIMER, a variable or parameter to which a
//! reading is assigned anywhere, and a reading more or less a Time. The difference of two readings is a Time.

use std::collections::HashSet;

use super::names::Entity;
use super::{Checker, range};
use crate::front::ast::{BinaryOp, Block, Expr, ExprKind, StmtKind};
use crate::front::span::Span;
use crate::front::words::Func;
use crate::hir::{self, BinOp, ReadKind, RoutineId, VarId};
use crate::kind::Kind;

/// What is assigned where.
type Assigned<'a> = (RoutineId, VarId, &'a Expr);

impl<'a> Checker<'a> {
    /// Finds the variables and parameters that hold readings.
    pub(super) fn find_clocks(&mut self) {
        let mut assigned = Vec::new();
        for (scope, body) in self.bodies() {
            self.assignments(scope, body, &mut assigned);
        }
        // Each round follows one assignment more; what is read directly comes first, so that the difference of two
        // readings is known as such.
        let direct = |value: &Expr| matches!(value.kind, ExprKind::Builtin(Func::Timer, _));
        self.clocks =
            assigned.iter().filter(|(_, _, value)| direct(value)).map(|(_, var, _)| *var).collect();
        loop {
            let more: HashSet<VarId> = assigned
                .iter()
                .filter(|(scope, var, value)| {
                    !self.clocks.contains(var) && self.is_reading(*scope, value)
                })
                .map(|(_, var, _)| *var)
                .collect();
            if more.is_empty() {
                return;
            }
            self.clocks.extend(more);
        }
    }

    fn assignments(&self, scope: RoutineId, block: &'a Block, into: &mut Vec<Assigned<'a>>) {
        for stmt in block {
            match &stmt.kind {
                StmtKind::Assign { target, value, bit: None, .. } => {
                    if let Some(Entity::Var(var)) = self.names.look(scope, &target.key) {
                        into.push((scope, var, value));
                    }
                }
                StmtKind::Call { name, args } => {
                    if let Some(Entity::Routine(id)) = self.names.look(scope, &name.key) {
                        let params = self.infos[id.0 as usize].params.iter();
                        into.extend(params.zip(args).map(|(param, arg)| (scope, *param, arg)));
                    }
                }
                _ => {}
            }
            for inner in stmt.blocks() {
                self.assignments(scope, inner, into);
            }
        }
    }

    /// Whether the value is a reading, by the variables that are known to hold some.
    fn is_reading(&self, scope: RoutineId, value: &Expr) -> bool {
        match &value.kind {
            ExprKind::Builtin(Func::Timer, _) => true,
            ExprKind::Builtin(Func::Min | Func::Max, list) => {
                list.iter().any(|value| self.is_reading(scope, value))
            }
            ExprKind::Name(name) | ExprKind::Apply(name, _) => {
                match self.names.look(scope, &name.key) {
                    Some(Entity::Var(var)) => self.clocks.contains(&var),
                    _ => false,
                }
            }
            ExprKind::Binary(op @ (BinaryOp::Add | BinaryOp::Sub), left, right) => {
                let sides = [left, right].map(|side| self.is_reading(scope, side));
                reads(*op == BinaryOp::Sub, sides)
            }
            _ => false,
        }
    }

    /// The same of a checked one.
    fn is_clock(&self, value: &hir::Expr) -> bool {
        match &value.node {
            hir::ExprKind::Read(ReadKind::Timer) => true,
            hir::ExprKind::Var(var) | hir::ExprKind::Elem(var, _) => self.clocks.contains(var),
            hir::ExprKind::Binary(BinOp::Min | BinOp::Max, left, right) => {
                self.is_clock(left) || self.is_clock(right)
            }
            hir::ExprKind::Binary(op @ (BinOp::Add | BinOp::Sub), left, right) => {
                reads(*op == BinOp::Sub, [left, right].map(|side| self.is_clock(side)))
            }
            // What `round` has made.
            hir::ExprKind::Binary(BinOp::Shr | BinOp::Shl, value, by) => {
                by.constant() == Some(1) && value.kind == Kind::Time && self.is_clock(value)
            }
            _ => false,
        }
    }

    /// Brings a sum or difference of Times with a reading in it back to 31 bits.
    pub(super) fn rounded(&self, op: BinOp, sum: hir::Expr) -> hir::Expr {
        let hir::ExprKind::Binary(_, left, right) = &sum.node else { return sum };
        let counts = matches!(op, BinOp::Add | BinOp::Sub) && sum.kind == Kind::Time;
        if counts && (self.is_clock(left) || self.is_clock(right)) { round(sum) } else { sum }
    }
}

/// Whether a sum, or a difference, with readings on these sides is one.
fn reads(difference: bool, [left, right]: [bool; 2]) -> bool {
    if difference { left != right } else { left || right }
}

/// TIMER.
pub(super) fn timer(span: Span) -> hir::Expr {
    let node = hir::ExprKind::Read(ReadKind::Timer);
    round(hir::Expr { kind: Kind::Time, span: range(span), node })
}

/// A value's low 31 bits as a number with its sign.
fn round(value: hir::Expr) -> hir::Expr {
    let span = value.span.clone();
    let shift = |op: BinOp, value: hir::Expr| {
        let one =
            hir::Expr { kind: Kind::Number, span: span.clone(), node: hir::ExprKind::Const(1) };
        let node = hir::ExprKind::Binary(op, Box::new(value), Box::new(one));
        hir::Expr { kind: Kind::Time, span: span.clone(), node }
    };
    shift(BinOp::Shr, shift(BinOp::Shl, value))
}
