//! Functions of the language: their arguments, what they read, what is known before the run.

use super::expr::{number, value_of};
use super::names::Entity;
use super::{Checker, MAIN, clocks, fold, kinds, range};
use crate::axis::Axis;
use crate::front::ast::{BinaryOp, Expr, ExprKind};
use crate::front::codes::Code;
use crate::front::diag::Diag;
use crate::front::parser::TIMED_OUT;
use crate::front::span::Span;
use crate::front::words::Func;
use crate::hir::{self, BinOp, ReadKind, UnOp, VarId};
use crate::kind::Kind;

impl<'a> Checker<'a> {
    /// A call of a function.
    pub(super) fn builtin(
        &mut self,
        func: Func,
        args: &'a [Expr],
        span: Span,
    ) -> Option<hir::Expr> {
        let read = |read: ReadKind| {
            let node = hir::ExprKind::Read(read);
            Some(hir::Expr { kind: kinds::func_kind(func), span: range(span), node })
        };
        let plain = |node: hir::ExprKind| {
            Some(hir::Expr { kind: kinds::func_kind(func), span: range(span), node })
        };
        match func {
            Func::CharIn => read(ReadKind::CharIn),
            Func::InPort => read(ReadKind::InPort),
            Func::Timer => Some(clocks::timer(span)),
            Func::TimedOut => match self.timed_out() {
                Some(var) => plain(hir::ExprKind::Var(var)),
                None => read(ReadKind::TimedOut),
            },
            Func::Err => plain(hir::ExprKind::Err),
            Func::Erl => plain(hir::ExprKind::Erl),
            Func::In => read(ReadKind::In(Box::new(self.port(args.first()?, false)?))),
            Func::Ain => read(ReadKind::Analog(self.analog(args.first()?)?)),
            Func::Out => read(ReadKind::Out(Box::new(self.port(args.first()?, true)?))),
            Func::Pos => read(ReadKind::Pos(self.axis_argument(args)?)),
            Func::PosSt => read(ReadKind::PosSteps(self.axis_argument(args)?)),
            Func::Probed => read(ReadKind::Probed(self.axis_argument(args)?)),
            Func::ProbedSt => read(ReadKind::ProbedSteps(self.axis_argument(args)?)),
            Func::ProbeOk => read(ReadKind::ProbeOk(self.axis_argument(args)?)),
            Func::Moving => read(ReadKind::Moving(self.axis_argument(args)?)),
            Func::Homed => read(ReadKind::Homed(self.axis_argument(args)?)),
            Func::Count => self.count(args.first()?, span),
            Func::Steps | Func::Length => self.conversion(func, args, span),
            Func::Abs => {
                let value = self.expr(args.first()?)?;
                let kind = value.kind;
                self.make_unary(UnOp::Abs, kind, value, span)
            }
            Func::Sgn => {
                let value = self.expr(args.first()?)?;
                self.make_unary(UnOp::Sgn, Kind::Number, value, span)
            }
            Func::Sqr => {
                let value = self.plain(args.first()?, "SQR")?;
                self.make_unary(UnOp::Sqr, Kind::Number, value, span)
            }
            Func::Sin | Func::Cos | Func::Atan2 | Func::Scale => self.turning(func, args, span),
            Func::Min | Func::Max => {
                let [left, right] = args else { return None };
                let left = self.expr(left);
                let right = self.expr(right);
                let (left, right) = (left?, right?);
                let Some(kind) = kinds::extreme(left.kind, right.kind) else {
                    let message = format!(
                        "{} of {} and {}",
                        func.text(),
                        kinds::a(left.kind),
                        kinds::a(right.kind)
                    );
                    let hint = kinds::remedy(BinaryOp::Add, left.kind, right.kind);
                    self.error(Code::KindMismatch, span, message, hint);
                    return None;
                };
                let op = if func == Func::Min { BinOp::Min } else { BinOp::Max };
                self.make_binary(op, kind, left, right, span)
            }
        }
    }

    /// The variable that holds TIMEDOUT where a WAIT UNTIL sets it too.
    pub(super) fn timed_out(&mut self) -> Option<VarId> {
        match self.names.take(MAIN, TIMED_OUT)?.entity {
            Entity::Var(var) => Some(var),
            _ => None,
        }
    }

    fn axis_argument(&mut self, args: &'a [Expr]) -> Option<Axis> {
        match &args.first()?.kind {
            ExprKind::Axis(axis) => self.axis(*axis),
            _ => None,
        }
    }

    fn count(&mut self, arg: &'a Expr, span: Span) -> Option<hir::Expr> {
        if let ExprKind::Name(name) = &arg.kind {
            let symbol = self.resolve(name)?;
            if let Entity::Table(id) = symbol.entity {
                let table = &self.tables[id.0 as usize];
                let rows = table.values.len() / table.columns.max(1) as usize;
                return Some(number(rows as i32, Kind::Number, span));
            }
            let text = symbol.text;
            let what = match symbol.entity {
                Entity::Var(var) if self.vars[var.0 as usize].array => {
                    let len = self.vars[var.0 as usize].len;
                    let hint = format!("it has as many values as its DIM says: write `{len}`");
                    Some(("an array", hint, Some(len.to_string())))
                }
                Entity::Port(false, _) => Some((
                    "an input",
                    format!("its edges are counted by `ON IN {text} RISE GOSUB label`"),
                    None,
                )),
                _ => None,
            };
            if let Some((what, hint, instead)) = what {
                let message = format!("COUNT takes the name of a TABLE, and `{text}` is {what}");
                let diag = Diag::new(Code::WrongUse, arg.span, message).hint(hint);
                self.diags.push(match instead {
                    Some(len) => diag.fix(span, len),
                    None => diag,
                });
                return None;
            }
        }
        self.error(
            Code::WrongUse,
            arg.span,
            "COUNT takes the name of a TABLE",
            "write `COUNT(table)`",
        );
        None
    }

    /// STEPS and LENGTH.
    fn conversion(&mut self, func: Func, args: &'a [Expr], span: Span) -> Option<hir::Expr> {
        let axis = self.axis_argument(args);
        let arg = args.get(1)?;
        let value = self.expr(arg)?;
        let (wanted, kind) = match func {
            Func::Steps => (Kind::Length, Kind::Steps),
            _ => (Kind::Steps, Kind::Length),
        };
        if value.kind != wanted {
            self.wrong_kind(func.text(), &[wanted], arg, value.kind);
            return None;
        }
        let axis = axis?;
        let scale = self.profile.axis(axis)?.scale;
        if let Some(constant) = value_of(&value) {
            let result = match func {
                Func::Steps => fold::to_steps(scale, constant),
                _ => fold::to_length(scale, constant),
            };
            return self.folded(result, kind, span);
        }
        let node = match func {
            Func::Steps => hir::ExprKind::ToSteps(axis, Box::new(value)),
            _ => hir::ExprKind::ToLength(axis, Box::new(value)),
        };
        Some(hir::Expr { kind, span: range(span), node })
    }
}
