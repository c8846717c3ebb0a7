//! Arguments of statements and functions: which kind is asked for, and what to write instead.

use super::{Checker, kinds};
use crate::front::ast::{BinaryOp, Expr, ExprKind, UnaryOp};
use crate::front::codes::Code;
use crate::front::diag::Diag;
use crate::front::span::Span;
use crate::hir;
use crate::kind::Kind;

/// A Length or a place in Steps.
pub(super) const PLACE: &[Kind] = &[Kind::Length, Kind::Steps];
/// A speed in either form.
pub(super) const SPEED: &[Kind] = &[Kind::Speed, Kind::StepRate];
/// An acceleration in either form.
pub(super) const ACCEL: &[Kind] = &[Kind::Accel, Kind::StepAccel];
/// How far before a place of the path.
pub(super) const LEAD: &[Kind] = &[Kind::Time, Kind::Length];
/// A duration.
pub(super) const TIME: &[Kind] = &[Kind::Time];

impl<'a> Checker<'a> {
    /// An expression of one of `wanted`.
    pub(super) fn quantity(
        &mut self,
        expr: &'a Expr,
        wanted: &[Kind],
        what: &str,
    ) -> Option<hir::Expr> {
        let value = self.expr(expr)?;
        if wanted.contains(&value.kind) {
            return Some(value);
        }
        self.wrong_kind(what, wanted, expr, value.kind);
        None
    }

    /// A Number, or a Truth where one serves.
    pub(super) fn plain(&mut self, expr: &'a Expr, what: &str) -> Option<hir::Expr> {
        let value = self.expr(expr)?;
        if kinds::is_plain(value.kind) {
            return Some(value);
        }
        self.wrong_kind(what, &[Kind::Number], expr, value.kind);
        None
    }

    /// Says that something of another kind is needed, and how to write it.
    pub(super) fn wrong_kind(&mut self, what: &str, wanted: &[Kind], expr: &'a Expr, found: Kind) {
        if self.decimal_comma(expr, found) {
            return;
        }
        let text = self.shown(expr);
        let names: Vec<String> = wanted.iter().map(|&kind| kinds::a(kind)).collect();
        let names = names.join(" or ");
        let (message, hint) = match (found, wanted) {
            (Kind::Number, [Kind::Truth]) => (
                format!("{what} needs a Truth, {text} is a Number"),
                "compare it: `x <> 0`".to_owned(),
            ),
            (Kind::Number | Kind::Truth, _) => {
                let examples: Vec<String> =
                    wanted.iter().flat_map(|&kind| with_unit(kind, expr)).collect();
                (
                    format!("{what} needs {names}, {text} is a {found}"),
                    format!("write {}", examples.join(" or ")),
                )
            }
            (Kind::Length, [Kind::Steps]) | (Kind::StepRate, [Kind::Speed]) => (
                format!("{what} needs {names}, {text} is {}", kinds::a(found)),
                "convert it: `STEPS(X, length)`".to_owned(),
            ),
            (Kind::Steps, [Kind::Length]) => (
                format!("{what} needs {names}, {text} is {}", kinds::a(found)),
                "convert it: `LENGTH(X, steps)`".to_owned(),
            ),
            (_, [kind]) if kinds::is_plain(*kind) => (
                format!("{what} needs {names}, {text} is {}", kinds::a(found)),
                format!("divide it by `{}` to make it a Number", kinds::unit_of(found)),
            ),
            _ => {
                let examples: Vec<String> = wanted
                    .iter()
                    .map(|&kind| format!("`{}`", crate::front::literal::example(kind)))
                    .collect();
                (
                    format!("{what} needs {names}, {text} is {}", kinds::a(found)),
                    format!("write a value like {}", examples.join(" or ")),
                )
            }
        };
        let mut diag = Diag::new(Code::ArgumentKind, expr.span, message).hint(hint);
        if let (Kind::Number, ExprKind::Literal { value, .. }, Some(unit)) =
            (found, &expr.kind, wanted.first().and_then(|&kind| units(kind).first()))
        {
            diag = diag.fix(expr.span, format!("{value}{unit}"));
        }
        self.diags.push(diag);
    }

    /// Whether a value is one side of `2,5mm`; reported at the first one.
    fn decimal_comma(&mut self, expr: &'a Expr, found: Kind) -> bool {
        let ExprKind::Literal { .. } = expr.kind else { return false };
        let bytes = self.text.as_bytes();
        let digit = |at: u32| bytes.get(at as usize).is_some_and(u8::is_ascii_digit);
        let comma = |at: u32| bytes.get(at as usize) == Some(&b',');
        let Span { start, end } = expr.span;
        if found == Kind::Number && comma(end) && digit(end + 1) {
            let comma = Span::new(end, end + 1);
            let rest = self.text.get(end as usize + 1..).unwrap_or("");
            let decimals = rest.bytes().take_while(|b| b.is_ascii_digit()).count();
            let unit = crate::front::literal::unit_length(&rest[decimals..]).unwrap_or(0);
            let meant = format!("{}.{}", expr.span.of(self.text), &rest[..decimals + unit]);
            let message = "a comma stands in a number: it separates arguments";
            let diag = Diag::new(Code::BadNumber, comma, message)
                .hint(format!("decimals have a point: `{meant}`"));
            self.diags.push(diag.fix(comma, "."));
            self.after_comma = end + 1;
            return true;
        }
        // The decimals, and what they push into the place of another argument.
        let line = |at: u32| self.text.get(self.after_comma as usize..at as usize);
        self.after_comma > 0
            && start >= self.after_comma
            && line(start).is_some_and(|text| !text.contains(['\r', '\n', ':']))
    }

    /// A short expression as it stands in the script; a long one is "this".
    fn shown(&self, expr: &Expr) -> String {
        const SHORT: usize = 24;
        let text = expr.span.of(self.text);
        if text.is_empty() || text.len() > SHORT { "this".to_owned() } else { format!("`{text}`") }
    }

    /// A condition, or an ON/OFF argument: a Truth or a Number, and none of the forms that look
    /// logical and are not (lang/README.md, Values and kinds).
    pub(super) fn condition(&mut self, expr: &'a Expr, what: &str) -> Option<hir::Expr> {
        let value = self.expr(expr)?;
        if !kinds::is_plain(value.kind) {
            self.error(
                Code::ConditionKind,
                expr.span,
                format!("{what} is a Truth or a Number, not {}", kinds::a(value.kind)),
                format!("compare it: `> 0{}`", zero_unit(value.kind)),
            );
            return None;
        }
        self.logical(expr)?;
        Some(value)
    }

    /// Looks for what is no condition in the logical part of an expression.
    fn logical(&mut self, expr: &'a Expr) -> Option<()> {
        match &expr.kind {
            ExprKind::Unary(UnaryOp::Not, inner) => {
                if self.quiet_kind(inner) == Some(Kind::Number) {
                    let text = self.shown(inner);
                    self.error(
                        Code::ConditionKind,
                        expr.span,
                        format!("NOT of a Number is bitwise, and {text} is a Number"),
                        "write `x = 0` for \"is not set\"",
                    );
                    return None;
                }
                self.logical(inner)
            }
            ExprKind::Binary(op @ (BinaryOp::And | BinaryOp::Or | BinaryOp::Xor), left, right) => {
                let pair = (self.quiet_kind(left), self.quiet_kind(right));
                if matches!(
                    pair,
                    (Some(Kind::Truth), Some(Kind::Number))
                        | (Some(Kind::Number), Some(Kind::Truth))
                ) {
                    self.error(
                        Code::ConditionKind,
                        expr.span,
                        format!("{} of a Truth and a Number works on their bits", op.symbol()),
                        "make both sides Truths: `x <> 0`",
                    );
                    return None;
                }
                self.logical(left)?;
                self.logical(right)
            }
            ExprKind::Binary(BinaryOp::AndAlso | BinaryOp::OrElse, left, right) => {
                self.logical(left)?;
                self.logical(right)
            }
            ExprKind::Binary(op, left, right) if op.is_comparison() => {
                let comparison = [left, right].into_iter().any(
                    |side| matches!(&side.kind, ExprKind::Binary(op, ..) if op.is_comparison()),
                );
                if comparison {
                    self.error(
                        Code::ConditionKind,
                        expr.span,
                        "a comparison of a comparison",
                        "join two comparisons: `a < b AND b < c`",
                    );
                    return None;
                }
                Some(())
            }
            _ => Some(()),
        }
    }

    /// The kind of an expression that was checked already.
    fn quiet_kind(&mut self, expr: &'a Expr) -> Option<Kind> {
        self.expr(expr).map(|value| value.kind)
    }
}

/// The units in which a quantity is written, the usual one first.
const fn units(kind: Kind) -> &'static [&'static str] {
    match kind {
        Kind::Number | Kind::Truth => &[],
        Kind::Length => &["mm"],
        Kind::Steps => &["st"],
        Kind::Time => &["ms", "s"],
        Kind::Speed => &["mm/min"],
        Kind::StepRate => &["st/s"],
        Kind::Accel => &["mm/s2"],
        Kind::StepAccel => &["st/s2"],
        Kind::Angle => &["deg"],
        Kind::Voltage => &["mV", "V"],
    }
}

/// How a Number is written as a quantity.
fn with_unit(kind: Kind, expr: &Expr) -> Vec<String> {
    let value = match &expr.kind {
        ExprKind::Literal { kind: Kind::Number, value } => Some(*value),
        _ => None,
    };
    let units = units(kind);
    if units.is_empty() {
        return vec!["a whole number".to_owned()];
    }
    match value {
        Some(value) => units.iter().map(|unit| format!("`{value}{unit}`")).collect(),
        None => units.iter().take(1).map(|unit| format!("`... * 1{unit}`")).collect(),
    }
}

fn zero_unit(kind: Kind) -> &'static str {
    match kind {
        Kind::Length => "mm",
        Kind::Time => "ms",
        other => other.unit().suffix(),
    }
}
