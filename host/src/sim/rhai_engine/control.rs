//! IF, SELECT and the loops.

use lang::hir::{Arm, BinOp, Block, Case, DoTest, Expr, LoopKind, Stmt, StmtKind, VarId};

use super::expr::comparison;
use super::translate::{Loop, Translator};

impl Translator<'_> {
    /// The innermost loop of a kind.
    pub(super) fn loop_of(&self, kind: LoopKind) -> Option<Loop> {
        self.loops.iter().rev().find(|inner| inner.kind == kind).copied()
    }

    fn looped(&mut self, kind: LoopKind, exit: usize, again: usize, body: &Block) {
        self.loops.push(Loop { kind, exit, again });
        self.block(body);
        self.loops.pop();
    }

    pub(super) fn compare(&mut self, op: BinOp, a: &str, b: &str) -> String {
        format!("{a} {} {b}", comparison(op).unwrap_or("=="))
    }

    /// IF.
    pub(super) fn choice(&mut self, stmt: &Stmt, arms: &[Arm], otherwise: &Block) {
        let end = self.out.block();
        self.out.begin(stmt.line, end);
        for (index, arm) in arms.iter().enumerate() {
            if index > 0 {
                self.out.test(arm.line, end);
            }
            let [yes, no] = [self.out.block(), self.out.block()];
            let condition = self.condition(&arm.condition);
            self.out.branch(&condition, yes, no);
            self.out.open(yes);
            self.block(&arm.body);
            self.out.jump(end);
            self.out.open(no);
        }
        self.block(otherwise);
        self.out.open(end);
    }

    /// SELECT.
    pub(super) fn select(
        &mut self,
        stmt: &Stmt,
        value: &Expr,
        temp: VarId,
        cases: &[Case],
        otherwise: &Block,
    ) {
        let end = self.out.block();
        self.out.begin(stmt.line, end);
        let value = self.value(value);
        self.out.line(format!("v{} = {value};", temp.0));
        for case in cases {
            self.out.test(case.line, end);
            let body = self.out.block();
            for test in &case.tests {
                let next = self.out.block();
                let condition = self.case_test(temp.0, test);
                self.out.branch(&condition, body, next);
                self.out.open(next);
            }
            let next = self.out.block();
            self.out.jump(next);
            self.out.open(body);
            self.block(&case.body);
            self.out.jump(end);
            self.out.open(next);
        }
        self.block(otherwise);
        self.out.open(end);
    }

    /// FOR.
    pub(super) fn count(&mut self, stmt: &Stmt) {
        let StmtKind::For { var, from, to, step, to_temp, step_temp, body, next_line } = &stmt.kind
        else {
            return;
        };
        let [pass, again, end] = [self.out.block(), self.out.block(), self.out.block()];
        self.out.begin(stmt.line, end);
        // Start, limit and step in this order; the variable changes last.
        let mut values = self.values(&[from, to, step]);
        if Self::constant(from).is_none() {
            let start = self.out.temp();
            self.out.line(format!("{start} = {};", values[0]));
            values[0] = start;
        }
        let limit = self.held(&values[1], *to_temp);
        let by = self.held(&values[2], *step_temp);
        self.out.line(format!("v{} = {};", var.0, values[0]));
        let constant = Self::constant(step);
        if constant.is_none() || constant == Some(0) {
            self.out.line(format!("nz({by});"));
        }
        let goes_on = match constant {
            Some(0..) => format!("v{} <= {limit}", var.0),
            Some(_) => format!("v{} >= {limit}", var.0),
            None => format!("if {by} > 0 {{ v{0} <= {limit} }} else {{ v{0} >= {limit} }}", var.0),
        };
        self.out.branch(&goes_on, pass, end);
        self.out.open(pass);
        self.looped(LoopKind::For, end, again, body);
        self.out.open(again);
        self.out.begin(*next_line, end);
        self.out.line(format!("v{0} = v{0} + {by};", var.0));
        self.out.branch(&goes_on, pass, end);
        self.out.open(end);
    }

    /// A limit or step: a number, or kept in its hidden variable.
    fn held(&mut self, value: &str, temp: Option<VarId>) -> String {
        match temp {
            Some(temp) => {
                self.out.line(format!("v{} = {value};", temp.0));
                format!("v{}", temp.0)
            }
            None => value.to_owned(),
        }
    }

    /// WHILE.
    pub(super) fn while_loop(&mut self, stmt: &Stmt, condition: &Expr, body: &Block) {
        let [head, pass, end] = [self.out.block(), self.out.block(), self.out.block()];
        self.out.open(head);
        self.out.begin(stmt.line, end);
        let condition = self.condition(condition);
        self.out.branch(&condition, pass, end);
        self.out.open(pass);
        self.looped(LoopKind::While, end, head, body);
        self.out.jump(head);
        self.out.open(end);
    }

    /// DO.
    pub(super) fn do_loop(
        &mut self,
        stmt: &Stmt,
        before: Option<&DoTest>,
        body: &Block,
        after: Option<&DoTest>,
    ) {
        let [head, pass, test] = [self.out.block(), self.out.block(), self.out.block()];
        let end = self.out.block();
        self.out.open(head);
        if let Some(before) = before {
            self.out.begin(before.line, end);
            self.do_test(before, pass, end);
        }
        self.out.open(pass);
        self.looped(LoopKind::Do, end, test, body);
        self.out.open(test);
        if let Some(after) = after {
            self.out.begin(after.line, end);
            self.do_test(after, head, end);
        } else {
            if before.is_none() {
                // Without any condition LOOP is what takes time.
                self.out.begin(stmt.line, end);
            }
            self.out.jump(head);
        }
        self.out.open(end);
    }

    fn do_test(&mut self, test: &DoTest, goes_on: usize, end: usize) {
        let condition = self.condition(&test.condition);
        let (yes, no) = if test.until { (end, goes_on) } else { (goes_on, end) };
        self.out.branch(&condition, yes, no);
    }

    /// REPEAT.
    pub(super) fn repeat(&mut self, stmt: &Stmt, count: &Expr, temp: VarId, body: &Block) {
        let [pass, again, end] = [self.out.block(), self.out.block(), self.out.block()];
        self.out.begin(stmt.line, end);
        let count = self.value(count);
        self.out.line(format!("v{} = {count};", temp.0));
        let goes_on = format!("v{} >= 1", temp.0);
        self.out.branch(&goes_on, pass, end);
        self.out.open(pass);
        self.looped(LoopKind::Repeat, end, again, body);
        self.out.open(again);
        self.out.begin(stmt.line, end);
        self.out.line(format!("v{0} = v{0} - 1;", temp.0));
        self.out.branch(&goes_on, pass, end);
        self.out.open(end);
    }
}
