//! Ends: a value, a flag, a number, or the call of what returns in the function's place.

use super::{Made, Writer, always};
use crate::leaf::{Holds, Type};
use crate::ops::{Line, Op, TAIL, routine};
use crate::tree::{Call, Cond, End, Expr, Vars};

impl Writer<'_> {
    /// A call is the last thing: what is called returns in the function's place.
    pub(super) fn last_call(&mut self, call: &Call) -> Made<()> {
        self.call(call, &Vars::new())?;
        let Some(Line::Op(op)) = self.lines.last() else { return self.refuse("a call") };
        if matches!(op.name.as_str(), "DO" | "CALL") && !self.state.dead {
            let tail = format!("{TAIL} {}, {}", op.name, op.first());
            self.lines.pop();
            self.put(Op::read(&tail));
            self.promised(false)
        } else {
            self.promised(self.state.zero)?;
            self.op("RETURN");
            Ok(())
        }
    }

    /// Whether r12 is as callers are told.
    fn promised(&self, zero: bool) -> Made<()> {
        if self.function.zero && !zero {
            return self.refuse("r12 is not known to be 0 at its end");
        }
        Ok(())
    }

    /// Whether callers are told that Z says whether the result is 0.
    fn promises_z(&self) -> bool {
        let row = routine(&self.function.label);
        self.function.gives == Type::Long && row.is_some_and(|row| row.flags == "Z")
    }

    /// Whether Z says so behind a call, or no one asks.
    fn tells_zero(&self, call: &Call) -> bool {
        let says = |op: &String| Op::read(op).facts().flags.contains('Z');
        let rule = call.rule.as_ref().and_then(|rule| routine(rule));
        !self.promises_z()
            || rule.is_some_and(|row| row.flags.contains('Z'))
            || call.code.last().is_some_and(says)
    }

    /// Whether a call leaves r8 and r9 as they are.
    pub(super) fn keeps_pointers(&self, call: &Call) -> bool {
        let kept = |op: &String| {
            let facts = Op::read(op).facts();
            facts.sets.is_empty() && facts.loses.is_empty()
        };
        call.rule.is_none() && call.code.iter().all(kept)
    }

    pub(super) fn end(&mut self, end: &End) -> Made<()> {
        let none = Vars::new();
        if let Some(label) = self.within.clone() {
            match end {
                End::Nothing => {}
                End::Value(Expr::Call(call)) => self.call(call, &none)?,
                _ => return self.refuse("what stands within has no result"),
            }
            self.jump("GOTO", &label);
            return Ok(());
        }
        match end {
            End::Nothing => {
                self.promised(self.state.zero)?;
                self.op("RETURN");
            }
            End::Done if self.state.zero => self.op("RETURN"),
            End::Done => self.op("DONE_"),
            End::NotYet => self.op("NOT_YET_"),
            End::Fault(fault) => self.fail(fault),
            End::Value(Expr::Call(call)) if call.or.is_none() && self.tells_zero(call) => {
                return self.last_call(call);
            }
            End::Value(Expr::Var(axis)) if self.function.gives == Type::Axis => {
                self.need_axis(Some(*axis))?;
                self.need_record(Some(*axis), None)?;
                self.op("RETURN");
            }
            End::Value(value) => {
                self.value(value, &none)?;
                if self.promises_z() && !self.state.z {
                    self.op("DO test_long");
                }
                self.op("RETURN");
            }
            End::Cond(cond) => return self.end_cond(cond),
        }
        Ok(())
    }

    /// With a fault or an exception.
    pub(super) fn fail(&mut self, symbol: &str) {
        if symbol.starts_with("EX_") {
            self.op(&format!("LIT {symbol}"));
            self.op("RETURN");
        } else {
            self.op(&format!("FAULT {symbol}"));
        }
    }

    /// The flag of the function's result is left.
    fn end_cond(&mut self, cond: &Cond) -> Made<()> {
        let none = Vars::new();
        let holds = self.function.holds;
        if let Some(so) = always(cond) {
            return self.end_known(so);
        }
        match (cond, holds) {
            (Cond::Call(call), holds) if call.holds == holds && call.or.is_none() => {
                return self.last_call(call);
            }
            (Cond::Bits(value, mask), Some(Holds::NotEqual)) => {
                self.value(value, &none)?;
                self.op(&format!("TESTI {}", mask.text));
            }
            (Cond::Within(value, first, last), Some(Holds::NoCarry)) => {
                self.within(value, first, last, &none)?;
            }
            (Cond::Same(value, zero), Some(Holds::Equal)) => self.zero(value, zero)?,
            (Cond::Not(inner), Some(Holds::NotEqual)) => match &**inner {
                Cond::Same(value, zero) => self.zero(value, zero)?,
                _ => return self.refuse("leaves no flag"),
            },
            _ => return self.refuse("leaves no flag"),
        }
        self.op("RETURN");
        Ok(())
    }

    /// With what is known.
    pub(super) fn end_known(&mut self, so: bool) -> Made<()> {
        if self.function.holds == Some(Holds::Carry) && !so {
            self.op("TESTI 0");
            self.op("RETURN");
            return Ok(());
        }
        let equal = match self.function.holds {
            Some(Holds::Equal) => so,
            Some(Holds::NotEqual) => !so,
            _ => return self.refuse("leaves no flag"),
        };
        if self.state.equal != Some(equal) {
            self.op(if equal { "LIT 0" } else { "LIT 1" });
            self.op("DO test_long");
        }
        self.op("RETURN");
        Ok(())
    }

    fn zero(&mut self, value: &Expr, zero: &Expr) -> Made<()> {
        if !matches!(zero, Expr::Number(zero) if zero.value == Some(0)) {
            return self.refuse("leaves no flag");
        }
        self.value(value, &Vars::new())?;
        if !self.state.z {
            self.op("DO test_long");
        }
        Ok(())
    }
}
