//! The formula interpreter: generated formulas, run from RAM, against their meaning.

use std::cell::RefCell;

use firmware::motion::scaled::Scaled;
use proptest::prelude::*;

use crate::chip::Chip;

/// Numbers that formulas name: 8 scaled ones, then 8 integers.
const NUMBERS: u16 = 0x0240;
/// Where an axis record would lie.
const RECORD: u16 = 0x0280;
/// Where the formula lies.
const CODE: u16 = 0x0300;
// Flags as formula.s has them.
const LAST: u8 = 0x20;
const AXIS: u8 = 0x40;
const RECORD_32: u8 = 0x80;
const RECORD_16: u8 = 0xC0;
const NEW: u8 = 1;

/// Operations, in the order of their codes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(dead_code, reason = "made from their numbers")]
#[repr(u8)]
enum Op {
    Load,
    Store,
    Plus,
    Minus,
    Times,
    Over,
    Least,
    Most,
    Root,
    Floor,
    Shift,
    Add,
    Sub,
    Int,
    Abs,
    New,
}

/// What an operation works with.
#[derive(Clone, Copy, Debug)]
enum Operand {
    /// An index of the numbers, and whether the axis is added.
    Number(u8, bool),
    /// A byte offset in the record, and whether the field has 32 bits.
    Field(u8, bool),
    /// The byte itself.
    Byte(u8),
}

/// An operation, its operand, whether that is made a scaled number.
type Step = (Op, Operand, bool);

/// What the chip and its twin start with.
#[derive(Clone, Debug)]
struct Machine {
    acc: u32,
    numbers: [u32; 16],
    record: [u16; 24],
    axis: u8,
}

impl Machine {
    fn value(&self, operand: Operand) -> u32 {
        match operand {
            Operand::Number(..) => self.numbers[self.index(operand)],
            Operand::Field(at, long) => {
                let at = usize::from(at / 2);
                let high = if long { self.record[at + 1] } else { 0 };
                u32::from(high) << 16 | u32::from(self.record[at])
            }
            Operand::Byte(byte) => byte.into(),
        }
    }

    fn index(&self, operand: Operand) -> usize {
        match operand {
            Operand::Number(n, true) => usize::from(n + self.axis),
            Operand::Number(n, false) => usize::from(n),
            _ => unreachable!("only numbers are stored to"),
        }
    }

    /// What a formula means.
    fn play(&mut self, steps: &[Step]) {
        for &(op, operand, new) in steps {
            let acc = Scaled(self.acc);
            let mut value = self.value(operand);
            if new {
                value = Scaled::new(value).0;
            }
            self.acc = match op {
                Op::Load | Op::Int => value,
                Op::Store => {
                    let index = self.index(operand);
                    self.numbers[index] = self.acc;
                    self.acc
                }
                Op::Plus => acc.plus(Scaled(value)).0,
                Op::Minus => acc.minus(Scaled(value)).0,
                Op::Times => acc.times(Scaled(value)).0,
                Op::Over => acc.over(Scaled(value)).0,
                Op::Least => self.acc.min(value),
                Op::Most => self.acc.max(value),
                Op::Root => acc.root().0,
                Op::Floor => acc.floor(),
                Op::Shift => acc.shifted(value as i8 - 64).0,
                Op::Add => self.acc.wrapping_add(value),
                Op::Sub => self.acc.wrapping_sub(value),
                Op::Abs => (self.acc as i32).unsigned_abs(),
                Op::New => Scaled::new(self.acc).0,
            };
        }
    }

    /// The same on the chip.
    fn play_on(&mut self, chip: &mut Chip, steps: &[Step]) {
        for (n, number) in self.numbers.iter().enumerate() {
            chip.board.poke16(NUMBERS + 4 * n as u16, *number as u16);
            chip.board.poke16(NUMBERS + 4 * n as u16 + 2, (*number >> 16) as u16);
        }
        for (n, word) in self.record.iter().enumerate() {
            chip.board.poke16(RECORD + 2 * n as u16, *word);
        }
        // call #formula
        let formula = chip.at("formula");
        chip.board.poke16(CODE, 0x12B0);
        chip.board.poke16(CODE + 2, formula);
        let mut at = CODE + 4;
        for (n, &(op, operand, new)) in steps.iter().enumerate() {
            let word = |n: u8| ((NUMBERS - 0x200) / 2) as u8 + 2 * n;
            let (mode, byte) = match operand {
                Operand::Number(n, by_axis) => (if by_axis { AXIS } else { 0 }, word(n)),
                Operand::Field(at, long) => (if long { RECORD_32 } else { RECORD_16 }, at),
                Operand::Byte(byte) => (0, byte),
            };
            let last = if n + 1 == steps.len() { LAST } else { 0 };
            chip.board.poke8(at, (2 * op as u8) | mode | last | if new { NEW } else { 0 });
            chip.board.poke8(at + 1, byte);
            at += 2;
        }
        // ret
        chip.board.poke16(at, 0x4130);
        let registers = [
            (12, self.acc as u16),
            (13, (self.acc >> 16) as u16),
            (8, 4 * u16::from(self.axis)),
            (9, RECORD),
            (7, 0x7777),
            (10, 0xAAAA),
        ];
        chip.call_at(CODE, "the formula", &registers);
        assert_eq!((chip.reg(7), chip.reg(10)), (0x7777, 0xAAAA), "r7, r10 are kept");
        self.acc = chip.result();
        for (n, number) in self.numbers.iter_mut().enumerate() {
            let at = NUMBERS + 4 * n as u16;
            *number = u32::from(chip.board.peek16(at + 2)) << 16 | u32::from(chip.board.peek16(at));
        }
    }
}

/// A scaled number in the planner's range.
fn scaled() -> impl Strategy<Value = u32> {
    prop_oneof![
        1 => Just(0),
        9 => (0x80_0000u32..0x100_0000, 96u32..170).prop_map(|(m, e)| e << 24 | m),
    ]
}

/// A scaled number in RAM; integers at 8 to 15 are made one first.
fn operand() -> impl Strategy<Value = (Operand, bool)> {
    prop_oneof![
        (0u8..6, any::<bool>()).prop_map(|(n, axis)| (Operand::Number(n, axis), false)),
        (8u8..14, any::<bool>()).prop_map(|(n, axis)| (Operand::Number(n, axis), true)),
        (0u8..22, any::<bool>()).prop_map(|(n, long)| (Operand::Field(2 * n, long), true)),
    ]
}

/// Operations from a scaled accumulator to a scaled one.
fn steps() -> impl Strategy<Value = Vec<Step>> {
    let binary = prop::sample::select(vec![
        Op::Load,
        Op::Plus,
        Op::Minus,
        Op::Times,
        Op::Over,
        Op::Least,
        Op::Most,
    ]);
    let integer = prop_oneof![
        (8u8..14, any::<bool>()).prop_map(|(n, axis)| Operand::Number(n, axis)),
        (0u8..22, any::<bool>()).prop_map(|(n, long)| Operand::Field(2 * n, long)),
    ];
    let nothing = Operand::Byte(0);
    prop_oneof![
        4 => (binary, operand()).prop_map(|(op, (x, new))| vec![(op, x, new)]),
        1 => (0u8..6, any::<bool>()).prop_map(|(n, axis)| vec![(Op::Store, Operand::Number(n, axis), false)]),
        1 => Just(vec![(Op::Root, nothing, false)]),
        1 => (60u8..69).prop_map(|n| vec![(Op::Shift, Operand::Byte(n), false)]),
        1 => (0u8..255).prop_map(|n| vec![(Op::Int, Operand::Byte(n), false), (Op::New, Operand::Byte(0), false)]),
        1 => (prop::sample::select(vec![Op::Add, Op::Sub]), integer).prop_map(move |(op, x)| vec![
            (Op::Floor, nothing, false), (op, x, false), (Op::Abs, nothing, false), (Op::New, nothing, false)]),
    ]
}

fn machine() -> impl Strategy<Value = Machine> {
    let numbers = (prop::array::uniform8(scaled()), any::<[u32; 8]>());
    (scaled(), numbers, any::<[u16; 24]>(), 0u8..3).prop_map(|(acc, (s, i), record, axis)| {
        let mut numbers = [0; 16];
        numbers[..8].copy_from_slice(&s);
        numbers[8..].copy_from_slice(&i);
        Machine { acc, numbers, record, axis }
    })
}

#[test]
fn formulas_mean_what_their_operations_say() {
    let chip = RefCell::new(Chip::new());
    let formulas = prop::collection::vec(steps(), 1..8);
    proptest!(|(formula in formulas, start in machine())| {
        let formula = formula.concat();
        let (mut twin, mut made) = (start.clone(), start);
        twin.play(&formula);
        // Beyond the exponent's byte the two may differ; no planner value comes near.
        let planned = |n: u32| n == 0 || (48..200).contains(&(n >> 24)) && n >> 23 & 1 == 1;
        prop_assume!(planned(twin.acc) && twin.numbers[..8].iter().all(|n| planned(*n)));
        made.play_on(&mut chip.borrow_mut(), &formula);
        prop_assert_eq!(made.acc, twin.acc, "{:?}", formula);
        prop_assert_eq!(made.numbers, twin.numbers, "{:?}", formula);
    });
}
