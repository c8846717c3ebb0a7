//! Statements that the parser writes out in others: what they compile to is in every machine already.
//!
//! Names that a script can not see have a blank in them.

use super::expr::{expr, optional_expr};
use super::input::{Edge, In, Parsed};
use super::piece::Piece;
use crate::front::ast::{
    Arm, BinaryOp, Block, Enclosing, Expr, ExprKind, KindRef, Name, Routine, Script, Stmt,
    StmtKind, Test, Variable,
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
    let (at, label, least, greatest) = (None, None, None, None);
    Variable { name, size: None, kind, timer: false, at, label, least, greatest }
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

/// Greatest value of a TIMER, in ms: 12 days, well within what the difference of two readings of TIMER holds.
pub const GREATEST: i32 = 12 * 24 * 60 * 60 * 1000;

/// Key of the FUNCTION that reads the TIMER of this key.
pub fn elapsed_key(timer: &str) -> String {
    format!("elapsed {timer}")
}

/// Key of the FUNCTION that looks for the edge that stands at this offset.
pub fn edge_key(start: u32) -> String {
    format!("edge {start}")
}

/// Adds the FUNCTIONs that read TIMERs and edges. They have neither parameters nor locals, so that the main
/// program and handlers may call them.
pub fn add_routines(script: &mut Script, edges: Vec<Edge>) {
    let mut timers = Vec::new();
    timers_of(&script.body, &mut timers);
    script.routines.extend(timers.iter().map(|(name, line)| elapsed(name, *line)));
    for edge in edges.into_iter().filter(|edge| !declares(script, edge.falls)).collect::<Vec<_>>() {
        let (variable, routine) = look(edge);
        let (span, line) = (routine.span, routine.line);
        script.body.push(Stmt { kind: StmtKind::Dim(vec![variable]), span, line });
        script.routines.push(routine);
    }
}

/// The TIMERs that a block declares, with their lines.
fn timers_of(block: &Block, into: &mut Vec<(Name, u32)>) {
    for stmt in block {
        if let StmtKind::Dim(list) = &stmt.kind {
            let timers = list.iter().filter(|variable| variable.timer);
            into.extend(timers.map(|variable| (variable.name.clone(), stmt.line)));
        }
        stmt.blocks().for_each(|inner| timers_of(inner, into));
    }
}

/// Whether a script uses the word RISE, or FALL, as a name of its own.
fn declares(script: &Script, falls: bool) -> bool {
    let key = if falls { "fall" } else { "rise" };
    fn block(list: &Block, key: &str) -> bool {
        list.iter().any(|stmt| {
            let own = match &stmt.kind {
                StmtKind::Dim(list) | StmtKind::Keep(list) => {
                    list.iter().any(|variable| *variable.name.key == *key)
                }
                StmtKind::Table { name, .. } => *name.key == *key,
                StmtKind::Const(list)
                | StmtKind::Analog(list)
                | StmtKind::Port { ports: list, .. } => {
                    list.iter().any(|(name, _)| *name.key == *key)
                }
                _ => false,
            };
            own || stmt.blocks().any(|inner| block(inner, key))
        })
    }
    let routine = |routine: &Routine| {
        *routine.name.key == *key
            || routine.params.iter().any(|param| *param.name.key == *key)
            || block(&routine.body, key)
    };
    block(&script.body, key) || script.routines.iter().any(routine)
}

/// Builds expressions and statements at one place.
struct At(Span, u32);

impl At {
    fn expr(&self, kind: ExprKind) -> Expr {
        Expr { kind, span: self.0 }
    }

    fn literal(&self, kind: Kind, value: i32) -> Expr {
        self.expr(ExprKind::Literal { kind, value })
    }

    fn read(&self, name: &Name) -> Expr {
        self.expr(ExprKind::Name(name.clone()))
    }

    fn binary(&self, op: BinaryOp, left: Expr, right: Expr) -> Expr {
        self.expr(ExprKind::Binary(op, Box::new(left), Box::new(right)))
    }

    fn timer(&self) -> Expr {
        self.expr(ExprKind::Builtin(Func::Timer, Vec::new()))
    }

    fn stmt(&self, kind: StmtKind) -> Stmt {
        Stmt { kind, span: self.0, line: self.1 }
    }

    fn set(&self, target: &Name, value: Expr) -> Stmt {
        let target = Name { span: self.0, ..target.clone() };
        self.stmt(StmtKind::Assign { target, index: Vec::new(), bit: None, value })
    }

    /// A FUNCTION without parameters.
    fn function(&self, text: &str, key: &str, kind: Kind, body: Block) -> Routine {
        Routine {
            name: hidden(text, key, self.0),
            is_function: true,
            params: Vec::new(),
            result: Some(KindRef { kind, span: self.0 }),
            body,
            span: self.0,
            line: 0,
            end_line: 0,
        }
    }
}

/// The FUNCTION that reads a TIMER. The variable holds what TIMER() was when it was restarted. Where more than
/// [`GREATEST`] has gone by, or so much that the difference came round, the variable is set so that the TIMER stands there: it
/// goes on standing as long as it is read once in 24 days.
///
/// ```text
/// IF TIMER() - t >= greatest ORELSE TIMER() - t < 0ms THEN
///   t = TIMER() - greatest
///   RETURN greatest
/// END IF
/// RETURN TIMER() - t
/// ```
fn elapsed(name: &Name, line: u32) -> Routine {
    let at = At(name.span, line);
    let gone = || at.binary(BinaryOp::Sub, at.timer(), at.read(name));
    let greatest = || at.literal(Kind::Time, GREATEST);
    let over = at.binary(BinaryOp::Ge, gone(), greatest());
    let round = at.binary(BinaryOp::Lt, gone(), at.literal(Kind::Time, 0));
    let body = vec![
        at.set(name, at.binary(BinaryOp::Sub, at.timer(), greatest())),
        at.stmt(StmtKind::Return(Some(greatest()))),
    ];
    let arms = vec![Arm { cond: at.binary(BinaryOp::OrElse, over, round), body, line }];
    let body = vec![
        at.stmt(StmtKind::If { arms, otherwise: None, one_line: false }),
        at.stmt(StmtKind::Return(Some(gone()))),
    ];
    at.function(&format!("reading of {}", name.text), &elapsed_key(&name.key), Kind::Time, body)
}

/// The variable and the FUNCTION of an edge. The variable's low two bits are 2, or 3 where the input was on, once there was a
/// look; before they are 0. The two bits above are those of the look before.
///
/// ```text
/// edge = (edge AND 3) << 2 OR 2 OR IN(n)
/// RETURN edge = 11    ' 14 for FALL
/// ```
fn look(edge: Edge) -> (Variable, Routine) {
    let at = At(edge.span, edge.line);
    let key = edge_key(edge.span.start);
    let name = hidden("input at the last look", &format!("{key} before"), edge.span);
    let number = |value| at.literal(Kind::Number, value);
    let low = at.binary(BinaryOp::And, at.read(&name), number(3));
    let before = at.binary(BinaryOp::Shl, low, number(2));
    let now = at.expr(ExprKind::Builtin(Func::In, vec![edge.input]));
    let looked = at.binary(BinaryOp::Or, before, number(2));
    let both = at.binary(BinaryOp::Or, looked, now);
    let met = at.binary(BinaryOp::Eq, at.read(&name), number(if edge.falls { 14 } else { 11 }));
    let body = vec![at.set(&name, both), at.stmt(StmtKind::Return(Some(met)))];
    let text = if edge.falls { "FALL of an input" } else { "RISE of an input" };
    (variable(name, Kind::Number), at.function(text, &key, Kind::Truth, body))
}
