//! The Modbus slave, by whole frames over the emulated line: the image runs from reset.

mod frames;
mod map;
mod run;

use emulator::{Board, TICKS_PER_SECOND};
use lang::wire::{CRC_START, crc16};

use crate::chip::{BOOT_US, Chip};

/// One character at 115200 bit/s, 10 bits.
const CHARACTER: u64 = TICKS_PER_SECOND * 10 / 115_200;
/// Silence that ends a frame above 19200 bit/s: 1750 us.
const SILENCE: u64 = TICKS_PER_SECOND / 1_000_000 * 1750;

/// A board that has come up.
pub fn board() -> Board {
    let mut board = Chip::new().board;
    board.reset_pin();
    board.run_us(BOOT_US);
    board.uart_take();
    board
}

pub fn sealed(body: &[u8]) -> Vec<u8> {
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
pub fn read(board: &mut Board, function: u8, first: u16, count: u16) -> Vec<u16> {
    let reply = ask(board, &words(function, first, count));
    assert_eq!(reply.len(), 3 + 2 * usize::from(count), "{reply:?}");
    assert_eq!(reply[..3], [1, function, 2 * count as u8]);
    reply[3..].chunks(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect()
}

pub fn write(board: &mut Board, first: u16, values: &[u16]) -> Result<(), u8> {
    let mut body = words(16, first, values.len() as u16);
    let head = body.clone();
    body.push(2 * values.len() as u8);
    body.extend(values.iter().flat_map(|value| value.to_be_bytes()));
    outcome(&ask(board, &body), &head)
}

pub fn write_one(board: &mut Board, register: u16, value: u16) -> Result<(), u8> {
    let body = words(6, register, value);
    outcome(&ask(board, &body), &body)
}

/// An echo is a success, an exception its code.
fn outcome(reply: &[u8], echo: &[u8]) -> Result<(), u8> {
    if reply == echo {
        return Ok(());
    }
    assert_eq!(reply[..2], [1, echo[1] | 0x80], "{reply:?}");
    Err(reply[2])
}

fn poke(board: &mut Board, symbol: &str, value: u16) {
    let at = board.symbol(symbol).unwrap();
    board.poke16(at, value);
}
