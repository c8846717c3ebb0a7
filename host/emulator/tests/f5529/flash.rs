//! Flash: who waits and how long, what may be read meanwhile, and power cuts.

use emulator::{Board, FlashSpeed, Silicon, Stop, WarningKind};

use crate::{CODE, US, board_on, full_speed, run_from_ram};

const FCTL1: u32 = 0x0140;
const FCTL3: u32 = 0x0144;
const FAR: u32 = 0x1_4400;

fn ready(silicon: Silicon, code: &[u16]) -> Board {
    let mut b = board_on(silicon, code);
    full_speed(&mut b);
    b.bus_write16(FCTL3, 0xA500);
    b
}

fn warned(b: &Board, kind: WarningKind) -> bool {
    b.warnings().iter().any(|w| w.kind == kind)
}

/// MOV R6,0(R5) from flash: ticks that it takes.
fn store_from_flash(b: &mut Board, at: u32, value: u16) -> u64 {
    b.poke16(CODE, 0x4685);
    b.poke16(CODE + 2, 0);
    b.set_reg(0, CODE);
    b.set_reg(5, at);
    b.set_reg(6, value);
    let before = b.cycles();
    b.step();
    b.cycles() - before
}

#[test]
fn code_in_flash_is_held_for_the_times_of_the_data_sheet() {
    for (speed, word, erase) in [
        (FlashSpeed::Fast, 64, 23_000),
        (FlashSpeed::Typical, 74, 27_500),
        (FlashSpeed::Slow, 85, 32_000),
    ] {
        let mut b = ready(Silicon { flash: speed, ..Silicon::default() }, &[]);
        b.bus_write16(FCTL1, 0xA540);
        assert_eq!(store_from_flash(&mut b, FAR, 0x1234) / US, word);
        assert_eq!(b.peek16(FAR), 0x1234);
        // Bits only go from 1 to 0.
        store_from_flash(&mut b, FAR, 0xFF00);
        assert_eq!(b.peek16(FAR), 0x1200);
        b.bus_write16(FCTL1, 0xA502);
        assert_eq!(store_from_flash(&mut b, FAR + 100, 0) / US, erase);
        assert_eq!(b.peek16(FAR), 0xFFFF);
        assert_eq!(b.wear().erases[&FAR], 1);
        assert!(b.warnings().is_empty(), "{:?}", b.warnings());
    }
}

/// Starts an erase from RAM: the dummy write, then NOPs and a loop.
fn erase_from_ram(b: &mut Board, at: u32) {
    b.bus_write16(FCTL1, 0xA502);
    run_from_ram(b, 0x3000, &[0x4685, 0x0000, 0x4303, 0x4303, 0x3FFD]);
    b.set_reg(5, at);
    b.step();
}

#[test]
fn code_in_ram_goes_on_and_polls_busy() {
    let mut b = ready(Silicon::default(), &[]);
    erase_from_ram(&mut b, FAR);
    assert_eq!(b.bus_read16(FCTL3) & 1, 1);
    assert_eq!(b.bus_read16(CODE), 0x3FFF, "flash is not to be read");
    assert!(warned(&b, WarningKind::FlashBusy));
    b.run_us(27_400);
    assert_eq!(b.bus_read16(FCTL3) & 1, 1);
    b.run_us(200);
    assert_eq!(b.bus_read16(FCTL3) & 1, 0);
    assert_eq!(b.bus_read16(FAR), 0xFFFF);
}

#[test]
fn a_write_while_busy_is_a_violation_and_changes_nothing() {
    let mut b = ready(Silicon::default(), &[]);
    erase_from_ram(&mut b, FAR);
    b.bus_write16(0x1_8000, 0x1234);
    assert_ne!(b.bus_read16(FCTL3) & 4, 0);
    b.run_us(30_000);
    assert_eq!(b.peek16(0x1_8000), 0xFFFF);
}

/// Section 14 of the part's notes: nobody knows whether interrupts wait.
#[test]
fn interrupts_while_busy_are_taken_or_not_as_the_silicon_is() {
    for taken in [false, true] {
        let mut b = ready(Silicon { interrupts_while_busy: taken, ..Silicon::default() }, &[]);
        b.bus_write16(0x0180, 1);
        b.poke16(0x43EA, 0x3800);
        b.poke16(0x3800, 0x3FFF);
        b.set_reg(1, 0x4300);
        erase_from_ram(&mut b, FAR);
        b.bus_write16(0x0342, 0x0011);
        b.set_reg(2, 8);
        b.run_us(1000);
        assert_eq!(b.reg(0) == 0x3800, taken);
        b.run_us(30_000);
        assert_eq!(b.reg(0), 0x3800, "then at the latest");
    }
}

#[test]
fn a_bank_erase_from_ram_takes_a_bank_and_leaves_the_others_readable() {
    let mut b = ready(Silicon::default(), &[0x1234]);
    for at in [0x1_43FEu32, 0x1_4400, 0x1_C3FE, 0x1_C400] {
        b.poke16(at, 0);
    }
    b.bus_write16(FCTL1, 0xA504);
    run_from_ram(&mut b, 0x3000, &[0x4685, 0x0000, 0x3FFF]);
    b.set_reg(5, 0x1_8000);
    b.step();
    assert_eq!(b.bus_read16(CODE), 0x1234, "another bank");
    assert_eq!(b.bus_read16(0x1_8000), 0x3FFF);
    b.run_us(33_000);
    let after = [0x1_43FEu32, 0x1_4400, 0x1_C3FE, 0x1_C400].map(|at| b.peek16(at));
    assert_eq!(after, [0, 0xFFFF, 0xFFFF, 0]);
}

#[test]
fn a_bank_erase_from_flash_is_erratum_flash34() {
    let mut b = ready(Silicon::default(), &[]);
    b.bus_write16(FCTL1, 0xA504);
    store_from_flash(&mut b, 0x1_C400, 0);
    assert!(warned(&b, WarningKind::FlashErratum));
}

#[test]
fn long_words_are_written_in_pairs_or_refused_as_the_silicon_is() {
    for pairs in [true, false] {
        let mut b = ready(Silicon { long_word_pairs: pairs, ..Silicon::default() }, &[]);
        b.bus_write16(FCTL1, 0xA580);
        let first = store_from_flash(&mut b, FAR, 0x1111);
        let second = store_from_flash(&mut b, FAR + 2, 0x2222);
        assert!(first < US, "the first half only waits for the second");
        if pairs {
            assert_eq!((b.peek16(FAR), b.peek16(FAR + 2)), (0x1111, 0x2222));
            assert_eq!((second / US, b.wear().operations), (74, 1));
        } else {
            assert_eq!((b.peek16(FAR), b.bus_read16(FCTL3) & 4), (0xFFFF, 4));
        }
    }
}

#[test]
fn a_block_is_written_from_ram_with_its_waits() {
    let mut b = ready(Silicon::default(), &[]);
    b.bus_write16(FCTL1, 0xA5C0);
    run_from_ram(&mut b, 0x3000, &[0x4685, 0x0000, 0x4685, 0x0002, 0x3FFF]);
    b.set_reg(5, FAR);
    b.set_reg(6, 0xABCD);
    for n in 0..32u32 {
        b.set_reg(0, 0x3000);
        b.set_reg(5, FAR + 4 * n);
        b.step();
        b.step();
        assert_eq!(b.bus_read16(FCTL3) & 9, 1, "busy, not to be written");
        b.run_us(60);
        assert_eq!(b.bus_read16(FCTL3) & 9, 9, "busy, but ready for the next");
    }
    b.bus_write16(FCTL1, 0xA540);
    b.run_us(70);
    assert_eq!(b.bus_read16(FCTL3) & 1, 0);
    assert!((FAR..FAR + 128).step_by(2).all(|at| b.peek16(at) == 0xABCD));
    assert!(b.warnings().iter().all(|w| w.kind == WarningKind::Unmapped), "{:?}", b.warnings());
    // From flash it is not allowed.
    b.bus_write16(FCTL1, 0xA5C0);
    store_from_flash(&mut b, FAR + 128, 0);
    assert!(warned(&b, WarningKind::FlashErratum));
    assert_ne!(b.bus_read16(FCTL3) & 0x10, 0, "locked");
}

#[test]
fn locks_protect_and_are_named() {
    let mut b = ready(Silicon::default(), &[]);
    b.bus_write16(FCTL1, 0xA540);
    // Segment A is locked until LOCKA is written with 1.
    store_from_flash(&mut b, 0x1980, 0);
    assert!(warned(&b, WarningKind::FlashLocked));
    b.bus_write16(FCTL3, 0xA540);
    store_from_flash(&mut b, 0x1980, 0);
    assert_eq!(b.peek16(0x1980), 0);
    b.bus_write16(0x0146, 0xA580);
    store_from_flash(&mut b, 0x1880, 0);
    assert_eq!(b.peek16(0x1880), 0xFFFF, "LOCKINFO");
    b.bus_write16(FCTL3, 0xA510);
    store_from_flash(&mut b, FAR, 0);
    assert_eq!(b.peek16(FAR), 0xFFFF, "LOCK");
}

#[test]
fn a_row_has_16_ms_between_erases() {
    let mut b = ready(Silicon { flash: FlashSpeed::Slow, ..Silicon::default() }, &[]);
    b.bus_write16(FCTL1, 0xA540);
    for n in 0..188u32 {
        store_from_flash(&mut b, FAR + n % 64 * 2, 0xFFFF);
    }
    assert!(!warned(&b, WarningKind::FlashRowTime));
    store_from_flash(&mut b, FAR, 0xFFFF);
    assert!(warned(&b, WarningKind::FlashRowTime));
}

#[test]
fn a_low_supply_is_noticed() {
    // At the core level of a reset the supervisor would not mind.
    let mut b = board_on(Silicon::default(), &[]);
    b.bus_write16(FCTL3, 0xA500);
    b.set_supply(1_700);
    b.bus_write16(FCTL1, 0xA540);
    store_from_flash(&mut b, FAR, 0);
    assert!(warned(&b, WarningKind::FlashSupply));
}

#[test]
fn power_can_be_cut_at_every_operation_and_between_clones() {
    let mut b = ready(Silicon::default(), &[]);
    b.stop_at_flash(true);
    b.bus_write16(FCTL1, 0xA540);
    b.poke16(CODE, 0x4685);
    b.poke16(CODE + 2, 0);
    b.set_reg(0, CODE);
    b.set_reg(5, FAR);
    b.set_reg(6, 0);
    let mut cut = b.clone();
    assert_eq!(b.run_us(1000), Stop::Flash);
    assert_eq!(b.peek16(FAR), 0);
    cut.cut_at_flash_operation(1, 7);
    assert_eq!(cut.run_us(1000), Stop::NoPower);
    assert!(!cut.powered());
    assert_ne!(cut.peek16(FAR), 0, "some bits only");
    cut.power_up();
    assert!(cut.powered());
    assert_eq!(cut.reg(0), CODE as u16);
}

#[test]
fn power_lost_in_the_middle_of_an_erase_from_ram_leaves_a_torn_segment() {
    let mut b = ready(Silicon::default(), &[]);
    (0..512u32).for_each(|n| b.poke8(FAR + n, n as u8));
    erase_from_ram(&mut b, FAR);
    b.run_us(5_000);
    b.power_cut();
    let segment: Vec<u8> = (0..512u32).map(|n| b.peek8(FAR + n)).collect();
    assert!(segment.iter().any(|byte| *byte != 0xFF));
}

#[test]
fn flash_content_survives_as_one_piece() {
    let mut b = ready(Silicon::default(), &[]);
    b.poke16(0x2_43FE, 0x55AA);
    b.poke16(0x1800, 0x1122);
    let content = b.flash_contents();
    assert_eq!(content.len(), 512 + 131_072);
    let mut other = ready(Silicon::default(), &[]);
    other.set_flash_contents(&content).expect("same part");
    assert_eq!((other.peek16(0x2_43FE), other.peek16(0x1800)), (0x55AA, 0x1122));
}
