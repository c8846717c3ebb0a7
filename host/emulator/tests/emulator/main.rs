//! The emulator against its witnesses: the user's guide's tables, vectors, and `mspdebug sim`.

mod asm;
mod cycles;
mod hostile;
mod lockstep;
mod peripherals;
mod power;
mod published;
mod serial;
mod silicon;
mod vectors;
mod world;

use emulator::{Board, Image, Part};

/// Where test code is put.
pub const CODE: u16 = 0xC000;
/// Watchdog control register.
pub const WDTCTL: u16 = 0x0120;
/// What holds the watchdog.
pub const WDT_HOLD: u16 = 0x5A80;

/// A board at 16 MHz with the watchdog held, about to execute `code`.
pub fn board(code: &[u16]) -> Board {
    board_with(&emulator::Config::default(), code)
}

/// The same with another configuration.
pub fn board_with(config: &emulator::Config, code: &[u16]) -> Board {
    let bytes: Vec<u8> = code.iter().flat_map(|w| w.to_le_bytes()).collect();
    let mut board = Board::with_config(config, &Image::from_bytes(CODE, &bytes).expect("code"));
    board.poke16(0xFFFE, CODE);
    board.reset_pin();
    set_up(&mut board);
    board
}

/// Watchdog held, DCO at its calibrated 16 MHz, program counter at the start of the code.
pub fn set_up(board: &mut Board) {
    board.bus_write16(WDTCTL, WDT_HOLD);
    let (bc1, dco) = (board.peek8(0x10F9), board.peek8(0x10F8));
    board.bus_write8(0x57, bc1);
    board.bus_write8(0x56, dco);
    board.set_reg(0, CODE);
}

/// `JMP $`, for tests in which only peripherals work.
pub const IDLE: [u16; 1] = [0x3FFF];

#[test]
fn parts_have_their_memory_map() {
    assert_eq!(Part::G2553.segment(0xC1FF), Some((0xC000, 512)));
    assert_eq!(Part::G2553.segment(0xFFFF), Some((0xFE00, 512)));
    assert_eq!(Part::G2553.segment(0x10C5), Some((0x10C0, 64)));
    assert_eq!(Part::G2553.segment(0x0200), None);
}
