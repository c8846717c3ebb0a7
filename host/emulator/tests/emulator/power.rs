//! Flash controller, its timing, and power that fails.

use emulator::{Board, Reset, Stop, WarningKind};

use crate::asm::{D, S, op2};
use crate::{CODE, IDLE, board};

const FCTL1: u16 = 0x128;
const FCTL2: u16 = 0x12A;
const FCTL3: u16 = 0x12C;
const SEGMENT: u16 = 0xF200;
/// SMCLK / 35 = 457 kHz.
const DIVIDER: u16 = 0xA580 | 34;

/// Flash unlocked in `mode`, about to execute `MOV #value, &addr` from flash.
fn write_board(mode: u16, addr: u16, value: u16) -> Board {
    let mut b = board(&op2("mov", false, S::Imm(value), D::Abs(addr), CODE));
    b.bus_write16(FCTL2, DIVIDER);
    b.bus_write16(FCTL3, 0xA500);
    b.bus_write16(FCTL1, 0xA500 | mode);
    b
}

#[test]
fn a_word_write_takes_30_cycles_and_only_clears_bits() {
    let mut b = write_board(0x40, SEGMENT, 0x1234);
    b.poke16(SEGMENT, 0xFF30);
    let start = b.cycles();
    b.step();
    assert_eq!(b.cycles() - start, 5 + 30 * 35);
    assert_eq!(b.peek16(SEGMENT), 0x1230);
    assert!(b.warnings().is_empty());
}

#[test]
fn erases_take_4819_and_10593_cycles() {
    let mut b = write_board(0x02, SEGMENT + 6, 0);
    b.poke16(SEGMENT, 0x1234);
    b.poke16(SEGMENT + 510, 0x1234);
    b.poke16(SEGMENT + 512, 0x1234);
    b.poke16(SEGMENT - 2, 0x1234);
    let start = b.cycles();
    b.step();
    assert_eq!(b.cycles() - start, 5 + 4819 * 35);
    let words = [SEGMENT, SEGMENT + 510, SEGMENT + 512, SEGMENT - 2].map(|at| b.peek16(at));
    assert_eq!(words, [0xFFFF, 0xFFFF, 0x1234, 0x1234]);
    assert_eq!(b.wear().erases[&SEGMENT.into()], 1);

    let mut b = write_board(0x04, SEGMENT, 0);
    let calibration = b.peek16(0x10F8);
    let start = b.cycles();
    b.step();
    assert_eq!(b.cycles() - start, 5 + 10_593 * 35);
    assert_eq!((b.peek16(CODE), b.peek16(0x10F8)), (0xFFFF, calibration));
}

#[test]
fn information_segments_are_64_bytes_and_a_is_locked() {
    let mut b = write_board(0x02, 0x1040, 0);
    for at in (0x1000..0x10C0).step_by(2) {
        b.poke16(at, 0);
    }
    b.step();
    let left = (0x1000..0x10C0).filter(|at| b.peek8(*at) == 0).count();
    assert_eq!(left, 128);

    let mut b = write_board(0x02, 0x10C0, 0);
    let before = b.peek16(0x10F8);
    b.step();
    assert_eq!(b.peek16(0x10F8), before);
    assert_eq!(b.warnings()[0].kind, WarningKind::FlashLocked);
    // LOCKA toggles when a 1 is written to it.
    b.bus_write16(FCTL3, 0xA540);
    assert_eq!(b.bus_read16(FCTL3) & 0x40, 0);
    b.set_reg(0, CODE);
    b.step();
    assert_eq!(b.peek16(0x10F8), 0xFFFF);
}

#[test]
fn locked_flash_stays_and_is_reported() {
    let mut b = board(&op2("mov", false, S::Imm(0), D::Abs(SEGMENT), CODE));
    b.step();
    assert_eq!(b.peek16(SEGMENT), 0xFFFF);
    assert_eq!(b.warnings()[0].kind, WarningKind::FlashLocked);
}

#[test]
fn a_wrong_key_resets_and_leaves_keyv() {
    for register in [FCTL1, FCTL2, FCTL3] {
        let mut b = board(&IDLE);
        b.bus_write16(register, 0x1200);
        b.run_for(100);
        assert_eq!(b.last_reset(), Reset::FlashKey);
        assert_eq!(b.bus_read16(FCTL3) & 0xFF02, 0x9602);
        assert_eq!(b.bus_read16(FCTL1), 0x9600);
    }
}

#[test]
fn flash_clock_and_rewriting_are_watched() {
    let mut b = write_board(0x40, SEGMENT, 0x1234);
    b.bus_write16(FCTL2, 0xA580 | 15);
    b.step();
    assert_eq!(b.warnings()[0].kind, WarningKind::FlashClock);

    let mut b = write_board(0x40, SEGMENT, 0x1234);
    for turn in 0..3 {
        assert!(b.warnings().is_empty(), "turn {turn}");
        b.set_reg(0, CODE);
        b.step();
    }
    assert_eq!(b.warnings()[0].kind, WarningKind::FlashRewritten);
}

#[test]
fn code_that_was_changed_is_decoded_anew() {
    let mut b = board(&[0x4314, 0x3FFE]);
    b.step();
    assert_eq!(b.reg(4), 1);
    b.poke16(CODE, 0x4324);
    b.set_reg(0, CODE);
    b.step();
    assert_eq!(b.reg(4), 2);
}

#[test]
fn a_cut_write_leaves_some_bits_and_no_power() {
    let mut seen = std::collections::BTreeSet::new();
    for seed in 0..50 {
        let mut b = write_board(0x40, SEGMENT, 0x0000);
        b.cut_at_flash_operation(1, seed);
        assert_eq!(b.run_for(10_000), Stop::NoPower);
        assert!(!b.powered());
        seen.insert(b.peek16(SEGMENT));
        assert_eq!(b.run_for(1000), Stop::NoPower);
        b.power_up();
        assert_eq!(b.last_reset(), Reset::Power);
    }
    assert!(seen.len() > 40, "partial bits differ from seed to seed");
}

#[test]
fn a_cut_erase_leaves_a_half_erased_segment() {
    let mut shapes = std::collections::BTreeSet::new();
    for seed in 0..40 {
        let mut b = write_board(0x02, SEGMENT, 0);
        for at in (SEGMENT..SEGMENT + 512).step_by(2) {
            b.poke16(at, 0);
        }
        b.cut_at_flash_operation(1, seed);
        assert_eq!(b.run_for(1_000_000), Stop::NoPower);
        let ones: u32 = (SEGMENT..SEGMENT + 512).map(|at| b.peek8(at).count_ones()).sum();
        shapes.insert(ones);
    }
    assert!(shapes.len() > 30);
    assert!(shapes.iter().any(|ones| *ones > 3000) && shapes.iter().any(|ones| *ones < 1000));
}

#[test]
fn flash_survives_and_ram_does_not() {
    let mut b = board(&IDLE);
    b.poke16(SEGMENT, 0x4711);
    b.poke16(0x0200, 0x4711);
    let content = b.flash_contents();
    assert_eq!(content.len(), 256 + 16 * 1024);
    b.power_cut();
    assert_eq!(b.run_us(10), Stop::NoPower);
    b.power_up();
    let words: Vec<u16> = (0x0200..0x0400).step_by(2).map(|at| b.peek16(at)).collect();
    assert!(words.iter().filter(|w| **w == 0x4711).count() < 2);
    assert_eq!(b.peek16(SEGMENT), 0x4711);
    assert_eq!(b.bus_read8(0x02) & 0x0D, 0x04, "PORIFG alone");

    let mut other = board(&IDLE);
    other.set_flash_contents(&content).expect("the right size");
    assert_eq!(other.peek16(SEGMENT), 0x4711);
    assert!(other.set_flash_contents(&content[1..]).is_err());
}

#[test]
fn bits_caught_in_a_write_read_differently_until_they_are_written_again() {
    let config = emulator::Config { unstable_bits: true, ..emulator::Config::default() };
    let code = op2("mov", false, S::Imm(0x00FF), D::Abs(SEGMENT), CODE);
    let mut b = crate::board_with(&config, &code);
    let unlock = |b: &mut Board| {
        crate::set_up(b);
        b.bus_write16(FCTL2, DIVIDER);
        b.bus_write16(FCTL3, 0xA500);
        b.bus_write16(FCTL1, 0xA540);
    };
    unlock(&mut b);
    b.cut_at_flash_operation(1, 7);
    assert_eq!(b.run_for(10_000), Stop::NoPower);
    let mut seen = std::collections::BTreeSet::new();
    for _ in 0..20 {
        b.power_up();
        seen.insert(b.peek16(SEGMENT));
    }
    assert!(seen.len() > 10);
    assert!(seen.iter().all(|word| word & 0x00FF == 0x00FF), "the others were not touched");
    // Writing the same word once more settles it.
    unlock(&mut b);
    b.step();
    for _ in 0..5 {
        b.power_up();
        assert_eq!(b.peek16(SEGMENT), 0x00FF);
    }
}

#[test]
fn without_power_no_pin_is_driven() {
    let config = emulator::Config { wiring: emulator::Wiring::Direct, ..Default::default() };
    let mut b = crate::board_with(&config, &IDLE);
    b.bus_write8(0x29, 0x25);
    b.bus_write8(0x2A, 0xFF);
    assert!(b.plant().output(1) && b.plant().output(2));
    b.record(true);
    b.power_cut();
    assert!(!b.plant().output(1) && !b.plant().output(2));
    assert!(b.take_edges().iter().all(|e| !e.level));
    b.uart_send(&[0x55; 4]);
    b.run_us(170);
    b.power_up();
    b.run_us(1000);
    assert!(b.take_edges().windows(2).all(|w| w[0].cycle <= w[1].cycle));
}

#[test]
fn a_cut_stops_the_time_at_its_instant() {
    let mut b = write_board(0x40, SEGMENT, 0);
    b.cut_at_flash_operation(1, 1);
    let start = b.cycles();
    assert_eq!(b.run_for(10_000), Stop::NoPower);
    assert!(b.cycles() - start < 10);
    assert_eq!(b.run_until(start + 10_000), Stop::NoPower);
    assert_eq!(b.cycles(), start + 10_000);
}

#[test]
fn the_stack_limit_is_the_end_of_the_data_that_the_image_names() {
    let push = crate::asm::op1("push", false, S::R(4), CODE);
    let bytes: Vec<u8> = push.iter().flat_map(|w| w.to_le_bytes()).collect();
    for (end, warned) in [(0x02FE, false), (0x0300, true)] {
        let mut image = emulator::Image::from_bytes(CODE, &bytes).expect("code");
        image.symbols.insert("_ebss".into(), end);
        let mut b = Board::new(emulator::Part::G2553, &image);
        crate::set_up(&mut b);
        b.set_reg(1, 0x0300);
        b.step();
        assert_eq!(b.warnings().iter().any(|w| w.kind == WarningKind::Stack), warned);
    }
}

#[test]
fn every_cut_of_a_run_can_be_tried_from_clones() {
    // Writes 0 to eight words, then idles.
    let mut code = Vec::new();
    for n in 0..8 {
        let at = CODE + 2 * code.len() as u16;
        code.extend(op2("mov", false, S::Imm(0), D::Abs(SEGMENT + 2 * n), at));
    }
    code.extend(IDLE);
    let mut b = board(&code);
    b.bus_write16(FCTL2, DIVIDER);
    b.bus_write16(FCTL3, 0xA500);
    b.bus_write16(FCTL1, 0xA540);
    b.stop_at_flash(true);
    let mut cuts = 0;
    loop {
        let mut other = b.clone();
        other.cut_at_flash_operation(1, cuts);
        if other.run_for(2000) == Stop::NoPower {
            let zeros = (0..8).filter(|n| other.peek16(SEGMENT + 2 * n) == 0).count();
            assert!(zeros as u64 == cuts || zeros as u64 == cuts + 1);
            cuts += 1;
        }
        if b.run_for(2000) != Stop::Flash {
            break;
        }
    }
    assert_eq!(cuts, 8);
    assert_eq!(b.wear().operations, 8);
}

#[test]
fn a_clone_goes_on_as_the_original_does() {
    let mut b = board(&IDLE);
    b.record(true);
    b.uart_send(&[0x12, 0x34]);
    b.uart_send_at(b.cycles() + 10_000, &[0x56]);
    b.run_us(50);
    let mut twin = b.clone();
    for board in [&mut b, &mut twin] {
        board.run_us(2000);
    }
    assert_eq!(b.cycles(), twin.cycles());
    let edges = b.take_edges();
    assert!(edges.len() > 10);
    assert_eq!(edges, twin.take_edges());
}
