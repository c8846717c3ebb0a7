//! Pieces of nom grammars that several formats share. All of them skip blanks before what they
//! take.

use nom::bytes::complete::{take_while, take_while1};
use nom::character::complete::{char, one_of};
use nom::combinator::{map_opt, opt, recognize};
use nom::sequence::preceded;
use nom::{IResult, Parser};

/// A parser's result on a line.
pub(crate) type Parsed<'a, T> = IResult<&'a str, T>;

/// Blanks and tabs.
pub(crate) fn blanks(i: &str) -> Parsed<'_, &str> {
    take_while(|c: char| c == ' ' || c == '\t' || c == '\u{a0}').parse(i)
}

/// A whole number with its sign. One beyond 64 bits is none, nor is the least of 64 bits: its sign can
/// be changed by whoever reads it.
pub(crate) fn whole(i: &str) -> Parsed<'_, i64> {
    let digits = take_while1(|c: char| c.is_ascii_digit());
    let number = recognize((opt(one_of("+-")), blanks, digits));
    preceded(
        blanks,
        map_opt(number, |text: &str| {
            let text: String =
                text.chars().filter(|c| !c.is_whitespace() && *c != '\u{a0}').collect();
            text.parse().ok().filter(|number: &i64| *number != i64::MIN)
        }),
    )
    .parse(i)
}

/// A number with sign and decimals, as text: `-12.5`, `.5`, `3.`.
pub(crate) fn decimal(i: &str) -> Parsed<'_, &str> {
    let digits = || take_while(|c: char| c.is_ascii_digit());
    let number = recognize((opt(one_of("+-")), digits(), opt((char('.'), digits()))));
    let (rest, text) = preceded(blanks, number).parse(i)?;
    if text.bytes().any(|b| b.is_ascii_digit()) {
        return Ok((rest, text));
    }
    Err(nom::Err::Error(nom::error::Error::new(i, nom::error::ErrorKind::Digit)))
}

/// A sign of its own.
pub(crate) fn sign<'a>(
    c: char,
) -> impl Parser<&'a str, Output = char, Error = nom::error::Error<&'a str>> {
    preceded(blanks, char(c))
}

/// A word in any case.
pub(crate) fn word<'a>(
    text: &'static str,
) -> impl Parser<&'a str, Output = &'a str, Error = nom::error::Error<&'a str>> {
    preceded(blanks, nom::bytes::complete::tag_no_case(text))
}

/// Column, from 1 and in characters, at which `rest` begins, a tail of `line`.
pub(crate) fn column(line: &str, rest: &str) -> u32 {
    let at = line.len().saturating_sub(rest.len());
    let before = line.get(..at).unwrap_or(line);
    u32::try_from(before.chars().count()).unwrap_or(u32::MAX - 1) + 1
}
