//! Expressions: names, kinds, constants.

use super::names::{Entity, Symbol};
use super::{Checker, fold, kinds, range};
use crate::fault::Fault;
use crate::front::ast::{BinaryOp, Expr, ExprKind, Name, UnaryOp};
use crate::front::codes::Code;
use crate::front::span::Span;
use crate::front::words::{self, Func};
use crate::hir::{self, BinOp, RoutineId, TableId, UnOp, VarId};
use crate::kind::Kind;

/// A constant node.
pub(super) fn number(value: i32, kind: Kind, span: Span) -> hir::Expr {
    hir::Expr { kind, span: range(span), node: hir::ExprKind::Const(value) }
}

/// The constant that has this bit alone.
pub(super) fn mask(bit: u8, span: Span) -> hir::Expr {
    number((1_u32 << bit) as i32, Kind::Number, span)
}

/// The value of a constant node.
pub(super) fn value_of(expr: &hir::Expr) -> Option<i32> {
    match expr.node {
        hir::ExprKind::Const(value) => Some(value),
        _ => None,
    }
}

impl<'a> Checker<'a> {
    /// Checks an expression; None after an error.
    pub(super) fn expr(&mut self, expr: &'a Expr) -> Option<hir::Expr> {
        match &expr.kind {
            ExprKind::Literal { kind, value } => Some(number(*value, *kind, expr.span)),
            ExprKind::Name(name) => self.name(name, expr.span),
            ExprKind::Apply(name, args) => self.apply(name, args, expr.span),
            ExprKind::Builtin(func, args) => self.builtin(*func, args, expr.span),
            ExprKind::Axis(axis) => {
                let letter = axis.axis.letter();
                self.error(
                    Code::WrongUse,
                    expr.span,
                    format!("`{letter}` is an axis, not a value"),
                    format!("its position is `POS({letter})`"),
                );
                None
            }
            ExprKind::Unary(op, inner) => self.unary(*op, inner, expr.span),
            ExprKind::Binary(op, left, right) => {
                let left_value = self.expr(left);
                let right_value = self.expr(right);
                self.binary(*op, left_value?, right_value?, expr.span)
            }
        }
    }

    fn name(&mut self, name: &'a Name, span: Span) -> Option<hir::Expr> {
        let symbol = self.resolve_as(name, |text| match words::foreign_function(&name.key) {
            Some(hint) => hint.to_owned(),
            None if words::foreign_target(&name.key).is_some() => {
                "an input is read by `IN(n)`, an output by `OUT(n)`".to_owned()
            }
            None => format!("declare it first: `DIM {text}`"),
        })?;
        match symbol.entity {
            Entity::Const(kind, value) => Some(number(value?, kind, span)),
            Entity::Port(_, n) | Entity::Analog(_, n) => Some(number(n?, Kind::Number, span)),
            Entity::Var(var) if self.vars[var.0 as usize].array => {
                let hint = format!("write which value: `{}(0)`", symbol.text);
                self.error(Code::WrongUse, span, format!("`{}` is an array", symbol.text), hint);
                None
            }
            Entity::Var(var) if self.reader(var).is_some() => {
                self.reader(var).map(|id| self.reading(id, span))
            }
            Entity::Var(var) => {
                let kind = self.vars[var.0 as usize].kind;
                Some(hir::Expr { kind, span: range(span), node: hir::ExprKind::Var(var) })
            }
            Entity::Table(_) => {
                let hint = format!("write which value: `{}(0)`", symbol.text);
                self.error(Code::WrongUse, span, format!("`{}` is a table", symbol.text), hint);
                None
            }
            Entity::Routine(id) => self.function(id, &symbol, &[], span),
        }
    }

    fn apply(&mut self, name: &'a Name, args: &'a [Expr], span: Span) -> Option<hir::Expr> {
        if let Some(id) = self.edge(name) {
            return Some(self.reading(id, span));
        }
        if let Some(func) = Func::soft(&name.key)
            && self.names.look(self.scope, &name.key).is_none()
            && !self.script.lost.contains(&*name.key)
        {
            if args.len() == func.args().len() {
                return self.builtin(func, args, span);
            }
            let wanted = func.args().len();
            let plural = if wanted == 1 { "" } else { "s" };
            let message =
                format!("{} takes {wanted} argument{plural}, not {}", func.text(), args.len());
            self.error(Code::WrongCount, span, message, format!("its form is `{}`", func.usage()));
            return None;
        }
        let symbol = self.resolve_as(name, |text| match words::foreign_function(&name.key) {
            Some(hint) => hint.to_owned(),
            None => format!(
                "an array is declared by `DIM {text}(8)`, a function by `FUNCTION {text}(n)`"
            ),
        })?;
        match symbol.entity {
            Entity::Var(var) => self.element(var, &symbol, args, span),
            Entity::Table(id) => self.table_value(id, &symbol, args, span),
            Entity::Routine(id) => self.function(id, &symbol, args, span),
            Entity::Const(..) | Entity::Port(..) | Entity::Analog(..) => {
                let hint = format!("write `{}` alone", symbol.text);
                let message = format!("`{}` is a constant; it has no parts", symbol.text);
                self.error(Code::WrongUse, span, message, hint);
                None
            }
        }
    }

    /// `array(i)`; also the place of an assignment.
    pub(super) fn index(
        &mut self,
        var: VarId,
        symbol: &Symbol<'a>,
        args: &'a [Expr],
        span: Span,
    ) -> Option<hir::Expr> {
        let len = self.vars[var.0 as usize].len;
        if !self.vars[var.0 as usize].array {
            let message = format!("`{}` is not an array", symbol.text);
            let hint = format!("declare it with a size: `DIM {}(8)`", symbol.text);
            self.error(Code::WrongUse, span, message, hint);
            return None;
        }
        let [arg] = args else {
            let message = format!("`{}` has one index, not {}", symbol.text, args.len());
            let hint =
                "arrays have one dimension: `a(row * columns + column)`; a TABLE has columns";
            self.error(Code::WrongCount, span, message, hint);
            return None;
        };
        let index = self.plain(arg, "an index")?;
        if let Some(i) = value_of(&index)
            && !(0..i64::from(len)).contains(&i64::from(i))
        {
            self.error(
                Code::IndexRange,
                arg.span,
                format!("`{}` has no value {i}", symbol.text),
                format!("its values are {0}(0) to {0}({1})", symbol.text, len - 1),
            );
            return None;
        }
        Some(index)
    }

    fn element(
        &mut self,
        var: VarId,
        symbol: &Symbol<'a>,
        args: &'a [Expr],
        span: Span,
    ) -> Option<hir::Expr> {
        let index = self.index(var, symbol, args, span)?;
        let kind = self.vars[var.0 as usize].kind;
        let node = hir::ExprKind::Elem(var, Box::new(index));
        Some(hir::Expr { kind, span: range(span), node })
    }

    /// The column of a table that an index names.
    pub(super) fn named_column(&self, id: TableId, index: &Expr) -> Option<usize> {
        let table = &self.tables[id.0 as usize];
        match &index.kind {
            ExprKind::Name(name) => table.column(&name.key),
            ExprKind::Axis(axis) => table.column(&axis.axis.letter().to_string()),
            _ => None,
        }
    }

    fn table_value(
        &mut self,
        id: TableId,
        symbol: &Symbol<'a>,
        args: &'a [Expr],
        span: Span,
    ) -> Option<hir::Expr> {
        let table = &self.tables[id.0 as usize];
        let (columns, rows) =
            (table.columns as i32, table.values.len() as i32 / table.columns as i32);
        let kinds = table.kinds.clone();
        if args.len() != if columns == 1 { 1 } else { 2 } {
            let hint = if columns == 1 { "(row)" } else { "(row, column)" };
            self.error(
                Code::WrongCount,
                span,
                format!("`{}` has {columns} column(s)", symbol.text),
                format!("write `{}{hint}`", symbol.text),
            );
            return None;
        }
        let row = self.plain(args.first()?, "a row")?;
        let named = args.get(1).and_then(|index| self.named_column(id, index));
        let column = match (args.get(1), named) {
            (Some(index), Some(n)) => number(n as i32, Kind::Number, index.span),
            (Some(index), None) => self.plain(index, "a column")?,
            (None, _) => number(0, Kind::Number, span),
        };
        for (index, count, what) in [(&row, rows, "row"), (&column, columns, "column")] {
            if let Some(i) = value_of(index)
                && !(0..count).contains(&i)
            {
                let place = Span::new(index.span.start as u32, index.span.end as u32);
                let message = format!("`{}` has no {what} {i}", symbol.text);
                self.error(
                    Code::IndexRange,
                    place,
                    message,
                    format!("they count from 0 to {}", count - 1),
                );
                return None;
            }
        }
        let kind = match value_of(&column) {
            Some(i) => kinds[i as usize],
            None => {
                let mut distinct = kinds.clone();
                distinct.dedup();
                if let [kind] = distinct[..] {
                    kind
                } else {
                    let message = format!("the columns of `{}` have different kinds", symbol.text);
                    let hint = "the column must be a constant here";
                    self.error(Code::TableKinds, span, message, hint);
                    return None;
                }
            }
        };
        let node = hir::ExprKind::Table { table: id, row: Box::new(row), column: Box::new(column) };
        Some(hir::Expr { kind, span: range(span), node })
    }

    fn function(
        &mut self,
        id: RoutineId,
        symbol: &Symbol<'a>,
        args: &'a [Expr],
        span: Span,
    ) -> Option<hir::Expr> {
        let Some(kind) = self.infos[id.0 as usize].result else {
            let message = format!("`{}` is a SUB and has no value", symbol.text);
            self.error(Code::WrongUse, span, message, "make it a FUNCTION with RETURN value");
            return None;
        };
        let args = self.arguments(id, args, span)?;
        Some(hir::Expr { kind, span: range(span), node: hir::ExprKind::Call(id, args) })
    }

    /// Arguments of a SUB or FUNCTION.
    pub(super) fn arguments(
        &mut self,
        id: RoutineId,
        args: &'a [Expr],
        span: Span,
    ) -> Option<Vec<hir::Expr>> {
        let routine = self.routine(id)?;
        let name = &routine.name.text;
        if args.len() != routine.params.len() {
            let params: Vec<&str> = routine.params.iter().map(|p| &*p.name.text).collect();
            self.error(
                Code::WrongCount,
                span,
                format!("`{name}` takes {} arguments, not {}", params.len(), args.len()),
                format!("its form is `{name}({})`", params.join(", ")),
            );
            return None;
        }
        let mut values = Vec::with_capacity(args.len());
        for (i, (arg, param)) in args.iter().zip(&routine.params).enumerate() {
            let value = self.expr(arg);
            let var = self.infos[id.0 as usize].params[i];
            let wanted = self.vars[var.0 as usize].kind;
            let Some(value) = value else { continue };
            if !kinds::fits(wanted, value.kind) {
                let what = format!("parameter `{}` of `{name}`", param.name.text);
                self.wrong_kind(&what, &[wanted], arg, value.kind);
                continue;
            }
            values.push(value);
        }
        (values.len() == args.len()).then_some(values)
    }

    fn unary(&mut self, op: UnaryOp, inner: &'a Expr, span: Span) -> Option<hir::Expr> {
        if let UnaryOp::Bit(bit) = op {
            let value = self.plain(inner, &format!("`.{bit}`"))?;
            let and = self.make_binary(BinOp::And, Kind::Number, value, mask(bit, span), span)?;
            return self.make_binary(
                BinOp::Ne,
                Kind::Truth,
                and,
                number(0, Kind::Number, span),
                span,
            );
        }
        let inner = self.expr(inner)?;
        let (op, kind) = match op {
            UnaryOp::Neg if inner.kind == Kind::Truth => (UnOp::Neg, Kind::Number),
            UnaryOp::Neg => (UnOp::Neg, inner.kind),
            UnaryOp::Not if inner.kind == Kind::Truth => (UnOp::LogNot, Kind::Truth),
            UnaryOp::Not if inner.kind == Kind::Number => (UnOp::BitNot, Kind::Number),
            _ => {
                let message = format!("NOT of {}", kinds::a(inner.kind));
                self.error(
                    Code::KindMismatch,
                    span,
                    message,
                    "NOT takes a Truth or a Number: compare first",
                );
                return None;
            }
        };
        self.make_unary(op, kind, inner, span)
    }

    /// An operation of one operand, folded where that is constant.
    pub(super) fn make_unary(
        &mut self,
        op: UnOp,
        kind: Kind,
        inner: hir::Expr,
        span: Span,
    ) -> Option<hir::Expr> {
        match value_of(&inner) {
            Some(value) => self.folded(fold::unary(op, value), kind, span),
            None => {
                let node = hir::ExprKind::Unary(op, Box::new(inner));
                Some(hir::Expr { kind, span: range(span), node })
            }
        }
    }

    /// A constant result, or the fault that it would be at run time.
    pub(super) fn folded(
        &mut self,
        result: Result<i32, Fault>,
        kind: Kind,
        span: Span,
    ) -> Option<hir::Expr> {
        match result {
            Ok(value) => Some(number(value, kind, span)),
            Err(fault) => {
                let message = format!("this is always {fault}: {}", fault.text());
                // What follows a semicolon is about axes, which no constant moves.
                let remedy = remedy(fault);
                let hint = remedy.split("; ").next().unwrap_or_default();
                self.error(Code::ConstantFault, span, message, hint);
                None
            }
        }
    }

    fn binary(
        &mut self,
        op: BinaryOp,
        left: hir::Expr,
        right: hir::Expr,
        span: Span,
    ) -> Option<hir::Expr> {
        let Some(kind) = kinds::binary(op, left.kind, right.kind) else {
            let message = format!(
                "`{}` between {} and {}",
                op.symbol(),
                kinds::a(left.kind),
                kinds::a(right.kind)
            );
            self.error(Code::KindMismatch, span, message, kinds::remedy(op, left.kind, right.kind));
            return None;
        };
        let op = match op {
            BinaryOp::AndAlso | BinaryOp::OrElse => {
                return Some(short_circuit(op, left, right, span));
            }
            BinaryOp::Or => BinOp::Or,
            BinaryOp::Xor => BinOp::Xor,
            BinaryOp::And => BinOp::And,
            BinaryOp::Eq => BinOp::Eq,
            BinaryOp::Ne => BinOp::Ne,
            BinaryOp::Lt => BinOp::Lt,
            BinaryOp::Le => BinOp::Le,
            BinaryOp::Gt => BinOp::Gt,
            BinaryOp::Ge => BinOp::Ge,
            BinaryOp::Shl => BinOp::Shl,
            BinaryOp::Shr => BinOp::Shr,
            BinaryOp::Add => BinOp::Add,
            BinaryOp::Sub => BinOp::Sub,
            BinaryOp::Mul => BinOp::Mul,
            BinaryOp::Div => BinOp::Div,
            BinaryOp::Mod => BinOp::Mod,
        };
        self.make_binary(op, kind, left, right, span)
    }

    /// An operation of two operands, folded where both are constant.
    pub(super) fn make_binary(
        &mut self,
        op: BinOp,
        kind: Kind,
        left: hir::Expr,
        right: hir::Expr,
        span: Span,
    ) -> Option<hir::Expr> {
        if let (Some(a), Some(b)) = (value_of(&left), value_of(&right)) {
            return self.folded(fold::binary(op, a, b), kind, span);
        }
        let node = hir::ExprKind::Binary(op, Box::new(left), Box::new(right));
        Some(self.rounded(op, hir::Expr { kind, span: range(span), node }))
    }
}

/// A fault's remedy as a hint: without capital letter and full stop.
pub(super) fn remedy(fault: Fault) -> String {
    let text = fault.remedy().trim_end_matches('.');
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}

/// ANDALSO and ORELSE; a constant left side settles them.
fn short_circuit(op: BinaryOp, left: hir::Expr, right: hir::Expr, span: Span) -> hir::Expr {
    let and = op == BinaryOp::AndAlso;
    match (value_of(&left), value_of(&right)) {
        (Some(0), _) if and => return number(0, Kind::Truth, span),
        (Some(a), _) if !and && a != 0 => return number(1, Kind::Truth, span),
        (Some(_), Some(b)) => return number(i32::from(b != 0), Kind::Truth, span),
        _ => {}
    }
    let (left, right) = (Box::new(left), Box::new(right));
    let node = match and {
        true => hir::ExprKind::AndAlso(left, right),
        false => hir::ExprKind::OrElse(left, right),
    };
    hir::Expr { kind: Kind::Truth, span: range(span), node }
}
