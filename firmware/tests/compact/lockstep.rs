//! The interpreter of micro-code beside the chip: the same operation, the same routine, from the same state.

use emulator::{Rng, Stop, TICKS_PER_SECOND};
use firmware::motion::scaled::Scaled;
use lang::isa::{Op, Operands, ROWS};
use micro::decode::Code;
use micro::image::{By, entries};
use micro::isa::{self, CALLED, FORMULAS, Formula, Gives, OWN, Operand, Own, ROUTINES, Takes};
use micro::run::{Called, End, Flags, Registers, World, run};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};

use crate::chip::{BACK, Chip, STACK};
use crate::machine::{install, mill};
use crate::verify::Elf;

/// Where a routine of instructions returns to that micro-code has called.
const BACK_IN: u16 = BACK - 2;
/// Where the tried operation stands, in flash.
const CODE: u16 = crate::area::AREA;
/// Where a statement's operands stand.
const OPERANDS: u16 = CODE + 0x1C0;
/// RAM that is compared: below the machine stack.
const RAM: std::ops::Range<u16> = 0x0200..0x03B8;

/// A chip whose micro-code the interpreter runs; instructions run on the chip.
pub struct OnChip {
    /// The chip.
    pub chip: Chip,
    /// Its image.
    pub elf: Elf,
    /// Whether scaled numbers are the chip's work, too; else they are the twin's.
    counts: bool,
}

fn bits(flags: Flags) -> u16 {
    let bit = |flag: Option<bool>, value| if flag == Some(true) { value } else { 0 };
    bit(flags.c, 1) | bit(flags.z, 2) | bit(flags.n, 4) | bit(flags.v, 0x100)
}

fn flags(status: u16) -> Flags {
    Flags::of(status & 2 != 0, status & 4 != 0, status & 1 != 0, status & 0x100 != 0)
}

/// What of `known` differs from what the chip has.
fn same(known: Flags, chip: u16) -> bool {
    let chip = flags(chip);
    let agrees = |known: Option<bool>, chip| known.is_none() || known == chip;
    agrees(known.z, chip.z)
        && agrees(known.n, chip.n)
        && agrees(known.c, chip.c)
        && agrees(known.v, chip.v)
}

impl Code for OnChip {
    fn byte(&self, at: u16) -> u8 {
        self.chip.board.peek8(at)
    }
    fn symbol(&self, name: &str) -> Option<u16> {
        self.chip.board.symbol(name)
    }
    fn places_end(&self, at: u16) -> Option<u16> {
        self.elf.places_end(at)
    }
}

impl World for OnChip {
    fn set_byte(&mut self, at: u16, value: u8) {
        self.chip.board.poke8(at, value);
    }

    fn call(&mut self, routine: u16, behind: u16, registers: &mut Registers) -> Called {
        let board = &mut self.chip.board;
        let acc = registers.acc;
        let known = [(12, acc as u16), (13, (acc >> 16) as u16), (8, registers.axis)];
        // The machine has just looked whether the address is odd; behind END flags are those of before.
        let entered = if routine == behind { bits(registers.flags) } else { 2 };
        // r15: where the machine keeps the flags of before; what ends its caller gives them back.
        let before = bits(registers.flags);
        let more = [(9, registers.record), (10, behind), (2, entered), (15, before)];
        let known = known.into_iter().chain(more);
        for (n, value) in known {
            board.set_reg(n, value);
        }
        // As the machine leaves it: back to it, the caller's r10, the caller's own way back.
        for (below, word) in [(6, BACK_IN), (4, 0x5555), (2, BACK)] {
            board.poke16(STACK - below, word);
        }
        board.set_reg(1, STACK - 6);
        board.set_reg(0, routine);
        board.set_breakpoint(BACK_IN);
        let stop = board.run_until(board.cycles() + TICKS_PER_SECOND);
        *registers = registers_of(&self.chip);
        match stop {
            Stop::Breakpoint(at) if at == u32::from(BACK_IN) => Called::On(self.chip.reg(10)),
            Stop::Breakpoint(at) if at == u32::from(BACK) => Called::Ended,
            stop => panic!("{routine:04x}: {stop:?}"),
        }
    }

    fn scaled(&mut self, op: Formula, acc: u32, x: u32) -> u32 {
        if self.counts {
            return self.count(FORMULAS[op as usize].label, acc, x);
        }
        let (a, b) = (Scaled(acc), Scaled(x));
        match op {
            Formula::Plus => a.plus(b).0,
            Formula::Minus => a.minus(b).0,
            Formula::Times => a.times(b).0,
            Formula::Over => a.over(b).0,
            Formula::Least => a.least(b).0,
            _ => a.most(b).0,
        }
    }

    fn new_scaled(&mut self, value: u32) -> u32 {
        if self.counts { self.count("pasapas_scaled_new", value, 0) } else { Scaled::new(value).0 }
    }
}

impl OnChip {
    /// With a copy of a chip.
    pub fn of(chip: &Chip, elf: &Elf, counts: bool) -> OnChip {
        OnChip { chip: chip.clone(), elf: elf.clone(), counts }
    }

    /// The chip's own arithmetic, which says something of numbers that are not scaled, too.
    fn count(&mut self, routine: &str, acc: u32, x: u32) -> u32 {
        let words = [acc, acc >> 16, x, x >> 16].map(|word| word as u16);
        for (n, word) in (12..).zip(words) {
            self.chip.board.set_reg(n, word);
        }
        let at = self.chip.at(routine);
        self.chip.board.poke16(STACK - 2, BACK);
        self.chip.board.set_reg(1, STACK - 2);
        self.chip.board.set_reg(0, at);
        let stop = self.chip.board.run_until(self.chip.board.cycles() + TICKS_PER_SECOND);
        assert_eq!(stop, Stop::Breakpoint(BACK.into()), "{routine}");
        self.chip.result()
    }
}

fn registers_of(chip: &Chip) -> Registers {
    Registers {
        acc: chip.result(),
        axis: chip.reg(8),
        record: chip.reg(9),
        flags: flags(chip.reg(2)),
    }
}

/// A state: RAM, accumulator, axis, flags.
#[derive(Clone, Debug)]
struct Start {
    /// What RAM is made of; words in front of it by themselves.
    seed: u64,
    words: Vec<u32>,
    acc: u32,
    axis: u16,
    status: u16,
}

fn start() -> impl Strategy<Value = Start> {
    let acc = prop_oneof![any::<u32>(), 0u32..300, scaled()];
    (any::<u64>(), acc, 0u16..3, 0u16..16).prop_map(|(seed, acc, axis, status)| Start {
        seed,
        words: Vec::new(),
        acc,
        axis: 4 * axis,
        status: status & 7 | (status & 8) << 5,
    })
}

/// A scaled number in the planner's range.
fn scaled() -> impl Strategy<Value = u32> {
    (0x80_0000u32..0x100_0000, 96u32..160).prop_map(|(mantissa, e)| e << 24 | mantissa)
}

impl Start {
    /// Puts it into a chip with a machine's record.
    fn put(&self, chip: &mut Chip) -> Registers {
        let mut random = Rng::new(self.seed);
        for at in RAM {
            chip.board.poke8(at, random.bits() as u8);
        }
        let words = self.words.iter().flat_map(|word| word.to_le_bytes());
        for (at, byte) in RAM.zip(words) {
            chip.board.poke8(at, byte);
        }
        install(chip, &mill());
        chip.set_word("BOARD", crate::rig::PROFILE);
        let record = chip.word("VM_CODE").wrapping_sub(64);
        for (n, value) in [(8, self.axis), (9, record), (12, self.acc as u16)] {
            chip.board.set_reg(n, value);
        }
        chip.board.set_reg(13, (self.acc >> 16) as u16);
        Registers { acc: self.acc, axis: self.axis, record, flags: flags(self.status) }
    }
}

/// Both after the same: RAM and registers.
fn agree(on_chip: &Chip, run: &OnChip, registers: &Registers, what: &str) {
    for at in RAM {
        let (a, b) = (on_chip.board.peek8(at), run.chip.board.peek8(at));
        assert_eq!(a, b, "{what}: the byte at {at:04x}");
    }
    let there = registers_of(on_chip);
    let known = |r: &Registers| (r.acc, r.axis, r.record);
    assert_eq!(known(&there), known(registers), "{what}: r13:r12, r8, r9");
    let status = on_chip.reg(2);
    assert!(same(registers.flags, status), "{what}: {:?}, but {status:x}", registers.flags);
}

/// `mov #status, r2; call #micro`, the operation, END, then r7 tells which way was taken.
fn place(code: &[u8], jump: Option<usize>, status: u16, chip: &mut Chip) {
    let micro = chip.at("micro");
    let mut bytes = Vec::new();
    for word in [0x4032, status, 0x12B0, micro] {
        bytes.extend(u16::to_le_bytes(word));
    }
    let first = bytes.len();
    bytes.extend(code);
    let end = chip.at("DO_micro_end") as u8;
    for way in [1, 2] {
        if let Some(offset) = jump.filter(|_| way == 2) {
            bytes[first + offset] = (bytes.len() - first - offset) as u8;
        }
        bytes.push(end);
        bytes.resize(bytes.len().next_multiple_of(2), 0);
        for word in [0x4037, way, 0x4130] {
            bytes.extend(u16::to_le_bytes(word));
        }
    }
    for (at, byte) in (CODE..).zip(bytes) {
        chip.board.poke8(at, byte);
    }
}

/// Runs one operation on the chip and in the interpreter.
fn compare(base: &OnChip, start: &Start, code: &[u8], jump: Option<usize>, what: &str) {
    let mut there = base.chip.clone();
    let mut here = OnChip::of(&base.chip, &base.elf, false);
    start.put(&mut there);
    let mut registers = start.put(&mut here.chip);
    place(code, jump, start.status, &mut there);
    place(code, jump, start.status, &mut here.chip);
    there.board.set_reg(7, 0u16);
    there.call_at(CODE, what, &[]);
    let end =
        run(&mut here, CODE + 8, &mut registers).unwrap_or_else(|trap| panic!("{what}: {trap}"));
    let way = match end {
        End::Returned => 0,
        End::Instructions(at) => here.word(at + 2),
    };
    assert_eq!(there.reg(7), way, "{what}: which way is taken");
    agree(&there, &here, &registers, what);
}

fn base() -> OnChip {
    OnChip { chip: Chip::new(), elf: Elf::of("whole"), counts: false }
}

/// A runner of so many cases, that keeps no file.
pub fn runner(cases: u32) -> TestRunner {
    TestRunner::new(Config { cases, failure_persistence: None, ..Config::default() })
}

#[test]
fn each_operation_of_the_machine_means_what_the_interpreter_says() {
    let base = base();
    for (n, &own) in Own::ALL.iter().enumerate() {
        if matches!(own, Own::Call | Own::End | Own::Switch) {
            continue;
        }
        let row = &OWN[n];
        let numbers = (start(), any::<[u8; 3]>(), 0u8..2);
        let result = runner(40).run(&numbers, |(start, operands, near)| {
            let mut code = vec![(ROUTINES.len() + n) as u8];
            for (operand, mut value) in row.operands.iter().zip(operands) {
                match operand {
                    // Of the board's profile, which has no more.
                    Operand::Number if own == Own::Profile => value %= 64,
                    // Often the accumulator's own byte, so that comparisons are equal.
                    Operand::Number if near == 1 => value = start.acc as u8,
                    // No byte of the stack, and BOARD stays.
                    Operand::Byte => value %= 100,
                    Operand::Word => code.push(value),
                    _ => {}
                }
                code.push(value);
            }
            let jump = (row.operands.last() == Some(&Operand::Jump)).then(|| code.len() - 1);
            compare(&base, &start, &code, jump, row.name);
            Ok(())
        });
        result.unwrap_or_else(|error| panic!("{}: {error}", row.name));
    }
}

#[test]
fn each_formula_means_what_the_interpreter_says() {
    let base = base();
    let kind = (0u8..16, 0u8..8);
    for (n, row) in FORMULAS.iter().enumerate() {
        let scaled = row.label.starts_with("pasapas") || row.name == "bound";
        let values = (start(), kind.clone(), scaled_ram(), any::<u32>(), self::scaled());
        let result = runner(60).run(&values, |(mut start, (word, mode), numbers, whole, acc)| {
            let [record, axis, new] = [4, 2, 1].map(|bit| mode & bit != 0);
            let mut mode = if record { isa::RECORD } else { 0 } | if axis { isa::AXIS } else { 0 };
            if new && Formula::ALL[n].takes_new() {
                mode |= isa::NEW;
            }
            // Words of RAM hold scaled numbers where those are taken, integers where they are made ones.
            let integers = mode & isa::NEW != 0 || !scaled;
            let number = |number| if integers { number ^ whole } else { number };
            start.words = numbers.into_iter().map(number).collect();
            start.acc = if scaled { acc } else { start.acc };
            if record && (Formula::ALL[n].writes() || scaled && !integers) {
                return Ok(());
            }
            let code = [isa::FORMULA | mode | n as u8, 2 * word];
            compare(&base, &start, &code, None, row.name);
            Ok(())
        });
        result.unwrap_or_else(|error| panic!("{}: {error}", row.name));
    }
}

fn scaled_ram() -> impl Strategy<Value = Vec<u32>> {
    prop::collection::vec(scaled(), 64)
}

#[test]
fn routines_leave_in_the_interpreter_what_they_leave_on_the_chip() {
    let base = base();
    let mut found = entries(&base);
    found.retain(|entry| !matches!(entry.by, By::Instructions));
    assert!(found.len() > 80, "only {} routines", found.len());
    let enter = base.chip.at("micro_enter");
    for entry in found {
        let name = match entry.by {
            By::Row(row) => row.name.to_owned(),
            by => format!("{by:?} {:04x}", entry.at),
        };
        let result = runner(12).run(&(start(), any::<[u8; 3]>(), 0u16..4), |(start, bytes, n)| {
            let low = match entry.by {
                By::Row(row) if row.sets.contains('a') || row.name == "home_by_profile" => n,
                By::Effect(first, last) | By::Line(first, last) => {
                    u16::from(last.saturating_sub(bytes[0] % 3).max(first))
                }
                By::Register => 0,
                By::Row(_) => start.acc as u16,
                By::Instructions => 0,
            };
            let mut there = base.chip.clone();
            let mut here = OnChip::of(&base.chip, &base.elf, true);
            for chip in [&mut there, &mut here.chip] {
                start.put(chip);
                settle(chip, low, bytes);
            }
            let acc = start.acc & 0xFFFF_0000 | u32::from(low);
            // Statements may begin at even places.
            there.call_at(enter, &name, &[(11, entry.at), (12, low), (5, 0x0300)]);
            here.chip.board.set_reg(5, 0x0300u16);
            let mut registers = registers_of(&here.chip);
            (registers.acc, registers.flags) = (acc, Flags::of(false, false, false, false));
            let end = run(&mut here, entry.at, &mut registers);
            match end.unwrap_or_else(|trap| panic!("{name}: {trap}")) {
                End::Returned => {}
                End::Instructions(at) => {
                    here.call(at, at, &mut registers);
                }
            }
            agree(&there, &here, &registers, &name);
            Ok(())
        });
        result.unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}

/// What of a random RAM would lead instructions astray: pointers, and a motion that never ends.
fn settle(chip: &mut Chip, code: u16, bytes: [u8; 3]) {
    let row = ROWS.iter().find(|row| (0..row.count).any(|n| u16::from(row.code + n) == code));
    let axis = row.is_none_or(|row| row.operands == Operands::Axis);
    // The small chip takes the codes behind, which none of its programs has, for it.
    let reads = (Op::Read as u8..=Op::ArcBy as u8).map(u16::from).any(|own| own == code);
    for (at, byte) in (OPERANDS..).zip(bytes) {
        // Flags, or what is looked at, have an axis in their low bits.
        let flags = if reads { (byte % 10) << 2 } else { byte & 0x7C };
        chip.board.poke8(at, if axis { 0 } else { flags } | (byte % 3));
    }
    let code = chip.word("VM_CODE");
    let end = chip.at("POOL_END");
    for (name, value) in [
        ("VM_PC", OPERANDS),
        ("VM_DATA", code),
        ("VM_SP", end - 24),
        ("VM_BASE", end),
        ("VM_CALLS", chip.at("POOL")),
        ("VM_CELLS", chip.at("POOL") + 16),
        ("OPEN", 0),
        ("TRACE_NUMBER", 0),
    ] {
        chip.set_word(name, value);
    }
    // COURSE_AT.
    chip.board.poke16(end - 4, code);
    chip.set_byte("PHASE", bytes[1] % 8);
    chip.set_byte("MOVING", if bytes[2] & 1 == 0 { 0 } else { bytes[2] >> 1 & 7 });
    chip.set_byte("N", bytes[0] % 3);
    chip.set_byte("PRINT_READY", bytes[2] % 16);
    chip.set_byte("PRINT_OPEN", 0);
}

#[test]
fn routines_of_instructions_keep_what_their_rows_say() {
    let base = base();
    let rows = ROUTINES.iter().chain(CALLED).filter(|row| !row.operands.contains(&Operand::Pairs));
    let mut count = 0;
    for row in rows {
        let Some(at) = base.symbol(row.label).filter(|at| at & 1 == 0) else { continue };
        if row.gives == Gives::Lost && row.loses == "ar" {
            continue;
        }
        count += 1;
        let result =
            runner(12).run(&(start(), any::<[u8; 3]>(), any::<u32>()), |(start, bytes, other)| {
                let call = |acc: u32| {
                    let mut here = OnChip::of(&base.chip, &base.elf, true);
                    let mut registers = start.put(&mut here.chip);
                    settle(&mut here.chip, 0, bytes);
                    let axis = row.sets.contains('a') || row.name.starts_with("reference");
                    registers.acc = if axis { acc & 0xFFFF_0001 } else { acc };
                    let before = registers;
                    let called = here.call(at, OPERANDS, &mut registers);
                    (before, registers, called)
                };
                let (before, after, called) = call(start.acc);
                if called == Called::Ended {
                    prop_assert!(row.ends_caller, "ends its caller");
                    return Ok(());
                }
                let high = |r: &Registers| r.acc >> 16;
                match row.gives {
                    Gives::Kept => prop_assert_eq!(after.acc, before.acc),
                    Gives::Low => prop_assert_eq!(high(&after), high(&before)),
                    _ => {}
                }
                let keeps = |letter| !row.loses.contains(letter) && !row.sets.contains(letter);
                prop_assert!(after.axis == before.axis || !keeps('a'), "r8 is kept");
                prop_assert!(after.record == before.record || !keeps('r'), "r9 is kept");
                // What is not taken makes no difference.
                let mask = match row.takes {
                    Takes::Nothing => u32::MAX,
                    Takes::Low => 0xFFFF_0000,
                    Takes::Long => 0,
                };
                let (_, also, _) = call(start.acc & !mask | other & mask);
                match row.gives {
                    Gives::Low | Gives::Only => prop_assert_eq!(also.acc as u16, after.acc as u16),
                    Gives::Long => prop_assert_eq!(also.acc, after.acc),
                    _ => {}
                }
                for letter in row.flags.chars() {
                    let flag = |r: &Registers| if letter == 'Z' { r.flags.z } else { r.flags.c };
                    prop_assert_eq!(flag(&also), flag(&after), "{}", letter);
                }
                Ok(())
            });
        result.unwrap_or_else(|error| panic!("{}: {error}", row.name));
    }
    assert!(count > 50, "only {count} routines");
}
