//! The emulated MSP430F5529 against its witnesses: TI's tables, published rules, Ghidra's model of
//! the MSP430X, and `mspdebug`'s disassembler.

mod clocks;
mod cpux;
mod cycles;
mod flash;
mod modules;
mod system;
mod witness;

use emulator::{Board, Config, Image, Part, Silicon};

/// Where test code is put.
pub const CODE: u32 = 0x4400;
/// Watchdog control register.
pub const WDTCTL: u32 = 0x015C;
/// What holds it.
pub const WDT_HOLD: u16 = 0x5A80;
/// `JMP $`, for tests in which only peripherals work.
pub const IDLE: [u16; 1] = [0x3FFF];
/// Ticks of a cycle at 25 MHz.
pub const CYCLE: u64 = 400;
/// Ticks of a microsecond.
pub const US: u64 = 10_000;

/// A board about to execute `code`, at the clock that a reset leaves, watchdog held.
pub fn board(code: &[u16]) -> Board {
    board_on(Silicon::default(), code)
}

/// The same with another piece of silicon.
pub fn board_on(silicon: Silicon, code: &[u16]) -> Board {
    let bytes: Vec<u8> = code.iter().flat_map(|w| w.to_le_bytes()).collect();
    let config = Config { part: Part::F5529, silicon, ..Config::default() };
    let mut board = Board::with_config(&config, &Image::from_bytes(CODE, &bytes).expect("code"));
    board.poke16(0xFFFE, CODE as u16);
    board.reset_pin();
    board.bus_write16(WDTCTL, WDT_HOLD);
    board.set_reg(0, CODE);
    board.set_reg(1, 0x4400);
    board
}

/// Core level 3 and 25 MHz from XT2, with the registers that the part's notes give.
pub fn full_speed(board: &mut Board) {
    run_from_ram(board, 0x1C00, &IDLE);
    raise_core(board);
    board.bus_write8(0x024A, 0x0C);
    for (register, value) in
        [(0x016C, 0x00CD), (0x0162, 0x0060), (0x0164, 0x0063), (0x0166, 0x0055), (0x0168, 0x0233)]
    {
        board.bus_write16(register, value);
    }
    board.run_us(40_000);
    board.bus_write16(0x016E, 0);
    board.bus_write16(0x0102, 0);
    board.set_reg(0, CODE);
    board.clear_warnings();
}

/// TI's way from one core level to the next, three times.
pub fn raise_core(board: &mut Board) {
    board.bus_write8(0x0121, 0xA5);
    for level in 1..=3u16 {
        board.bus_write16(0x012C, 0);
        let steps = [(0x0124, 0x4400 | level), (0x0124, 0x4400 | level << 8 | level)];
        for (register, value) in steps {
            board.bus_write16(register, value);
            board.run_us(150);
            assert_eq!(
                board.bus_read16(0x012C) & 0x30,
                0x10,
                "delay passed, supply is high enough"
            );
            board.bus_write16(0x012C, 0);
        }
        board.bus_write8(0x0120, level as u8);
        board.bus_write16(0x0126, 0x4400 | level << 8 | level);
        board.run_us(150);
        assert_ne!(board.bus_read16(0x012C) & 1, 0);
    }
    board.bus_write8(0x0121, 0);
}

/// Loads `code` at `at` in RAM and lets the CPU begin there.
pub fn run_from_ram(board: &mut Board, at: u32, code: &[u16]) {
    for (n, word) in code.iter().enumerate() {
        board.poke16(at + 2 * n as u32, *word);
    }
    board.set_reg(0, at);
}

#[test]
fn the_part_has_its_memory_map() {
    let part = Part::F5529;
    assert_eq!(part.segment(0x4400), Some((0x4400, 512)));
    assert_eq!(part.segment(0x2_43FF), Some((0x2_4200, 512)));
    assert_eq!(part.segment(0x1985), Some((0x1980, 128)));
    assert_eq!(part.segment(0x2_4400), None);
    assert_eq!(part.bank(0x1_4400), Some((0x1_4400, 0x1_C3FF)));
    assert_eq!(part.bank(0x1_43FF), Some((0xC400, 0x1_43FF)));
    assert_eq!(part.flash.clone().count(), 131_072);
}
