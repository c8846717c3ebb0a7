//! An interface card that is talked to line by line: what each line asks for, or the character that
//! the card answers instead of `0`.
//!
//! It knows the card's state (axes, plane, what is being stored) and no machine. Source: the
//! charlyrobot binder, chapter 3; what newer cards (iMC-S8) take beside that is [`Dialect::Newer`].

use lang::axis::Axis;

use super::emit::{resulting, together};
use super::instr::{Axes, Op, Pairs};
use super::operands::RATES;
use super::parse::{Read, Reader, Refused};
use crate::codes::Code;
use crate::diag::Diags;

/// Instructions that are stored at most; a card with 32 KB holds about 1500.
const MOST_STORED: usize = 10_000;

/// Which card it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Dialect {
    /// charlyrobot and isel interface cards 4.0 and 5.0.
    #[default]
    Binder,
    /// iMC-S8 and its like: the same, and settings that ramps and currents of ours have no use for.
    Newer,
}

/// Axes that move together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Phase {
    /// Machine positions in steps, or distances.
    pub axes: Vec<(Axis, i64)>,
    /// Speed along their path, steps/s.
    pub rate: i64,
}

/// What a line asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Order {
    /// Nothing that the machine would notice.
    Nothing,
    /// The axes were named: a program begins anew.
    Axes,
    /// Moves, one after the other; `absolute`: to machine positions.
    Move {
        /// To positions instead of by distances.
        absolute: bool,
        /// In their order.
        phases: Vec<Phase>,
    },
    /// Reference runs in this order.
    Home(Vec<Axis>),
    /// Where these axes stand is their zero from here on: [`Card::set_zero`] is to be told.
    Zero(Vec<Axis>),
    /// Eight outputs from `first` on, from 1.
    Outputs {
        /// The lowest one.
        first: u16,
        /// Bit 0 is that one.
        value: u8,
    },
    /// Speed of reference runs, steps/s, by axis.
    Speeds([Option<i64>; 3]),
    /// The stored program is whole: [`Card::program`].
    Stored,
    /// The stored program is to run, or to go on.
    Start,
    /// A halted run is to end.
    Quit,
    /// The positions of all axes.
    Position,
    /// A byte of the card's memory at this address, where inputs and outputs are, too.
    Peek(i64),
    /// Answers have CR and LF behind them from now on, or not.
    Handshake(bool),
    /// Who the card is.
    Version,
}

/// A line that was understood.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// What it asks for.
    pub order: Order,
    /// It is answered before it is carried out.
    pub at_once: bool,
}

/// The state of a card.
#[derive(Clone, Debug)]
pub struct Card {
    dialect: Dialect,
    number: char,
    axes: Option<Axes>,
    plane: u8,
    solid: bool,
    clockwise: bool,
    /// Between `i` and `9`.
    storing: bool,
    /// The stored instructions as they came.
    stored: Vec<String>,
    complete: bool,
    /// They move their zero themselves.
    zeroes: bool,
    /// Zero of absolute moves, machine steps.
    zero: [i64; 3],
}

impl Card {
    /// A card that was just switched on, with number 0.
    pub fn new(dialect: Dialect) -> Card {
        Card {
            dialect,
            number: '0',
            axes: None,
            plane: 0,
            solid: false,
            clockwise: true,
            storing: false,
            stored: Vec::new(),
            complete: false,
            zeroes: false,
            zero: [0; 3],
        }
    }

    /// Tells where an axis has its zero, in machine steps.
    pub fn set_zero(&mut self, axis: Axis, steps: i64) {
        self.zero[axis.index()] = steps;
    }

    /// Takes a line without its end; none when it is for a card with another number.
    ///
    /// # Errors
    /// The character that the card answers.
    pub fn line(&mut self, text: &str) -> Option<Result<Line, char>> {
        let text = text.trim();
        let command = text.strip_prefix('@').map(str::trim_start);
        // Another card's number is another card's line.
        let other = |own: char| own.is_ascii_digit() && own != self.number;
        if command.and_then(|rest| rest.chars().next()).is_some_and(other) {
            return None;
        }
        let order = match command.map(|rest| (rest.strip_prefix(self.number), self.storing)) {
            None if self.storing => self.store(text).map(|order| (order, false)),
            // An instruction that is not stored ends the storing.
            Some((Some(rest), false)) => self.direct(text, rest.trim_start()),
            _ => Err('5'),
        };
        if order.is_err() && self.storing {
            // "The program so far cannot be used" (binder, Input).
            self.storing = false;
            self.stored.clear();
        }
        Some(order.map(|(order, at_once)| Line { order, at_once }))
    }

    /// A text for the importer: the stored program with the settings that hold where it begins; none
    /// while there is none.
    pub fn program(&self) -> Option<String> {
        let axes = self.axes.filter(|_| self.complete)?;
        let solid = if self.solid { "@0Z1\n" } else { "" };
        let sense = if self.clockwise { 0 } else { -1 };
        let head = format!("@0{}\n@0e{}\n{solid}@0F{sense}\n@0i\n", axes.0, self.plane);
        Some(head + &self.stored.join("\n") + "\n9\n")
    }

    /// Reads with the reader of recorded texts; what it makes of the line comes back.
    fn read<T>(&mut self, read: impl FnOnce(&mut Reader<'_>) -> Read<T>) -> Result<(T, Op), char> {
        let mut diags = Diags::new(false);
        let mut reader = Reader::new(&mut diags);
        (reader.device, reader.axes) = (Some(self.number), self.axes);
        let result = read(&mut reader).map_err(|refused| refused.card.unwrap_or('5'))?;
        self.axes = reader.axes;
        let list = if reader.storing { &mut reader.stored } else { &mut reader.program };
        Ok((result, list.pop().map_or(Op::Delay(0), |item| item.op)))
    }

    /// A command with what stands behind the card's number.
    fn direct(&mut self, text: &str, rest: &str) -> Result<(Order, bool), char> {
        let letter = rest.chars().next().ok_or('5')?;
        let values = &rest[letter.len_utf8()..];
        let at_once = matches!(letter, 'a' | 'm' | 'r' | 's');
        let newer = self.dialect == Dialect::Newer;
        let order = match letter {
            'A' | 'a' | 'M' | 'm' | 'R' | 'r' | 'n' | 'e' | 'Z' | 'F' | 'B' => {
                let op = self.read(|reader| reader.direct(&text[1..], text));
                return Ok((self.order(op?.1)?, at_once));
            }
            'z' if newer => {
                let (_, op) = self.read(|reader| reader.solid(values, text))?;
                self.order(op)?
            }
            '0'..='9' => {
                self.read(|reader| reader.direct(&text[1..], text))?;
                self.forget();
                Order::Axes
            }
            'i' => {
                self.read(|reader| {
                    reader.known_axes()?;
                    reader.end(values)
                })?;
                self.forget();
                self.storing = true;
                Order::Nothing
            }
            'S' | 's' | 'Q' | 'P' | 'V' => {
                self.read(|reader| reader.end(values))?;
                match letter {
                    'P' => Order::Position,
                    'Q' => Order::Quit,
                    'V' => Order::Version,
                    _ if self.complete => Order::Start,
                    _ => return Err('5'),
                }
            }
            'd' => {
                let numbers = self.read(|reader| reader.numbers(values))?.0;
                Order::Speeds(self.speeds(&numbers)?)
            }
            'b' | 'c' => Order::Peek(self.read(|reader| reader.exactly::<1>(values))?.0[0]),
            'C' => match self.read(|reader| reader.exactly::<1>(values))?.0 {
                [on @ 0..=1] => Order::Handshake(on == 1),
                _ => return Err('1'),
            },
            'G' => {
                let [number] = self.read(|reader| reader.exactly::<1>(values))?.0;
                let number = u32::try_from(number).ok().and_then(|n| char::from_digit(n, 10));
                self.number = number.ok_or('1')?;
                Order::Nothing
            }
            'k' | 'K' => {
                self.read(|reader| reader.end(values))?;
                *self = Card::new(self.dialect);
                Order::Nothing
            }
            // Currents, ramps and units of a card that has them.
            'I' | 'J' | 'j' | 'g' if newer => Order::Nothing,
            _ => return Err('5'),
        };
        Ok((order, at_once))
    }

    /// The card divides its memory by its axes and forgets what it held.
    fn forget(&mut self) {
        self.stored.clear();
        (self.complete, self.zeroes) = (false, false);
    }

    /// "An axis that does not move needs a speed of the range as well" (binder, error D); newer cards
    /// take any there.
    fn check_rates(&self, op: &Op) -> Result<(), char> {
        let (Op::Relative(pairs) | Op::Absolute(pairs) | Op::UntilImpulse(pairs)) = op else {
            return Ok(());
        };
        let mut all = pairs.axes.iter().flatten().chain(&pairs.back);
        let strict = self.dialect == Dialect::Binder;
        match strict && all.any(|pair| !RATES.contains(&pair.rate)) {
            true => Err('D'),
            false => Ok(()),
        }
    }

    /// What an instruction asks for that is carried out now.
    fn order(&mut self, op: Op) -> Result<Order, char> {
        self.check_rates(&op)?;
        Ok(match op {
            Op::Relative(pairs) => {
                Order::Move { absolute: false, phases: self.phases(&pairs, false) }
            }
            Op::Absolute(pairs) => {
                Order::Move { absolute: true, phases: self.phases(&pairs, true) }
            }
            Op::Home(axes) => Order::Home(axes.list().rev().collect()),
            Op::Zero(axes) => Order::Zero(axes.list().collect()),
            Op::Port { first, value, .. } => {
                let (first, value) = (u16::try_from(first), u8::try_from(value));
                Order::Outputs { first: first.map_err(|_| '1')?, value: value.map_err(|_| '1')? }
            }
            Op::Plane(plane) => {
                self.plane = plane;
                Order::Nothing
            }
            Op::Solid(solid) => {
                self.solid = solid;
                Order::Nothing
            }
            Op::Clockwise(clockwise) => {
                self.clockwise = clockwise;
                Order::Nothing
            }
            _ => return Err('5'),
        })
    }

    /// The moves of an instruction, one after the other.
    fn phases(&self, pairs: &Pairs, absolute: bool) -> Vec<Phase> {
        let mut phases = Vec::new();
        for group in together(self.solid, self.plane) {
            let moving = group.into_iter().filter_map(|axis| {
                let pair = pairs.axes[axis.index()]?;
                let zero = if absolute { self.zero[axis.index()] } else { 0 };
                (absolute || pair.steps != 0).then_some(((axis, pair.steps + zero), pair.rate))
            });
            let (axes, rates): (Vec<_>, Vec<_>) = moving.unzip();
            if !axes.is_empty() {
                phases.push(Phase { axes, rate: resulting(rates.into_iter()) });
            }
        }
        if let Some(back) = pairs.back.filter(|pair| pair.steps != 0) {
            phases.push(Phase { axes: vec![(Axis::Z, back.steps)], rate: back.rate });
        }
        phases
    }

    /// Reference speeds: one for each axis; cards with a fourth one send its speed, too.
    fn speeds(&self, numbers: &[i64]) -> Result<[Option<i64>; 3], char> {
        let axes = self.axes.ok_or('4')?;
        let count = axes.list().count();
        if numbers.len() != count && (numbers.len(), count) != (4, 3) {
            return Err('7');
        }
        if numbers.iter().any(|rate| !RATES.contains(rate)) {
            return Err('D');
        }
        let mut speeds = [None; 3];
        for (axis, rate) in axes.list().zip(numbers) {
            speeds[axis.index()] = Some(*rate);
        }
        Ok(speeds)
    }

    /// An instruction that is stored.
    fn store(&mut self, text: &str) -> Result<Order, char> {
        let before = self.stored.len();
        let zero = self.zero;
        let shifts = !self.zeroes && zero != [0; 3];
        let (is_end, op) = self.read(|reader| {
            reader.storing = true;
            // Jumps count instructions.
            let item =
                super::instr::Item { op: Op::Delay(0), line: 1, col: 1, text: String::new() };
            reader.stored = vec![item; before];
            let is_end = text.starts_with('9');
            reader.store(text)?;
            if is_end && before == 0 {
                return Err(Refused::new('5', Code::NoProgram, "nothing is stored"));
            }
            Ok(is_end)
        })?;
        if is_end {
            (self.storing, self.complete) = (false, true);
            return Ok(Order::Stored);
        }
        if before >= MOST_STORED {
            return Err('6');
        }
        // There is no other card that this one could start.
        if matches!(op, Op::Tell { .. }) {
            return Err('B');
        }
        self.check_rates(&op)?;
        self.zeroes |= matches!(op, Op::Zero(_));
        let text = match &op {
            Op::Absolute(pairs) if shifts => shifted(pairs, zero),
            _ => text.to_owned(),
        };
        self.stored.push(text);
        Ok(Order::Nothing)
    }
}

/// An absolute move whose targets count from another zero.
fn shifted(pairs: &Pairs, zero: [i64; 3]) -> String {
    let named = Axis::ALL.into_iter().filter_map(|axis| Some((axis, pairs.axes[axis.index()]?)));
    let mut values = Vec::new();
    for (axis, pair) in named {
        values.push(format!("{},{}", pair.steps + zero[axis.index()], pair.rate));
        if axis == Axis::Z {
            values.push("0,21".to_owned());
        }
    }
    format!("m {}", values.join(","))
}

#[cfg(test)]
mod tests {
    use super::{Card, Dialect, Order, Phase};
    use lang::axis::Axis::{X, Y, Z};

    /// The answers to lines: `0`, an error's character, or `-` for a line of another card.
    fn answers(card: &mut Card, lines: &[&str]) -> String {
        let answer = |line: &&str| match card.line(line) {
            None => '-',
            Some(Ok(_)) => '0',
            Some(Err(error)) => error,
        };
        lines.iter().map(answer).collect()
    }

    fn order(card: &mut Card, line: &str) -> Order {
        card.line(line).expect("for this card").expect("good").order
    }

    #[test]
    fn the_binders_examples_and_errors_have_their_answers() {
        let mut card = Card::new(Dialect::Binder);
        // Binder: "Erreurs possibles" of each command.
        let wrong = ["@0R7", "@0A 50,900", "@0i", "@0d2000", "@09", "@0S"];
        assert_eq!(answers(&mut card, &wrong), "444435");
        assert_eq!(answers(&mut card, &["@03", "@0R7", "@0A 50,900", "@0A 50,20,20,900"]), "037D");
        assert_eq!(answers(&mut card, &["@0A 60E3,900,0,21", "@0x", "hello", "9", ""]), "55555");
        assert_eq!(answers(&mut card, &["@1R1", "@0d3000,5000", "@0d1", "@0d20001,21"]), "-07D");
        assert_eq!(
            answers(&mut card, &["@0C2", "@0G1", "@0P", "@1P", "@1G0", "@0K", "@0n1"]),
            "10-0004"
        );
        assert_eq!(answers(&mut card, &["@0I", "@0J100"]), "55");
        let mut newer = Card::new(Dialect::Newer);
        assert_eq!(answers(&mut card, &["@01", "@0A 0,0", "@0i", "0 0,0"]), "0D0D");
        assert_eq!(answers(&mut newer, &["@01", "@0A 0,0"]), "00");
        assert_eq!(answers(&mut newer, &["@07", "@0IR7", "@0J100", "@0z1", "@0Q"]), "00000");
        assert_eq!(
            order(&mut newer, "@0A 1,100,2,100,3,100,0,21"),
            Order::Move {
                absolute: false,
                phases: vec![Phase { axes: vec![(X, 1), (Y, 2), (Z, 3)], rate: 173 }],
            }
        );
    }

    #[test]
    fn a_move_is_one_group_after_the_other() {
        let mut card = Card::new(Dialect::Binder);
        answers(&mut card, &["@07"]);
        let phase = |axes: &[_], rate| Phase { axes: axes.to_vec(), rate };
        assert_eq!(
            order(&mut card, "@0A 30,800,10,600,4,90,-4,21"),
            Order::Move {
                absolute: false,
                phases: vec![
                    phase(&[(X, 30), (Y, 10)], 1000),
                    phase(&[(Z, 4)], 90),
                    phase(&[(Z, -4)], 21)
                ],
            }
        );
        assert_eq!(answers(&mut card, &["@0e1"]), "0");
        card.set_zero(Y, 500);
        assert_eq!(
            order(&mut card, "@0m 30,800,10,600,4,600,0,21"),
            Order::Move {
                absolute: true,
                phases: vec![phase(&[(X, 30), (Z, 4)], 1000), phase(&[(Y, 510)], 600)],
            }
        );
        assert_eq!(order(&mut card, "@0R7"), Order::Home(vec![Z, Y, X]));
        assert!(card.line("@0r1").expect("for it").expect("good").at_once);
        assert_eq!(order(&mut card, "@0B65530,129"), Order::Outputs { first: 9, value: 129 });
        assert_eq!(order(&mut card, "@0n 5"), Order::Zero(vec![X, Z]));
        assert_eq!(
            order(&mut card, "@0d1000,1500,2000"),
            Order::Speeds([1000, 1500, 2000].map(Some))
        );
    }

    #[test]
    fn a_stored_program_is_whole_or_there_is_none() {
        let mut card = Card::new(Dialect::Binder);
        let good = ["@01", "@0i", "0 5000,900", "3 5,-1", "1 70", "9"];
        assert_eq!(answers(&mut card, &good), "000000");
        assert_eq!(
            card.program().expect("one"),
            "@01\n@0e0\n@0F0\n@0i\n0 5000,900\n3 5,-1\n1 70\n9\n"
        );
        assert_eq!(order(&mut card, "@0S"), Order::Start);
        // An error ends the storing; nothing of it can be started.
        assert_eq!(answers(&mut card, &["@0i", "0 5000,900", "0 5000", "9", "@0S"]), "00755");
        assert_eq!(
            answers(&mut card, &["@0i", "3 4,-1", "@0i", "@0P", "0 1,21", "9", "@0S"]),
            "0B05555"
        );
        assert_eq!(answers(&mut card, &["@0i", "9", "@0i", "8 1S"]), "050B");
        assert!(card.program().is_none());
        // The axes' choice erases what was stored.
        assert_eq!(answers(&mut card, &good), "000000");
        assert_eq!(answers(&mut card, &["@01", "@0S"]), "05");
        // Absolute moves count from the zero that was set outside.
        card.set_zero(X, -100);
        assert_eq!(answers(&mut card, &["@0i", "m 50,900", "n 1", "m 50,900", "9"]), "00000");
        let text = card.program().expect("one");
        assert!(text.contains("@0i\nm -50,900\nn 1\nm 50,900\n9"), "{text}");
    }
}
