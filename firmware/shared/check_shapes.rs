//! The operands and stack effects of [`lang::isa`]'s instructions for the image check, packed into few bytes.

use crate::vm::PART;
use firmware::verify::feature_of;
use lang::isa::{self, Class, Op, Operands, ROWS};

/// No instruction.
const INVALID: u16 = (Kind::Invalid as u16) << 3;
/// Bit of a shape: the instruction never falls through.
pub const ENDS: u16 = 1 << 2;
/// Bit of a shape: nothing may lie below the values that the instruction takes.
const EXACT: u16 = 1 << 15;
/// Codes below have a row of their own each.
pub const LOW: u8 = 0x60;
/// From here on each code has one again.
pub const FIRST_EFFECT: u8 = isa::EFFECTS;
/// Between the two, groups of 16 codes have one together.
pub const GROUPS: u8 = (FIRST_EFFECT - LOW) / 16;
#[cfg(feature = "f5529")]
const INDICES: usize = LOW as usize + GROUPS as usize + 0x100 - FIRST_EFFECT as usize;

/// What an instruction's operands are to the check, in the order of `verify_table`.
#[derive(Clone, Copy)]
#[repr(u8)]
pub enum Kind {
    /// Whole thousands in the code: targets of a move along a line.
    Inline,
    /// Those of a move with speed.
    InlineMove,
    /// Those of a probe move.
    InlineProbe,
    /// Those whose number the code alone says.
    InlinePlain,
    /// Nothing to look at. What comes before this brings values that its effect takes.
    Plain,
    Cell,
    /// One of the cells that IncShort and Zero have in their codes.
    LowCell,
    /// One of those that Load and Store have.
    ShortCell,
    Array,
    ColumnNear,
    ColumnFar,
    TextNear,
    TextFar,
    /// An axis, there or not.
    AxisNumber,
    /// An axis that is there.
    Axis,
    /// No instruction.
    Invalid,
    /// From here on jumps, from `Distance` on relative ones.
    SubNear,
    SubFar,
    Address,
    Distance,
    CellDistance,
    LowCellDistance,
}

const fn kind(op: Op, operands: Operands, class: Class) -> Kind {
    match operands {
        Operands::Cell => Kind::Cell,
        Operands::Array => Kind::Array,
        Operands::Column8 => Kind::ColumnNear,
        Operands::Column => Kind::ColumnFar,
        Operands::Text8 => Kind::TextNear,
        Operands::Text => Kind::TextFar,
        Operands::Axis if matches!(class, Class::Effect) => Kind::AxisNumber,
        Operands::Axis => Kind::Axis,
        Operands::Mm2Flags if matches!(op, Op::MoveMm) => Kind::InlineMove,
        Operands::MmFlags | Operands::Mm2Flags | Operands::Mm3Flags => Kind::Inline,
        Operands::Mm2Flags2 => Kind::InlineProbe,
        Operands::Mm | Operands::Mm2 | Operands::Mm3 => Kind::InlinePlain,
        Operands::Sub8 => Kind::SubNear,
        Operands::Sub => Kind::SubFar,
        Operands::Addr => Kind::Address,
        Operands::Rel => Kind::Distance,
        Operands::CellRel | Operands::CellWordRel => Kind::CellDistance,
        Operands::U8Rel => Kind::LowCellDistance,
        _ => match op {
            Op::IncShort | Op::Zero => Kind::LowCell,
            Op::Load | Op::Store => Kind::ShortCell,
            _ => Kind::Plain,
        },
    }
}

/// Bits 0, 1 are [`INDEX`]'s or [`LENGTHS`]', 2 is [`ENDS`], 3..7 [`Kind`], 8, 9 values taken, 10, 11
/// values left, 12..14 operand bytes, then [`EXACT`].
const fn shape(code: u8) -> u16 {
    if feature_of(code) & !PART.features != 0 {
        return INVALID;
    }
    let mut r = 0;
    while r < ROWS.len() {
        let row = &ROWS[r];
        if code.wrapping_sub(row.code) < row.count {
            let short = code.wrapping_sub(Op::Rapid as u8);
            let pops = match short {
                0..10 => isa::SHORT_AXES[short as usize % 5].0.count_ones() as u8,
                _ => row.pops,
            };
            let pushes = match isa::inline(code) {
                Some(inline) => inline.values,
                None => row.pushes,
            };
            let class = match row.class {
                Class::Ends => ENDS,
                Class::Pure | Class::Effect => 0,
            };
            let exact = match row.op {
                Op::Call
                | Op::CallFar
                | Op::Gosub
                | Op::Return
                | Op::ExitSub
                | Op::Leave
                | Op::Give => EXACT,
                _ => 0,
            };
            assert!(pops < 4 && pushes < 4);
            return class
                | (kind(row.op, row.operands, row.class) as u16) << 3
                | (pops as u16) << 8
                | (pushes as u16) << 10
                | (row.operands.len(false) as u16) << 12
                | exact;
        }
        r += 1;
    }
    INVALID
}

/// Codes that one of [`SHAPES`] may stand for.
#[cfg(feature = "g2553")]
const RUNS: [u8; 4] = [1, 2, 6, 16];
/// The same for the check.
#[cfg(feature = "g2553")]
pub static LENGTHS: [u8; 4] = RUNS;

/// The shapes of all codes in their order, from [`LOW`] on round to what lies below, which is less
/// frequent; bits 0 and 1 say in [`LENGTHS`] of how many codes. An instruction is looked for from the
/// start: that takes longer than a table of codes, which 3 KB of program can bear.
#[cfg(feature = "g2553")]
pub static SHAPES: [u16; COUNTED.1] = {
    let mut shapes = [0; COUNTED.1];
    let mut i = 0;
    while i < COUNTED.1 {
        shapes[i] = COUNTED.0[i];
        i += 1;
    }
    shapes
};

#[cfg(feature = "g2553")]
const COUNTED: ([u16; 0x100], usize) = {
    let mut all = [0; 0x100];
    let mut code = 0;
    while code < 0x100 {
        all[code] = shape((code as u8).wrapping_add(LOW));
        code += 1;
    }
    let (mut shapes, mut count) = ([0; 0x100], 0);
    code = 0;
    while code < 0x100 {
        let mut same = 1;
        while code + same < 0x100 && all[code + same] == all[code] {
            same += 1;
        }
        let mut run = RUNS.len() - 1;
        while RUNS[run] as usize > same {
            run -= 1;
        }
        // The last one may reach beyond the codes there are.
        if code + same == 0x100 && RUNS[run] as usize != same && run + 1 < RUNS.len() {
            run += 1;
        }
        shapes[count] = all[code] | run as u16;
        count += 1;
        code += RUNS[run] as usize;
    }
    (shapes, count)
};

#[cfg(feature = "f5529")]
const fn code_of(index: usize) -> u8 {
    match index as u8 {
        index @ 0..LOW => index,
        index if index < LOW + GROUPS => LOW + (index - LOW) * 16,
        index => FIRST_EFFECT + (index - LOW - GROUPS),
    }
}

#[cfg(feature = "f5529")]
const fn position(shapes: &[u16], count: usize, wanted: u16) -> usize {
    let mut i = 0;
    while i < count && shapes[i] != wanted {
        i += 1;
    }
    i
}

#[cfg(feature = "f5529")]
const fn dictionary() -> ([u16; INDICES], usize) {
    let mut shapes = [0; INDICES];
    let mut count = 0;
    let mut index = 0;
    while index < INDICES {
        let wanted = shape(code_of(index));
        if position(&shapes, count, wanted) == count {
            shapes[count] = wanted;
            count += 1;
        }
        index += 1;
    }
    (shapes, count)
}

#[cfg(feature = "f5529")]
const KINDS: usize = dictionary().1;

/// The shapes that occur.
#[cfg(feature = "f5529")]
pub static SHAPES: [u16; KINDS] = {
    let all = dictionary().0;
    let mut shapes = [0; KINDS];
    let mut i = 0;
    while i < KINDS {
        shapes[i] = all[i];
        i += 1;
    }
    shapes
};

/// Which of them an instruction has, twice its number in [`SHAPES`].
#[cfg(feature = "f5529")]
pub static INDEX: [u8; INDICES] = {
    let shapes = dictionary().0;
    let mut indices = [0; INDICES];
    let mut index = 0;
    while index < INDICES {
        indices[index] = 2 * position(&shapes, KINDS, shape(code_of(index))) as u8;
        index += 1;
    }
    indices
};

const fn counted(code: u8) -> bool {
    let (first, second) = isa::argument_masks(code);
    first | second != 0 && feature_of(code) & !PART.features == 0
}

const fn counted_codes() -> usize {
    let mut count = 0;
    let mut code = FIRST_EFFECT;
    while code != 0 {
        count += counted(code) as usize;
        code = code.wrapping_add(1);
    }
    count
}

/// Bytes of [`MASKS`].
pub const MASKS_LEN: usize = 3 * counted_codes();

/// Codes whose flag bytes bring arguments, each with the masks of [`isa::argument_masks`].
pub static MASKS: [u8; MASKS_LEN] = {
    let mut masks = [0; MASKS_LEN];
    let mut at = 0;
    let mut code = FIRST_EFFECT;
    while code != 0 {
        if counted(code) {
            let (first, second) = isa::argument_masks(code);
            (masks[at], masks[at + 1], masks[at + 2]) = (code, first, second);
            at += 3;
        }
        code = code.wrapping_add(1);
    }
    masks
};
