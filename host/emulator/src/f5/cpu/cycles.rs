//! Cycle counts of the MSP430X CPU, version 2 (SLAU208, chapter 6, tables "Interrupt, Reset",
//! "Format II", "Format I", and their extended and address counterparts).

use super::decode::{Act, Dst, Size, Src};
use crate::cpu::decode::Kind;

/// What the tables distinguish in a source operand.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Column {
    /// Register or constant generator.
    Register,
    /// `@Rn`
    Indirect,
    /// `@Rn+`
    AutoIncrement,
    /// `#N`
    Immediate,
    /// `X(Rn)`
    Indexed,
    /// `ADDR`
    Symbolic,
    /// `&ADDR`
    Absolute,
}

impl Column {
    fn memory(self) -> bool {
        matches!(self, Column::Indexed | Column::Symbolic | Column::Absolute)
    }
}

/// The column of a decoded source.
pub fn column(src: Src) -> Column {
    match src {
        Src::Reg(_) | Src::Constant(_) => Column::Register,
        Src::Indirect(_) | Src::NextWord(_) => Column::Indirect,
        Src::Increment(_) => Column::AutoIncrement,
        Src::Immediate(_) => Column::Immediate,
        Src::Indexed { .. } => Column::Indexed,
        Src::Symbolic(_) => Column::Symbolic,
        Src::Absolute(_) => Column::Absolute,
    }
}

fn only_reads_or_moves(kind: Kind) -> bool {
    matches!(kind, Kind::Mov | Kind::Bit | Kind::Cmp)
}

/// Two operands, without extension word.
pub fn double(kind: Kind, src: Src, dst: Dst) -> u8 {
    let [register, pc, memory] = match column(src) {
        Column::Register => [1, 3, 4],
        Column::Indirect | Column::AutoIncrement => [2, 4, 5],
        Column::Immediate => [2, 3, 5],
        Column::Indexed | Column::Symbolic | Column::Absolute => [3, 5, 6],
    };
    match dst {
        Dst::Reg(0) => pc,
        Dst::Reg(_) => register,
        _ => memory - u8::from(only_reads_or_moves(kind)),
    }
}

/// One operand, without extension word.
pub fn single(kind: Kind, src: Src) -> u8 {
    let column = column(src);
    match kind {
        Kind::Push => 3 + u8::from(column.memory()),
        Kind::Call => match column {
            Column::Indexed | Column::Symbolic => 5,
            Column::Absolute => 6,
            _ => 4,
        },
        Kind::Reti => 5,
        _ => match column {
            Column::Register => 1,
            Column::Indirect | Column::AutoIncrement | Column::Immediate => 3,
            _ => 4,
        },
    }
}

/// Two operands behind an extension word, executed once.
pub fn double_extended(kind: Kind, size: Size, src: Src, dst: Dst) -> u8 {
    let address = u8::from(size == Size::Address);
    let column = column(src);
    match dst {
        Dst::Reg(0) => {
            let quick = matches!(kind, Kind::Mov | Kind::Add | Kind::Sub);
            match column {
                Column::Register => 4,
                Column::Immediate => 4 - u8::from(quick),
                Column::Indirect | Column::AutoIncrement => 5 + address - u8::from(quick),
                _ => 6 + address - u8::from(quick),
            }
        }
        Dst::Reg(_) => match column {
            Column::Register => 2,
            Column::Immediate => 3,
            Column::Indirect | Column::AutoIncrement => 3 + address,
            _ => 4 + address,
        },
        _ => {
            let [word, far] = match column {
                Column::Register => [5, 7],
                Column::Indirect | Column::AutoIncrement => [6, 9],
                Column::Immediate => [6, 8],
                _ => [7, 10],
            };
            let less = u8::from(only_reads_or_moves(kind));
            if address != 0 { far - 2 * less } else { word - less }
        }
    }
}

/// One operand behind an extension word, executed once.
pub fn single_extended(kind: Kind, size: Size, src: Src) -> u8 {
    let address = size == Size::Address;
    let column = column(src);
    if kind == Kind::Push {
        return match column {
            Column::Indirect | Column::AutoIncrement => 4 + 2 * u8::from(address),
            Column::Register | Column::Immediate => 4 + u8::from(address),
            _ => 5 + 2 * u8::from(address),
        };
    }
    match column {
        Column::Register => 2,
        Column::Indirect | Column::AutoIncrement | Column::Immediate => 4 + 2 * u8::from(address),
        _ => 5 + 2 * u8::from(address),
    }
}

/// MOVA, CMPA, ADDA, SUBA.
pub fn address(act: Act, src: Src, dst: Dst) -> u8 {
    let pc = dst == Dst::Reg(0);
    match (act, column(src), dst) {
        (_, _, Dst::Indexed { .. } | Dst::Absolute(_) | Dst::Symbolic(_)) => 4,
        (Act::Mova, Column::Indirect | Column::AutoIncrement, _) => 3 + 2 * u8::from(pc),
        (Act::Mova, Column::Immediate, _) => 2 + u8::from(pc),
        (Act::Mova, Column::Register, _) => 1 + 2 * u8::from(pc),
        (Act::Mova, _, _) => 4 + 2 * u8::from(pc),
        (Act::Cmpa, Column::Register, _) => 1,
        (_, Column::Register, _) => 1 + 2 * u8::from(pc),
        _ => 3,
    }
}

/// CALLA by mode; `sp` tells that the base is the stack pointer.
pub fn calla(src: Src, sp: bool) -> u8 {
    match column(src) {
        Column::Register | Column::Immediate => 5,
        Column::Indexed => 5 + u8::from(sp),
        Column::Indirect | Column::AutoIncrement => 6,
        Column::Symbolic | Column::Absolute => 7,
    }
}

/// PUSHM and POPM of `n` registers.
pub fn multiple(size: Size, n: u8) -> u8 {
    if size == Size::Address { 2 + 2 * n } else { 2 + n }
}
