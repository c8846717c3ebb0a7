//! The parser: nom parsers for single statements over the tokens, and a builder for the blocks.
//! A statement that is wrong is reported and skipped, so one run finds many errors.

mod blocks;
mod control;
mod declare;
mod expr;
mod foreign;
mod gcode;
mod input;
mod machine;
mod piece;
mod slips;
mod stmt;
mod sugar;
mod timeouts;

pub use sugar::{GREATEST, TIMED_OUT, edge_key, elapsed_key};

use super::ast::{Script, Stmt, StmtKind};
use super::codes::Code;
use super::diag::{Diag, Diags};
use super::lexer::{begins_gcode, lex};
use super::span::Span;
use super::token::{Sign, Tok, Token};
use super::words::{Func, Kw, lookup};
use crate::kind::Kind;
use blocks::Builder;
use core::cell::{Cell, RefCell};
use input::{Context, In};
use piece::{Opener, Piece, Placed};
use std::collections::BTreeSet;

/// Whether a word can be a name anywhere: words that are names outside of one statement only are
/// left out.
pub fn is_name(word: &str) -> bool {
    let mut bytes = word.bytes();
    bytes.next().is_some_and(|b| b.is_ascii_alphabetic())
        && bytes.all(|b| b.is_ascii_alphanumeric() || b == b'_')
        && !(word.len() == 1 && "xyzXYZ".contains(word))
        && lookup(word).is_none()
        && !begins_gcode(word)
}

/// Parses a script. The tree holds what could be read; it is whole if `diags` got no error.
pub fn parse(text: &str, diags: &mut Diags) -> Script {
    let mut tokens = lex(text, diags);
    tokens.retain(|t| !t.tok.is_trivia());
    let last_line = last_line(&tokens);
    let context = Context {
        text,
        routines: routine_names(text, &tokens),
        declared: declared_names(text, &tokens),
        guesses: Cell::new(0),
        reads_timed_out: tokens.iter().any(|t| t.tok == Tok::Func(Func::TimedOut)),
        timed_waits: Cell::new(false),
        edges: RefCell::default(),
        texts: RefCell::default(),
    };
    let mut builder = Builder::new(diags);
    let mut i = In { tokens: &tokens, context: &context, depth: 0 };
    while !i.tokens.is_empty() && !builder.diags().hopeless() {
        i = match i.tok() {
            Tok::LineEnd | Tok::Sign(Sign::Colon) => i.rest(),
            _ => statement(i, &mut builder),
        };
    }
    let mut script = builder.finish(last_line, text.trim_end().len() as u32);
    timeouts::look(&tokens, context.timed_waits.get(), diags);
    if context.timed_waits.get() {
        let span = Span::point(text.len() as u32);
        let kind = StmtKind::Dim(vec![sugar::variable(sugar::timed_out(span), Kind::Truth)]);
        script.body.push(Stmt { kind, span, line: last_line });
    }
    sugar::add_routines(&mut script, context.edges.take());
    script
}

/// Line of the last token that is no line end, at least 1.
fn last_line(tokens: &[Token]) -> u32 {
    tokens.iter().rev().find(|t| t.tok != Tok::LineEnd).map_or(1, |t| t.line)
}

/// The names behind SUB and FUNCTION that open one: `EXIT SUB` and `END SUB` name none.
fn routine_names(text: &str, tokens: &[Token]) -> BTreeSet<String> {
    let mut before = Tok::LineEnd;
    let mut names = BTreeSet::new();
    for pair in tokens.windows(2) {
        let opens = matches!(pair[0].tok, Tok::Kw(Kw::Sub | Kw::Function))
            && !matches!(before, Tok::Kw(Kw::End | Kw::Exit));
        let soft = matches!(pair[1].tok, Tok::Kw(kw) if kw.is_soft());
        if opens && (soft || pair[1].tok == Tok::Name) {
            names.insert(pair[1].span.of(text).to_ascii_lowercase());
        }
        before = pair[0].tok;
    }
    names
}

/// The names in statements that declare some, as they are written.
fn declared_names<'a>(text: &'a str, tokens: &[Token]) -> BTreeSet<&'a str> {
    let mut declaring = false;
    let mut names = BTreeSet::new();
    for token in tokens {
        match token.tok {
            Tok::LineEnd | Tok::Sign(Sign::Colon) => declaring = false,
            Tok::Name if declaring => {
                names.insert(token.span.of(text));
            }
            tok => declaring |= declares(tok),
        }
    }
    names
}

/// Reads one statement, or skips it; gives what stands behind it.
fn statement<'a>(i: In<'a>, builder: &mut Builder<'_>) -> In<'a> {
    if let Some((piece, words)) = foreign::block_word(i) {
        let rest = (0..words).fold(i, |i, _| i.rest());
        let span = i.span_to(rest);
        builder.diags().push(foreign::block_word_diag(i, &piece, span));
        builder.add(Placed { piece, span, line: i.first().line });
        return skip(rest);
    }
    if let Some(diag) = foreign::loop_label(i, builder.has_open(Kw::Do)) {
        builder.diags().push(diag);
        return i.rest();
    }
    if let Some(diag) = foreign::argument_sign(i) {
        builder.diags().push(diag);
        return recover(i, builder);
    }
    let result = stmt::piece(i).and_then(|(rest, piece)| {
        let continues = matches!(piece, Piece::Else)
            || matches!(piece, Piece::Stmt(super::ast::StmtKind::Label(_)));
        if continues { Ok((rest, piece)) } else { stmt::end(rest).map(|(rest, ())| (rest, piece)) }
    });
    match result {
        Ok((rest, piece)) => {
            if matches!(piece, Piece::Else)
                && rest.tok() == Tok::Kw(Kw::If)
                && let Some(after) = else_if(i, rest, builder)
            {
                return after;
            }
            let span = i.span_to(rest);
            builder.add(Placed { piece, span, line: i.first().line });
            rest
        }
        Err(nom::Err::Error(failure) | nom::Err::Failure(failure)) => {
            let usage = match i.tok() {
                Tok::Kw(Kw::On) => Some(foreign::on_usage(i.second().tok)),
                Tok::Kw(Kw::Wait) if i.second().tok == Tok::Kw(Kw::Until) => {
                    Some("WAIT UNTIL condition [, time]")
                }
                Tok::Kw(kw) | Tok::Quiet(kw) if !kw.is_soft() => Some(kw.entry().usage),
                Tok::Name if i.second().tok == Tok::Sign(Sign::Eq) => Some("name = expression"),
                _ => None,
            };
            let slip = slips::reserved_label(i)
                .or_else(|| slips::undeclared_target(i))
                .or_else(|| slips::closed_line(i));
            if let Some(diag) = slip.or_else(|| failure.into_diag(i.context.text, usage)) {
                builder.diags().push(diag);
            }
            recover(i, builder)
        }
        Err(nom::Err::Incomplete(_)) => recover(i, builder),
    }
}

/// `ELSE IF c THEN` at the end of a line: reported, then read as ELSEIF.
fn else_if<'a>(i: In<'a>, if_: In<'a>, builder: &mut Builder<'_>) -> Option<In<'a>> {
    let (rest, piece) = stmt::piece(if_).ok()?;
    let Piece::Open(Opener::If(cond)) = piece else { return None };
    let span = i.span_to(if_.rest());
    let diag = Diag::new(Code::ForeignStatement, span, "`ELSE IF` would open a block of its own")
        .hint("write `ELSEIF`")
        .fix(span, "ELSEIF");
    builder.diags().push(diag);
    builder.add(Placed { piece: Piece::ElseIf(cond), span, line: i.first().line });
    Some(rest)
}

/// Goes on behind a statement that could not be read. Where it would have opened a block, the
/// block is opened all the same, so that its end finds it.
fn recover<'a>(i: In<'a>, builder: &mut Builder<'_>) -> In<'a> {
    let one_line_if = i.tok() == Tok::Kw(Kw::If);
    match foreign::broken_opener(i, i) {
        Some(opener) => {
            let span = i.first().span;
            builder.add(Placed { piece: Piece::Open(opener), span, line: i.first().line });
        }
        None if matches!(i.tok(), Tok::Bad) => builder.lose(),
        None => {
            if let Some(piece) = foreign::broken_line(i) {
                let Token { span, line, .. } = i.first();
                builder.add(Placed { piece, span, line });
            }
        }
    }
    let mut rest = skip(i.rest());
    if declares(i.tok()) {
        // What it would have declared is not missed again at each use.
        let count = i.tokens.len() - rest.tokens.len();
        let names = i.tokens.iter().take(count).filter(|t| t.tok == Tok::Name);
        for token in names {
            builder.lose_name(token.span.of(i.context.text).to_ascii_lowercase());
        }
        for diag in slips::further_names(i, count) {
            builder.diags().push(diag);
        }
    }
    while one_line_if && rest.tok() == Tok::Sign(Sign::Colon) {
        rest = skip(rest.rest());
    }
    rest
}

/// Whether a statement that begins so declares names.
fn declares(tok: Tok) -> bool {
    matches!(
        tok,
        Tok::Kw(
            Kw::Dim
                | Kw::Keep
                | Kw::Const
                | Kw::Input
                | Kw::Output
                | Kw::Table
                | Kw::Sub
                | Kw::Function
        )
    )
}

/// Up to the end of the statement.
fn skip(i: In<'_>) -> In<'_> {
    let ends = |t: &Token| matches!(t.tok, Tok::LineEnd | Tok::Sign(Sign::Colon));
    let count = i.tokens.iter().position(ends).unwrap_or(i.tokens.len());
    In { tokens: i.tokens.get(count..).unwrap_or(&[]), ..i }
}
