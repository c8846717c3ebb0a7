//! The output pins of the MSP430F5529 from the first instruction of a reset: with a profile that says how the board is
//! wired, and with none, when all are left to their resistors and nothing moves.

mod rig;

use emulator::{Board, Config, Part, Silicon, Wiring};
use lang::part::{F5529, pins};
use lang::profile::Profile;
use lang::record::BoardRecord;
use lang::wire::{self, Control, Exception, RunState, command};
use rig::{BOOT_US, ask, image, machine, off, on, read, write, write_body};

/// Registers of the ports that have output 1, which is the latch of the chain, and output 2, which is its output enable.
const P1OUT: u16 = 0x0202;
const P1DIR: u16 = 0x0204;
const P1SEL: u16 = 0x020A;
const P3DIR: u16 = 0x0224;
const P3SEL: u16 = 0x022A;
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

/// Pins of STEP, DIR, the PWM and the chain's SPI that the board drives or has given a peripheral, port by port.
fn moving(board: &mut Board) -> [u8; 3] {
    let steps = board.bus_read8(P1DIR) | board.bus_read8(P1SEL);
    let port3 = board.bus_read8(P3DIR) | board.bus_read8(P3SEL);
    [
        steps & pins::mask(&pins::STEP),
        board.bus_read8(P6DIR) & pins::mask(&pins::DIR),
        port3 & (pins::PWM.mask() | pins::mask(&pins::CHAIN)),
    ]
}

/// Whether it drives no pin of the machine.
fn lets_go(board: &mut Board) -> bool {
    driven(board) == [None; 2] && moving(board) == [0; 3]
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
                    lets_go(board) && board.plant().outputs() == off
                });
            }
            // Neither does it when it is asked to: it says that it has none.
            assert_eq!(read(&mut board, wire::RUN_STATE), Some(RunState::Empty as u16));
            let reply = ask(&mut board, &write_body(wire::OUTPUTS, 1), 20_000);
            assert_eq!(reply.get(1..3), Some(&[0x86, Exception::IllegalValue as u8][..]));
            let reply = ask(&mut board, &[1, 5, 0, wire::COILS as u8, 0xFF, 0], 20_000);
            assert_eq!(reply.get(1..3), Some(&[0x85, Exception::IllegalAddress as u8][..]));
            // Nor does it begin a motion, from a command or as a program, and it says why.
            let words = [command::MOVE_BY, 1, 800, 0, 1000, 0, 10_000, 0, 10_000, 0];
            for (register, word) in (wire::COMMAND + 1..).zip(&words[1..]) {
                write(&mut board, register, *word);
            }
            let reply = ask(&mut board, &write_body(wire::COMMAND, words[0]), 20_000);
            assert_eq!(reply.get(1..3), Some(&[0x86, Exception::Busy as u8][..]));
            assert_eq!(read(&mut board, wire::BLOCKING_INPUT), Some(wire::UNWIRED));
            write(&mut board, wire::RUN_CONTROL, Control::EmergencyStop as u16);
            board.run_us(10_000);
            assert!(lets_go(&mut board) && board.plant().outputs() == off);
            assert_eq!(read(&mut board, wire::MACHINE_POSITIONS), Some(0));
            assert_eq!(board.warnings(), &[]);
        }
    }
}

/// What is no profile yet: of the first one so many words were written when power failed.
#[test]
fn a_board_whose_first_profile_is_cut_short_drives_nothing() {
    for low in [false, true] {
        let mut profile = machine("");
        profile.step_invert = low;
        let whole = BoardRecord::of(&profile, 1).to_bytes();
        for words in [1, 2, 3, 16, BoardRecord::SIZE / 2 - 1] {
            let mut bytes = whole;
            bytes[2 * words..].fill(0xFF);
            for place in F5529.profiles {
                let mut board = empty(Wiring::Direct);
                (place..).zip(bytes).for_each(|(at, byte)| board.poke8(at, byte));
                each_instruction(&mut board, "power-up", lets_go);
                assert_eq!(board.warnings(), &[], "{words} words");
            }
        }
    }
}

/// What is no profile any more: its last word says where STEP rests, until the set-up has found that it does not hold.
#[test]
fn a_board_whose_profile_is_broken_drives_no_output() {
    let mut bytes = BoardRecord::of(&machine(""), 1).to_bytes();
    bytes[4] ^= 1;
    let mut board = empty(Wiring::Direct);
    for place in F5529.profiles {
        (place..).zip(bytes).for_each(|(at, byte)| board.poke8(at, byte));
    }
    for reset in ["power-up", "RST"] {
        each_instruction(&mut board, reset, |board| driven(board) == [None; 2]);
        assert!(lets_go(&mut board), "{reset}");
    }
    assert_eq!(board.warnings(), &[]);
}

/// A program is no profile: with a stored one Start does nothing.
#[test]
fn a_board_without_a_profile_begins_no_program() {
    let mut board = off(Silicon::default(), &machine(""), "G1 X10 F600\n");
    for place in F5529.profiles {
        (place..).zip([0xFF; BoardRecord::SIZE]).for_each(|(at, byte)| board.poke8(at, byte));
    }
    board.power_up();
    board.run_us(BOOT_US);
    assert_eq!(read(&mut board, wire::RUN_STATE), Some(RunState::Ready as u16));
    write(&mut board, wire::RUN_CONTROL, Control::Start as u16);
    board.run_us(100_000);
    assert_eq!(read(&mut board, wire::RUN_STATE), Some(RunState::Ready as u16));
    assert_eq!(read(&mut board, wire::RUN_COUNT), Some(0));
    assert!(lets_go(&mut board));
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
            let [steps, dirs, _] = moving(&mut board);
            assert_eq!((steps, dirs), (pins::mask(&pins::STEP), pins::mask(&pins::DIR)));
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

/// What a profile that comes over the link brings holds from the next reset on: STEP and outputs are driven at rest first.
#[test]
fn a_profile_wires_the_board_at_the_next_reset() {
    for low in [false, true] {
        let mut profile = direct(low);
        profile.step_invert = low;
        let mut board = empty(Wiring::Direct);
        board.power_up();
        board.run_us(BOOT_US);
        let bytes = BoardRecord::of(&profile, 1).to_bytes();
        for (register, word) in (wire::PROFILE_WINDOW..).zip(bytes.chunks(2)) {
            assert!(lets_go(&mut board), "register {register}");
            let body = write_body(register, u16::from_le_bytes([word[0], word[1]]));
            assert_eq!(
                ask(&mut board, &body, 60_000).get(..6),
                Some(&body[..]),
                "register {register}"
            );
        }
        assert!(lets_go(&mut board), "before its reset");
        write(&mut board, wire::RUN_CONTROL, Control::Restart as u16);
        for n in 0..INSTRUCTIONS {
            board.step();
            let resting = if low { pins::mask(&pins::STEP) } else { 0 };
            let steps = board.bus_read8(P1DIR) & pins::mask(&pins::STEP);
            assert!(
                steps == 0 || board.bus_read8(P1OUT) & steps == resting & steps,
                "instruction {n}: STEP begins at work"
            );
            let off = |level: Option<bool>| level.is_none_or(|level| level == low);
            assert!(driven(&mut board).into_iter().all(off), "instruction {n}: an output is on");
        }
        board.run_us(BOOT_US);
        assert_eq!(moving(&mut board)[..2], [pins::mask(&pins::STEP), pins::mask(&pins::DIR)]);
        write(&mut board, wire::OUTPUTS, 0b1);
        board.run_us(10_000);
        assert_eq!(driven(&mut board), [Some(!low), Some(low)]);
    }
}

/// Power fails at each word of a profile that comes over the link: to a board that has none, and to one that has.
#[test]
fn power_that_fails_while_a_profile_is_written_leaves_the_old_one_or_none() {
    let new = BoardRecord::of(&direct(false), 2).to_bytes();
    for cut in (0..BoardRecord::SIZE / 2).step_by(5) {
        let mut none = empty(Wiring::Direct);
        none.power_up();
        none.run_us(BOOT_US);
        let some = on(Silicon::default(), &direct(true), "Wait 999s\n");
        for (mut board, before) in [(none, None), (some, Some(true))] {
            let mut at = wire::PROFILE_WINDOW;
            for word in new.chunks(2).take(cut) {
                let body = write_body(at, u16::from_le_bytes([word[0], word[1]]));
                assert_eq!(ask(&mut board, &body, 60_000).get(..6), Some(&body[..]));
                at += 1;
            }
            // In the middle of the next one, of the first one's erase.
            let word = u16::from_le_bytes([new[2 * cut], new[2 * cut + 1]]);
            let end = board.uart_send(&rig::frame(&write_body(at, word)));
            board.run_until(end);
            board.run_us(if cut == 0 { 12_000 } else { 1_900 });
            board.power_cut();
            board.power_up();
            for n in 0..INSTRUCTIONS {
                board.step();
                let holds = match before {
                    None => lets_go(&mut board),
                    Some(off) => driven(&mut board)
                        .into_iter()
                        .all(|level| level.is_none_or(|level| level == off)),
                };
                assert!(holds, "{cut} words, instruction {n}");
            }
            board.run_us(BOOT_US);
            match before {
                None => assert!(lets_go(&mut board), "{cut} words"),
                Some(_) => assert_eq!(driven(&mut board), [Some(true); 2], "{cut} words"),
            }
        }
    }
}
