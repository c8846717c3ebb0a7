//! Control statements, and the one-line IF.

use super::expr::expr;
use super::foreign;
use super::input::{Failure, In, Parsed, comma, kw, name, tok};
use super::piece::{Closer, ForHead, Opener, Piece, enclosing};
use super::stmt;
use crate::effect::Want;
use crate::front::ast::{
    Arm, BinaryOp, Block, CaseTest, Enclosing, KindRef, Param, Stmt, StmtKind, Test,
};
use crate::front::codes::Code;
use crate::front::diag::Diag;
use crate::front::token::{Sign, Tok};
use crate::front::words::Kw;
use crate::kind::Kind;
use nom::Parser;
use nom::branch::alt;
use nom::combinator::{cut, map, opt, value};
use nom::multi::separated_list1;
use nom::sequence::{delimited, preceded};

/// IF in both forms.
pub fn if_(i: In<'_>) -> Parsed<'_, Piece> {
    let (rest, cond) = cut(expr).parse(i.rest())?;
    let (rest, _) = cut(kw(Kw::Then)).parse(rest)?;
    if rest.tok() == Tok::LineEnd {
        return Ok((rest, Piece::Open(Opener::If(cond))));
    }
    let line = i.first().line;
    let (rest, body) = one_line(rest.deeper()?)?;
    let (rest, otherwise) = match rest.tok() {
        Tok::Kw(Kw::Else) => map(one_line, Some).parse(rest.rest())?,
        _ => (rest, None),
    };
    let arms = vec![Arm { cond, body, line }];
    let kind = StmtKind::If { arms, otherwise, one_line: true };
    Ok((rest.back_to(i), Piece::Stmt(kind)))
}

/// The statements of a part of a one-line IF, up to ELSE or the line's end.
fn one_line(i: In<'_>) -> Parsed<'_, Block> {
    let mut block = Block::new();
    let mut rest = i;
    loop {
        match rest.tok() {
            Tok::LineEnd | Tok::Kw(Kw::Else) => return Ok((rest, block)),
            Tok::Sign(Sign::Colon) => rest = rest.rest(),
            _ => {
                let (after, piece) = cut(stmt::piece).parse(rest)?;
                let span = rest.span_to(after);
                match piece {
                    Piece::Stmt(kind) => {
                        block.push(Stmt { kind, span, line: rest.first().line });
                    }
                    Piece::Several(kinds) => {
                        let line = rest.first().line;
                        block.extend(kinds.into_iter().map(|kind| Stmt { kind, span, line }));
                    }
                    other => return Err(rest.fail(foreign::in_one_line(rest, span, &other))),
                }
                if let Some(diag) = foreign::one_line_end(after) {
                    return Err(after.fail(diag));
                }
                let (after, ()) = stmt::end(after)?;
                rest = after;
            }
        }
    }
}

/// `ELSEIF c THEN`
pub fn else_if(i: In<'_>) -> Parsed<'_, Piece> {
    let (rest, cond) = cut(expr).parse(i)?;
    let (rest, _) = cut(kw(Kw::Then)).parse(rest)?;
    Ok((rest, Piece::ElseIf(cond)))
}

/// `SELECT CASE e`
pub fn select(i: In<'_>) -> Parsed<'_, Piece> {
    let (rest, value) = preceded(cut(kw(Kw::Case)), cut(expr)).parse(i)?;
    Ok((rest, Piece::Open(Opener::Select(value))))
}

/// `CASE 1, 5 TO 9, IS < 0` or `CASE ELSE`
pub fn case(i: In<'_>) -> Parsed<'_, Piece> {
    if i.tok() == Tok::Kw(Kw::Else) {
        return Ok((i.rest(), Piece::CaseElse));
    }
    map(separated_list1(comma, cut(case_test)), Piece::Case).parse(i)
}

fn case_test(i: In<'_>) -> Parsed<'_, CaseTest> {
    if i.tok() == Tok::Kw(Kw::Is) {
        let (rest, op) = cut(comparison).parse(i.rest())?;
        return map(cut(expr), |e| CaseTest::Is(op, e)).parse(rest);
    }
    if comparison(i).is_ok() {
        let diag = Diag::new(Code::Expected, i.first().span, "a comparison in CASE needs IS");
        return Err(i.fail(diag.hint(format!("write `CASE IS {}`", i.word()))));
    }
    let (rest, first) = expr(i)?;
    let (rest, last) = opt(preceded(kw(Kw::To), cut(expr))).parse(rest)?;
    Ok((
        rest,
        match last {
            Some(last) => CaseTest::Range(first, last),
            None => CaseTest::Value(first),
        },
    ))
}

fn comparison(i: In<'_>) -> Parsed<'_, BinaryOp> {
    let op = match i.tok() {
        Tok::Sign(Sign::Eq) => BinaryOp::Eq,
        Tok::Sign(Sign::Ne) => BinaryOp::Ne,
        Tok::Sign(Sign::Lt) => BinaryOp::Lt,
        Tok::Sign(Sign::Le) => BinaryOp::Le,
        Tok::Sign(Sign::Gt) => BinaryOp::Gt,
        Tok::Sign(Sign::Ge) => BinaryOp::Ge,
        _ => return Err(i.expected("a comparison (`=` `<>` `<` `<=` `>` `>=`)")),
    };
    Ok((i.rest(), op))
}

/// `FOR v = a TO b [STEP s]`
pub fn for_(i: In<'_>) -> Parsed<'_, Piece> {
    let (rest, var) = cut(name).parse(i)?;
    let (rest, _) = cut(tok(Tok::Sign(Sign::Eq), "`=`")).parse(rest)?;
    let (rest, from) = cut(expr).parse(rest)?;
    let (rest, to) = preceded(cut(kw(Kw::To)), cut(expr)).parse(rest)?;
    let (rest, step) = opt(preceded(kw(Kw::Step), cut(expr))).parse(rest)?;
    Ok((rest, Piece::Open(Opener::For(Box::new(ForHead { var, from, to, step })))))
}

/// `NEXT [v]`
pub fn next(i: In<'_>) -> Parsed<'_, Piece> {
    let (rest, var) = if i.at_end() { (i, None) } else { map(cut(name), Some).parse(i)? };
    Ok((rest, Piece::Close(Closer::For(var))))
}

/// The test of DO or LOOP, if there is one.
pub fn test(i: In<'_>) -> Parsed<'_, Option<Test>> {
    let until = match i.tok() {
        Tok::Kw(Kw::Until) => true,
        Tok::Kw(Kw::While) => false,
        _ => return Ok((i, None)),
    };
    map(cut(expr), |cond| Some(Test { until, cond })).parse(i.rest())
}

/// What EXIT and CONTINUE name.
pub fn target<'a>(word: Kw, i: In<'a>) -> Parsed<'a, Enclosing> {
    let what = if word == Kw::Exit {
        "FOR, WHILE, DO, REPEAT, SUB or FUNCTION"
    } else {
        "FOR, WHILE, DO or REPEAT"
    };
    let named = match i.tok() {
        Tok::Kw(kw) => enclosing(kw),
        _ => None,
    };
    let routine = matches!(named, Some(Enclosing::Sub | Enclosing::Function));
    match named {
        Some(named) if word == Kw::Exit || !routine => Ok((i.rest(), named)),
        _ => {
            let message = format!("{} needs what it is about: {what}", word.text());
            let diag = Diag::new(Code::Expected, i.first().span, message);
            Err(i.fail(diag.hint(format!("write `{} FOR` or what else it is in", word.text()))))
        }
    }
}

/// A label's name behind GOTO or GOSUB.
pub fn label(i: In<'_>) -> Parsed<'_, crate::front::ast::Name> {
    if i.tok() == Tok::Number {
        let diag = Diag::new(Code::LineNumber, i.first().span, "lines have no numbers")
            .hint("write a label, `name:` at the start of its line, and go to that");
        return Err(i.fail(diag));
    }
    cut(name).parse(i)
}

/// `ON ...`
pub fn on(i: In<'_>) -> Parsed<'_, StmtKind> {
    let rest = i.rest();
    match i.tok() {
        Tok::Kw(Kw::Error) => alt((
            value(StmtKind::OnError(None), kw(Kw::Stop)),
            map(preceded(kw(Kw::Goto), label), |label| StmtKind::OnError(Some(label))),
        ))
        .parse(rest),
        Tok::Kw(Kw::Every) if rest.tok() == Tok::Kw(Kw::Off) && rest.rest().at_end() => {
            Ok((rest.rest(), StmtKind::OnEvery(None)))
        }
        Tok::Kw(Kw::Every) => {
            let (rest, every) = cut(expr).parse(rest)?;
            let (rest, target) = preceded(cut(kw(Kw::Gosub)), label).parse(rest)?;
            Ok((rest, StmtKind::OnEvery(Some((every, target)))))
        }
        Tok::Func(crate::front::words::Func::In) => {
            let (rest, input) = cut(expr).parse(rest)?;
            let (rest, edge) = alt((
                value(Some(Want::Rise), kw(Kw::Rise)),
                value(Some(Want::Fall), kw(Kw::Fall)),
                value(None, kw(Kw::Off)),
            ))
            .parse(rest)?;
            let Some(edge) = edge else {
                return Ok((rest, StmtKind::OnIn { input, handler: None }));
            };
            let (rest, target) = preceded(cut(kw(Kw::Gosub)), label).parse(rest)?;
            Ok((rest, StmtKind::OnIn { input, handler: Some((edge, target)) }))
        }
        _ => Err(i.expected("ERROR, IN or EVERY")),
    }
}

/// `AS kind`, if it is there.
pub fn as_kind(i: In<'_>) -> Parsed<'_, Option<KindRef>> {
    if i.tok() != Tok::Kw(Kw::As) {
        return Ok((i, None));
    }
    let i = i.rest();
    let span = i.first().span;
    match Kind::from_name(i.word()) {
        Some(kind) => Ok((i.rest(), Some(KindRef { kind, span }))),
        None if matches!(i.tok(), Tok::Bad | Tok::LineEnd) => {
            Err(i.expected("a kind").into_failure())
        }
        None => Err(i.fail(foreign::kind(i))),
    }
}

/// Turns an error that another branch may avert into a final one.
trait Final {
    fn into_failure(self) -> Self;
}

impl Final for nom::Err<Failure> {
    fn into_failure(self) -> Self {
        match self {
            Self::Error(e) => Self::Failure(e),
            other => other,
        }
    }
}

/// `SUB name(...)`, `FUNCTION name(...) AS kind`
pub fn routine(is_function: bool) -> impl Fn(In<'_>) -> Parsed<'_, Piece> {
    move |i| {
        let (rest, name) = cut(name).parse(i)?;
        let (rest, params) = match rest.tok() {
            Tok::Sign(Sign::Open) if rest.second().tok == Tok::Sign(Sign::Close) => {
                (rest.rest().rest(), Vec::new())
            }
            Tok::Sign(Sign::Open) => delimited(
                tok(Tok::Sign(Sign::Open), "`(`"),
                separated_list1(comma, cut(param)),
                cut(tok(Tok::Sign(Sign::Close), "`)`")),
            )
            .parse(rest)?,
            _ => (rest, Vec::new()),
        };
        let (rest, result) = if is_function { as_kind(rest)? } else { (rest, None) };
        Ok((rest, Piece::Open(Opener::Routine { name, is_function, params, result })))
    }
}

fn param(i: In<'_>) -> Parsed<'_, Param> {
    map((name, as_kind), |(name, kind)| Param { name, kind }).parse(i)
}
