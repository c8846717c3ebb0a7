//! A line of an NCP program taken apart.

use lang::front::literal::Decimal;

/// A command and what stands behind it.
pub(super) struct Command<'a> {
    /// In upper case.
    pub name: String,
    /// The rest of the line.
    pub rest: &'a str,
}

impl<'a> Command<'a> {
    /// `MOVEABS X5` and `MOVEABSX5` alike: a command ends at a blank, or where an axis and its number
    /// follow it directly.
    pub fn of(text: &'a str) -> Command<'a> {
        const MOVES: [&str; 4] = ["FASTABS", "MOVEABS", "FASTREL", "MOVEREL"];
        let upper = text.to_ascii_uppercase();
        let joined = MOVES.iter().find(|name| upper.starts_with(*name)).map(|name| name.len());
        let end = joined.unwrap_or_else(|| text.find([' ', '\t']).unwrap_or(text.len()));
        let (name, rest) = text.split_at(end);
        Command { name: name.to_ascii_uppercase(), rest }
    }
}

/// A line behind its number, `N000010`.
pub(super) fn without_number(line: &str) -> &str {
    let Some(digits) = line.strip_prefix(['N', 'n']) else { return line };
    let rest = digits.trim_start_matches(|c: char| c.is_ascii_digit());
    if rest.len() < digits.len() { rest.trim_start() } else { line }
}

/// Letters with whole numbers; one without a letter has the letter ` `.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Words {
    /// In the line's order; each letter once.
    pub list: Vec<(char, i64)>,
}

impl Words {
    /// Reads them all; the error is what cannot be read.
    pub fn of(text: &str) -> Result<Words, String> {
        let mut words = Words::default();
        let mut rest = text.trim_start();
        while let Some(first) = rest.chars().next() {
            let shown = || rest.split_whitespace().next().unwrap_or_default().to_owned();
            let letter = if first.is_ascii_alphabetic() { first.to_ascii_uppercase() } else { ' ' };
            let body = if letter == ' ' { rest } else { rest[1..].trim_start() };
            let sign = usize::from(body.starts_with(['+', '-']));
            let digits = body[sign..].find(|c: char| !c.is_ascii_digit() && c != '.');
            let end = digits.map_or(body.len(), |at| at + sign);
            let value = Decimal::parse(body[..end].trim_start_matches('+'));
            let value = value.and_then(|value| value.scaled(1, 1)).map(|(value, _)| value);
            // No machine is a kilometre long, and no sum of two such numbers overflows.
            let value = value.filter(|value| value.abs() <= 1_000_000_000).ok_or_else(shown)?;
            if words.get(letter).is_some() {
                return Err(shown());
            }
            words.list.push((letter, value));
            rest = body[end..].trim_start();
        }
        Ok(words)
    }

    /// The number behind a letter.
    pub fn get(&self, letter: char) -> Option<i64> {
        self.list.iter().find(|(known, _)| *known == letter).map(|(_, value)| *value)
    }

    /// The number of a command that has one, without a letter.
    pub fn plain(&self) -> Option<i64> {
        match self.list[..] {
            [(' ', value)] => Some(value),
            _ => None,
        }
    }
}

/// Words of several letters, each with its number if one follows: `CW RPM12000 TIME 2000`.
pub(super) fn named(text: &str) -> Vec<(String, Option<i64>)> {
    let mut list: Vec<(String, Option<i64>)> = Vec::new();
    for part in text.split_whitespace() {
        let end = part.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(part.len());
        let (word, number) = part.split_at(end);
        let number = (!number.is_empty()).then(|| number.parse().unwrap_or(-1));
        match list.last_mut() {
            Some((_, last @ None)) if word.is_empty() => *last = number,
            _ => list.push((word.to_ascii_uppercase(), number)),
        }
    }
    list
}
