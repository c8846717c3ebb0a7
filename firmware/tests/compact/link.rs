//! The Modbus slave, by whole frames over the emulated line: the image runs from reset.

use emulator::{Board, Format, Parity, Reset, TICKS_PER_SECOND};
use firmware::WHOLE;
use lang::fault::Fault;
use lang::isa::{FINGERPRINT, Op};
use lang::profile::Profile;
use lang::record::BoardRecord;
use lang::wire::{self, BLOCKS, CRC_START, Control, RunState, Table, WRITABLE, crc16};
use proptest::prelude::*;

use crate::chip::Chip;

/// One character at 115200 bit/s, 10 bits.
const CHARACTER: u64 = TICKS_PER_SECOND * 10 / 115_200;
/// Silence that ends a frame above 19200 bit/s: 1750 us.
const SILENCE: u64 = TICKS_PER_SECOND / 1_000_000 * 1750;

/// The watchdog bites by then, and the board has booted.
const BITE_US: u64 = 100_000;

/// A board that has come up.
pub fn board() -> Board {
    let mut board = Chip::new().board;
    board.reset_pin();
    board.run_us(20_000);
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

#[test]
fn a_board_says_who_it_is() {
    let mut board = board();
    let own = read(&mut board, 3, wire::OWN, 64);
    assert_eq!(own[..3], [wire::WIRE_VERSION, 1, FINGERPRINT]);
    assert_eq!(own[4..6], [WHOLE.features, WHOLE.room_for(false) as u16]);
    assert_eq!(own[7..11], [0; 4], "no program");
    assert_eq!(own[14], WHOLE.pool[0] / 2);
    assert_eq!(own[15..20], [0; 5], "a gap reads 0");
    assert_eq!(read(&mut board, 4, wire::OWN, 64)[..12], own[..12]);
    let record = board.symbol("BOARD_DEFAULT").unwrap();
    assert_eq!(own[3], board.peek16(record + 62));
    let profile = read(&mut board, 3, wire::PROFILE_WINDOW, 32);
    let expected: Vec<u16> = (0..32).map(|n| board.peek16(record + 2 * n)).collect();
    assert_eq!(profile, expected);
}

#[test]
fn every_block_is_there_with_its_ends() {
    let mut board = board();
    for block in BLOCKS {
        if block.first >= wire::STREAM_MACHINE || block.first == wire::OVERRIDES {
            // Jobs from RAM and an override are not of this build.
            assert_eq!(ask(&mut board, &words(block.table, block.first, 1)), [1, 0x83, 2]);
            continue;
        }
        let last = block.first + block.count - 1;
        let bytes = if block.table <= 2 { 1 } else { 2 };
        for place in [block.first, last] {
            let reply = ask(&mut board, &words(block.table, place, 1));
            assert_eq!(reply[..3], [1, block.table, bytes], "{block:?} at {place}");
        }
        let beyond = ask(&mut board, &words(block.table, last, 2));
        assert_eq!(beyond, [1, block.table | 0x80, 2], "{block:?}");
        let before = ask(&mut board, &words(block.table, block.first.wrapping_sub(1), 2));
        assert_eq!(before, [1, block.table | 0x80, 2], "{block:?}");
        if block.flags & WRITABLE == 0 && block.table == Table::Holding as u8 {
            assert_eq!(write_one(&mut board, block.first, 0), Err(2), "{block:?}");
        }
    }
}

#[test]
fn values_of_ram_reach_their_registers() {
    let mut board = board();
    let long = |board: &mut Board, symbol: &str, n: u16, value: i32| {
        let at = board.symbol(symbol).unwrap() + 4 * n;
        board.poke16(at, value as u16);
        board.poke16(at + 2, (value >> 16) as u16);
    };
    for (n, value) in [(0, -2), (1, 70_000), (2, i32::MIN)] {
        long(&mut board, "ACTUAL", n, value);
        long(&mut board, "STEPS", n, value.wrapping_add(9));
        long(&mut board, "PROBED", n, value.wrapping_sub(9));
    }
    let halves = |value: i32| [value as u16, (value as u32 >> 16) as u16];
    let axes =
        |by: i32| [-2, 70_000, i32::MIN].map(|value: i32| halves(value.wrapping_add(by))).concat();
    assert_eq!(read(&mut board, 3, wire::MACHINE_POSITIONS, 6), axes(0));
    assert_eq!(read(&mut board, 3, wire::COMMANDED, 6), axes(9));
    assert_eq!(read(&mut board, 3, wire::COMMANDED + 6, 8), [0; 8]);
    assert_eq!(read(&mut board, 4, wire::WORK_POSITIONS, 6), axes(0), "no offset");
    assert_eq!(read(&mut board, 3, wire::POSITIONS, 12)[..6], axes(0));
    assert_eq!(read(&mut board, 4, wire::TARGETS, 6), axes(9));
    for probed in [wire::PROBE_RESULT, wire::PROBE_RESULT_TEXT] {
        assert_eq!(read(&mut board, 4, probed, 12)[..6], axes(-9));
        assert_eq!(read(&mut board, 4, probed + 6, 6), [0; 6]);
        assert_eq!(read(&mut board, 4, probed + 3, 1), axes(-9)[3..4], "a high half alone");
    }
    assert_eq!(read(&mut board, 3, wire::SPEEDS, 12), [0; 12], "at rest");

    for (symbol, register, value) in [
        ("RUNS", wire::RUN_COUNT, 0x1234),
        ("PRINT_TAIL", wire::PRINT_TAIL, 0xFFFE),
        ("CHAR_OUT", wire::CHAR_OUT, 0x0141),
        ("MISSED", wire::MISSED_DEADLINES, 77),
    ] {
        poke(&mut board, symbol, value);
        assert_eq!(read(&mut board, 3, register, 1), [value], "{symbol}");
    }
    for (symbol, register) in [
        ("REFUSAL", wire::UPLOAD_RESULT),
        ("VM_FAULT", wire::FAULT),
        ("FAULT_IN", wire::FAULT_INPUT),
        ("LAST_END", wire::LAST_END),
        ("HOMED", wire::HOMED),
        ("CHAR_IN", wire::CHAR_IN),
        ("PRINT_READY", wire::PRINT_COUNT),
        ("CAUSE", wire::RESET_CAUSE),
    ] {
        let at = board.symbol(symbol).unwrap();
        board.poke8(at, 7);
        assert_eq!(read(&mut board, 4, register, 1), [7], "{symbol}");
        board.poke8(at, 0);
    }
}

#[test]
fn print_shows_from_its_tail_on_and_is_taken() {
    let mut board = board();
    let ring = board.symbol("PRINT").unwrap();
    for n in 0..16 {
        board.poke8(ring + n, b'a' + n as u8);
    }
    poke(&mut board, "PRINT_TAIL", 0xFFFD);
    let ready = board.symbol("PRINT_READY").unwrap();
    board.poke8(ready, 5);
    let words = read(&mut board, 3, wire::PRINT_COUNT, 5);
    assert_eq!(words[..2], [5, 0xFFFD]);
    assert_eq!(words[2..5], [*b"no", *b"pa", *b"bc"].map(u16::from_be_bytes));
    assert_eq!(write_one(&mut board, wire::PRINT_TAIL, 3), Err(3), "more than there is");
    assert_eq!(write_one(&mut board, wire::PRINT_TAIL, 2), Ok(()));
    assert_eq!(read(&mut board, 3, wire::PRINT_COUNT, 2), [0, 2]);
    assert_eq!(write_one(&mut board, wire::PRINT_TAIL, 2), Ok(()), "the same again");
}

#[test]
fn outputs_are_coils_and_a_register() {
    let mut board = board();
    let body = words(5, 2, 0xFF00);
    assert_eq!(ask(&mut board, &body), body);
    assert_eq!(read(&mut board, 3, wire::OUTPUTS, 6), [4, 0, 0, 0, 0, 0]);
    assert_eq!(ask(&mut board, &[1, 15, 0, 1, 0, 10, 2, 0b1010_0110, 1]), [1, 15, 0, 1, 0, 10]);
    assert_eq!(read(&mut board, 3, wire::OUTPUTS, 1), [0b1_1010_0110 << 1]);
    assert_eq!(write_one(&mut board, wire::OUTPUTS, 0x8421), Ok(()));
    assert_eq!(ask(&mut board, &words(1, 0, 16)), [1, 1, 2, 0x21, 0x84]);
    assert_eq!(ask(&mut board, &words(1, 5, 11)), [1, 1, 2, 0x21, 4], "padded with 0");
    assert_eq!(board.plant().outputs(), 0x8421);
    assert_eq!(write_one(&mut board, wire::OUTPUTS + 1, 0), Err(2));
    assert_eq!(ask(&mut board, &words(5, 0, 1)), [1, 0x85, 3], "neither on nor off");
    assert_eq!(ask(&mut board, &words(5, 16, 0)), [1, 0x85, 2]);
    assert_eq!(ask(&mut board, &[1, 15, 0, 15, 0, 2, 1, 0]), [1, 0x8F, 2], "leaves the block");
}

#[test]
fn inputs_and_status_are_bits_and_registers() {
    let mut board = board();
    for n in [3, 10, 16] {
        board.plant_mut().set_input(n, true);
    }
    board.run_us(30_000);
    assert_eq!(read(&mut board, 4, wire::INPUTS, 2), [0x8204, 0]);
    assert_eq!(ask(&mut board, &words(2, 0, 32)), [1, 2, 4, 0x04, 0x82, 0, 0]);
    // Input 10 is the reference switch of Y, at its negative end.
    assert_eq!(read(&mut board, 4, wire::LIMITS, 1), [2]);
    let at = board.symbol("NEGATIVE").unwrap();
    board.poke8(at, 0b010);
    assert_eq!(read(&mut board, 4, wire::MOVING, 1), [0x0500]);
    let status = ask(&mut board, &words(2, 256, 128));
    assert_eq!(status.len(), 3 + 16);
    assert_eq!(status[3..9], [0, 5, 0, 0, 2, 0]);
    for (symbol, register, value) in
        [("HOMING_ERROR", wire::HOMING, 0x0300), ("PROBE_ERROR", wire::PROBE_ERROR, 3)]
    {
        let at = board.symbol(symbol).unwrap();
        board.poke8(at, 3);
        assert_eq!(read(&mut board, 4, register, 1), [value], "{symbol}");
    }
    assert_eq!(read(&mut board, 4, wire::COMMAND_ROOM, 3), [21, 0, 0]);
    board.plant_mut().set_input(17, true);
    assert_eq!(read(&mut board, 4, wire::INPUTS, 2), [0x8204, 1]);
}

#[test]
fn exceptions_are_those_of_the_standard() {
    let mut board = board();
    let high = (wire::OWN >> 8) as u8;
    let low = wire::OWN as u8;
    for (body, code) in [
        (&[1, 7, 0, 0, 0, 0][..], 1),
        (&[1, 7], 1),
        (&[1, 0, 0, 0, 0, 0], 1),
        (&[1, 17, 0, 0, 0, 0], 1),
        (&[1, 14, 0, 0, 0, 0], 1),
        (&[1, 0x83, 0, 0, 0, 1], 1),
        (&[1, 3, 0x40, 0, 0, 1], 2),
        (&[1, 3, high, low, 0, 126], 3),
        (&[1, 3, high, low, 0, 0], 3),
        (&[1, 3, high, low, 0x80, 1], 3),
        (&[1, 3, high, low, 0xFF, 0xFF], 3),
        (&[1, 1, 0, 0, 0xFF, 0xFF], 3),
        (&[1, 1, 0, 0, 0x07, 0xD1], 3),
        (&[1, 3, high, low, 0], 3),
        (&[1, 3, high, low, 0, 1, 0], 3),
        (&[1, 16, 0x07, 0xD0, 0, 2, 3, 0, 0, 0], 3),
        (&[1, 16, 0x07, 0xD0, 0, 2, 4, 0, 0, 0], 3),
        (&[1, 16, 0x07, 0xD0, 0, 0, 0], 3),
        (&[1, 16, 0x07, 0xD0, 0x80, 1, 2, 0, 0], 3),
        (&[1, 15, 0, 0, 0, 3, 2, 5, 0], 3),
        (&[1, 6, 0x07, 0xD0, 0], 3),
        (&[1, 6, 0x09, 0x6C, 0, 1], 2),
        (&[1, 16, 0x09, 0x61, 0, 2, 4, 0, 0, 0, 0], 3),
        (&[1, 16, 0x09, 0x60, 0, 1, 2, 0, 0], 3),
        (&[1, 6, 0x09, 0x61, 0, 0], 3),
    ] {
        assert_eq!(ask(&mut board, body), [1, body[1] | 0x80, code], "{body:?}");
    }
}

#[test]
fn values_outside_their_range_are_refused() {
    let mut board = board();
    for (register, value, code) in [
        (wire::CHAR_IN, 32, 3),
        (wire::CHAR_IN, 126, 3),
        (wire::RUN_CONTROL, 0, 3),
        (wire::RUN_CONTROL, 9, 3),
        (wire::RUN_CONTROL, Control::Start as u16, 4),
        (wire::UPLOAD_CONTROL, 5, 3),
        (wire::RUN_STATE, 1, 2),
        (wire::OWN, 1, 2),
        (wire::CHAR_IN + 1, 1, 2),
        (wire::CELLS, 1, 4),
        (wire::KEEPS, 1, 3),
    ] {
        assert_eq!(write_one(&mut board, register, value), Err(code), "{register}");
    }
    assert_eq!(write(&mut board, wire::CELLS, &[1, 0]), Err(4));
    assert_eq!(read(&mut board, 3, wire::CELLS, 64), [0; 64]);
    assert_eq!(read(&mut board, 3, wire::UPLOAD_WINDOW + 1400, 125), [0; 125]);
    for (register, value) in [
        (wire::CHAR_IN, 125),
        (wire::TRACE_MODE, 1),
        (wire::UPLOAD_LENGTH, 0x8123),
        (wire::RUN_CONTROL, Control::Acknowledge as u16),
    ] {
        assert_eq!(write_one(&mut board, register, value), Ok(()), "{register}");
    }
    assert_eq!(read(&mut board, 3, wire::CHAR_IN, 1), [125]);
    assert_eq!(read(&mut board, 3, wire::TRACE_MODE, 2), [1, 0]);
    assert_eq!(read(&mut board, 3, wire::UPLOAD_LENGTH, 1), [0x8123]);
}

#[test]
fn the_command_buffer_takes_21_registers() {
    let mut board = board();
    let values: Vec<u16> = (0..20).map(|n| 0x0101 * n + 7).collect();
    assert_eq!(write(&mut board, wire::COMMAND + 1, &values), Ok(()));
    assert_eq!(read(&mut board, 3, wire::COMMAND + 1, 20), values);
    let all = [&[9999], &values[..]].concat();
    // No such command, but all of it arrived.
    let mut body = words(16, wire::COMMAND, 21);
    body.push(42);
    body.extend(all.iter().flat_map(|value| value.to_be_bytes()));
    ask(&mut board, &body);
    assert_eq!(read(&mut board, 3, wire::COMMAND, 21), all);
}

#[test]
fn broadcasts_are_obeyed_in_silence() {
    let mut board = board();
    assert!(ask(&mut board, &[0, 5, 0, 1, 0xFF, 0]).is_empty());
    assert_eq!(read(&mut board, 3, wire::OUTPUTS, 1), [2]);
    assert!(ask(&mut board, &[0, 3, 0x13, 0x88, 0, 9]).is_empty());
    assert!(ask(&mut board, &[0, 7, 0x13, 0x88, 0, 9]).is_empty());
    assert!(ask(&mut board, &[2, 5, 0, 0, 0xFF, 0]).is_empty(), "for another board");
    assert_eq!(read(&mut board, 3, wire::OUTPUTS, 1), [2]);
}

#[test]
fn gaps_and_their_absence_spoil_frames_without_harm() {
    let mut board = board();
    let request = sealed(&words(3, wire::VERSION, 1));
    let good = [1, 3, 2, 0, wire::WIRE_VERSION as u8];
    // A gap of one character is one frame; of two it spoils it; of five it makes two.
    for (characters, whole) in
        [(1, true), (2, true), (9, true), (11, false), (17, false), (30, false)]
    {
        // In tenths of what is allowed: 1.5 characters are 750 us at this rate.
        let gap = TICKS_PER_SECOND / 1_000_000 * 75 * characters;
        let end = board.uart_send(&request[..3]);
        board.uart_send_at(end + gap, &request[3..]);
        let reply = listen(&mut board);
        assert_eq!(reply, if whole { &good[..] } else { &[] }, "gap of {gap} ticks");
    }
    // Two requests without silence are one frame that makes no sense.
    board.uart_send(&[&request[..], &request[..]].concat());
    assert!(listen(&mut board).is_empty());
    // The next one may come when the silence after the reply has passed.
    let end = board.uart_send(&request) + SILENCE + 7 * CHARACTER;
    board.uart_send_at(end + SILENCE, &request);
    board.run_until(board.uart_free() + 2 * SILENCE);
    let replies: Vec<u8> = board.uart_take().into_iter().map(|(_, byte)| byte).collect();
    assert_eq!(replies, sealed(&good).repeat(2));
    // More than the buffer holds.
    board.uart_send(&[1; 300]);
    assert!(listen(&mut board).is_empty());
    let long = sealed(&[[1, 16, 0x07, 0xD0, 0, 60, 120].as_slice(), &[0; 120]].concat());
    board.uart_send(&long);
    assert!(listen(&mut board).is_empty());
    assert_eq!(ask(&mut board, &words(3, wire::VERSION, 1)), good);
}

#[test]
fn noise_never_silences_the_slave() {
    let fresh = board();
    let good = [1, 3, 2, 0, wire::WIRE_VERSION as u8];
    proptest!(ProptestConfig::with_cases(40), |(
        noise in prop::collection::vec(any::<u8>(), 0..80),
        glitch in prop::option::of(1u64..3000),
    )| {
        let mut board = fresh.clone();
        board.uart_send(&noise);
        if let Some(ticks) = glitch {
            board.uart_send_raw(&[(false, ticks), (true, 100)]);
        }
        board.run_until(board.uart_free() + 2 * SILENCE);
        board.uart_take();
        prop_assert_eq!(ask(&mut board, &words(3, wire::VERSION, 1)), good);
    });
}

#[test]
fn a_host_is_heard_by_a_sound_request_only() {
    let mut board = board();
    let flags = board.symbol("RUN_FLAGS").unwrap();
    let heard = board.symbol("R_HOST").unwrap() as u8;
    board.uart_send(&[1, 3, 0, 0]);
    assert!(listen(&mut board).is_empty());
    assert_eq!(board.peek8(flags) & heard, 0, "noise is no host");
    read(&mut board, 3, wire::VERSION, 1);
    assert_eq!(board.peek8(flags) & heard, heard);
}

#[test]
fn a_host_listens_when_it_takes_what_is_printed_or_finds_nothing() {
    let mut board = board();
    let unheard = board.symbol("UNHEARD").unwrap();
    let listens = |board: &mut Board, act: &dyn Fn(&mut Board)| {
        poke(board, "UNHEARD", 1000);
        act(board);
        board.peek16(unheard) < 1000
    };
    let looks: &dyn Fn(&mut Board) = &|board| drop(read(board, 3, wire::PRINT_COUNT, 18));
    assert!(!listens(&mut board, &|board| drop(read(board, 3, wire::RUN_STATE, 1))));
    assert!(listens(&mut board, looks), "nothing to take");
    let ready = board.symbol("PRINT_READY").unwrap();
    board.poke8(ready, 3);
    assert!(!listens(&mut board, looks), "looks, but takes nothing");
    assert!(listens(&mut board, &|board| assert_eq!(write(board, wire::PRINT_TAIL, &[2]), Ok(()))));
}

#[test]
fn a_control_ends_its_request() {
    let mut board = board();
    let at = board.symbol("CHAR_IN").unwrap();
    for register in [wire::RUN_CONTROL, wire::UPLOAD_CONTROL] {
        assert_eq!(write(&mut board, register, &[2, 0]), Err(3), "{register}");
        assert_eq!(write(&mut board, register - 1, &[0, 2]), Err(2), "{register}");
    }
    assert_eq!(write(&mut board, wire::RUN_CONTROL, &[Control::Stop as u16]), Ok(()));
    assert_eq!(board.peek8(at), 0);
}

#[test]
fn restarts_that_a_host_asked_for_are_no_bites_of_the_watchdog() {
    let mut board = board();
    let booted = board.symbol("R_BOOTED").unwrap() as u8;
    let flags = board.symbol("RUN_FLAGS").unwrap();
    for _ in 0..4 {
        assert_eq!(write_one(&mut board, wire::RUN_CONTROL, Control::Restart as u16), Ok(()));
        board.run_us(BITE_US);
        assert_eq!(board.last_reset(), Reset::Watchdog);
        assert_eq!(board.peek8(flags) & booted, 0, "autorun is not given up");
    }
}

#[test]
fn restart_resets_once_the_reply_is_out() {
    let mut board = board();
    board.uart_send(&sealed(&words(5, 0, 0xFF00)));
    listen(&mut board);
    assert_eq!(write_one(&mut board, wire::RUN_CONTROL, Control::Restart as u16), Ok(()));
    board.run_us(BITE_US);
    assert_eq!(board.last_reset(), Reset::Watchdog);
    assert_eq!(read(&mut board, 3, wire::OUTPUTS, 1), [0]);
}

#[test]
fn every_rate_and_parity_is_served() {
    let profile = Profile::built_in("mill").unwrap();
    for (rate, baud) in [(0, 9600), (1, 19_200), (2, 57_600), (3, 115_200)] {
        for (parity, expected) in [(0, Parity::None), (1, Parity::Even), (2, Parity::Odd)] {
            for stop in [false, true] {
                let mut board = Chip::new().board;
                let mut record = BoardRecord::of(&profile, 1);
                record.rate = parity << 4 | rate;
                record.address = 9;
                for (at, byte) in (0x1040..).zip(record.sealed().to_bytes()) {
                    board.poke8(at, byte);
                }
                board.plant_mut().press_stop(stop);
                board.reset_pin();
                // Stop held at reset: 9600 8N1, address 1.
                let (baud, parity, address) =
                    if stop { (9600, Parity::None, 1) } else { (baud, expected, 9) };
                board.set_uart_format(Format { baud, parity });
                board.run_us(20_000);
                board.uart_take();
                let mut body = words(3, wire::VERSION, 20);
                body[0] = address;
                board.uart_send(&sealed(&body));
                let end = board.uart_free() + TICKS_PER_SECOND / 10;
                board.run_until(end);
                let reply: Vec<u8> = board.uart_take().into_iter().map(|(_, byte)| byte).collect();
                assert_eq!(reply.len(), 45, "{baud} {parity:?}");
                assert_eq!(reply, sealed(&reply[..43]));
                assert_eq!(board.uart_errors(), 0);
            }
        }
    }
}

/// What the slave makes of a request, without the line: the chip does nothing else.
fn exchange(chip: &mut Chip, body: &[u8]) -> Vec<u8> {
    let frame = sealed(body);
    let at = chip.at("FRAME");
    for (place, &byte) in (at..).zip(&frame) {
        chip.board.poke8(place, byte);
    }
    chip.set_byte("HEAD", frame.len() as u8);
    chip.set_byte("LINE_STATE", 1);
    chip.call("link_poll", &[]);
    let reply: Vec<u8> =
        (at..).take(chip.byte("HEAD").into()).map(|a| chip.board.peek8(a)).collect();
    chip.set_word("HEAD", 0);
    chip.set_word("LINE_STATE", 0);
    reply[..reply.len() - 2].to_vec()
}

/// A chip whose program runs with three cells.
fn running() -> Chip {
    let mut chip = Chip::new();
    let board = chip.at("BOARD_DEFAULT");
    chip.set_word("BOARD", board);
    chip.set_byte("ADDRESS", 1);
    chip.set_byte("RUN", RunState::Running as u8);
    let cells = chip.at("POOL") + 8;
    chip.set_word("VM_CELLS", cells);
    chip.set_byte("VM_CELL_COUNT", 3);
    chip
}

#[test]
fn cells_of_a_run_are_read_and_written_whole() {
    let mut chip = running();
    let mut body = words(16, wire::CELLS + 2, 4);
    body.extend([8, 0xFF, 0xFE, 0xFF, 0xFF, 0x12, 0x34, 0, 5]);
    assert_eq!(exchange(&mut chip, &body), body[..6]);
    assert_eq!(chip.long("POOL", 12), -2i32 as u32);
    assert_eq!(chip.long("POOL", 16), 0x0005_1234);
    let reply = exchange(&mut chip, &words(3, wire::CELLS, 8));
    assert_eq!(reply[3..], [0, 0, 0, 0, 0xFF, 0xFE, 0xFF, 0xFF, 0x12, 0x34, 0, 5, 0, 0, 0, 0]);
    let reply = exchange(&mut chip, &words(3, wire::CELLS + 5, 1));
    assert_eq!(reply[3..], [0, 5]);
    let body = words(6, wire::CELLS, 0x8000);
    assert_eq!(exchange(&mut chip, &body), body);
    assert_eq!(chip.long("POOL", 8), 0xFFFF_8000, "function 6 extends the sign");
    let body = words(6, wire::CELLS + 6, 1);
    assert_eq!(exchange(&mut chip, &body), [1, 0x86, 3], "no such cell");
    let body = words(6, wire::CELLS + 1, 1);
    assert_eq!(exchange(&mut chip, &body), [1, 0x86, 3], "a high half");
}

#[test]
fn the_run_state_shows_in_all_its_registers() {
    let mut chip = running();
    let one = |chip: &mut Chip, function, register| {
        let reply = exchange(chip, &words(function, register, 1));
        u16::from_be_bytes([reply[3], reply[4]])
    };
    for (state, shown, interp) in [
        (RunState::Empty, 0, 0),
        (RunState::Ready, 1, 0),
        (RunState::Running, 2, 1 << 3),
        (RunState::Paused, 3, 1 << 3 | 1 << 4),
        (RunState::Fault, 4, 1),
        (RunState::Stopping, 6, 1 << 3),
    ] {
        chip.set_byte("RUN", state as u8);
        assert_eq!(one(&mut chip, 3, wire::RUN_STATE), shown);
        assert_eq!(one(&mut chip, 4, wire::CNC_STATE), interp);
        let running = u16::from(interp & 1 << 3 != 0);
        assert_eq!(one(&mut chip, 4, wire::PLC_STATUS), running << 10);
        assert_eq!(one(&mut chip, 4, wire::COMMAND_ROOM), 21 - 21 * running);
        assert_eq!(exchange(&mut chip, &words(2, 346, 1))[3], running as u8);
    }
    chip.set_byte("RUN", RunState::Running as u8);
    chip.set_byte("RUN_FLAGS", 1);
    assert_eq!(one(&mut chip, 3, wire::RUN_STATE), RunState::WaitStart as u16);
    for (code, n, homing, probing) in [
        (Op::Home as u8, 0, 1, 0),
        (Op::Home as u8 + 2, 2, 4, 0),
        (Op::HomeQuery as u8, 1, 2, 0),
        (Op::Probe as u8, 2, 0, 0x0400),
        (Op::Wait as u8, 2, 0, 0),
        (0, 1, 0, 0),
    ] {
        chip.set_byte("EFFECT", code);
        chip.set_byte("N", n);
        assert_eq!(one(&mut chip, 4, wire::HOMING), homing);
        assert_eq!(one(&mut chip, 4, wire::PROBING), probing);
        assert_eq!(one(&mut chip, 4, wire::CNC_STATE), 1 << 3 | u16::from(homing != 0) << 2);
    }
    for (fault, code) in [
        (Fault::LimitSwitch, 1),
        (Fault::EmergencyStop, 10),
        (Fault::Watchdog, 3),
        (Fault::ValueRange, 3),
    ] {
        chip.set_byte("VM_FAULT", fault.number());
        chip.set_byte("RUN", RunState::Running as u8);
        assert_eq!(one(&mut chip, 4, wire::CNC_ALARM), 0);
        chip.set_byte("RUN", RunState::Fault as u8);
        assert_eq!(one(&mut chip, 4, wire::CNC_ALARM), code);
    }
}

#[test]
fn a_command_during_a_run_leaves_the_programs_memory_alone() {
    let mut chip = running();
    for n in 0..20 {
        chip.set_word("POOL", 0);
        let at = chip.at("POOL") + 2 * n;
        chip.board.poke16(at, 0x1100 + n);
    }
    let pool = |chip: &Chip| -> Vec<u16> {
        (0..20).map(|n| chip.board.peek16(chip.at("POOL") + 2 * n)).collect()
    };
    let before = pool(&chip);
    let body = [words(16, wire::COMMAND, 2), vec![4, 0x04, 0xB0, 0, 88]].concat();
    assert_eq!(exchange(&mut chip, &body), body[..6], "1200 is taken");
    assert_eq!(pool(&chip), before);
    let mut body = [words(16, wire::COMMAND, 4), vec![8]].concat();
    body.extend([0, 103, 0, 1, 0, 0, 0, 0]);
    assert_eq!(exchange(&mut chip, &body), [1, 0x90, 6]);
    let body = words(6, wire::COMMAND + 5, 1);
    assert_eq!(exchange(&mut chip, &body), [1, 0x86, 6]);
    assert_eq!(pool(&chip), before);
}
