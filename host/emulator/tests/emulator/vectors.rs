//! Instruction semantics: every vector in every addressing mode, and the odd corners.

use emulator::WarningKind;

use crate::asm::{D, S, op1, op2};
use crate::{CODE, board};

const SRC: u16 = 0x0240;
const DST: u16 = 0x0280;

struct Vector {
    name: &'static str,
    byte: bool,
    src: Option<u16>,
    dst: u16,
    before: u16,
    result: u16,
    after: u16,
}

/// Status register bits by their letters.
pub fn flags(letters: &str) -> u16 {
    letters.chars().fold(0, |all, letter| {
        all | match letter {
            'C' => 0x0001,
            'Z' => 0x0002,
            'N' => 0x0004,
            'V' => 0x0100,
            '-' => 0,
            other => panic!("{other} is no flag"),
        }
    })
}

fn vectors() -> Vec<Vector> {
    let hex = |text: &str| u16::from_str_radix(text, 16).expect("hexadecimal");
    include_str!("data/vectors.txt")
        .lines()
        .filter(|line| !line.is_empty() && !line.starts_with('#'))
        .map(|line| {
            let field: Vec<&str> = line.split_whitespace().collect();
            let &[name, width, src, dst, before, "=", result, after] = field.as_slice() else {
                panic!("malformed vector: {line}");
            };
            Vector {
                name,
                byte: width == "b",
                src: (src != "-").then(|| hex(src)),
                dst: hex(dst),
                before: flags(before),
                result: hex(result),
                after: flags(after),
            }
        })
        .collect()
}

/// What memory holds after a byte or word result: bytes leave their neighbour alone.
fn in_memory(v: &Vector) -> u16 {
    if v.byte { v.dst & 0xFF00 | v.result & 0xFF } else { v.result }
}

#[test]
fn two_operand_vectors_hold_in_all_modes() {
    let mut cases = 0;
    for v in vectors().iter().filter(|v| v.src.is_some()) {
        let src = v.src.unwrap_or(0);
        let sources =
            [S::R(5), S::Imm(src), S::X(6, 4), S::Abs(SRC), S::Sym(SRC), S::At(7), S::Inc(7)];
        let constant = match src {
            0 => Some(0),
            1 => Some(1),
            2 => Some(2),
            4 => Some(4),
            8 => Some(8),
            0xFFFF => Some(-1),
            _ => None,
        };
        for s in sources.into_iter().chain(constant.map(S::Cg)) {
            for d in [D::R(8), D::X(9, 0xFFFE), D::Abs(DST), D::Sym(DST)] {
                let mut board = board(&op2(v.name, v.byte, s, d, CODE));
                board.poke16(SRC, src);
                board.poke16(DST, v.dst);
                for (n, value) in
                    [(2, v.before), (5, src), (6, SRC - 4), (7, SRC), (8, v.dst), (9, DST + 2)]
                {
                    board.set_reg(n, value);
                }
                board.step();
                let what =
                    format!("{} byte={} {s:?} {d:?}, {:04x} {:04x}", v.name, v.byte, src, v.dst);
                assert_eq!(board.reg(2), v.after, "flags of {what}");
                let only_flags = matches!(v.name, "cmp" | "bit");
                match d {
                    D::R(_) if only_flags => assert_eq!(board.reg(8), v.dst, "{what}"),
                    D::R(_) => assert_eq!(board.reg(8), v.result, "{what}"),
                    _ if only_flags => assert_eq!(board.peek16(DST), v.dst, "{what}"),
                    _ => assert_eq!(board.peek16(DST), in_memory(v), "{what}"),
                }
                let moved = if s != S::Inc(7) {
                    0
                } else if v.byte {
                    1
                } else {
                    2
                };
                assert_eq!(board.reg(7), SRC + moved, "{what}");
                assert_eq!(board.warnings(), [], "{what}");
                cases += 1;
            }
        }
    }
    assert!(cases > 1500, "{cases} cases");
}

#[test]
fn one_operand_vectors_hold_in_all_modes() {
    for v in vectors().iter().filter(|v| v.src.is_none()) {
        for s in [S::R(8), S::X(6, 4), S::Abs(DST), S::Sym(DST), S::At(7), S::Inc(7)] {
            let mut board = board(&op1(v.name, v.byte, s, CODE));
            board.poke16(DST, v.dst);
            for (n, value) in [(2, v.before), (6, DST - 4), (7, DST), (8, v.dst)] {
                board.set_reg(n, value);
            }
            board.step();
            let what = format!("{} byte={} {s:?}, {:04x}", v.name, v.byte, v.dst);
            assert_eq!(board.reg(2), v.after, "flags of {what}");
            let (got, want) = match s {
                S::R(_) => (board.reg(8), v.result),
                _ => (board.peek16(DST), in_memory(v)),
            };
            assert_eq!(got, want, "{what}");
            let moved = if s != S::Inc(7) {
                0
            } else if v.byte {
                1
            } else {
                2
            };
            assert_eq!(board.reg(7), DST + moved, "{what}");
        }
    }
}

#[test]
fn push_call_and_reti_use_the_stack_as_the_guide_says() {
    let mut b = board(&op1("push", true, S::R(5), CODE));
    b.set_reg(1, 0x0300);
    b.set_reg(5, 0x1234);
    b.poke16(0x02FE, 0xABCD);
    b.step();
    // A pushed byte takes a word and leaves the high byte.
    assert_eq!((b.reg(1), b.peek16(0x02FE)), (0x02FE, 0xAB34));

    let mut b = board(&op1("push", false, S::R(1), CODE));
    b.set_reg(1, 0x0300);
    b.step();
    assert_eq!((b.reg(1), b.peek16(0x02FE)), (0x02FE, 0x0300));

    let mut b = board(&op1("call", false, S::Imm(0xD001), CODE));
    b.set_reg(1, 0x0300);
    b.step();
    // Bit 0 of the program counter reads 0.
    assert_eq!((b.reg(0), b.reg(1), b.peek16(0x02FE)), (0xD000, 0x02FE, CODE + 4));

    let mut b = board(&[crate::asm::RETI]);
    b.set_reg(1, 0x0300);
    b.poke16(0x0300, 0x0105);
    b.poke16(0x0302, 0xD000);
    b.step();
    assert_eq!((b.reg(0), b.reg(1), b.reg(2)), (0xD000, 0x0304, 0x0105));
}

#[test]
fn stack_pointer_moves_by_words_even_for_bytes() {
    let mut b = board(&op2("mov", true, S::Inc(1), D::R(5), CODE));
    b.set_reg(1, 0x0300);
    b.poke16(0x0300, 0x1234);
    b.step();
    assert_eq!((b.reg(1), b.reg(5)), (0x0302, 0x0034));
}

#[test]
fn program_counter_as_operand() {
    // As a source it is the address after the instruction word.
    let mut b = board(&op2("mov", false, S::R(0), D::R(5), CODE));
    b.step();
    assert_eq!(b.reg(5), CODE + 2);
    let mut b = board(&op2("mov", false, S::R(0), D::Abs(DST), CODE));
    b.step();
    assert_eq!((b.peek16(DST), b.reg(0)), (CODE + 2, CODE + 4));
    // As a destination it is the address of the next instruction.
    let mut b = board(&op2("add", false, S::Imm(0x0010), D::R(0), CODE));
    b.step();
    assert_eq!(b.reg(0), CODE + 4 + 0x10);
    // A table jump by `mov table(r5), pc`, odd entry rounded down.
    let mut b = board(&op2("mov", false, S::X(5, DST), D::R(0), CODE));
    b.set_reg(5, 2);
    b.poke16(DST + 2, 0xD003);
    b.step();
    assert_eq!(b.reg(0), 0xD002);
}

#[test]
fn status_register_is_read_before_and_written_after_the_flags() {
    let mut b = board(&op2("add", false, S::R(2), D::R(5), CODE));
    b.set_reg(2, 0x0105);
    b.set_reg(5, 1);
    b.step();
    assert_eq!((b.reg(5), b.reg(2)), (0x0106, 0));
    let mut b = board(&op2("sub", false, S::Imm(0x0001), D::R(2), CODE));
    b.set_reg(2, 0x0101);
    b.step();
    assert_eq!(b.reg(2), 0x0100);
}

#[test]
fn increment_comes_before_the_destination_address() {
    let mut b = board(&op2("mov", false, S::Inc(7), D::X(7, 0), CODE));
    b.set_reg(7, SRC);
    b.poke16(SRC, 0x1234);
    b.step();
    assert_eq!((b.peek16(SRC + 2), b.reg(7)), (0x1234, SRC + 2));
    let mut b = board(&op2("add", false, S::Inc(7), D::R(7), CODE));
    b.set_reg(7, SRC);
    b.poke16(SRC, 0x0010);
    b.step();
    assert_eq!(b.reg(7), SRC + 2 + 0x10);
}

#[test]
fn words_at_odd_addresses_are_rounded_down_and_reported() {
    let mut b = board(&op2("mov", false, S::Abs(SRC + 1), D::Abs(DST + 1), CODE));
    b.poke16(SRC, 0x1234);
    b.step();
    assert_eq!(b.peek16(DST), 0x1234);
    assert!(
        b.warnings().iter().any(|w| w.kind == WarningKind::Unaligned && w.pc == u32::from(CODE))
    );
}

#[test]
fn byte_results_in_registers_clear_the_high_byte_also_of_constants() {
    let mut b = board(&op2("mov", true, S::Cg(-1), D::R(5), CODE));
    b.set_reg(5, 0x1234);
    b.step();
    assert_eq!(b.reg(5), 0x00FF);
}

#[test]
fn what_is_no_instruction_or_no_memory_is_reported() {
    for word in [0x0000, 0x13C0, 0x1400, 0x1FFF, 0x10C5] {
        let mut b = board(&[word]);
        b.step();
        let kinds: Vec<_> = b.warnings().iter().map(|w| w.kind).collect();
        assert_eq!(kinds, [WarningKind::IllegalInstruction], "{word:#06x}");
    }
    let mut b = board(&op2("mov", false, S::Abs(0x0500), D::R(5), CODE));
    b.step();
    assert_eq!((b.reg(5), b.warnings()[0].kind), (0x3FFF, WarningKind::Unmapped));
    let mut b = board(&op2("mov", false, S::Imm(0x0100), D::R(0), CODE));
    b.step();
    b.step();
    b.step();
    assert_eq!(b.last_reset(), emulator::Reset::Fetch);
}
