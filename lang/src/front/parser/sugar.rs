//! Statements that the parser writes out in others: what they compile to is in every machine already.
//!
//! Names that a script can not see have a blank in them.

use super::expr::{expr, optional_expr};
use super::input::{In, Parsed};
use super::piece::Piece;
use crate::front::ast::{
    Arm, BinaryOp, Enclosing, Expr, ExprKind, KindRef, Name, Stmt, StmtKind, Test, Variable,
};
use crate::front::codes::Code;
use crate::front::diag::Diag;
use crate::front::span::Span;
use crate::front::words::Func;
use crate::kind::Kind;
use nom::Parser;
use nom::combinator::cut;

/// The variable that holds TIMEDOUT in a script that has a WAIT UNTIL with a time and reads it.
pub const TIMED_OUT: &str = "timed out";
/// Longest time of a WAIT UNTIL, in ms: half of what TIMER counts before it goes on from its least value.
const LONGEST: i32 = (1 << 30) - 1;

/// A name of the compiler's own.
fn hidden(text: &str, key: &str, span: Span) -> Name {
    Name { text: text.into(), key: key.into(), span }
}

/// A variable of the compiler's own.
pub fn variable(name: Name, kind: Kind) -> Variable {
    let kind = Some(KindRef { kind, span: name.span });
    Variable { name, size: None, kind, at: None, label: None, least: None, greatest: None }
}

/// The variable [`TIMED_OUT`].
pub fn timed_out(span: Span) -> Name {
    hidden(TIMED_OUT, TIMED_OUT, span)
}

/// `WAIT UNTIL condition [, time]`; `i` stands at WAIT.
///
/// ```text
/// limit = time : limit = limit + TIMER() : timed out = FALSE
/// DO UNTIL condition
///   IF TIMER() - limit >= 0ms THEN timed out = TRUE : EXIT DO
/// LOOP
/// ```
/// Without a time the body is empty. The time goes into the variable first, so that one of another
/// kind is refused by the name of the variable.
pub fn wait_until(i: In<'_>) -> Parsed<'_, Piece> {
    let (rest, cond) = cut(expr).parse(i.rest().rest())?;
    let (rest, time) = optional_expr(rest)?;
    let (span, line) = (i.span_to(rest), i.first().line);
    let stmt = |kind| Stmt { kind, span, line };
    let before = Some(Box::new(Test { until: true, cond }));
    let wait = |body| StmtKind::Do { before, body, after: None, loop_line: line };
    let Some(time) = time else { return Ok((rest, Piece::Stmt(wait(Vec::new())))) };
    if let ExprKind::Literal { kind: Kind::Time, value: LONGEST.. } = time.kind {
        let diag = Diag::new(Code::NumberRange, time.span, "a WAIT UNTIL of more than 12 days");
        return Err(i.fail(diag.hint("leave the time out to wait for ever")));
    }
    let at = time.span;
    let limit = hidden("time of WAIT UNTIL", &format!("until {}", span.start), at);
    let expr = |kind| Expr { kind, span: at };
    let literal = |kind, value| expr(ExprKind::Literal { kind, value });
    let timer = || Box::new(expr(ExprKind::Builtin(Func::Timer, Vec::new())));
    let read = || Box::new(expr(ExprKind::Name(limit.clone())));
    let set = |target, value| StmtKind::Assign { target, index: Vec::new(), bit: None, value };
    let end = expr(ExprKind::Binary(BinaryOp::Add, read(), timer()));
    let mut parts = vec![
        StmtKind::Dim(vec![variable(limit.clone(), Kind::Time)]),
        set(limit.clone(), time),
        set(limit.clone(), end),
    ];
    let mut over = Vec::new();
    if i.context.reads_timed_out {
        i.context.timed_waits.set(true);
        parts.push(set(timed_out(at), literal(Kind::Truth, 0)));
        over.push(stmt(set(timed_out(at), literal(Kind::Truth, 1))));
    }
    over.push(stmt(StmtKind::Exit(Enclosing::Do)));
    let left = Box::new(expr(ExprKind::Binary(BinaryOp::Sub, timer(), read())));
    let zero = Box::new(literal(Kind::Time, 0));
    let cond = expr(ExprKind::Binary(BinaryOp::Ge, left, zero));
    let arms = vec![Arm { cond, body: over, line }];
    parts.push(wait(vec![stmt(StmtKind::If { arms, otherwise: None, one_line: true })]));
    Ok((rest, Piece::Several(parts)))
}
