//! Notation from operations: what `firmware/g2553` would say, without the names of constants.

use crate::decode::{Code, Kind, Op, decode};
use crate::image::Entry;
use crate::isa::{FORMULAS, OWN, Operand, Own, ROUTINES};

/// An operation in the assembler's notation; `name` gives the symbol of an address.
#[must_use]
pub fn show(op: &Op, name: &dyn Fn(u16) -> Option<String>) -> String {
    let named = |at: u16| name(at).unwrap_or_else(|| format!("{at:#06x}"));
    match op.kind {
        Kind::Formula(formula, place) => {
            let word = if place.record { format!("{:#x}", place.at) } else { named(place.at) };
            let mut text = String::from(if place.record { "FR " } else { "F " });
            text += FORMULAS[formula as usize].name;
            text = format!("{text} {word}");
            if place.record {
                text += if place.short { ", SHORT" } else { ", LONG" };
            }
            if place.axis {
                text += ", AXIS";
            }
            if place.new {
                text += ", NEW";
            }
            text
        }
        Kind::Routine(n) => {
            let routine = &ROUTINES[n];
            let text = format!("DO {}", routine.name);
            with(text, op.operands.iter().map(u16::to_string).collect())
        }
        Kind::Own(own) => {
            let row = &OWN[own as usize];
            let text = row.notation.map_or_else(|| format!("DO {}", row.name), str::to_owned);
            let mut operands = Vec::new();
            let mut values = op.operands.iter();
            for operand in row.operands {
                let value = values.next().copied().unwrap_or_default();
                operands.push(match operand {
                    Operand::Byte | Operand::Routine => named(value),
                    Operand::Power => (value as i8).to_string(),
                    Operand::Jump | Operand::Places => continue,
                    _ => value.to_string(),
                });
            }
            operands.extend(op.targets.iter().map(|at| named(*at)));
            if own == Own::Literal { format!("LIT {}", operands[0]) } else { with(text, operands) }
        }
    }
}

fn with(text: String, operands: Vec<String>) -> String {
    if operands.is_empty() { text } else { format!("{text} {}", operands.join(", ")) }
}

/// A routine: a line for each operation, by address, labels in front of them.
#[must_use]
pub fn listing(code: &dyn Code, entry: &Entry, name: &dyn Fn(u16) -> Option<String>) -> String {
    let mut text = String::new();
    for at in entry.operations(code) {
        if let Some(label) = name(at) {
            text += &format!("{label}:\n");
        }
        match decode(code, at) {
            Ok(op) => text += &format!("    {at:04x}  {}\n", show(&op, name)),
            Err(wrong) => text += &format!("    {at:04x}  {wrong}\n"),
        }
    }
    text
}
