//! A line of G-code as Grbl reads it: blanks and comments left out, then letters with numbers.

use super::Error;

/// Longest line in bytes; a longer one is `error:11`.
pub const LONGEST: usize = 255;

/// A letter, in capitals, and its number.
pub type Word = (char, f64);

/// Leaves out blanks, control characters, `( )` and `;` comments and `/`, and makes capitals. The text
/// behind `$` keeps its blanks in `$N0=` and the like with Grbl as little as here.
pub fn clean(line: &str) -> String {
    let mut out = String::new();
    let mut inside = false;
    for c in line.chars() {
        match c {
            ')' if inside => inside = false,
            _ if inside => {}
            '(' => inside = true,
            ';' => break,
            '/' => {}
            c if c <= ' ' => {}
            c => out.push(c.to_ascii_uppercase()),
        }
    }
    out
}

/// The words of a cleaned line.
///
/// # Errors
/// `error:1` where a letter is missing, `error:2` where a number is missing or has more than digits, a
/// sign and a point.
pub fn words(text: &str) -> Result<Vec<Word>, Error> {
    let mut list = Vec::new();
    let mut rest = text;
    while let Some(letter) = rest.chars().next() {
        if !letter.is_ascii_uppercase() {
            return Err(Error::LETTER);
        }
        rest = &rest[1..];
        let end = rest.find(|c: char| !(c.is_ascii_digit() || "+-.".contains(c)));
        let (number, behind) = rest.split_at(end.unwrap_or(rest.len()));
        list.push((letter, value(number).ok_or(Error::NUMBER)?));
        rest = behind;
    }
    Ok(list)
}

/// A number without exponent; none where it is no number or has more than 32 digits.
pub fn value(number: &str) -> Option<f64> {
    let digits = number.strip_prefix(['+', '-']).unwrap_or(number);
    let good = !digits.contains(['+', '-']) && digits.bytes().any(|c| c.is_ascii_digit());
    if !good || digits.len() > 32 {
        return None;
    }
    number.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::{clean, words};
    use crate::grbl::Error;

    #[test]
    fn a_line_is_cleaned_as_grbl_cleans_it() {
        assert_eq!(clean(" g1 x1.5 (to the (left) ) y-2 ; G0 X9"), "G1X1.5)Y-2");
        assert_eq!(clean("/g0\tx1(open G1"), "G0X1");
    }

    #[test]
    fn words_touch_and_what_is_none_has_its_number() {
        let read = |text: &str| words(text);
        assert_eq!(read("G1X1.5Y-.2"), Ok(vec![('G', 1.0), ('X', 1.5), ('Y', -0.2)]));
        for (text, error) in [
            ("1", Error::LETTER),
            ("G1X", Error::NUMBER),
            ("X1.2.3", Error::NUMBER),
            ("X--1", Error::NUMBER),
            ("X.", Error::NUMBER),
            ("X1E5", Error::NUMBER),
            ("G\u{e9}", Error::NUMBER),
            ("\u{e9}", Error::LETTER),
        ] {
            assert_eq!(read(text), Err(error), "{text}");
        }
    }
}
