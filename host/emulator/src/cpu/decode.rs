//! Instruction words to decoded operations (SLAU144, chapter 3).

use super::cycles;

/// What an instruction does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Two operands, opcodes 4 to 15.
    Mov,
    /// `dst += src`
    Add,
    /// `dst += src + C`
    Addc,
    /// `dst += !src + C`
    Subc,
    /// `dst -= src`
    Sub,
    /// `dst - src`, flags only.
    Cmp,
    /// Decimal `dst += src + C`.
    Dadd,
    /// `dst & src`, flags only.
    Bit,
    /// `dst &= !src`, no flags.
    Bic,
    /// `dst |= src`, no flags.
    Bis,
    /// `dst ^= src`
    Xor,
    /// `dst &= src`
    And,
    /// Rotate right through carry.
    Rrc,
    /// Swap bytes.
    Swpb,
    /// Arithmetic shift right.
    Rra,
    /// Sign extend the low byte.
    Sxt,
    /// Push.
    Push,
    /// Call.
    Call,
    /// Return from interrupt.
    Reti,
    /// Conditional jump; the condition is in `Op::jump`.
    Jump,
    /// No instruction of this CPU.
    Illegal,
}

/// A source operand. The program counter as a base is resolved at decoding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Src {
    /// Register.
    Reg(u8),
    /// From a constant generator, or the program counter read as a register.
    Constant(u16),
    /// `#N`
    Immediate(u16),
    /// `X(Rn)`
    Indexed(u8, u16),
    /// `&ADDR` and symbolic.
    Absolute(u16),
    /// `@Rn`
    Indirect(u8),
    /// `@PC`: the word after the instruction word.
    NextWord(u16),
    /// `@Rn+`
    Increment(u8),
}

/// A destination operand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dst {
    /// Register.
    Reg(u8),
    /// `X(Rn)`
    Indexed(u8, u16),
    /// `&ADDR` and symbolic.
    Absolute(u16),
}

/// Conditions of the jumps, in the order of their encoding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Condition {
    /// JNE, JNZ
    NotZero,
    /// JEQ, JZ
    Zero,
    /// JNC, JLO
    NoCarry,
    /// JC, JHS
    Carry,
    /// JN
    Negative,
    /// JGE
    GreaterOrEqual,
    /// JL
    Less,
    /// JMP
    Always,
}

/// One decoded instruction, of a size that makes the cache's index a shift.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(align(16))]
pub struct Op {
    /// What it does.
    pub kind: Kind,
    /// Byte operation (`.B`).
    pub byte: bool,
    /// Words that it occupies, 1 to 3; 0 marks an empty cache entry.
    pub words: u8,
    /// Cycles that it takes.
    pub cycles: u8,
    /// Source, or the only operand.
    pub src: Src,
    /// Destination of two-operand instructions.
    pub dst: Dst,
    /// Condition of a jump.
    pub condition: Condition,
}

impl Op {
    /// An empty cache entry.
    pub const NONE: Op = Op {
        kind: Kind::Illegal,
        byte: false,
        words: 0,
        cycles: 1,
        src: Src::Constant(0),
        dst: Dst::Reg(3),
        condition: Condition::Always,
    };
}

pub(crate) const DOUBLE: [Kind; 12] = [
    Kind::Mov,
    Kind::Add,
    Kind::Addc,
    Kind::Subc,
    Kind::Sub,
    Kind::Cmp,
    Kind::Dadd,
    Kind::Bit,
    Kind::Bic,
    Kind::Bis,
    Kind::Xor,
    Kind::And,
];

pub(crate) const SINGLE: [Kind; 8] = [
    Kind::Rrc,
    Kind::Swpb,
    Kind::Rra,
    Kind::Sxt,
    Kind::Push,
    Kind::Call,
    Kind::Reti,
    Kind::Illegal,
];

pub(crate) const CONDITIONS: [Condition; 8] = [
    Condition::NotZero,
    Condition::Zero,
    Condition::NoCarry,
    Condition::Carry,
    Condition::Negative,
    Condition::GreaterOrEqual,
    Condition::Less,
    Condition::Always,
];

/// Decodes the instruction at `pc`; `fetch` reads a code word.
pub fn decode(pc: u16, mut fetch: impl FnMut(u16) -> u16) -> Op {
    let word = fetch(pc);
    let mut at = pc.wrapping_add(2);
    match word >> 12 {
        2 | 3 => jump(word, at),
        1 if word < 0x1400 => {
            let kind = SINGLE[usize::from(word >> 7 & 7)];
            let byte = word & 0x40 != 0;
            // The byte bit has no meaning for these; no assembler makes it.
            let undefined =
                byte && matches!(kind, Kind::Swpb | Kind::Sxt | Kind::Call | Kind::Reti);
            if kind == Kind::Illegal || undefined {
                return Op { words: 1, ..Op::NONE };
            }
            if kind == Kind::Reti {
                return Op {
                    kind,
                    words: 1,
                    cycles: cycles::single(kind, Src::Constant(0)),
                    ..Op::NONE
                };
            }
            let src = source((word & 15) as u8, word >> 4 & 3, &mut at, &mut fetch);
            let words = (at.wrapping_sub(pc) / 2) as u8;
            Op { kind, byte, words, cycles: cycles::single(kind, src), src, ..Op::NONE }
        }
        4.. => {
            let kind = DOUBLE[usize::from((word >> 12) - 4)];
            let byte = word & 0x40 != 0;
            let src = source((word >> 8 & 15) as u8, word >> 4 & 3, &mut at, &mut fetch);
            let dst = destination((word & 15) as u8, word & 0x80 != 0, &mut at, &mut fetch);
            let words = (at.wrapping_sub(pc) / 2) as u8;
            Op { kind, byte, words, cycles: cycles::double(src, dst), src, dst, ..Op::NONE }
        }
        _ => Op { words: 1, ..Op::NONE },
    }
}

fn jump(word: u16, next: u16) -> Op {
    // Ten bits, two's complement, in words.
    let offset = ((word << 6) as i16 >> 5) as u16;
    Op {
        kind: Kind::Jump,
        words: 1,
        cycles: cycles::JUMP,
        src: Src::Constant(next.wrapping_add(offset)),
        condition: CONDITIONS[usize::from(word >> 10 & 7)],
        ..Op::NONE
    }
}

fn extension(at: &mut u16, fetch: &mut impl FnMut(u16) -> u16) -> (u16, u16) {
    let here = *at;
    *at = at.wrapping_add(2);
    (here, fetch(here))
}

fn source(reg: u8, mode: u16, at: &mut u16, fetch: &mut impl FnMut(u16) -> u16) -> Src {
    match (mode, reg) {
        // Constant generators R2 and R3 (SLAU144, table 3-2).
        (2, 2) => Src::Constant(4),
        (3, 2) => Src::Constant(8),
        (0, 3) => Src::Constant(0),
        (1, 3) => Src::Constant(1),
        (2, 3) => Src::Constant(2),
        (3, 3) => Src::Constant(0xFFFF),
        (0, 0) => Src::Constant(*at),
        (0, _) => Src::Reg(reg),
        (1, 0) => {
            let (here, x) = extension(at, fetch);
            Src::Absolute(here.wrapping_add(x))
        }
        (1, 2) => Src::Absolute(extension(at, fetch).1),
        (1, _) => Src::Indexed(reg, extension(at, fetch).1),
        (2, 0) => Src::NextWord(*at),
        (2, _) => Src::Indirect(reg),
        (_, 0) => Src::Immediate(extension(at, fetch).1),
        _ => Src::Increment(reg),
    }
}

fn destination(reg: u8, memory: bool, at: &mut u16, fetch: &mut impl FnMut(u16) -> u16) -> Dst {
    match (memory, reg) {
        (false, _) => Dst::Reg(reg),
        (true, 0) => {
            let (here, x) = extension(at, fetch);
            Dst::Absolute(here.wrapping_add(x))
        }
        // R2 as a base reads 0; so does R3.
        (true, 2 | 3) => Dst::Absolute(extension(at, fetch).1),
        (true, _) => Dst::Indexed(reg, extension(at, fetch).1),
    }
}
