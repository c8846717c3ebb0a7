//! Lines of a course run through their corners, at the pins of the running image.

mod joined;
mod outside;
mod rig;

use std::f64::consts::TAU;

use lang::fault::Fault;
use lang::image::course::{Entry, record};
use lang::part::G2553;
use lang::wire::{self, Control, End, RunState};

use self::rig::{Line, Made, Mill, Mover, bound, each, image, in_order, judge, mill, script};
use crate::rig::T_FULL;

/// Where a line ends, mm.
type Place = [f64; 3];
/// Vector of Timer1_A CCR0.
const STEP: u16 = 0xFFFA;
/// [`wire::MISSED_DEADLINES`] as a request has it.
const MISSED: [u8; 2] = wire::MISSED_DEADLINES.to_be_bytes();
/// F3000.
const FEED: f64 = 50_000.0;

fn chords(n: u32, by: Place) -> Vec<Place> {
    (1..=n).map(|k| by.map(|by| by * f64::from(k))).collect()
}

/// Once round from 0, in XY and, twice as often, in Z.
fn circle(n: u32, r: f64, z: f64) -> Vec<Place> {
    let at = |k: u32| TAU * f64::from(k) / f64::from(n);
    let place = |a: f64| [r * a.sin(), r - r * a.cos(), z * (2.0 * a).sin()];
    (1..=n).map(|k| place(at(k))).collect()
}

/// A board that has a path with a slow point for each line.
fn board(mill: &Mill, places: &[Place]) -> (Mover, Vec<Line>) {
    let lines = mill.lines(places, FEED);
    let image = image(mill, &script(places, FEED), each(&lines));
    (Mover::new(mill, &image), lines)
}

/// The same of relative lines, so many times in a loop.
fn in_a_loop(mill: &Mill, times: u32) -> (Mover, Vec<Line>) {
    let lines = mill.lines(&chords(times, [0.3, 0.1, 0.0]), FEED);
    let text = format!("DIM n\nF3000\nG91\nFOR n = 1 TO {times}\nG1 X0.3 Y0.1\nNEXT\n");
    (Mover::new(mill, &image(mill, &text, each(&lines))), lines)
}

/// The run ended so, and nothing was lost; no pulse was short, and DIR never changed while STEP was high or had just fallen.
fn ended(mover: &Mover, end: End, fault: Option<Fault>) {
    assert_eq!(mover.board.plant().violations(), []);
    assert_eq!(mover.byte("LAST_END"), end as u8, "fault {}", mover.byte("VM_FAULT"));
    assert_eq!(mover.byte("VM_FAULT"), fault.map_or(0, Fault::number));
    let motors = mover.motors();
    assert_eq!((mover.longs("ACTUAL"), mover.longs("STEPS")), (motors, motors));
    assert_eq!((mover.byte("MOVING"), mover.byte("MOTION")), (0, 0));
}

/// The whole path was made, within its ramps.
fn whole(mill: &Mill, mover: &Mover, lines: &[Line]) -> Made {
    ended(mover, End::Done, None);
    in_order(&mover.steps, lines, true);
    assert_eq!(mover.motors(), lines[lines.len() - 1].to);
    ramped(mill, mover, lines)
}

fn ramped(mill: &Mill, mover: &Mover, lines: &[Line]) -> Made {
    let made = judge(mill, &mover.steps, lines);
    assert!(made.up <= 1.05 && made.down <= 1.05 && made.top <= FEED * 1.02, "{made:?}");
    made
}

/// Pauses and goes on, twice: it rests where it says, for so long.
fn paused_twice(mover: &mut Mover, us: u64) {
    for control in [Control::Pause, Control::Resume, Control::Pause, Control::Resume] {
        mover.control(control);
        mover.run_us(us);
        if control == Control::Pause && mover.state() != RunState::Ready {
            assert_eq!(mover.state(), RunState::Paused);
            let rests = mover.motors();
            assert_eq!(rests, mover.longs("ACTUAL"));
            mover.run_us(100_000);
            assert_eq!(mover.motors(), rests);
        }
    }
}

/// An emergency stop by the link: no step comes any more, and no axis is homed.
fn stopped_at_once(mover: &mut Mover, lines: &[Line]) {
    mover.control(Control::EmergencyStop);
    let stands = mover.motors();
    mover.run_us(50_000);
    assert_eq!(mover.motors(), stands);
    ended(mover, End::Fault, Some(Fault::EmergencyStop));
    assert_eq!(mover.byte("HOMED"), 0);
    in_order(&mover.steps, lines, false);
}

/// To the end of a path of F3000 under one override after the other, percent.
fn overridden(mill: &Mill, mover: &mut Mover, lines: &[Line], percents: &[u8]) {
    let [high, low] = wire::OVERRIDES.to_be_bytes();
    for &percent in percents {
        assert_eq!(mover.answer(&[1, 6, high, low, 0, percent]).len(), 6);
        mover.run_us(120_000);
    }
    mover.end(20);
    ended(mover, End::Done, None);
    in_order(&mover.steps, lines, true);
    let made = judge(mill, &mover.steps, lines);
    assert!(made.up <= 1.05 && made.down <= 1.05 && made.top < 2.0 * FEED, "{made:?}");
}

fn run(places: &[Place]) -> Made {
    let mill = mill();
    let (mut mover, lines) = board(&mill, places);
    mover.start();
    mover.end(20);
    whole(&mill, &mover, &lines)
}

#[test]
fn chords_of_a_line_are_one_line() {
    let made = run(&chords(100, [0.4, 0.0, 0.0]));
    assert!(made.top > 49_000.0 && made.time < 1.0, "{made:?}");
}

/// The pace of the host's slow points, while a host asks without a pause.
#[test]
fn lines_as_short_as_the_host_makes_them_come_in_time() {
    let ways = [[0.16, 0.0, 0.0], [0.0, 0.12, 0.14], [0.12, 0.1, 0.1]];
    for (by, least_us) in ways.into_iter().zip(G2553.course_us) {
        for phase in 0..3 {
            let mut mill = mill();
            // Its first segment takes 0.7 ms, and each step's interrupts 12 us from the planner.
            let events = by.iter().fold(0.0, |most, by| f64::max(most, by * 100.0));
            mill.least = (f64::from(least_us) + 700.0 + 12.0 * events) / 1e6;
            let places = chords(250, by);
            let (mut mover, lines) = board(&mill, &places);
            mover.start();
            mover.run_us(20_000 + phase * 1_000);
            mover.storm = Some(mover.board.cycles());
            mover.end(20);
            let made = whole(&mill, &mover, &lines);
            assert!(mover.replies > 100 && made.time < 1.2 * 250.0 * mill.least, "{made:?}");
        }
    }
}

#[test]
fn a_circle_turns_both_axes_at_speed() {
    let made = run(&circle(150, 10.0, 0.0));
    assert!(made.time < 1.6, "{made:?}");
}

#[test]
fn chords_in_space_go_on_in_all_axes() {
    let made = run(&circle(90, 10.0, 4.0));
    assert!(made.time < 2.4, "{made:?}");
}

#[test]
fn corners_are_passed_as_slowly_as_their_slow_points_want() {
    // Four sides of short lines, each with a corner of a right angle behind it.
    let side = |from: Place, by: Place| {
        (1..=6).map(move |k| [0, 1, 2].map(|a| from[a] + by[a] * f64::from(k)))
    };
    let places: Vec<Place> = side([0.0; 3], [1.5, 0.0, 0.0])
        .chain(side([9.0, 0.0, 0.0], [0.0, 1.5, 0.0]))
        .chain(side([9.0, 9.0, 0.0], [-1.5, 0.0, 0.0]))
        .chain(side([0.0, 9.0, 0.0], [0.0, -1.5, 0.0]))
        .collect();
    let made = run(&places);
    assert!(made.time < 1.7, "{made:?}");
}

#[test]
fn entries_fall_or_hold_and_rest_in_between() {
    let mill = mill();
    let places = chords(60, [0.5, 0.25, 0.0]);
    let mut lines = mill.lines(&places, FEED);
    let length = lines[0].length;
    let fall = 2.0 * mill.ramp(&lines[0], |axis| axis.decel) * length * 31.0 / 32.0;
    // 20 lines hold, 9 fall to rest, 10 hold, 20 fall to the end.
    let speed = 22_000.0_f64.min((9.0 * fall).sqrt());
    let hold = |lines| Entry { lines, holds: true, bound: bound(speed), joins: 0 };
    let falls = |lines| Entry { lines, holds: false, bound: bound(speed), joins: 0 };
    let rest = Entry { lines: 1, holds: false, bound: 0, joins: 0 };
    let entries = record(&[hold(20), falls(9), rest, hold(9), falls(21)]);
    let mut mover = Mover::new(&mill, &image(&mill, &script(&places, FEED), entries));
    mover.start();
    mover.end(20);
    for line in &mut lines {
        line.exit = speed;
    }
    let made = whole(&mill, &mover, &lines);
    assert!(made.top > speed, "inside of a line it may be faster: {made:?}");
    let times: Vec<f64> = rig::passes(&mover.steps, &lines);
    let longest = times.windows(2).map(|two| two[1] - two[0]).fold(0.0, f64::max);
    assert!(longest < 0.2, "{longest}");
}

#[test]
fn a_loop_names_its_slow_points_in_each_pass() {
    let mill = mill();
    let (mut mover, lines) = in_a_loop(&mill, 120);
    mover.start();
    mover.end(20);
    let made = whole(&mill, &mover, &lines);
    assert!(made.time < 1.3, "{made:?}");
}

#[test]
fn a_pause_anywhere_brakes_along_the_path_and_loses_nothing() {
    let mill = mill();
    for at in [20, 97, 200, 333, 480, 700, 910, 1200] {
        let (mut mover, lines) = board(&mill, &circle(150, 10.0, 0.0));
        mover.start();
        mover.run_us(at * 1000);
        paused_twice(&mut mover, 400_000);
        mover.end(20);
        whole(&mill, &mover, &lines);
    }
}

#[test]
fn a_stop_anywhere_ends_the_run_where_it_brakes() {
    let mill = mill();
    for at in [20, 60, 150, 290, 505, 777, 1100] {
        let (mut mover, lines) = board(&mill, &circle(150, 10.0, 0.0));
        mover.start();
        mover.run_us(at * 1000);
        mover.control(Control::Stop);
        mover.end(5);
        mover.run_us(100_000);
        ended(&mover, End::Stopped, None);
        in_order(&mover.steps, &lines, false);
        ramped(&mill, &mover, &lines);
        assert_ne!(mover.motors(), lines[lines.len() - 1].to, "{at}");
        // The next run begins where it stands.
        mover.control(Control::Start);
        mover.end(20);
        ended(&mover, End::Done, None);
        assert_eq!(mover.motors(), lines[lines.len() - 1].to);
    }
}

#[test]
fn the_button_pauses_and_held_ends_the_run() {
    let mill = mill();
    let (mut mover, lines) = board(&mill, &circle(150, 10.0, 0.0));
    mover.start();
    mover.run_us(500_000);
    mover.board.plant_mut().press_stop(true);
    mover.run_us(1_000_000);
    assert_eq!(mover.state(), RunState::Paused);
    mover.run_us(1_500_000);
    mover.board.plant_mut().press_stop(false);
    ended(&mover, End::Stopped, None);
    in_order(&mover.steps, &lines, false);
}

#[test]
fn an_emergency_stop_ends_the_steps_at_once() {
    let mill = mill();
    for at in [30, 250, 611, 900] {
        let (mut mover, lines) = board(&mill, &chords(120, [0.3, 0.2, 0.0]));
        mover.home();
        mover.start();
        mover.run_us(at * 1000);
        stopped_at_once(&mut mover, &lines);
        mover.control(Control::Acknowledge);
        mover.control(Control::Start);
        mover.end(20);
        ended(&mover, End::Done, None);
        assert_eq!(mover.motors(), lines[lines.len() - 1].to);
    }
}

#[test]
fn a_limit_switch_ends_the_steps_at_once() {
    let mill = mill();
    let (mut mover, lines) = board(&mill, &chords(80, [-0.4, 0.1, 0.0]));
    mover.switch(0, -900, false);
    mover.start();
    mover.end(20);
    mover.run_us(10_000);
    ended(&mover, End::Fault, Some(Fault::LimitSwitch));
    assert_eq!(mover.byte("FAULT_IN"), mover.board.plant().reference_input(0));
    assert!((-950..=-900).contains(&mover.motors()[0]), "{:?}", mover.motors());
    in_order(&mover.steps, &lines, false);
}

#[test]
fn another_override_is_taken_within_a_course() {
    let mill = mill();
    let (mut mover, lines) = board(&mill, &circle(150, 10.0, 0.0));
    mover.start();
    overridden(&mill, &mut mover, &lines, &[100, 60, 200, 25, 140, 10, 100]);
}

#[test]
fn a_host_that_never_rests_makes_no_line_late() {
    let mut mill = mill();
    mill.finer(4);
    for places in [chords(120, [0.2, 0.11, 0.07]), circle(120, 10.0, 0.0)] {
        let (mut mover, lines) = board(&mill, &places);
        mover.storm = Some(mover.board.cycles());
        mover.start();
        mover.end(20);
        whole(&mill, &mover, &lines);
        let worst = mover.board.stats().interrupts[&STEP].worst;
        assert!(worst <= 310, "{worst} cycles in the step interrupt");
        let stack = mover.at("POOL_END")..0x0400;
        let untouched = stack.take_while(|&at| mover.board.peek8(at) == 0xA5).count();
        assert!(untouched >= 20, "{untouched} bytes of the machine stack were never used");
        assert!(mover.replies > 200, "{} bytes", mover.replies);
    }
}

#[test]
fn each_line_rests_where_a_host_traces() {
    let mill = mill();
    let (mut mover, lines) = board(&mill, &chords(30, [0.4, 0.0, 0.0]));
    mover.trace();
    mover.start();
    let events = mover.traced(20);
    whole(&mill, &mover, &lines);
    assert_eq!(events.len(), lines.len() + 1, "each line, and the end");
    let speeds = rig::passes(&mover.steps, &lines);
    assert!(speeds.windows(2).all(|two| two[1] - two[0] > 0.03), "none is passed at speed");
}

#[test]
fn trace_mode_in_the_middle_begins_behind_the_course() {
    let mill = mill();
    let (mut mover, lines) = board(&mill, &chords(100, [0.4, 0.0, 0.0]));
    mover.start();
    mover.run_us(300_000);
    mover.trace();
    let events = mover.traced(20);
    let made = whole(&mill, &mover, &lines);
    assert!(made.time < 1.0, "{made:?}");
    assert_eq!(events, [wire::TraceKind::End as u8]);
}

#[test]
fn a_loop_that_was_traced_goes_on_as_it_began() {
    let mill = mill();
    let (mut mover, lines) = in_a_loop(&mill, 60);
    mover.trace();
    let tracing = mover.at("TRACING");
    mover.start();
    for _ in 0..300 {
        let flags = mover.board.peek8(tracing);
        mover.board.poke8(tracing, flags & !*T_FULL);
        mover.run_us(1_000);
    }
    assert!(mover.motors()[0] > 100, "{:?}", mover.motors());
    mover.board.poke8(tracing, 0);
    mover.end(20);
    whole(&mill, &mover, &lines);
    let speeds = rig::passes(&mover.steps, &lines);
    assert!(speeds.windows(2).all(|two| two[1] - two[0] > 0.02), "none is passed at speed");
}

#[test]
fn lines_without_a_step_are_none_of_a_course() {
    let mill = mill();
    let places = circle(75, 10.0, 0.0);
    // Places of steps, and others less than half a step away.
    let two = |place: Place| {
        let step = place.map(|mm| (mm * 100.0).round() / 100.0);
        [step, step.map(|mm| mm + 0.001)]
    };
    let places: Vec<Place> = places.into_iter().flat_map(two).collect();
    for at in [0, 170, 405, 683, 920] {
        let (mut mover, lines) = board(&mill, &places);
        mover.start();
        if at > 0 {
            mover.run_us(at * 1000);
            mover.control(Control::Pause);
            mover.run_us(400_000);
            assert_eq!(mover.state(), RunState::Paused, "{at}");
            mover.control(Control::Resume);
        }
        mover.end(20);
        let made = whole(&mill, &mover, &lines);
        assert!(made.time < 2.8, "{made:?}");
    }
}

#[test]
fn some_lines_without_a_step_in_a_row_leave_nothing_behind() {
    let mill = mill();
    let many = |y: f64| {
        (0..6).map(move |k| [0.0, y + if k == 0 { 0.0 } else { 0.001 * f64::from(k % 4) }, 0.0])
    };
    let places: Vec<Place> = (1..=8).flat_map(|n| many(4.0 * f64::from(n))).collect();
    let (mut mover, lines) = board(&mill, &places);
    assert_eq!(lines.len(), 8);
    mover.start();
    mover.end(20);
    whole(&mill, &mover, &lines);
}

#[test]
fn a_line_that_comes_too_late_is_a_fault_and_never_silent() {
    let mut mill = mill();
    mill.least = 0.0;
    let (mut mover, lines) = board(&mill, &chords(100, [0.05, 0.03, -0.02]));
    mover.home();
    mover.start();
    mover.end(20);
    mover.run_us(10_000);
    ended(&mover, End::Fault, Some(Fault::EmergencyStop));
    assert_eq!((mover.byte("HOMED"), mover.byte("FAULT_IN")), (0, 0));
    in_order(&mover.steps, &lines, false);
    // A host tells it from an emergency stop by the run that it was in.
    assert_eq!(mover.answer(&[1, 3, MISSED[0], MISSED[1], 0, 1])[3], 1);
}

#[test]
fn an_emergency_stop_is_no_line_that_came_too_late() {
    let mill = mill();
    let (mut mover, lines) = board(&mill, &circle(150, 10.0, 2.0));
    mover.home();
    mover.start();
    mover.run_us(60_000);
    stopped_at_once(&mut mover, &lines);
    assert_eq!(mover.answer(&[1, 3, MISSED[0], MISSED[1], 0, 1])[3], 0);
}

#[test]
fn a_line_without_a_target_ends_the_run_out_of_any_speed() {
    let mill = mill();
    let (mut mover, lines) = board(&mill, &circle(150, 10.0, 0.0));
    mover.home();
    mover.start();
    mover.end(20);
    mover.run_us(10_000);
    ended(&mover, End::Fault, Some(Fault::EmergencyStop));
    assert_eq!(mover.byte("HOMED"), 0);
    in_order(&mover.steps, &lines, false);
    assert!(mover.motors()[0] > -100, "{:?}", mover.motors());
}

#[test]
fn cells_of_a_program_with_slow_points_are_its_own() {
    let mill = mill();
    let (mut mover, lines) = in_a_loop(&mill, 120);
    mover.start();
    mover.run_us(200_000);
    let [high, low] = wire::CELLS.to_be_bytes();
    assert_eq!(mover.answer(&[1, 6, high, low, 0, 1]), [1, 0x86, 6]);
    assert_eq!(mover.answer(&[1, 3, high, low, 0, 2]).len(), 7);
    mover.end(20);
    whole(&mill, &mover, &lines);
}
