//! Expressions, by precedence climbing over nom parsers.

use super::foreign;
use super::input::{Edge, In, Parsed, axis, comma, is_unit, name, tok};
use crate::front::ast::{BinaryOp, Expr, ExprKind, MAX_EXPR_DEPTH, Name, UnaryOp};
use crate::front::codes::Code;
use crate::front::diag::Diag;
use crate::front::literal;
use crate::front::span::Span;
use crate::front::token::{Sign, Tok};
use crate::front::words::{ArgKind, Func, Kw};
use crate::kind::Kind;
use nom::Parser;
use nom::combinator::{cut, opt};
use nom::multi::separated_list1;
use nom::sequence::preceded;

/// An expression with the height of its tree.
type Tall = (Expr, usize);

/// Binding strength of NOT: looser than comparisons, tighter than AND.
const NOT_LEVEL: u8 = 2;

/// An expression.
pub fn expr(i: In<'_>) -> Parsed<'_, Expr> {
    let (rest, (expr, _)) = climb(i, 0)?;
    Ok((rest, expr))
}

/// `, expression` where there is one; what follows a comma must be one.
pub fn optional_expr(i: In<'_>) -> Parsed<'_, Option<Expr>> {
    opt(preceded(comma, cut(expr))).parse(i)
}

/// The operator of a token with its level: the greater, the tighter.
fn operator(tok: Tok) -> Option<(BinaryOp, u8)> {
    Some(match tok {
        Tok::Kw(Kw::Or) => (BinaryOp::Or, 0),
        Tok::Kw(Kw::Xor) => (BinaryOp::Xor, 0),
        Tok::Kw(Kw::OrElse) => (BinaryOp::OrElse, 0),
        Tok::Kw(Kw::And) => (BinaryOp::And, 1),
        Tok::Kw(Kw::AndAlso) => (BinaryOp::AndAlso, 1),
        Tok::Sign(Sign::Eq) => (BinaryOp::Eq, 3),
        Tok::Sign(Sign::Ne) => (BinaryOp::Ne, 3),
        Tok::Sign(Sign::Lt) => (BinaryOp::Lt, 3),
        Tok::Sign(Sign::Le) => (BinaryOp::Le, 3),
        Tok::Sign(Sign::Gt) => (BinaryOp::Gt, 3),
        Tok::Sign(Sign::Ge) => (BinaryOp::Ge, 3),
        Tok::Sign(Sign::Shl) => (BinaryOp::Shl, 4),
        Tok::Sign(Sign::Shr) => (BinaryOp::Shr, 4),
        Tok::Sign(Sign::Plus) => (BinaryOp::Add, 5),
        Tok::Sign(Sign::Minus) => (BinaryOp::Sub, 5),
        Tok::Sign(Sign::Star) => (BinaryOp::Mul, 6),
        Tok::Sign(Sign::Slash) => (BinaryOp::Div, 6),
        Tok::Kw(Kw::Mod) => (BinaryOp::Mod, 6),
        _ => return None,
    })
}

fn climb(i: In<'_>, least: u8) -> Parsed<'_, Tall> {
    let (mut rest, (mut left, mut height)) = prefix(i)?;
    while let Some((op, level)) = operator(rest.tok()).filter(|&(_, level)| level >= least) {
        let (after, (right, right_height)) = cut(|j| climb(j, level + 1)).parse(rest.rest())?;
        height = grown(rest, height.max(right_height))?;
        let span = left.span.to(right.span);
        left = Expr { kind: ExprKind::Binary(op, Box::new(left), Box::new(right)), span };
        rest = after;
    }
    Ok((rest, (left, height)))
}

/// The height of a node above others; a diagnostic where the tree gets too high.
fn grown(i: In<'_>, below: usize) -> Result<usize, nom::Err<super::input::Failure>> {
    if below >= MAX_EXPR_DEPTH {
        let message = format!("this expression has more than {MAX_EXPR_DEPTH} operators in a row");
        let diag = Diag::new(Code::TooDeep, i.first().span, message)
            .hint("put a part of it into a variable first");
        return Err(i.fail(diag));
    }
    Ok(below + 1)
}

fn prefix(i: In<'_>) -> Parsed<'_, Tall> {
    let (op, level) = match i.tok() {
        Tok::Sign(Sign::Minus) => {
            if let Some(literal) = negative_literal(i) {
                return Ok((i.rest().rest(), (literal, 1)));
            }
            (UnaryOp::Neg, u8::MAX)
        }
        Tok::Kw(Kw::Not) => (UnaryOp::Not, NOT_LEVEL),
        _ => return bits(i),
    };
    let inner = i.deeper()?.rest();
    let (rest, (operand, height)) = match op {
        UnaryOp::Neg => cut(prefix).parse(inner)?,
        _ => cut(|j| climb(j, level)).parse(inner)?,
    };
    let height = grown(i, height)?;
    let span = i.first().span.to(operand.span);
    Ok((rest.back_to(i), (Expr { kind: ExprKind::Unary(op, Box::new(operand)), span }, height)))
}

/// A minus with its number, so that -2147483648 fits.
fn negative_literal(i: In<'_>) -> Option<Expr> {
    let number = i.rest();
    if number.tok() != Tok::Number || is_unit(number.rest()) {
        return None;
    }
    let literal = literal::settle(number.word()).ok()?;
    let value = i32::try_from(-literal.value).ok()?;
    let span = i.first().span.to(number.first().span);
    Some(Expr { kind: ExprKind::Literal { kind: literal.kind, value }, span })
}

/// A primary, and the bit of it that may be asked for.
fn bits(i: In<'_>) -> Parsed<'_, Tall> {
    let (rest, (inner, height)) = primary(i)?;
    if rest.tok() != Tok::Bit {
        return Ok((rest, (inner, height)));
    }
    let (rest, bit) = bit(rest)?;
    let height = grown(i, height)?;
    let kind = ExprKind::Unary(UnaryOp::Bit(bit), Box::new(inner));
    Ok((rest, (Expr { kind, span: i.span_to(rest) }, height)))
}

/// `.3`: the number of a bit.
pub fn bit(i: In<'_>) -> Parsed<'_, u8> {
    let (rest, token) = tok(Tok::Bit, "a bit")(i)?;
    match i.word()[1..].parse() {
        Ok(bit @ 0..=31) => Ok((rest, bit)),
        _ => {
            let message = format!("there is no bit `{}`", i.word());
            let diag = Diag::new(Code::NumberRange, token.span, message);
            Err(i.fail(diag.hint("the bits of a Number are .0, the lowest, to .31")))
        }
    }
}

fn primary(i: In<'_>) -> Parsed<'_, Tall> {
    let span = i.first().span;
    let truth = |value| {
        let kind = ExprKind::Literal { kind: Kind::Truth, value };
        Ok((i.rest(), (Expr { kind, span }, 1)))
    };
    match i.tok() {
        Tok::Number => number(i).map(|(rest, e)| (rest, (e, 1))),
        Tok::Kw(Kw::True | Kw::On) => truth(1),
        Tok::Kw(Kw::False | Kw::Off) => truth(0),
        Tok::Sign(Sign::Open) => {
            let (rest, (mut inner, height)) = climb(i.deeper()?.rest(), 0)?;
            let (rest, close) = cut(tok(Tok::Sign(Sign::Close), "`)`")).parse(rest)?;
            inner.span = span.to(close.span);
            Ok((rest.back_to(i), (inner, height)))
        }
        Tok::Func(func) => builtin(i, func),
        Tok::Text => {
            let diag = Diag::new(Code::Expected, span, "a text can not be part of an expression")
                .hint("texts stand in PRINT, between `;`: PRINT \"hole \"; i");
            Err(i.fail(diag))
        }
        Tok::Name | Tok::Kw(_) | Tok::Quiet(_) | Tok::GWord => named(i),
        Tok::Sign(Sign::Plus) => {
            let diag = Diag::new(Code::Expected, span, "there is no unary `+`")
                .hint("leave it out")
                .fix(span, "");
            Err(i.fail(diag))
        }
        Tok::Sign(Sign::OpenBracket) => {
            let diag = Diag::new(Code::ForeignBrackets, span, "`[` can not begin an expression")
                .hint("expressions and indices stand in parentheses: `a(i)`");
            Err(i.fail(diag))
        }
        _ => Err(i.expected("an expression")),
    }
}

fn number(i: In<'_>) -> Parsed<'_, Expr> {
    let span = i.first().span;
    let after = i.rest();
    let shown = after.tok() == Tok::Func(Func::In) && is_unit(after.rest());
    if is_unit(after) && after.second().tok != Tok::Sign(Sign::Open) && !shown {
        let (digits, unit) = (i.word(), after.word());
        let whole = span.to(after.first().span);
        let message = format!("a blank stands between `{digits}` and its unit");
        let diag = Diag::new(Code::UnitApart, whole, message)
            .hint(format!("write `{}`", foreign::joined(i)));
        return Err(i.fail(diag.fix(whole, format!("{digits}{unit}"))));
    }
    if let Some(diag) = foreign::unit_call(i) {
        return Err(i.fail(diag));
    }
    let Some(value) =
        literal::settle(i.word()).ok().and_then(|l| Some((l.kind, i32::try_from(l.value).ok()?)))
    else {
        let message = format!("`{}` does not fit in 32 bits", i.word());
        let diag = Diag::new(Code::NumberRange, span, message)
            .hint("values go from -2147483648 to 2147483647");
        return Err(i.fail(diag));
    };
    let (kind, value) = value;
    Ok((after, Expr { kind: ExprKind::Literal { kind, value }, span }))
}

/// A name, or an array, table or FUNCTION with its parentheses.
fn named(i: In<'_>) -> Parsed<'_, Tall> {
    if let Tok::Kw(kw) = i.tok()
        && !kw.is_soft()
    {
        return Err(match kw {
            _ if i.at_end() => i.expected("an expression"),
            kw if kw.begins_statement() => i.fail(foreign::undeclared(i).unwrap_or_else(|| {
                let message =
                    format!("expected an expression, found the statement `{}`", kw.text());
                Diag::new(Code::Expected, i.first().span, message)
            })),
            _ => i.expected("an expression"),
        });
    }
    if let Some(diag) = foreign::axis_as_value(i) {
        return Err(i.fail(diag));
    }
    let (rest, name) = name(i)?;
    match rest.tok() {
        Tok::Sign(Sign::Open) => {
            let (after, (args, height)) = arguments(rest)?;
            let height = grown(i, height)?;
            let span = i.span_to(after);
            if let (Tok::Kw(kw @ (Kw::Rise | Kw::Fall)), [input]) = (i.tok(), &args[..]) {
                let (falls, input, line) = (kw == Kw::Fall, input.clone(), i.first().line);
                i.context.edges.borrow_mut().push(Edge { falls, input, span, line });
            }
            Ok((after, (Expr { kind: ExprKind::Apply(name, args), span }, height)))
        }
        Tok::Sign(Sign::OpenBracket) => {
            let message = format!("`{}[` has no meaning", name.text);
            let diag = Diag::new(Code::ForeignBrackets, rest.first().span, message)
                .hint(format!("an index stands in parentheses: `{}(i)`", name.text));
            Err(rest.fail(diag))
        }
        _ => {
            let span = name.span;
            Ok((rest, (Expr { kind: ExprKind::Name(name), span }, 1)))
        }
    }
}

/// `(a, b)` or `()`, with the height of the highest.
pub fn arguments(i: In<'_>) -> Parsed<'_, (Vec<Expr>, usize)> {
    let (inner, _) = tok(Tok::Sign(Sign::Open), "`(`")(i.deeper()?)?;
    if inner.tok() == Tok::Sign(Sign::Close) {
        return Ok((inner.rest().back_to(i), (Vec::new(), 0)));
    }
    let first = inner.tokens.len();
    let (rest, list) = separated_list1(comma, cut(|j| listed(j, first))).parse(inner)?;
    let (rest, _) = cut(tok(Tok::Sign(Sign::Close), "`)`")).parse(rest)?;
    let height = list.iter().map(|(_, h)| *h).max().unwrap_or(0);
    let args = list.into_iter().map(|(e, _)| e).collect();
    Ok((rest.back_to(i), (args, height)))
}

/// One argument; `first` is how many tokens stand from the first one on.
fn listed(i: In<'_>, first: usize) -> Parsed<'_, Tall> {
    if i.tokens.len() == first || !names_column(i) {
        return climb(i, 0);
    }
    let (rest, axis) = axis(i)?;
    Ok((rest, (Expr { kind: ExprKind::Axis(axis), span: axis.span }, 1)))
}

/// Whether an axis letter alone stands before the closing parenthesis: a column of a TABLE may be called so.
fn names_column(i: In<'_>) -> bool {
    i.tok() == Tok::Name
        && i.second().tok == Tok::Sign(Sign::Close)
        && ["x", "y", "z"].iter().any(|letter| i.word().eq_ignore_ascii_case(letter))
}

fn builtin(i: In<'_>, func: Func) -> Parsed<'_, Tall> {
    let span = i.first().span;
    let usage = |what: &str| {
        let message = format!("`{}` {what}", func.text());
        Diag::new(Code::WrongArguments, span, message).hint(format!("write `{}`", func.usage()))
    };
    let open = i.rest();
    if func.is_bare() {
        return if open.tok() == Tok::Sign(Sign::Open) {
            Err(i.fail(usage("takes no parentheses")))
        } else {
            Ok((open, (Expr { kind: ExprKind::Builtin(func, Vec::new()), span }, 1)))
        };
    }
    if open.tok() != Tok::Sign(Sign::Open) {
        if let Some(diag) = foreign::undeclared(i) {
            return Err(i.fail(diag));
        }
        let mut diag = usage("is a function and needs its parentheses");
        if func.args().is_empty() {
            diag = diag.fix(Span::point(span.end), "()");
        }
        return Err(i.fail(diag));
    }
    let mut rest = open.deeper()?.rest();
    let mut args = Vec::new();
    let mut height = 0;
    for (n, kind) in func.args().iter().enumerate() {
        if n > 0 {
            if rest.tok() == Tok::Sign(Sign::Close) {
                return Err(i.fail(usage("has too few arguments")));
            }
            rest = cut(comma).parse(rest)?.0;
        } else if rest.tok() == Tok::Sign(Sign::Close) {
            return Err(i.fail(usage("has too few arguments")));
        }
        let (after, (arg, arg_height)) = argument(rest, *kind)?;
        args.push(arg);
        height = height.max(arg_height);
        rest = after;
    }
    if rest.tok() == Tok::Sign(Sign::Comma) || (args.is_empty() && !is_close(rest)) {
        return Err(i.fail(usage("has too many arguments")));
    }
    let (rest, close) = cut(tok(Tok::Sign(Sign::Close), "`)`")).parse(rest)?;
    let height = grown(i, height)?;
    let expr = Expr { kind: ExprKind::Builtin(func, args), span: span.to(close.span) };
    Ok((rest.back_to(i), (expr, height)))
}

fn is_close(i: In<'_>) -> bool {
    matches!(i.tok(), Tok::Sign(Sign::Close) | Tok::Bad | Tok::LineEnd)
}

fn argument(i: In<'_>, kind: ArgKind) -> Parsed<'_, Tall> {
    match kind {
        ArgKind::Value => cut(|j| climb(j, 0)).parse(i),
        ArgKind::Axis => {
            let (rest, axis) = axis(i)?;
            Ok((rest, (Expr { kind: ExprKind::Axis(axis), span: axis.span }, 1)))
        }
        ArgKind::Table => {
            let (rest, name): (_, Name) = cut(name).parse(i)?;
            let span: Span = name.span;
            Ok((rest, (Expr { kind: ExprKind::Name(name), span }, 1)))
        }
    }
}
