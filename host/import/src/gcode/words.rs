//! A line of G-code taken apart: words and remarks, nothing of their meaning.

use nom::branch::alt;
use nom::bytes::complete::{take_till, take_while};
use nom::character::complete::{char, satisfy};
use nom::combinator::{map, opt, rest, value};
use nom::multi::many0;
use nom::sequence::{delimited, preceded};
use nom::{IResult, Parser};

use crate::line::{Parsed, blanks, decimal};

/// A word: its letter, upper case, and its number as it stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Word<'a> {
    pub letter: char,
    pub number: &'a str,
    /// What follows the letter in the line; its length tells the place.
    pub tail: &'a str,
}

/// A piece of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Piece<'a> {
    Word(Word<'a>),
    /// In parentheses, or behind `;`.
    Remark(&'a str),
    /// Block delete, `/`.
    Optional,
    /// `*` and a checksum.
    Checksum,
}

fn word(i: &str) -> Parsed<'_, Piece<'_>> {
    let (tail, letter) = satisfy(|c| c.is_ascii_alphabetic()).parse(i)?;
    let (i, number) = decimal(tail)?;
    Ok((i, Piece::Word(Word { letter: letter.to_ascii_uppercase(), number, tail })))
}

fn remark(i: &str) -> Parsed<'_, Piece<'_>> {
    // A parenthesis that is not closed goes to the line's end.
    let parens = delimited(char('('), take_till(|c| c == ')'), opt(char(')')));
    let tail = preceded(char(';'), rest);
    map(alt((parens, tail)), Piece::Remark).parse(i)
}

fn checksum(i: &str) -> Parsed<'_, Piece<'_>> {
    let digits = take_while(|c: char| c.is_ascii_digit());
    value(Piece::Checksum, preceded(char('*'), preceded(blanks, digits))).parse(i)
}

/// All pieces of a line; what is left over cannot be read.
pub(crate) fn pieces(line: &str) -> IResult<&str, Vec<Piece<'_>>> {
    let optional = value(Piece::Optional, char('/'));
    let piece = alt((remark, optional, checksum, word));
    let (rest, list) = many0(preceded(blanks, piece)).parse(line)?;
    let (rest, _) = blanks(rest)?;
    Ok((rest, list))
}

#[cfg(test)]
mod tests {
    use super::{Piece, pieces};

    #[test]
    fn words_touch_and_remarks_stand_between() {
        let (rest, list) = pieces("n10 g1X-1.5 (to the left) y.5F100;end").expect("pieces");
        assert_eq!(rest, "");
        let words: Vec<String> = list
            .iter()
            .map(|piece| match piece {
                Piece::Word(word) => format!("{}{}", word.letter, word.number),
                Piece::Remark(text) => format!("({text})"),
                other => format!("{other:?}"),
            })
            .collect();
        assert_eq!(words, ["N10", "G1", "X-1.5", "(to the left)", "Y.5", "F100", "(end)"]);
    }

    #[test]
    fn what_cannot_be_read_is_left_over() {
        assert_eq!(pieces("G1 X#1").map(|(rest, _)| rest), Ok("X#1"));
        assert_eq!(pieces("G1 X").map(|(rest, _)| rest), Ok("X"));
    }
}
