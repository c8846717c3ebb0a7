//! Declarations.

use super::control::as_kind;
use super::expr::expr;
use super::input::{In, Parsed, comma, name, text, tok};
use super::piece::Piece;
use crate::front::ast::{BinaryOp, Expr, ExprKind, KindRef, Name, StmtKind, Variable};
use crate::front::codes::Code;
use crate::front::diag::Diag;
use crate::front::token::{Sign, Tok};
use crate::front::words::{Func, Kw};
use crate::kind::Kind;
use nom::Parser;
use nom::combinator::{cut, map, opt};
use nom::multi::separated_list1;
use nom::sequence::delimited;
use std::rc::Rc;

/// `name = e, ...`
pub fn equations(i: In<'_>) -> Parsed<'_, Vec<(Name, Expr)>> {
    let equation = |i| {
        let (rest, name) = name(i)?;
        let (rest, _) = cut(tok(Tok::Sign(Sign::Eq), "`=`")).parse(rest)?;
        map(cut(expr), move |e| (name.clone(), e)).parse(rest)
    };
    separated_list1(comma, cut(equation)).parse(i)
}

/// `name[(size)] [AS kind] [= value] [AT address [LABEL "text"] [MIN value] [MAX value]], ...`
///
/// A value is an assignment where the DIM stands. The values of an array go on to the end of the
/// statement, as those of a TABLE do.
pub fn dim(i: In<'_>) -> Parsed<'_, Piece> {
    let mut variables = Vec::new();
    let mut values = Vec::new();
    let mut rest = i;
    loop {
        let (after, (variable, list)) = cut(variable).parse(rest)?;
        let array = variable.size.is_some();
        for (n, value) in (0..).zip(list) {
            let target = variable.name.clone();
            let place = ExprKind::Literal { kind: Kind::Number, value: n };
            let index = if array { vec![Expr { kind: place, span: value.span }] } else { vec![] };
            values.push(StmtKind::Assign { target, index, bit: None, value });
        }
        variables.push(variable);
        rest = after;
        if rest.tok() != Tok::Sign(Sign::Comma) {
            break;
        }
        rest = rest.rest();
    }
    let dim = StmtKind::Dim(variables);
    let piece = match values.is_empty() {
        true => Piece::Stmt(dim),
        false => Piece::Several(core::iter::once(dim).chain(values).collect()),
    };
    Ok((rest, piece))
}

/// `name [AS kind], ...`; what else DIM takes is refused by the checker, a value here.
pub fn keep(i: In<'_>) -> Parsed<'_, Vec<Variable>> {
    let plain = |i| {
        let (rest, (variable, values)) = variable(i)?;
        if let Some(value) = values.first() {
            let name = &variable.name.text;
            let message = format!("`{name}` is kept and has no initial value");
            let diag = Diag::new(Code::BadKeep, value.span, message).hint(format!(
                "it is 0 after an upload; `IF {name} = 0 THEN {name} = ...` gives it its first value"
            ));
            return Err(i.fail(diag));
        }
        Ok((rest, variable))
    };
    separated_list1(comma, cut(plain)).parse(i)
}

/// A variable with its values.
fn variable(i: In<'_>) -> Parsed<'_, (Variable, Vec<Expr>)> {
    let (rest, name) = name(i)?;
    let (rest, size) = opt(parenthesised).parse(rest)?;
    let (kind, at, label, least, greatest) = (None, None, None, None, None);
    let mut variable = Variable { name, size, kind, timer: false, at, label, least, greatest };
    let mut values = Vec::new();
    let mut rest = rest;
    loop {
        match rest.tok() {
            Tok::Kw(Kw::As)
                if variable.kind.is_none() && rest.second().tok == Tok::Func(Func::Timer) =>
            {
                let span = rest.second().span;
                variable.kind = Some(KindRef { kind: Kind::Time, span });
                variable.timer = true;
                rest = rest.rest().rest();
            }
            Tok::Kw(Kw::As) if variable.kind.is_none() => {
                let (after, kind) = as_kind(rest)?;
                variable.kind = kind;
                rest = after;
            }
            Tok::Sign(Sign::Eq) if values.is_empty() && variable.size.is_some() => {
                (rest, values) = separated_list1(comma, cut(expr)).parse(rest.rest())?;
            }
            Tok::Sign(Sign::Eq) if values.is_empty() => {
                let (after, value) = cut(expr).parse(rest.rest())?;
                values.push(value);
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
            _ => break,
        }
    }
    match value_of_register(&variable, &values) {
        Some(diag) => Err(i.fail(diag)),
        None => Ok((rest, (variable, values))),
    }
}

/// A value for a variable with AT, which keeps what the operator gave it: `AT 3000 = 5` too, which
/// reads as a comparison.
fn value_of_register(variable: &Variable, values: &[Expr]) -> Option<Diag> {
    let at = variable.at.as_ref()?;
    let compared = match &at.kind {
        ExprKind::Binary(BinaryOp::Eq, _, right) => Some(&**right),
        _ => None,
    };
    let value = values.first().or(compared)?;
    let name = &variable.name.text;
    let message = format!("`{name}` is the operator's and has no initial value");
    let hint = format!("write `{name} = ...` where the program shall set it");
    Some(Diag::new(Code::BadAt, value.span, message).hint(hint))
}

fn parenthesised(i: In<'_>) -> Parsed<'_, Expr> {
    delimited(tok(Tok::Sign(Sign::Open), "`(`"), cut(expr), cut(tok(Tok::Sign(Sign::Close), "`)`")))
        .parse(i)
}

/// Names of columns, in parentheses, at least two: one alone is a CONST that says how many there are. Axis letters are
/// names here.
fn columns(i: In<'_>) -> Parsed<'_, Vec<Rc<str>>> {
    let mut names: Vec<Rc<str>> = Vec::new();
    let mut rest = i.rest();
    if i.tok() != Tok::Sign(Sign::Open) || rest.second().tok != Tok::Sign(Sign::Comma) {
        return Ok((i, names));
    }
    loop {
        let plain = match rest.tok() {
            Tok::Name => true,
            Tok::Kw(kw) => kw.is_soft(),
            _ => false,
        };
        if !plain {
            return Err(rest.expected("the name of a column"));
        }
        let key: Rc<str> = rest.word().to_ascii_lowercase().into();
        if names.contains(&key) {
            let span = rest.first().span;
            let message = format!("two columns are called `{}`", rest.word());
            let diag = Diag::new(Code::DeclaredTwice, span, message);
            return Err(i.fail(diag.hint("give each column a name of its own")));
        }
        names.push(key);
        rest = rest.rest();
        match rest.tok() {
            Tok::Sign(Sign::Comma) => rest = rest.rest(),
            Tok::Sign(Sign::Close) => return Ok((rest.rest(), names)),
            _ => return Err(rest.expected("`,` or `)`")),
        }
    }
}

/// `name[(columns)] = row; row ...`
pub fn table(i: In<'_>) -> Parsed<'_, StmtKind> {
    let (rest, name) = cut(name).parse(i)?;
    let (rest, columns) = cut(columns).parse(rest)?;
    let (rest, width) = opt(map(parenthesised, Box::new)).parse(rest)?;
    let (rest, _) = cut(tok(Tok::Sign(Sign::Eq), "`=`")).parse(rest)?;
    let row = separated_list1(comma, cut(expr));
    let semicolon = tok(Tok::Sign(Sign::Semicolon), "`;`");
    let (rest, rows) = separated_list1(semicolon, row).parse(rest)?;
    Ok((rest, StmtKind::Table { name, width, columns, rows }))
}
