//! Coordinates: their unit, and where the point stands that most files leave out.

use crate::line::Parsed;
use lang::front::literal::Decimal;
use nom::Parser;
use nom::character::complete::{char, digit1, one_of, space0};
use nom::sequence::separated_pair;

/// Which zeros of a coordinate stand in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Zeros {
    /// `LZ`: leading ones; trailing ones are left out.
    Leading,
    /// `TZ`: trailing ones; leading ones are left out.
    Trailing,
}

/// How coordinates without a point are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Numbers {
    /// Inches; millimetres with `false`.
    pub inches: Option<bool>,
    /// Digits before and behind the point.
    pub digits: Option<(usize, usize)>,
    pub zeros: Option<Zeros>,
    /// What the file's coordinates look like, for files that do not name their zeros.
    pub guess: Option<Zeros>,
}

/// Why a coordinate cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wrong {
    /// It is beyond any machine.
    Range,
    /// It has more digits than the format.
    Digits(usize, usize),
}

impl Numbers {
    /// Takes the format that a remark names, as several board tools write it; whether it did.
    ///
    /// `FORMAT={3:3/ absolute / metric / suppress leading zeros}` is KiCad's, `FILE_FORMAT=4:4`
    /// Altium's, `Format  : 2.4 / Absolute / Inch / Trailing` that of Siemens' tools, where the
    /// zeros named are those left out.
    pub fn remark(&mut self, remark: &str) -> bool {
        let lower = remark.trim().to_ascii_lowercase();
        let Some(rest) = lower.strip_prefix("file_format").or(lower.strip_prefix("format")) else {
            return false;
        };
        let rest = rest.trim_start_matches([' ', '\t', '=', ':', '{']);
        let pair: Parsed<'_, (&str, &str)> =
            separated_pair(digit1, (space0, one_of(":."), space0), digit1).parse(rest);
        if let Ok((_, (whole, fraction))) = pair
            && let (Ok(whole), Ok(fraction)) = (whole.parse(), fraction.parse())
            && whole + fraction <= MAX_DIGITS
        {
            self.digits = Some((whole, fraction));
        }
        let words: Vec<&str> = rest.split('/').map(str::trim).collect();
        let named = |text: &[&str]| words.iter().any(|word| text.contains(word));
        if named(&["suppress leading zeros", "leading}", "leading"]) {
            self.zeros.get_or_insert(Zeros::Trailing);
        } else if named(&["suppress trailing zeros", "trailing}", "trailing"]) {
            self.zeros.get_or_insert(Zeros::Leading);
        }
        true
    }

    /// Takes a header's `METRIC,TZ,000.000`, or the part of it behind M71 and M72.
    ///
    /// # Errors
    /// The word that is no number format.
    pub fn header<'t>(&mut self, text: &'t str) -> Result<(), &'t str> {
        for part in text.split(',').map(str::trim) {
            match part {
                "METRIC" | "M71" => self.set_inches(false),
                "INCH" | "M72" => self.set_inches(true),
                "LZ" => self.zeros = Some(Zeros::Leading),
                "TZ" => self.zeros = Some(Zeros::Trailing),
                "" => {}
                _ => match part.split_once('.') {
                    Some((whole, fraction))
                        if part.bytes().all(|b| b == b'0' || b == b'.')
                            && part.len() <= MAX_DIGITS + 1 =>
                    {
                        self.digits = Some((whole.len(), fraction.len()));
                    }
                    _ => return Err(part),
                },
            }
        }
        Ok(())
    }

    /// Another unit has its own digits.
    fn set_inches(&mut self, inches: bool) {
        if self.inches.is_some_and(|before| before != inches) {
            self.digits = None;
        }
        self.inches = Some(inches);
    }

    /// Digits before and behind the point: those named, else 2.4 for inches and 3.3 for
    /// millimetres (IPC-NC-349).
    fn places(&self) -> (usize, usize) {
        self.digits.unwrap_or(if self.is_inches() { (2, 4) } else { (3, 3) })
    }

    /// A file that names no unit is in inches, which Excellon began with.
    pub fn is_inches(&self) -> bool {
        self.inches.unwrap_or(true)
    }

    /// Whether a coordinate's point stands where it does by [`Numbers::guess`] only.
    pub fn is_guessed(&self, text: &str) -> bool {
        let (whole, fraction) = self.places();
        let digits = text.trim_start_matches(['-', '+']);
        let shorter = digits.len() < whole + fraction && digits != "0";
        self.zeros.is_none() && !text.contains('.') && shorter
    }

    /// A coordinate in um.
    ///
    /// # Errors
    /// See [`Wrong`].
    pub fn um(&self, text: &str) -> Result<i64, Wrong> {
        let unit = if self.is_inches() { 25_400 } else { 1000 };
        let read = |text: &str| {
            let (um, _) = Decimal::parse(text)?.scaled(unit, 1)?;
            Some(um)
        };
        if text.contains('.') {
            return read(text).ok_or(Wrong::Range);
        }
        let (whole, fraction) = self.places();
        let (sign, digits) = match text.strip_prefix(['-', '+']) {
            Some(digits) => (&text[..1], digits),
            None => ("", text),
        };
        if digits.len() > whole + fraction {
            return Err(Wrong::Digits(whole, fraction));
        }
        let width = whole + fraction;
        let digits = match self.zeros.or(self.guess).unwrap_or(Zeros::Trailing) {
            Zeros::Leading => format!("{digits:0<width$}"),
            Zeros::Trailing => format!("{digits:0>width$}"),
        };
        let (whole, fraction) = digits.split_at(whole);
        read(&format!("{sign}{whole}.{fraction}")).ok_or(Wrong::Range)
    }
}

/// Digits of a coordinate that are read.
const MAX_DIGITS: usize = 9;

/// What the coordinates of a file that does not name its zeros look like: leading ones stand where
/// one of them begins with 0 and is not 0 itself. `None` without such a coordinate.
pub(super) fn guess(lines: &[(u32, &str)]) -> Option<Zeros> {
    let coordinate = |i| -> Parsed<'_, &str> {
        let sign = nom::combinator::opt(one_of("+-"));
        let (i, (_, _, digits)) = (one_of("XY"), sign, digit1).parse(i)?;
        let (i, _) = nom::combinator::not(char('.')).parse(i)?;
        Ok((i, digits))
    };
    let mut seen = None;
    for (_, line) in lines {
        let mut rest = line.trim();
        while let Ok((after, digits)) = coordinate(rest) {
            if digits.len() > 1 && digits.starts_with('0') {
                return Some(Zeros::Leading);
            }
            if digits != "0" {
                seen = Some(Zeros::Trailing);
            }
            rest = after.strip_prefix("G85").unwrap_or(after);
        }
    }
    seen
}

#[cfg(test)]
mod tests {
    use super::{Numbers, Wrong, Zeros, guess};

    fn numbers(header: &str, remark: &str) -> Numbers {
        let mut numbers = Numbers::default();
        numbers.header(header).expect("a header");
        numbers.remark(remark);
        numbers
    }

    /// Worked by hand: `0127` behind 2 whole digits is 01.27 in, before 4 decimals 0.0127 in.
    #[test]
    fn zeros_and_digits_place_the_point() {
        let um = |numbers: Numbers, text: &str| numbers.um(text);
        assert_eq!(um(numbers("INCH,LZ", ""), "0127"), Ok(32_258));
        assert_eq!(um(numbers("INCH,TZ", ""), "0127"), Ok(323));
        assert_eq!(um(numbers("METRIC,LZ", "FILE_FORMAT=4:4"), "002365"), Ok(23_650));
        assert_eq!(um(numbers("METRIC,LZ", "FILE_FORMAT=4:4"), "00159755"), Ok(15_976));
        assert_eq!(um(numbers("METRIC,LZ", "FILE_FORMAT=4:4"), "-00015"), Ok(-1500));
        assert_eq!(um(numbers("INCH,TZ", "FILE_FORMAT=2:2"), "+1000"), Ok(254_000));
        assert_eq!(um(numbers("METRIC,0000.00", ""), "+004398"), Ok(43_980));
        assert_eq!(um(numbers("M71,TZ", ""), "-33.975"), Ok(-33_975));
        let kicad = " FORMAT={4:2/ absolute / metric / suppress leading zeros}";
        assert_eq!(um(numbers("METRIC", kicad), "1270"), Ok(12_700));
        let siemens = " Format  : 3.3 / Absolute / MM / Leading";
        assert_eq!(um(numbers("METRIC", siemens), "9560"), Ok(9560));
        assert_eq!(um(numbers("INCH,LZ", ""), "00130500"), Err(Wrong::Digits(2, 4)));
    }

    #[test]
    fn another_unit_drops_the_digits() {
        let mut both = numbers("METRIC,TZ,0000.00", "");
        both.header("M72").expect("a header");
        assert_eq!(both.um("12345"), Ok(31_356));
    }

    #[test]
    fn zeros_are_seen_in_the_coordinates() {
        let eagle = [(1, "M72"), (2, "X9250Y4064"), (3, "X12100Y0")];
        assert_eq!(guess(&eagle), Some(Zeros::Trailing));
        let pads = [(1, "X0362Y049"), (2, "X11Y1")];
        assert_eq!(guess(&pads), Some(Zeros::Leading));
        assert_eq!(guess(&[(1, "X1.5Y0.5")]), None);
    }
}
