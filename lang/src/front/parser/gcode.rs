//! G-code blocks.

use super::expr::expr;
use super::input::{In, Parsed, tok};
use crate::front::ast::{GValue, GWord, StmtKind};
use crate::front::codes::Code;
use crate::front::diag::Diag;
use crate::front::literal::Decimal;
use crate::front::token::{Sign, Tok};
use nom::Parser;
use nom::combinator::cut;
use nom::multi::many1;
use nom::sequence::delimited;

/// A block: at least one word.
pub fn block(i: In<'_>) -> Parsed<'_, StmtKind> {
    let (rest, words) = many1(word).parse(i)?;
    Ok((rest, StmtKind::Gcode(words)))
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
                cut(tok(Tok::Sign(Sign::CloseBracket), "`]`")),
            )
            .parse(i.rest())?;
            Ok((rest, GWord { letter, value: GValue::Expr(value), span: i.span_to(rest) }))
        }
        _ => Err(i.expected("a G-code word")),
    }
}
