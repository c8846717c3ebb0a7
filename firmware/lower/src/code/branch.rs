//! Ways of an `if`: to an end, to what only parts have, to one of two.

use super::{Made, Writer};
use crate::ops::Op;
use crate::tree::{Cond, End, Stmt, Vars};

impl Writer<'_> {
    pub(super) fn branch(
        &mut self,
        cond: &Cond,
        then: &[Stmt],
        other: &[Stmt],
        out: &Vars,
    ) -> Made<()> {
        if let (Some((symbol, cond)), []) = (of_parts(cond), other) {
            return self.only_when(symbol, out, |writer| writer.branch(&cond, then, other, out));
        }
        if let Some((symbol, cond)) = of_parts(cond) {
            let (before, behind) = (self.live(then, out), self.live(other, out));
            let both = before.union(&behind).copied().collect();
            let (otherwise, end) = (self.label(), self.label());
            self.only_when(symbol, &behind, |writer| {
                writer.unless(&cond, &otherwise, &both)?;
                writer.block(then, out)?;
                writer.jump("GOTO", &end);
                Ok(())
            })?;
            self.place(&otherwise, &behind)?;
            self.block(other, out)?;
            return self.place(&end, out);
        }
        // The operation itself returns NOT_YET.
        if let (Cond::Not(inner), [Stmt::Return(End::NotYet)], []) = (cond, then, other)
            && let Cond::Call(call) = &**inner
            && call.code.last().is_some_and(|op| Op::read(op).facts().ends_caller)
        {
            return self.call(call, out);
        }
        if other.is_empty() && self.refuses(cond, then, out)? {
            return Ok(());
        }
        if let ([Stmt::Return(End::Cond(end))], []) = (then, other)
            && let Some(so) = always(end)
        {
            let label = match self.known.get(&so) {
                Some(label) => label.clone(),
                None => self.label(),
            };
            self.known.insert(so, label.clone());
            return self.when(cond, true, &label, out);
        }
        let (before, behind) = (self.live(then, out), self.live(other, out));
        let otherwise = self.label();
        let both = before.union(&behind).copied().collect();
        self.unless(cond, &otherwise, &both)?;
        self.block(then, out)?;
        if other.is_empty() {
            return self.place(&otherwise, out);
        }
        let end = self.label();
        self.jump("GOTO", &end);
        self.place(&otherwise, &behind)?;
        self.block(other, out)?;
        self.place(&end, out)
    }
}

/// A condition that begins with what only parts with a symbol have: that, and what has to be so on them.
fn of_parts(cond: &Cond) -> Option<(&str, Cond)> {
    match cond {
        Cond::When(symbol, inner) => Some((symbol, (**inner).clone())),
        Cond::And(a, b) => {
            let (symbol, a) = of_parts(a)?;
            Some((symbol, Cond::And(Box::new(a), b.clone())))
        }
        _ => None,
    }
}

/// What is always so, or never.
pub(super) fn always(cond: &Cond) -> Option<bool> {
    match cond {
        Cond::Never => Some(false),
        Cond::Not(inner) if **inner == Cond::Never => Some(true),
        _ => None,
    }
}
