//! Bits of a Number that are written: `n.3 = ON` is `n = n OR 8`.

use super::expr::{mask, number, value_of};
use super::{Checker, kinds, range};
use crate::front::ast::{Expr, Name, Stmt};
use crate::front::codes::Code;
use crate::front::span::Span;
use crate::hir::{self, Arm, BinOp, ExprKind, Place, StmtKind};
use crate::kind::Kind;

impl<'a> Checker<'a> {
    /// `name.bit = value`: the value first, then the rest of the Number as it is by then.
    pub(super) fn assign_bit(
        &mut self,
        target: &'a Name,
        index: &'a [Expr],
        bit: u8,
        value: &'a Expr,
        stmt: &Stmt,
    ) -> Option<StmtKind> {
        let place = self.place(target, index);
        let value = self.condition(value, "the state of a bit");
        let ((place, kind), value) = (place?, value?);
        let name = &target.text;
        if kind != Kind::Number {
            let message = format!("`{name}.{bit}`: `{name}` is {}, not a Number", kinds::a(kind));
            let hint = "only Numbers have bits: declare it `AS NUMBER`";
            self.error(Code::AssignKind, target.span, message, hint);
            return None;
        }
        if let Place::Elem(_, at) = &place
            && !is_steady(at)
        {
            let message = "this index is evaluated twice to write one bit";
            let span = Span::new(at.span.start as u32, at.span.end as u32);
            let hint = format!("put it into a variable first: `i = ...`, `{name}(i).{bit} = ...`");
            self.error(Code::WrongUse, span, message, hint);
            return None;
        }
        let on = write(&place, bit, true, target.span);
        let off = write(&place, bit, false, target.span);
        if let Some(value) = value_of(&value) {
            return Some(if value != 0 { on } else { off });
        }
        let body = |kind| vec![hir::Stmt { line: stmt.line, span: range(stmt.span), kind }];
        let arms = vec![Arm { line: stmt.line, condition: value, body: body(on) }];
        Some(StmtKind::If { arms, otherwise: body(off), one_line: false })
    }
}

/// `n = n OR mask`, or `n = n AND NOT mask`.
fn write(place: &Place, bit: u8, on: bool, span: Span) -> StmtKind {
    let node = match place {
        Place::Var(var) => ExprKind::Var(*var),
        Place::Elem(var, at) => ExprKind::Elem(*var, at.clone()),
    };
    let old = hir::Expr { kind: Kind::Number, span: range(span), node };
    let mask = mask(bit, span);
    let (op, mask) = match on {
        true => (BinOp::Or, mask),
        false => (BinOp::And, number(!value_of(&mask).unwrap_or(0), Kind::Number, span)),
    };
    let node = ExprKind::Binary(op, Box::new(old), Box::new(mask));
    StmtKind::Assign(place.clone(), hir::Expr { kind: Kind::Number, span: range(span), node })
}

/// Whether an index is the same when it is evaluated again: variables, constants and their sums.
fn is_steady(index: &hir::Expr) -> bool {
    match &index.node {
        ExprKind::Const(_) | ExprKind::Var(_) => true,
        ExprKind::Unary(_, inner) => is_steady(inner),
        ExprKind::Binary(_, left, right) => is_steady(left) && is_steady(right),
        _ => false,
    }
}
