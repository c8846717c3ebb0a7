//! The outputs' pins of the MSP430F5529 from the first instruction of a reset: with a profile that says how the board is
//! wired, and with none, when both are left to their resistors.

mod rig;

use emulator::{Board, Config, Part, Silicon, Wiring};
use lang::part::{F5529, pins};
use lang::profile::Profile;
use lang::record::BoardRecord;
use lang::wire::{self, Exception, RunState};
use rig::{BOOT_US, ask, image, machine, off, read, write, write_body};

/// Registers of the ports that have output 1, which is the latch of the chain, and output 2, which is its output enable.
const P1OUT: u16 = 0x0202;
const P1DIR: u16 = 0x0204;
const P6OUT: u16 = 0x0243;
const P6DIR: u16 = 0x0245;

/// Instructions that are looked at one by one: RAM is painted by 30 000 of them, the rest of the set-up takes fewer.
const INSTRUCTIONS: u32 = 100_000;

/// What the board does to the pins of outputs 1 and 2: `None` is nothing, else the level.
fn driven(board: &mut Board) -> [Option<bool>; 2] {
    let mut pin = |dir, out, mask| {
        (board.bus_read8(dir) & mask != 0).then(|| board.bus_read8(out) & mask != 0)
    };
    [pin(P1DIR, P1OUT, pins::LATCH.mask()), pin(P6DIR, P6OUT, pins::ENABLE.mask())]
}

/// A board of this wiring with erased information memory, still without power.
fn empty(wiring: Wiring) -> Board {
    let config = Config { part: Part::F5529, wiring, ..Config::default() };
    let mut board = Board::with_config(&config, &image());
    board.power_cut();
    board
}

/// Resets it and holds `holds` at each instruction of the set-up and for a while in the main loop.
fn each_instruction(board: &mut Board, reset: &str, holds: impl Fn(&mut Board) -> bool) {
    match reset {
        "power-up" => board.power_up(),
        _ => board.reset_pin(),
    }
    for n in 0..INSTRUCTIONS {
        board.step();
        let found = driven(board);
        assert!(holds(board), "{reset}, instruction {n}: {found:?}");
    }
    for ms in 0..200 {
        board.run_us(1_000);
        let found = driven(board);
        assert!(holds(board), "{reset}, {ms} ms later: {found:?}");
    }
}

#[test]
fn a_board_without_a_profile_drives_no_output() {
    for wiring in [Wiring::Direct, Wiring::Chain] {
        // Resistors to ground, and to 3.3 V for outputs that are on when low.
        for up in [false, true] {
            let mut board = empty(wiring);
            if up {
                board.plant_mut().pull_outputs_up();
            }
            let off = if up && wiring == Wiring::Direct { 0b11 } else { 0 };
            for reset in ["power-up", "RST"] {
                each_instruction(&mut board, reset, |board| {
                    driven(board) == [None; 2] && board.plant().outputs() == off
                });
            }
            // Neither does it when it is asked to: it says that it has none.
            assert_eq!(read(&mut board, wire::RUN_STATE), Some(RunState::Empty as u16));
            let reply = ask(&mut board, &write_body(wire::OUTPUTS, 1), 20_000);
            assert_eq!(reply.get(1..3), Some(&[0x86, Exception::IllegalValue as u8][..]));
            let reply = ask(&mut board, &[1, 5, 0, wire::COILS as u8, 0xFF, 0], 20_000);
            assert_eq!(reply.get(1..3), Some(&[0x85, Exception::IllegalAddress as u8][..]));
            board.run_us(10_000);
            assert_eq!((driven(&mut board), board.plant().outputs()), ([None; 2], off));
            assert_eq!(board.warnings(), &[]);
        }
    }
}

/// What is no profile any more, or not yet.
#[test]
fn a_board_whose_profile_is_broken_drives_no_output() {
    let whole = BoardRecord::of(&machine(""), 1).to_bytes();
    let mut torn = whole;
    torn[BoardRecord::SIZE / 2..].fill(0xFF);
    let mut flipped = whole;
    flipped[4] ^= 1;
    for (what, bytes) in [("torn", torn), ("flipped", flipped)] {
        let mut board = empty(Wiring::Direct);
        for place in F5529.profiles {
            (place..).zip(bytes).for_each(|(at, byte)| board.poke8(at, byte));
        }
        for reset in ["power-up", "RST"] {
            each_instruction(&mut board, reset, |board| driven(board) == [None; 2]);
        }
        assert_eq!(board.warnings(), &[], "{what}");
    }
}

/// The built-in machine with its inputs and outputs at the pins, outputs on when low or when high.
fn direct(invert: bool) -> Profile {
    let mut profile = machine("");
    profile.wiring = lang::profile::Wiring::Direct;
    profile.outputs.truncate(2);
    for (n, output) in (1..).zip(&mut profile.outputs) {
        (output.n, output.invert, output.role) = (n, invert, None);
    }
    profile
}

#[test]
fn a_board_with_a_profile_drives_its_outputs_off_until_they_are_wanted() {
    for invert in [false, true] {
        let mut board = off(Silicon::default(), &direct(invert), "Wait 999s\n");
        if invert {
            board.plant_mut().pull_outputs_up();
        }
        let rests = if invert { 0b11 } else { 0 };
        for reset in ["power-up", "RST"] {
            each_instruction(&mut board, reset, |board| {
                let off = |level: Option<bool>| level.is_none_or(|level| level == invert);
                driven(board).into_iter().all(off) && board.plant().outputs() == rests
            });
            assert_eq!(driven(&mut board), [Some(invert); 2], "{reset}: driven at last");
        }
        write(&mut board, wire::OUTPUTS, 0b11);
        board.run_us(10_000);
        assert_eq!(driven(&mut board), [Some(!invert); 2]);
    }
    // Of the chain the registers' outputs are let go until they hold what is wanted.
    let mut board = off(Silicon::default(), &machine(""), "Wait 999s\n");
    for reset in ["power-up", "RST"] {
        each_instruction(&mut board, reset, |board| {
            let [_, enable] = driven(board);
            enable != Some(false) || board.plant().chain.latched == 0
        });
        assert_eq!(driven(&mut board), [Some(true), Some(false)], "{reset}: driven at last");
    }
    assert_eq!(board.warnings(), &[]);
}

/// What a profile brings holds from the next reset on.
#[test]
fn a_profile_wires_the_board_at_the_next_reset() {
    let mut board = empty(Wiring::Chain);
    board.power_up();
    board.run_us(BOOT_US);
    assert_eq!(driven(&mut board), [None; 2]);
    let bytes = BoardRecord::of(&machine(""), 1).to_bytes();
    (F5529.profiles[1]..).zip(bytes).for_each(|(at, byte)| board.poke8(at, byte));
    board.reset_pin();
    board.run_us(BOOT_US);
    write(&mut board, wire::OUTPUTS, 0b1);
    board.run_us(10_000);
    assert_eq!(board.plant().outputs(), 1);
}
