//! Instructions behind an extension word (SLAU208, section "MSP430X Extended Instructions").

use super::cycles;
use super::decode::{ADDRESS, Act, Dst, Op, Repeat, Size, Src, Words, constant};
use crate::cpu::decode::{DOUBLE, Kind, SINGLE};

/// Bit of the extension word: carry is taken as 0, in register mode.
const ZERO_CARRY: u16 = 0x100;
/// Bit of the extension word: the repetition count stands in a register, in register mode.
const COUNT_IN_REGISTER: u16 = 0x80;
/// Bit of the extension word: the operation is not of 20 bits.
const NOT_ADDRESS: u16 = 0x40;

/// Decodes what stands behind the extension word `extension`.
pub fn decode<F: FnMut(u32) -> u16>(extension: u16, words: &mut Words<F>) -> Op {
    let (_, word) = words.next();
    let byte = word & 0x40 != 0;
    let size = match (extension & NOT_ADDRESS != 0, byte) {
        (true, true) => Some(Size::Byte),
        (true, false) => Some(Size::Word),
        (false, true) => Some(Size::Address),
        // Reserved, but for SWPBX.A and SXTX.A.
        (false, false) => None,
    };
    let mode = word >> 4 & 3;
    let (src_high, dst_high) = (extension >> 7 & 15, extension & 15);
    match word >> 12 {
        1 if word < 0x1280 => {
            let kind = SINGLE[usize::from(word >> 7 & 7)];
            let swaps = matches!(kind, Kind::Swpb | Kind::Sxt);
            let size = match size {
                // The byte bit has no meaning for these two.
                Some(Size::Byte | Size::Address) if swaps => return Op::RESERVED,
                None if swaps => Size::Address,
                Some(size) => size,
                None => return Op::RESERVED,
            };
            let reg = (word & 15) as u8;
            if mode == 0 && kind != Kind::Push {
                let src = Src::Reg(reg);
                let cycles = cycles::single_extended(kind, size, src);
                let op = Op { act: Act::Core(kind), size, cycles, src, ..Op::NONE };
                return repeated(op, extension);
            }
            // The only operand is a destination: its high bits stand where those are.
            let src = source(reg, mode, dst_high, words);
            let cycles = cycles::single_extended(kind, size, src);
            Op { act: Act::Core(kind), size, cycles, src, ..Op::NONE }
        }
        4.. => {
            let Some(size) = size else { return Op::RESERVED };
            let kind = DOUBLE[usize::from((word >> 12) - 4)];
            let (from, to) = ((word >> 8 & 15) as u8, (word & 15) as u8);
            let memory = word & 0x80 != 0;
            let register_mode = mode == 0 && !memory;
            let src = source(from, mode, if register_mode { 0 } else { src_high }, words);
            let dst = destination(to, memory, dst_high, words);
            let cycles = cycles::double_extended(kind, size, src, dst);
            let op = Op { act: Act::Core(kind), size, cycles, src, dst, ..Op::NONE };
            if register_mode { repeated(op, extension) } else { op }
        }
        _ => Op::RESERVED,
    }
}

/// Register mode: repetitions and carry from the extension word.
fn repeated(op: Op, extension: u16) -> Op {
    let field = (extension & 15) as u8;
    let repeat = if extension & COUNT_IN_REGISTER != 0 {
        Repeat::Register(field)
    } else {
        Repeat::Times(field + 1)
    };
    Op { repeat, zero_carry: extension & ZERO_CARRY != 0, ..op }
}

fn join(high: u16, low: u16) -> u32 {
    u32::from(high) << 16 | u32::from(low)
}

fn source<F: FnMut(u32) -> u16>(reg: u8, mode: u16, high: u16, words: &mut Words<F>) -> Src {
    if let Some(value) = constant(reg, mode) {
        return Src::Constant(value);
    }
    match (mode, reg) {
        (0, 0) => Src::Constant(words.at),
        (0, _) => Src::Reg(reg),
        (1, 0) => {
            let (here, x) = words.next();
            Src::Symbolic((here + join(high, x)) & ADDRESS)
        }
        (1, 2) => Src::Absolute(join(high, words.next().1)),
        (1, _) => Src::Indexed { reg, near: false, x: join(high, words.next().1) },
        (2, 0) => Src::NextWord(words.at),
        (2, _) => Src::Indirect(reg),
        (_, 0) => Src::Immediate(join(high, words.next().1)),
        _ => Src::Increment(reg),
    }
}

fn destination<F: FnMut(u32) -> u16>(
    reg: u8,
    memory: bool,
    high: u16,
    words: &mut Words<F>,
) -> Dst {
    match (memory, reg) {
        (false, _) => Dst::Reg(reg),
        (true, 0) => {
            let (here, x) = words.next();
            Dst::Symbolic((here + join(high, x)) & ADDRESS)
        }
        (true, 2 | 3) => Dst::Absolute(join(high, words.next().1)),
        (true, _) => Dst::Indexed { reg, near: false, x: join(high, words.next().1) },
    }
}
