//! Conditions: jumps by flags that are right already, by a byte, or by a comparison.

use super::state::Held;
use super::ways::refused;
use super::{Made, Writer, is_byte};
use crate::leaf::{Holds, Type};
use crate::tree::{Call, Cond, Expr, Number, Pair, Size, Stmt, Vars};

impl Writer<'_> {
    /// Goes to `label` unless a condition holds; variables of `out` are needed on either way.
    pub(super) fn unless(&mut self, cond: &Cond, label: &str, out: &Vars) -> Made<()> {
        self.when(cond, false, label, out)
    }

    /// Goes to `label` when a condition is `so`.
    pub(super) fn when(&mut self, cond: &Cond, so: bool, label: &str, out: &Vars) -> Made<()> {
        if self.state.dead {
            return Ok(());
        }
        match cond {
            Cond::Not(inner) => self.when(inner, !so, label, out),
            Cond::And(a, b) | Cond::Or(a, b) => {
                let both = matches!(cond, Cond::And(..));
                if let Some((byte, mask)) = bits_of_one(a, b, both) {
                    let any = so != both;
                    self.jump(&format!("{} {byte}, {mask}", bits(any)), label);
                    return Ok(());
                }
                let mut rest = out.clone();
                b.vars(&mut rest);
                if both == so {
                    let past = self.label();
                    self.when(a, !so, &past, &rest)?;
                    self.when(b, so, label, out)?;
                    self.place(&past, out)
                } else {
                    self.when(a, so, label, &rest)?;
                    self.when(b, so, label, out)
                }
            }
            Cond::Any(byte, mask, _) if mask.is_empty() => {
                let jump = if so { "IF_SET" } else { "IF_ZERO" };
                self.jump(&format!("{jump} {byte}"), label);
                Ok(())
            }
            Cond::Any(byte, mask, _) => {
                self.jump(&format!("{} {byte}, {mask}", bits(so)), label);
                Ok(())
            }
            // Without it there is no jump.
            Cond::When(symbol, inner) if so => {
                self.only_when(symbol, out, |writer| writer.when(inner, true, label, out))
            }
            Cond::When(..) => self.refuse("what not all parts have is an `if` by itself"),
            Cond::Never => {
                if !so {
                    self.jump("GOTO", label);
                }
                Ok(())
            }
            Cond::Is(byte, value) => {
                let jump = if so { "IF_IS" } else { "IF_IS_NOT" };
                self.jump(&format!("{jump} {byte}, {value}"), label);
                Ok(())
            }
            Cond::In(byte, axis) => {
                if self.state.axis != Some(*axis) {
                    return self.refuse("r8 is no longer the axis: one axis at a time");
                }
                let jump = format!("IF_NOT_AXIS {byte}");
                self.either(None, Some(&jump), so, label, out)
            }
            Cond::First => {
                if !self.state.first {
                    return self.refuse("whether it is the first call is asked first of all");
                }
                self.either(Some("IF_EQUAL"), Some("IF_NOT_EQUAL"), so, label, out)
            }
            Cond::Call(call) => self.flag(call, so, label, out),
            Cond::Same(a, b) => self.same_as(a, b, so, label, out),
            Cond::Below(value, Expr::Number(number)) => {
                self.value(value, out)?;
                if self.is_long(value) {
                    if number.value != Some(0) || !self.state.n {
                        return self
                            .refuse("a long is below 0 or not, behind a load, sum or difference");
                    }
                } else {
                    self.op(&format!("CMPI {}", number.text));
                }
                self.either(Some("IF_NEGATIVE"), Some("IF_NOT_NEGATIVE"), so, label, out)
            }
            Cond::Below(a, b) if self.is_long(a) && self.is_long(b) => {
                // Without a sign, as scaled numbers are.
                self.pair(Pair::Sub, a, b, true, out)?;
                self.either(None, Some("IF_CARRY"), so, label, out)
            }
            Cond::Below(..) => self.refuse("below a number, or a scaled number below another"),
            Cond::Bits(value, mask) => self.bits(value, mask, so, label, out),
            Cond::Within(value, first, last) => {
                self.within(value, first, last, out)?;
                self.either(Some("IF_NEGATIVE"), Some("IF_CARRY"), so, label, out)
            }
        }
    }

    /// `if` a condition holds, a value is illegal: the operation that returns by itself then, where there is one.
    pub(super) fn refuses(&mut self, cond: &Cond, then: &[Stmt], out: &Vars) -> Made<bool> {
        if !refused(then) {
            return Ok(false);
        }
        let zero = |value: &Expr| matches!(value, Expr::Number(zero) if zero.value == Some(0));
        let flag = |call: &Call, holds| call.holds == Some(holds) && call.or.is_none();
        match cond {
            Cond::Not(inner) => match &**inner {
                Cond::Below(value, Expr::Number(number)) if !self.is_long(value) => {
                    self.value(value, out)?;
                    self.op(&format!("BELOW {}", number.text));
                    return Ok(true);
                }
                Cond::Same(value, none) if zero(none) && !self.is_long(value) => {
                    self.value(value, out)?;
                    self.op("BELOW 1");
                    return Ok(true);
                }
                Cond::Bits(value, mask) => {
                    self.value(value, out)?;
                    self.op(&format!("TESTI {}", mask.text));
                }
                Cond::Call(call) if flag(call, Holds::NotEqual) => self.call(call, out)?,
                _ => return Ok(false),
            },
            Cond::Same(value, none) if zero(none) && self.is_long(value) => {
                self.value(value, out)?;
                if !self.state.z {
                    self.op("DO test_long");
                }
            }
            Cond::Call(call) if flag(call, Holds::Equal) => self.call(call, out)?,
            _ => return Ok(false),
        }
        self.op("WANTED");
        Ok(true)
    }

    /// A jump by a flag: one for each sense, where there is one.
    fn either(
        &mut self,
        yes: Option<&str>,
        not: Option<&str>,
        so: bool,
        label: &str,
        out: &Vars,
    ) -> Made<()> {
        let (jump, other) = if so { (yes, not) } else { (not, yes) };
        match (jump, other) {
            (Some(jump), _) => self.jump(jump, label),
            (None, Some(other)) => {
                let past = self.label();
                self.jump(other, &past);
                self.jump("GOTO", label);
                self.place(&past, out)?;
            }
            _ => return self.refuse("no jump tells"),
        }
        Ok(())
    }

    fn by(&mut self, holds: Holds, so: bool, label: &str, out: &Vars) -> Made<()> {
        let (yes, not) = match holds {
            Holds::Equal => (Some("IF_EQUAL"), Some("IF_NOT_EQUAL")),
            Holds::NotEqual => (Some("IF_NOT_EQUAL"), Some("IF_EQUAL")),
            Holds::Carry => (Some("IF_CARRY"), None),
            Holds::NoCarry => (None, Some("IF_CARRY")),
            Holds::Negative => (Some("IF_NEGATIVE"), Some("IF_NOT_NEGATIVE")),
            Holds::Overflow => (Some("IF_OVERFLOW"), None),
        };
        self.either(yes, not, so, label, out)
    }

    fn flag(&mut self, call: &Call, so: bool, label: &str, out: &Vars) -> Made<()> {
        let Some(holds) = call.holds else { return self.refuse("a call that leaves no flag") };
        self.call(call, out)?;
        let Some(other) = &call.or else { return self.by(holds, so, label, out) };
        if so {
            self.by(holds, true, label, out)?;
            self.code(other, call, out)?;
            return self.by(holds, true, label, out);
        }
        let yes = self.label();
        self.by(holds, true, &yes, out)?;
        self.code(other, call, out)?;
        self.by(holds, false, label, out)?;
        self.place(&yes, out)
    }

    pub(super) fn is_long(&self, value: &Expr) -> bool {
        match value {
            Expr::Var(var) => self.function.vars[*var] == Type::Long,
            Expr::Place(place) => matches!(place.size, crate::tree::Size::Long),
            Expr::Call(call) => matches!(call.gives, Type::Long | Type::Maybe),
            Expr::Pair(_, a, b) => self.is_long(a) || self.is_long(b),
            Expr::Of(..) | Expr::Shifted(..) | Expr::Most => true,
            Expr::Wide(_) | Expr::OrZero(_) | Expr::OrFault(..) => true,
            Expr::If(_, a, _) => self.is_long(a),
            _ => false,
        }
    }

    fn same_as(&mut self, a: &Expr, b: &Expr, so: bool, label: &str, out: &Vars) -> Made<()> {
        let Expr::Number(number) = b else {
            let (value, byte) = match (a, b) {
                (a, Expr::Place(place)) if is_byte(place.size) => (a, place),
                (Expr::Place(place), b) if is_byte(place.size) => (b, place),
                _ => return self.refuse("one of two values that are compared is a byte in memory"),
            };
            self.value(value, out)?;
            self.op(&format!("COMPARE {}", byte.symbol));
            return self.either(Some("IF_EQUAL"), Some("IF_NOT_EQUAL"), so, label, out);
        };
        let byte = match a {
            Expr::Place(place) if is_byte(place.size) => Some(place.symbol.clone()),
            Expr::Var(var)
                if self.function.vars[*var] == Type::Byte && self.state.stored.contains(var) =>
            {
                self.slots.get(var).cloned()
            }
            _ => None,
        };
        let held = match a {
            Expr::Place(place) => self.state.held.contains(&Held::Place(place.clone())),
            Expr::Var(var) => self.state.held.contains(&Held::Var(*var)),
            _ => false,
        };
        if let Some(byte) = byte.clone().filter(|_| !held) {
            let jump = match (number.value, so) {
                (Some(0), true) => format!("IF_ZERO {byte}"),
                (Some(0), false) => format!("IF_SET {byte}"),
                (_, true) => format!("IF_IS {byte}, {}", number.text),
                (_, false) => format!("IF_IS_NOT {byte}, {}", number.text),
            };
            self.jump(&jump, label);
        } else if self.is_long(a) {
            if number.value != Some(0) {
                return self.refuse("a long is 0 or not");
            }
            self.value(a, out)?;
            if !self.state.z {
                self.op("DO test_long");
            }
            self.either(Some("IF_EQUAL"), Some("IF_NOT_EQUAL"), so, label, out)?;
            if !so {
                (self.state.zero, self.state.wide) = (true, true);
            }
        } else {
            if let (Expr::Place(word), true) = (a, number.wide)
                && word.size == Size::Word
            {
                self.value(b, out)?;
                self.formula("cmp", a, out)?;
                return self.either(Some("IF_EQUAL"), Some("IF_NOT_EQUAL"), so, label, out);
            }
            self.value(a, out)?;
            if number.value == Some(0) && self.state.z {
                self.either(Some("IF_EQUAL"), Some("IF_NOT_EQUAL"), so, label, out)?;
            } else {
                let jump = if so { "CASE" } else { "CASE_NOT" };
                self.jump(&format!("{jump} {}", number.text), label);
            }
            if !so {
                self.state.hold(Held::Number(number.clone()));
                self.state.zero |= number.value == Some(0);
            }
        }
        if let (false, Some(byte), Some(value)) = (so, byte, number.value) {
            self.state.known.insert(byte, value);
        }
        Ok(())
    }

    fn bits(&mut self, value: &Expr, mask: &Number, so: bool, label: &str, out: &Vars) -> Made<()> {
        let byte = match value {
            Expr::Place(place) if is_byte(place.size) => Some(place.symbol.clone()),
            Expr::Var(var)
                if self.state.stored.contains(var)
                    && !self.state.held.contains(&Held::Var(*var)) =>
            {
                self.slots.get(var).cloned()
            }
            _ => None,
        };
        if let Some(byte) = byte {
            self.jump(&format!("{} {byte}, {}", bits(so), mask.text), label);
            return Ok(());
        }
        self.value(value, out)?;
        self.op(&format!("TESTI {}", mask.text));
        self.either(Some("IF_NOT_EQUAL"), Some("IF_EQUAL"), so, label, out)
    }

    /// C is clear, and N set, when a value lies within.
    pub(super) fn within(
        &mut self,
        value: &Expr,
        first: &Number,
        last: &Number,
        out: &Vars,
    ) -> Made<()> {
        self.value(value, out)?;
        self.clobber(out)?;
        self.op(&format!("ADDI -{}", first.text));
        self.op(&format!("CMPI {}+1-{}", last.text, first.text));
        Ok(())
    }
}

const fn bits(any: bool) -> &'static str {
    if any { "IF_ANY" } else { "IF_NONE" }
}

/// Two conditions that look at bits of one byte: the byte and all of the bits.
fn bits_of_one(a: &Cond, b: &Cond, both: bool) -> Option<(String, String)> {
    let of = |cond: &Cond| match cond {
        Cond::Any(byte, mask, _) => Some((byte.clone(), mask.clone(), false)),
        Cond::Not(inner) => match &**inner {
            Cond::Any(byte, mask, _) => Some((byte.clone(), mask.clone(), true)),
            _ => None,
        },
        _ => None,
    };
    let ((byte, first, not), (other, second, also)) = (of(a)?, of(b)?);
    let bits = !first.is_empty() && !second.is_empty();
    (bits && byte == other && not == also && not == both)
        .then(|| (byte, format!("{first}|{second}")))
}
