//! What stands within other code: that of some parts alone, that of a rule where it is called, a number in front of
//! the jump to who takes it.

use super::{Made, Writer, value};
use crate::leaf::Type;
use crate::tree::{Call, Cond, End, Expr, Function, Stmt, Vars};

impl<'a> Writer<'a> {
    /// Makes what only parts with this symbol have: behind it is known what is so with and without.
    pub(super) fn only_when(
        &mut self,
        symbol: &str,
        out: &Vars,
        make: impl FnOnce(&mut Self) -> Made<()>,
    ) -> Made<()> {
        if self.when.is_some() {
            return self.refuse("one condition of parts at a time");
        }
        let without = self.state.on_way();
        self.when = Some(symbol.to_owned());
        let made = make(self);
        self.when = None;
        made?;
        let with = std::mem::take(&mut self.state);
        self.state = if with.dead { without } else { without.meet(&with) };
        self.kept(out)
    }

    /// The rule that is called, when its code stands where it is called.
    pub(super) fn stands_here(&self, call: &Call) -> Option<&'a Function> {
        let named = |function: &&Function| Some(&function.label) == call.rule.as_ref();
        self.functions.iter().find(named).filter(|function| function.within)
    }

    /// Its code.
    pub(super) fn stand(&mut self, function: &Function, out: &Vars) -> Made<()> {
        if !function.vars.is_empty() || !out.is_empty() || self.within.is_some() {
            return self
                .refuse("what stands within has no variables, and there are none around it");
        }
        let end = self.label();
        self.within = Some(end.clone());
        let made = self.block(&function.body, out);
        self.within = None;
        made?;
        self.place(&end, out)
    }

    /// `if` bytes say so, a rule with a number ends the function, which has no result.
    pub(super) fn number_first<'b>(
        &self,
        cond: &Cond,
        then: &'b [Stmt],
        other: &[Stmt],
    ) -> Option<&'b Call> {
        let ([Stmt::Return(End::Value(Expr::Call(call)))], []) = (then, other) else { return None };
        let number = matches!(call.value.as_deref(), Some(Expr::Number(_)));
        let fits = self.within.is_none()
            && self.function.gives == Type::Nothing
            && value::looks_at_bytes(cond);
        (fits && number && call.rule.is_some() && call.axis.is_none()).then_some(call)
    }

    pub(super) fn goes_with(&mut self, cond: &Cond, call: &Call, out: &Vars) -> Made<()> {
        if let (Some(value), Some(rule)) = (&call.value, &call.rule) {
            self.value(value, out)?;
            self.when(cond, true, rule, out)?;
        }
        Ok(())
    }
}
