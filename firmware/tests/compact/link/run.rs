//! The slave while a program runs.

use lang::fault::Fault;
use lang::isa::Op;
use lang::wire::{self, RunState};

use super::{sealed, words};
use crate::chip::Chip;
use crate::machine::{install, mill};

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
    install(&mut chip, &mill());
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
