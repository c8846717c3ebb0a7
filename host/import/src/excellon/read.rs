//! From lines to holes, slots and routes.

use std::collections::BTreeMap;

use super::number::{Numbers, guess};
use super::{Arc, Cut, Place, Round, Segment, Step};
use crate::codes::Code;
use crate::diag::{Diag, Diags};
use crate::line::column;

/// Holes, slots and pieces of routes of one file.
const MAX_CUTS: usize = 100_000;
/// Greatest coordinate, um.
pub(super) const MAX_UM: i64 = 10_000_000;

/// How a route moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    /// G00: above the board.
    Above,
    /// G01
    Straight,
    /// G02, G03
    Arc { clockwise: bool },
}

/// See the module.
pub(super) struct Reader<'d> {
    pub(super) diags: &'d mut Diags,
    header: bool,
    pub(super) numbers: Numbers,
    pub(super) relative: bool,
    tool: u32,
    sizes: BTreeMap<u32, String>,
    pub(super) at: Place,
    /// How a route moves; `None` while drilling.
    routing: Option<Motion>,
    /// The tool is down on a route.
    down: bool,
    /// The path that is being milled.
    path: Option<(Place, Vec<Segment>)>,
    cuts: Vec<Step>,
    /// Of those, pieces that were counted.
    count: usize,
    /// Where the pattern begins, and where it ends once it has.
    pattern: (usize, Option<usize>),
    /// How far the pattern's last repetition lies from it.
    shift: Place,
    pub(super) ended: bool,
    last: u32,
}

impl<'d> Reader<'d> {
    /// Before the first line.
    pub(super) fn new(lines: &[(u32, &str)], diags: &'d mut Diags) -> Reader<'d> {
        Reader {
            diags,
            header: false,
            numbers: Numbers { guess: guess(lines), ..Numbers::default() },
            relative: false,
            tool: 0,
            sizes: BTreeMap::new(),
            at: [0; 2],
            routing: None,
            down: false,
            path: None,
            cuts: Vec::new(),
            count: 0,
            pattern: (0, None),
            shift: [0; 2],
            ended: false,
            last: 1,
        }
    }

    pub(super) fn error(
        &mut self,
        number: u32,
        col: u32,
        code: Code,
        text: impl Into<String>,
        hint: &str,
    ) {
        self.diags.push(Diag::new(code, number, col, text).hint(hint));
    }

    pub(super) fn warn(&mut self, number: u32, code: Code, text: impl Into<String>, hint: &str) {
        self.diags.once(Diag::new(code, number, 1, text).warning().hint(hint));
    }

    /// Reads a line.
    pub(super) fn line(&mut self, number: u32, line: &str) {
        self.last = number;
        let mut text = line.trim();
        if let Some(remark) = text.strip_prefix(';') {
            return self.remark(remark);
        }
        if let Some(rest) = text.strip_prefix('/') {
            let what = "`/` makes this line optional; it is executed";
            self.diags.once(Diag::new(Code::Changed, number, 1, what).warning());
            text = rest.trim_start();
        }
        if text.starts_with("METRIC") || text.starts_with("INCH") || text.starts_with("M7") {
            if let Err(wrong) = self.numbers.header(text) {
                let text = format!("`{wrong}` is no number format");
                let hint = "known are LZ, TZ and digits such as 000.000";
                self.error(number, 1, Code::Unreadable, text, hint);
            }
            return;
        }
        match text {
            "" | "FMAT,2" => {}
            "M48" => self.header = true,
            "%" | "M95" => self.header = false,
            "M30" | "M00" => {
                self.lift();
                self.ended = true;
            }
            "G05" | "G81" => {
                self.lift();
                self.routing = None;
            }
            "G90" | "ICI,OFF" => self.relative = false,
            "G91" | "ICI,ON" | "ICI" => self.relative = true,
            "M15" => self.down = true,
            "M16" | "M17" => self.lift(),
            "G40" => {}
            "M25" if !self.header => {
                self.pattern = (self.cuts.len(), None);
                self.shift = [0; 2];
            }
            "M01" if !self.header => self.pattern.1 = Some(self.cuts.len()),
            "M08" | "M02" if !self.header => self.pattern.1 = None,
            _ if text.starts_with(['X', 'Y']) => self.place(number, line, text),
            _ if self.header && !text.starts_with('T') => {
                // VER, DETECT, ATC and the like set up another machine.
                let text = format!("`{text}` sets up another machine; it is left out");
                self.diags.push(Diag::new(Code::LeftOut, number, 1, text).note());
            }
            _ => self.command(number, line, text),
        }
    }

    /// A remark may name the format, or as Allegro writes it a tool:
    /// `T01 Holesize 1. = 12.000000 Tolerance = ... PLATED MILS Quantity = 241`.
    fn remark(&mut self, remark: &str) {
        if self.numbers.remark(remark) {
            return;
        }
        let mut words = remark.split_whitespace();
        let tool = words.next().and_then(|word| word.strip_prefix('T')).map(str::parse);
        let (Some(Ok(tool)), Some("Holesize")) = (tool, words.next()) else { return };
        let size = remark.split_once('=').and_then(|(_, rest)| rest.split_whitespace().next());
        let unit = words.find_map(|word| match word {
            "MILS" => Some((true, "mil")),
            "INCHES" => Some((true, "in")),
            "MM" => Some((false, "mm")),
            _ => None,
        });
        if let (Some(size), Some((inches, unit))) = (size, unit) {
            self.numbers.inches.get_or_insert(inches);
            let size = size.trim_end_matches('0').trim_end_matches('.');
            self.sizes.insert(tool, format!("{size} {unit}"));
        }
    }

    /// A line that begins neither with a coordinate nor is a fixed word.
    fn command(&mut self, number: u32, line: &str, text: &str) {
        if let Some(rest) = text.strip_prefix('T') {
            return self.select(number, line, rest);
        }
        if let Some(rest) = text.strip_prefix('R') {
            return self.repeat(number, line, rest);
        }
        if let Some(rest) = text.strip_prefix("M02") {
            return self.again(number, line, rest);
        }
        if let Some(rest) = text.strip_prefix("G93") {
            let zero = self.words(number, line, rest).map(|words| words.place);
            if zero.is_some_and(|place| place.iter().flatten().any(|um| *um != 0)) {
                let hint = "let the board tool write coordinates from one zero";
                self.error(number, 1, Code::Unsupported, format!("`{text}`: another zero"), hint);
            }
            return;
        }
        let motions = [
            ("G00", Motion::Above),
            ("G01", Motion::Straight),
            ("G02", Motion::Arc { clockwise: true }),
            ("G03", Motion::Arc { clockwise: false }),
        ];
        for (word, motion) in motions {
            if let Some(rest) = text.strip_prefix(word) {
                return self.route(number, line, motion, rest.trim_start());
            }
        }
        let starts = |list: &[&str]| list.iter().any(|word| text.starts_with(word));
        let (why, hint) = if starts(&["M97", "M98"]) {
            ("text that is drilled in dots", "let the board tool write each dot as a hole")
        } else if starts(&["G82", "G83", "G84", "G87"]) {
            ("a pattern of holes", "let the board tool write each hole")
        } else if starts(&["G32", "G33"]) {
            ("a routed circle", "let the board tool write G02 or G03")
        } else if starts(&["G41", "G42"]) {
            ("cutter radius compensation", "let the board tool offset the path")
        } else if starts(&["M45", "M47", "M06", "M09", "M18"]) {
            let text = format!("`{text}` is for the operator of another machine; it is left out");
            return self.warn(number, Code::LeftOut, text, "write PRINT or M0 where it matters");
        } else {
            (
                "this is no drilling",
                "known are tools T, holes X Y, repeats R, slots G85, patterns M25 M01 M02, routes \
                 G00 G01 G02 G03 M15 M16, G05, G81, G90, M30",
            )
        };
        self.error(number, 1, Code::Unsupported, format!("`{text}`: {why}"), hint);
    }

    /// `T1C0.8` or `T1C.015F200S65` in the header names a tool, `T1` in the body takes it.
    fn select(&mut self, number: u32, line: &str, rest: &str) {
        self.lift();
        let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let Ok(tool) = rest[..digits].parse::<u32>() else {
            let text = format!("`T{rest}` is no tool");
            return self.error(number, column(line, rest), Code::Unreadable, text, "write `T1`");
        };
        let size = rest[digits..].split_once('C').map(|(_, size)| size);
        if let Some(size) = size {
            let end = size.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(size.len());
            let unit = if self.numbers.is_inches() { "in" } else { "mm" };
            let zero = if size.starts_with('.') { "0" } else { "" };
            self.sizes.insert(tool, format!("{zero}{} {unit}", &size[..end]));
        }
        if self.header {
            return;
        }
        if tool != 0 && !self.sizes.is_empty() && !self.sizes.contains_key(&tool) {
            let text = format!("tool T{tool} is not in the header's list");
            self.warn(number, Code::Inconsistent, text, "its size is not known");
        }
        self.tool = tool;
    }

    /// A hole, a slot with G85, or on a route its next place.
    fn place(&mut self, number: u32, line: &str, text: &str) {
        if let Some(motion) = self.routing {
            return self.route(number, line, motion, text);
        }
        let (start, end) = match text.split_once("G85") {
            Some((start, end)) => (start, Some(end)),
            None => (text, None),
        };
        if !self.go(number, line, start) {
            return;
        }
        let from = self.at;
        match end {
            None => self.add(number, Cut::Hole(from)),
            Some(end) if self.go(number, line, end) => {
                self.add(number, Cut::Slot(from, self.at));
            }
            Some(_) => {}
        }
    }

    /// G00 goes somewhere above the board; G01, G02 and G03 mill there with the tool down.
    fn route(&mut self, number: u32, line: &str, motion: Motion, text: &str) {
        self.routing = Some(motion);
        if motion == Motion::Above {
            self.lift();
        }
        if text.is_empty() {
            return;
        }
        let Some(words) = self.words(number, line, text) else { return };
        let from = self.at;
        if !self.take(number, &words) || motion == Motion::Above {
            return;
        }
        let arc = match motion {
            Motion::Arc { clockwise } => {
                let round = match (words.radius, words.center) {
                    (Some(radius), [None, None]) if radius > 0 => Round::Radius(radius),
                    (None, center @ ([Some(_), _] | [_, Some(_)])) => {
                        Round::Center(center.map(Option::unwrap_or_default))
                    }
                    _ => {
                        let hint = "write its radius A, or its centre I J from the start";
                        return self.error(
                            number,
                            1,
                            Code::WrongCount,
                            "an arc of no circle",
                            hint,
                        );
                    }
                };
                Some(Arc { clockwise, round })
            }
            _ => None,
        };
        if !self.down {
            let text = "a route with the tool up mills nothing; it is left out";
            return self.warn(number, Code::LeftOut, text, "M15 lowers the tool before G01");
        }
        let to = self.at;
        if self.counted(number) {
            self.path.get_or_insert((from, Vec::new())).1.push(Segment { to, arc });
        }
    }

    /// The tool comes up: the path ends.
    fn lift(&mut self) {
        self.down = false;
        let Some((from, list)) = self.path.take() else { return };
        let cut = match list[..] {
            [Segment { to, arc: None }] => Cut::Slot(from, to),
            _ => Cut::Route(from, list),
        };
        self.cuts.push(Step { tool: self.tool, line: self.last, cut });
    }

    /// `R5X2.54Y0`: the last hole five times more.
    fn repeat(&mut self, number: u32, line: &str, rest: &str) {
        let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let times = rest[..digits].parse::<usize>().ok().filter(|times| *times <= MAX_CUTS);
        let hole = |step: &&Step| matches!(step.cut, Cut::Hole(_)) && step.tool == self.tool;
        let drilled = self.cuts.last().filter(hole).is_some();
        let (Some(times), true) = (times, drilled) else {
            let text = format!("`R{rest}` repeats no hole");
            let hint = "write a hole, then `R5X2.54`: five more, each 2.54 further";
            return self.error(number, 1, Code::Unreadable, text, hint);
        };
        let absolute = core::mem::replace(&mut self.relative, true);
        let first = self.at;
        if self.go(number, line, &rest[digits..]) {
            let step = [self.at[0] - first[0], self.at[1] - first[1]];
            for turn in 1..=times as i64 {
                let at = [0, 1].map(|i: usize| first[i] + turn * step[i]);
                if at.iter().any(|um| um.abs() > MAX_UM) || self.ended {
                    let text = format!("`R{rest}` leads out of range");
                    self.error(number, 1, Code::OutOfRange, text, "holes lie within 10 m");
                    break;
                }
                self.at = at;
                self.add(number, Cut::Hole(at));
            }
        }
        self.relative = absolute;
    }

    /// `M02X50Y0`: the pattern of M25 to M01 once more, so much further than the last time.
    fn again(&mut self, number: u32, line: &str, rest: &str) {
        let Some(words) = self.words(number, line, rest) else { return };
        let (from, Some(to)) = self.pattern else {
            let text = format!("`M02{rest}` repeats no pattern");
            let hint = "a pattern stands between M25 and M01";
            return self.error(number, 1, Code::Unreadable, text, hint);
        };
        for (shift, step) in self.shift.iter_mut().zip(words.place) {
            *shift += step.unwrap_or(0);
        }
        let by = self.shift;
        if by.iter().any(|um| um.abs() > MAX_UM) {
            let text = format!("`M02{rest}` leads out of range");
            return self.error(number, 1, Code::OutOfRange, text, "holes lie within 10 m");
        }
        for index in from..to {
            if !self.counted(number) {
                return;
            }
            let step = &self.cuts[index];
            let copy = Step { tool: step.tool, line: number, cut: step.cut.moved(by) };
            self.cuts.push(copy);
        }
    }

    fn add(&mut self, number: u32, cut: Cut) {
        if self.counted(number) {
            self.cuts.push(Step { tool: self.tool, line: number, cut });
        }
    }

    /// Counts a hole or a piece of a route; `false` when there are too many, which was said.
    fn counted(&mut self, number: u32) -> bool {
        self.count += 1;
        if self.count <= MAX_CUTS {
            return true;
        }
        self.ended = true;
        let text = format!("more than {MAX_CUTS} holes");
        self.error(number, 1, Code::TooLong, text, "cut the file in pieces");
        false
    }

    /// The cuts and the tools' sizes.
    pub(super) fn finish(mut self) -> (Vec<Step>, BTreeMap<u32, String>) {
        self.lift();
        if self.cuts.is_empty() && !self.diags.has_errors() {
            // KiCad writes such a file for a board without holes that are not plated.
            let diag = Diag::new(Code::NoProgram, 1, 1, "the file has no hole");
            self.diags.push(if self.ended { diag.warning() } else { diag });
        } else if !self.ended {
            let diag = Diag::new(Code::NoProgram, self.last, 1, "the file does not end in M30");
            self.diags.push(diag.warning().hint("it may be cut"));
        }
        (self.cuts, self.sizes)
    }
}
