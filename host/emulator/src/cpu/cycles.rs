//! Cycle counts of the MSP430 CPU (SLAU144, tables 3-14 to 3-16). Not those of the MSP430X.

use super::decode::{Dst, Kind, Src};

/// Cycles from an interrupt's acceptance to the first instruction of its handler.
pub const INTERRUPT: u64 = 6;
/// Cycles from the end of a reset to the first instruction.
pub const RESET: u64 = 4;

/// What the tables distinguish in a source operand.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Column {
    /// Register or constant generator.
    Register,
    Indirect,
    AutoIncrement,
    Immediate,
    /// Indexed, symbolic or absolute.
    Memory,
}

fn column(src: Src) -> Column {
    match src {
        Src::Reg(_) | Src::Constant(_) => Column::Register,
        Src::Indirect(_) | Src::NextWord(_) => Column::Indirect,
        Src::Increment(_) => Column::AutoIncrement,
        Src::Immediate(_) => Column::Immediate,
        Src::Indexed(..) | Src::Absolute(_) => Column::Memory,
    }
}

/// Cycles of a two-operand instruction.
pub fn double(src: Src, dst: Dst) -> u8 {
    let [register, pc, memory] = match column(src) {
        Column::Register => [1, 2, 4],
        Column::Indirect => [2, 2, 5],
        Column::AutoIncrement | Column::Immediate => [2, 3, 5],
        Column::Memory => [3, 3, 6],
    };
    match dst {
        Dst::Reg(0) => pc,
        Dst::Reg(_) => register,
        Dst::Indexed(..) | Dst::Absolute(_) => memory,
    }
}

/// Cycles of a one-operand instruction.
pub fn single(kind: Kind, src: Src) -> u8 {
    let column = column(src);
    match kind {
        Kind::Push => match column {
            Column::Register => 3,
            Column::Indirect | Column::Immediate => 4,
            Column::AutoIncrement | Column::Memory => 5,
        },
        Kind::Call => match column {
            Column::Register | Column::Indirect => 4,
            Column::AutoIncrement | Column::Immediate | Column::Memory => 5,
        },
        Kind::Reti => 5,
        _ => match column {
            Column::Register => 1,
            Column::Indirect | Column::AutoIncrement | Column::Immediate => 3,
            Column::Memory => 4,
        },
    }
}

/// Cycles of every jump, taken or not.
pub const JUMP: u8 = 2;
