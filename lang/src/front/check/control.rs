//! Structured statements: IF, SELECT, FOR, WHILE, DO, REPEAT.
//!
//! Every part is checked even where an earlier one was wrong, so that one run shows all errors.

use super::names::Entity;
use super::stmt::{Lowered, Then};
use super::{Checker, expr::number, expr::value_of, kinds};
use crate::fault::Fault;
use crate::front::ast::{self, BinaryOp, Block, Expr, Name, Stmt, StmtKind};
use crate::front::codes::Code;
use crate::front::span::Span;
use crate::hir::{self, BinOp, LoopKind};
use crate::kind::Kind;

impl<'a> Checker<'a> {
    pub(super) fn compound(&mut self, stmt: &'a Stmt) -> Option<Lowered> {
        match &stmt.kind {
            StmtKind::If { arms, otherwise, one_line } => {
                self.if_stmt(arms, otherwise.as_ref(), *one_line)
            }
            StmtKind::Select { value, cases, otherwise } => {
                self.select(value, cases, otherwise.as_ref(), stmt.span)
            }
            StmtKind::For { var, from, to, step, body, next_line, .. } => {
                self.for_stmt(var, [from, to], step.as_deref(), body, *next_line)
            }
            StmtKind::While { cond, body, .. } => {
                let condition = self.condition(cond, "the condition of WHILE");
                let (body, left) = self.loop_body(LoopKind::While, body);
                let condition = condition?;
                let forever = value_of(&condition).is_some_and(|c| c != 0);
                let kind = hir::StmtKind::While { condition, body };
                Some((vec![kind], ends(forever && !left)))
            }
            StmtKind::Do { before, body, after, loop_line } => {
                self.do_stmt(before.as_deref(), body, after.as_deref(), *loop_line, stmt.line)
            }
            StmtKind::Repeat { count, body, .. } => {
                let lowered = self.plain(count, "REPEAT");
                let (body, _) = self.loop_body(LoopKind::Repeat, body);
                let temp = self.hidden("repeat counter", Kind::Number, count.span);
                Some((vec![hir::StmtKind::Repeat { count: lowered?, temp, body }], Then::GoesOn))
            }
            _ => None,
        }
    }

    /// Lowers a loop's body; says whether an EXIT leaves it.
    fn loop_body(&mut self, kind: LoopKind, body: &'a Block) -> (hir::Block, bool) {
        self.around.loops.push((kind, false));
        let (body, _) = self.block(body);
        let left = self.around.loops.pop().is_some_and(|(_, left)| left);
        (body, left)
    }

    fn if_stmt(
        &mut self,
        arms: &'a [ast::Arm],
        otherwise: Option<&'a Block>,
        one_line: bool,
    ) -> Option<Lowered> {
        let mut lowered = Vec::with_capacity(arms.len());
        let mut goes_on = otherwise.is_none();
        let mut wrong = false;
        for (i, arm) in arms.iter().enumerate() {
            self.statements += u32::from(i > 0);
            let condition = self.condition(&arm.cond, "the condition of IF");
            let (body, then) = self.block(&arm.body);
            goes_on |= then == Then::GoesOn;
            match condition {
                Some(condition) => lowered.push(hir::Arm { line: arm.line, condition, body }),
                None => wrong = true,
            }
        }
        let otherwise = otherwise.map_or_else(Vec::new, |block| {
            let (block, then) = self.block(block);
            goes_on |= then == Then::GoesOn;
            block
        });
        if wrong {
            return None;
        }
        let kind = hir::StmtKind::If { arms: lowered, otherwise, one_line };
        Some((vec![kind], ends(!goes_on)))
    }

    fn select(
        &mut self,
        value: &'a Expr,
        cases: &'a [ast::Case],
        otherwise: Option<&'a Block>,
        span: Span,
    ) -> Option<Lowered> {
        let lowered = self.expr(value);
        let kind = lowered.as_ref().map(|v| v.kind);
        let temp = self.hidden("select value", kind.unwrap_or(Kind::Number), span);
        let mut list = Vec::with_capacity(cases.len());
        let mut goes_on = otherwise.is_none();
        let mut wrong = false;
        for case in cases {
            self.statements += 1;
            let mut tests = Vec::with_capacity(case.tests.len());
            for test in &case.tests {
                match self.case_test(test, kind) {
                    Some(test) => tests.push(test),
                    None => wrong = true,
                }
            }
            let (body, then) = self.block(&case.body);
            goes_on |= then == Then::GoesOn;
            list.push(hir::Case { line: case.line, tests, body });
        }
        let otherwise = otherwise.map_or_else(Vec::new, |block| {
            let (block, then) = self.block(block);
            goes_on |= then == Then::GoesOn;
            block
        });
        let value = lowered?;
        if wrong {
            return None;
        }
        let kind = hir::StmtKind::Select { value: Box::new(value), temp, cases: list, otherwise };
        Some((vec![kind], ends(!goes_on)))
    }

    fn case_test(&mut self, test: &'a ast::CaseTest, kind: Option<Kind>) -> Option<hir::CaseTest> {
        match test {
            ast::CaseTest::Value(e) => Some(hir::CaseTest::Equal(self.case_value(e, kind)?)),
            ast::CaseTest::Range(low, high) => {
                let low_value = self.case_value(low, kind);
                let high_value = self.case_value(high, kind);
                let (low_value, high_value) = (low_value?, high_value?);
                if let (Some(a), Some(b)) = (value_of(&low_value), value_of(&high_value))
                    && a > b
                {
                    let hint = "write the lesser one first: `CASE 5 TO 9`";
                    self.error(
                        Code::EmptyRange,
                        low.span.to(high.span),
                        "no value lies in this range",
                        hint,
                    );
                }
                Some(hir::CaseTest::Range(low_value, high_value))
            }
            ast::CaseTest::Is(op, e) => {
                let op = match op {
                    BinaryOp::Eq => BinOp::Eq,
                    BinaryOp::Ne => BinOp::Ne,
                    BinaryOp::Lt => BinOp::Lt,
                    BinaryOp::Le => BinOp::Le,
                    BinaryOp::Gt => BinOp::Gt,
                    _ => BinOp::Ge,
                };
                Some(hir::CaseTest::Is(op, self.case_value(e, kind)?))
            }
        }
    }

    fn case_value(&mut self, e: &'a Expr, kind: Option<Kind>) -> Option<hir::Expr> {
        let value = self.expr(e)?;
        let kind = kind?;
        if value.kind == kind || (kinds::is_plain(kind) && kinds::is_plain(value.kind)) {
            return Some(value);
        }
        let what = "CASE, as its SELECT,";
        self.wrong_kind(what, &[kind], e, value.kind);
        None
    }

    fn for_stmt(
        &mut self,
        name: &'a Name,
        [from, to]: [&'a Expr; 2],
        step: Option<&'a Expr>,
        body: &'a Block,
        next_line: u32,
    ) -> Option<Lowered> {
        let symbol = self.resolve(name);
        let from_value = self.expr(from);
        let to_value = self.expr(to);
        let step_value = step.map(|step| self.expr(step));
        let (body, _) = self.loop_body(LoopKind::For, body);
        let symbol = symbol?;
        let var = match symbol.entity {
            Entity::Var(var) if !self.vars[var.0 as usize].array && self.reader(var).is_none() => {
                var
            }
            _ => {
                let message = format!("FOR counts in a variable, `{}` is none", name.text);
                self.error(Code::WrongUse, name.span, message, "declare one: `DIM i`");
                return None;
            }
        };
        let kind = self.vars[var.0 as usize].kind;
        if kind == Kind::Truth {
            let message = format!("FOR can not count in `{}`, a Truth", name.text);
            self.error(Code::AssignKind, name.span, message, "declare it `AS NUMBER`");
            return None;
        }
        let what = format!("FOR `{}`, {},", name.text, kinds::a(kind));
        let mut fits = |value: Option<hir::Expr>, e: &'a Expr| {
            let value = value?;
            if kinds::fits(kind, value.kind) {
                return Some(value);
            }
            self.wrong_kind(&what, &[kind], e, value.kind);
            None
        };
        let from_value = fits(from_value, from);
        let to_value = fits(to_value, to);
        let step_value = match (step, step_value) {
            (Some(step), Some(value)) => fits(value, step),
            _ if kind == Kind::Number => Some(number(1, Kind::Number, name.span)),
            _ => {
                let message =
                    format!("`{}` is {}: its STEP must be written", name.text, kinds::a(kind));
                let example = crate::front::literal::example(kind);
                self.error(Code::StepNeeded, name.span, message, format!("add `STEP {example}`"));
                None
            }
        };
        let (from, to, by) = (from_value?, to_value?, step_value?);
        if value_of(&by) == Some(0) {
            let span = step.map_or(name.span, |s| s.span);
            let hint = "give a step that leads to the limit, or write `DO` ... `LOOP`";
            self.ends_here(Fault::ValueRange, span, "STEP 0 never ends", hint);
        }
        if let (Some(first), Some(last), Some(step)) =
            (value_of(&from), value_of(&to), value_of(&by))
            && (step > 0 && first > last || step < 0 && first < last)
        {
            let (where_, sign) = if step > 0 { ("above", "-") } else { ("below", "") };
            let hint = match step.unsigned_abs() {
                1 if kind == Kind::Number => {
                    format!("write `STEP {sign}1`, or swap start and limit")
                }
                _ => "give STEP the other sign, or swap start and limit".to_owned(),
            };
            self.error(
                Code::EmptyRange,
                name.span,
                format!("this FOR never runs: its start is {where_} its limit"),
                hint,
            );
        }
        let to_temp = value_of(&to).is_none().then(|| self.hidden("for limit", kind, name.span));
        let step_temp = value_of(&by).is_none().then(|| self.hidden("for step", kind, name.span));
        let [from, to, by] = [from, to, by].map(Box::new);
        let kind =
            hir::StmtKind::For { var, from, to, step: by, to_temp, step_temp, body, next_line };
        Some((vec![kind], Then::GoesOn))
    }

    fn do_stmt(
        &mut self,
        before: Option<&'a ast::Test>,
        body: &'a Block,
        after: Option<&'a ast::Test>,
        loop_line: u32,
        line: u32,
    ) -> Option<Lowered> {
        let mut test = |test: Option<&'a ast::Test>, line: u32| {
            test.map(|test| {
                let word = if test.until { "UNTIL" } else { "WHILE" };
                let condition = self.condition(&test.cond, &format!("the condition of {word}"))?;
                Some(Box::new(hir::DoTest { line, until: test.until, condition }))
            })
        };
        // A LOOP with a condition does more than close its block.
        let conditions = u32::from(after.is_some());
        let before = test(before, line);
        let after = test(after, loop_line);
        self.statements += conditions;
        let (body, left) = self.loop_body(LoopKind::Do, body);
        let before = before.map_or(Some(None), |test| test.map(Some))?;
        let after = after.map_or(Some(None), |test| test.map(Some))?;
        let endless = |test: &Option<Box<hir::DoTest>>| match test {
            None => true,
            Some(test) => value_of(&test.condition).is_some_and(|c| (c != 0) != test.until),
        };
        let forever = endless(&before) && endless(&after) && !left;
        Some((vec![hir::StmtKind::Do { before, body, after }], ends(forever)))
    }
}

/// Whether control goes on, given that it never does.
fn ends(never: bool) -> Then {
    if never { Then::Never } else { Then::GoesOn }
}
