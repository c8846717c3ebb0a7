//! The Modbus slave, by whole frames over the emulated line: the image runs from reset.

use emulator::{Board, TICKS_PER_SECOND};
use lang::isa::FINGERPRINT;
use lang::part::G2553;
use lang::wire::{self, CRC_START, crc16};

use crate::chip::Chip;

/// One character at 115200 bit/s, 10 bits.
const CHARACTER: u64 = TICKS_PER_SECOND * 10 / 115_200;
/// Silence that ends a frame above 19200 bit/s: 1750 us.
const SILENCE: u64 = TICKS_PER_SECOND / 1_000_000 * 1750;

/// A board that has come up.
fn board() -> Board {
    let mut board = Chip::new().board;
    board.reset_pin();
    board.run_us(20_000);
    board.uart_take();
    board
}

fn sealed(body: &[u8]) -> Vec<u8> {
    let crc = body.iter().fold(CRC_START, |crc, &byte| crc16(crc, byte));
    [body, &crc.to_le_bytes()].concat()
}

/// What the board sends within the time of a long reply, its CRC checked and taken off.
fn listen(board: &mut Board) -> Vec<u8> {
    let end = board.uart_free() + SILENCE + 300 * CHARACTER;
    board.run_until(end);
    let reply: Vec<u8> = board.uart_take().into_iter().map(|(_, byte)| byte).collect();
    if reply.is_empty() {
        return reply;
    }
    let body = reply.len().saturating_sub(2);
    assert_eq!(sealed(&reply[..body]), reply, "CRC");
    reply[..body].to_vec()
}

fn ask(board: &mut Board, body: &[u8]) -> Vec<u8> {
    board.uart_send(&sealed(body));
    listen(board)
}

fn words(function: u8, first: u16, second: u16) -> Vec<u8> {
    let mut body = vec![1, function];
    body.extend(first.to_be_bytes());
    body.extend(second.to_be_bytes());
    body
}

/// Registers read by function 3 or 4.
fn read(board: &mut Board, function: u8, first: u16, count: u16) -> Vec<u16> {
    let reply = ask(board, &words(function, first, count));
    assert_eq!(reply.len(), 3 + 2 * usize::from(count), "{reply:?}");
    assert_eq!(reply[..3], [1, function, 2 * count as u8]);
    reply[3..].chunks(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect()
}

#[test]
fn a_board_says_who_it_is() {
    let mut board = board();
    let own = read(&mut board, 3, wire::OWN, 64);
    assert_eq!(own[..3], [wire::WIRE_VERSION, 1, FINGERPRINT]);
    assert_eq!(own[4..6], [G2553.features, G2553.room_for(false) as u16]);
    assert_eq!(own[7..11], [0; 4], "no program");
    assert_eq!(own[14], G2553.pool[0] / 2);
    assert_eq!(own[15..20], [0; 5], "a gap reads 0");
    assert_eq!(read(&mut board, 4, wire::OWN, 64)[..12], own[..12]);
    let record = board.symbol("BOARD_DEFAULT").unwrap();
    assert_eq!(own[3], board.peek16(record + 62));
    let profile = read(&mut board, 3, wire::PROFILE_WINDOW, 32);
    let expected: Vec<u16> = (0..32).map(|n| board.peek16(record + 2 * n)).collect();
    assert_eq!(profile, expected);
}
