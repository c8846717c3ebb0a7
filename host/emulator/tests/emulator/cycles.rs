//! Cycle counts of the MSP430 CPU for every mode: SLAU144, tables 3-14 to 3-16, as numbers.

use crate::asm::{D, DOUBLE, RETI, S, jump, op1, op2};
use crate::{CODE, board};

/// Address of a word in RAM; R5 points there.
const DATA: u16 = 0x0300;

fn cycles_of(code: &[u16]) -> u64 {
    let mut board = board(code);
    board.set_reg(1, 0x03F0);
    for n in 4..16 {
        board.set_reg(n, DATA);
    }
    // A return address that RETI and jumps to memory contents may use.
    for at in (0x0280..0x0400).step_by(2) {
        board.poke16(at, CODE);
    }
    let before = board.cycles();
    board.step();
    board.cycles() - before
}

#[test]
fn two_operand_instructions_take_what_the_table_says() {
    // Source; cycles to a register, to PC, to memory.
    let rows: [(S, u64, u64, u64); 14] = [
        (S::R(5), 1, 2, 4),
        (S::Cg(0), 1, 2, 4),
        (S::Cg(1), 1, 2, 4),
        (S::Cg(2), 1, 2, 4),
        (S::Cg(4), 1, 2, 4),
        (S::Cg(8), 1, 2, 4),
        (S::Cg(-1), 1, 2, 4),
        (S::At(5), 2, 2, 5),
        (S::Inc(5), 2, 3, 5),
        (S::Imm(0x1234), 2, 3, 5),
        (S::X(5, 2), 3, 3, 6),
        (S::Sym(DATA), 3, 3, 6),
        (S::Abs(DATA), 3, 3, 6),
        (S::X(1, 2), 3, 3, 6),
    ];
    for name in DOUBLE {
        for byte in [false, true] {
            for (src, register, pc, memory) in rows {
                let columns = [
                    (D::R(6), register),
                    (D::R(0), pc),
                    (D::X(6, 4), memory),
                    (D::Sym(DATA), memory),
                    (D::Abs(DATA), memory),
                ];
                for (dst, want) in columns {
                    let got = cycles_of(&op2(name, byte, src, dst, CODE));
                    assert_eq!(got, want, "{name} byte={byte} {src:?}, {dst:?}");
                }
            }
        }
    }
}

#[test]
fn one_operand_instructions_take_what_the_table_says() {
    // Source; cycles of RRA, RRC, SWPB, SXT; of PUSH; of CALL.
    let rows: [(S, Option<u64>, u64, u64); 8] = [
        (S::R(5), Some(1), 3, 4),
        (S::At(5), Some(3), 4, 4),
        (S::Inc(5), Some(3), 5, 5),
        (S::Imm(CODE), None, 4, 5),
        (S::X(5, 2), Some(4), 5, 5),
        (S::Sym(DATA), Some(4), 5, 5),
        (S::Abs(DATA), Some(4), 5, 5),
        (S::Cg(2), None, 3, 4),
    ];
    for (src, shift, push, call) in rows {
        for name in ["rrc", "swpb", "rra", "sxt"] {
            if let Some(want) = shift {
                assert_eq!(cycles_of(&op1(name, false, src, CODE)), want, "{name} {src:?}");
            }
        }
        for byte in [false, true] {
            assert_eq!(cycles_of(&op1("push", byte, src, CODE)), push, "push {src:?}");
        }
        assert_eq!(cycles_of(&op1("call", false, src, CODE)), call, "call {src:?}");
    }
    assert_eq!(cycles_of(&[RETI]), 5);
}

#[test]
fn jumps_take_two_cycles_taken_or_not() {
    for condition in 0..8 {
        for flags in [0, 1, 2, 4, 0x100, 0x104] {
            let mut board = board(&[jump(condition, 5)]);
            board.set_reg(2, flags);
            let before = board.cycles();
            board.step();
            assert_eq!(board.cycles() - before, 2);
        }
    }
}

#[test]
fn interrupt_entry_takes_six_cycles_and_a_reset_four() {
    let mut board = board(&[0x4303, 0x4303, 0x4303]);
    board.set_reg(1, 0x0400);
    board.poke16(0xFFE4, 0xD000);
    // P1IFG and P1IE, then GIE.
    board.bus_write8(0x23, 0x01);
    board.bus_write8(0x25, 0x01);
    board.set_reg(2, 0x0008);
    let before = board.cycles();
    board.step();
    assert_eq!(board.cycles() - before, 6);
    assert_eq!(board.reg(0), 0xD000);
    assert_eq!(board.peek16(0x03FE), CODE);
    assert_eq!(board.peek16(0x03FC), 0x0008);
    assert_eq!(board.reg(2), 0);
    let before = board.cycles();
    board.reset_pin();
    // 15 ticks a cycle at the rate after reset.
    assert_eq!(board.cycles() - before, 4 * 15);
}
