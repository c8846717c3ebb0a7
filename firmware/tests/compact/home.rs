//! Reference runs and probes on the running board, against switches and probes of the plant.

use emulator::plant::Contact;
use emulator::{Stop, TICKS_PER_SECOND};
use lang::fault::Fault;
use lang::profile::{Profile, Wiring};
use lang::wire::{End, TRACE_OK, TraceKind};

use crate::live::Live;
use crate::rig::{Event, event};

/// The built-in `mill`, which need not be homed first and looks 10 mm far for its switches.
fn mill() -> Profile {
    let mut profile = Profile::built_in("mill").expect("mill is built in");
    profile.require_homing = false;
    for axis in [&mut profile.x, &mut profile.y, &mut profile.z].into_iter().flatten() {
        axis.home.stroke_um = 10_000;
    }
    profile
}

fn done() -> Event {
    event(TraceKind::End, End::Done as u8, 0)
}

fn failed(fault: Fault) -> Event {
    event(TraceKind::End, End::Fault as u8, fault.number().into())
}

fn home(axis: u8, ok: bool, position: i32) -> Event {
    event(TraceKind::Home, axis | if ok { TRACE_OK } else { 0 }, position)
}

fn probe(axis: u8, ok: bool, position: i32) -> Event {
    event(TraceKind::Probe, axis | if ok { TRACE_OK } else { 0 }, position)
}

/// A board whose axis meets its probe there.
fn with_probe(mut live: Live, axis: usize, position: i64, above: bool) -> Live {
    let contact = Contact { axis, position, above };
    live.board.plant_mut().probes[axis] = Some(contact);
    live
}

#[test]
fn an_axis_finds_its_switch_and_counts_from_where_it_opens() {
    let mut live = Live::new(&mill(), "MoveRel X, 50st\nHome X\nMoveAxe X, 1mm\n");
    live = live.with_switch(0, -500, false);
    live.finish(8000);
    let moved = event(TraceKind::Axe, 0, 0);
    assert_eq!(live.events, [moved, home(0, true, 0), moved, done()]);
    assert_eq!(live.byte("HOMED"), 1);
    assert_eq!(live.longs("ACTUAL")[0], 100);
    assert_eq!(live.motors()[0], -499 + 100);
}

#[test]
fn the_switch_at_the_positive_end_the_position_and_the_clearance_come_from_the_profile() {
    let mut profile = mill();
    let z = profile.z.as_mut().expect("mill has Z");
    z.home.position_um = 2_000;
    z.home.clearance_um = 500;
    let mut live = Live::new(&profile, "SetPos Z, 3mm\nHome Z\n").with_switch(2, 300, true);
    live.finish(8000);
    assert_eq!(live.events, [home(2, true, 150), done()]);
    assert_eq!(live.longs("OFFSET")[2], 0);
    assert_eq!(live.longs("UM")[2], 1_500);
    assert_eq!(live.motors()[2], 299 - 50);
}

#[test]
fn a_switch_that_is_closed_already_is_left_slowly() {
    let mut live = Live::new(&mill(), "Home Y\n").with_switch(1, 20, false);
    live.finish(8000);
    assert_eq!(live.events, [home(1, true, 0), done()]);
    assert_eq!(live.motors()[1], 21);
}

#[test]
fn a_faster_axis_counts_from_where_the_switch_opened_too() {
    let mut profile = mill();
    profile.x.as_mut().expect("mill has X").home.slow_rate = 900;
    let mut live = Live::new(&profile, "Home X\n").with_switch(0, -500, false);
    live.finish(8000);
    assert_eq!(live.events, [home(0, true, 0), done()]);
    // The switch is looked at each millisecond.
    assert!((-499..=-498).contains(&live.motors()[0]), "{:?}", live.motors());
}

#[test]
fn a_switch_that_is_not_found_is_a_fault_or_an_answer() {
    let mut live = Live::new(&mill(), "Home? X\nIF NOT HOMED(X) THEN SetOut 3, ON\nHome X\n");
    live.finish(8000);
    let out = event(TraceKind::Out, 3, 1);
    let (first, second) = (home(0, false, -1_000), home(0, false, -2_000));
    assert_eq!(live.events, [first, out, second, failed(Fault::HomeNotFound)]);
    assert_eq!(live.longs("STEPS")[0], -2_000);
    assert_eq!(live.longs("UM")[0], -20_000);
}

#[test]
fn a_switch_that_stays_closed_is_a_fault() {
    let mut live = Live::new(&mill(), "Home? X\n");
    live.board.plant_mut().set_input(9, true);
    live.finish(20_000);
    assert_eq!(live.events, [home(0, false, 1_000), failed(Fault::HomeStaysClosed)]);
}

#[test]
fn a_stopped_reference_run_ends_the_run_where_the_axis_stands() {
    let mut live = Live::new(&mill(), "Home X\n");
    live.start();
    live.run_ms(100);
    live.board.plant_mut().press_stop(true);
    live.run_ms(2_500);
    live.board.plant_mut().press_stop(false);
    live.run_ms(100);
    assert_eq!(live.events, [event(TraceKind::End, End::Stopped as u8, 0)]);
    assert_eq!(live.byte("HOMED"), 0);
    assert_eq!(live.longs("STEPS").map(i64::from), live.motors());
    assert_eq!(live.longs("UM")[0], 10 * live.longs("STEPS")[0]);
}

#[test]
fn the_probe_pin_catches_the_very_step() {
    for (speed, at) in [("300st/s", -137), ("3000st/s", -700)] {
        let script = format!("Probe Z, -10mm, {speed}\nMoveAxe Z, 0mm\n");
        let mut live = with_probe(Live::new(&mill(), &script), 2, at, false);
        live.finish(8000);
        let moved = event(TraceKind::Axe, 2, 0);
        let caught = i32::try_from(at).expect("near");
        assert_eq!(live.events, [probe(2, true, caught), moved, done()]);
        assert_eq!(live.longs("PROBED")[2], caught);
        assert_eq!(live.byte("PROBE_OK"), 4);
        assert_eq!(live.motors(), [0; 3]);
    }
}

#[test]
fn a_slow_probe_rests_at_its_plate_however_late_the_main_loop_is() {
    /// `jmp $`, in a word of the pool that this program has no use for.
    const PARKED: u16 = 0x3FFF;
    let mut live = with_probe(Live::new(&mill(), "Probe Z, -10mm, 300st/s\n"), 2, -137, false);
    live.start();
    while live.motors()[2] > -136 {
        live.run_ms(1);
    }
    let (main, park) = (live.at("loop"), live.at("POOL"));
    live.board.set_breakpoint(main);
    assert_eq!(live.board.run_for(TICKS_PER_SECOND / 100), Stop::Breakpoint(main.into()));
    live.board.clear_breakpoint(main);
    live.board.poke16(park, PARKED);
    live.board.set_reg(0, park);
    live.board.run_us(10_000);
    assert_eq!(live.motors()[2], -137);
    live.board.set_reg(0, main);
    live.run_ms(100);
    assert_eq!(live.events, [probe(2, true, -137), done()]);
    assert_eq!(live.motors()[2], -137);
    assert_eq!(live.longs("STEPS")[2], -137);
}

#[test]
fn a_probe_at_a_pin_of_the_direct_wiring_catches_the_very_step() {
    let mut profile = mill();
    profile.wiring = Wiring::Direct;
    profile.outputs.retain(|output| output.n <= 2);
    profile.inputs.clear();
    let script = "Probe X, 8mm, 2000st/s, 4, ON\n";
    let mut live = with_probe(Live::new(&profile, script), 0, 321, true);
    live.finish(8000);
    assert_eq!(live.events, [probe(0, true, 321), done()]);
}

#[test]
fn a_missed_probe_is_a_fault_or_an_answer() {
    let script = "F 600mm/min\nProbe? X, 1mm, 10mm/s\nIF NOT PROBEOK(X) THEN SetOut 3, ON\n\
                  Probe X, 100st, 5mm/s\nProbe X, 2mm, 5mm/s\n";
    let script = script.replace("F 600mm/min\n", "");
    let mut live = Live::new(&mill(), &script);
    live.finish(8000);
    let out = event(TraceKind::Out, 3, 1);
    let missed = [probe(0, false, 100), out, probe(0, false, 100), failed(Fault::ProbeMissed)];
    assert_eq!(live.events, missed);
}

#[test]
fn an_input_that_is_active_already_is_a_fault() {
    let mut live = Live::new(&mill(), "MoveRel X, 7st\nProbe? X, 1mm, 10mm/s, 3, OFF\n");
    live.finish(8000);
    let moved = event(TraceKind::Axe, 0, 0);
    assert_eq!(live.events, [moved, probe(0, false, 7), failed(Fault::InputActive)]);
}

#[test]
fn a_mask_of_inputs_ends_a_probe() {
    let mut live = Live::new(&mill(), "ProbeMask X, 5mm, 400st/s, 12, 8\n");
    live.board.plant_mut().set_input(4, true);
    live.start();
    live.run_ms(100);
    live.board.plant_mut().set_input(4, false);
    live.run_ms(100);
    assert_eq!(live.events[0].argument, TRACE_OK);
    let [x, ..] = live.motors();
    assert!((30..60).contains(&x), "{x}");
    assert_eq!(i64::from(live.longs("PROBED")[0]), i64::from(live.events[0].value));
}

#[test]
fn the_feed_is_a_probes_speed_without_one() {
    let mut live = with_probe(Live::new(&mill(), "G38.2 Z-3 F120\n"), 2, -50, false);
    live.finish(8000);
    assert_eq!(live.events, [probe(2, true, -50), done()]);
}
