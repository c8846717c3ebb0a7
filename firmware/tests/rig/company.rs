//! A fast machine with both lines busy, and what a host of it does.

use emulator::{Board, Link};
use lang::profile::Profile;
use lang::wire::{self, Control};

use super::{frame, read, write_body};

/// A fast machine of 100 steps/mm with a second line.
pub fn fast(top: u64) -> Profile {
    let mut text = String::from(
        "name = \"fast\"\nhome_order = [\"Z\"]\nwiring = \"chain\"\npulse_us = 3\ndir_setup_us = 2\n",
    );
    for axis in ["x", "y", "z"] {
        text += &format!(
            "[{axis}]\nscale = {{ steps = 100, um = 1000 }}\nstart_rate = 4000\naccel = 300000\n\
             top_rate = {top}\nmin_um = -9000000\nmax_um = 9000000\n\
             home = {{ direction = \"negative\", fast_rate = 2000, slow_rate = 200, stroke_um = 330000, \
             pause_ms = 100 }}\n"
        );
    }
    text += "[rs485]\naddress = 2\nrate = 115200\nparity = \"none\"\n";
    text += "[[input]]\nn = 8\nrole = \"emergency_stop\"\n";
    Profile::parse(&text).expect("a profile")
}

/// Sends bytes on a line; when they are through.
pub fn send(board: &mut Board, line: Link, bytes: &[u8]) -> u64 {
    let now = board.cycles();
    board.uart_take_on(line);
    board.uart_send_on(line, now, bytes)
}

/// Starts the program: the reply comes once the board has checked it.
pub fn start(board: &mut Board) {
    send(board, Link::Host, &frame(&write_body(wire::RUN_CONTROL, Control::Start as u16)));
    let mut bytes = 0;
    for _ in 0..2_000 {
        board.run_us(500);
        bytes += board.uart_take().len();
        if bytes >= 8 {
            return;
        }
    }
    panic!("it does not start");
}

/// A signed value of two registers.
pub fn long(board: &mut Board, register: u16) -> i32 {
    let [low, high] = [0, 1].map(|n| read(board, register + n).expect("it answers"));
    (u32::from(high) << 16 | u32::from(low)) as i32
}

/// Hosts that read 100 registers again and again on the lines that are to be busy.
pub struct Company {
    busy: [bool; 2],
    next: [u64; 2],
    asked: u64,
}

impl Company {
    pub fn new(busy: [bool; 2]) -> Company {
        Company { busy, next: [0; 2], asked: 0 }
    }

    /// The next requests, where it is time for them: at least every 500 us.
    pub fn ask(&mut self, board: &mut Board) {
        let us = board.ticks_per_second() / 1_000_000;
        let [high, low] = wire::VERSION.to_be_bytes();
        for (line, next) in [Link::Host, Link::Rs485].into_iter().zip(&mut self.next) {
            if self.busy[line as usize] && board.cycles() >= *next {
                self.asked += 1;
                let gone = send(board, line, &frame(&[1 + line as u8, 3, high, low, 0, 100]));
                *next = gone + (21_000 + self.asked * 7 % 29 * 53) * us;
            }
        }
    }
}
