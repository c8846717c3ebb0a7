//! Byte code as text, one instruction a line.

use core::fmt::Write as _;

use crate::back::report::Sidecar;
use crate::image::{self, Image};
use crate::isa::{self, Op, Operands};
use crate::vm::effects;

/// One instruction taken apart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Insn {
    /// Address.
    pub pc: usize,
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// Mnemonic and operands.
    pub text: String,
}

/// Takes the code of an image apart. Bytes that are no instruction appear as `?`, one a line.
pub fn instructions(image: &Image<'_>) -> Vec<Insn> {
    let mut out = Vec::new();
    let mut pc = 0;
    while pc < image.code.len() {
        let rest = &image.code[pc..];
        let wide = image.header.wide();
        let decoded = Op::decode(rest[0]).and_then(|(op, n)| {
            let len = 1 + op.row().operands.len(wide);
            rest.get(..len).map(|bytes| (op, n, bytes))
        });
        let (bytes, text) = match decoded {
            Some((op, n, bytes)) => (bytes, text(image, pc, op, n, bytes)),
            None => (&rest[..1], "?".to_owned()),
        };
        out.push(Insn { pc, bytes: bytes.to_vec(), text });
        pc += bytes.len();
    }
    out
}

/// A listing with addresses, bytes and, where the sidecar is there, the source lines.
pub fn listing(image: &Image<'_>, sidecar: Option<&Sidecar>) -> String {
    let mut out = String::new();
    let mut line = 0;
    for insn in instructions(image) {
        let mark = sidecar.and_then(|sidecar| sidecar.at(insn.pc));
        if let Some(mark) = mark
            && mark.line != line
        {
            line = mark.line;
            let _ = writeln!(out, "line {line}");
        }
        let bytes: Vec<String> = insn.bytes.iter().map(|byte| format!("{byte:02X}")).collect();
        let entry = if insn.pc == image.header.entry { '>' } else { ' ' };
        let _ = writeln!(out, "{entry}{:04X}  {:<14} {}", insn.pc, bytes.join(" "), insn.text);
    }
    out
}

fn text(image: &Image<'_>, pc: usize, op: Op, n: u8, bytes: &[u8]) -> String {
    let row = op.row();
    let next = pc + bytes.len();
    let byte = |i: usize| bytes.get(i).copied().unwrap_or(0);
    let address = || image::address(bytes, 1, image.header.wide()).unwrap_or(0);
    let jump = |distance: u8| next.wrapping_add_signed(isize::from(distance.cast_signed()));
    let operands = match row.operands {
        Operands::None if row.count == 1 => String::new(),
        Operands::None => match op {
            Op::OutShort => format!(" {} {}", n / 2 + 1, n & 1),
            Op::MoveTo | Op::MoveBy | Op::Home => {
                format!(" {}", ["X", "Y", "Z"].get(usize::from(n)).unwrap_or(&"?"))
            }
            Op::Rapid | Op::Line => format!(" {}", ["X", "Y", "XY", "Z", "XYZ"][usize::from(n)]),
            _ => format!(" {n}"),
        },
        Operands::U8 | Operands::I8 | Operands::I16 | Operands::I32 => {
            format!(" {}", number(op, bytes))
        }
        Operands::Cell => format!(" {}", byte(1)),
        Operands::Array => format!(" {} len {}", byte(1), byte(2)),
        Operands::Rel => format!(" {:04X}", jump(byte(1))),
        Operands::Addr | Operands::Sub => format!(" {:04X}", address()),
        Operands::CellRel => format!(" {} {:04X}", byte(1), jump(byte(2))),
        Operands::Mm
        | Operands::Mm2
        | Operands::Mm3
        | Operands::MmFlags
        | Operands::Mm2Flags
        | Operands::Mm3Flags
        | Operands::Mm2Flags2 => {
            return inline_text(bytes, row.name);
        }
        Operands::U8Rel => format!(" {n} {} {:04X}", byte(1), jump(byte(2))),
        Operands::CellWordRel => {
            let limit = i16::from_le_bytes([byte(2), byte(3)]);
            format!(" {} {limit} {:04X}", byte(1), jump(byte(4)))
        }
        Operands::Sub8 => format!(" {:04X}", byte(1)),
        Operands::Column8 => format!(" data {:04X}", byte(1)),
        Operands::Column => format!(" data {:04X}", address()),
        Operands::Text8 | Operands::Text => {
            let offset = if bytes.len() == 2 { usize::from(byte(1)) } else { address() };
            let text = image.text(offset).unwrap_or_default();
            format!(" {:?}", String::from_utf8_lossy(text))
        }
        Operands::Axis | Operands::Flags | Operands::Flags2 | Operands::Flags3 => {
            let flags = [byte(1), byte(2), byte(3)];
            return effect_text(bytes[0], flags, row.name);
        }
    };
    format!("{}{operands}", row.name)
}

/// What a constant pushes.
fn number(op: Op, bytes: &[u8]) -> i64 {
    let mut value: i64 = 0;
    for &byte in bytes[1..].iter().rev() {
        value = value << 8 | i64::from(byte);
    }
    let unused = 64 - 8 * (bytes.len() as u32 - 1);
    let signed = value << unused >> unused;
    match op {
        Op::Tens => value * 10,
        Op::WordTens => signed * 10,
        Op::Hundreds => signed * 100,
        Op::Thousands => signed * 1000,
        Op::Check => value,
        _ => signed,
    }
}

/// An instruction with millimetres: the effect that it is.
fn inline_text(bytes: &[u8], name: &str) -> String {
    let Some(inline) = isa::inline(bytes[0]) else { return name.to_owned() };
    let (values, flags) = bytes[1..].split_at(usize::from(inline.values));
    let mut arguments = [0; effects::MAX_ARGUMENTS];
    for (argument, value) in arguments.iter_mut().zip(values) {
        *argument = i32::from(value.cast_signed()) * 1000;
    }
    let flag = |i: usize| flags.get(i).copied().unwrap_or(0);
    let flags = [flag(0), flag(1), 0];
    match effects::decode(inline.code, flags, arguments) {
        Some(effect) => format!("{name} ; {effect:?}"),
        None => name.to_owned(),
    }
}

/// An instruction with flags: the bytes, and the effect with its arguments as 1, 2, 3...
fn effect_text(code: u8, flags: [u8; 3], name: &str) -> String {
    let operands = isa::shape(code).map_or(0, |shape| shape.operands().len(false));
    let bytes: Vec<String> = flags[..operands.min(3)].iter().map(|b| format!("{b:02X}")).collect();
    match effects::decode(code, flags, [1, 2, 3, 4, 5]) {
        Some(effect) => format!("{name} {} ; {effect:?}", bytes.join(" ")),
        None => format!("{name} {}", bytes.join(" ")),
    }
}
