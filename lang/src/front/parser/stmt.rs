//! One statement of a line.

use super::control;
use super::declare;
use super::expr::{arguments, bit, expr};
use super::foreign;
use super::gcode;
use super::input::{In, Parsed, comma, kw, name, text, tok};
use super::machine::{begins_action, machine, set_aout, sync};
use super::piece::{Closer, Opener, Piece};
use super::sugar;
use crate::front::ast::{Expr, Name, StmtKind};
use crate::front::codes::Code;
use crate::front::diag::Diag;
use crate::front::token::{Sign, Tok};
use crate::front::words::{Class, Kw};
use nom::Parser;
use nom::combinator::{cut, map};
use nom::multi::separated_list1;
use nom::sequence::preceded;

/// The statement that stands here, without the `:` or line end behind it.
pub fn piece(i: In<'_>) -> Parsed<'_, Piece> {
    match i.tok() {
        Tok::GWord | Tok::GLetter => map(gcode::block, Piece::Stmt).parse(i),
        Tok::Label => label(i),
        Tok::Kw(kw) if kw.is_soft() => named(i),
        Tok::Kw(kw) => keyword(kw, i),
        Tok::Quiet(kw) => {
            map(|j| machine(kw, true, j), |m| Piece::Stmt(StmtKind::Machine(Box::new(m))))
                .parse(i.rest())
        }
        Tok::Name => named(i),
        Tok::Bad => Err(i.expected("a statement")),
        _ => Err(i.fail(foreign::no_statement(i))),
    }
}

/// Whether the statement ends here; if not, why.
pub fn end(i: In<'_>) -> Parsed<'_, ()> {
    if i.at_end() { Ok((i, ())) } else { Err(i.fail_or_expect(foreign::surplus(i))) }
}

impl<'a> In<'a> {
    /// The diagnostic as an error, or the end of the statement as what was expected.
    fn fail_or_expect(self, diag: Option<Diag>) -> nom::Err<super::input::Failure> {
        match diag {
            Some(diag) => self.fail(diag),
            None => self.expected("the end of the statement"),
        }
    }
}

fn label(i: In<'_>) -> Parsed<'_, Piece> {
    let mut name_token = i.first();
    name_token.span.end -= 1;
    let word = name_token.span.of(i.context.text);
    let key = word.to_ascii_lowercase();
    if i.context.routines.contains(&key) {
        let diag = Diag::new(
            Code::LabelIsSub,
            name_token.span,
            format!("`{word}` is a SUB or FUNCTION and can not be a label"),
        )
        .hint(format!("to call it at the start of a line write `CALL {word}`"));
        return Err(i.fail(diag));
    }
    name_token.tok = Tok::Name;
    let alone = [name_token];
    let checked = name(In { tokens: &alone, ..i }).map(|(_, name)| name);
    match checked {
        Ok(name) => Ok((i.rest(), Piece::Stmt(StmtKind::Label(name)))),
        Err(error) => Err(error),
    }
}

fn keyword(kw_: Kw, i: In<'_>) -> Parsed<'_, Piece> {
    let rest = i.rest();
    let stmt = |(rest, kind)| Ok((rest, Piece::Stmt(kind)));
    match kw_ {
        Kw::Profile => map(cut(text), Piece::Profile).parse(rest),
        Kw::Const => stmt(map(declare::equations, StmtKind::Const).parse(rest)?),
        Kw::Input | Kw::Output => {
            let output = kw_ == Kw::Output;
            let ports = map(declare::equations, |ports| StmtKind::Port { output, ports });
            stmt({ ports }.parse(rest)?)
        }
        Kw::Wait if rest.tok() == Tok::Kw(Kw::Until) => sugar::wait_until(i),
        Kw::Dim => declare::dim(rest),
        Kw::Keep => stmt(map(declare::keep, StmtKind::Keep).parse(rest)?),
        Kw::Table => stmt(declare::table(rest)?),
        Kw::Sub => control::routine(false)(rest),
        Kw::Function => control::routine(true)(rest),
        Kw::If => control::if_(i),
        Kw::ElseIf => control::else_if(rest),
        Kw::Else => Ok((rest, Piece::Else)),
        Kw::Select => control::select(rest),
        Kw::Case => control::case(rest),
        Kw::For => control::for_(rest),
        Kw::Next => control::next(rest),
        Kw::While => map(cut(expr), |c| Piece::Open(Opener::While(c))).parse(rest),
        Kw::Wend => Ok((rest, Piece::Close(Closer::While))),
        Kw::Do => map(control::test, |t| Piece::Open(Opener::Do(t))).parse(rest),
        Kw::Loop => map(control::test, |t| Piece::Close(Closer::Do(t))).parse(rest),
        Kw::Repeat => map(cut(expr), |n| Piece::Open(Opener::Repeat(n))).parse(rest),
        Kw::Exit => stmt(map(|j| control::target(Kw::Exit, j), StmtKind::Exit).parse(rest)?),
        Kw::Continue => {
            stmt(map(|j| control::target(Kw::Continue, j), StmtKind::Continue).parse(rest)?)
        }
        Kw::Goto => stmt(map(control::label, StmtKind::Goto).parse(rest)?),
        Kw::Gosub => stmt(map(control::label, StmtKind::Gosub).parse(rest)?),
        Kw::Return if rest.at_end() => stmt((rest, StmtKind::Return(None))),
        Kw::Return => stmt(map(expr, |e| StmtKind::Return(Some(e))).parse(rest)?),
        Kw::Call => stmt(call(rest)?),
        Kw::End => end_word(rest),
        Kw::Run => stmt(map(cut(text), StmtKind::Run).parse(rest)?),
        Kw::On => stmt(control::on(rest)?),
        Kw::Resume if rest.at_end() => stmt((rest, StmtKind::Resume)),
        Kw::Resume => stmt(map(kw(Kw::Next), |_| StmtKind::ResumeNext).parse(rest)?),
        kw_ if kw_.entry().class == Class::Machine => {
            stmt(map(|j| machine(kw_, false, j), |m| StmtKind::Machine(Box::new(m))).parse(rest)?)
        }
        _ => Err(i.fail(foreign::no_statement(i))),
    }
}

/// END, and the closing lines that begin with it; `i` stands behind the word.
fn end_word(i: In<'_>) -> Parsed<'_, Piece> {
    let closer = match i.tok() {
        Tok::Kw(Kw::If) => Closer::If,
        Tok::Kw(Kw::Select) => Closer::Select,
        Tok::Kw(Kw::Repeat) => Closer::Repeat,
        Tok::Kw(Kw::Sub) => Closer::Sub,
        Tok::Kw(Kw::Function) => Closer::Function,
        _ => return Ok((i, Piece::Stmt(StmtKind::End))),
    };
    Ok((i.rest(), Piece::Close(closer)))
}

/// `CALL name` or `CALL name(...)`
fn call(i: In<'_>) -> Parsed<'_, StmtKind> {
    let (rest, name) = cut(name).parse(i)?;
    if rest.tok() == Tok::Sign(Sign::Open) {
        return map(arguments, |(args, _)| StmtKind::Call { name: name.clone(), args }).parse(rest);
    }
    Ok((rest, StmtKind::Call { name, args: Vec::new() }))
}

/// An assignment or a call.
fn named(i: In<'_>) -> Parsed<'_, Piece> {
    let next = i.second().tok;
    let key = i.word().to_ascii_lowercase();
    let routine = i.context.routines.contains(&key);
    let assigned = |rest: In<'_>| {
        let rest = if rest.tok() == Tok::Bit { rest.rest() } else { rest };
        rest.tok() == Tok::Sign(Sign::Eq)
    };
    let assigns = assigned(i.rest())
        || (next == Tok::Sign(Sign::Open)
            && !routine
            && behind_parentheses(i.rest()).is_some_and(assigned));
    if routine && !assigns {
        let (rest, name) = name(i)?;
        return map(call_list, |args| Piece::Stmt(StmtKind::Call { name: name.clone(), args }))
            .parse(rest);
    }
    if i.tok() == Tok::Kw(Kw::Analog) && !assigns {
        return map(declare::equations, |list| Piece::Stmt(StmtKind::Analog(list))).parse(i.rest());
    }
    if i.tok() == Tok::Kw(Kw::Sync) && !assigns && begins_action(i.rest()) {
        return map(sync, |m| Piece::Stmt(StmtKind::Machine(Box::new(m)))).parse(i.rest());
    }
    if i.tok() == Tok::Kw(Kw::SetAout) && !assigns {
        return map(set_aout, |m| Piece::Stmt(StmtKind::Machine(Box::new(m)))).parse(i.rest());
    }
    if !assigns {
        return Err(match next {
            Tok::Bad => i.rest().expected("`=`"),
            _ => i.fail(foreign::unknown_statement(i)),
        });
    }
    let (rest, target): (_, Name) = cut(name).parse(i)?;
    let (rest, index) = match next {
        Tok::Sign(Sign::Open) => map(arguments, |(args, _)| args).parse(rest)?,
        _ => (rest, Vec::new()),
    };
    let (rest, bit) = match rest.tok() {
        Tok::Bit => map(bit, Some).parse(rest)?,
        _ => (rest, None),
    };
    let (rest, value) = preceded(cut(tok(Tok::Sign(Sign::Eq), "`=`")), cut(expr)).parse(rest)?;
    Ok((rest, Piece::Stmt(StmtKind::Assign { target, index, bit, value })))
}

/// The arguments of a call without CALL: one pair of parentheses may stand round all of them.
fn call_list(i: In<'_>) -> Parsed<'_, Vec<Expr>> {
    if i.at_end() {
        return Ok((i, Vec::new()));
    }
    if i.tok() == Tok::Sign(Sign::Open) && behind_parentheses(i).is_some_and(In::at_end) {
        return map(arguments, |(args, _)| args).parse(i);
    }
    separated_list1(comma, cut(expr)).parse(i)
}

/// What stands behind the parenthesis that matches the one here; None where it is not closed in
/// this statement.
pub fn behind_parentheses(i: In<'_>) -> Option<In<'_>> {
    let mut open = 0usize;
    let mut rest = i;
    while !rest.at_end() {
        match rest.tok() {
            Tok::Sign(Sign::Open) => open += 1,
            Tok::Sign(Sign::Close) => open = open.saturating_sub(1),
            _ => {}
        }
        rest = rest.rest();
        if open == 0 {
            return Some(rest);
        }
    }
    None
}
