//! Motors, switches, probe, outputs, measurements and the recorder.

use emulator::plant::Contact;
use emulator::plant::motor::ViolationKind;
use emulator::{Board, Config, Image, Part, Signal, Stop, VcdWriter, WarningKind, Wiring};

use crate::asm::{D, S, op1, op2};
use crate::{CODE, IDLE, board, board_with};

const P2OUT: u16 = 0x29;

fn driving() -> Board {
    let mut b = board(&IDLE);
    b.bus_write8(0x2E, 0x00);
    b.bus_write8(P2OUT, 0x04);
    b.bus_write8(0x2A, 0xFF);
    b
}

/// One pulse on the STEP pins of `mask`, high and low for `ticks` each.
fn pulse(b: &mut Board, mask: u8, ticks: u64) {
    let out = b.bus_read8(P2OUT);
    b.bus_write8(P2OUT, out | mask);
    b.run_for(ticks);
    b.bus_write8(P2OUT, out);
    b.run_for(ticks);
}

#[test]
fn motors_count_pulses_in_the_direction_of_their_pin() {
    let mut b = driving();
    b.bus_write8(P2OUT, 0x08 | 0x80);
    b.run_for(100);
    for _ in 0..5 {
        pulse(&mut b, 0x13, 50);
    }
    assert_eq!(b.plant().motors.each_ref().map(|m| m.position), [5, -5, 5]);
    b.plant_mut().motors[0].inverted = true;
    b.plant_mut().stall(1, 2);
    for _ in 0..3 {
        pulse(&mut b, 0x03, 50);
    }
    assert_eq!(b.plant().motors.each_ref().map(|m| m.position), [2, -6, 5]);
    assert_eq!(b.plant().motors.each_ref().map(|m| m.pulses), [8, 8, 5]);
    assert!(b.plant().violations().is_empty());
}

#[test]
fn short_pulses_and_late_directions_are_violations() {
    let mut b = driving();
    pulse(&mut b, 0x01, 20);
    b.run_for(100);
    b.bus_write8(P2OUT, 0x08);
    b.run_for(4);
    pulse(&mut b, 0x01, 50);
    let kinds: Vec<_> = b.plant().violations().iter().map(|v| (v.axis, v.kind)).collect();
    assert_eq!(kinds, [(0, ViolationKind::PulseHigh), (0, ViolationKind::DirSetup)]);
    pulse(&mut b, 0x01, 50);
    b.bus_write8(P2OUT, 0x09);
    b.run_for(50);
    b.bus_write8(P2OUT, 0x08);
    b.run_for(10);
    b.bus_write8(P2OUT, 0x09);
    assert_eq!(b.plant().violations()[2].kind, ViolationKind::PulseLow);
    assert_eq!(b.plant().violation_count, 3);
}

#[test]
fn directions_that_change_while_step_is_high_or_has_just_fallen_are_violations() {
    let mut b = driving();
    b.bus_write8(P2OUT, 0x01);
    b.run_for(50);
    b.bus_write8(P2OUT, 0x09);
    b.run_for(50);
    b.bus_write8(P2OUT, 0x08);
    b.run_for(10);
    b.bus_write8(P2OUT, 0x00);
    b.run_for(50);
    b.bus_write8(P2OUT, 0x08);
    let found: Vec<_> = b.plant().violations().iter().map(|v| (v.kind, v.ticks < 16)).collect();
    assert_eq!(found, [(ViolationKind::DirHold, true); 2]);
    assert_eq!(b.plant().violations()[0].ticks, 0, "STEP was high");
}

#[test]
fn switches_close_at_their_place_and_beyond() {
    let config = Config { wiring: Wiring::Direct, ..Config::default() };
    let mut b = board_with(&config, &IDLE);
    b.bus_write8(0x2E, 0x00);
    b.bus_write8(0x2A, 0xDB);
    // Pull-ups on the contacts of port 1.
    b.bus_write8(0x21, 0xF9);
    b.bus_write8(0x27, 0xF9);
    b.plant_mut().switches[0] = Some(Contact { axis: 0, position: -3, above: false });
    b.plant_mut().probes[0] = Some(Contact { axis: 0, position: -5, above: false });
    b.run_for(10);
    let mut levels = Vec::new();
    for _ in 0..6 {
        pulse(&mut b, 0x01, 50);
        levels.push(b.bus_read8(0x20) & 0x90);
    }
    assert_eq!(levels, [0x90, 0x90, 0x80, 0x80, 0x00, 0x00]);
    assert!(b.plant().input(1) && b.plant().input(4));
    b.plant_mut().set_active_low(1, false);
    b.run_for(10);
    assert_eq!(b.bus_read8(0x20) & 0x10, 0x10, "a normally closed contact has opened");
}

#[test]
fn runs_stop_at_output_changes_when_asked() {
    let config = Config { wiring: Wiring::Direct, ..Config::default() };
    // A delay, then BIS.B #4, &P2OUT, then idle.
    let mut code = vec![0x4303; 20];
    code.extend(op2("bis", true, S::Cg(4), D::Abs(P2OUT), CODE + 40));
    code.extend(IDLE);
    let mut b = board_with(&config, &code);
    b.bus_write8(P2OUT, 0);
    b.bus_write8(0x2A, 0x24);
    b.plant_mut().stop_at_output = true;
    assert_eq!(b.run_us(100), Stop::Output);
    assert!(b.plant().output(1) && !b.plant().output(2));
    let changes = b.plant_mut().take_output_changes();
    assert_eq!((changes.len(), changes[0].output, changes[0].on), (1, 1, true));
    assert_eq!(changes[0].cycle, b.cycles());
    assert_eq!(b.run_us(100), Stop::Time);
}

#[test]
fn breakpoints_stop_before_their_instruction_and_runs_go_on_from_them() {
    let mut b = board(&[0x4303, 0x4303, 0x3FFD]);
    b.set_breakpoint(CODE + 2);
    for _ in 0..3 {
        assert_eq!(b.run_us(100), Stop::Breakpoint(u32::from(CODE) + 2));
        assert_eq!(b.reg(0), CODE + 2);
    }
    b.clear_breakpoint(CODE + 2);
    assert_eq!(b.run_us(100), Stop::Time);
}

#[test]
fn profile_and_stack_marks_tell_where_time_and_memory_went() {
    let mut code = op2("mov", false, S::Imm(0x0400), D::R(1), CODE);
    code.extend(op1("push", false, S::R(4), CODE + 4));
    code.extend(op1("push", false, S::R(4), CODE + 6));
    code.extend(IDLE);
    let mut b = board(&code);
    b.paint(0x0200, 0x03FF, 0xA5);
    b.set_reg(4, 0);
    b.set_stack_limit(0x03FE);
    b.profile(true);
    b.run_for(1000);
    assert_eq!(b.stats().lowest_sp, Some(0x03FC));
    assert_eq!(b.untouched(0x0200, 0x03FF, 0xA5), 0x1FC);
    assert_eq!(b.warnings().iter().map(|w| w.kind).collect::<Vec<_>>(), [WarningKind::Stack]);
    let by_word = |at: u16| b.stats().profile()[usize::from(at / 2)];
    assert_eq!([CODE, CODE + 4, CODE + 6].map(by_word), [2, 3, 3]);
    assert!(by_word(CODE + 8) >= 990);
    assert_eq!(b.profile_by_symbol()[0].0, "?");
}

#[test]
fn edges_become_a_value_change_dump() {
    let mut b = driving();
    let start = b.cycles();
    let mut out = Vec::new();
    let mut writer =
        VcdWriter::new(&mut out, &b.plant().signals(), start, b.ticks_per_second()).expect("head");
    b.record(true);
    b.bus_write8(P2OUT, 0x0C);
    pulse(&mut b, 0x01, 100);
    b.plant_mut().set_input(3, true);
    b.plant_mut().press_start(true);
    b.run_for(10);
    writer.write(&b.take_edges()).expect("edges");
    writer.finish(b.cycles()).expect("end");
    let mut parser = vcd::Parser::new(out.as_slice());
    let header = parser.parse_header().expect("a header");
    let names = [
        "step_x", "step_z", "dir_y", "out_1", "out_16", "in_1", "in_17", "start", "stop", "probe",
        "rx", "tx",
    ];
    let codes: Vec<_> = names
        .iter()
        .map(|name| header.find_var(&["board", name]).unwrap_or_else(|| panic!("no {name}")).code)
        .collect();
    let code = |name| header.find_var(&["board", name]).expect("signal").code;
    assert_eq!(codes.len(), names.len());
    let mut changes = Vec::new();
    let mut time = 0;
    for command in parser {
        match command.expect("a command") {
            vcd::Command::Timestamp(t) => time = t,
            vcd::Command::ChangeScalar(id, level) => changes.push((time, id, level)),
            _ => {}
        }
    }
    let of = |name| -> Vec<(u64, vcd::Value)> {
        changes.iter().filter(|c| c.1 == code(name)).map(|c| (c.0, c.2)).collect()
    };
    let steps = of("step_x");
    assert_eq!(steps.len(), 3);
    // 100 ticks of 62.5 ns in units of 100 ps.
    assert_eq!(steps[2].0 - steps[1].0, 62_500);
    assert_eq!(of("in_3").last().map(|c| c.1), Some(vcd::Value::V1));
    assert_eq!(of("start").last().map(|c| c.1), Some(vcd::Value::V0));
    assert_eq!(of("dir_x").last().map(|c| c.1), Some(vcd::Value::V1));
}

#[test]
fn a_sink_hears_every_edge() {
    let mut b = driving();
    let (send, receive) = std::sync::mpsc::channel();
    b.set_edge_sink(Some(Box::new(move |edge| {
        send.send(edge).expect("the receiver lives");
    })));
    pulse(&mut b, 0x02, 100);
    b.set_edge_sink(None);
    let got: Vec<(Signal, bool)> = receive.iter().map(|e| (e.signal, e.level)).collect();
    assert_eq!(got, [(Signal::Step(1), true), (Signal::Step(1), false)]);
}

#[test]
fn a_watched_instruction_stops_runs_and_costs_nothing() {
    // P2DIR = 1; loop: P2OUT ^= 1; jmp loop, with the reset vector at its place.
    let text = "@C000\nF2 43 2A 00 D2 E3 29 00 FD 3F\n@FFFE\n00 C0\nq\n";
    let image = Image::parse(text.as_bytes()).unwrap();
    let mut free = Board::new(Part::G2553, &image);
    let mut seen = free.clone();
    seen.watch(0xC004);
    let mut times = Vec::new();
    loop {
        match seen.run_until(200_000) {
            Stop::Watched(at) => {
                assert_eq!((at, seen.reg(0)), (0xC004, 0xC004));
                times.push(seen.cycles());
            }
            stop => {
                assert_eq!(stop, Stop::Time);
                break;
            }
        }
    }
    free.run_until(200_000);
    assert_eq!(seen.cycles(), free.cycles());
    assert_eq!(seen.plant().motors[0].pulses, free.plant().motors[0].pulses);
    // Once for each pass of the loop, every second of which raises STEP.
    assert!(times.len() > 500, "{}", times.len());
    let raised = seen.plant().motors[0].pulses;
    assert!((times.len() as u64).div_ceil(2).abs_diff(raised) <= 1, "{raised}");
}
