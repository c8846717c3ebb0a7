//! Frames on the line: silence, noise, rates, broadcasts, who counts as a host, restarts.

use emulator::{Board, Format, Parity, Reset, TICKS_PER_SECOND};
use lang::profile::Profile;
use lang::record::BoardRecord;
use lang::wire::{self, Control};
use proptest::prelude::*;

use super::{CHARACTER, SILENCE, ask, board, listen, poke, read, sealed, words, write, write_one};
use crate::chip::{BOOT_US, Chip};

/// The watchdog bites by then, and the board has booted.
const BITE_US: u64 = 100_000 + BOOT_US;

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
                board.run_us(BOOT_US);
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
