//! The instruction set of the VM.
//!
//! One byte selects the instruction, operand bytes follow, numbers least byte first. Nothing is
//! aligned: the MSP430 reads operands byte by byte. The top bits of the first byte split the codes
//! so that a hand-written core decodes them by shifts alone:
//!
//! | codes | meaning |
//! |---|---|
//! | `0nnn_nnnn` | an entry of the handler table: `2 * code` is its index |
//! | `011n_nnnn` | push n |
//! | `1000_nnnn` | push cell n: `4 * n` is left after two shifts |
//! | `1001_nnnn` | store into cell n |
//! | `1010_nnnn` | effect whose values, whole thousands, stand in the code |
//! | `1011_nnnn`, `11nn_nnnn` | effect: the VM leaves with the arguments on the stack |
//!
//! [`Op`], [`ROWS`], the encoder, the decoder, the disassembler, the verifier's stack effects and
//! the reference manual's table all come from `isa/table.rs`.

mod codes;
mod fingerprint;
pub mod flags;
mod table;

pub use codes::{first, last};
pub use fingerprint::{EXTRA, FINGERPRINT};

use crate::axis::AxisSet;

/// What stands behind the first byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Operands {
    /// Nothing.
    None = 0,
    /// Number 0..=255.
    U8,
    /// Number -128..=127.
    I8,
    /// 16-bit number.
    I16,
    /// 32-bit number.
    I32,
    /// Cell number.
    Cell,
    /// First cell and length of an array.
    Array,
    /// Signed distance of a jump from the instruction's end.
    Rel,
    /// Jump target, counted from the start of the code.
    Addr,
    /// Cell, then signed distance.
    CellRel,
    /// Limit 0..=255, signed distance.
    U8Rel,
    /// Routine that starts below 256.
    Sub8,
    /// Routine.
    Sub,
    /// Table column whose data offset is below 256.
    Column8,
    /// Table column.
    Column,
    /// Text whose data offset is below 256.
    Text8,
    /// Text.
    Text,
    /// Axis 0..=2.
    Axis,
    /// One byte of flags.
    Flags,
    /// Two bytes of flags.
    Flags2,
    /// Three bytes of flags.
    Flags3,
    /// Millimetres, -128..=127.
    Mm,
    /// Two of them.
    Mm2,
    /// Three of them.
    Mm3,
    /// Millimetres, then a byte of flags.
    MmFlags,
    /// Twice millimetres, then a byte of flags.
    Mm2Flags,
    /// Three times millimetres, then a byte of flags.
    Mm3Flags,
    /// Twice millimetres, then two bytes of flags.
    Mm2Flags2,
    /// Cell, 16-bit limit, signed distance.
    CellWordRel,
}

impl Operands {
    const ALL: [Operands; 29] = [
        Operands::None,
        Operands::U8,
        Operands::I8,
        Operands::I16,
        Operands::I32,
        Operands::Cell,
        Operands::Array,
        Operands::Rel,
        Operands::Addr,
        Operands::CellRel,
        Operands::U8Rel,
        Operands::Sub8,
        Operands::Sub,
        Operands::Column8,
        Operands::Column,
        Operands::Text8,
        Operands::Text,
        Operands::Axis,
        Operands::Flags,
        Operands::Flags2,
        Operands::Flags3,
        Operands::Mm,
        Operands::Mm2,
        Operands::Mm3,
        Operands::MmFlags,
        Operands::Mm2Flags,
        Operands::Mm3Flags,
        Operands::Mm2Flags2,
        Operands::CellWordRel,
    ];

    /// Bytes behind the first one. Addresses have two, in a wide image three.
    pub const fn len(self, wide: bool) -> usize {
        match self {
            Operands::None => 0,
            Operands::I16
            | Operands::Array
            | Operands::CellRel
            | Operands::Flags2
            | Operands::Mm2
            | Operands::U8Rel
            | Operands::MmFlags => 2,
            Operands::Flags3 | Operands::Mm3 | Operands::Mm2Flags => 3,
            Operands::I32 | Operands::Mm3Flags | Operands::Mm2Flags2 | Operands::CellWordRel => 4,
            Operands::Addr | Operands::Sub | Operands::Column | Operands::Text => 2 + wide as usize,
            _ => 1,
        }
    }
}

/// Who executes an instruction, and whether the next one follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Class {
    /// The VM; the next instruction may follow.
    Pure = 0,
    /// The VM; never falls through. The next instruction begins a statement.
    Ends = 1,
    /// The machine: the VM leaves and is resumed with the result.
    Effect = 2,
}

/// A row of the opcode table.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The instruction.
    pub op: Op,
    /// Its first code.
    pub code: u8,
    /// Number of its codes; above 1 the code carries a small operand.
    pub count: u8,
    /// Mnemonic.
    pub name: &'static str,
    /// Operand bytes.
    pub operands: Operands,
    /// Values taken from the stack, but for what [`arguments`] adds.
    pub pops: u8,
    /// Values left.
    pub pushes: u8,
    /// Who executes it.
    pub class: Class,
    /// What it does.
    pub doc: &'static str,
}

/// Rows by their codes.
const fn sorted<const N: usize>(mut rows: [Row; N]) -> [Row; N] {
    let mut end = 1;
    while end < N {
        let mut at = end;
        while at > 0 && rows[at].code < rows[at - 1].code {
            let row = rows[at];
            rows[at] = rows[at - 1];
            rows[at - 1] = row;
            at -= 1;
        }
        end += 1;
    }
    rows
}

macro_rules! opcodes {
    ($($code:literal x $count:literal $name:ident $text:literal
       $operands:ident $pops:literal $pushes:literal $class:ident $doc:literal;)*) => {
        /// An instruction; the discriminant is its first code.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(u8)]
        pub enum Op { $(#[doc = $doc] $name = $code,)* }

        /// The opcode table in ascending order of codes.
        pub const ROWS: &[Row] = &sorted([$(Row {
            op: Op::$name,
            code: $code,
            count: $count,
            name: $text,
            operands: Operands::$operands,
            pops: $pops,
            pushes: $pushes,
            class: Class::$class,
            doc: $doc,
        },)*]);

        impl Op {
            /// The instruction of a code and the small operand that the code carries.
            pub const fn decode(code: u8) -> Option<(Op, u8)> {
                $(if code.wrapping_sub($code) < $count { return Some((Op::$name, code - $code)); })*
                None
            }
        }
    };
}

crate::opcode_rows!(opcodes);

/// First code of the short `push cell`.
pub const LOAD: u8 = Op::Load as u8;
/// First code of the effects.
pub const EFFECTS: u8 = 0xA0;
/// Cells that have short forms of load and store.
pub const SHORT_CELLS: u8 = 16;
/// Constants that have an instruction of one byte.
pub const SMALL: i32 = 32;
/// Cells that one byte sets to 0 or counts up, and that loops count in two bytes fewer.
pub const LOW_CELLS: u8 = 4;
/// Axes of the short forms of G0 and G1.
pub const SHORT_AXES: [AxisSet; 5] =
    [AxisSet(0b001), AxisSet(0b010), AxisSet(0b011), AxisSet(0b100), AxisSet(0b111)];

/// What the verifier needs to know of a code, in two bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape(u16);

impl Shape {
    const INVALID: Shape = Shape(0xFFFF);

    const fn of(row: &Row) -> Shape {
        Shape(
            row.operands as u16
                | (row.pops as u16) << 5
                | (row.pushes as u16) << 8
                | (row.class as u16) << 10,
        )
    }

    /// Operand bytes.
    pub const fn operands(self) -> Operands {
        Operands::ALL[(self.0 & 31) as usize]
    }

    /// Values taken from the stack, but for what [`arguments`] adds.
    pub const fn pops(self) -> u8 {
        (self.0 >> 5 & 7) as u8
    }

    /// Values left.
    pub const fn pushes(self) -> u8 {
        (self.0 >> 8 & 3) as u8
    }

    /// Who executes it.
    pub const fn class(self) -> Class {
        match self.0 >> 10 {
            0 => Class::Pure,
            1 => Class::Ends,
            _ => Class::Effect,
        }
    }
}

const LOW: usize = 0x60;

const fn shapes<const N: usize>(first: u8) -> [Shape; N] {
    let mut table = [Shape::INVALID; N];
    let mut i = 0;
    while i < N {
        let code = first + i as u8;
        let mut r = 0;
        while r < ROWS.len() {
            if code.wrapping_sub(ROWS[r].code) < ROWS[r].count {
                table[i] = Shape::of(&ROWS[r]);
            }
            r += 1;
        }
        i += 1;
    }
    table
}

static LOW_SHAPES: [Shape; LOW] = shapes(0);
/// One for each sixteen codes: small twice, load, store.
static SHORT_SHAPES: [Shape; 4] = [
    shapes::<1>(0x60)[0],
    shapes::<1>(0x60)[0],
    shapes::<1>(LOAD)[0],
    shapes::<1>(LOAD + SHORT_CELLS)[0],
];
const EFFECTS_AT: usize = EFFECTS as usize;
static EFFECT_SHAPES: [Shape; 0x100 - EFFECTS_AT] = shapes(EFFECTS);

/// The shape of a code; `None` when no instruction has it.
pub fn shape(code: u8) -> Option<Shape> {
    let shape = match usize::from(code) {
        code @ 0..LOW => LOW_SHAPES.get(code),
        code @ LOW..EFFECTS_AT => SHORT_SHAPES.get((code - LOW) >> 4),
        code => EFFECT_SHAPES.get(code - EFFECTS_AT),
    };
    shape.copied().filter(|&shape| shape != Shape::INVALID)
}

/// What an instruction with whole thousands stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Inline {
    /// Code of the effect that takes its values from the stack.
    pub code: u8,
    /// Values in the code, one byte each.
    pub values: u8,
}

/// The effect behind an instruction that brings whole thousands in its first operand bytes; the
/// effect's own operands follow them.
pub const fn inline(code: u8) -> Option<Inline> {
    const fn entry(effect: Op, n: u8, values: u8) -> Inline {
        Inline { code: effect as u8 + n, values }
    }
    /// In the order of the codes; the small operands of rapid and line are 0 X, 1 Y, 2 XY, 3 Z.
    const TABLE: [Inline; 16] = [
        entry(Op::MoveTo, 0, 1),
        entry(Op::MoveTo, 1, 1),
        entry(Op::MoveTo, 2, 1),
        entry(Op::Line, 0, 1),
        entry(Op::Line, 1, 1),
        entry(Op::Line, 3, 1),
        entry(Op::Rapid, 3, 1),
        entry(Op::Feed, 0, 1),
        entry(Op::Wait, 0, 1),
        entry(Op::Rapid, 2, 2),
        entry(Op::Line, 2, 2),
        entry(Op::Linear, 0, 1),
        entry(Op::Linear, 0, 2),
        entry(Op::Linear, 0, 3),
        entry(Op::Move, 0, 2),
        entry(Op::Probe, 0, 2),
    ];
    let n = code.wrapping_sub(Op::MoveToMm as u8) as usize;
    if n < TABLE.len() { Some(TABLE[n]) } else { None }
}

/// Bits of the first and the second byte of flags that each bring one more argument.
pub const fn argument_masks(code: u8) -> (u8, u8) {
    const MOVE: u8 = Op::Move as u8;
    const MOVE_RAMP: u8 = Op::MoveRamp as u8;
    const LINEAR: u8 = Op::Linear as u8;
    const LINEAR_MIXED: u8 = Op::LinearMixed as u8;
    const ARC: u8 = Op::Arc as u8;
    const ARC_MIXED: u8 = Op::ArcMixed as u8;
    const PROBE: u8 = Op::Probe as u8;
    const WAIT_IN: u8 = Op::WaitIn as u8;
    const WAIT_CHAR: u8 = Op::WaitChar as u8;
    const EVENT: u8 = Op::Event as u8;
    const ARC_BY: u8 = Op::ArcBy as u8;
    match code {
        MOVE => (flags::SPEED, 0),
        MOVE_RAMP => (flags::SPEED, flags::ACCEL | flags::DECEL),
        LINEAR | LINEAR_MIXED => (flags::AXES, 0),
        ARC | ARC_MIXED | ARC_BY => (flags::AXES | flags::OFFSETS, 0),
        PROBE => (flags::SPEED, flags::SENSOR),
        WAIT_IN => (flags::LEVEL | flags::TIMEOUT | flags::INPUT_ON_STACK, 0),
        WAIT_CHAR => (flags::TIMEOUT, 0),
        EVENT => (flags::EVENT_ARGUMENT, 0),
        _ => (0, 0),
    }
}

/// Values that an instruction takes beyond its row's `pops`, from its code and flags.
pub fn arguments(code: u8, flags: u8, flags2: u8) -> u8 {
    let rapid = code.wrapping_sub(Op::Rapid as u8);
    if rapid < 10 {
        let axes = SHORT_AXES.get(usize::from(rapid % 5)).copied().unwrap_or_default();
        return axes.0.count_ones() as u8;
    }
    let (first, second) = argument_masks(code);
    ((flags & first).count_ones() + (flags2 & second).count_ones()) as u8
}

/// What the instruction `read` looks at; its flags are `look << 2 | axis`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Look {
    /// `POS`
    Pos = 0,
    /// `POSST`
    PosSteps = 1,
    /// `PROBED`
    Probed = 2,
    /// `PROBEDST`
    ProbedSteps = 3,
    /// `PROBEOK`
    ProbeOk = 4,
    /// `MOVING`
    Moving = 5,
    /// `HOMED`
    Homed = 6,
    /// `INPORT`
    InPort = 7,
    /// `TIMER`
    Timer = 8,
    /// `CHARIN`
    CharIn = 9,
    /// `AIN`, its number less one in the place of the axis
    Analog = 10,
}

impl Op {
    /// The instruction's row.
    #[cfg(feature = "compiler")]
    pub fn row(self) -> &'static Row {
        ROWS.iter().find(|row| row.op == self).expect("every Op comes from a row")
    }

    /// The first code.
    pub const fn code(self) -> u8 {
        self as u8
    }
}

/// The opcode table as a Markdown table for the reference manual.
#[cfg(feature = "compiler")]
pub fn markdown() -> String {
    use core::fmt::Write as _;
    let mut text = String::from(
        "| code | mnemonic | operands | takes | leaves | does |\n|---|---|---|---|---|---|\n",
    );
    for row in ROWS {
        let codes = match row.count {
            1 => format!("{:02X}", row.code),
            count => format!("{:02X}..{:02X}", row.code, row.code + count - 1),
        };
        let operands = match row.operands {
            Operands::None => String::new(),
            other => format!("{other:?}"),
        };
        let (first, second) = argument_masks(row.code);
        let more = first | second != 0 || matches!(row.op, Op::Rapid | Op::Line);
        let _ = writeln!(
            text,
            "| {codes} | `{}` | {operands} | {}{} | {} | {} |",
            row.name,
            row.pops,
            if more { "+" } else { "" },
            row.pushes,
            row.doc.replace('|', "\\|"),
        );
    }
    text
}

#[cfg(test)]
mod tests;
