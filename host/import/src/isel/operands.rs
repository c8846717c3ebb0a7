//! Instructions with their values, checked as the card checks them.

use nom::Parser;
use nom::character::complete::anychar;
use nom::combinator::opt;
use nom::multi::separated_list0;
use nom::sequence::preceded;

use super::answer::answer;
use super::instr::{Axes, Op, Pair, Pairs};
use super::parse::{Read, Reader, Refused};
use crate::codes::Code;
use crate::line::{Parsed, blanks, sign, whole};
use lang::axis::Axis;

/// Greatest value that the card's 24 bits hold.
pub(crate) const MAX_STEPS: i64 = 8_388_607;
/// Slowest and fastest rate, steps/s, of system versions 4.0 and 5.0 together.
pub(crate) const RATES: core::ops::RangeInclusive<i64> = 21..=20_000;

/// The first port of eight outputs, the second, and that of eight inputs (binder, "Mettre les
/// ports de sortie en service").
const PORTS: [i64; 3] = [65_529, 65_530, 65_531];

impl Reader<'_> {
    pub(super) fn known_axes(&self) -> Read<Axes> {
        self.axes.ok_or_else(|| {
            Refused::new('4', Code::NoAxes, "the axes are not named before this")
                .hint("`@07` names X, Y and Z; X is 1, Y 2, Z 4")
        })
    }

    pub(super) fn set_axes(&mut self, values: &str) -> Read<()> {
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

    pub(super) fn mask(&mut self, values: &str) -> Read<Axes> {
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

    pub(super) fn movement(&mut self, values: &str, code: &str, make: fn(Pairs) -> Op) -> Read<()> {
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
    pub(super) fn check_rates(&mut self, op: &Op, pairs: &Pairs) -> Read<()> {
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
    pub(super) fn second_z(&mut self, op: &Op, mut pairs: Pairs) -> Pairs {
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

    pub(super) fn home(&mut self, values: &str, code: &str) -> Read<()> {
        let axes = self.mask(values)?;
        self.push(Op::Home(axes), code)
    }

    pub(super) fn zero(&mut self, values: &str, code: &str) -> Read<()> {
        let axes = self.mask(values)?;
        self.push(Op::Zero(axes), code)
    }

    pub(super) fn plane(&mut self, values: &str, code: &str) -> Read<()> {
        match self.exactly(values)? {
            [plane @ 0..=2] => self.push(Op::Plane(plane as u8), code),
            [plane] => Err(Refused::new('5', Code::OutOfRange, format!("plane {plane}"))
                .hint("planes are 0 XY, 1 XZ, 2 YZ")),
        }
    }

    pub(super) fn solid(&mut self, values: &str, code: &str) -> Read<()> {
        let numbers = self.numbers(values)?;
        match numbers[..] {
            // The binder's table has the letter alone.
            [] | [1] => self.push(Op::Solid(true), code),
            [0] => self.push(Op::Solid(false), code),
            _ => Err(Refused::new('5', Code::OutOfRange, "3D is switched by 0 or 1")),
        }
    }

    pub(super) fn sense(&mut self, values: &str, code: &str) -> Read<()> {
        match self.exactly(values)? {
            [0] => self.push(Op::Clockwise(true), code),
            // The binder writes both.
            [-1 | 1] => self.push(Op::Clockwise(false), code),
            [other] => Err(Refused::new('5', Code::OutOfRange, format!("sense {other}"))
                .hint("0 is clockwise, -1 the other way")),
        }
    }

    pub(super) fn arc(&mut self, values: &str, code: &str) -> Read<()> {
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

    pub(super) fn character(&mut self, c: i64) -> Read<()> {
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

    pub(super) fn wait_char(&mut self, values: &str, code: &str) -> Read<()> {
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
    pub(super) fn target(&self, offset: i64) -> Read<usize> {
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

    pub(super) fn repeat(&mut self, values: &str, code: &str) -> Read<()> {
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

    pub(super) fn tell(&mut self, values: &str, code: &str) -> Read<()> {
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

    pub(super) fn port(&mut self, values: &str, code: &str) -> Read<()> {
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

    pub(super) fn bits(&self, bit: i64, value: i64) -> Read<()> {
        let top = if bit == 0 { 255 } else { 1 };
        if (0..=8).contains(&bit) && (0..=top).contains(&value) {
            return Ok(());
        }
        Err(Refused::new('1', Code::OutOfRange, format!("bit {bit} with value {value}"))
            .hint("bits 1 to 8 are 0 or 1; bit 0 stands for all eight, 0 to 255"))
    }

    pub(super) fn port_test(&mut self, values: &str, code: &str) -> Read<()> {
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
    pub(super) fn poke(&mut self, values: &str, code: &str) -> Read<()> {
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
    pub(super) fn numbers(&mut self, values: &str) -> Read<Vec<i64>> {
        // `@0A,50,500` stands in the binder for `@0A 50,500`.
        let values = match values.strip_prefix(',') {
            Some(rest) => {
                self.note("the comma behind the command's letter is left out");
                rest
            }
            None => values,
        };
        let list: Parsed<'_, Vec<i64>> = separated_list0(sign(','), whole).parse(values);
        let (rest, numbers) =
            list.map_err(|_| Refused::new('5', Code::Unreadable, "numbers belong here"))?;
        self.end(rest)?;
        Ok(numbers)
    }

    pub(super) fn exactly<const N: usize>(&mut self, values: &str) -> Read<[i64; N]> {
        let numbers = self.numbers(values)?;
        let count = numbers.len();
        <[i64; N]>::try_from(numbers).map_err(|_| {
            Refused::new('7', Code::WrongCount, format!("{count} values where {N} belong"))
        })
    }

    /// Nothing more may stand here but a remark.
    pub(super) fn end(&mut self, rest: &str) -> Read<()> {
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
