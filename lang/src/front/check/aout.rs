//! Analog outputs: which there are, of which kind their values are, and how far these go.

use super::expr::{number, value_of};
use super::names::Entity;
use super::{Checker, kinds};
use crate::fault::Fault;
use crate::front::ast::{Expr, ExprKind, GValue, GWord};
use crate::front::codes::Code;
use crate::front::span::Span;
use crate::hir::{self, BinOp};
use crate::kind::Kind;
use crate::profile::Aout;

/// mV in a volt.
const MV: i32 = 1000;

impl<'a> Checker<'a> {
    /// The arguments of SetAout: number and value.
    pub(super) fn set_aout(&mut self, list: &'a [Expr]) -> Option<(hir::Expr, hir::Expr)> {
        let [n, value] = list else { return None };
        if let ExprKind::Name(name) = &n.kind {
            let remedy =
                |name: &str| format!("give an [[aout]] of the profile `name = \"{name}\"`");
            let symbol = self.resolve_as(name, remedy)?;
            let what = match symbol.entity {
                Entity::Analog(false, _) => Some("an analog input"),
                Entity::Port(false, _) => Some("an input"),
                Entity::Port(true, _) => Some("an output that is on or off"),
                _ => None,
            };
            if let Some(what) = what {
                let message =
                    format!("SetAout takes an analog output, and `{}` is {what}", symbol.text);
                let hint = "write the number or the name of an [[aout]] of the profile";
                self.error(Code::WrongUse, n.span, message, hint);
                return None;
            }
        }
        let known = self.plain(n, "an analog output's number")?;
        let aout = self.aout(&known, n.span)?;
        let level = match aout.is_share() {
            true => self.plain(value, "SetAout")?,
            false => self.quantity(value, &[Kind::Voltage], "SetAout")?,
        };
        self.check_level(aout, &level, value.span);
        Some((known, level))
    }

    /// E and Q of M67 and M68: number and value; a plain Q is in volts, or in steps of the share.
    pub(super) fn aout_words(
        &mut self,
        e: &'a GWord,
        q: &'a GWord,
    ) -> Option<(hir::Expr, hir::Expr)> {
        let n = self.number_word(e)?;
        let aout = self.aout(&n, e.span)?;
        let level = match &q.value {
            _ if aout.is_share() => self.number_word(q)?,
            GValue::Number(decimal) => {
                let mv = decimal.scaled(MV as u32, 1).and_then(|(mv, _)| i32::try_from(mv).ok());
                let Some(mv) = mv else { return self.too_large(q) };
                number(mv, Kind::Voltage, q.span)
            }
            GValue::Expr(expr) => {
                let value = self.expr(expr)?;
                match value.kind {
                    Kind::Voltage => value,
                    kind if kinds::is_plain(kind) => {
                        let factor = number(MV, Kind::Voltage, q.span);
                        self.make_binary(BinOp::Mul, Kind::Voltage, value, factor, q.span)?
                    }
                    kind => {
                        let message =
                            format!("Q needs volts or a Voltage, this is {}", kinds::a(kind));
                        let hint = "write `Q1.5` or `Q[1500mV]`";
                        self.error(Code::ArgumentKind, expr.span, message, hint);
                        return None;
                    }
                }
            }
        };
        self.check_level(aout, &level, q.span);
        Some((n, level))
    }

    /// The analog output of a number, which must be known and in the profile.
    fn aout(&mut self, n: &hir::Expr, span: Span) -> Option<&'a Aout> {
        let Some(n) = value_of(n) else {
            let message = "the number of an analog output is only known at run time";
            self.error(Code::NotConstant, span, message, "write its number or its name");
            return None;
        };
        let aouts = &self.profile.aouts;
        if let Some(aout) = aouts.iter().find(|aout| aout.n == n) {
            return Some(aout);
        }
        let message = format!("the machine `{}` has no analog output {n}", self.profile.name);
        let hint = match &aouts[..] {
            [] => "write `[[aout]]` with `n = 1` into its profile; the F5529 has one".to_owned(),
            some => {
                let numbers: Vec<String> = some.iter().map(|aout| aout.n.to_string()).collect();
                format!("its analog output is {}", numbers.join(", "))
            }
        };
        self.error(Code::NoPort, span, message, hint);
        None
    }

    /// A value that is known lies within what the output gives.
    fn check_level(&mut self, aout: &Aout, level: &hir::Expr, span: Span) {
        if value_of(level).is_none_or(|value| (0..=aout.full()).contains(&value)) {
            return;
        }
        let unit = if aout.is_share() { "" } else { "mV" };
        let hint = format!("analog output {} gives 0{unit} to {}{unit}", aout.n, aout.full());
        self.ends_here(Fault::ValueRange, span, "the output has no such value", hint);
    }
}
