//! Declarations.

use super::control::as_kind;
use super::expr::expr;
use super::input::{In, Parsed, comma, name, text, tok};
use crate::front::ast::{Expr, Name, StmtKind, Variable};
use crate::front::token::{Sign, Tok};
use crate::front::words::{Func, Kw};
use nom::Parser;
use nom::combinator::{cut, map, opt};
use nom::multi::separated_list1;
use nom::sequence::delimited;

/// `name = e, ...`
pub fn equations(i: In<'_>) -> Parsed<'_, Vec<(Name, Expr)>> {
    let equation = |i| {
        let (rest, name) = name(i)?;
        let (rest, _) = cut(tok(Tok::Sign(Sign::Eq), "`=`")).parse(rest)?;
        map(cut(expr), move |e| (name.clone(), e)).parse(rest)
    };
    separated_list1(comma, cut(equation)).parse(i)
}

/// `name[(size)] [AS kind] [AT address [LABEL "text"] [MIN value] [MAX value]], ...`
pub fn variables(i: In<'_>) -> Parsed<'_, Vec<Variable>> {
    separated_list1(comma, cut(variable)).parse(i)
}

fn variable(i: In<'_>) -> Parsed<'_, Variable> {
    let (rest, name) = name(i)?;
    let (rest, size) = opt(parenthesised).parse(rest)?;
    let (kind, at, label, least, greatest) = (None, None, None, None, None);
    let mut variable = Variable { name, size, kind, at, label, least, greatest };
    let mut rest = rest;
    loop {
        match rest.tok() {
            Tok::Kw(Kw::As) if variable.kind.is_none() => {
                let (after, kind) = as_kind(rest)?;
                variable.kind = kind;
                rest = after;
            }
            Tok::Kw(Kw::At) if variable.at.is_none() => {
                let (after, at) = map(cut(expr), Some).parse(rest.rest())?;
                variable.at = at;
                rest = after;
            }
            Tok::Kw(Kw::Label) if variable.label.is_none() => {
                let (after, label) = map(cut(text), Some).parse(rest.rest())?;
                variable.label = label;
                rest = after;
            }
            Tok::Func(Func::Min) if variable.least.is_none() => {
                let (after, least) = map(cut(expr), Some).parse(rest.rest())?;
                variable.least = least;
                rest = after;
            }
            Tok::Func(Func::Max) if variable.greatest.is_none() => {
                let (after, greatest) = map(cut(expr), Some).parse(rest.rest())?;
                variable.greatest = greatest;
                rest = after;
            }
            _ => return Ok((rest, variable)),
        }
    }
}

fn parenthesised(i: In<'_>) -> Parsed<'_, Expr> {
    delimited(tok(Tok::Sign(Sign::Open), "`(`"), cut(expr), cut(tok(Tok::Sign(Sign::Close), "`)`")))
        .parse(i)
}

/// `name[(columns)] = row; row ...`
pub fn table(i: In<'_>) -> Parsed<'_, StmtKind> {
    let (rest, name) = cut(name).parse(i)?;
    let (rest, width) = opt(map(parenthesised, Box::new)).parse(rest)?;
    let (rest, _) = cut(tok(Tok::Sign(Sign::Eq), "`=`")).parse(rest)?;
    let row = separated_list1(comma, cut(expr));
    let semicolon = tok(Tok::Sign(Sign::Semicolon), "`;`");
    let (rest, rows) = separated_list1(semicolon, row).parse(rest)?;
    Ok((rest, StmtKind::Table { name, width, rows }))
}
