//! Runs: Start, Stop, pauses, faults, and what the VM leaves to the session.

use lang::fault::Fault;
use lang::image::{Image, at, seal};
use lang::isa::Op;
use lang::profile::Profile;
use lang::wire::{End, RunState, TraceKind};

use crate::rig::{Rig, event, image_of};

const END: fn(u8, i32) -> crate::rig::Event = |end, fault| event(TraceKind::End, end, fault);

#[test]
fn start_runs_the_program_to_its_end() {
    let mut rig = Rig::traced("mill", "DIM i\nFOR i = 1 TO 3\nWait i * 10ms\nNEXT\n");
    rig.start();
    assert_eq!(rig.state(), RunState::Running);
    rig.ms(60);
    let wait = |ms| event(TraceKind::Wait, 0, ms);
    assert_eq!(rig.events, [wait(10), wait(20), wait(30), END(End::Done as u8, 0)]);
    assert_eq!(rig.state(), RunState::Ready);
    assert_eq!(rig.chip.byte("LAST_END"), End::Done as u8);
    assert_eq!(rig.chip.word("RUNS"), 1);
}

#[test]
fn a_pause_stops_the_clock_of_waits() {
    let mut rig = Rig::new("mill", "SetOut 2, ON\nWait 100ms\nSetOut 2, OFF\n");
    rig.start();
    assert!(rig.output(2));
    rig.stop();
    assert_eq!(rig.state(), RunState::Paused);
    let left = rig.chip.long("TIME", 0);
    rig.ms(500);
    assert_eq!(rig.chip.long("TIME", 0), left);
    rig.start();
    assert_eq!(rig.state(), RunState::Running);
    rig.ms(left + 2);
    assert_eq!(rig.state(), RunState::Ready);
}

#[test]
fn stop_held_for_two_seconds_ends_the_run() {
    let mut rig = Rig::traced("mill", "Wait 10s\n");
    rig.start();
    rig.chip.board.plant_mut().press_stop(true);
    rig.ms(1990);
    assert_eq!(rig.state(), RunState::Paused);
    rig.ms(30);
    assert_eq!(rig.state(), RunState::Ready);
    assert_eq!(rig.events.last(), Some(&END(End::Stopped as u8, 0)));
}

#[test]
fn a_fault_ends_the_run_and_start_acknowledges_it() {
    let mut rig = Rig::traced("mill", "DIM a, b\nb = 1 / a\nSetOut 2, ON\n");
    rig.start();
    let fault = Fault::DivisionByZero.number();
    assert_eq!(rig.events, [END(End::Fault as u8, fault.into())]);
    assert_eq!(rig.state(), RunState::Fault);
    assert_eq!(rig.chip.byte("VM_FAULT"), fault);
    rig.start();
    assert_eq!(rig.state(), RunState::Ready);
    assert_eq!(rig.chip.byte("VM_FAULT"), fault, "still to be read");
}

#[test]
fn errors_go_to_their_handler_and_back() {
    let script = "DIM a, b\nON ERROR GOTO bad\nb = 7\nb = 1 / a\nPRINT b\nEND\nbad:\nPRINT ERR; \" at \"; ERL\nRESUME NEXT\n";
    let mut rig = Rig::new("mill", script);
    rig.start();
    assert_eq!(rig.printed, "2 at 4\n7\n");
    assert_eq!(rig.state(), RunState::Ready);
    assert_eq!(rig.chip.byte("VM_FAULT"), 0, "the run ended well");
}

#[test]
fn a_goto_out_of_the_handler_forgets_what_was_open() {
    let script = "DIM n, d\nON ERROR GOTO bad\nagain:\nn = n + 1\nGOSUB work\nPRINT n\nEND\nwork:\nIF n < 9 THEN d = 1 / (n - n)\nRETURN\nbad:\nGOTO again\n";
    let mut rig = Rig::new("mill", script);
    rig.start();
    assert_eq!(rig.printed, "9\n");
}

#[test]
fn faults_that_no_handler_takes_end_the_run() {
    let script = "ON ERROR GOTO bad\nWait 1s\nEND\nbad:\nPRINT \"handled\"\n";
    let mut rig = Rig::traced("mill", script);
    rig.start();
    rig.chip.call("control", &[(12, 5)]);
    assert_eq!(rig.chip.byte("HOMED"), 0);
    rig.ms(2);
    let fault = i32::from(Fault::EmergencyStop.number());
    assert_eq!(rig.events.last(), Some(&END(End::Fault as u8, fault)));
    assert_eq!(rig.state(), RunState::Fault);
}

#[test]
fn an_input_may_be_a_start_button() {
    let text = include_str!("../../../examples/profiles/mill.toml").to_owned()
        + "\n[[input]]\nn = 13\nrole = \"start\"\n";
    let profile = lang::profile::Profile::parse(&text).expect("mill with a second button");
    let mut rig = Rig::with(&profile, "WaitStart\nSetOut 2, ON\n");
    rig.input(12, true);
    assert_eq!(rig.state(), RunState::Ready);
    rig.input(13, true);
    assert_eq!(rig.state(), RunState::Running);
    rig.ms(100);
    assert!(!rig.output(2), "one press");
    rig.input(13, false);
    rig.input(13, true);
    assert_eq!(rig.state(), RunState::Ready);
    assert_eq!(rig.chip.word("RUNS"), 1);
}

#[test]
fn a_second_run_finds_its_memory_empty() {
    let mut rig = Rig::new("mill", "DIM a(3)\na(1) = a(1) + 1\nPRINT a(1)\n");
    for _ in 0..3 {
        rig.start();
    }
    assert_eq!(rig.printed, "1\n1\n1\n");
    assert_eq!(rig.chip.word("RUNS"), 3);
}

#[test]
fn functions_and_calls_share_the_stack() {
    let script = "PRINT 1 + twice(3) * twice(one() + 4)\nEND\nFUNCTION twice(n)\nRETURN n + n\nEND FUNCTION\nFUNCTION one()\nRETURN 1\nEND FUNCTION\n";
    let mut rig = Rig::new("mill", script);
    rig.start();
    rig.ms(50);
    assert_eq!(rig.printed, "61\n");
}

#[test]
fn a_function_that_calls_itself_ends_before_it_writes_over_cells() {
    let mill = Profile::built_in("mill").expect("a built-in profile");
    let script = "DIM a, b\nb = 7\na = f(1)\nFUNCTION f(n)\nRETURN 1 + (2 + g(n))\n\
                  END FUNCTION\nFUNCTION g(n)\nRETURN n\nEND FUNCTION\n";
    let mut image = image_of(&mill, script);
    // The compiler refuses it: f calls itself instead of g, with room for twelve calls.
    image[at::CALLS] = 12;
    let parsed = Image::new(&image).expect("an image");
    let (start, code) = (image.len() - parsed.code.len() - parsed.data.len(), parsed.code);
    let mut calls = Vec::new();
    let mut pc = 0;
    while let Some((op, _)) = code.get(pc).and_then(|code| Op::decode(*code)) {
        if op == Op::Func {
            calls.push((start + pc + 1, [code[pc + 1], code[pc + 2]]));
        }
        pc += 1 + op.row().operands.len(false);
    }
    let [inner, outer] = calls[..] else { panic!("{calls:?}") };
    assert!(inner.1 != outer.1);
    image[inner.0..inner.0 + 2].copy_from_slice(&outer.1);
    seal(&mut image);
    let mut rig = Rig::with_image(&mill, &image);
    rig.start();
    assert_eq!(rig.chip.byte("VM_FAULT"), Fault::Stack.number());
    let b = rig.chip.word("VM_CELLS") + 4;
    assert_eq!(rig.chip.board.peek16(b), 7);
}

#[test]
fn the_lamp_shows_the_state() {
    let text = include_str!("../../../examples/profiles/mill.toml").to_owned()
        + "\n[[output]]\nn = 9\nrole = \"lamp\"\n";
    let profile = lang::profile::Profile::parse(&text).expect("mill with a lamp");
    let mut rig = Rig::with(&profile, "DIM a\nWait 3s\na = 1 / a\n");
    rig.ms(20);
    assert!(rig.output(9), "ready");
    rig.changes();
    rig.start();
    rig.ms(2900);
    let blinks = rig.changes().len();
    assert!((5..=7).contains(&blinks), "slow: {blinks} changes");
    rig.ms(200);
    assert_eq!(rig.state(), RunState::Fault);
    rig.changes();
    rig.ms(32 * 256);
    assert_eq!(rig.changes().len(), 4, "F02: two blinks in 8 s");
}

#[test]
fn the_main_loop_runs_a_program_from_reset() {
    let script = "DIM i\nFOR i = 1 TO 5\nSetOut 2, ON\nWait 20ms\nSetOut 2, OFF\nWait 20ms\nNEXT\n";
    let mut rig = Rig::new("mill", script);
    let board = &mut rig.chip.board;
    board.reset_pin();
    board.run_us(60_000);
    board.plant_mut().take_output_changes();
    board.plant_mut().press_start(true);
    board.run_us(40_000);
    board.plant_mut().press_start(false);
    board.run_us(300_000);
    assert_eq!(rig.changes(), [(2, true), (2, false)].repeat(5));
    assert_eq!(rig.state(), RunState::Ready);
    assert_eq!((rig.chip.word("RUNS"), rig.chip.word("MISSED")), (1, 0));
}

#[test]
fn autorun_begins_half_a_second_after_power_up_alone() {
    let text = include_str!("../../../examples/profiles/mill.toml").to_owned()
        + "\n[run]\nautorun = true\n\n[[input]]\nn = 13\nrole = \"emergency_stop\"\n";
    let profile = lang::profile::Profile::parse(&text).expect("mill with autorun");
    // The causes of resets: watchdog, RST, power with RST; power alone.
    for cause in [1, 8, 12, 4] {
        let mut rig = Rig::with(&profile, "SetOut 2, ON\nWait 1s\n");
        rig.chip.set_byte("CAUSE", cause);
        rig.ms(499);
        assert_eq!(rig.state(), RunState::Ready, "cause {cause}");
        rig.ms(2);
        let wanted = if cause == 4 { RunState::Running } else { RunState::Ready };
        assert_eq!(rig.state(), wanted, "cause {cause}");
        assert_eq!(rig.chip.byte("VM_FAULT"), 0);
    }
}
