//! Drill files in Gerber (The Gerber Layer Format Specification, revision 2024.05): each flash is a
//! hole of its aperture's size.

use std::collections::BTreeMap;

use super::{MAX_UM, MOST_POINTS, Point};
use crate::codes::Code;
use crate::diag::{Diag, Diags};

/// Whether a text is Gerber.
pub(super) fn is_gerber(text: &str) -> bool {
    let found =
        |word| text.split(['\n', '\r', '*']).take(200).any(|part| part.trim().starts_with(word));
    found("%FS") || found("%MO") || found("%ADD")
}

/// What was read so far.
struct Reader<'d> {
    diags: &'d mut Diags,
    line: u32,
    /// Decimals of a coordinate.
    decimals: Option<u32>,
    /// um of a unit, as a fraction.
    unit: Option<(i64, i64)>,
    /// Sizes of the apertures.
    sizes: BTreeMap<u32, String>,
    aperture: u32,
    at: [i64; 2],
    /// Between G36 and G37.
    region: bool,
    /// The file said that it is a drill file.
    named: bool,
    /// What was drawn with a hole's aperture.
    slots: usize,
    points: Vec<Point>,
}

/// Reads the holes.
pub(super) fn read(text: &str, diags: &mut Diags) -> Vec<Point> {
    let mut reader = Reader {
        diags,
        line: 1,
        decimals: None,
        unit: None,
        sizes: BTreeMap::new(),
        aperture: 0,
        at: [0; 2],
        region: false,
        named: false,
        slots: 0,
        points: Vec::new(),
    };
    let mut extended = false;
    let mut word = String::new();
    let mut line = 1;
    let mut ended = false;
    for c in text.chars() {
        match c {
            '\n' => line += 1,
            '\r' => {}
            '%' => extended = !extended,
            '*' => {
                let whole = std::mem::take(&mut word);
                if extended {
                    reader.extended(&whole);
                } else if reader.command(whole.trim()) {
                    ended = true;
                    break;
                }
            }
            _ => {
                if word.is_empty() {
                    reader.line = line;
                }
                word.push(c);
            }
        }
        if reader.diags.hopeless() || reader.points.len() > MOST_POINTS {
            break;
        }
    }
    let Reader { diags, named, slots, points, .. } = reader;
    if !ended && !diags.has_errors() && points.len() <= MOST_POINTS {
        let diag = Diag::new(Code::NoProgram, line, 1, "the file does not end in M02");
        diags.push(diag.warning().hint("it may be cut"));
    }
    if !named {
        let words =
            "the file does not say that it is a drill file: its flashes are taken for holes";
        diags.push(Diag::new(Code::Said, 1, 1, words).note());
    }
    if slots > 0 {
        let words = format!("{slots} slots are left out: only holes are points");
        diags.push(Diag::new(Code::LeftOut, 1, 1, words).warning());
    }
    points
}

impl Reader<'_> {
    fn error(&mut self, words: impl Into<String>, hint: &str) {
        self.diags.push(Diag::new(Code::Unsupported, self.line, 1, words).hint(hint));
    }

    /// A command between percent signs.
    fn extended(&mut self, word: &str) {
        const HINT: &str = "let the board tool write its drill file as Excellon";
        let word = word.trim();
        if let Some(format) = word.strip_prefix("FS") {
            let digits = format.strip_prefix("LAX").and_then(|rest| rest.split_once('Y'));
            let decimals = digits.filter(|(x, y)| x == y && x.len() == 2);
            let decimals = decimals.and_then(|(x, _)| x[1..].parse().ok()).filter(|n| *n <= 6);
            self.decimals = decimals;
            if decimals.is_none() {
                self.error(format!("`{word}` is no format of numbers"), "known is %FSLAX46Y46*%");
            }
        } else if let Some(unit) = word.strip_prefix("MO") {
            self.unit = match unit {
                "MM" => Some((1000, 1)),
                "IN" => Some((25_400, 1)),
                _ => None,
            };
            if self.unit.is_none() {
                self.error(format!("`{word}` is no unit"), "known are %MOMM*% and %MOIN*%");
            }
        } else if let Some(aperture) = word.strip_prefix("ADD") {
            let digits = aperture.find(|c: char| !c.is_ascii_digit()).unwrap_or(aperture.len());
            let size = aperture[digits..].strip_prefix("C,").map(|size| {
                let unit = if self.unit == Some((25_400, 1)) { "in" } else { "mm" };
                let size = size.split('X').next().unwrap_or_default();
                let short = size.trim_end_matches('0').trim_end_matches('.');
                format!("{} {unit}", if size.contains('.') { short } else { size })
            });
            match aperture[..digits].parse() {
                Ok(number) => drop(self.sizes.insert(number, size.unwrap_or_default())),
                Err(_) => self.error(format!("`{word}` is no aperture"), HINT),
            }
        } else if let Some(what) = word.strip_prefix("TF.FileFunction,") {
            self.named = ["Plated", "NonPlated"].iter().any(|kind| what.starts_with(kind));
            if !self.named {
                let layer = what.split(',').next().unwrap_or_default();
                let words = format!("this Gerber file is the layer {layer}, no drill file");
                self.error(words, "open the drill file of the same board");
            }
        } else if ["AB", "SR", "LPC", "IPNEG"].iter().any(|start| word.starts_with(start))
            && !["SR", "SRX1Y1I0J0", "AB"].contains(&word)
        {
            self.error(format!("`{word}` stands in no drill file"), HINT);
        }
        // The rest tells what things are: attributes, macros of pads, polarity.
    }

    /// A command of its own; whether it is the last.
    fn command(&mut self, word: &str) -> bool {
        if word.starts_with("G04") || word.is_empty() {
            return false;
        }
        let word = word.strip_prefix("G54").unwrap_or(word);
        match word {
            "M02" | "M00" | "M30" => return true,
            "G36" => {
                self.region = true;
                self.error(
                    "a region stands in no drill file",
                    "open the drill file of the same board",
                );
            }
            "G37" => self.region = false,
            "G01" | "G02" | "G03" | "G74" | "G75" | "G90" => {}
            "G70" => self.unit = Some((25_400, 1)),
            "G71" => self.unit = Some((1000, 1)),
            _ => self.operation(word),
        }
        false
    }

    /// `X12700000Y-2540000D03`, or a change of the aperture.
    fn operation(&mut self, word: &str) {
        let word = ["G01", "G02", "G03"].iter().find_map(|g| word.strip_prefix(g)).unwrap_or(word);
        let Some((places, code)) = word.split_once('D') else {
            return self.error(format!("`{word}` is no operation"), "known are D01, D02, D03");
        };
        let Ok(code) = code.parse::<u32>() else {
            return self.error(format!("`{word}` is no operation"), "known are D01, D02, D03");
        };
        if code >= 10 && places.is_empty() {
            if !self.sizes.contains_key(&code) {
                self.error(format!("aperture D{code} is not defined"), "the file may be cut");
            }
            self.aperture = code;
            return;
        }
        let (Some(decimals), Some(unit)) = (self.decimals, self.unit) else {
            return self.error("a place before %FS and %MO", "the file may be cut");
        };
        let mut rest = places;
        while let Some(letter) = rest.chars().next() {
            let body = &rest[letter.len_utf8()..];
            let end = body.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(body.len());
            let um = body[..end].parse::<i64>().ok().and_then(|n| scaled(n, decimals, unit));
            let Some(um) = um.filter(|um| um.abs() <= MAX_UM) else {
                return self.error(format!("`{word}` is no place"), "places lie within 10 m");
            };
            match letter {
                'X' => self.at[0] = um,
                'Y' => self.at[1] = um,
                'I' | 'J' => {}
                _ => return self.error(format!("`{word}` is no place"), "known are X, Y, I and J"),
            }
            rest = &body[end..];
        }
        match code {
            1 => self.slots += usize::from(!self.region),
            2 => {}
            3 => {
                let size = self.sizes.get(&self.aperture).filter(|size| !size.is_empty());
                let group = size.cloned().unwrap_or_else(|| format!("D{}", self.aperture));
                self.points.push(Point { name: String::new(), at: self.at, group });
            }
            _ => self.error(format!("`{word}` is no operation"), "known are D01, D02, D03"),
        }
    }
}

/// A coordinate in um, half away from zero.
fn scaled(n: i64, decimals: u32, (num, den): (i64, i64)) -> Option<i64> {
    let (up, down) = (n.checked_mul(num)?, den * 10_i64.pow(decimals));
    let twice = up.checked_abs()?.checked_mul(2)?.checked_add(down)?;
    Some(twice / (2 * down) * n.signum())
}
