//! A board without a client: frames as bytes, power and flash under the test's control, no retries.

use std::sync::{Mutex, PoisonError};

use desk::board::NativeBoard;
use emulator::{Board, Config, Stop, Wiring};
use lang::wire::{
    CRC_START, Control, PROGRAM_CRC, PROGRAM_LENGTH, RUN_CONTROL, RUN_STATE, UPLOAD_CONTROL,
    UPLOAD_LENGTH, UPLOAD_RESULT, Upload, VERSION, WIRE_VERSION, check_ms, crc16, upload_window,
};

use super::table::Table;
use crate::board::Build;

/// Beyond what an upload's erase and check may take, the longest wait for the first byte of a reply, us.
const BEYOND_US: u64 = 100_000;
/// Two looks for characters, us.
const LOOK_US: u64 = 200;
/// Silence that ends a frame and lets the next one begin, us.
const SILENCE_US: u64 = 2_000;
/// A board answers so soon after power, us.
pub const BOOT_US: u64 = 200_000;
/// Registers of one write.
const REGISTERS: usize = 21;

/// What came back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Answer {
    /// A reply without its CRC.
    Reply(Vec<u8>),
    /// An exception.
    Exception(u8),
    /// Nothing.
    Silence,
    /// Bytes that are no frame.
    Noise(Vec<u8>),
    /// The board lost its power.
    NoPower,
}

/// CRC of a frame; 0 of one that carries its own.
pub fn crc(bytes: &[u8]) -> u16 {
    bytes.iter().fold(CRC_START, |crc, &byte| crc16(crc, byte))
}

/// A request with its CRC.
pub fn framed(body: &[u8]) -> Vec<u8> {
    [body, &crc(body).to_le_bytes()].concat()
}

/// Body of a write of registers.
pub fn write_body(address: u16, values: &[u16]) -> Vec<u8> {
    let [high, low] = address.to_be_bytes();
    let count = values.len() as u8;
    let mut body = vec![1, 16, high, low, 0, count, count.wrapping_mul(2)];
    body.extend(values.iter().flat_map(|value| value.to_be_bytes()));
    body
}

/// Body of a read of holding registers.
pub fn read_body(address: u16, count: u8) -> Vec<u8> {
    let [high, low] = address.to_be_bytes();
    vec![1, 3, high, low, 0, count]
}

/// Words of an image as the upload window takes them.
pub fn words(image: &[u8]) -> Vec<u16> {
    image
        .chunks(2)
        .map(|pair| u16::from_le_bytes([pair[0], *pair.get(1).unwrap_or(&0xFF)]))
        .collect()
}

/// A board on the table.
#[derive(Clone)]
pub struct Stand<B = Board> {
    /// The board.
    pub board: B,
    /// Longest wait for the first byte of a reply, us.
    patience_us: u64,
}

impl Stand {
    /// A board with the shipped firmware of a build, the profile `mill` and no program, powered up.
    ///
    /// # Errors
    /// The shipped firmware is damaged.
    pub fn new(build: &Build, config: &Config) -> Result<Stand, String> {
        let image = build.image().map_err(|error| error.to_string())?;
        let config = Config { part: build.chip.clone(), ..config.clone() };
        let mut board = Board::with_config(&config, &image);
        crate::board::tell_default(build, &mut board);
        let mut stand = Stand::around(board);
        stand.board.run_us(BOOT_US);
        Ok(stand)
    }
}

impl Stand<NativeBoard> {
    /// The firmware's machine on the desktop, with the profile `mill` and no program, powered up.
    pub fn native() -> Stand<NativeBoard> {
        let mut stand = Stand::around(NativeBoard::new(Wiring::Chain));
        stand.board.run_us(BOOT_US);
        stand
    }
}

impl<B: Table> Stand<B> {
    /// A board in the hand.
    pub fn around(board: B) -> Stand<B> {
        let mut stand = Stand { board, patience_us: 0 };
        stand.expects(0);
        stand
    }

    /// From now on an image of so many bytes may be checked before a reply comes.
    pub fn expects(&mut self, length: usize) {
        self.patience_us = BEYOND_US + 1000 * check_ms(length);
    }

    /// Ticks of the board's chip in so many microseconds.
    pub fn ticks(&self, us: u64) -> u64 {
        us * (self.board.ticks_per_second() / 1_000_000)
    }

    /// Sends bytes and listens until the line rests.
    pub fn exchange(&mut self, bytes: &[u8]) -> Answer {
        self.board.uart_take();
        let gone = self.board.uart_send(bytes);
        if self.board.run_to(gone) == Stop::NoPower {
            return Answer::NoPower;
        }
        let mut reply = Vec::new();
        let (mut waited, mut silent) = (0, 0);
        while waited < self.patience_us && (reply.is_empty() || silent < SILENCE_US) {
            if self.board.run_us(LOOK_US) == Stop::NoPower {
                return Answer::NoPower;
            }
            let more = self.board.uart_take();
            silent = if more.is_empty() { silent + LOOK_US } else { 0 };
            waited += if reply.is_empty() { LOOK_US } else { 0 };
            reply.extend(more.into_iter().map(|(_, byte)| byte));
        }
        if reply.is_empty() {
            return Answer::Silence;
        }
        if reply.len() < 5 || crc(&reply) != 0 {
            return Answer::Noise(reply);
        }
        if reply[1] & 0x80 != 0 {
            return Answer::Exception(reply[2]);
        }
        reply.truncate(reply.len() - 2);
        Answer::Reply(reply)
    }

    /// Sends a request.
    pub fn ask(&mut self, body: &[u8]) -> Answer {
        self.exchange(&framed(body))
    }

    /// Reads one holding register.
    pub fn read(&mut self, address: u16) -> Option<u16> {
        match self.ask(&read_body(address, 1)) {
            Answer::Reply(reply) if reply.len() == 5 => {
                Some(u16::from_be_bytes([reply[3], reply[4]]))
            }
            _ => None,
        }
    }

    /// Reads a 32-bit value.
    pub fn read_long(&mut self, address: u16) -> Option<i32> {
        match self.ask(&read_body(address, 2)) {
            Answer::Reply(reply) if reply.len() == 7 => {
                let word = |at: usize| u32::from(u16::from_be_bytes([reply[at], reply[at + 1]]));
                Some((word(5) << 16 | word(3)).cast_signed())
            }
            _ => None,
        }
    }

    /// Writes registers.
    pub fn write(&mut self, address: u16, values: &[u16]) -> Answer {
        self.ask(&write_body(address, values))
    }

    /// Writes a run control.
    pub fn control(&mut self, control: Control) -> Answer {
        self.write(RUN_CONTROL, &[control as u16])
    }

    /// Number of the run state.
    pub fn state(&mut self) -> Option<u16> {
        self.read(RUN_STATE)
    }

    /// Whether the board answers as itself.
    pub fn answers(&mut self) -> bool {
        self.read(VERSION) == Some(WIRE_VERSION)
    }

    /// Brings an image to the board by the steps of an upload.
    ///
    /// # Errors
    /// The answer that ended it.
    pub fn upload(&mut self, image: &[u8], keep: bool) -> Result<(), Answer> {
        let done = |answer| match answer {
            Answer::Reply(_) => Ok(()),
            other => Err(other),
        };
        self.expects(image.len());
        let length = image.len() as u16 | u16::from(keep) << 15;
        done(self.write(UPLOAD_LENGTH, &[length]))?;
        done(self.write(UPLOAD_CONTROL, &[Upload::Begin as u16]))?;
        for (n, words) in words(image).chunks(REGISTERS).enumerate() {
            done(self.write(upload_window(image.len()) + (REGISTERS * n) as u16, words))?;
        }
        done(self.write(UPLOAD_CONTROL, &[Upload::Commit as u16]))
    }

    /// Erases the stored program.
    pub fn erase(&mut self) -> Answer {
        self.write(UPLOAD_CONTROL, &[Upload::Erase as u16])
    }

    /// Number of the last refusal of an image.
    pub fn refusal(&mut self) -> Option<u16> {
        self.read(UPLOAD_RESULT)
    }

    /// Length and CRC of the stored program.
    pub fn stored(&mut self) -> Option<(u16, u16)> {
        let length = self.read(PROGRAM_LENGTH)?;
        Some((length, if length == 0 { 0 } else { self.read(PROGRAM_CRC)? }))
    }

    /// Switches off and on again; whether the board answers in time.
    pub fn power_cycle(&mut self) -> bool {
        self.board.power_cut();
        self.board.power_up();
        self.board.forget();
        self.board.run_us(BOOT_US);
        self.answers()
    }
}

/// A board of which every case gets a copy.
pub struct Fresh<B: Table = Board> {
    kept: Mutex<B::Kept>,
    patience_us: u64,
}

impl<B: Table> Fresh<B> {
    /// Keeps a board.
    pub fn new(stand: Stand<B>) -> Fresh<B> {
        Fresh { patience_us: stand.patience_us, kept: Mutex::new(stand.board.kept()) }
    }

    /// A copy.
    pub fn copy(&self) -> Stand<B> {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        Stand { board: B::copy_of(&kept), patience_us: self.patience_us }
    }
}

/// Length and CRC of an image.
pub fn identity(image: &[u8]) -> (u16, u16) {
    (image.len() as u16, lang::image::crc_in(image))
}
