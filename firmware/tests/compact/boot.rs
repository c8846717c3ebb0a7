//! From reset to the main loop: clock and pins, the profile, what a reset broke off, the log.

use lang::fault::Fault;
use lang::part::G2553;
use lang::record::BoardRecord;
use lang::wire::{CRC_START, Exception, RunState, crc16};

use crate::chip::Chip;

/// IFG1 (SLAU144, 2.2.4): bit 0 watchdog, 2 power on, 3 RST pin.
const IFG1: u16 = 0x0002;
/// TA0CCTL0: the millisecond's interrupt.
const TACCTL0: u16 = 0x0162;
const WATCHDOG: u8 = 1 << 0;
const POWER: u8 = 1 << 2;
const PIN: u8 = 1 << 3;
/// Segment D, the log of faults.
const LOG: u16 = 0x1000;

/// Boots after a reset for this cause; what RAM keeps over one holds.
fn reset(chip: &mut Chip, cause: u8) {
    let first = chip.at("STEP_SLOT");
    for address in (first..0x0400).step_by(2) {
        chip.board.poke16(address, 0);
    }
    chip.board.bus_write8(IFG1, cause);
    chip.call("boot", &[]);
    // No millisecond comes between the calls of a test.
    chip.board.bus_write16(TACCTL0, 0);
}

/// The 32 words of a profile, its CRC made right.
fn record(sequence: u16, address: u8) -> Vec<u16> {
    let flags = BoardRecord::CHAIN;
    let head = [sequence, BoardRecord::DEFAULT.version, flags, u16::from(address)];
    let mut words: Vec<u16> = (0..31).map(|at| head.get(at).copied().unwrap_or(0)).collect();
    let bytes = words.iter().flat_map(|word| word.to_le_bytes());
    words.push(bytes.fold(CRC_START, crc16));
    words
}

fn write_profile(chip: &mut Chip, words: &[u16]) -> u16 {
    for (index, &word) in words.iter().enumerate() {
        chip.call("profile_word", &[(12, index as u16), (13, word)]);
        if chip.reg(12) != 0 {
            assert_eq!(index, 31, "word {index} is not taken");
        }
    }
    chip.reg(12)
}

#[test]
fn an_erased_board_starts_with_the_default_profile() {
    let mut chip = Chip::new();
    chip.board.bus_write8(IFG1, POWER);
    chip.call("boot", &[]);
    assert_eq!(chip.word("BOARD"), chip.at("BOARD_DEFAULT"));
    assert_eq!(chip.word("STORED"), 0);
    assert_eq!(chip.word("VM_CODE"), 0);
    assert_eq!(chip.byte("CAUSE"), POWER);
    assert_eq!(chip.board.bus_read8(IFG1), 0);
    assert_eq!(chip.byte("VM_FAULT"), 0);
    assert_eq!(chip.byte("FAULT_IN"), 0);
    assert_eq!(chip.byte("RUN"), RunState::Empty as u8);
    assert_eq!(chip.board.warnings(), &[]);
}

#[test]
fn a_watchdog_reset_leaves_no_timer_armed() {
    // TA0CCTL1, and TA1CCTL0 to TA1CCTL2, which such a reset does not clear.
    const CONTROLS: [u16; 4] = [0x0164, 0x0182, 0x0184, 0x0186];
    // Output mode and interrupt enable (SLAU144, 12.3).
    const ARMED: u16 = 0x00F0;
    let mut chip = Chip::new();
    CONTROLS.into_iter().for_each(|register| chip.board.bus_write16(register, 0x0030));
    reset(&mut chip, WATCHDOG);
    for register in CONTROLS {
        assert_eq!(chip.board.bus_read16(register) & ARMED, 0, "{register:04X}");
    }
}

#[test]
fn the_profile_takes_turns_between_two_copies() {
    let mut chip = Chip::new();
    reset(&mut chip, POWER);
    for (sequence, copy) in [(1, 0), (2, 1), (3, 0), (4, 1)] {
        assert_eq!(write_profile(&mut chip, &record(sequence, 7)), 0);
        reset(&mut chip, POWER);
        assert_eq!(chip.word("BOARD"), G2553.profiles[copy], "sequence {sequence}");
    }
    let mut damaged = record(5, 9);
    damaged[3] ^= 2;
    assert_eq!(write_profile(&mut chip, &damaged), Exception::DeviceFailure as u16);
    reset(&mut chip, POWER);
    assert_eq!(chip.word("BOARD"), G2553.profiles[1], "the old one holds");
}

#[test]
fn a_profile_cut_anywhere_leaves_the_old_one_or_the_new() {
    let mut before = Chip::new();
    reset(&mut before, POWER);
    write_profile(&mut before, &record(1, 7));
    reset(&mut before, POWER);
    let mut cuts = 0;
    loop {
        let mut chip = before.clone();
        chip.board.cut_at_flash_operation(cuts + 1, cuts);
        let done = record(2, 8).iter().enumerate().all(|(index, &word)| {
            chip.try_call("profile_word", &[(12, index as u16), (13, word)]).is_some()
        });
        chip.restart();
        reset(&mut chip, POWER);
        let address = chip.board.peek8(chip.word("BOARD") + 6);
        if done {
            assert_eq!((address, cuts), (8, 33));
            break;
        }
        cuts += 1;
        assert!(address == 7 || address == 8, "cut {cuts}: {address}");
    }
}

#[test]
fn a_run_that_a_reset_broke_off_is_a_fault() {
    let broken_off = |cause, runs| {
        let mut chip = Chip::new();
        let mark = if runs { chip.at("RUNS_MARK") } else { 0 };
        chip.set_word("RUNNING", mark);
        reset(&mut chip, cause);
        assert_ne!(chip.word("RUNNING"), chip.at("RUNS_MARK"));
        assert_eq!(chip.byte("RUN") == RunState::Fault as u8, chip.byte("VM_FAULT") != 0);
        chip.byte("VM_FAULT")
    };
    assert_eq!(broken_off(WATCHDOG, true), Fault::Watchdog.number());
    assert_eq!(broken_off(PIN, true), Fault::EmergencyStop.number());
    assert_eq!(broken_off(POWER | PIN, true), 0);
    assert_eq!(broken_off(WATCHDOG, false), 0);
}

#[test]
fn the_last_fault_survives_power_off() {
    let mut chip = Chip::new();
    reset(&mut chip, POWER);
    // Eight records fill the log: the ninth erases it.
    for number in 1..20u8 {
        chip.set_byte("VM_FAULT", number);
        chip.set_byte("FAULT_IN", 20 - number);
        chip.set_word("VM_FAULT_PC", chip.word("VM_CODE") + u16::from(number));
        chip.call("fault_log", &[]);
        let at = LOG + 8 * u16::from((number - 1) % 8);
        let words = [0, 2, 4, 6].map(|offset| chip.board.peek16(at + offset));
        assert_eq!(words[..2], [u16::from_le_bytes([number, 20 - number]), u16::from(number)]);
        assert_eq!(words[3], words[0] ^ words[1] ^ words[2]);
        chip.restart();
        reset(&mut chip, POWER);
        assert_eq!(chip.byte("VM_FAULT"), number);
        assert_eq!(chip.byte("FAULT_IN"), 20 - number);
        assert_eq!(chip.word("VM_FAULT_PC"), chip.word("VM_CODE") + u16::from(number));
    }
    assert_eq!(chip.board.wear().erases[&LOG.into()], 2);
}

#[test]
fn the_stack_tells_how_deep_it_has_been() {
    let mut chip = Chip::new();
    let (first, last) = (chip.at("POOL_END"), 0x03FF);
    chip.board.paint(first, last, 0xA5);
    chip.board.poke16(first + 30, 0x1234);
    chip.call("stack_free", &[]);
    assert_eq!(chip.reg(12), 30);
}
