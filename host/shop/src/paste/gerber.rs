//! Gerber layers (The Gerber Layer Format Specification, revision 2024.05): flashes, strokes,
//! regions, macros, blocks, step and repeat, in mm or inch.

mod draw;

use std::collections::BTreeMap;

use super::aperture::{self, Macro};
use super::outline::{Piece, Spot, Thing};
use super::{FAR, Layer, Side};
use crate::Wrong;

/// Errors that are kept.
const MOST_ERRORS: usize = 20;
/// Corners of all that is drawn.
const MOST_CORNERS: usize = 4_000_000;
/// Blocks and repetitions in each other.
const DEEPEST: usize = 10;
/// mm of an inch.
const INCH: f64 = 25.4;

/// Whether a text is Gerber.
pub(super) fn is_gerber(text: &str) -> bool {
    let found =
        |word| text.split(['\n', '\r', '*']).take(200).any(|part| part.trim().starts_with(word));
    found("%FS") || found("%MO") || found("%ADD") || found("G04 ")
}

/// What an aperture number stands for.
enum Aperture {
    Pieces(Vec<Piece>),
    Block(Vec<Thing>),
}

/// What is drawn into until it is closed.
enum Open {
    Block(u32, Vec<Thing>),
    Repeat([u32; 2], Spot, Vec<Thing>),
}

impl Open {
    fn things(&mut self) -> &mut Vec<Thing> {
        match self {
            Open::Block(_, things) | Open::Repeat(_, _, things) => things,
        }
    }
}

/// How the way between two places goes.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    Line,
    Clockwise,
    Counter,
}

/// How apertures are flashed: mirror of X and Y, degrees, scale.
#[derive(Clone, Copy)]
struct Turn {
    mirror: [bool; 2],
    degrees: f64,
    scale: f64,
}

struct Reader {
    layer: Layer,
    wrong: Vec<Wrong>,
    line: u32,
    /// Digits before and after the point, and whether zeros at the end are left out.
    format: Option<(usize, usize, bool)>,
    /// mm of a unit.
    unit: Option<f64>,
    macros: BTreeMap<String, Macro>,
    apertures: BTreeMap<u32, Aperture>,
    aperture: Option<u32>,
    at: Spot,
    way: Way,
    /// Arcs of at most a quarter, whose I and J have no sign.
    quarter: bool,
    region: Option<Vec<Spot>>,
    regions: Vec<Piece>,
    last: u32,
    dark: bool,
    turn: Turn,
    name: String,
    open: Vec<Open>,
    corners: usize,
}

/// Reads a layer.
pub(super) fn read(text: &str) -> Result<Layer, Vec<Wrong>> {
    let mut reader = Reader {
        layer: Layer { what: "a Gerber layer".to_owned(), ..Layer::default() },
        wrong: Vec::new(),
        line: 1,
        format: None,
        unit: None,
        macros: BTreeMap::new(),
        apertures: BTreeMap::new(),
        aperture: None,
        at: [0.0; 2],
        way: Way::Line,
        quarter: false,
        region: None,
        regions: Vec::new(),
        last: 0,
        dark: true,
        turn: Turn { mirror: [false; 2], degrees: 0.0, scale: 1.0 },
        name: String::new(),
        open: Vec::new(),
        corners: 0,
    };
    let ended = reader.words(text);
    reader.end_repeat();
    if !ended && reader.wrong.is_empty() {
        let note = Wrong::new(reader.line, "the file does not end in M02", "it may be cut");
        reader.layer.notes.push(note.warning());
    }
    if let (Some(open), true) = (reader.open.pop(), reader.wrong.is_empty()) {
        let what = if matches!(open, Open::Block(..)) { "%AB*%" } else { "%SR*%" };
        let words = format!("what was begun is not ended by {what}");
        reader.wrong.push(Wrong::new(reader.line, words, "the file may be cut"));
    }
    if reader.wrong.is_empty() { Ok(reader.layer) } else { Err(reader.wrong) }
}

impl Reader {
    /// Cuts the text into its words; whether the last one was there.
    fn words(&mut self, text: &str) -> bool {
        let mut extended: Option<Vec<(u32, String)>> = None;
        let (mut word, mut line, mut begun) = (String::new(), 1, 1);
        for c in text.chars() {
            match c {
                '\n' => line += 1,
                '\r' => {}
                '%' => match extended.take() {
                    None => extended = Some(Vec::new()),
                    Some(words) => self.extended(words),
                },
                '*' => {
                    let whole = std::mem::take(&mut word);
                    self.line = begun;
                    match &mut extended {
                        Some(words) => words.push((begun, whole)),
                        None if self.command(whole.trim()) => return true,
                        None => {}
                    }
                }
                _ => {
                    if word.is_empty() {
                        begun = line;
                    }
                    word.push(c);
                }
            }
            if self.wrong.len() >= MOST_ERRORS || self.corners > MOST_CORNERS {
                break;
            }
        }
        self.line = line;
        false
    }

    fn error(&mut self, words: impl Into<String>, hint: &str) {
        self.wrong.push(Wrong::new(self.line, words, hint));
    }

    fn unreadable(&mut self, word: &str) {
        let word: String = word.chars().take(40).collect();
        self.error(
            format!("`{word}` is not understood"),
            "let the board tool write Gerber X2 (RS-274X)",
        );
    }

    /// All between two percent signs.
    fn extended(&mut self, words: Vec<(u32, String)>) {
        let Some((line, first)) = words.first() else { return };
        self.line = *line;
        if let Some(name) = first.trim().strip_prefix("AM") {
            let body = words[1..].iter().map(|(_, word)| word.clone()).collect();
            self.macros.insert(name.to_owned(), body);
            return;
        }
        for (line, word) in words {
            self.line = line;
            self.parameter(word.trim());
        }
    }

    fn parameter(&mut self, word: &str) {
        let (code, rest) = word.split_at(word.char_indices().nth(2).map_or(word.len(), |(n, _)| n));
        match code {
            "FS" => self.format(rest),
            "MO" => match rest {
                "MM" => self.unit = Some(1.0),
                "IN" => self.unit = Some(INCH),
                _ => self.error(format!("`{word}` is no unit"), "known are %MOMM*% and %MOIN*%"),
            },
            "AD" => self.define(rest),
            "AB" => self.block(rest),
            "SR" => self.repeat(rest),
            "LP" => match rest {
                "D" => self.dark = true,
                "C" => self.dark = false,
                _ => self.unreadable(word),
            },
            "LM" => self.turn.mirror = [rest.contains('X'), rest.contains('Y')],
            "LR" | "LS" => match rest.parse::<f64>().ok().filter(|n| n.abs() <= 1e6) {
                Some(value) if code == "LR" => self.turn.degrees = value,
                Some(value) if value > 0.0 => self.turn.scale = value,
                _ => self.unreadable(word),
            },
            "TF" => self.function(rest),
            "TO" => {
                if let Some(name) = rest.strip_prefix(".C,").or_else(|| rest.strip_prefix(".P,")) {
                    name.split(',').next().unwrap_or_default().clone_into(&mut self.name);
                }
            }
            "TD" if rest.is_empty() || rest == ".C" || rest == ".P" => self.name.clear(),
            "TD" | "TA" | "LN" | "IN" => {}
            _ => self.old(word),
        }
    }

    /// What the layer is for.
    fn function(&mut self, rest: &str) {
        let mut words = rest.split(',');
        match (words.next(), words.next()) {
            (Some(".FileFunction"), Some(kind @ ("Paste" | "Glue" | "Other"))) => {
                self.layer.what = format!("the layer {kind}");
                self.layer.side = match words.next() {
                    Some("Top") => Some(Side::Top),
                    Some("Bot") => Some(Side::Bottom),
                    _ => None,
                };
            }
            (Some(".FileFunction"), Some(kind)) => self.error(
                format!("this file is the layer {kind}, no paste layer"),
                "open the paste layer of the same board, such as -F_Paste.gbr or .gtp",
            ),
            (Some(".FilePolarity"), Some("Negative")) => self.error(
                "a negative layer: what is drawn gets no paste",
                "let the board tool write the layer as positive",
            ),
            _ => {}
        }
    }

    /// Parameters of before 2014: their usual values change nothing.
    fn old(&mut self, word: &str) {
        let usual =
            ["IPPOS", "ASAXBY", "MIA0B0", "IR0", "SFA1B1", "SFA1.0B1.0", "OFA0B0", "OFA0.0B0.0"];
        if !usual.contains(&word) {
            self.unreadable(word);
        }
    }

    fn format(&mut self, rest: &str) {
        let trailing = rest.starts_with('T');
        let digits = ["LA", "TA"].iter().find_map(|start| rest.strip_prefix(start));
        let pair = digits.and_then(|rest| rest.strip_prefix('X')?.split_once('Y'));
        let read =
            pair.filter(|(x, y)| x == y && x.len() == 2 && x.is_ascii()).and_then(|(x, _)| {
                let (whole, part) = (x[..1].parse().ok()?, x[1..].parse().ok()?);
                (whole <= 6 && part <= 7).then_some((whole, part, trailing))
            });
        self.format = read;
        if read.is_none() {
            self.error(format!("`FS{rest}` is no format of numbers"), "known is %FSLAX46Y46*%");
        }
    }

    /// `D10C,0.5X0.2`.
    fn define(&mut self, rest: &str) {
        let Some(rest) = rest.strip_prefix('D') else { return self.unreadable(rest) };
        let digits = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
        let (number, shape) = rest.split_at(digits);
        let (kind, numbers) = shape.split_once(',').unwrap_or((shape, ""));
        let read = |text: &str| text.trim().parse::<f64>().ok().filter(|n| n.abs() <= 1e6);
        let numbers: Option<Vec<f64>> = match numbers {
            "" => Some(Vec::new()),
            numbers => numbers.split(['X', 'x']).map(read).collect(),
        };
        let (Ok(number), Some(numbers)) = (number.parse::<u32>(), numbers) else {
            return self.unreadable(&format!("AD{rest}"));
        };
        let Some(mm) = self.unit else {
            return self.error("an aperture before its unit", "a file begins with %FS and %MO");
        };
        let made = match kind {
            "C" | "R" | "O" | "P" => aperture::standard(kind, &numbers, mm),
            _ => match self.macros.get(kind) {
                Some(words) => aperture::of_macro(words, &numbers, mm),
                None => Err(format!("there is no macro `{kind}`")),
            },
        };
        match made {
            Ok(pieces) => drop(self.apertures.insert(number, Aperture::Pieces(pieces))),
            Err(words) => self.error(format!("aperture D{number}: {words}"), "the file may be cut"),
        }
    }

    /// A command of its own; whether it is the last.
    fn command(&mut self, word: &str) -> bool {
        if word.is_empty() || word.starts_with("G04") || word.starts_with("G4 ") {
            return false;
        }
        let mut rest = word;
        while let Some(code) = rest.strip_prefix('G') {
            let end = code.find(|c: char| !c.is_ascii_digit()).unwrap_or(code.len());
            match code[..end].parse::<u32>() {
                Ok(1) => self.way = Way::Line,
                Ok(2) => self.way = Way::Clockwise,
                Ok(3) => self.way = Way::Counter,
                Ok(36) => self.region = Some(Vec::new()),
                Ok(37) => self.end_region(),
                Ok(70) => self.unit = Some(INCH),
                Ok(71) => self.unit = Some(1.0),
                Ok(74) => self.quarter = true,
                Ok(75) => self.quarter = false,
                Ok(54 | 55 | 90) => {}
                _ => {
                    self.unreadable(word);
                    return false;
                }
            }
            rest = &code[end..];
        }
        match rest {
            "" => {}
            "M00" | "M02" | "M30" | "M0" | "M2" => return true,
            "M01" => {}
            _ => self.operation(rest),
        }
        false
    }

    /// `X12700000Y-2540000D03`, or a change of the aperture.
    fn operation(&mut self, word: &str) {
        let (places, code) = match word.split_once('D') {
            Some((places, code)) => match code.parse::<u32>() {
                Ok(code) => (places, code),
                Err(_) => return self.unreadable(word),
            },
            None => (word, self.last),
        };
        if code >= 10 && places.is_empty() {
            if !self.apertures.contains_key(&code) {
                self.error(format!("aperture D{code} is not defined"), "the file may be cut");
            }
            self.aperture = Some(code);
            return;
        }
        if self.format.is_none() || self.unit.is_none() {
            return self.error("a place before %FS and %MO", "the file may be cut");
        }
        let Some([x, y, i, j]) = self.numbers(places) else { return self.unreadable(word) };
        let to = [x.unwrap_or(self.at[0]), y.unwrap_or(self.at[1])];
        let middle = [i.unwrap_or(0.0), j.unwrap_or(0.0)];
        if to.iter().chain(&middle).any(|mm| mm.abs() > FAR) {
            return self.error(format!("`{word}` lies beyond 10 m"), "%FS and %MO may be wrong");
        }
        match code {
            1 => self.stroke(to, middle),
            2 => {
                if self.region.is_some() {
                    self.end_contour();
                }
            }
            3 => self.flash(to),
            _ => return self.unreadable(word),
        }
        self.last = code;
        self.at = to;
    }

    /// Coordinates in mm.
    fn numbers(&self, text: &str) -> Option<[Option<f64>; 4]> {
        let ((whole, part, trailing), unit) = (self.format?, self.unit?);
        let mut out = [None; 4];
        let mut rest = text;
        while let Some(letter) = rest.chars().next() {
            let n = "XYIJ".find(letter)?;
            let end =
                rest[1..].find(|c: char| c.is_ascii_alphabetic()).map_or(rest.len(), |n| n + 1);
            let digits = rest[1..end].trim();
            let value = match digits.contains('.') {
                true => digits.parse::<f64>().ok()?,
                false => {
                    let (sign, size) = match digits.strip_prefix('-') {
                        Some(size) => (-1.0, size),
                        None => (1.0, digits.strip_prefix('+').unwrap_or(digits)),
                    };
                    if size.is_empty() || size.len() > 15 {
                        return None;
                    }
                    let filled = match trailing {
                        true => format!("{size:0<width$}", width = whole + part),
                        false => size.to_owned(),
                    };
                    sign * filled.parse::<u64>().ok()? as f64 / 10_f64.powi(part as i32)
                }
            };
            out[n] = Some(value * unit);
            rest = &rest[end..];
        }
        Some(out)
    }
}
