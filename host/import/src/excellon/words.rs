//! The words of a line's place.

use nom::Parser;
use nom::character::complete::satisfy;
use nom::multi::many1;
use nom::sequence::{pair, preceded};

use super::number::{Wrong, Zeros};
use super::read::{MAX_UM, Reader};
use crate::codes::Code;
use crate::diag::Diag;
use crate::line::{Parsed, blanks, column, decimal};

/// Words of a place, in um: X, Y, the radius A, the centre I, J.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Words {
    pub place: [Option<i64>; 2],
    pub radius: Option<i64>,
    pub center: [Option<i64>; 2],
}

impl Reader<'_> {
    /// Goes to the place that X and Y words name; `false` when they are wrong, which was said.
    pub(super) fn go(&mut self, number: u32, line: &str, text: &str) -> bool {
        let Some(words) = self.words(number, line, text) else { return false };
        if words.radius.is_some() || words.center != [None; 2] {
            let text = format!("`{text}` is no place");
            self.error(number, 1, Code::Unreadable, text, "a hole has X and Y");
            return false;
        }
        self.take(number, &words)
    }

    pub(super) fn take(&mut self, number: u32, words: &Words) -> bool {
        let mut at = self.at;
        for (at, um) in at.iter_mut().zip(words.place) {
            let Some(um) = um else { continue };
            *at = if self.relative { *at + um } else { um };
        }
        if at.iter().any(|um| um.abs() > MAX_UM) {
            let text = "this place is out of range";
            self.error(number, 1, Code::OutOfRange, text, "holes lie within 10 m");
            return false;
        }
        self.at = at;
        true
    }

    /// Reads X, Y, A, I and J words; `None` when they are wrong, which was said.
    pub(super) fn words(&mut self, number: u32, line: &str, text: &str) -> Option<Words> {
        // Some tools put a blank between a letter and its number, or between two words.
        let word = pair(preceded(blanks, satisfy(|c| "XYAIJ".contains(c))), decimal);
        let list: Parsed<'_, Vec<(char, &str)>> = many1(word).parse(text);
        let Ok((rest, list)) = list else {
            let what = format!("`{text}` is no place");
            let col = column(line, text);
            self.error(number, col, Code::Unreadable, what, "write `X1.5Y2.5`");
            return None;
        };
        if !rest.trim().is_empty() {
            let what = format!("`{}` does not belong here", rest.trim());
            let col = column(line, rest);
            self.error(number, col, Code::Unreadable, what, "a hole has X and Y");
            return None;
        }
        let mut words = Words::default();
        for (letter, value) in list {
            let um = self.coordinate(number, letter, value)?;
            let slot = match letter {
                'X' => &mut words.place[0],
                'Y' => &mut words.place[1],
                'A' => &mut words.radius,
                'I' => &mut words.center[0],
                _ => &mut words.center[1],
            };
            if slot.replace(um).is_some() {
                let text = format!("a second {letter} in one line");
                let hint = "the line may be cut, or two lines run together";
                self.error(number, 1, Code::Unreadable, text, hint);
                return None;
            }
        }
        Some(words)
    }

    fn coordinate(&mut self, number: u32, letter: char, value: &str) -> Option<i64> {
        if self.numbers.inches.is_none() {
            let text = "neither METRIC nor INCH is named: coordinates are taken to be in inches";
            self.warn(number, Code::Inconsistent, text, "write one of them as the first line");
        }
        let read = self.numbers.um(value);
        if self.numbers.is_guessed(value) && read.is_ok() {
            let text = "neither LZ nor TZ is named: by the look of the coordinates";
            let text = match self.numbers.guess {
                Some(Zeros::Leading) => {
                    format!("{text} trailing zeros are left out")
                }
                _ => format!("{text} leading zeros are left out"),
            };
            self.diags.once(Diag::new(Code::Said, number, 1, text).note());
        }
        match read {
            Ok(um) if um.abs() <= MAX_UM => return Some(um),
            Err(Wrong::Digits(whole, fraction)) => {
                let text =
                    format!("`{letter}{value}` has more digits than the format {whole}.{fraction}");
                let hint = "write the digits before and behind the point as the file's first line, \
                            such as `;FILE_FORMAT=3:5`";
                self.error(number, 1, Code::OutOfRange, text, hint);
            }
            _ => {
                let text = format!("`{letter}{value}` is out of range");
                self.error(number, 1, Code::OutOfRange, text, "one X and one Y within 10 m");
            }
        }
        None
    }
}
