//! Statements of the machine.

use super::expr::{expr, optional_expr};
use super::foreign;
use super::input::{In, Parsed, axis, comma, kw, text};
use crate::effect::{ActKind, Plane, Unit, Want};
use crate::front::ast::{AxisRef, Expr, InputState, Machine, PrintPart, ShownIn};
use crate::front::codes::Code;
use crate::front::diag::Diag;
use crate::front::token::{Sign, Tok};
use crate::front::words::{Class, Func, Kw};
use crate::plain::Plain;
use nom::Parser;
use nom::branch::alt;
use nom::combinator::{cut, map, opt, value};
use nom::multi::separated_list1;
use nom::sequence::preceded;

/// The machine statement of this word; `i` stands behind it. `quiet` is the form with `?`.
pub fn machine<'a>(word: Kw, quiet: bool, i: In<'a>) -> Parsed<'a, Machine> {
    if let Some(diag) = foreign::parenthesised_list(word, i) {
        return Err(i.fail(diag));
    }
    if let Some(statement) = Plain::of_word(word) {
        return plain(statement, i);
    }
    match word {
        Kw::Start => start(i),
        Kw::MoveAxe => movement(false, false, i),
        Kw::MoveRel => movement(false, true, i),
        Kw::WaitMove => map(optional_axis, Machine::WaitMove).parse(i),
        Kw::MoveSpeed => map((axis, next_expr), |(a, v)| Machine::MoveSpeed(a, v)).parse(i),
        Kw::StopAxe => map(axis, Machine::StopAxe).parse(i),
        Kw::Home if i.at_end() => Ok((i, Machine::Home { quiet, axes: Vec::new() })),
        Kw::Home => {
            map(separated_list1(comma, axis), |axes| Machine::Home { quiet, axes }).parse(i)
        }
        Kw::Probe => probe(quiet, i),
        Kw::ProbeMask => probe_mask(quiet, i),
        Kw::SetPos => map((axis, next_expr), |(a, v)| Machine::SetPos(a, v)).parse(i),
        Kw::Motors => {
            let axis = opt(preceded(comma, axis));
            map((expr, axis), |(on, axis)| Machine::Motors(on, axis)).parse(i)
        }
        Kw::WaitIn => wait_in(quiet, i),
        Kw::WaitChar => {
            map((expr, optional_expr), |(code, timeout)| Machine::WaitChar { quiet, code, timeout })
                .parse(i)
        }
        Kw::Print => print(i),
        Kw::Plane => plane(i),
        _ => Err(i.expected("a statement")),
    }
}

/// As many expressions as the statement has arguments.
fn plain(statement: Plain, i: In<'_>) -> Parsed<'_, Machine> {
    map(list(statement.arguments().len()), |list| Machine::Plain(statement, list)).parse(i)
}

/// So many expressions.
fn list<'a>(count: usize) -> impl FnMut(In<'a>) -> Parsed<'a, Vec<Expr>> {
    move |i| {
        let mut list = Vec::with_capacity(count);
        let mut rest = i;
        for _ in 0..count {
            let (after, argument) =
                if list.is_empty() { expr.parse(rest)? } else { next_expr.parse(rest)? };
            list.push(argument);
            rest = after;
        }
        Ok((rest, list))
    }
}

/// SetAout; `i` stands behind it.
pub fn set_aout(i: In<'_>) -> Parsed<'_, Machine> {
    map(list(2), Machine::SetAout).parse(i)
}

/// Whether SYNC stands before what is here: a statement of the machine, or one of an analog output.
pub fn begins_action(i: In<'_>) -> bool {
    match i.tok() {
        Tok::Kw(kw) => kw == Kw::SetAout || kw.entry().class == Class::Machine,
        _ => false,
    }
}

/// What stands behind SYNC.
pub fn sync(i: In<'_>) -> Parsed<'_, Machine> {
    let kind = match i.tok() {
        Tok::Kw(Kw::SetOut) => ActKind::Set,
        Tok::Kw(Kw::Pulse) => ActKind::Pulse,
        Tok::Kw(Kw::SetAout) => ActKind::Analog,
        _ => {
            let message = format!("{} does not act on the way", i.word());
            let hint = "write `SYNC SetOut n, ON`, `SYNC Pulse n, 20ms` or `SYNC SetAout n, v`";
            return Err(i.fail(Diag::new(Code::Expected, i.first().span, message).hint(hint)));
        }
    };
    map((list(2), optional_expr), move |(list, lead)| Machine::Sync { kind, list, lead })
        .parse(i.rest())
}

fn next_expr(i: In<'_>) -> Parsed<'_, Expr> {
    preceded(cut(comma), cut(expr)).parse(i)
}

fn optional_axis(i: In<'_>) -> Parsed<'_, Option<AxisRef>> {
    if i.at_end() { Ok((i, None)) } else { map(axis, Some).parse(i) }
}

fn start(i: In<'_>) -> Parsed<'_, Machine> {
    let relative = match i.tok() {
        Tok::Kw(Kw::MoveAxe) => false,
        Tok::Kw(Kw::MoveRel) => true,
        _ => return Err(i.expected("MoveAxe or MoveRel")),
    };
    movement(true, relative, i.rest())
}

fn movement(start: bool, relative: bool, i: In<'_>) -> Parsed<'_, Machine> {
    map(
        (axis, next_expr, optional_expr, optional_expr, optional_expr),
        move |(axis, target, speed, accel, decel)| Machine::Move {
            start,
            relative,
            axis,
            target,
            speed,
            accel,
            decel,
        },
    )
    .parse(i)
}

fn probe(quiet: bool, i: In<'_>) -> Parsed<'_, Machine> {
    map(
        (axis, next_expr, next_expr, optional_expr, optional_expr),
        move |(axis, limit, speed, input, state)| Machine::Probe {
            quiet,
            axis,
            limit,
            speed,
            input,
            state,
        },
    )
    .parse(i)
}

fn probe_mask(quiet: bool, i: In<'_>) -> Parsed<'_, Machine> {
    map(
        (axis, next_expr, next_expr, next_expr, next_expr),
        move |(axis, limit, speed, and, xor)| Machine::ProbeMask {
            quiet,
            axis,
            limit,
            speed,
            and,
            xor,
        },
    )
    .parse(i)
}

fn wait_in(quiet: bool, i: In<'_>) -> Parsed<'_, Machine> {
    let state = alt((
        value(InputState::Edge(Want::Rise), kw(Kw::Rise)),
        value(InputState::Edge(Want::Fall), kw(Kw::Fall)),
        map(expr, InputState::Level),
    ));
    map((expr, preceded(cut(comma), cut(state)), optional_expr), move |(input, state, timeout)| {
        Machine::WaitIn { quiet, input, state, timeout }
    })
    .parse(i)
}

fn print(i: In<'_>) -> Parsed<'_, Machine> {
    let mut parts = Vec::new();
    let mut rest = i;
    while !rest.at_end() {
        let value = map((expr, shown_in), |(value, shown)| PrintPart::Value(value, shown));
        let part = alt((map(text, PrintPart::Text), value));
        let (after, part) = cut(part).parse(rest)?;
        parts.push(part);
        rest = after;
        match rest.tok() {
            Tok::Sign(Sign::Semicolon) => rest = rest.rest(),
            Tok::Sign(Sign::Comma) => return Err(rest.fail(foreign::print_comma(rest))),
            _ if rest.at_end() => {}
            _ => return Err(rest.expected("`;`")),
        }
    }
    Ok((rest, Machine::Print(parts)))
}

/// `IN unit` behind a value. The lexer made one name of the unit.
fn shown_in(i: In<'_>) -> Parsed<'_, Option<ShownIn>> {
    let is_in = matches!(i.tok(), Tok::Func(Func::In) | Tok::Name);
    if !is_in || !i.word().eq_ignore_ascii_case("IN") {
        return Ok((i, None));
    }
    let rest = i.rest();
    let span = rest.first().span;
    if let (Tok::Name, Some(unit)) = (rest.tok(), Unit::from_text(rest.word())) {
        return Ok((rest.rest(), Some(ShownIn { unit, span })));
    }
    let diag = Diag::new(Code::Expected, span, format!("expected a unit, {}", rest.found()));
    Err(i.fail(diag.hint(
        "units are mm, um, in, s, ms, min, mm/s, mm/min, in/min, mm/s2, deg, st, st/s and st/s2",
    )))
}

fn plane(i: In<'_>) -> Parsed<'_, Machine> {
    map(
        alt((
            value(Plane::Xy, kw(Kw::Xy)),
            value(Plane::Zx, kw(Kw::Xz)),
            value(Plane::Yz, kw(Kw::Yz)),
        )),
        Machine::Plane,
    )
    .parse(i)
}
