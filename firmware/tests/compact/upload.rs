//! A program brought over the line, started, and still there after power was off.

use emulator::{Board, Stop};
use lang::wire::{self, Control, End, RunState, Upload};

use crate::area::{image, words};
use crate::chip::BOOT_US;
use crate::link::{board, read, sealed, write, write_one};

/// Milliseconds that a host allows for the reply to an upload code (`lang::wire`).
const ALLOWED: u64 = 300;

/// Writes an upload code; `None` when no sound reply comes in time.
fn control(board: &mut Board, code: Upload) -> Option<()> {
    let [high, low] = wire::UPLOAD_CONTROL.to_be_bytes();
    let request = sealed(&[1, 6, high, low, 0, code as u8]);
    board.uart_send(&request);
    assert_eq!(board.run_us(1000 * ALLOWED), Stop::Time);
    let reply: Vec<u8> = board.uart_take().into_iter().map(|(_, byte)| byte).collect();
    (reply == request).then_some(())
}

fn upload(board: &mut Board, image: &[u8]) -> Option<()> {
    write_one(board, wire::UPLOAD_LENGTH, image.len() as u16).ok()?;
    control(board, Upload::Begin)?;
    for (n, values) in words(image).chunks(21).enumerate() {
        write(board, wire::UPLOAD_WINDOW + 21 * n as u16, values).ok()?;
    }
    control(board, Upload::Commit)
}

fn state(board: &mut Board) -> u16 {
    read(board, 3, wire::RUN_STATE, 1)[0]
}

#[test]
fn a_program_comes_over_the_line_and_stays() {
    let program = image("DIM i\nFOR i = 1 TO 3\nSetOut 2, ON\nWait 5ms\nSetOut 2, OFF\nNEXT\n");
    let mut board = board();
    upload(&mut board, &program).expect("the program is taken");
    for _ in 0..2 {
        assert_eq!(state(&mut board), RunState::Ready as u16);
        assert_eq!(read(&mut board, 3, wire::PROGRAM_LENGTH, 1), [program.len() as u16]);
        assert_eq!(read(&mut board, 3, wire::PROGRAM_CRC, 1), [lang::image::crc_in(&program)]);
        write_one(&mut board, wire::RUN_CONTROL, Control::Start as u16).expect("it starts");
        board.run_us(100_000);
        assert_eq!(read(&mut board, 3, wire::LAST_END, 1), [End::Done as u16]);
        board.power_cut();
        board.power_up();
        board.run_us(BOOT_US + 100_000);
        board.uart_take();
    }
    assert_eq!(board.warnings(), &[]);
}

#[test]
fn the_longest_program_is_checked_in_the_time_that_a_host_allows() {
    let limit = lang::part::G2553.room_for(false);
    // What programs have most of, and what the check looks for longest.
    for line in ["SetOut 3, ON", "a = b", "a = -b", "IF a < b THEN a = b"] {
        let program = |n: usize| image(&format!("DIM a, b\n{}", format!("{line}\n").repeat(n)));
        let each = (program(200).len() - program(100).len()).div_ceil(100);
        let image = program((limit - program(0).len()) / each);
        assert!(image.len() <= limit && image.len() > limit - 100, "{} bytes", image.len());
        let mut board = board();
        upload(&mut board, &image).unwrap_or_else(|| panic!("{line}: refused or late"));
        assert_eq!(state(&mut board), RunState::Ready as u16);
    }
}
