//! The micro-code machine: generated formulas, run from RAM, against their meaning; jumps and bytes.

use std::cell::RefCell;

use firmware::motion::scaled::Scaled;
use micro::isa::{AXIS, FORMULA, NEW};
use proptest::prelude::*;

use crate::chip::Chip;

/// Numbers that formulas name: 8 scaled ones, then 8 integers.
const NUMBERS: u16 = 0x0240;
/// Where an axis record would lie.
const RECORD: u16 = 0x0280;
/// Where the formula lies.
const CODE: u16 = 0x0300;
const RECORD_32: u8 = micro::isa::RECORD;
const RECORD_16: u8 = RECORD_32 | AXIS;

/// Operations: those of formulas in the order of their codes, then routines and operations of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    Add,
    Sub,
    Root,
    Floor,
    Shift,
    Int,
    Abs,
    New,
}

impl Op {
    /// The symbol of its number in the table, and whether a byte follows; none for a formula's.
    fn in_table(self) -> Option<(&'static str, bool)> {
        match self {
            Op::Root => Some(("DO_root", false)),
            Op::Floor => Some(("DO_floor", false)),
            Op::Shift => Some(("DO_micro_shift", true)),
            Op::Int => Some(("DO_micro_literal", true)),
            Op::Abs => Some(("DO_abs", false)),
            Op::New => Some(("DO_new", false)),
            _ => None,
        }
    }
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
                Op::Shift => acc.shifted(value as i8).0,
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
        let mut code = Vec::new();
        for &(op, operand, new) in steps {
            let word = |n: u8| ((NUMBERS - 0x200) / 2) as u8 + 2 * n;
            let (mode, byte) = match operand {
                Operand::Number(n, by_axis) => (if by_axis { AXIS } else { 0 }, word(n)),
                Operand::Field(at, long) => (if long { RECORD_32 } else { RECORD_16 }, at),
                Operand::Byte(byte) => (0, byte),
            };
            match op.in_table() {
                Some((number, follows)) => {
                    code.push(chip.at(number) as u8);
                    code.extend(follows.then_some(byte));
                }
                None => {
                    let new = if new { NEW } else { 0 };
                    code.extend([FORMULA | op as u8 | mode | new, byte]);
                }
            }
        }
        let registers = [
            (12, self.acc as u16),
            (13, (self.acc >> 16) as u16),
            (8, 4 * u16::from(self.axis)),
            (9, RECORD),
            (7, 0x7777),
            (10, 0xAAAA),
        ];
        run(chip, &code, &registers);
        assert_eq!((chip.reg(7), chip.reg(10)), (0x7777, 0xAAAA), "r7, r10 are kept");
        self.acc = chip.result();
        for (n, number) in self.numbers.iter_mut().enumerate() {
            let at = NUMBERS + 4 * n as u16;
            *number = u32::from(chip.board.peek16(at + 2)) << 16 | u32::from(chip.board.peek16(at));
        }
    }
}

/// Runs micro-code between instructions.
fn run(chip: &mut Chip, code: &[u8], registers: &[(usize, u16)]) {
    // call #micro
    let micro = chip.at("micro");
    chip.board.poke16(CODE, 0x12B0);
    chip.board.poke16(CODE + 2, micro);
    let mut at = CODE + 4;
    for &byte in code.iter().chain(&[chip.at("DO_micro_end") as u8]) {
        chip.board.poke8(at, byte);
        at += 1;
    }
    // ret
    chip.board.poke16((at + 1) & !1, 0x4130);
    chip.call_at(CODE, "the micro-code", registers);
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
        1 => (-4i8..5).prop_map(|n| vec![(Op::Shift, Operand::Byte(n as u8), false)]),
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

#[test]
fn bytes_are_looked_at_and_changed_and_jumps_are_taken() {
    let mut chip = Chip::new();
    let number = |chip: &Chip, name: &str| chip.at(&format!("DO_micro_{name}")) as u8;
    // What stands in PHASE, the test of it, and whether it jumps over the addition.
    for (value, test, operand, jumps) in [
        (0, "if_zero", None, true),
        (3, "if_zero", None, false),
        (3, "if_set", None, true),
        (0, "if_set", None, false),
        (6, "if_any", Some(2), true),
        (5, "if_any", Some(2), false),
        (5, "if_none", Some(2), true),
        (6, "if_none", Some(2), false),
        (9, "if_is", Some(9), true),
        (9, "if_is", Some(8), false),
        (9, "if_is_not", Some(8), true),
        (9, "if_is_not", Some(9), false),
    ] {
        let phase = (chip.at("PHASE") - chip.at("BYTES")) as u8;
        chip.set_byte("PHASE", value);
        let mut code = vec![number(&chip, "literal"), 40, number(&chip, test), phase];
        code.extend(operand);
        code.extend([3, number(&chip, "addi"), 1, number(&chip, "up"), phase]);
        run(&mut chip, &code, &[(10, 0xAAAA)]);
        assert_eq!(chip.reg(12), if jumps { 40 } else { 41 }, "{value} {test} {operand:?}");
        assert_eq!(chip.byte("PHASE"), value + 1);
        assert_eq!(chip.reg(10), 0xAAAA, "r10 is kept");
    }
}

#[test]
fn words_are_read_compared_and_changed() {
    let mut chip = Chip::new();
    let [literal, profile] = ["DO_micro_word", "DO_micro_profile"].map(|name| chip.at(name) as u8);
    let formula = |op: u8, mode: u8, operand: u8| [FORMULA | mode | op, operand];
    let at = ((NUMBERS - 0x200) / 2) as u8;
    // In the order of their codes, behind those of formulas.
    let [word, put, cmp, clear, base] =
        [0, 1, 2, 3, 4].map(|op| formula(Op::Sub as u8 + 1 + op, 0, at));
    let fill = |chip: &mut Chip, value: u16| {
        chip.board.poke16(NUMBERS, value);
        chip.board.poke16(NUMBERS + 2, 0x5555);
    };
    let high = (13, 0x3333);
    let (zero, negative, carry) = (2, 4, 1);

    for (value, flags) in [(0, zero), (0x8000, negative), (0x1234, 0)] {
        fill(&mut chip, value);
        run(&mut chip, &word, &[high]);
        assert_eq!((chip.reg(12), chip.reg(13)), (value, 0x3333), "r13 is kept");
        assert_eq!(chip.reg(2) & (zero | negative), flags, "{value:x}");
    }
    run(&mut chip, &[literal, 0x34, 0x12], &[high]);
    assert_eq!((chip.reg(12), chip.reg(13)), (0x1234, 0x3333), "r13 is kept");

    fill(&mut chip, 1);
    run(&mut chip, &put, &[(12, 0xABCD), high]);
    assert_eq!((chip.board.peek16(NUMBERS), chip.board.peek16(NUMBERS + 2)), (0xABCD, 0x5555));
    run(&mut chip, &clear, &[]);
    assert_eq!((chip.board.peek16(NUMBERS), chip.board.peek16(NUMBERS + 2)), (0, 0x5555));

    for (value, flags) in [(0xABCD, zero | carry), (0xABCE, carry), (0xABCC, negative)] {
        fill(&mut chip, 0xABCD);
        run(&mut chip, &cmp, &[(12, value)]);
        assert_eq!((chip.reg(12), chip.reg(2) & 7), (value, flags));
    }

    // By way of a pointer: a field behind it, and the board's profile.
    fill(&mut chip, RECORD);
    chip.set_word("BOARD", RECORD);
    chip.board.poke16(RECORD + 6, 0x8765);
    let field = formula(Op::Sub as u8 + 1, RECORD_16, 6);
    run(&mut chip, &[base, field].concat(), &[]);
    assert_eq!((chip.reg(9), chip.reg(12)), (RECORD, 0x8765));
    run(&mut chip, &[profile, 7], &[high]);
    assert_eq!((chip.reg(12), chip.reg(13), chip.reg(2) & zero), (0x87, 0x3333, 0));
}

#[test]
fn flags_decide_behind_the_operation_that_makes_them() {
    let mut chip = Chip::new();
    let number = |chip: &Chip, name: &str| chip.at(&format!("DO_micro_{name}")) as u8;
    for (value, limit, test, jumps) in [
        (7, 7, "if_equal", true),
        (8, 7, "if_equal", false),
        (8, 7, "if_not_equal", true),
        (7, 7, "if_not_equal", false),
        (7, 7, "if_carry", true),
        (6, 7, "if_carry", false),
        (6, 7, "if_negative", true),
        (7, 7, "if_negative", false),
        (7, 7, "if_not_negative", true),
        (6, 7, "if_not_negative", false),
    ] {
        let mut code = vec![number(&chip, "literal"), value, number(&chip, "cmpi"), limit];
        // Backward over the way out: a loop of one round.
        code.extend([
            number(&chip, "goto"),
            5,
            number(&chip, "literal"),
            99,
            number(&chip, "goto"),
            3,
        ]);
        code.extend([number(&chip, test), (-5i8) as u8]);
        run(&mut chip, &code, &[]);
        assert_eq!(chip.reg(12), if jumps { 99 } else { value.into() }, "{value} {limit} {test}");
    }
}

#[test]
fn numbers_are_taken_from_the_stack_within_bounds_or_end_the_routine() {
    let mut chip = Chip::new();
    let codes = ["DO_pop_number", "DO_micro_addi"].map(|name| chip.at(name));
    let [pop_number, addi] = codes.map(|code| code as u8);
    let range = 0x100 + u16::from(lang::fault::Fault::ValueRange.number());
    for (value, result) in [
        (0u32, range),
        (32, range),
        (33, 133),
        (125, 225),
        (126, range),
        (0x1_0021, range),
        (-1i32 as u32, range),
    ] {
        chip.set_long("VM_TOP", 0, value);
        let end = chip.at("POOL_END");
        chip.set_word("VM_SP", end - 8);
        run(&mut chip, &[pop_number, 33, 125, addi, 100], &[(10, 0xAAAA)]);
        assert_eq!(chip.reg(12), result, "{value:x}");
        assert_eq!(chip.reg(10), 0xAAAA, "r10 is kept");
        assert_eq!(chip.word("VM_SP"), end - 4, "it is taken");
    }
}
