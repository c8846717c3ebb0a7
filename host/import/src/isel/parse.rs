//! From the lines of a recorded text, or of a BASIC listing that prints them, to the list of
//! instructions in the order of execution.

use nom::Parser;
use nom::character::complete::{anychar, satisfy};
use nom::combinator::opt;
use nom::multi::separated_list0;
use nom::sequence::preceded;

use super::answer::answer;
use super::instr::{Axes, Item, Op, Pair, Pairs};
use crate::codes::Code;
use crate::diag::{Diag, Diags};
use crate::line::{Parsed, blanks, column, sign, whole};
use lang::axis::Axis;

/// Instructions of one script; a card with 32 KB holds about 1500.
const MAX_ITEMS: usize = 200_000;
/// Jumps and loops among them.
const MAX_JUMPS: usize = 2000;
/// Greatest value that the card's 24 bits hold.
const MAX_STEPS: i64 = 8_388_607;
/// Slowest and fastest rate, steps/s, of system versions 4.0 and 5.0 together.
pub(crate) const RATES: core::ops::RangeInclusive<i64> = 21..=20_000;

/// The first port of eight outputs, the second, and that of eight inputs (binder, "Mettre les
/// ports de sortie en service").
const PORTS: [i64; 3] = [65_529, 65_530, 65_531];

/// What went wrong in an instruction: the character that the card answers, and why.
struct Refused {
    card: Option<char>,
    code: Code,
    text: String,
    hint: Option<String>,
}

impl Refused {
    fn new(card: char, code: Code, text: impl Into<String>) -> Refused {
        Refused { card: Some(card), code, text: text.into(), hint: None }
    }

    fn hint(mut self, hint: impl Into<String>) -> Refused {
        self.hint = Some(hint.into());
        self
    }
}

type Read<T> = Result<T, Refused>;

/// A list that is being read.
struct Reader<'d> {
    diags: &'d mut Diags,
    /// The card's number, as the first command names it.
    device: Option<char>,
    axes: Option<Axes>,
    /// In order of execution.
    program: Vec<Item>,
    /// Between `i` and `9`.
    storing: bool,
    stored: Vec<Item>,
    complete: bool,
    started: bool,
    /// The line that is being read.
    line: u32,
    col: u32,
}

/// Reads a text. With errors the list is of no use.
pub(crate) fn read(lines: &[(u32, &str)], diags: &mut Diags) -> Vec<Item> {
    let mut reader = Reader {
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
    };
    for &(number, line) in lines {
        reader.line = number;
        let Some(code) = listing(line) else { continue };
        reader.col = column(line, code);
        reader.read_line(line, code);
        if reader.diags.hopeless() {
            break;
        }
    }
    reader.finish()
}

/// The part of a line that goes to the card: of a BASIC listing what `PRINT #` prints. None for
/// lines that send nothing.
fn listing(line: &str) -> Option<&str> {
    const WORDS: [&str; 12] = [
        "print", "open", "close", "gosub", "goto", "if", "stop", "return", "a$", "rem", "end",
        "cls",
    ];
    let rest = line.trim_start().trim_start_matches(|c: char| c.is_ascii_digit()).trim_start();
    let lower = rest.to_ascii_lowercase();
    let numbered = line.trim_start().starts_with(|c: char| c.is_ascii_digit());
    if !numbered || !WORDS.iter().any(|word| lower.starts_with(word)) {
        return Some(line);
    }
    let printed = rest.get("print".len()..).filter(|_| lower.starts_with("print"))?;
    let from = printed.find(['"', '«', '»'])?;
    let quote = printed[from..].chars().next()?;
    let text = &printed[from + quote.len_utf8()..];
    let text = &text[..text.find(['"', '«', '»']).unwrap_or(text.len())];
    let to_card = printed.trim_start().starts_with('#');
    (to_card || text.starts_with('@')).then_some(text)
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

    fn warn(&mut self, code: Code, text: impl Into<String>) {
        self.diags.once(Diag::new(code, self.line, self.col, text).warning());
    }

    fn note(&mut self, text: impl Into<String>) {
        self.diags.once(Diag::new(Code::Said, self.line, self.col, text).note());
    }

    /// What follows `@`.
    fn direct(&mut self, command: &str, code: &str) -> Read<()> {
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
            'P' | 'b' | 'c' | '?' | 'I' | 'V' | 'C' | 'G' | 'u' => {
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
    fn store(&mut self, code: &str) -> Read<()> {
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

    fn push(&mut self, op: Op, code: &str) -> Read<()> {
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

    fn known_axes(&self) -> Read<Axes> {
        self.axes.ok_or_else(|| {
            Refused::new('4', Code::NoAxes, "the axes are not named before this")
                .hint("`@07` names X, Y and Z; X is 1, Y 2, Z 4")
        })
    }

    fn set_axes(&mut self, values: &str) -> Read<()> {
        let [mask] = self.exactly(values)?;
        let axes = match mask {
            1 | 3 | 5 | 7 => Axes(mask as u8),
            2 | 4 | 6 => {
                self.note(format!("the manual forbids `@0{mask}`; programs send it all the same"));
                Axes(mask as u8)
            }
            _ => {
                return Err(Refused::new('3', Code::WrongAxis, format!("{mask} names no axes"))
                    .hint("X is 1, Y 2, Z 4: 1, 3, 5 and 7"));
            }
        };
        // The card divides its memory by the number of axes and forgets what it held.
        self.axes = Some(axes);
        self.stored.clear();
        self.complete = false;
        Ok(())
    }

    fn mask(&mut self, values: &str) -> Read<Axes> {
        let axes = self.known_axes()?;
        let [mask] = self.exactly(values)?;
        let named = u8::try_from(mask).ok().filter(|mask| (1..=7).contains(mask)).map(Axes);
        match named {
            Some(named) if axes.holds(named) => Ok(named),
            _ => Err(Refused::new(
                '3',
                Code::WrongAxis,
                format!("{mask} names axes that `@0{}` does not", axes.0),
            )
            .hint("X is 1, Y 2, Z 4, added")),
        }
    }

    fn movement(&mut self, values: &str, code: &str, make: fn(Pairs) -> Op) -> Read<()> {
        let axes = self.known_axes()?;
        let numbers = self.numbers(values)?;
        let wanted = 2 * axes.pairs();
        if numbers.len() != wanted {
            return Err(Refused::new(
                '7',
                Code::WrongCount,
                format!("{} values; `@0{}` needs {wanted}", numbers.len(), axes.0),
            )
            .hint("steps and speed for each of X and Y, two such pairs for Z"));
        }
        let mut list = Vec::with_capacity(4);
        for pair in numbers.chunks_exact(2) {
            let (steps, rate) = (pair[0], pair[1]);
            if steps.abs() > MAX_STEPS {
                return Err(Refused::new('5', Code::OutOfRange, format!("{steps} steps"))
                    .hint(format!("steps lie within {MAX_STEPS}")));
            }
            list.push(Pair { steps, rate });
        }
        let back = if axes.has(Axis::Z) { list.pop() } else { None };
        let mut pairs = Pairs { back, ..Pairs::default() };
        for (axis, pair) in axes.list().zip(list) {
            pairs.axes[axis.index()] = Some(pair);
        }
        let op = make(pairs);
        self.check_rates(&op, &pairs)?;
        let pairs = self.second_z(&op, pairs);
        self.push(
            match op {
                Op::Absolute(_) => Op::Absolute(pairs),
                op => op,
            },
            code,
        )
    }

    /// A pair that moves nothing needs no speed, whatever the card says.
    fn check_rates(&mut self, op: &Op, pairs: &Pairs) -> Read<()> {
        let absolute = matches!(op, Op::Absolute(_));
        let axes = pairs.axes.iter().flatten().map(|pair| (pair, absolute));
        for (pair, moves) in axes.chain(pairs.back.iter().map(|pair| (pair, false))) {
            if RATES.contains(&pair.rate) {
                continue;
            }
            let text = format!("a speed of {} steps/s", pair.rate);
            if moves || pair.steps != 0 {
                return Err(Refused::new('D', Code::OutOfRange, text).hint(format!(
                    "speeds are {} to {}",
                    RATES.start(),
                    RATES.end()
                )));
            }
            self.warn(Code::OutOfRange, format!("{text}, where nothing moves{}", answer('D')));
        }
        Ok(())
    }

    /// The second Z of an absolute move has no meaning; it should be 0.
    fn second_z(&mut self, op: &Op, mut pairs: Pairs) -> Pairs {
        if !matches!(op, Op::Absolute(_)) {
            return pairs;
        }
        let first = pairs.axes[Axis::Z.index()];
        match pairs.back.take() {
            Some(back) if back.steps != 0 && first.is_some_and(|z| z.steps == back.steps) => {
                self.note("the second Z of an absolute move repeats the first: it is left out");
            }
            Some(back) if back.steps != 0 => {
                self.warn(
                    Code::LeftOut,
                    "the second Z of an absolute move must be 0; it is left out",
                );
            }
            _ => {}
        }
        pairs
    }

    fn home(&mut self, values: &str, code: &str) -> Read<()> {
        let axes = self.mask(values)?;
        self.push(Op::Home(axes), code)
    }

    fn zero(&mut self, values: &str, code: &str) -> Read<()> {
        let axes = self.mask(values)?;
        self.push(Op::Zero(axes), code)
    }

    fn plane(&mut self, values: &str, code: &str) -> Read<()> {
        match self.exactly(values)? {
            [plane @ 0..=2] => self.push(Op::Plane(plane as u8), code),
            [plane] => Err(Refused::new('5', Code::OutOfRange, format!("plane {plane}"))
                .hint("planes are 0 XY, 1 XZ, 2 YZ")),
        }
    }

    fn solid(&mut self, values: &str, code: &str) -> Read<()> {
        let numbers = self.numbers(values)?;
        match numbers[..] {
            // The binder's table has the letter alone.
            [] | [1] => self.push(Op::Solid(true), code),
            [0] => self.push(Op::Solid(false), code),
            _ => Err(Refused::new('5', Code::OutOfRange, "3D is switched by 0 or 1")),
        }
    }

    fn sense(&mut self, values: &str, code: &str) -> Read<()> {
        match self.exactly(values)? {
            [0] => self.push(Op::Clockwise(true), code),
            // The binder writes both.
            [-1 | 1] => self.push(Op::Clockwise(false), code),
            [other] => Err(Refused::new('5', Code::OutOfRange, format!("sense {other}"))
                .hint("0 is clockwise, -1 the other way")),
        }
    }

    fn arc(&mut self, values: &str, code: &str) -> Read<()> {
        let axes = self.known_axes()?;
        let [length, rate, _error, x, y, rx, ry] = self.exactly(values)?;
        if axes != Axes::ALL {
            self.note("the manual wants three axes for circles");
        }
        if !RATES.contains(&rate) {
            return Err(Refused::new('D', Code::OutOfRange, format!("a speed of {rate} steps/s")));
        }
        let within = [length, x, y].iter().all(|value| value.abs() <= MAX_STEPS);
        if !within || length <= 0 || (x, y) == (0, 0) || ![rx, ry].iter().all(|r| r.abs() == 1) {
            return Err(Refused::new('5', Code::OutOfRange, "these values make no circle")
                .hint("`y R,V,D,Xs,Ys,Rx,Ry`: R above 0, Xs and Ys the start seen from the centre, Rx and Ry 1 or -1"));
        }
        self.push(Op::Arc { length, rate, from: [x, y] }, code)
    }

    fn character(&mut self, c: i64) -> Read<()> {
        if !(33..=125).contains(&c) {
            return Err(Refused::new(
                '5',
                Code::OutOfRange,
                format!("synchronisation character {c}"),
            )
            .hint("they are 33 to 125"));
        }
        if c == 48 || c == 64 {
            self.warn(
                Code::OutOfRange,
                format!("character {c} is barred by the manual: it opens the link's own traffic"),
            );
        }
        Ok(())
    }

    fn wait_char(&mut self, values: &str, code: &str) -> Read<()> {
        let numbers = self.numbers(values)?;
        let (c, offset) = match numbers[..] {
            [c] => (c, 0),
            [c, offset] => (c, offset),
            _ => {
                return Err(Refused::new(
                    '7',
                    Code::WrongCount,
                    "a character and an offset belong here",
                ));
            }
        };
        self.character(c)?;
        let jump = match offset {
            0 => None,
            _ => Some(self.target(offset)?),
        };
        self.push(Op::WaitChar { c, jump }, code)
    }

    /// The instruction `offset` away from the next one to be stored.
    fn target(&self, offset: i64) -> Read<usize> {
        if !(-32_767..=32_767).contains(&offset) {
            return Err(Refused::new('1', Code::OutOfRange, format!("an offset of {offset}"))
                .hint("offsets lie within 32767"));
        }
        let here = i64::try_from(self.stored.len()).unwrap_or(i64::MAX - 40_000);
        usize::try_from(here + offset).map_err(|_| {
            Refused::new('B', Code::BadJump, format!("{offset} leads before the program's start"))
                .hint(format!("this is instruction {}", here + 1))
        })
    }

    fn repeat(&mut self, values: &str, code: &str) -> Read<()> {
        let [times, offset] = self.exactly(values)?;
        if !(0..=32_767).contains(&times) {
            return Err(Refused::new('1', Code::OutOfRange, format!("{times} passes"))
                .hint("loops run 1 to 32767 times, 0 is a jump"));
        }
        let wrong = if times > 0 && offset >= 0 {
            Some("a loop repeats what stands before it")
        } else if offset == 0 {
            Some("a jump to itself")
        } else {
            None
        };
        if let Some(wrong) = wrong {
            return Err(Refused::new('C', Code::BadJump, wrong)
                .hint("`3 7,-2` runs the last two instructions 7 times in all"));
        }
        let target = self.target(offset)?;
        self.push(
            if offset < 0 { Op::Loop { times, start: target } } else { Op::Jump(target) },
            code,
        )
    }

    fn tell(&mut self, values: &str, code: &str) -> Read<()> {
        let text: String = values.chars().filter(|c| !c.is_whitespace()).take(5).collect();
        let mut chars = text.chars();
        let device = chars.next().is_some_and(|c| c.is_ascii_digit());
        if !device || !text.is_ascii() || text.contains(['"', '\'']) {
            return Err(Refused::new(
                'B',
                Code::Unreadable,
                "`8` needs the other card's number and a command",
            )
            .hint("`8 0S` starts it, `8 0R1` homes its X"));
        }
        let wait = chars.next().is_some_and(|c| c.is_ascii_uppercase());
        self.push(Op::Tell { text, wait }, code)
    }

    fn port(&mut self, values: &str, code: &str) -> Read<()> {
        let [address, bit, value] = self.exactly(values)?;
        let first = match address {
            a if a == PORTS[0] => 1,
            a if a == PORTS[1] => 9,
            _ => {
                return Err(Refused::new(
                    '1',
                    Code::OutOfRange,
                    format!("{address} is no port of outputs"),
                )
                .hint(format!("they are {} and {}", PORTS[0], PORTS[1])));
            }
        };
        self.bits(bit, value)?;
        self.push(Op::Port { first, bit, value }, code)
    }

    fn bits(&self, bit: i64, value: i64) -> Read<()> {
        let top = if bit == 0 { 255 } else { 1 };
        if (0..=8).contains(&bit) && (0..=top).contains(&value) {
            return Ok(());
        }
        Err(Refused::new('1', Code::OutOfRange, format!("bit {bit} with value {value}"))
            .hint("bits 1 to 8 are 0 or 1; bit 0 stands for all eight, 0 to 255"))
    }

    fn port_test(&mut self, values: &str, code: &str) -> Read<()> {
        let [address, bit, value, offset] = self.exactly(values)?;
        if address != PORTS[2] {
            return Err(Refused::new(
                '1',
                Code::OutOfRange,
                format!("{address} is no port of inputs"),
            )
            .hint(format!("it is {}", PORTS[2])));
        }
        self.bits(bit, value)?;
        let jump = self.target(offset)?;
        self.push(Op::PortTest { bit, value, jump }, code)
    }

    /// `B`: writing to a port's address is an output; anything else is the card's own memory.
    fn poke(&mut self, values: &str, code: &str) -> Read<()> {
        let [address, value] = self.exactly(values)?;
        let first = PORTS[..2].iter().position(|port| *port == address);
        let Some(index) = first else {
            return Err(Refused {
                card: None,
                code: Code::Unsupported,
                hint: None,
                text: format!("address {address} belongs to the card's own memory"),
            }
            .hint("ports of outputs are 65529 and 65530"));
        };
        self.bits(0, value)?;
        self.push(Op::Port { first: [1, 9][index], bit: 0, value }, code)
    }

    /// Numbers with commas between; a remark may follow.
    fn numbers(&mut self, values: &str) -> Read<Vec<i64>> {
        let list: Parsed<'_, Vec<i64>> = separated_list0(sign(','), whole).parse(values);
        let (rest, numbers) =
            list.map_err(|_| Refused::new('5', Code::Unreadable, "numbers belong here"))?;
        self.end(rest)?;
        Ok(numbers)
    }

    fn exactly<const N: usize>(&mut self, values: &str) -> Read<[i64; N]> {
        let numbers = self.numbers(values)?;
        let count = numbers.len();
        <[i64; N]>::try_from(numbers).map_err(|_| {
            Refused::new('7', Code::WrongCount, format!("{count} values where {N} belong"))
        })
    }

    /// Nothing more may stand here but a remark.
    fn end(&mut self, rest: &str) -> Read<()> {
        let tail: Parsed<'_, Option<char>> = preceded(blanks, opt(anychar)).parse(rest);
        let apart = rest.starts_with([' ', '\t']);
        match tail {
            Ok((_, None | Some('(' | ';' | '\'' | '{' | '/' | '"'))) => Ok(()),
            Ok((_, Some(c))) if apart && c.is_alphabetic() => {
                self.note("words behind an instruction are taken as a remark");
                Ok(())
            }
            Ok((_, Some(c))) => {
                Err(Refused::new('5', Code::Unreadable, format!("`{c}` does not belong here")))
            }
            Err(_) => Ok(()),
        }
    }
}
