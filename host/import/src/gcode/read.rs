//! From lines to blocks that the language takes, in the state that a controller would be in.

use super::rules::{self, Fate};
use super::words::{Piece, Word, pieces};
use crate::codes::Code;
use crate::diag::{Diag, Diags};
use crate::line::column;
use crate::{Format, Job};
use lang::axis::Axis;
use lang::front::literal::Decimal;
use lang::profile::OutputRole;
use lang::record::FULL_POWER;

/// Longest dwell that is not doubted, s.
const LONG_DWELL: i64 = 60;

/// A block of the script.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Block<'a> {
    /// Line of the source.
    pub line: u32,
    /// Words in the source's order.
    pub words: Vec<(char, Value<'a>)>,
    /// Text of a remark.
    pub remark: String,
    /// Text for PRINT before it.
    pub message: Option<String>,
    /// A statement that is no G-code; there are no words then.
    pub statement: &'static str,
    /// The motion mode in which its axis words stand.
    pub motion: i64,
    /// Where X and Y go, um, as far as it is known; under G91 it is not told.
    pub to: [Option<i64>; 2],
}

/// A word's number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Value<'a> {
    /// As it stood.
    Text(&'a str),
    /// Made by the importer.
    Whole(i64),
}

impl core::fmt::Display for Value<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Value::Text(text) = self else {
            let Value::Whole(value) = self else { return Ok(()) };
            return value.fmt(f);
        };
        // `X.5` and `X5.` are what other controllers write for 0.5 and 5.
        let (sign, digits) = match text.strip_prefix(['-', '+']) {
            Some(digits) => (&text[..1], digits),
            None => ("", *text),
        };
        let digits = digits.trim_end_matches('.');
        let sign = if sign == "+" { "" } else { sign };
        write!(f, "{sign}{}{digits}", if digits.starts_with('.') { "0" } else { "" })
    }
}

/// The state of a controller, as far as it matters here.
struct State {
    inches: bool,
    relative: bool,
    /// The active G word of motion; 80 for none.
    motion: i64,
    /// An F came.
    feed: bool,
    /// The script has ended.
    ended: bool,
    /// X and Y, um.
    at: [Option<i64>; 2],
    /// M3 or M4 holds.
    armed: bool,
    /// The beam is on.
    beam: bool,
    /// The last S.
    power: i64,
    /// An S came.
    powered: bool,
}

/// Reads all lines.
pub(super) fn read<'a>(job: &'a Job<'a>, format: Format, diags: &mut Diags) -> Vec<Block<'a>> {
    let lines = job.lines.numbered(diags);
    let laser = (format == Format::Laser).then(|| full_power(job, &lines));
    // Elsewhere S is a spindle's speed, which no output follows.
    let graded = !job.options.on_off && job.profile.output_with(OutputRole::Laser).is_some();
    let mut reader = Reader {
        job,
        laser,
        graded,
        diags,
        state: State {
            inches: false,
            relative: false,
            motion: 80,
            feed: job.profile.default_feed_um_s.is_some(),
            ended: false,
            // A laser begins at its picture's corner; elsewhere only what a word says is known.
            at: [laser.map(|_| 0); 2],
            armed: false,
            beam: false,
            power: 0,
            powered: false,
        },
        blocks: Vec::with_capacity(lines.len()),
    };
    for (number, line) in lines {
        reader.line(number, line);
        if reader.diags.hopeless() {
            break;
        }
    }
    if let Some(full) = laser {
        let beam = match graded {
            true => "S0 is dark",
            false => "M3 and M5 follow it: the beam is on or off",
        };
        let text =
            format!("full power is taken to be S{full}; the script's is S{FULL_POWER}, and {beam}");
        reader
            .diags
            .push(Diag::new(Code::Said, 1, 1, text).note().hint("`--s-max` says otherwise"));
    }
    reader.blocks
}

/// The S of full power: as asked for, else the least of 100, 255 and 1000 that no S exceeds.
fn full_power(job: &Job<'_>, lines: &[(u32, &str)]) -> i64 {
    if let Some(given) = job.options.s_max {
        return i64::from(given.max(1));
    }
    let most = lines.iter().filter_map(|(_, line)| {
        let code = line.split([';', '(']).next()?;
        let at = code.find(['S', 's'])?;
        let digits = code.get(at + 1..)?.trim_start();
        let end = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
        digits[..end].parse::<i64>().ok()
    });
    let most = most.max().unwrap_or(0);
    [100, 255, 1000].into_iter().find(|full| most <= *full).unwrap_or(most)
}

struct Reader<'a, 'd> {
    job: &'a Job<'a>,
    /// The S of full power, of laser files.
    laser: Option<i64>,
    /// S is the laser's power; otherwise M3 and M5 follow it.
    graded: bool,
    diags: &'d mut Diags,
    state: State,
    blocks: Vec<Block<'a>>,
}

impl<'a> Reader<'a, '_> {
    fn error(&mut self, number: u32, col: u32, code: Code, text: String, hint: &str) {
        let diag = Diag::new(code, number, col, text);
        self.diags.push(if hint.is_empty() { diag } else { diag.hint(hint) });
    }

    fn line(&mut self, number: u32, line: &'a str) {
        let trimmed = line.trim();
        if trimmed.is_empty() {
            return;
        }
        let mut block = Block { line: number, motion: self.state.motion, ..Block::default() };
        if self.state.ended {
            if trimmed != "%" {
                let text = "lines behind the program's end are left out";
                self.diags.once(Diag::new(Code::LeftOut, number, 1, text).warning());
            }
            return;
        }
        if trimmed.starts_with(['%', ':']) || is_program_number(trimmed) {
            block.remark = trimmed.trim_matches(['%', ':']).trim().to_owned();
            if !block.remark.is_empty() {
                self.blocks.push(block);
            }
            return;
        }
        if let Some(command) = trimmed.strip_prefix('$') {
            match command {
                "H" | "h" => block.statement = "Home",
                _ => {
                    let text =
                        format!("`{trimmed}` sets a controller of another kind; it is left out");
                    self.diags.push(Diag::new(Code::LeftOut, number, 1, text).warning());
                    return;
                }
            }
            self.blocks.push(block);
            return;
        }
        let Ok((rest, list)) = pieces(line) else { return };
        if !rest.is_empty() {
            return self.unreadable(number, line, rest);
        }
        let errors = self.diags.has_errors();
        for piece in list {
            match piece {
                Piece::Word(word) => self.word(&mut block, line, word),
                Piece::Remark(text) => remark(&mut block, text),
                Piece::Optional => {
                    let text = "`/` makes this line optional; it is executed";
                    self.diags.once(Diag::new(Code::Changed, number, 1, text).warning());
                }
                Piece::Checksum => {
                    let text = "checksums behind `*` are left out";
                    self.diags.once(Diag::new(Code::Said, number, 1, text).note());
                }
            }
        }
        if block.words.is_empty() {
            if block.message.is_some() || !block.remark.is_empty() {
                self.blocks.push(block);
            }
            return;
        }
        self.follow(&mut block, !errors && self.diags.has_errors());
        self.blocks.push(block);
    }

    fn unreadable(&mut self, number: u32, line: &str, rest: &str) {
        let col = column(line, rest);
        let first = rest.chars().next().unwrap_or(' ');
        let tail = rest.trim_start_matches(|c: char| c.is_ascii_alphabetic()).trim_start();
        let (what, hint) = if first == '#' || tail.starts_with('#') {
            (
                "parameters have no meaning here",
                "let the CAM tool write numbers, or declare variables in the script",
            )
        } else if line.trim_start().starts_with(['O', 'o']) {
            (
                "O-words have no meaning here",
                "unroll the program, or write SUB, IF and REPEAT in the script",
            )
        } else if tail.starts_with('[') {
            (
                "expressions have no meaning in a file",
                "let the CAM tool write numbers, or write them in the script",
            )
        } else if first.is_ascii_alphabetic() {
            ("a letter without its number", "a word is a letter directly followed by a number")
        } else {
            ("this cannot be read", "a block is made of words: a letter with its number")
        };
        let shown: String = rest.chars().take(12).collect();
        self.error(number, col, Code::Unreadable, format!("{what}: `{}`", shown.trim_end()), hint);
    }

    fn word(&mut self, block: &mut Block<'a>, line: &str, word: Word<'a>) {
        let Word { letter, number, tail } = word;
        let col = column(line, tail).saturating_sub(1);
        let Some(decimal) = Decimal::parse(number) else {
            let text = format!("`{letter}{number}` has too many digits");
            return self.error(block.line, col, Code::OutOfRange, text, "");
        };
        let fate = match letter {
            'G' => decimal.exact(10).map_or(rules::g(-1), rules::g),
            'M' => decimal.exact(1).map_or(rules::m(-1), rules::m),
            _ if rules::is_value(letter) => Fate::Keep,
            _ => rules::other(letter),
        };
        match fate {
            Fate::Keep => {}
            Fate::Idle(text) => {
                self.diags.once(Diag::new(Code::Said, block.line, col, text).note());
                return;
            }
            Fate::LeaveOut(text) => {
                self.diags.once(Diag::new(Code::LeftOut, block.line, col, text).warning());
                return;
            }
            Fate::As(other, text) => {
                self.diags.once(Diag::new(Code::Changed, block.line, col, text).note());
                block.words.push((letter, Value::Text(&other[1..])));
                return;
            }
            Fate::Refuse(reason, hint) => {
                let text = format!("`{letter}{number}`: {reason}");
                return self.error(block.line, col, Code::Unsupported, text, hint);
            }
        }
        let value = match letter {
            // G01 is G1.
            'G' | 'M' => Value::Text(plain(number)),
            'S' => match self.laser {
                Some(full) => {
                    let Some((value, _)) =
                        decimal.scaled(FULL_POWER as u32, u32::try_from(full).unwrap_or(u32::MAX))
                    else {
                        return self.error(
                            block.line,
                            col,
                            Code::OutOfRange,
                            format!("S{number} is out of range"),
                            "",
                        );
                    };
                    if !(0..=i64::from(FULL_POWER)).contains(&value) {
                        let text = format!("a power of S{number}; full power is S{full}");
                        return self.error(
                            block.line,
                            col,
                            Code::OutOfRange,
                            text,
                            "`--s-max` names full power",
                        );
                    }
                    Value::Whole(if decimal.sign() > 0 { value.max(1) } else { value })
                }
                None => match decimal.scaled(1, 1) {
                    Some((value, true)) => Value::Whole(value),
                    Some((value, false)) => {
                        let text = "S is a whole number here: decimals are rounded";
                        self.diags.once(Diag::new(Code::Changed, block.line, col, text).note());
                        Value::Whole(value)
                    }
                    None => {
                        return self.error(
                            block.line,
                            col,
                            Code::OutOfRange,
                            format!("S{number} is out of range"),
                            "",
                        );
                    }
                },
            },
            'T' => match decimal.exact(1) {
                Some(value) => Value::Whole(value),
                None => {
                    return self.error(
                        block.line,
                        col,
                        Code::OutOfRange,
                        format!("T{number} is no tool"),
                        "tools have whole numbers",
                    );
                }
            },
            'X' | 'Y' | 'Z' => {
                let axis = Axis::from_letter(letter).unwrap_or(Axis::X);
                if self.job.profile.axis(axis).is_none() {
                    let text =
                        format!("the machine `{}` has no axis {letter}", self.job.profile.name);
                    return self.error(
                        block.line,
                        col,
                        Code::WrongAxis,
                        text,
                        "choose another with `--profile`",
                    );
                }
                Value::Text(number)
            }
            _ => Value::Text(number),
        };
        if !matches!(letter, 'G' | 'M') && block.words.iter().any(|(known, _)| *known == letter) {
            let text = format!("a second {letter} in one block");
            return self.error(
                block.line,
                col,
                Code::Unreadable,
                text,
                "the line may be cut, or two lines run together",
            );
        }
        block.words.push((letter, value));
    }

    /// Follows the block in the controller's state; `broken` when a word of it was refused.
    fn follow(&mut self, block: &mut Block<'a>, broken: bool) {
        let words = core::mem::take(&mut block.words);
        let has = |letter: char| words.iter().any(|(known, _)| *known == letter);
        let number = |letter: char, text: &str| {
            words.iter().any(|(known, value)| *known == letter && *value == Value::Text(text))
        };
        let state = &mut self.state;
        state.feed |= has('F');
        let mut special = false;
        for (_, value) in words.iter().filter(|(letter, _)| *letter == 'G') {
            match value {
                Value::Text("20") => state.inches = true,
                Value::Text("21") => state.inches = false,
                Value::Text("90") => state.relative = false,
                Value::Text("91") => state.relative = true,
                Value::Text("28" | "92" | "38.2" | "38.3" | "53") => special = true,
                Value::Text(mode @ ("0" | "1" | "2" | "3" | "80" | "81" | "82" | "83")) => {
                    state.motion = mode.parse().unwrap_or(80);
                }
                _ => {}
            }
        }
        block.motion = state.motion;
        let moves = ['X', 'Y', 'Z'].into_iter().any(has);
        if moves && !special && state.motion == 80 && !broken {
            let text = "axis words before any of G0, G1, G2 and G3".to_owned();
            self.error(block.line, 1, Code::Unreadable, text, "write the motion word");
        } else if moves && matches!(state.motion, 1..=3) && !state.feed && !broken {
            self.state.feed = true;
            let text = "a feed move before any F".to_owned();
            self.error(
                block.line,
                1,
                Code::Unreadable,
                text,
                "write F, or choose a profile with a default feed: `--profile thesis`",
            );
        }
        let dwell =
            number('G', "4").then(|| words.iter().find(|(letter, _)| *letter == 'P')).flatten();
        if let Some((_, Value::Text(text))) = dwell
            && Decimal::parse(text)
                .and_then(|p| p.scaled(1, 1))
                .is_some_and(|(s, _)| s > LONG_DWELL)
        {
            let text = format!("G4 P{text} waits for {text} s; some tools mean milliseconds");
            self.diags.once(Diag::new(Code::Inconsistent, block.line, 1, text).note());
        }
        // P behind G64 is a tolerance, which the profile sets here.
        let tolerance = number('G', "64") && has('P');
        if tolerance {
            let text = "P of G64: the corner tolerance is the profile's `corner_um`";
            self.diags.once(Diag::new(Code::LeftOut, block.line, 1, text).note());
        }
        for (i, axis) in ['X', 'Y'].into_iter().enumerate() {
            let word = words.iter().find(|(letter, _)| *letter == axis);
            self.track(block.line, i, word.map(|(_, value)| *value), special);
        }
        block.to = if self.state.relative { [None; 2] } else { self.state.at };
        self.state.ended |= number('M', "2") || number('M', "30");
        block.words = words;
        block.words.retain(|(letter, _)| !(tolerance && *letter == 'P'));
        if self.laser.is_some() {
            self.beam(block);
        }
    }

    /// Follows X or Y, and says where a laser's path leaves the machine.
    fn track(&mut self, line: u32, index: usize, value: Option<Value<'_>>, special: bool) {
        let Some(Value::Text(text)) = value else { return };
        let scale = if self.state.inches { 25_400 } else { 1000 };
        let um = Decimal::parse(text).and_then(|number| number.scaled(scale, 1)).map(|(um, _)| um);
        let Some(um) = um.filter(|um| um.abs() <= i64::from(i32::MAX)) else {
            let text = format!("{text} is too far away");
            return self.error(line, 1, Code::OutOfRange, text, "the greatest length is 2147 mm");
        };
        let before = self.state.at[index];
        let at = match self.state.relative {
            _ if special => None,
            true => before.and_then(|before| before.checked_add(um)),
            false => Some(um),
        };
        self.state.at[index] = at;
        let axis = if index == 0 { Axis::X } else { Axis::Y };
        let Some(part) = self.job.profile.axis(axis).filter(|_| self.laser.is_some()) else {
            return;
        };
        let travel = i64::from(part.min_um)..=i64::from(part.max_um);
        if let Some(at) = at.filter(|at| !travel.contains(at)) {
            let (letter, at) = (axis.letter(), crate::script::mm(at));
            let text =
                format!("{letter} goes to {at}, outside the travel of `{}`", self.job.profile.name);
            let hint = format!(
                "the travel is {} to {}",
                crate::script::mm(*travel.start()),
                crate::script::mm(*travel.end())
            );
            self.error(line, 1, Code::OutOfRange, text, &hint);
        }
    }

    /// A laser without power is off: where S is not its power M3 and M5 follow S.
    fn beam(&mut self, block: &mut Block<'a>) {
        if self.graded {
            // Before any S a laser has no power, where a script's laser has all of it.
            let starts = block
                .words
                .iter()
                .any(|(letter, value)| *letter == 'M' && matches!(value, Value::Text("3" | "4")));
            self.state.powered |= block.words.iter().any(|(letter, _)| *letter == 'S');
            if starts && !core::mem::replace(&mut self.state.powered, true) {
                block.words.push(('S', Value::Whole(0)));
            }
            return;
        }
        for (letter, value) in &block.words {
            match (letter, value) {
                ('M', Value::Text("3" | "4")) => self.state.armed = true,
                ('M', Value::Text("5" | "2" | "30")) => self.state.armed = false,
                ('S', Value::Whole(power)) => self.state.power = *power,
                _ => {}
            }
        }
        let asked = block
            .words
            .iter()
            .any(|(letter, value)| *letter == 'M' && matches!(value, Value::Text("3" | "4" | "5")));
        block.words.retain(|(letter, value)| {
            *letter != 'M' || !matches!(value, Value::Text("3" | "4" | "5"))
        });
        let on = self.state.armed && self.state.power > 0;
        if on != self.state.beam || (asked && !self.state.armed) {
            block.words.insert(0, ('M', Value::Text(if on { "3" } else { "5" })));
        }
        self.state.beam = on;
    }
}

/// A remark, or a message that the controller shows.
fn remark(block: &mut Block<'_>, text: &str) {
    let text = text.trim();
    let message = text.get(..3).filter(|word| word.eq_ignore_ascii_case("MSG"));
    if let Some(message) = message.and_then(|_| text.get(3..)) {
        block.message = Some(message.trim_start_matches([',', ' ']).to_owned());
        return;
    }
    if !block.remark.is_empty() && !text.is_empty() {
        block.remark.push_str("; ");
    }
    block.remark.push_str(text);
}

/// `01` as `1`, `1.` as `1`, `38.20` as `38.2`.
fn plain(number: &str) -> &str {
    let number = number.trim_start_matches('+');
    let number = if number.contains('.') {
        number.trim_end_matches('0').trim_end_matches('.')
    } else {
        number
    };
    let short = number.trim_start_matches('0');
    if short.is_empty() || short.starts_with('.') { "0" } else { short }
}

/// `O1001` and a remark: a program's name, no O-word.
fn is_program_number(line: &str) -> bool {
    let Some(rest) = line.strip_prefix(['O', 'o']) else { return false };
    let tail = rest.trim_start_matches(|c: char| c.is_ascii_digit());
    tail.len() < rest.len() && (tail.trim().is_empty() || tail.trim_start().starts_with('('))
}
