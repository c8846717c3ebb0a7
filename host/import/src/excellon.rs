//! Drill files of circuit board tools: Excellon, as KiCad, Eagle, Altium and their kin write it.
//!
//! Coordinates with a point are what they say. Without one they count in the format's last
//! decimal (IPC-NC-349): 3.3 digits for METRIC, 2.4 for INCH; `LZ` keeps leading zeros and leaves
//! trailing ones out, `TZ` the other way round. `R5X2.54` repeats the last hole five times, each
//! time by so much further; `X1Y1G85X3Y1` and a route of G00, M15, G01, M16 are slots.

use nom::Parser;
use nom::bytes::complete::take_while;
use nom::character::complete::{one_of, satisfy};
use nom::combinator::{opt, recognize};
use nom::multi::many1;
use nom::sequence::pair;

use super::Job;
use super::codes::Code;
use super::diag::{Diag, Diags};
use super::line::{Parsed, column, decimal};
use super::script::{Made, Script, mm};
use lang::axis::Axis;
use lang::front::literal::Decimal;
use std::collections::BTreeMap;

/// Holes of one file.
const MAX_HOLES: usize = 100_000;
/// Rows of a table on one line.
const ROWS_A_LINE: usize = 4;
/// Greatest coordinate, um.
const MAX_UM: i64 = 10_000_000;

/// Makes a script of a drill file.
pub(crate) fn import(job: &Job<'_>, diags: &mut Diags) -> Made {
    let lines = job.lines.numbered(diags);
    let mut reader = Reader::new(diags);
    for (number, line) in lines {
        reader.line(number, line);
        if reader.ended || reader.diags.hopeless() {
            break;
        }
    }
    let (runs, sizes) = reader.finish();
    if let Some(axis) = Axis::ALL.into_iter().find(|axis| job.profile.axis(*axis).is_none()) {
        let text = format!("the machine `{}` has no axis {}", job.profile.name, axis.letter());
        diags.push(Diag::new(Code::WrongAxis, 1, 1, text).hint("choose another with `--profile`"));
    }
    if diags.has_errors() {
        return Made::default();
    }
    write(job, &runs, &sizes, diags)
}

/// Holes or slots that one tool makes in a row.
struct Run {
    tool: u32,
    /// Slots, which have an end.
    slots: bool,
    /// From where, and for slots to where.
    places: Vec<[[i64; 2]; 2]>,
}

struct Reader<'d> {
    diags: &'d mut Diags,
    header: bool,
    inches: bool,
    /// Digits before and behind the point of coordinates without one.
    digits: Option<(usize, usize)>,
    leading: bool,
    relative: bool,
    tool: u32,
    sizes: BTreeMap<u32, String>,
    at: [i64; 2],
    /// A route goes on: G00 or G01 has come, drilling not again.
    routing: bool,
    /// The tool is down on a route.
    down: bool,
    runs: Vec<Run>,
    holes: usize,
    ended: bool,
    last: u32,
}

impl<'d> Reader<'d> {
    fn new(diags: &'d mut Diags) -> Reader<'d> {
        Reader {
            diags,
            header: false,
            inches: false,
            digits: None,
            leading: true,
            relative: false,
            tool: 0,
            sizes: BTreeMap::new(),
            at: [0; 2],
            routing: false,
            down: false,
            runs: Vec::new(),
            holes: 0,
            ended: false,
            last: 1,
        }
    }

    fn error(&mut self, number: u32, col: u32, code: Code, text: String, hint: &str) {
        self.diags.push(Diag::new(code, number, col, text).hint(hint));
    }

    fn line(&mut self, number: u32, line: &str) {
        self.last = number;
        let text = line.trim();
        if let Some(remark) = text.strip_prefix(';') {
            // `;FORMAT={3:3/ absolute / metric / decimal}` is KiCad's.
            let lower = remark.to_ascii_lowercase();
            if let Some(format) = lower.strip_prefix("format={") {
                let mut digits = format.split(['/', '}']).next().unwrap_or("").split(':');
                let next =
                    |digits: &mut core::str::Split<'_, char>| digits.next()?.trim().parse().ok();
                self.digits = next(&mut digits).zip(next(&mut digits)).filter(|(a, b)| a + b <= 9);
            }
            return;
        }
        match text {
            "" => return,
            "M48" => {
                self.header = true;
                return;
            }
            "%" | "M95" => {
                self.header = false;
                return;
            }
            "M30" | "M00" => {
                self.ended = true;
                return;
            }
            "G05" | "G81" => {
                self.routing = false;
                self.down = false;
                return;
            }
            "FMAT,2" => return,
            "G90" | "ICI,OFF" => {
                self.relative = false;
                return;
            }
            "M15" => {
                self.down = true;
                return;
            }
            "M16" | "M17" => {
                self.down = false;
                return;
            }
            "M71" | "METRIC" => {
                self.inches = false;
                return;
            }
            "M72" | "INCH" => {
                self.inches = true;
                return;
            }
            "G91" | "ICI,ON" | "ICI" => {
                self.relative = true;
                return;
            }
            _ => {}
        }
        if text.starts_with("METRIC,") || text.starts_with("INCH,") {
            return self.units(number, text);
        }
        if let Some(rest) = text.strip_prefix('T') {
            return self.select(number, line, rest);
        }
        if text.starts_with(['X', 'Y']) {
            return self.hole(number, line, text);
        }
        if self.header {
            // VER, DETECT, ATC and the like set up another machine.
            let text = format!("`{text}` sets up another machine; it is left out");
            self.diags.push(Diag::new(Code::LeftOut, number, 1, text).note());
            return;
        }
        if let Some(rest) = text.strip_prefix("G00").or_else(|| text.strip_prefix("G01")) {
            return self.route(number, line, text.starts_with("G01"), rest.trim_start());
        }
        if let Some(rest) = text.strip_prefix('R') {
            return self.repeat(number, line, rest);
        }
        let (why, hint) = if text.starts_with("G02") || text.starts_with("G03") {
            ("an arc of a routed path", "let the board tool write G-code for it")
        } else {
            (
                "this is no drilling",
                "known are tools T, holes X Y, repeats R, slots G85, routes G00 G01 M15 M16, G05, \
                 G81, G90, M30",
            )
        };
        self.error(number, 1, Code::Unsupported, format!("`{text}`: {why}"), hint);
    }

    fn units(&mut self, number: u32, text: &str) {
        for part in text.split(',') {
            match part.trim() {
                "METRIC" => self.inches = false,
                "INCH" => self.inches = true,
                "LZ" => self.leading = true,
                "TZ" => self.leading = false,
                "" => {}
                digits if digits.bytes().all(|b| b == b'0' || b == b'.') => {
                    self.digits = digits.split_once('.').map(|(a, b)| (a.len(), b.len()));
                }
                other => {
                    let text = format!("`{other}` is no number format");
                    self.error(
                        number,
                        1,
                        Code::Unreadable,
                        text,
                        "known are LZ, TZ and digits such as 000.000",
                    );
                }
            }
        }
    }

    /// `T1C0.8` or `T1F200S65C0.8` in the header names a tool, `T1` in the body takes it.
    fn select(&mut self, number: u32, line: &str, rest: &str) {
        let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let Ok(tool) = rest[..digits].parse::<u32>() else {
            return self.error(
                number,
                column(line, rest),
                Code::Unreadable,
                format!("`T{rest}` is no tool"),
                "write `T1`",
            );
        };
        let size = rest[digits..].split_once('C').map(|(_, size)| size);
        if let Some(size) = size {
            let size = size.trim_end_matches(|c: char| !c.is_ascii_digit() && c != '.');
            self.sizes.insert(tool, format!("{size} {}", if self.inches { "in" } else { "mm" }));
        }
        if !self.header {
            self.tool = tool;
        }
    }

    /// A hole, or with G85 a slot.
    fn hole(&mut self, number: u32, line: &str, text: &str) {
        let (start, end) = match text.split_once("G85") {
            Some((start, end)) => (start, Some(end)),
            None => (text, None),
        };
        if !self.go(number, line, start) {
            return;
        }
        let from = self.at;
        if let Some(end) = end {
            if self.go(number, line, end) {
                self.add(number, true, from);
            }
        } else if !self.routing {
            self.add(number, false, from);
        } else if self.down {
            // A bare place on a route goes on with it; its start was the place before.
            self.error(
                number,
                1,
                Code::Unsupported,
                format!("`{text}`: a place on a route without G01"),
                "write G01 on each line of a route, G05 before holes",
            );
        }
    }

    /// G00 goes somewhere above the board, G01 with the tool down mills there.
    fn route(&mut self, number: u32, line: &str, mills: bool, text: &str) {
        self.routing = true;
        let from = self.at;
        if self.go(number, line, text) && mills && self.down {
            self.add(number, true, from);
        }
    }

    /// `R5X2.54Y0`: the last hole five times more.
    fn repeat(&mut self, number: u32, line: &str, rest: &str) {
        let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let times = rest[..digits].parse::<usize>().ok().filter(|times| *times <= MAX_HOLES);
        let drilled = matches!(self.runs.last(), Some(run) if !run.slots && run.tool == self.tool);
        let (Some(times), true) = (times, drilled) else {
            return self.error(
                number,
                1,
                Code::Unreadable,
                format!("`R{rest}` repeats no hole"),
                "write a hole, then `R5X2.54`: five more, each 2.54 further",
            );
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
                self.add(number, false, at);
            }
        }
        self.relative = absolute;
    }

    /// Goes to the place that X and Y words name; `false` when they are wrong, which was said.
    fn go(&mut self, number: u32, line: &str, text: &str) -> bool {
        let word = pair(satisfy(|c| c == 'X' || c == 'Y'), decimal);
        let list: Parsed<'_, Vec<(char, &str)>> = many1(word).parse(text);
        let Ok((rest, words)) = list else {
            self.error(
                number,
                column(line, text),
                Code::Unreadable,
                format!("`{text}` is no place"),
                "write `X1.5Y2.5`",
            );
            return false;
        };
        if !rest.trim().is_empty() {
            let col = column(line, rest);
            self.error(
                number,
                col,
                Code::Unreadable,
                format!("`{}` does not belong here", rest.trim()),
                "a hole has X and Y",
            );
            return false;
        }
        let mut seen = [false; 2];
        for (letter, value) in words {
            let index = usize::from(letter == 'Y');
            let base = if self.relative { self.at[index] } else { 0 };
            let um = self.coordinate(value).map(|um| base + um).filter(|um| um.abs() <= MAX_UM);
            let (Some(um), false) = (um, core::mem::replace(&mut seen[index], true)) else {
                self.error(
                    number,
                    1,
                    Code::OutOfRange,
                    format!("`{letter}{value}` is out of range"),
                    "one X and one Y within 10 m",
                );
                return false;
            };
            self.at[index] = um;
        }
        true
    }

    /// Adds the hole at `from`, or the slot from there to the present place.
    fn add(&mut self, number: u32, slots: bool, from: [i64; 2]) {
        if self.holes >= MAX_HOLES {
            self.ended = true;
            return self.error(
                number,
                1,
                Code::TooLong,
                format!("more than {MAX_HOLES} holes"),
                "cut the file in pieces",
            );
        }
        self.holes += 1;
        let place = [from, self.at];
        match self.runs.last_mut() {
            Some(run) if run.tool == self.tool && run.slots == slots => run.places.push(place),
            _ => self.runs.push(Run { tool: self.tool, slots, places: vec![place] }),
        }
    }

    /// A coordinate in um.
    fn coordinate(&self, text: &str) -> Option<i64> {
        let unit = if self.inches { 25_400 } else { 1000 };
        if text.contains('.') {
            return Some(Decimal::parse(text)?.scaled(unit, 1)?.0);
        }
        let (whole, fraction) = self.digits.unwrap_or(if self.inches { (2, 4) } else { (3, 3) });
        let signs: Parsed<'_, &str> =
            recognize((opt(one_of("+-")), take_while(|_| false))).parse(text);
        let (digits, sign) = signs.ok()?;
        let mut digits = digits.to_owned();
        if self.leading {
            // Trailing zeros were left out.
            while digits.len() < whole + fraction {
                digits.push('0');
            }
        } else {
            while digits.len() <= fraction {
                digits.insert(0, '0');
            }
        }
        let point = if self.leading { whole } else { digits.len().checked_sub(fraction)? };
        let (whole, fraction) = digits.split_at_checked(point)?;
        Some(Decimal::parse(&format!("{sign}{whole}.{fraction}"))?.scaled(unit, 1)?.0)
    }

    fn finish(self) -> (Vec<Run>, BTreeMap<u32, String>) {
        if self.runs.is_empty() && !self.diags.has_errors() {
            self.diags.push(Diag::new(Code::NoProgram, 1, 1, "the file has no hole"));
        } else if !self.ended {
            let diag = Diag::new(Code::NoProgram, self.last, 1, "the file does not end in M30");
            self.diags.push(diag.warning().hint("it may be cut"));
        }
        (self.runs, self.sizes)
    }
}

fn write(job: &Job<'_>, runs: &[Run], sizes: &BTreeMap<u32, String>, diags: &mut Diags) -> Made {
    let mut script = Script::new(job.name, "a drill file", job.profile);
    script.remark("Set the work zero on the board's surface; these say how deep and how fast:");
    // Where Z counts downward, deeper is more.
    let down =
        if job.profile.z.as_ref().is_some_and(|z| z.max_um > 0 && z.min_um >= 0) { 1 } else { -1 };
    script.line(&format!("CONST DEPTH = {}, SAFE = {}", mm(2000 * down), mm(-2000 * down)));
    script.line("CONST PLUNGE = 120mm/min");
    if runs.iter().any(|run| run.slots) {
        script.line("CONST MILL = 120mm/min");
    }
    let text = "a drill file says nothing of depth and speed: they are the script's CONST lines";
    diags.push(Diag::new(Code::Said, 1, 1, text).note());
    script.line("DIM i");
    let alone = |slots: bool| runs.iter().filter(|run| run.slots == slots).count() == 1;
    let name = |index: usize| {
        let word = if runs[index].slots { "slots" } else { "holes" };
        if alone(runs[index].slots) { word.to_owned() } else { format!("{word}_{}", index + 1) }
    };
    for (index, run) in runs.iter().enumerate() {
        let ends = if run.slots { 2 } else { 1 };
        let cell = |place: &[[i64; 2]; 2]| {
            place[..ends].iter().flatten().map(|um| mm(*um)).collect::<Vec<_>>().join(", ")
        };
        let rows: Vec<String> = run
            .places
            .chunks(ROWS_A_LINE / ends)
            .map(|chunk| chunk.iter().map(cell).collect::<Vec<_>>().join("; "))
            .collect();
        let columns = 2 * ends;
        let text = format!("TABLE {}({columns}) = {}", name(index), rows.join("; _\n  "));
        text.lines().for_each(|line| script.line(line));
    }
    script.gap();
    if down < 0 {
        script.line("G0 Z[SAFE]");
    } else {
        script.line("MoveAxe Z, SAFE");
    }
    for (index, run) in runs.iter().enumerate() {
        let size = sizes.get(&run.tool).map_or(String::new(), |size| format!(", {size}"));
        let what = match (run.slots, run.places.len()) {
            (false, 1) => "hole",
            (false, _) => "holes",
            (true, 1) => "slot",
            (true, _) => "slots",
        };
        script.remark(&format!("Tool {}{size}: {} {what}", run.tool, run.places.len()));
        // The first tool is in the spindle when Start is pressed.
        match index.checked_sub(1).map(|before| runs[before].tool) {
            None => script.line(&format!("T{}", run.tool)),
            Some(before) if before != run.tool => script.line(&format!("M6 T{}", run.tool)),
            Some(_) => {}
        }
        let other = |index: usize| runs.get(index).is_none_or(|other| other.tool != run.tool);
        if index.checked_sub(1).is_none_or(other) {
            script.line("M3");
        }
        script.open(&format!("FOR i = 0 TO COUNT({}) - 1", name(index)));
        let place = |first: usize| {
            let name = name(index);
            format!("X[{name}(i, {first})] Y[{name}(i, {})]", first + 1)
        };
        script.line(&format!("G0 {}", place(0)));
        script.line("G1 Z[DEPTH] F[PLUNGE]");
        if run.slots {
            script.line(&format!("G1 {} F[MILL]", place(2)));
        }
        script.line("G0 Z[SAFE]");
        script.close("NEXT");
        if other(index + 1) {
            script.line("M5");
        }
    }
    script.finish()
}
