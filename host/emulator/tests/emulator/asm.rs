//! A few lines of assembler: operands to instruction words, independent of the decoder.

/// Source operand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum S {
    /// Rn
    R(u16),
    /// #N, always as an extension word.
    Imm(u16),
    /// Constant generator: -1, 0, 1, 2, 4, 8.
    Cg(i16),
    /// X(Rn)
    X(u16, u16),
    /// &ADDR
    Abs(u16),
    /// ADDR, relative to the program counter.
    Sym(u16),
    /// @Rn
    At(u16),
    /// @Rn+
    Inc(u16),
}

/// Destination operand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum D {
    /// Rn
    R(u16),
    /// X(Rn)
    X(u16, u16),
    /// &ADDR
    Abs(u16),
    /// ADDR, relative to the program counter.
    Sym(u16),
}

/// Mnemonics of the two-operand instructions in the order of their opcodes, from 4.
pub const DOUBLE: [&str; 12] =
    ["mov", "add", "addc", "subc", "sub", "cmp", "dadd", "bit", "bic", "bis", "xor", "and"];

/// Mnemonics of the one-operand instructions in the order of their opcodes.
pub const SINGLE: [&str; 6] = ["rrc", "swpb", "rra", "sxt", "push", "call"];

/// RETI
pub const RETI: u16 = 0x1300;

/// Register, As field and extension of a source; `ext_at` is where the extension will stand.
fn source(s: S, ext_at: u16) -> (u16, u16, Option<u16>) {
    match s {
        S::R(n) => (n, 0, None),
        S::Imm(v) => (0, 3, Some(v)),
        S::Cg(0) => (3, 0, None),
        S::Cg(1) => (3, 1, None),
        S::Cg(2) => (3, 2, None),
        S::Cg(-1) => (3, 3, None),
        S::Cg(4) => (2, 2, None),
        S::Cg(8) => (2, 3, None),
        S::Cg(other) => panic!("{other} is no constant of the generators"),
        S::X(n, x) => (n, 1, Some(x)),
        S::Abs(a) => (2, 1, Some(a)),
        S::Sym(a) => (0, 1, Some(a.wrapping_sub(ext_at))),
        S::At(n) => (n, 2, None),
        S::Inc(n) => (n, 3, None),
    }
}

/// A two-operand instruction at `pc`.
pub fn op2(name: &str, byte: bool, s: S, d: D, pc: u16) -> Vec<u16> {
    let opcode = DOUBLE.iter().position(|n| *n == name).expect("two-operand mnemonic") as u16 + 4;
    let (sreg, amode, sext) = source(s, pc.wrapping_add(2));
    let dext_at = pc.wrapping_add(if sext.is_some() { 4 } else { 2 });
    let (dreg, dmode, dext) = match d {
        D::R(n) => (n, 0, None),
        D::X(n, x) => (n, 1, Some(x)),
        D::Abs(a) => (2, 1, Some(a)),
        D::Sym(a) => (0, 1, Some(a.wrapping_sub(dext_at))),
    };
    let first = opcode << 12 | sreg << 8 | dmode << 7 | u16::from(byte) << 6 | amode << 4 | dreg;
    [Some(first), sext, dext].into_iter().flatten().collect()
}

/// A one-operand instruction at `pc`.
pub fn op1(name: &str, byte: bool, s: S, pc: u16) -> Vec<u16> {
    let opcode = SINGLE.iter().position(|n| *n == name).expect("one-operand mnemonic") as u16;
    let (reg, mode, ext) = source(s, pc.wrapping_add(2));
    let first = 0x1000 | opcode << 7 | u16::from(byte) << 6 | mode << 4 | reg;
    [Some(first), ext].into_iter().flatten().collect()
}

/// A jump with a condition (0 to 7: NE, EQ, NC, C, N, GE, L, always) over `words` words.
pub fn jump(condition: u16, words: i16) -> u16 {
    0x2000 | condition << 10 | words as u16 & 0x3FF
}
