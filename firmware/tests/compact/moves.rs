//! Moves of whole programs on the running board: steps at the pins, commanded places, trace.

use lang::fault::Fault;
use lang::profile::Profile;
use lang::wire::{End, TraceKind};

use crate::live::Live;
use crate::rig::{Event, event};

/// The built-in `mill`, which need not be homed first.
fn mill() -> Profile {
    let mut profile = Profile::built_in("mill").expect("mill is built in");
    profile.require_homing = false;
    profile
}

fn run_on(profile: &Profile, script: &str, ms: u64) -> Live {
    let mut live = Live::new(profile, script);
    live.finish(ms);
    live
}

fn run(script: &str, ms: u64) -> Live {
    run_on(&mill(), script, ms)
}

fn axe(n: u8) -> Event {
    event(TraceKind::Axe, n, 0)
}

fn line() -> Event {
    event(TraceKind::Line, 0, 0)
}

fn rapid() -> Event {
    event(TraceKind::Rapid, 0, 0)
}

fn done() -> Event {
    event(TraceKind::End, End::Done as u8, 0)
}

fn failed(fault: Fault) -> Event {
    event(TraceKind::End, End::Fault as u8, fault.number().into())
}

/// The motors stand where the commanded places are, in the board's view too.
fn rests_at_its_places(live: &Live) {
    assert_eq!(live.longs("ACTUAL"), live.longs("STEPS"));
    assert_eq!(live.motors(), live.longs("STEPS").map(i64::from));
}

#[test]
fn axes_move_to_places_and_by_distances() {
    let live = run("MoveAxe X, 3mm\nMoveRel X, -1mm\nMoveRel Y, 100st\nMoveAxe X, 2mm\n", 3000);
    assert_eq!(live.events, [axe(0), axe(0), axe(1), done()]);
    assert_eq!(live.longs("UM")[0], 2000);
    assert_eq!(live.longs("STEPS")[1], 100);
    rests_at_its_places(&live);
}

#[test]
fn speeds_and_ramps_come_from_the_stack() {
    let script = "DIM v\nMoveAxe X, 3mm, 5mm/s, 100mm/s2, 2000st/s2\nv = 0\n\
                  MoveRel X, 100st, 300st/s, 4000st/s2\nMoveRel X, 1mm, v * 1mm/s\n";
    let live = run(script, 4000);
    assert_eq!(live.events, [axe(0), axe(0), failed(Fault::SpeedRange)]);
    rests_at_its_places(&live);
}

#[test]
fn lines_end_where_their_words_say() {
    let script =
        "G0 X1 Y2\nG1 Z-1 F600\nG91 G1 X0.5 Y-0.25\nG90 G53 G1 X2\nG1 X[200st] Y1\nG1 Y1\n";
    let live = run(script, 6000);
    assert_eq!(live.events, [rapid(), line(), line(), line(), line(), done()]);
    assert_eq!(live.longs("UM")[1..], [1000, -1000]);
    assert_eq!(live.longs("STEPS")[0], 200);
    rests_at_its_places(&live);
}

#[test]
fn work_zeros_shift_what_comes_behind_them() {
    let script =
        "MoveAxe X, 2mm\nSetPos X, 500um\nMoveAxe X, 1mm\nSetPos Y, 0mm\nPRINT POS(X); POSST(X)\n";
    let mut live = Live::new(&mill(), script);
    live.finish(3000);
    assert_eq!(live.longs("UM")[0], 2500);
    assert_eq!(live.longs("OFFSET")[0], 1500);
    rests_at_its_places(&live);
}

#[test]
fn z_goes_apart_in_a_rapid_move() {
    let mut profile = mill();
    profile.rapid_z_apart = true;
    let mut live = Live::new(&profile, "G0 X1 Y1 Z2\nG0 X0 Y0 Z0\n");
    live.start();
    // Z's switch is at the top: it lifts first, and lowers last.
    while live.events.last() != Some(&done()) {
        live.run_ms(1);
        let [x, y, z] = live.motors();
        assert!(z == 200 || x == 0 && y == 0, "{x} {y} {z}");
    }
    assert_eq!(live.events, [rapid(), rapid(), done()]);
    rests_at_its_places(&live);
}

#[test]
fn a_target_beyond_the_travel_is_refused_before_any_axis_is_commanded() {
    let mut live = Live::new(&mill(), "G0 X1\nG1 X2 Y-500 F600\n");
    let homed = live.at("HOMED");
    live.board.poke8(homed, 7);
    live.finish(3000);
    assert_eq!(live.events, [rapid(), failed(Fault::SoftLimit)]);
    assert_eq!(live.longs("UM"), [1000, 0, 0]);
    rests_at_its_places(&live);
}

#[test]
fn a_machine_that_demands_homing_moves_only_relatively_before() {
    let mut profile = mill();
    profile.require_homing = true;
    let live = run_on(&profile, "MoveRel X, 1mm\nMoveAxe X, 0mm\n", 3000);
    assert_eq!(live.events, [axe(0), failed(Fault::NotHomed)]);
    rests_at_its_places(&live);
}

#[test]
fn an_axis_that_runs_into_its_switch_stops_the_run() {
    let mut live = Live::new(&mill(), "MoveAxe X, 3mm\nMoveAxe X, -20mm\n");
    live = live.with_switch(0, -100, false);
    let homed = live.at("HOMED");
    live.board.poke8(homed, 0);
    live.finish(4000);
    assert_eq!(live.events, [axe(0), axe(0), failed(Fault::LimitSwitch)]);
    assert_eq!(live.byte("FAULT_IN"), live.board.plant().reference_input(0));
    assert_eq!(live.longs("ACTUAL").map(i64::from), live.motors());
}

#[test]
fn stops_of_resting_axes_are_traced_and_do_nothing_else() {
    let stop = event(TraceKind::Stop, 1, 0);
    let live = run("MoveRel X, 100st\nStopAxe Y\nStopAll\nWaitMove\nMoveRel X, 1st\n", 3000);
    assert_eq!(live.events, [axe(0), stop, axe(0), done()]);
    rests_at_its_places(&live);
}

#[test]
fn a_pause_loses_no_step() {
    let mut live = Live::new(&mill(), "G1 X5 Y3 F1200\nMoveAxe X, 0mm\n");
    live.start();
    live.run_ms(100);
    live.board.plant_mut().press_stop(true);
    live.run_ms(300);
    live.board.plant_mut().press_stop(false);
    live.run_ms(100);
    let paused = live.motors();
    live.run_ms(100);
    assert_eq!(live.motors(), paused);
    live.finish(4000);
    assert_eq!(live.events, [line(), axe(0), done()]);
    rests_at_its_places(&live);
}

#[test]
fn the_machine_stack_keeps_room_in_motion() {
    let script = "DIM a, b\nb = -3\nHome? X\nG0 X3 Y2 Z-1\nG1 X1 Y1 F900\nMoveAxe X, 2mm, 9mm/s, 90mm/s2\n\
                  Probe? X, 1mm, 10mm/s\na = (b * 7 - 20) / 3\nPRINT POS(X)\n";
    let mut profile = mill();
    profile.x.as_mut().expect("mill has X").home.stroke_um = 3_000;
    let mut live = Live::new(&profile, script);
    live.finish(8000);
    assert_eq!(live.events.last(), Some(&done()), "{:?}", live.events);
    let (first, last) = (live.at("POOL_END"), 0x0400);
    let untouched = (first..last).take_while(|&at| live.board.peek8(at) == 0xA5).count();
    assert!(untouched >= 20, "{untouched} bytes were never used");
}
