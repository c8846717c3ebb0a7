//! Blocks: IF, SELECT, FOR, WHILE, DO, REPEAT, EXIT, CONTINUE.

use super::{Loop, Lower};
use crate::back::ir::{Cond, Item, Label};
use crate::back::report::MarkKind;
use crate::hir::{
    Arm, Block, Case, CaseTest, DoTest, Expr, ExprKind, LoopKind, Stmt, StmtKind, VarId,
};
use crate::isa::Op;

/// The parts of a FOR.
struct For<'s> {
    var: VarId,
    from: &'s Expr,
    to: &'s Expr,
    step: &'s Expr,
    to_temp: Option<VarId>,
    step_temp: Option<VarId>,
    body: &'s Block,
    next_line: u32,
}

impl For<'_> {
    /// Whether it is known that the first pass runs.
    fn enters(&self) -> bool {
        let parts = (constant(self.from), constant(self.to), constant(self.step));
        let (Some(from), Some(to), Some(step)) = parts else { return false };
        if step > 0 { from <= to } else { step < 0 && from >= to }
    }
}

fn constant(expr: &Expr) -> Option<i32> {
    match expr.node {
        ExprKind::Const(value) => Some(value),
        _ => None,
    }
}

impl Lower<'_> {
    /// Lowers a statement that is a block or leaves one; `false` for all others.
    pub(super) fn control(&mut self, stmt: &Stmt) -> bool {
        match &stmt.kind {
            StmtKind::If { arms, otherwise, .. } => self.if_block(arms, otherwise),
            StmtKind::Select { value, temp, cases, otherwise } => {
                self.select(value, *temp, cases, otherwise);
            }
            StmtKind::For { var, from, to, step, to_temp, step_temp, body, next_line } => self
                .for_loop(&For {
                    var: *var,
                    from,
                    to,
                    step,
                    to_temp: *to_temp,
                    step_temp: *step_temp,
                    body,
                    next_line: *next_line,
                }),
            StmtKind::While { condition, body } => self.while_loop(condition, body),
            StmtKind::Do { before, body, after } => {
                self.do_loop(before.as_deref(), body, after.as_deref());
            }
            StmtKind::Repeat { count, temp, body } => self.repeat(count, *temp, body),
            StmtKind::Exit(kind) => self.jump_out(*kind, |outer| outer.exit),
            StmtKind::Continue(kind) => self.jump_out(*kind, |outer| outer.next),
            _ => return false,
        }
        true
    }

    fn jump_out(&mut self, kind: LoopKind, label: impl Fn(&Loop) -> Label) {
        self.mark(MarkKind::Statement, None);
        // The checker has seen to it that there is such a loop.
        if let Some(outer) = self.loops.iter().rev().find(|outer| outer.kind == kind) {
            let target = label(outer);
            self.push(Item::Jump(target));
        }
    }

    /// The body of a block, then back to the block's own place in the source.
    fn inner(&mut self, body: &Block) {
        let (line, span) = (self.line, self.span.clone());
        self.block(body);
        (self.line, self.span) = (line, span);
    }

    fn loop_body(&mut self, kind: LoopKind, next: Label, exit: Label, body: &Block) {
        self.loops.push(Loop { kind, next, exit });
        self.inner(body);
        self.loops.pop();
    }

    fn if_block(&mut self, arms: &[Arm], otherwise: &Block) {
        let exit = self.fresh();
        for (i, arm) in arms.iter().enumerate() {
            let first = i == 0;
            let last = i + 1 == arms.len() && otherwise.is_empty();
            let next = if last { exit } else { self.fresh() };
            let kind = if first { MarkKind::Statement } else { MarkKind::Test };
            self.mark_line(arm.line, kind, Some(exit));
            self.branch(&arm.condition, false, next);
            self.inner(&arm.body);
            if !last {
                self.mark_line(arm.line, MarkKind::Glue, None);
                self.push(Item::Jump(exit));
                self.push(Item::Label(next));
            }
        }
        self.inner(otherwise);
        self.push(Item::Label(exit));
    }

    fn select(&mut self, value: &Expr, temp: VarId, cases: &[Case], otherwise: &Block) {
        let exit = self.fresh();
        self.mark(MarkKind::Statement, Some(exit));
        self.expr(value);
        self.push(Item::Store(temp));
        for case in cases {
            let body = self.fresh();
            let next = self.fresh();
            self.mark_line(case.line, MarkKind::Test, Some(exit));
            for (i, test) in case.tests.iter().enumerate() {
                self.case_test(temp, test, body, (i + 1 == case.tests.len()).then_some(next));
            }
            self.push(Item::Label(body));
            self.inner(&case.body);
            self.mark_line(case.line, MarkKind::Glue, None);
            self.push(Item::Jump(exit));
            self.push(Item::Label(next));
        }
        self.inner(otherwise);
        self.push(Item::Label(exit));
    }

    /// One test: to `body` if it holds. The last falls through then, and else goes to `next`.
    fn case_test(&mut self, temp: VarId, test: &CaseTest, body: Label, next: Option<Label>) {
        let compare = |lower: &mut Self, cond: Cond, value: &Expr| {
            lower.push(Item::Load(temp));
            lower.expr(value);
            lower.push(match next {
                Some(next) => Item::Branch(cond.inverse(), next),
                None => Item::Branch(cond, body),
            });
        };
        match test {
            CaseTest::Equal(value) => compare(self, Cond::Eq, value),
            CaseTest::Is(op, value) => {
                compare(self, super::expr::cond(*op).unwrap_or(Cond::Eq), value);
            }
            CaseTest::Range(low, high) if !high.is_simple() => {
                // Both limits are evaluated: there is no short circuit here.
                self.push(Item::Load(temp));
                self.expr(low);
                self.plain(Op::Ge);
                self.push(Item::Load(temp));
                self.expr(high);
                self.plain(Op::Le);
                self.plain(Op::And);
                self.push(match next {
                    Some(next) => Item::Branch(Cond::Zero, next),
                    None => Item::Branch(Cond::Nonzero, body),
                });
            }
            CaseTest::Range(low, high) => {
                let outside = next.unwrap_or_else(|| self.fresh());
                self.push(Item::Load(temp));
                self.expr(low);
                self.push(Item::Branch(Cond::Lt, outside));
                compare(self, Cond::Le, high);
                if next.is_none() {
                    self.push(Item::Label(outside));
                }
            }
        }
    }

    fn for_loop(&mut self, parts: &For<'_>) {
        let (top, next, exit) = (self.fresh(), self.fresh(), self.fresh());
        self.mark(MarkKind::Statement, Some(exit));
        self.expr(parts.from);
        if let Some(temp) = parts.to_temp {
            self.expr(parts.to);
            self.push(Item::Store(temp));
        }
        if let Some(temp) = parts.step_temp {
            self.expr(parts.step);
            self.push(Item::Store(temp));
        }
        self.push(Item::Store(parts.var));
        if !parts.enters() {
            self.bounds(parts);
            self.push(Item::Turn(Op::ForStep, parts.var, exit));
        }
        self.push(Item::Label(top));
        self.loop_body(LoopKind::For, next, exit, parts.body);
        self.push(Item::Label(next));
        self.mark_line(parts.next_line, MarkKind::LoopEnd, Some(exit));
        match constant(parts.to).and_then(|to| i16::try_from(to).ok()) {
            Some(limit) if constant(parts.step) == Some(1) => {
                self.push(Item::NextLimit(parts.var, limit, top));
            }
            _ => {
                self.bounds(parts);
                self.push(Item::Turn(Op::NextStep, parts.var, top));
            }
        }
        self.push(Item::Label(exit));
    }

    /// Limit and step.
    fn bounds(&mut self, parts: &For<'_>) {
        match parts.to_temp {
            Some(temp) => self.push(Item::Load(temp)),
            None => self.expr(parts.to),
        }
        match parts.step_temp {
            Some(temp) => self.push(Item::Load(temp)),
            None => self.expr(parts.step),
        }
    }

    fn while_loop(&mut self, condition: &Expr, body: &Block) {
        let (top, exit) = (self.fresh(), self.fresh());
        self.push(Item::Label(top));
        self.mark(MarkKind::Statement, Some(exit));
        self.branch(condition, false, exit);
        self.loop_body(LoopKind::While, top, exit, body);
        self.mark(MarkKind::Glue, None);
        self.push(Item::Jump(top));
        self.push(Item::Label(exit));
    }

    fn do_loop(&mut self, before: Option<&DoTest>, body: &Block, after: Option<&DoTest>) {
        let (top, next, exit) = (self.fresh(), self.fresh(), self.fresh());
        self.push(Item::Label(top));
        if let Some(test) = before {
            self.mark_line(test.line, MarkKind::Statement, Some(exit));
            self.branch(&test.condition, test.until, exit);
        }
        self.loop_body(LoopKind::Do, next, exit, body);
        self.push(Item::Label(next));
        match after {
            Some(test) => {
                self.mark_line(test.line, MarkKind::LoopEnd, Some(exit));
                self.branch(&test.condition, !test.until, top);
            }
            None => {
                // Without any condition LOOP is what takes time.
                let kind = if before.is_some() { MarkKind::Glue } else { MarkKind::LoopEnd };
                self.mark(kind, None);
                self.push(Item::Jump(top));
            }
        }
        self.push(Item::Label(exit));
    }

    fn repeat(&mut self, count: &Expr, temp: VarId, body: &Block) {
        let (top, next, exit) = (self.fresh(), self.fresh(), self.fresh());
        self.mark(MarkKind::Statement, Some(exit));
        // A known number of passes is counted up to, any other down from.
        let known = constant(count).and_then(|count| i16::try_from(count).ok());
        let known = known.filter(|&count| count > 0);
        match known {
            Some(_) => self.push(Item::Const(1)),
            None => self.expr(count),
        }
        self.push(Item::Store(temp));
        if known.is_none() {
            self.push(Item::Load(temp));
            self.push(Item::Const(0));
            self.push(Item::Branch(Cond::Le, exit));
        }
        self.push(Item::Label(top));
        self.loop_body(LoopKind::Repeat, next, exit, body);
        self.push(Item::Label(next));
        self.mark(MarkKind::LoopEnd, Some(exit));
        match known {
            Some(count) => self.push(Item::NextLimit(temp, count, top)),
            None => {
                self.push(Item::Const(1));
                self.push(Item::Const(-1));
                self.push(Item::Turn(Op::NextStep, temp, top));
            }
        }
        self.push(Item::Label(exit));
    }
}
