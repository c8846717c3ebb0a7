//! Registers, bits and the exceptions beside them.

use emulator::Board;
use firmware::WHOLE;
use lang::isa::FINGERPRINT;
use lang::wire::{self, BLOCKS, Control, Table, WRITABLE};

use super::{ask, board, poke, read, words, write, write_one};

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
        let others =
            [wire::ANALOGS, wire::AOUTS, wire::PROFILE_MORE, wire::LIBRARY, wire::TRACE_QUEUE];
        if block.first >= wire::STREAM_MACHINE || others.contains(&block.first) {
            // Analog inputs and outputs, jobs from RAM, a PWM, a library and a queue of events are not of this build.
            let refused = [1, block.table | 0x80, 2];
            assert_eq!(ask(&mut board, &words(block.table, block.first, 1)), refused);
            continue;
        }
        if [wire::PLACES, wire::GOALS].contains(&block.first) {
            // One block with STATUS here, up to the targets.
            continue;
        }
        let status = block.first == wire::STATUS && block.table == Table::InputRegisters as u8;
        let count = if status { wire::TARGET_SPEEDS - wire::STATUS } else { block.count };
        let last = block.first + count - 1;
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
    assert_eq!(read(&mut board, 3, wire::OUTPUTS, 1), [4]);
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
