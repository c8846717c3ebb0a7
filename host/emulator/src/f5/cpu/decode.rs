//! Instruction words of the MSP430X to decoded operations (SLAU208, chapter 6).

use super::{cycles, extended};
use crate::cpu::decode::{CONDITIONS, Condition, DOUBLE, Kind, SINGLE};

/// What an instruction does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Act {
    /// An instruction of the MSP430, with or without extension word.
    Core(Kind),
    /// 20-bit move.
    Mova,
    /// 20-bit compare.
    Cmpa,
    /// 20-bit add.
    Adda,
    /// 20-bit subtract.
    Suba,
    /// Rotate right through carry, `repeat` times.
    Rrcm,
    /// Arithmetic shift right, `repeat` times.
    Rram,
    /// Arithmetic shift left, `repeat` times.
    Rlam,
    /// Unsigned shift right, `repeat` times.
    Rrum,
    /// Call of a 20-bit address.
    Calla,
    /// Push `repeat` registers downwards from the source.
    Pushm,
    /// Pop `repeat` registers upwards from the source.
    Popm,
    /// An encoding that TI reserves.
    Reserved,
}

/// Width of an operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// `.B`
    Byte,
    /// `.W`
    Word,
    /// `.A`, 20 bits.
    Address,
}

/// A source operand. The program counter as a base is resolved at decoding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Src {
    /// Register.
    Reg(u8),
    /// From a constant generator, or the program counter read as a register.
    Constant(u32),
    /// `#N`
    Immediate(u32),
    /// `X(Rn)`; `near` sums wrap in the low 64 KB when the register points there.
    Indexed { reg: u8, near: bool, x: u32 },
    /// `ADDR`
    Symbolic(u32),
    /// `&ADDR`
    Absolute(u32),
    /// `@Rn`
    Indirect(u8),
    /// `@PC`: the word after the instruction word.
    NextWord(u32),
    /// `@Rn+`
    Increment(u8),
}

/// A destination operand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dst {
    /// Register.
    Reg(u8),
    /// `X(Rn)`, as a source.
    Indexed { reg: u8, near: bool, x: u32 },
    /// `ADDR`
    Symbolic(u32),
    /// `&ADDR`
    Absolute(u32),
}

/// How often a register operation is executed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Repeat {
    /// A number, 1 to 16.
    Times(u8),
    /// Low four bits of a register, plus one.
    Register(u8),
}

/// One decoded instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Op {
    /// What it does.
    pub act: Act,
    /// Width.
    pub size: Size,
    /// Words that it occupies, 1 to 4; 0 marks an empty cache entry.
    pub words: u8,
    /// Cycles that it takes when it is executed once.
    pub cycles: u8,
    /// Repetitions, or registers of PUSHM and POPM.
    pub repeat: Repeat,
    /// Carry is taken as 0 (RRUX).
    pub zero_carry: bool,
    /// Condition of a jump.
    pub condition: Condition,
    /// Erratum CPU40: the word behind this jump makes the program counter go wrong.
    pub cpu40: bool,
    /// Source, or the only operand.
    pub src: Src,
    /// Destination of two-operand instructions.
    pub dst: Dst,
}

impl Op {
    /// An empty cache entry.
    pub const NONE: Op = Op {
        act: Act::Reserved,
        size: Size::Word,
        words: 0,
        cycles: 1,
        repeat: Repeat::Times(1),
        zero_carry: false,
        condition: Condition::Always,
        cpu40: false,
        src: Src::Constant(0),
        dst: Dst::Reg(3),
    };

    /// What stands for a reserved encoding of one word.
    pub(super) const RESERVED: Op = Op { words: 1, ..Op::NONE };
}

/// 20 bits of an address.
pub const ADDRESS: u32 = 0xF_FFFF;

/// A 16-bit index as a 20-bit number.
pub fn signed(x: u16) -> u32 {
    i32::from(x.cast_signed()).cast_unsigned() & ADDRESS
}

/// Reads the words of an instruction one after the other.
pub struct Words<F> {
    /// Address of the next word.
    pub at: u32,
    fetch: F,
}

impl<F: FnMut(u32) -> u16> Words<F> {
    /// The next word and its address.
    pub fn next(&mut self) -> (u32, u16) {
        let here = self.at;
        self.at = (here + 2) & ADDRESS;
        (here, (self.fetch)(here))
    }
}

/// Decodes the instruction at `pc`; `fetch` reads a code word.
pub fn decode(pc: u32, fetch: impl FnMut(u32) -> u16) -> Op {
    let mut words = Words { at: pc, fetch };
    let (_, word) = words.next();
    let mut op = match word >> 12 {
        0 => address(word, &mut words),
        1 if word >= 0x1800 => extended::decode(word, &mut words),
        1 if word >= 0x1400 => multiple(word),
        1 if word > 0x1300 => calla(word, &mut words),
        1 => single(word, &mut words),
        2 | 3 => jump(word, &mut words),
        _ => double(word, &mut words),
    };
    if op.act != Act::Reserved && !matches!(op.act, Act::Core(Kind::Jump)) {
        op.words = ((words.at.wrapping_sub(pc) & ADDRESS) / 2) as u8;
    }
    op
}

fn double<F: FnMut(u32) -> u16>(word: u16, words: &mut Words<F>) -> Op {
    let kind = DOUBLE[usize::from((word >> 12) - 4)];
    let size = if word & 0x40 != 0 { Size::Byte } else { Size::Word };
    let src = source((word >> 8 & 15) as u8, word >> 4 & 3, words);
    let dst = destination((word & 15) as u8, word & 0x80 != 0, words);
    Op { act: Act::Core(kind), size, cycles: cycles::double(kind, src, dst), src, dst, ..Op::NONE }
}

fn single<F: FnMut(u32) -> u16>(word: u16, words: &mut Words<F>) -> Op {
    let kind = SINGLE[usize::from(word >> 7 & 7)];
    let byte = word & 0x40 != 0;
    // The byte bit has no meaning for these; no assembler makes it.
    let undefined = byte && matches!(kind, Kind::Swpb | Kind::Sxt | Kind::Call | Kind::Reti);
    if kind == Kind::Illegal || undefined {
        return Op::RESERVED;
    }
    let act = Act::Core(kind);
    if kind == Kind::Reti {
        return Op { act, cycles: cycles::single(kind, Src::Constant(0)), ..Op::NONE };
    }
    let size = if byte { Size::Byte } else { Size::Word };
    let src = source((word & 15) as u8, word >> 4 & 3, words);
    Op { act, size, cycles: cycles::single(kind, src), src, ..Op::NONE }
}

fn jump<F: FnMut(u32) -> u16>(word: u16, words: &mut Words<F>) -> Op {
    // Ten bits, two's complement, in words.
    let offset = signed(((word << 6).cast_signed() >> 5).cast_unsigned());
    let target = (words.at + offset) & ADDRESS;
    let (_, behind) = words.next();
    Op {
        act: Act::Core(Kind::Jump),
        words: 1,
        cycles: crate::cpu::cycles::JUMP,
        src: Src::Constant(target),
        condition: CONDITIONS[usize::from(word >> 10 & 7)],
        cpu40: matches!(behind & 0xF0FF, 0x0040 | 0x0050),
        ..Op::NONE
    }
}

/// Group 0xxx: MOVA, CMPA, ADDA, SUBA, and RRCM, RRAM, RLAM, RRUM.
fn address<F: FnMut(u32) -> u16>(word: u16, words: &mut Words<F>) -> Op {
    let (first, last) = ((word >> 8 & 15) as u8, (word & 15) as u8);
    let high = |bits: u8| u32::from(bits) << 16;
    let code = word >> 4 & 15;
    if matches!(code, 4 | 5) {
        let act = [Act::Rrcm, Act::Rram, Act::Rlam, Act::Rrum][usize::from(word >> 8 & 3)];
        let n = (word >> 10 & 3) as u8 + 1;
        let size = if code == 4 { Size::Address } else { Size::Word };
        let (src, dst) = (Src::Reg(last), Dst::Reg(last));
        return Op { act, size, cycles: n, repeat: Repeat::Times(n), src, dst, ..Op::NONE };
    }
    let register = |reg: u8, at: u32| if reg == 0 { Src::Constant(at) } else { Src::Reg(reg) };
    let (act, src, dst) = match code {
        // Erratum CPU22: what the program counter does here nobody can tell. A word 0 is such a one.
        0 | 1 if first == 0 => return Op::RESERVED,
        0 => (Act::Mova, Src::Indirect(first), Dst::Reg(last)),
        1 => (Act::Mova, Src::Increment(first), Dst::Reg(last)),
        2 => {
            let low = u32::from(words.next().1);
            (Act::Mova, Src::Absolute(high(first) | low), Dst::Reg(last))
        }
        3 => {
            let (here, x) = words.next();
            let src = match first {
                0 => Src::Symbolic((here + signed(x)) & ADDRESS),
                _ => Src::Indexed { reg: first, near: false, x: signed(x) },
            };
            (Act::Mova, src, Dst::Reg(last))
        }
        6 => {
            let low = u32::from(words.next().1);
            (Act::Mova, register(first, words.at), Dst::Absolute(high(last) | low))
        }
        7 => {
            let (here, x) = words.next();
            let dst = match last {
                0 => Dst::Symbolic((here + signed(x)) & ADDRESS),
                _ => Dst::Indexed { reg: last, near: false, x: signed(x) },
            };
            (Act::Mova, register(first, words.at), dst)
        }
        _ => {
            let act = [Act::Mova, Act::Cmpa, Act::Adda, Act::Suba][usize::from(code & 3)];
            let src = if code < 12 {
                Src::Immediate(high(first) | u32::from(words.next().1))
            } else {
                register(first, words.at)
            };
            (act, src, Dst::Reg(last))
        }
    };
    Op { act, size: Size::Address, cycles: cycles::address(act, src, dst), src, dst, ..Op::NONE }
}

fn indirect(reg: u8, next: u32) -> Src {
    if reg == 0 { Src::NextWord(next) } else { Src::Indirect(reg) }
}

/// Group 13xx behind RETI: CALLA.
fn calla<F: FnMut(u32) -> u16>(word: u16, words: &mut Words<F>) -> Op {
    let reg = (word & 15) as u8;
    let high = u32::from(word & 15) << 16;
    let src = match word >> 4 & 15 {
        4 if reg == 0 => Src::Constant(words.at),
        4 => Src::Reg(reg),
        5 => {
            let (here, x) = words.next();
            match reg {
                0 => Src::Symbolic((here + signed(x)) & ADDRESS),
                _ => Src::Indexed { reg, near: false, x: signed(x) },
            }
        }
        6 if reg != 0 => Src::Indirect(reg),
        7 if reg != 0 => Src::Increment(reg),
        8 => Src::Absolute(high | u32::from(words.next().1)),
        9 => {
            let (here, x) = words.next();
            Src::Symbolic((here + (high | u32::from(x))) & ADDRESS)
        }
        11 => Src::Immediate(high | u32::from(words.next().1)),
        _ => return Op::RESERVED,
    };
    let cycles = cycles::calla(src, reg == 1);
    Op { act: Act::Calla, size: Size::Address, cycles, src, ..Op::NONE }
}

/// Groups 14xx to 17xx: PUSHM and POPM.
fn multiple(word: u16) -> Op {
    let n = (word >> 4 & 15) as u8 + 1;
    let reg = (word & 15) as u8;
    let size = if word & 0x100 != 0 { Size::Word } else { Size::Address };
    let (act, fits) =
        if word & 0x200 != 0 { (Act::Popm, reg + n <= 16) } else { (Act::Pushm, reg + 1 >= n) };
    if !fits {
        return Op::RESERVED;
    }
    let cycles = cycles::multiple(size, n);
    Op { act, size, cycles, repeat: Repeat::Times(n), src: Src::Reg(reg), ..Op::NONE }
}

/// Source of an instruction without extension word.
fn source<F: FnMut(u32) -> u16>(reg: u8, mode: u16, words: &mut Words<F>) -> Src {
    if let Some(value) = constant(reg, mode) {
        return Src::Constant(value);
    }
    match (mode, reg) {
        (0, 0) => Src::Constant(words.at),
        (0, _) => Src::Reg(reg),
        (1, 0) => {
            let (here, x) = words.next();
            Src::Symbolic(near(here, x))
        }
        (1, 2) => Src::Absolute(u32::from(words.next().1)),
        (1, _) => Src::Indexed { reg, near: true, x: signed(words.next().1) },
        (2, _) => indirect(reg, words.at),
        (_, 0) => Src::Immediate(u32::from(words.next().1)),
        _ => Src::Increment(reg),
    }
}

/// What a constant generator gives (SLAU208, table "Values of Constant Generators"), in all bits.
pub fn constant(reg: u8, mode: u16) -> Option<u32> {
    match (mode, reg) {
        (2, 2) => Some(4),
        (3, 2) => Some(8),
        (0, 3) => Some(0),
        (1, 3) => Some(1),
        (2, 3) => Some(2),
        (3, 3) => Some(ADDRESS),
        _ => None,
    }
}

/// `base + x` as instructions without extension word add: below 64 KB it stays there.
pub fn near(base: u32, x: u16) -> u32 {
    let sum = base + signed(x);
    if base <= 0xFFFF { sum & 0xFFFF } else { sum & ADDRESS }
}

/// Destination of an instruction without extension word.
fn destination<F: FnMut(u32) -> u16>(reg: u8, memory: bool, words: &mut Words<F>) -> Dst {
    match (memory, reg) {
        (false, _) => Dst::Reg(reg),
        (true, 0) => {
            let (here, x) = words.next();
            Dst::Symbolic(near(here, x))
        }
        // R2 as a base reads 0; so does R3.
        (true, 2 | 3) => Dst::Absolute(u32::from(words.next().1)),
        (true, _) => Dst::Indexed { reg, near: true, x: signed(words.next().1) },
    }
}
