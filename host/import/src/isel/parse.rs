//! From the lines of a recorded text, or of a BASIC listing that prints them, to the list of
//! instructions in the order of execution.

use nom::Parser;
use nom::character::complete::satisfy;
use nom::sequence::preceded;

use super::answer::answer;
use super::instr::{Axes, Item, Op};
use super::listing::{self, Sent};
use crate::codes::Code;
use crate::diag::{Diag, Diags};
use crate::line::{Parsed, blanks, column};

/// Instructions of one script; a card with 32 KB holds about 1500.
const MAX_ITEMS: usize = 200_000;
/// Jumps and loops among them.
const MAX_JUMPS: usize = 2000;

/// What went wrong in an instruction: the character that the card answers, and why.
pub(super) struct Refused {
    pub(super) card: Option<char>,
    pub(super) code: Code,
    pub(super) text: String,
    pub(super) hint: Option<String>,
}

impl Refused {
    pub(super) fn new(card: char, code: Code, text: impl Into<String>) -> Refused {
        Refused { card: Some(card), code, text: text.into(), hint: None }
    }

    pub(super) fn hint(mut self, hint: impl Into<String>) -> Refused {
        self.hint = Some(hint.into());
        self
    }
}

pub(super) type Read<T> = Result<T, Refused>;

/// A list that is being read.
pub(super) struct Reader<'d> {
    pub(super) diags: &'d mut Diags,
    /// The card's number, as the first command names it.
    pub(super) device: Option<char>,
    pub(super) axes: Option<Axes>,
    /// In order of execution.
    pub(super) program: Vec<Item>,
    /// Between `i` and `9`.
    pub(super) storing: bool,
    pub(super) stored: Vec<Item>,
    pub(super) complete: bool,
    started: bool,
    /// The line that is being read.
    line: u32,
    col: u32,
}

/// Reads a text. With errors the list is of no use.
pub(crate) fn read(lines: &[(u32, &str)], diags: &mut Diags) -> Vec<Item> {
    let mut reader = Reader::new(diags);
    let is_listing = listing::is_one(lines);
    for &(number, line) in lines {
        reader.line = number;
        let code = match is_listing.then(|| listing::sent(line)) {
            None => line,
            Some(Sent::Text(text)) => text,
            Some(Sent::Nothing) => continue,
            Some(Sent::Unknown(reason)) => {
                let diag = Diag::new(Code::Unsupported, number, 1, reason);
                reader.diags.push(diag.hint("record what the program sends, and import that"));
                continue;
            }
        };
        reader.col = column(line, code);
        reader.read_line(line, code);
        if reader.diags.hopeless() {
            break;
        }
    }
    reader.finish()
}

impl<'d> Reader<'d> {
    /// Of a card that was just switched on.
    pub(super) fn new(diags: &'d mut Diags) -> Reader<'d> {
        Reader {
            diags,
            device: None,
            axes: None,
            program: Vec::new(),
            storing: false,
            stored: Vec::new(),
            complete: false,
            started: false,
            line: 1,
            col: 1,
        }
    }
}

impl Reader<'_> {
    fn read_line(&mut self, line: &str, code: &str) {
        let Ok((code, _)) = blanks(code) else { return };
        if code.is_empty() || code.starts_with([';', '\'', '(', '/', '{', '#']) {
            return;
        }
        self.col = column(line, code);
        let read = match code.strip_prefix('@') {
            Some(command) => self.direct(command, code),
            None if self.storing => self.store(code),
            None => Err(Refused::new(
                '5',
                Code::Unreadable,
                "this is neither an `@` command nor between `@0i` and `9`",
            )
            .hint("stored instructions follow `@0i`")),
        };
        if let Err(refused) = read {
            if self.storing && !code.starts_with('@') && self.stored.len() < MAX_ITEMS {
                // It counts for the jumps of the others.
                let text = code.to_owned();
                let op = Op::Delay(0);
                self.stored.push(Item { op, line: self.line, col: self.col, text });
            }
            let mut text = refused.text;
            if let Some(card) = refused.card {
                text += &answer(card);
            }
            let diag = Diag::new(refused.code, self.line, self.col, text);
            self.diags.push(match refused.hint {
                Some(hint) => diag.hint(hint),
                None => diag,
            });
        }
    }

    pub(super) fn warn(&mut self, code: Code, text: impl Into<String>) {
        self.diags.once(Diag::new(code, self.line, self.col, text).warning());
    }

    pub(super) fn note(&mut self, text: impl Into<String>) {
        self.diags.once(Diag::new(Code::Said, self.line, self.col, text).note());
    }

    /// What follows `@`.
    pub(super) fn direct(&mut self, command: &str, code: &str) -> Read<()> {
        let device: Parsed<'_, char> =
            preceded(blanks, satisfy(|c| c.is_ascii_digit())).parse(command);
        let Ok((rest, device)) = device else {
            return Err(Refused::new('5', Code::Unreadable, "`@` without the card's number")
                .hint("commands begin with `@0`"));
        };
        if *self.device.get_or_insert(device) != device {
            return Err(Refused {
                card: None,
                code: Code::Unsupported,
                hint: None,
                text: format!("this is for another card, number {device}"),
            }
            .hint("import the lines of each card by themselves"));
        }
        if self.storing {
            self.warn(
                Code::Inconsistent,
                "a command in the middle of stored instructions: `9` is missing before it",
            );
            self.end_storing()?;
        }
        let (rest, _) = blanks(rest).unwrap_or((rest, ""));
        let Some(letter) = rest.chars().next() else {
            self.warn(
                Code::Inconsistent,
                "`@0` alone stands for `@0i` in printed listings: instructions follow",
            );
            return self.begin_storing();
        };
        let values = &rest[letter.len_utf8()..];
        match letter {
            '0'..='9' => self.set_axes(rest),
            'i' => {
                self.end(values)?;
                self.begin_storing()
            }
            'A' | 'a' => self.movement(values, code, Op::Relative),
            'M' | 'm' => self.movement(values, code, Op::Absolute),
            'R' | 'r' => self.home(values, code),
            'n' => self.zero(values, code),
            'e' => self.plane(values, code),
            'Z' => self.solid(values, code),
            'F' | 'f' => self.sense(values, code),
            'Y' | 'y' => self.arc(values, code),
            'S' | 's' => {
                self.end(values)?;
                self.start()
            }
            't' => {
                self.note("`t` runs single steps; the script runs through");
                self.start()
            }
            'd' => {
                let rates = self.numbers(values)?;
                let text =
                    format!("the reference speed is the profile's (`fast_rate`), not {rates:?}");
                self.warn(Code::LeftOut, text);
                Ok(())
            }
            'B' => self.poke(values, code),
            'k' | 'K' => {
                self.stored.clear();
                self.complete = false;
                self.note("`k` clears the card's memory: there is none here");
                Ok(())
            }
            'G' => {
                let [device] = self.exactly(values)?;
                let named = u32::try_from(device).ok().and_then(|n| char::from_digit(n, 10));
                let Some(named) = named else {
                    return Err(Refused::new('5', Code::OutOfRange, format!("card {device}"))
                        .hint("cards are 0 to 9"));
                };
                self.device = Some(named);
                self.note("`G` gives the card another number, which the lines behind it use");
                Ok(())
            }
            'P' | 'b' | 'c' | '?' | 'I' | 'V' | 'C' | 'u' => {
                self.note(format!(
                    "`@0{letter}` is about the card itself; it moves nothing and is left out"
                ));
                Ok(())
            }
            'Q' => {
                self.warn(Code::LeftOut, "`@0Q` ends a run by the computer: use Stop");
                Ok(())
            }
            _ => Err(Refused::new(
                '5',
                Code::Unreadable,
                format!("no command begins with `{letter}`"),
            )),
        }
    }

    /// A stored instruction.
    pub(super) fn store(&mut self, code: &str) -> Read<()> {
        let Some(opcode) = code.chars().next() else { return Ok(()) };
        let values = &code[opcode.len_utf8()..];
        match opcode {
            '0' => self.movement(values, code, Op::Relative),
            'm' => self.movement(values, code, Op::Absolute),
            '6' => self.movement(values, code, Op::UntilImpulse),
            '1' => {
                let [c] = self.exactly(values)?;
                self.character(c)?;
                self.push(Op::Send(c), code)
            }
            '2' => self.wait_char(values, code),
            '3' => self.repeat(values, code),
            '4' => {
                let [option] = self.exactly(values)?;
                if !(1..=6).contains(&option) {
                    return Err(Refused::new(
                        'A',
                        Code::OutOfRange,
                        format!("pulse option {option}"),
                    )
                    .hint("options are 1 to 6"));
                }
                self.push(Op::Pulse(option), code)
            }
            '5' => {
                let [tenths] = self.exactly(values)?;
                if !(0..=32_767).contains(&tenths) {
                    return Err(Refused::new(
                        '1',
                        Code::OutOfRange,
                        format!("a delay of {tenths}"),
                    )
                    .hint("delays are 0 to 32767 tenths of a second"));
                }
                self.push(Op::Delay(tenths), code)
            }
            '7' => self.home(values, code),
            '8' => self.tell(values, code),
            '9' => {
                self.end(values)?;
                self.end_storing()
            }
            'n' => self.zero(values, code),
            'e' => self.plane(values, code),
            'Z' => self.solid(values, code),
            'F' | 'f' => self.sense(values, code),
            'y' | 'Y' => self.arc(values, code),
            'p' => self.port(values, code),
            'o' => self.port_test(values, code),
            _ => Err(Refused::new(
                '5',
                Code::Unreadable,
                format!("`{opcode}` begins no stored instruction"),
            )
            .hint("stored are 0 1 2 3 4 5 6 7 8 9 m n e Z F y p o")),
        }
    }

    pub(super) fn push(&mut self, op: Op, code: &str) -> Read<()> {
        let item = Item { op, line: self.line, col: self.col, text: code.trim().to_owned() };
        let list = if self.storing { &mut self.stored } else { &mut self.program };
        list.push(item);
        if list.len() > MAX_ITEMS {
            return Err(Refused::new(
                '6',
                Code::TooLong,
                format!("more than {MAX_ITEMS} instructions"),
            ));
        }
        Ok(())
    }

    fn begin_storing(&mut self) -> Read<()> {
        self.known_axes()?;
        self.storing = true;
        self.complete = false;
        self.started = false;
        self.stored.clear();
        Ok(())
    }

    fn end_storing(&mut self) -> Read<()> {
        self.storing = false;
        self.complete = true;
        let end = self.stored.len();
        let beyond = self.stored.iter().find(|item| item.op.target().is_some_and(|to| to > end));
        if let Some(item) = beyond {
            (self.line, self.col) = (item.line, item.col);
            return Err(Refused::new(
                'B',
                Code::BadJump,
                "this jump leads behind the program's end",
            ));
        }
        let jumps = self.stored.iter().filter(|item| item.op.target().is_some()).count();
        if jumps > MAX_JUMPS {
            return Err(Refused::new(
                '6',
                Code::TooLong,
                format!("{jumps} jumps and loops; at most {MAX_JUMPS} are read"),
            ));
        }
        Ok(())
    }

    /// `S`: the stored program runs here.
    fn start(&mut self) -> Read<()> {
        if !self.complete {
            return Err(Refused {
                card: None,
                code: Code::NoProgram,
                hint: None,
                text: "nothing is stored that could be started".to_owned(),
            }
            .hint("stored instructions stand between `@0i` and `9`"));
        }
        self.started = true;
        let base = self.program.len();
        if base + self.stored.len() > MAX_ITEMS {
            return Err(Refused::new(
                '6',
                Code::TooLong,
                format!("more than {MAX_ITEMS} instructions"),
            ));
        }
        self.program.extend(self.stored.iter().map(|item| {
            let mut item = item.clone();
            item.op.shift(base);
            item
        }));
        Ok(())
    }

    fn finish(mut self) -> Vec<Item> {
        if self.storing {
            let diag = Diag::new(Code::NoProgram, self.line, 1, "the stored program has no end");
            self.diags.push(diag.hint("`9` ends it; the file may be cut"));
        } else if self.complete && !self.started {
            // The card's Start button runs it.
            let _ = self.start();
        }
        if self.program.is_empty() && !self.diags.has_errors() {
            self.diags.push(Diag::new(Code::NoProgram, 1, 1, "no instruction is executed"));
        }
        self.program
    }
}
