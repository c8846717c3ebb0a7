//! Effects that move nothing, traced as the host sees them.

use lang::fault::Fault;
use lang::wire::{End, RunState, TRACE_OK, TraceKind};
use proptest::prelude::*;

use crate::rig::{Event, Rig, T_HEARD, event};

fn out(n: u8, on: bool) -> Event {
    event(TraceKind::Out, n, on.into())
}

fn done() -> Event {
    event(TraceKind::End, End::Done as u8, 0)
}

fn failed(fault: Fault) -> Event {
    event(TraceKind::End, End::Fault as u8, fault.number().into())
}

/// The script's trace on a built-in profile; nothing happens at the inputs.
fn trace(profile: &str, script: &str) -> Vec<Event> {
    let mut rig = Rig::traced(profile, script);
    rig.start();
    rig.ms(100);
    rig.events
}

#[test]
fn outputs_change_at_the_pins_and_in_the_trace() {
    let script = "DIM n, k\nSetOut 1, ON\nn = 3\nSetOut n, 2\nk = OUT(n)\nSetOut n, k - 1\nSetOut 1, OFF\nSetOut n + 14, ON\n";
    let mut rig = Rig::traced("mill", script);
    rig.start();
    assert_eq!(
        rig.events,
        [out(1, true), out(3, true), out(3, false), out(1, false), failed(Fault::ValueRange)]
    );
    let changes = rig.changes();
    for n in [1, 3] {
        assert_eq!(changes.iter().rfind(|change| change.0 == n), Some(&(n, false)));
    }
}

#[test]
fn a_pulse_ends_in_a_pause_too() {
    let mut rig = Rig::traced("mill", "Pulse 4, 100ms\nWait 1ms\n");
    rig.start();
    assert_eq!(rig.events, [out(4, true)]);
    rig.stop();
    assert_eq!(rig.state(), RunState::Paused);
    assert!(rig.output(4));
    rig.ms(80);
    assert!(!rig.output(4));
    rig.start();
    assert!(!rig.output(4), "resuming does not bring it back");
    let wait = event(TraceKind::Wait, 0, 1);
    assert_eq!(rig.events, [out(4, true), out(4, false), wait, done()]);
}

#[test]
fn a_port_is_set_output_by_output() {
    let expected: Vec<Event> =
        (1..=8).map(|n| out(n, 0x5A >> (n - 1) & 1 != 0)).chain([done()]).collect();
    assert_eq!(trace("mill", "SetPort &H15A\n"), expected);
}

#[test]
fn a_port_leaves_enable_and_lamp_alone() {
    let text = include_str!("../../../examples/profiles/mill.toml").to_owned()
        + "\n[[output]]\nn = 3\nrole = \"lamp\"\n\n[[output]]\nn = 8\nrole = \"enable\"\n";
    let profile = lang::profile::Profile::parse(&text).expect("mill with a lamp");
    let mut rig = Rig::with(&profile, "SetPort 255\nMotors ON\nMotors OFF, Y\n");
    rig.chip.set_byte("TRACING", 1);
    rig.chip.set_byte("HOMED", 0b111);
    rig.start();
    let expected: Vec<Event> =
        [1, 2, 4, 5, 6, 7].map(|n| out(n, true)).into_iter().chain([done()]).collect();
    assert_eq!(rig.events, expected);
    assert_eq!(rig.chip.byte("HOMED"), 0b101);
}

#[test]
fn waits_for_inputs_meet_levels_and_edges() {
    let script = "WaitIn 2, ON\nWaitIn 2, FALL\nWaitIn 7, RISE\nWaitIn 7, OFF\n";
    let mut rig = Rig::traced("mill", script);
    let met = |n, v| event(TraceKind::WaitIn, n | TRACE_OK, v);
    rig.start();
    rig.input(7, true);
    assert_eq!(rig.events, []);
    rig.input(2, true);
    assert_eq!(rig.events, [met(2, 1)]);
    rig.input(2, false);
    rig.ms(50);
    assert_eq!(rig.events, [met(2, 1), met(2, 0)], "input 7 was on before");
    rig.input(7, false);
    assert_eq!(rig.events.len(), 2);
    rig.input(7, true);
    rig.input(7, false);
    assert_eq!(rig.events[2..], [met(7, 1), met(7, 0), done()]);
}

#[test]
fn waits_time_out() {
    let missed = |n, v| event(TraceKind::WaitIn, n, v);
    let script = "DIM n, s\nn = 3 : s = 1\nWaitIn? n, s, 20ms\nIF TIMEDOUT THEN SetOut 5, ON\nWaitIn? n, OFF, 20ms\nIF TIMEDOUT THEN SetOut 6, ON\nWaitIn n + 1, RISE, 30ms\n";
    let met = event(TraceKind::WaitIn, 3 | TRACE_OK, 0);
    assert_eq!(
        trace("mill", script),
        [missed(3, 1), out(5, true), met, missed(4, 1), failed(Fault::TimedOut)]
    );
    assert_eq!(trace("mill", "DIM t\nt = -1ms\nWait t\n"), [failed(Fault::ValueRange)]);
    let script = "DIM t\nt = -1ms\nWaitIn 1, ON, t\n";
    assert_eq!(trace("mill", script), [failed(Fault::ValueRange)]);
    assert_eq!(trace("mill", "DIM n\nWaitIn n, ON\n"), [failed(Fault::ValueRange)]);
}

#[test]
fn a_wait_takes_its_time() {
    let mut rig = Rig::new("mill", "Wait 50ms\nSetOut 1, ON\n");
    rig.start();
    let left = rig.chip.long("TIME", 0);
    assert!(left > 0);
    rig.ms(left - 1);
    assert_eq!(rig.state(), RunState::Running);
    rig.ms(2);
    assert_eq!(rig.state(), RunState::Ready);
}

#[test]
fn a_wait_for_start_wants_a_new_press() {
    let mut rig = Rig::traced("mill", "WaitStart\nSetOut 1, ON\n");
    rig.start();
    rig.ms(50);
    assert_eq!(rig.events, []);
    rig.start();
    assert_eq!(rig.events, [event(TraceKind::WaitStart, TRACE_OK, 0), out(1, true), done()]);
}

#[test]
fn characters_go_both_ways() {
    let script = "Send 65\nWaitChar 66\nSend CHARIN() + 33\nWaitChar? 67, 10ms\nSend 126\n";
    let mut rig = Rig::traced("mill", script);
    rig.start();
    assert_eq!(rig.chip.word("CHAR_OUT"), 0x0141);
    rig.chip.set_byte("CHAR_IN", 65);
    rig.ms(5);
    assert_eq!(rig.chip.byte("CHAR_IN"), 65, "not the one");
    rig.chip.set_byte("CHAR_IN", 66);
    rig.ms(30);
    let sent = |c| event(TraceKind::Send, 0, c);
    let expected = [sent(65), event(TraceKind::WaitChar, 66 | TRACE_OK, 66)];
    assert_eq!(rig.events[..2], expected);
}

#[test]
fn inputs_are_read_by_number() {
    let script =
        "DIM n\nFOR n = 1 TO 17\nIF IN(n) THEN PRINT n\nNEXT\nPRINT IN(2); IN(3)\nPRINT IN(n)\n";
    let mut rig = Rig::new("mill", script);
    for n in [2, 9, 16, 17] {
        rig.input(n, true);
    }
    rig.start();
    assert_eq!(rig.printed, "2\n9\n16\n17\n10\n");
    assert_eq!(rig.chip.byte("VM_FAULT"), Fault::ValueRange.number());
}

#[test]
fn quantities_are_printed_with_their_unit() {
    let script = "DIM n\nn = -1\nPRINT -2147483648; \" \"; 0; \"|\"; n\nPRINT 2540um; 250ms; 100st; 25mm/s; 2000st/s; 3mm/s2; 400st/s2\nPRINT \"no more than sixteen bytes at once\"\n";
    let text = "-2147483648 0|-1\n2540um250ms100st25000um/s2000st/s3000um/s2400st/s2\nno more than sixteen bytes at once\n";
    let mut rig = Rig::new("mill", script);
    rig.start();
    rig.ms(20);
    assert_eq!(rig.printed, text);
    let mut rig = Rig::traced("mill", script);
    rig.start();
    rig.ms(20);
    assert_eq!(rig.printed, text);
    let print = event(TraceKind::Print, 0, 0);
    assert_eq!(rig.events, [print, print, print, done()]);
}

#[test]
fn lines_that_nobody_takes_are_dropped_whole() {
    let script = "PRINT \"first\"\nPRINT \"the second is too long\"\nPRINT \"third\"\n";
    let mut rig = Rig::new("mill", script);
    rig.takes = false;
    rig.chip.set_word("UNHEARD", 512);
    rig.start();
    assert_eq!(rig.state(), RunState::Ready);
    rig.takes = true;
    rig.ms(1);
    assert_eq!(rig.printed, "first\nthird\n");
}

#[test]
fn a_line_waits_half_a_second_for_a_host_that_takes_nothing() {
    let mut rig = Rig::new("mill", "PRINT \"longer than the ring is\"\nSetOut 2, ON\n");
    rig.takes = false;
    rig.start();
    rig.ms(400);
    assert_eq!(rig.state(), RunState::Running);
    rig.ms(200);
    assert_eq!(rig.state(), RunState::Ready);
}

#[test]
fn a_line_waits_while_a_host_listens() {
    let mut rig = Rig::new("mill", "PRINT \"longer than the ring is\"\n");
    rig.takes = false;
    rig.start();
    rig.ms(200);
    assert_eq!(rig.state(), RunState::Running);
    rig.takes = true;
    rig.ms(2);
    assert_eq!(rig.printed, "longer than the ring is\n");
    assert_eq!(rig.state(), RunState::Ready);
}

#[test]
fn a_trace_slot_is_read_by_parity() {
    let mut rig = Rig::new("mill", "Wait 1ms\n");
    let chip = &mut rig.chip;
    let read = |chip: &mut crate::chip::Chip, index: u16| {
        chip.call("trace_slot", &[(12, index)]);
        chip.reg(12)
    };
    chip.set_word("TRACE_NUMBER", 7);
    chip.set_word("TRACE_PC", 0x123);
    chip.set_long("TRACE_VALUE", 0, 0x0004_0005);
    // Trace mode, and the slot is full.
    chip.set_byte("TRACING", 3);
    assert_eq!(read(chip, 8), 7);
    assert_eq!([10, 11, 12, 13].map(|index| read(chip, index)), [0x123, 5, 4, 0]);
    assert_eq!(chip.byte("TRACING"), 3 | *T_HEARD, "not received yet");
    assert_eq!(read(chip, 0), 0);
    assert_eq!(chip.byte("TRACING"), 1 | *T_HEARD);
}

#[test]
fn numbers_are_printed_as_the_host_prints_them() {
    let rig = std::cell::RefCell::new(Rig::new("mill", "DIM n AT 3000\nWaitStart\nPRINT n\n"));
    proptest!(ProptestConfig::with_cases(24), |(n in any::<i32>(), shift in 0..32u32)| {
        let mut rig = rig.borrow_mut();
        let n = n >> shift;
        rig.start();
        let cells = rig.chip.word("VM_CELLS");
        rig.chip.board.poke16(cells, n as u16);
        rig.chip.board.poke16(cells + 2, (n >> 16) as u16);
        rig.start();
        prop_assert_eq!(std::mem::take(&mut rig.printed), format!("{n}\n"));
    });
}
