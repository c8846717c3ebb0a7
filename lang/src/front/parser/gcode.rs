//! G-code blocks.

use super::expr::expr;
use super::input::{In, Parsed, tok};
use crate::front::ast::{GValue, GWord, StmtKind};
use crate::front::codes::Code;
use crate::front::diag::Diag;
use crate::front::literal::Decimal;
use crate::front::token::{Sign, Tok, Token};
use nom::Parser;
use nom::combinator::cut;
use nom::multi::many1;
use nom::sequence::delimited;

/// A block: at least one word.
pub fn block(i: In<'_>) -> Parsed<'_, StmtKind> {
    let (rest, words) = many1(word).parse(i)?;
    Ok((rest, StmtKind::Gcode(words)))
}

/// The `]` of an expression; a diagnostic with the form of the word where it is missing.
fn closing_bracket(letter: char, i: In<'_>) -> Parsed<'_, Token> {
    let close = Tok::Sign(Sign::CloseBracket);
    if i.tok() == close || i.tok() == Tok::Bad {
        return tok(close, "`]`")(i);
    }
    let message = match i.tok() {
        Tok::LineEnd => "expected `]` before the end of the line".to_owned(),
        _ => format!("expected `]` before `{}`", i.word().chars().take(30).collect::<String>()),
    };
    let hint = format!("an expression in a G-code word ends with `]`: `{letter}[a + 5mm]`");
    Err(i.fail(Diag::new(Code::Expected, i.first().span, message).hint(hint)))
}

fn word(i: In<'_>) -> Parsed<'_, GWord> {
    let text = i.word();
    let letter = text.chars().next().unwrap_or(' ').to_ascii_uppercase();
    match i.tok() {
        Tok::GWord => {
            let Some(number) = Decimal::parse(text.get(1..).unwrap_or("")) else {
                let message = format!("the number of `{letter}` has too many digits");
                let diag = Diag::new(Code::NumberRange, i.first().span, message)
                    .hint("at most 12 digits stand before the point");
                return Err(i.fail(diag));
            };
            let value = GValue::Number(number);
            Ok((i.rest(), GWord { letter, value, span: i.first().span }))
        }
        Tok::GLetter => {
            let (rest, value) = delimited(
                tok(Tok::Sign(Sign::OpenBracket), "`[`"),
                cut(expr),
                cut(|j| closing_bracket(letter, j)),
            )
            .parse(i.rest())?;
            Ok((rest, GWord { letter, value: GValue::Expr(value), span: i.span_to(rest) }))
        }
        _ => Err(i.expected("a G-code word")),
    }
}
