//! Emulated boards with the image of the MSP430F5529, a profile and a program, and a host on their link.
// Each test file takes what it needs.
#![allow(dead_code)]

pub mod company;
#[path = "../slot/mod.rs"]
mod slot;

use emulator::{Board, Config, Image, Part, Silicon, Wiring};
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::part::F5529;
use lang::profile::Profile;
use lang::record::BoardRecord;
use lang::wire::{CRC_START, crc16};

/// From reset to the main loop.
pub const BOOT_US: u64 = 200_000;
pub fn machine(more: &str) -> Profile {
    let (_, text) =
        lang::profile::BUILT_IN.iter().find(|(name, _)| *name == "mill").expect("built in");
    Profile::parse(&format!("{text}\n{more}")).expect("a profile")
}

/// A machine of three axes with these tables of a profile.
pub fn wired(wiring: &str, more: &str) -> Profile {
    let mut text = format!("name = \"d\"\nhome_order = [\"Z\"]\nwiring = \"{wiring}\"\n");
    for axis in ["x", "y", "z"] {
        text += &format!(
            "[{axis}]\nscale = {{ steps = 80, um = 1000 }}\nstart_rate = 400\naccel = 100000\n\
             top_rate = 20000\nmin_um = -1000000\nmax_um = 1000000\n\
             home = {{ direction = \"negative\", fast_rate = 2000, slow_rate = 200, stroke_um = 330000, \
             pause_ms = 100 }}\n"
        );
    }
    Profile::parse(&(text + more)).expect("a profile")
}

/// The shipped image.
pub fn image() -> Image {
    Image::parse(include_bytes!("../../image/pasapas-f5529.elf")).expect("the image")
}

/// Writes a profile into a board without power.
pub fn give(board: &mut Board, profile: &Profile) {
    let record = BoardRecord::of(profile, 1);
    let bytes = record.to_bytes().into_iter().chain(record.more.to_bytes());
    (F5529.profiles[1]..).zip(bytes).for_each(|(at, byte)| board.poke8(at, byte));
}

/// A board with a profile and a program, still without power.
pub fn off(silicon: Silicon, profile: &Profile, script: &str) -> Board {
    let wiring = match profile.wiring {
        lang::profile::Wiring::Direct => Wiring::Direct,
        lang::profile::Wiring::Chain => Wiring::Chain,
    };
    // The fastest oscillator of the watchdog (SLAS590, VLO).
    let config = Config { part: Part::F5529, wiring, silicon, vlo_hz: 14_000, ..Config::default() };
    let mut board = Board::with_config(&config, &image());
    board.power_cut();
    give(&mut board, profile);
    let (source, _) = Source::decode("test", script.as_bytes());
    let (program, diags) = compile(&source, ProfileChoice::Given(Box::new(profile.clone())));
    let program = program.unwrap_or_else(|| panic!("{}", diags.render(&source)));
    let program = lang::back::compile(&program).expect("it fits").image;
    let (first, slot) = slot::slot(&F5529, &program);
    (first..).zip(slot).for_each(|(at, byte)| board.poke8(at, byte));
    board
}

/// The same, come up.
pub fn on(silicon: Silicon, profile: &Profile, script: &str) -> Board {
    let mut board = off(silicon, profile, script);
    board.power_up();
    board.run_us(BOOT_US);
    board
}

pub fn frame(body: &[u8]) -> Vec<u8> {
    let crc = body.iter().fold(CRC_START, |crc, &byte| crc16(crc, byte));
    [body, &crc.to_le_bytes()].concat()
}

pub fn ask(board: &mut Board, body: &[u8], us: u64) -> Vec<u8> {
    board.uart_take();
    let end = board.uart_send(&frame(body));
    board.run_until(end);
    board.run_us(us);
    board.uart_take().into_iter().map(|(_, byte)| byte).collect()
}

pub fn read(board: &mut Board, register: u16) -> Option<u16> {
    let [high, low] = register.to_be_bytes();
    let reply = ask(board, &[1, 3, high, low, 0, 1], 20_000);
    (reply.len() == 7).then(|| u16::from_be_bytes([reply[3], reply[4]]))
}

pub fn write_body(register: u16, value: u16) -> [u8; 6] {
    let ([a, b], [c, d]) = (register.to_be_bytes(), value.to_be_bytes());
    [1, 6, a, b, c, d]
}

pub fn write(board: &mut Board, register: u16, value: u16) {
    let body = write_body(register, value);
    assert_eq!(ask(board, &body, 20_000).get(..6), Some(&body[..]), "register {register}");
}
