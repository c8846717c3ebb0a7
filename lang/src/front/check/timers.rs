//! TIMERs and edges: names that the checker reads through FUNCTIONs of the parser's making.

use super::names::Entity;
use super::{Checker, MAIN, clocks, kinds, range};
use crate::front::ast::{Expr, Name, Variable};
use crate::front::codes::Code;
use crate::front::parser::{edge_key, elapsed_key};
use crate::front::span::Span;
use crate::hir::{self, BinOp, Place, RoutineId, StmtKind, VarId};
use crate::kind::Kind;

/// Greatest value that a TIMER is set to, in ms: what it stands at.
const GREATEST: i32 = crate::front::parser::GREATEST;

impl<'a> Checker<'a> {
    /// `DIM t AS TIMER`
    pub(super) fn dim_timer(&mut self, variable: &'a Variable, var: VarId) {
        let name = &variable.name;
        let extra = variable.size.as_ref().or(variable.at.as_ref());
        if self.scope != MAIN {
            let message = format!("`{}` is a TIMER inside a SUB", name.text);
            let hint = "declare it outside: a local is new at each call";
            self.error(Code::WrongUse, name.span, message, hint);
        } else if let Some(extra) = extra {
            let message = format!("`{}` is a TIMER and has neither size nor register", name.text);
            let hint = "declare each by itself: `DIM t AS TIMER`; a panel gets `DIM shown AT 3000`";
            self.error(Code::WrongUse, extra.span, message, hint);
        } else if let Some(Entity::Routine(id)) = self.names.look(MAIN, &elapsed_key(&name.key)) {
            self.timers.insert(var, id);
        }
    }

    /// The FUNCTION that reads this variable, where it is a TIMER and not read by that itself.
    pub(super) fn reader(&self, var: VarId) -> Option<RoutineId> {
        let own = self.routine(self.scope).is_some_and(|routine| routine.name.is_hidden());
        self.timers.get(&var).copied().filter(|_| !own)
    }

    /// The FUNCTION of an edge, where RISE or FALL is not a name of the script.
    pub(super) fn edge(&self, name: &Name) -> Option<RoutineId> {
        if !matches!(&*name.key, "rise" | "fall") {
            return None;
        }
        match self.names.look(MAIN, &edge_key(name.span.start)) {
            Some(Entity::Routine(id)) => Some(id),
            _ => None,
        }
    }

    /// A call of one of these FUNCTIONs.
    pub(super) fn reading(&self, id: RoutineId, span: Span) -> hir::Expr {
        let kind = self.infos[id.0 as usize].result.unwrap_or(Kind::Number);
        hir::Expr { kind, span: range(span), node: hir::ExprKind::Call(id, Vec::new()) }
    }

    /// `t = 0s`: the variable holds what TIMER() was when the TIMER stood at 0.
    pub(super) fn restart(
        &self,
        var: VarId,
        value: &hir::Expr,
        span: Span,
    ) -> Result<StmtKind, &'static str> {
        let ms = value.constant().filter(|_| value.kind == Kind::Time);
        let ms = ms.filter(|ms| (0..=GREATEST).contains(ms));
        let ms = ms.ok_or("a TIMER is set to a constant Time of 0s to 12 days")?;
        let now = clocks::timer(span);
        if ms == 0 {
            return Ok(StmtKind::Assign(Place::Var(var), now));
        }
        let node = hir::ExprKind::Binary(BinOp::Sub, Box::new(now), Box::new(value.clone()));
        let begun = hir::Expr { kind: Kind::Time, span: range(span), node };
        Ok(StmtKind::Assign(Place::Var(var), self.rounded(BinOp::Sub, begun)))
    }

    /// What is wrong with a value that a TIMER can not be set to.
    pub(super) fn wrong_restart(&mut self, name: &Name, value: &Expr, found: Kind, why: &str) {
        let message =
            format!("`{}` is a TIMER and can not be set to {}", name.text, kinds::a(found));
        let hint = format!("{why}: `{} = 0s` restarts it", name.text);
        self.error(Code::AssignKind, value.span, message, hint);
    }
}
