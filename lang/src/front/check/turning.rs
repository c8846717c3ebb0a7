//! SIN, COS, ATAN2 and SCALE, which are functions where nothing of the script has the name.

use super::expr::value_of;
use super::{Checker, kinds, range};
use crate::front::ast::{BinaryOp, Expr};
use crate::front::codes::Code;
use crate::front::span::Span;
use crate::front::words::Func;
use crate::hir::{self, BinOp, UnOp};
use crate::kind::Kind;
use crate::trig;

impl<'a> Checker<'a> {
    /// One of these functions, with as many arguments as it has.
    pub(super) fn turning(
        &mut self,
        func: Func,
        args: &'a [Expr],
        span: Span,
    ) -> Option<hir::Expr> {
        match (func, args) {
            (Func::Sin | Func::Cos, [arg]) => {
                let angle = self.expr(arg)?;
                if angle.kind != Kind::Angle {
                    self.wrong_kind(func.text(), &[Kind::Angle], arg, angle.kind);
                    return None;
                }
                let op = if func == Func::Sin { UnOp::Sin } else { UnOp::Cos };
                self.make_unary(op, Kind::Number, angle, span)
            }
            (Func::Atan2, [y, x]) => {
                let (y, x) = (self.expr(y), self.expr(x));
                let (y, x) = (y?, x?);
                self.alike(func, &y, &x, span)?;
                self.make_binary(BinOp::Atan2, Kind::Angle, y, x, span)
            }
            (Func::Scale, [v, a, b, c, d]) => {
                let parts = [v, a, b, c, d].map(|arg| self.expr(arg));
                let [Some(v), Some(a), Some(b), Some(c), Some(d)] = parts else { return None };
                self.scale(v, [a, b], [c, d], args, span)
            }
            _ => None,
        }
    }

    /// `c + (v - a) * (d - c) / (b - a)`, the product with 64 bits. The limits stand in it twice.
    fn scale(
        &mut self,
        v: hir::Expr,
        [a, b]: [hir::Expr; 2],
        [c, d]: [hir::Expr; 2],
        args: &'a [Expr],
        span: Span,
    ) -> Option<hir::Expr> {
        self.alike(Func::Scale, &v, &a, span)?;
        self.alike(Func::Scale, &a, &b, span)?;
        self.alike(Func::Scale, &c, &d, span)?;
        let limits = [&a, &b, &c, &d];
        if let Some(n) = limits.iter().position(|limit| !limit.is_simple()) {
            let message = "a limit of SCALE is a constant or a variable";
            let hint = "put the value into a variable first: `lo = ...`";
            self.error(Code::NotConstant, args[n + 1].span, message, hint);
            return None;
        }
        let kind = if c.kind == Kind::Truth { Kind::Number } else { c.kind };
        let value = self.make_binary(BinOp::Sub, v.kind, v, a.clone(), span)?;
        let times = self.make_binary(BinOp::Sub, kind, d, c.clone(), span)?;
        let over = self.make_binary(BinOp::Sub, a.kind, b, a, span)?;
        let known = [value_of(&value), value_of(&times), value_of(&over)];
        let part = match known {
            [Some(value), Some(times), Some(over)] => {
                self.folded(trig::mul_div(value, times, over, trig::wide), kind, span)?
            }
            [_, _, Some(0)] => self.folded(trig::mul_div(1, 1, 0, trig::wide), kind, span)?,
            _ => {
                let node = hir::ExprKind::MulDiv(Box::new([value, times, over]));
                hir::Expr { kind, span: range(span), node }
            }
        };
        self.make_binary(BinOp::Add, kind, part, c, span)
    }

    /// Two values of one kind, or an error.
    fn alike(&mut self, func: Func, left: &hir::Expr, right: &hir::Expr, span: Span) -> Option<()> {
        if kinds::extreme(left.kind, right.kind).is_some() {
            return Some(());
        }
        let pair = (kinds::a(left.kind), kinds::a(right.kind));
        let message = format!("{} of {} and {}", func.text(), pair.0, pair.1);
        let hint = kinds::remedy(BinaryOp::Add, left.kind, right.kind);
        self.error(Code::KindMismatch, span, message, hint);
        None
    }
}
