//! What the assembler takes from the table: numbers, notation, the machine's tables.

use std::fmt::Write as _;

use crate::isa::{self, FORMULAS, OWN, Operand, ROUTINES, Row};

/// Numbers and macros. `formula_table` and `micro_tables` are macros that the machine puts where it reaches
/// them.
#[must_use]
pub fn notation() -> String {
    let mut text = String::new();
    let mut set = |name: &str, value: usize| line(&mut text, &format!(".set {name}, {value:#x}"));
    for (n, row) in FORMULAS.iter().enumerate() {
        set(&format!("F_{}", row.name), n);
    }
    for (name, bits) in [
        ("FORMULA", isa::FORMULA),
        ("F_RECORD", isa::RECORD),
        // What may stand behind an operand.
        ("AXIS", isa::AXIS),
        ("NEW", isa::NEW),
        ("LONG", 0),
        ("SHORT", isa::AXIS),
    ] {
        set(name, bits.into());
    }
    set("FAULTED", isa::FAULTED.into());
    set("NOT_YET", isa::NOT_YET.into());
    let names = ROUTINES.iter().map(|row| row.name).chain(OWN.iter().map(|row| row.name));
    for (n, name) in names.enumerate() {
        line(&mut text, &format!(".set DO_{name}, {n:#x}"));
        line(&mut text, &format!(".global DO_{name}"));
    }
    line(&mut text, &format!(".set MICRO_OWNS, {:#x}", isa::owns()));
    line(&mut text, &format!(".set MICRO_BYTES, {:#x}", isa::with_byte()));
    for row in OWN {
        if let Some(notation) = row.notation {
            operation(&mut text, notation, row.name, row.operands);
        }
    }
    let pop = ROUTINES.iter().filter(|row| !row.operands.is_empty());
    for row in pop.filter(|row| !row.operands.contains(&Operand::Pairs)) {
        let notation = row.name.trim_start_matches("micro_").to_uppercase();
        operation(&mut text, &notation, row.name, row.operands);
    }
    tables(&mut text);
    text
}

/// The macro of an operation: `notation operands`.
fn operation(text: &mut String, notation: &str, name: &str, operands: &[Operand]) {
    let names = ["a", "b", "c"];
    let list = names[..operands.len()].join(", ");
    line(text, &format!(".macro {notation} {list}"));
    if let Some(at) = operands.iter().position(|o| *o == Operand::Byte) {
        let byte = names[at];
        line(text, &format!(".if (\\{byte}) < BYTES || (\\{byte}) > BYTES+255"));
        line(text, ".error \"the byte is out of reach\"");
        line(text, ".endif");
    }
    line(text, &format!(".byte DO_{name}"));
    for (operand, name) in operands.iter().zip(names) {
        line(
            text,
            &match operand {
                Operand::Number => format!(".byte \\{name}"),
                Operand::Wrapped | Operand::Power => format!(".byte (\\{name}) & 0xff"),
                Operand::Word | Operand::Routine => format!(".short \\{name}"),
                Operand::Byte => format!(".byte (\\{name})-BYTES"),
                Operand::Jump => format!("TO \\{name}"),
                Operand::Places | Operand::Pairs => continue,
            },
        );
    }
    if name == "micro_end" {
        line(text, ".balign 2, 0");
    }
    line(text, ".endm");
}

/// Where the machine goes for each number: addresses, and how far its own operations lie behind `micro_base`.
fn tables(text: &mut String) {
    line(text, ".macro FORMULA_TABLE");
    line(text, "formula_table:");
    for row in FORMULAS {
        line(text, &format!(".short {}", row.label));
    }
    line(text, ".endm");
    line(text, ".macro MICRO_TABLES");
    line(text, "micro_table:");
    for row in ROUTINES {
        line(text, &format!(".short {}", row.label));
    }
    line(text, "micro_offsets:");
    for Row { label, .. } in OWN {
        line(text, &format!(".if {label}-micro_base > 2*255"));
        line(text, ".error \"the operation is out of reach\"");
        line(text, ".endif");
        line(text, &format!(".byte ({label}-micro_base)/2"));
    }
    line(text, ".endm");
}

fn line(text: &mut String, line: &str) {
    let _ = writeln!(text, "{line}");
}

#[cfg(test)]
mod tests {
    use super::notation;

    #[test]
    fn each_operation_has_its_number_and_its_notation() {
        let text = notation();
        assert!(text.contains(".set DO_micro_nothing, 0x0\n.global DO_micro_nothing"));
        assert!(text.contains(".macro IF_ANY a, b, c\n"));
        assert!(
            text.contains(".byte DO_micro_if_any\n.byte (\\a)-BYTES\n.byte \\b\nTO \\c\n.endm")
        );
        assert!(text.contains(".macro POP_NUMBER a, b\n"));
    }
}
