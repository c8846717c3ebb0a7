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

/// The motion mode after a refused word of its group. Axis words behind it are not reported again.
pub(super) const REFUSED: i64 = -1;

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
    /// It named axes that are not there.
    pub others: bool,
    /// The motion mode in which its axis words stand.
    pub motion: i64,
    /// Where X and Y go, um, as far as it is known; under G91 it is not told.
    pub to: [Option<i64>; 2],
    /// Named parameters that it sets behind its motion, and the values.
    pub sets: Vec<(u16, String)>,
}

/// A word's number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Value<'a> {
    /// As it stood.
    Text(&'a str),
    /// Made by the importer.
    Whole(i64),
    /// A parameter that keeps a name ([`super::named`]).
    Named { index: u16, minus: bool },
}

impl core::fmt::Display for Value<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let text = match self {
            Value::Text(text) => *text,
            Value::Whole(value) => return value.fmt(f),
            Value::Named { index, minus } => {
                return write!(f, "{}#{index}", if *minus { "-" } else { "" });
            }
        };
        // `X.5` and `X5.` are what other controllers write for 0.5 and 5.
        let (sign, digits) = match text.strip_prefix(['-', '+']) {
            Some(digits) => (&text[..1], digits),
            None => ("", text),
        };
        let digits = digits.trim_end_matches('.');
        let sign = if sign == "+" { "" } else { sign };
        write!(f, "{sign}{}{digits}", if digits.starts_with('.') { "0" } else { "" })
    }
}

/// The state of a controller, as far as it matters here.
pub(super) struct State {
    pub inches: bool,
    pub relative: bool,
    /// The axes of circles, first and second.
    pub plane: [usize; 2],
    /// The active G word of motion; 80 for none, [`REFUSED`] after one that was refused.
    pub motion: i64,
    /// The G word of motion that was active before the last canned cycle; 80 for none.
    pub before_cycle: i64,
    /// An F came.
    pub feed: bool,
    /// The script has ended.
    pub ended: bool,
    /// X, Y and Z, um.
    pub at: [Option<i64>; 3],
    /// The G word of arcs that holds where the script has G1 instead.
    pub lined: Option<&'static str>,
    /// M3 or M4 holds.
    pub armed: bool,
    /// The beam is on.
    pub beam: bool,
    /// The last S.
    pub power: i64,
    /// An S came.
    pub powered: bool,
}

/// Reads all lines.
pub(super) fn read<'a>(job: &'a Job<'a>, format: Format, diags: &mut Diags) -> Vec<Block<'a>> {
    let lines = job.lines.numbered(diags);
    let laser = (format == Format::Laser).then(|| full_power(job, &lines));
    // Elsewhere S is a spindle's speed, which no output follows.
    let graded = !job.options.on_off && job.profile.has_power();
    let mut reader = Reader {
        job,
        laser,
        graded,
        diags,
        state: State {
            inches: false,
            relative: false,
            plane: [0, 1],
            motion: 80,
            before_cycle: 80,
            feed: job.profile.default_feed_um_s.is_some(),
            ended: false,
            // A laser begins at its picture's corner; elsewhere only what a word says is known.
            at: [laser.map(|_| 0), laser.map(|_| 0), None],
            lined: None,
            armed: false,
            beam: false,
            power: 0,
            powered: false,
        },
        reach: [Reach::default(); 3],
        blocks: Vec::with_capacity(lines.len()),
    };
    for (number, line) in lines {
        reader.line(number, line);
        if reader.diags.hopeless() {
            break;
        }
    }
    reader.placed();
    if let Some(full) = laser {
        let own = job.profile.full_power();
        let beam = match graded {
            true => "S0 is dark",
            false => "M3 and M5 follow it: the beam is on or off",
        };
        let text = format!("full power is taken to be S{full}; the script's is S{own}, and {beam}");
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

pub(super) struct Reader<'a, 'd> {
    pub(super) job: &'a Job<'a>,
    /// The S of full power, of laser files.
    pub(super) laser: Option<i64>,
    /// S is the laser's power; otherwise M3 and M5 follow it.
    pub(super) graded: bool,
    pub(super) diags: &'d mut Diags,
    pub(super) state: State,
    /// How far a laser's picture reaches.
    pub(super) reach: [Reach; 3],
    blocks: Vec<Block<'a>>,
}

/// How far a laser's picture reaches along an axis.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reach {
    /// The least and the greatest place, um.
    pub range: Option<[i64; 2]>,
    /// It is larger than the table; that was written.
    pub refused: bool,
}

impl<'a> Reader<'a, '_> {
    pub(super) fn error(&mut self, number: u32, col: u32, code: Code, text: String, hint: &str) {
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
        // Without an axis these mean all of them.
        let all = |(letter, value): &(char, Value<'_>)| {
            *letter == 'G' && matches!(value, Value::Text("28" | "92"))
        };
        let named = block.words.iter().any(|(letter, _)| matches!(letter, 'X' | 'Y' | 'Z'));
        if block.others && !named && block.words.iter().any(all) {
            let text = "this block is about axes that are not there".to_owned();
            self.error(number, 1, Code::WrongAxis, text, "the axes are X, Y and Z");
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
                "parameters take numbers, `+ - * /` and brackets here",
                "let the CAM tool write numbers, or declare variables in the script",
            )
        } else if line.trim_start().starts_with(['O', 'o']) {
            (
                "O-words have no meaning here",
                "unroll the program, or write SUB, IF and REPEAT in the script",
            )
        } else if tail.starts_with('[') {
            (
                "expressions take numbers, parameters, `+ - * /` and brackets here",
                "let the CAM tool write numbers, or write them in the script",
            )
        } else if rest.starts_with(',') && rest[1..].starts_with(|c: char| c.is_ascii_digit()) {
            ("a comma in a number", "decimals stand behind a point")
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
        let tenths = decimal.exact(10);
        let coolant = matches!(decimal.exact(1), Some(7..=9));
        let fate = match letter {
            'M' if coolant && self.job.profile.output_with(OutputRole::Coolant).is_none() => {
                rules::NO_COOLANT
            }
            'G' => tenths.map_or(rules::g(-1), rules::g),
            'M' => decimal.exact(1).map_or(rules::m(-1), rules::m),
            _ if rules::is_value(letter) => Fate::Keep,
            _ if rules::is_other_axis(letter) && decimal.sign() == 0 => {
                block.others = true;
                Fate::Idle("an axis that is not there stands at 0 and stays there")
            }
            _ => rules::other(letter),
        };
        if letter == 'M' && matches!(decimal.exact(1), Some(62..=65)) {
            let text = "M62 to M65: P is the number of an output of this machine, counted from 1";
            self.diags.once(Diag::new(Code::Said, block.line, col, text).note());
        }
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
                if letter == 'G' && tenths.is_some_and(rules::is_motion) {
                    self.state.motion = REFUSED;
                }
                let text = format!("`{letter}{number}`: {reason}");
                return self.error(block.line, col, Code::Unsupported, text, hint);
            }
        }
        let value = match letter {
            // G01 is G1.
            'G' | 'M' => Value::Text(plain(number)),
            'S' => match self.laser {
                Some(full) => {
                    let own = self.job.profile.full_power().unsigned_abs();
                    let Some((value, _)) =
                        decimal.scaled(own, u32::try_from(full).unwrap_or(u32::MAX))
                    else {
                        return self.error(
                            block.line,
                            col,
                            Code::OutOfRange,
                            format!("S{number} is out of range"),
                            "",
                        );
                    };
                    if !(0..=i64::from(own)).contains(&value) {
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
                let lacks = self.job.profile.axis(axis).is_none();
                if lacks && axis == Axis::Z && self.laser.is_some() {
                    let text = format!(
                        "Z moves a laser's focus, and `{}` has no axis Z: its words are left out",
                        self.job.profile.name
                    );
                    self.diags.once(Diag::new(Code::LeftOut, block.line, col, text).warning());
                    return;
                }
                if lacks {
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
