//! Cycle counts of the MSP430X CPU: TI's tables (SLAU208, chapter 6; the same in SLAU445) as
//! numbers.

use crate::{CODE, board};

/// Address of a word in RAM; R5 to R9 point there.
const DATA: u16 = 0x3000;

fn cycles_of(code: &[u16]) -> u64 {
    let mut board = board(code);
    // The clock after a reset still moves: a tick of the watchdog's clock is not needed here.
    for n in 4..16 {
        board.set_reg(n, DATA);
    }
    board.set_reg(1, 0x4300);
    for at in (0x2F00..0x4400u32).step_by(2) {
        board.poke16(at, CODE as u16);
    }
    let cycle = cycle_ticks(&mut board);
    board.set_reg(0, CODE);
    let before = board.cycles();
    board.step();
    let ticks = board.cycles() - before;
    assert_eq!(ticks % cycle, 0);
    ticks / cycle
}

/// Ticks of one cycle, by a NOP.
fn cycle_ticks(board: &mut emulator::Board) -> u64 {
    crate::run_from_ram(board, 0x4000, &[0x4303]);
    let before = board.cycles();
    board.step();
    board.cycles() - before
}

/// As field, register and extension of a source.
type Source = (u16, u16, Option<u16>);

const RN: Source = (0, 5, None);
const AT: Source = (2, 5, None);
const INC: Source = (3, 5, None);
const IMM: Source = (3, 0, Some(0x1234));
const X: Source = (1, 5, Some(2));
const SYM: Source = (1, 0, Some(0x100));
const ABS: Source = (1, 2, Some(DATA));

fn words(first: &[u16], extensions: [Option<u16>; 2]) -> Vec<u16> {
    first.iter().copied().chain(extensions.into_iter().flatten()).collect()
}

#[test]
fn two_operands_as_the_table_says() {
    // Source; to a register, to PC, to memory, to memory for MOV, BIT and CMP.
    let rows: [(Source, [u64; 4]); 9] = [
        (RN, [1, 3, 4, 3]),
        ((0, 3, None), [1, 3, 4, 3]),
        ((2, 2, None), [1, 3, 4, 3]),
        (AT, [2, 4, 5, 4]),
        (INC, [2, 4, 5, 4]),
        (IMM, [2, 3, 5, 4]),
        (X, [3, 5, 6, 5]),
        (SYM, [3, 5, 6, 5]),
        (ABS, [3, 5, 6, 5]),
    ];
    for opcode in 4..16u16 {
        let short = matches!(opcode, 4 | 9 | 11);
        for byte in [0, 0x40] {
            for ((mode, reg, ext), [register, pc, memory, less]) in rows {
                let memory = if short { less } else { memory };
                let first = opcode << 12 | reg << 8 | byte | mode << 4;
                let cases = [
                    (words(&[first | 6], [ext, None]), register),
                    (words(&[first], [ext, None]), pc),
                    (words(&[first | 0x80 | 6], [ext, Some(4)]), memory),
                    (words(&[first | 0x82], [ext, Some(DATA)]), memory),
                    (words(&[first | 0x80], [ext, Some(0x200)]), memory),
                ];
                for (code, want) in cases {
                    assert_eq!(cycles_of(&code), want, "{code:04x?}");
                }
            }
        }
    }
}

#[test]
fn one_operand_as_the_table_says() {
    // Source; RRA and its kin, PUSH, CALL.
    let rows: [(Source, Option<u64>, u64, u64); 8] = [
        (RN, Some(1), 3, 4),
        (AT, Some(3), 3, 4),
        (INC, Some(3), 3, 4),
        (IMM, None, 3, 4),
        (X, Some(4), 4, 5),
        (SYM, Some(4), 4, 5),
        (ABS, Some(4), 4, 6),
        ((2, 2, None), None, 3, 4),
    ];
    for ((mode, reg, ext), shift, push, call) in rows {
        let operand = mode << 4 | reg;
        if let Some(want) = shift {
            for opcode in [0x1000, 0x1080, 0x1100, 0x1180] {
                assert_eq!(cycles_of(&words(&[opcode | operand], [ext, None])), want);
            }
        }
        assert_eq!(cycles_of(&words(&[0x1200 | operand], [ext, None])), push, "{operand:x}");
        assert_eq!(cycles_of(&words(&[0x1280 | operand], [ext, None])), call, "{operand:x}");
    }
    assert_eq!(cycles_of(&[0x1300]), 5, "RETI");
    assert_eq!(cycles_of(&[0x4130]), 4, "RET");
    assert_eq!(cycles_of(&[0x3C05]), 2, "JMP");
}

#[test]
fn address_instructions_as_the_table_says() {
    let rows: [(&[u16], u64); 33] = [
        (&[0x050B], 3),
        (&[0x0500], 5),
        (&[0x051B], 3),
        (&[0x0110], 5),
        (&[0x002B, DATA], 4),
        (&[0x0020, DATA], 6),
        (&[0x053B, 4], 4),
        (&[0x0530, 4], 6),
        (&[0x0B60, DATA], 4),
        (&[0x0B75, 4], 4),
        (&[0x008A, 0x4400], 2),
        (&[0x0080, 0x4400], 3),
        (&[0x009A, 1], 3),
        (&[0x00AA, 1], 3),
        (&[0x00BA, 1], 3),
        (&[0x0BCA], 1),
        (&[0x05C0], 3),
        (&[0x0BDA], 1),
        (&[0x0BEA], 1),
        (&[0x0BFA], 1),
        (&[0x004A], 1),
        (&[0x0C4A], 4),
        (&[0x095A], 3),
        (&[0x1345], 5),
        (&[0x1355, 2], 5),
        (&[0x1365], 6),
        (&[0x1375], 6),
        (&[0x1380, DATA], 7),
        (&[0x1390, 0x10], 7),
        (&[0x13B0, 0x4400], 5),
        (&[0x146B], 2 + 2 * 7),
        (&[0x1547], 2 + 5),
        (&[0x1624], 2 + 2 * 3),
    ];
    for (code, want) in rows {
        assert_eq!(cycles_of(code), want, "{code:04x?}");
    }
}

#[test]
fn extended_instructions_as_the_table_says() {
    // Source; to a register, to PC, to memory: .W and .A.
    let rows: [(Source, [[u64; 2]; 3]); 7] = [
        (RN, [[2, 2], [4, 4], [5, 7]]),
        (AT, [[3, 4], [5, 6], [6, 9]]),
        (INC, [[3, 4], [5, 6], [6, 9]]),
        (IMM, [[3, 3], [4, 4], [6, 8]]),
        (X, [[4, 5], [6, 7], [7, 10]]),
        (SYM, [[4, 5], [6, 7], [7, 10]]),
        (ABS, [[4, 5], [6, 7], [7, 10]]),
    ];
    // XOR: nothing is taken off. MOV: one less to memory, two for .A; one less to PC but from registers.
    for (opcode, moves) in [(0xE000u16, false), (0x4000, true)] {
        for ((mode, reg, ext), [register, pc, memory]) in rows {
            for (n, (prefix, byte)) in [(0x1840u16, 0), (0x1800, 0x40u16)].into_iter().enumerate() {
                let first = opcode | reg << 8 | byte | mode << 4;
                let less_pc = u64::from(moves && mode != 0);
                let less_memory = if moves { n as u64 + 1 } else { 0 };
                let cases = [
                    (words(&[prefix, first | 6], [ext, None]), register[n]),
                    (words(&[prefix, first], [ext, None]), pc[n] - less_pc),
                    (words(&[prefix, first | 0x86], [ext, Some(4)]), memory[n] - less_memory),
                ];
                for (code, want) in cases {
                    assert_eq!(cycles_of(&code), want, "{code:04x?}");
                }
            }
        }
    }
    // One operand: RRAX and PUSHX.
    let rows: [(Source, [u64; 2], [u64; 2]); 4] =
        [(RN, [2, 2], [4, 5]), (AT, [4, 6], [4, 6]), (INC, [4, 6], [4, 6]), (X, [5, 7], [5, 7])];
    for ((mode, reg, ext), shift, push) in rows {
        for (n, (prefix, byte)) in [(0x1840u16, 0), (0x1800, 0x40u16)].into_iter().enumerate() {
            for (opcode, want) in [(0x1100, shift[n]), (0x1200, push[n])] {
                let code = words(&[prefix, opcode | byte | mode << 4 | reg], [ext, None]);
                assert_eq!(cycles_of(&code), want, "{code:04x?}");
            }
        }
    }
    // Repeated: n + 1 cycles.
    assert_eq!(cycles_of(&[0x1847, 0x1106]), 9, "RPT #8 RRAX.W R6");
    assert_eq!(cycles_of(&[0x184F, 0x5606]), 17, "RPT #16 ADDX.W R6, R6");
}
