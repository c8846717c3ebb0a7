//! NCP programs (`IMF_PBL`), which isel's controllers and Remote run and which FreeCAD, FlatCAM,
//! VCarve, gerbv and Fusion write.
//!
//! Each line is a command with its words: `FASTABS X1000 Y2000`, `VEL 5000`. Lengths are um, speeds
//! um/s, times ms; Z counts upward. A line becomes one line of G-code, which [`crate::gcode`] reads
//! on, so that diagnostics and line numbers stay those of the file.
//!
//! The posts disagree in two places, where nothing is guessed: the sense of an arc outside the plane
//! XY, and whether DRILLDEF counts in um or mm.

mod drill;
mod words;

use std::fmt::Write;

use lang::axis::Axis;

use super::codes::Code;
use super::diag::{Diag, Diags};
use super::text::Lines;
use drill::Cycle;
use words::{Command, Words};

/// Whether a text is such a program: its first line says so, behind a line number.
pub(crate) fn is_one<'a>(mut lines: impl Iterator<Item = &'a str>) -> bool {
    let mut head = || lines.find(|line| !line.starts_with(';')).map(words::without_number);
    head().is_some_and(|line| {
        line.get(..7).is_some_and(|start| start.eq_ignore_ascii_case("IMF_PBL"))
    })
}

/// The program as G-code, line by line.
pub(crate) fn translated(lines: &Lines, diags: &mut Diags) -> Lines {
    let mut reader = Reader {
        diags,
        line: 1,
        at: [None; 3],
        relative: false,
        machine: false,
        plane: "XY".to_owned(),
        speed: None,
        fed: None,
        register: None,
        cycle: Cycle::default(),
        ended: false,
    };
    let mut out = String::with_capacity(lines.text().len());
    let mut at = 1;
    for (number, line) in lines.numbered(reader.diags) {
        while at < number {
            out.push('\n');
            at += 1;
        }
        reader.line = number;
        let (code, remark) = line.split_at(line.find(';').unwrap_or(line.len()));
        if let Some(block) = reader.command(code) {
            out.push_str(&block);
        }
        out.push_str(remark);
        if reader.diags.hopeless() {
            break;
        }
    }
    Lines::of(out)
}

struct Reader<'d> {
    diags: &'d mut Diags,
    /// The line that is being read.
    line: u32,
    /// Where the tool is, um, as far as it is known.
    at: [Option<i64>; 3],
    /// G91 holds in what was written.
    relative: bool,
    /// Places count from the machine's zero (WPCLEAR).
    machine: bool,
    /// As PLANE named it.
    plane: String,
    /// VEL, um/s.
    speed: Option<i64>,
    /// The speed that the last F said, um/s.
    fed: Option<i64>,
    /// The work zero's number (WPREG).
    register: Option<String>,
    cycle: Cycle,
    /// PROGEND came.
    ended: bool,
}

impl Reader<'_> {
    fn error(&mut self, code: Code, text: impl Into<String>, hint: &str) -> Option<String> {
        self.diags.push(Diag::new(code, self.line, 1, text).hint(hint));
        None
    }

    /// A line's G-code; nothing where it says nothing or was refused.
    fn command(&mut self, text: &str) -> Option<String> {
        let text = words::without_number(text.trim());
        if text.is_empty() || self.ended {
            return None;
        }
        let Command { name, rest } = Command::of(text);
        match name.as_str() {
            "PROGBEGIN" | "METRIC" => None,
            name if name.starts_with("IMF_PBL") => None,
            "PROGEND" => {
                self.ended = true;
                Some("M30".to_owned())
            }
            "TYPE" => Some(format!("(MSG,{})", rest.trim().replace(['(', ')'], " "))),
            "PLANE" => self.plane(rest),
            "SPINDLE" => self.spindle(rest),
            "COOLANT" | "COOLANT2" => self.coolant(&name, rest),
            "WPCLEAR" => {
                self.machine = true;
                self.at = [None; 3];
                None
            }
            "WPZERO" => self.zero("STANDARD"),
            name if name.starts_with("WPREG") => self.zero(name),
            "PUMP" | "LAMP" | "WPCLAMP" | "POPTION1" | "POPTION2" => {
                let text = format!(
                    "{name} switches an output of isel's controller; it is left out: write SetOut where it is wired"
                );
                self.diags.once(Diag::new(Code::LeftOut, self.line, 1, text).warning());
                None
            }
            "HALT" | "STOP" => Some("M0".to_owned()),
            "INCH" => self.error(
                Code::Unsupported,
                "INCH: lengths of these programs are um",
                "let the CAM tool write METRIC",
            ),
            "REF" => match rest.trim().to_ascii_uppercase().as_str() {
                "XYZ" | "ZXY" | "ZYX" => {
                    self.at = [None; 3];
                    Some("$H".to_owned())
                }
                _ => self.error(
                    Code::Unsupported,
                    format!("`{text}` references some of the axes"),
                    "write `REF XYZ`, or Home in the script",
                ),
            },
            _ => self.with_words(&name, rest),
        }
    }

    /// A command whose words are letters with numbers.
    fn with_words(&mut self, name: &str, rest: &str) -> Option<String> {
        let words = match Words::of(rest) {
            Ok(words) => words,
            Err(wrong) => {
                let text = format!("`{wrong}` is no word of {name}");
                return self.error(Code::Unreadable, text, "a word is a letter and a whole number");
            }
        };
        match name {
            "FASTABS" | "MOVEABS" | "FASTREL" | "MOVEREL" => self.straight(name, &words),
            "CWABS" | "CCWABS" | "CWREL" | "CCWREL" => self.arc(name, &words),
            "VEL" => self.velocity(&words),
            "FASTVEL" => {
                let text = "FASTVEL: rapid moves have the speeds of the profile";
                self.diags.once(Diag::new(Code::LeftOut, self.line, 1, text).note());
                None
            }
            "WAIT" => match words.plain() {
                Some(ms) if ms >= 0 => Some(format!("G4 P{}", thousandths(ms))),
                _ => self.error(Code::WrongCount, "WAIT without a time", "`WAIT 500` waits 500 ms"),
            },
            "GETTOOL" => match words.plain() {
                Some(tool) if tool >= 0 => Some(format!("M6 T{tool}")),
                _ => self.error(Code::WrongCount, "GETTOOL without a number", "`GETTOOL 1`"),
            },
            "DRILLDEF" => {
                self.cycle.define(&words);
                None
            }
            "DRILL" => self.drill(&words),
            "SETPORT" | "SETBIT" => self.error(
                Code::Unsupported,
                format!("{name} switches outputs of isel's controller"),
                "write `SetOut n, ON` or OFF in the script",
            ),
            "CWHLXABS" | "CCWHLXABS" => self.error(
                Code::Unsupported,
                "a helix of several turns",
                "let the CAM tool write lines, or arcs of one turn at most",
            ),
            _ => self.error(
                Code::Unreadable,
                format!("`{name}` is no command that is known here"),
                "known are FASTABS MOVEABS FASTREL MOVEREL CWABS CCWABS VEL FASTVEL PLANE DRILLDEF \
                 DRILL SPINDLE COOLANT GETTOOL WAIT TYPE HALT REF WPCLEAR WPZERO WPREG PROGEND",
            ),
        }
    }

    fn velocity(&mut self, words: &Words) -> Option<String> {
        match words.plain() {
            Some(speed) if speed > 0 => {
                self.speed = Some(speed);
                None
            }
            _ => self.error(Code::WrongCount, "VEL without a speed", "`VEL 5000` is 5 mm/s"),
        }
    }

    /// G90 or G91, where the other holds.
    fn mode(&mut self, relative: bool) -> &'static str {
        match (std::mem::replace(&mut self.relative, relative) != relative, relative) {
            (false, _) => "",
            (true, true) => "G91 ",
            (true, false) => "G90 ",
        }
    }

    /// The F word, where the last one says something else.
    fn feed(&mut self) -> String {
        match self.speed {
            Some(speed) if self.fed.replace(speed) != Some(speed) => {
                format!(" F{}", per_minute(speed))
            }
            _ => String::new(),
        }
    }

    /// The tool's new place.
    fn go(&mut self, axis: Axis, um: i64, relative: bool) {
        let at = &mut self.at[axis.index()];
        *at = if relative { at.and_then(|at| at.checked_add(um)) } else { Some(um) };
    }

    fn straight(&mut self, name: &str, words: &Words) -> Option<String> {
        let (relative, rapid) = (name.ends_with("REL"), name.starts_with("FAST"));
        if self.machine && (relative || !rapid) {
            let text = format!("{name} counts from the machine's zero after WPCLEAR");
            return self.error(Code::Unsupported, text, "FASTABS is the only move that does");
        }
        let mut block = format!(
            "{}{}G{}",
            self.mode(relative),
            if self.machine { "G53 " } else { "" },
            if rapid { 0 } else { 1 }
        );
        for (letter, um) in &words.list {
            match Axis::from_letter(*letter) {
                Some(_) if self.machine => {}
                Some(axis) => self.go(axis, *um, relative),
                None => {}
            }
            let _ = write!(block, " {letter}{}", thousandths(*um));
        }
        if words.list.is_empty() {
            let text = format!("{name} without a place");
            return self.error(Code::WrongCount, text, "write X, Y or Z behind it");
        }
        if !rapid {
            block += &self.feed();
        }
        Some(block)
    }

    /// An arc: of CWABS and CCWABS the centre is a place, of the others it counts from the start.
    fn arc(&mut self, name: &str, words: &Words) -> Option<String> {
        if self.plane != "XY" || self.machine {
            return self.error(
                Code::Unsupported,
                format!("{name} outside the plane XY of the work"),
                "the tools that write these programs disagree on its sense: let the CAM tool write lines",
            );
        }
        let (Some(i), Some(j)) = (words.get('I'), words.get('J')) else {
            let text = format!("{name} without its centre");
            return self.error(Code::WrongCount, text, "I and J both belong to an arc");
        };
        let relative = name.ends_with("REL");
        let center = match (relative, self.at) {
            (true, _) => [i, j],
            (false, [Some(x), Some(y), _]) => [i.saturating_sub(x), j.saturating_sub(y)],
            _ => {
                let text = format!("where {name} begins is not known");
                return self.error(
                    Code::Inconsistent,
                    text,
                    "write FASTABS with X and Y before it",
                );
            }
        };
        let mut block =
            format!("{}G{}", self.mode(relative), if name.starts_with("CCW") { 3 } else { 2 });
        for (letter, um) in &words.list {
            if let Some(axis) = Axis::from_letter(*letter) {
                self.go(axis, *um, relative);
                let _ = write!(block, " {letter}{}", thousandths(*um));
            } else if !matches!(letter, 'I' | 'J') {
                let text = format!("`{letter}` is no word of {name}");
                return self.error(Code::Unsupported, text, "known are X, Y, Z, I and J");
            }
        }
        let _ = write!(block, " I{} J{}", thousandths(center[0]), thousandths(center[1]));
        block += &self.feed();
        Some(block)
    }

    fn plane(&mut self, rest: &str) -> Option<String> {
        self.plane = rest.trim().to_ascii_uppercase();
        match self.plane.as_str() {
            "XY" => Some("G17".to_owned()),
            "XZ" | "ZX" | "YZ" | "ZY" => None,
            _ => {
                let text = format!("`PLANE {}` is no plane", rest.trim());
                self.error(Code::Unreadable, text, "known are XY, XZ and YZ")
            }
        }
    }

    /// The work zero counts again; there is one only.
    fn zero(&mut self, name: &str) -> Option<String> {
        (self.machine, self.at) = (false, [None; 3]);
        let first = self.register.get_or_insert_with(|| name.to_owned());
        if first != name {
            let text = format!("a second work zero, {name} after {first}");
            return self.error(
                Code::Unsupported,
                text,
                "there is one: let the CAM tool use one setup",
            );
        }
        let text = "the work zero is where the board has it; SetPos sets it";
        self.diags.once(Diag::new(Code::Said, self.line, 1, text).note());
        None
    }

    /// `SPINDLE CW RPM12000 TIME2000`, in any order.
    fn spindle(&mut self, rest: &str) -> Option<String> {
        let mut block = String::new();
        let mut wait = None;
        for (word, number) in words::named(rest) {
            match (word.as_str(), number) {
                ("ON" | "CW", None) => block.insert_str(0, "M3"),
                ("CCW", None) => block.insert_str(0, "M4"),
                ("OFF", None) => block.insert_str(0, "M5"),
                ("RPM", Some(turns)) if turns >= 0 => {
                    let _ = write!(block, " S{turns}");
                }
                ("TIME", Some(ms)) if ms >= 0 => wait = Some(ms),
                _ => {
                    let text = format!("`{}` is no word of SPINDLE", rest.trim());
                    let hint = "known are ON, OFF, CW, CCW, RPM and TIME";
                    return self.error(Code::Unreadable, text, hint);
                }
            }
        }
        if let Some(ms) = wait {
            let _ = write!(block, " G4 P{}", thousandths(ms));
        }
        Some(block.trim().to_owned())
    }

    fn coolant(&mut self, name: &str, rest: &str) -> Option<String> {
        match rest.trim().to_ascii_uppercase().as_str() {
            "ON" => Some(if name == "COOLANT" { "M8" } else { "M7" }.to_owned()),
            "OFF" => Some("M9".to_owned()),
            other => {
                let text = format!("`{name} {other}` switches nothing");
                self.error(Code::Unreadable, text, "write ON or OFF")
            }
        }
    }
}

/// A number of thousandths as a decimal: um as mm, ms as s.
fn thousandths(n: i64) -> String {
    let (sign, n) = (if n < 0 { "-" } else { "" }, n.unsigned_abs());
    let decimals = format!("{:03}", n % 1000);
    match decimals.trim_end_matches('0') {
        "" => format!("{sign}{}", n / 1000),
        decimals => format!("{sign}{}.{decimals}", n / 1000),
    }
}

/// um/s as mm/min.
fn per_minute(um_s: i64) -> String {
    thousandths(um_s.saturating_mul(60))
}
