//! Rules of the 20-bit CPU that tables do not show: register widths, address sums, interrupts,
//! and what the emulator warns of.

use emulator::{Board, WarningKind};

use crate::{CODE, board};

fn after(code: &[u16], registers: &[(usize, u32)]) -> Board {
    let mut board = board(code);
    for (n, value) in registers {
        board.set_reg(*n, *value);
    }
    board.step();
    board
}

#[test]
fn widths_clear_what_is_above_them() {
    let top = &[(5usize, 0xA_BCDEu32), (6, 0xF_FFFF)];
    assert_eq!(after(&[0x4506], top).far_reg(6), 0xBCDE, "MOV.W R5,R6");
    assert_eq!(after(&[0x4546], top).far_reg(6), 0xDE, "MOV.B R5,R6");
    assert_eq!(after(&[0x05C6], top).far_reg(6), 0xA_BCDE, "MOVA R5,R6");
    assert_eq!(after(&[0x1185], &[(5, 0x0080)]).far_reg(5), 0xF_FF80, "SXT R5");
    assert_eq!(after(&[0x1085], &[(5, 0x1234)]).far_reg(5), 0x3412, "SWPB R5");
    assert_eq!(after(&[0x5316], top).far_reg(6), 0, "INC R6 on 16 bits");
}

#[test]
fn near_sums_stay_below_64_kb_and_far_ones_do_not() {
    let read = |code: &[u16], base: u32, at: u32| {
        let mut b = board(code);
        b.set_reg(5, base);
        b.poke16(at, 0x77AA);
        b.step();
        b.reg(6) == 0x77AA
    };
    // MOV X(R5),R6: wraps below 64 KB, sign-extended above.
    assert!(read(&[0x4516, 0x2500], 0xFF00, 0x2400));
    assert!(read(&[0x4516, 0xE000], 0x1_2000, 0x1_0000));
    assert!(read(&[0x4516, 0x8000], 0x1_2000, 0xA000), "may run down below 64 KB");
    // MOVA 3(R5): signed 16 bits, 20-bit sum.
    let mut b = board(&[0x0536, 0x2500]);
    b.set_reg(5, 0xFF00);
    b.poke16(0x1_2400, 0x3456);
    b.poke16(0x1_2402, 0xFFF7);
    b.step();
    assert_eq!(b.far_reg(6), 0x7_3456);
    // MOVX.W with 20 bits of X.
    assert!(read(&[0x18C0, 0x4516, 0x2345], 0x0055, 0x1_239A));
    // @Rn+ counts through the border in 20 bits.
    let mut b = board(&[0x4536, 0x4536]);
    b.set_reg(5, 0xFFFE);
    b.poke16(0x1_0000, 0x1122);
    b.step();
    b.step();
    assert_eq!((b.far_reg(5), b.reg(6)), (0x1_0002, 0x1122));
}

#[test]
fn an_interrupt_keeps_the_upper_bits_of_the_program_counter() {
    let mut b = board(&[]);
    for (n, word) in [0x4303u16, 0x4303, 0x4303].into_iter().enumerate() {
        b.poke16(0x1_2340 + 2 * n as u32, word);
    }
    b.poke16(0xFFDE, 0x5000);
    b.poke16(0x5000, 0x1300);
    b.bus_write8(0x021A, 0x01);
    b.bus_write8(0x021C, 0x01);
    b.set_reg(0, 0x1_2340);
    b.set_reg(2, 0x0009);
    b.step();
    assert_eq!(b.far_reg(0), 0x5000);
    assert_eq!((b.peek16(0x43FE), b.peek16(0x43FC)), (0x2340, 0x1009));
    b.bus_write8(0x021C, 0);
    b.step();
    assert_eq!((b.far_reg(0), b.reg(2), b.reg(1)), (0x1_2340, 0x0009, 0x4400));
}

#[test]
fn calls_push_one_word_or_two() {
    let b = after(&[0x12B0, 0x6000], &[]);
    assert_eq!((b.far_reg(0), b.reg(1), b.peek16(0x43FE)), (0x6000, 0x43FE, 0x4404));
    let mut b = after(&[0x13B1, 0x2346], &[]);
    assert_eq!((b.far_reg(0), b.reg(1)), (0x1_2346, 0x43FC));
    assert_eq!((b.peek16(0x43FE), b.peek16(0x43FC)), (0, 0x4404));
    b.poke16(0x1_2346, 0x0110);
    b.step();
    assert_eq!((b.far_reg(0), b.reg(1)), (0x4404, 0x4400), "RETA");
}

fn warned(board: &Board, kind: WarningKind) -> bool {
    board.warnings().iter().any(|w| w.kind == kind)
}

#[test]
fn a_pointer_cut_to_16_bits_is_noticed() {
    let cut = WarningKind::PointerTruncated;
    let far = &[(5usize, 0x1_4400u32)];
    for code in [0x1205u16, 0x4135, 0x5315, 0x1505, 0x1705] {
        assert!(warned(&after(&[code], far), cut), "{code:04x}");
        assert!(!warned(&after(&[code], &[(5, 0x4400)]), cut), "{code:04x}");
    }
    for code in [0x1405u16, 0x1605, 0x4305, 0x4576, 0x05E5] {
        assert!(!warned(&after(&[code], far), cut), "{code:04x}");
    }
}

#[test]
fn interrupts_on_and_off_without_an_instruction_between_are_noticed() {
    let mut close = board(&[0xD232, 0xC232]);
    let mut apart = board(&[0xD232, 0x4303, 0xC232]);
    for b in [&mut close, &mut apart] {
        for _ in 0..3 {
            b.step();
        }
    }
    assert!(warned(&close, WarningKind::InterruptsOnOff));
    assert!(!warned(&apart, WarningKind::InterruptsOnOff));
}

#[test]
fn the_word_behind_a_jump_is_looked_at_for_erratum_cpu40() {
    for (word, bad) in [(0x0040u16, true), (0x0350, true), (0x1040, false), (0x4303, false)] {
        let mut b = board(&[0x2401, word, 0x3FFF]);
        b.step();
        assert_eq!(warned(&b, WarningKind::JumpErratum), bad, "{word:04x}");
    }
}

#[test]
fn reserved_encodings_are_refused_loudly() {
    for code in [
        &[0x0000u16][..],
        &[0x13A0],
        &[0x13C0],
        &[0x1310],
        &[0x12C5],
        &[0x1800, 0x4506],
        &[0x1840, 0x1845],
        &[0x1840, 0x2405],
        &[0x14F3],
        &[0x17F3],
    ] {
        let mut b = board(code);
        b.step();
        assert!(warned(&b, WarningKind::IllegalInstruction), "{code:04x?}");
        assert_eq!(b.far_reg(0), CODE + 2);
    }
}

/// Operands whose low four bits are 0 give the flags that their upper 16 bits give as words: those
/// the G2553's tests compare with `mspdebug`.
#[test]
fn flags_of_20_bits_are_those_of_16_bits_moved_up() {
    let mut rng = emulator::Rng::new(20);
    let corners = [0u32, 1, 0x7FFF, 0x8000, 0xFFFF];
    let mut b = board(&crate::IDLE);
    let mut after = |code: &[u16], registers: [(usize, u32); 3]| {
        crate::run_from_ram(&mut b, 0x3000, code);
        for (n, value) in registers {
            b.set_reg(n, value);
        }
        b.step();
        (b.reg(2), b.far_reg(6))
    };
    // ADD, SUB, CMP, BIT, XOR, AND, then RRA, RRC on the second operand.
    let opcodes = [0x5506u16, 0x8506, 0x9506, 0xB506, 0xE506, 0xF506, 0x1106, 0x1006];
    for round in 0..4000 {
        let mut value = || match rng.below(3) {
            0 => corners[rng.below(5) as usize],
            _ => rng.bits() as u32 & 0xFFFF,
        };
        let (x, y) = (value(), value());
        let opcode = opcodes[round % opcodes.len()];
        // The bit that a shift moves out must be 0 in both.
        let y = if opcode < 0x2000 { y & !1 } else { y };
        let sr = [0u32, 1, 0x107][round % 3];
        let word = after(&[opcode], [(5, x), (6, y), (2, sr)]);
        let far = after(&[0x1800, opcode | 0x40], [(5, x << 4), (6, y << 4), (2, sr)]);
        assert_eq!((far.0, far.1 >> 4), word, "{opcode:04x} {x:x} {y:x}");
        // ADDA, SUBA, CMPA R5,R6.
        let short = match opcode {
            0x5506 => 0x05E6,
            0x8506 => 0x05F6,
            0x9506 => 0x05D6,
            _ => continue,
        };
        assert_eq!(after(&[short], [(5, x << 4), (6, y << 4), (2, sr)]), far);
    }
}
