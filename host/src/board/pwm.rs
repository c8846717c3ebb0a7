//! Checks the PWM's pin of the virtual board: frequency, power in ramps, dark after every kind of stop.

use std::time::Duration;

use emulator::{Edge, Signal};
use lang::back;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::profile::Profile;
use lang::record::BoardRecord;
use lang::wire::{Control, Exception, OVERRIDES, PROFILE_WINDOW};

use crate::bench::stand::Stand;
use crate::board::G2553;
use crate::link::Link;

/// Ticks of the board in a microsecond.
const US: u64 = 10_000;

/// The laser's machine with switches at the chip's pins, an emergency stop at input 4, and this PWM.
fn machine(pwm: &str) -> Profile {
    let text = include_str!("../../../examples/profiles/laser.toml")
        .replace("wiring = \"chain\"", "wiring = \"direct\"");
    let text =
        format!("{text}\n[[input]]\nn = 4\nrole = \"emergency_stop\"\n\n[pwm]\noutput = 1\n{pwm}");
    Profile::parse(&text).expect("a profile")
}

fn stand(profile: &Profile, script: &str) -> Stand {
    let mut stand = Stand::new(profile).expect("a board");
    let source = Source::new("pwm", script.to_owned());
    let (program, diags) = compile(&source, ProfileChoice::Given(Box::new(profile.clone())));
    let program = program.unwrap_or_else(|| panic!("{}", diags.render(&source)));
    let compiled = back::compile(&program).expect("it fits");
    stand.upload(&compiled.image).expect("stored");
    stand.rig().borrow_mut().board().record(true);
    stand.client().control(Control::Start).expect("started");
    stand
}

fn pause(stand: &mut Stand, ms: u64) {
    stand.client().link().pause(Duration::from_millis(ms));
}

fn edges(stand: &mut Stand) -> Vec<Edge> {
    stand.rig().borrow_mut().board().take_edges()
}

/// Runs a script for so long.
fn run(profile: &Profile, script: &str, ms: u64) -> Vec<Edge> {
    let mut stand = stand(profile, script);
    pause(&mut stand, ms);
    edges(&mut stand)
}

/// From when to when the pin is high, ticks.
fn pulses(edges: &[Edge]) -> Vec<(u64, u64)> {
    let own: Vec<&Edge> = edges.iter().filter(|edge| edge.signal == Signal::Pwm).collect();
    own.windows(2).filter(|pair| pair[0].level).map(|pair| (pair[0].cycle, pair[1].cycle)).collect()
}

/// Rising edges of a motor.
fn steps(edges: &[Edge], axis: u8) -> Vec<u64> {
    let own = edges.iter().filter(|edge| edge.signal == Signal::Step(axis) && edge.level);
    own.map(|edge| edge.cycle).collect()
}

/// Part of the time for which the pin is high, from its first edge to its last.
fn duty(pulses: &[(u64, u64)]) -> f64 {
    // The pin is high up to the period's end.
    let (first, last) = (pulses[0].1, pulses[pulses.len() - 1].1);
    let high: u64 = pulses[1..].iter().map(|(up, down)| down - up).sum();
    high as f64 / (last - first) as f64
}

#[test]
fn the_frequency_is_what_the_profile_says_and_the_duty_what_s_says() {
    for hz in [50, 381, 382, 5_000, 20_000] {
        for (s, wanted) in [(1, 0.105), (4_000, 0.46), (9_999, 1.0)] {
            let pwm =
                format!("kind = \"spindle\"\nfrequency_hz = {hz}\nrange = 10000\nminimum = 100\n");
            let edges = run(&machine(&pwm), &format!("S{s}\nM3\nWait 300ms\nM5\n"), 250);
            let pulses = pulses(&edges);
            let periods = pulses.len() as u64 - 1;
            let took = pulses[pulses.len() - 1].1 - pulses[0].1;
            let each = took as f64 / periods as f64;
            let exact = 1e6 * US as f64 / f64::from(hz);
            assert!((each / exact - 1.0).abs() < 2e-3, "{hz} Hz, S{s}: {each} ticks a period");
            let duty = duty(&pulses);
            assert!((duty - wanted).abs() < 6e-3, "{hz} Hz, S{s}: {duty}");
        }
    }
}

#[test]
fn a_spindle_turns_at_rest_and_stops_with_its_output() {
    let edges = run(
        &machine("kind = \"spindle\"\n"),
        "S500\nM3\nG1 X2 F600\nWait 100ms\nS0\nWait 100ms\n",
        700,
    );
    let pulses = pulses(&edges);
    let (first, last) = (pulses[0].0, pulses[pulses.len() - 1].1);
    let on = (last - first) / US;
    let moved = steps(&edges, 0);
    assert!(first < moved[0] && last > moved[moved.len() - 1], "before and behind the move");
    assert!((290_000..340_000).contains(&on), "{on} us");
    assert!((duty(&pulses) - 0.5).abs() < 2e-3);
}

/// Part of the time for which the beam is on between two steps, with the time between.
fn beams(edges: &[Edge]) -> Vec<(f64, f64)> {
    let (moved, pulses) = (steps(edges, 0), pulses(edges));
    let light = |from: u64, to: u64| -> u64 {
        pulses.iter().map(|(up, down)| (*down).min(to).saturating_sub((*up).max(from))).sum()
    };
    // Over eight steps, as a step's time is no whole number of periods.
    let spans = moved.windows(9).step_by(8);
    spans
        .map(|span| (span[8] - span[0], light(span[0], span[8])))
        .map(|(all, on)| (on as f64 / all as f64, all as f64 / 8.0))
        .collect()
}

#[test]
fn power_follows_the_speed_under_m4_and_nothing_under_m3() {
    let laser = machine("kind = \"laser\"\nfrequency_hz = 20000\n");
    // 6 mm at 100 mm/s: 4000 st/s, up and down in 160 ms each.
    let text = |m: &str| format!("{m} S800\nG1 X30 F6000\n");
    let constant = beams(&run(&laser, &text("M3"), 800));
    assert!(constant.len() > 100, "{}", constant.len());
    for (duty, _) in &constant[..constant.len() - 1] {
        assert!((duty - 0.8).abs() < 0.03, "{duty}");
    }
    let follows = beams(&run(&laser, &text("M4"), 800));
    let fastest = US as f64 * 1e6 / 4000.0;
    for (duty, interval) in &follows[1..follows.len() - 1] {
        let wanted = 0.8 * fastest / interval;
        // A segment on a ramp has one power; its speeds differ by up to a tenth.
        assert!((duty - wanted).abs() < 0.03 + 0.1 * wanted, "{duty} for {wanted}");
    }
    let slow = follows.iter().filter(|(duty, _)| *duty < 0.4).count();
    assert!(slow > 4, "{slow} with less than half");
}

#[test]
fn power_under_m4_is_of_the_programmed_speed_and_at_most_full() {
    let laser = machine("kind = \"laser\"\nfrequency_hz = 20000\n");
    for (percent, wanted) in [(50, 0.3), (100, 0.6), (150, 0.9), (200, 1.0)] {
        let mut stand = stand(&laser, "Wait 50ms\nM4 S600\nG1 X30 F1200\n");
        stand.client().write(OVERRIDES, percent).expect("taken");
        pause(&mut stand, 300);
        edges(&mut stand);
        pause(&mut stand, 60);
        let duty = duty(&pulses(&edges(&mut stand)));
        assert!((duty - wanted).abs() < 0.02, "{percent} %: {duty}");
    }
}

#[test]
fn a_laser_is_dark_at_rest_in_rapid_moves_and_for_s0() {
    let laser = machine("kind = \"laser\"\nfrequency_hz = 10000\n");
    let text = "M3 S500\nWait 50ms\nG1 X2 F1200\nWait 50ms\nG0 X6\nS0\nG1 X8\nS500\nM4\nG1 X10\nWait 50ms\nMoveAxe X, 12mm\nM3\nMoveAxe X, 14mm\nM5\nG1 X16\n";
    let edges = run(&laser, text, 2000);
    let (moved, pulses) = (steps(&edges, 0), pulses(&edges));
    assert_eq!(moved.len(), 640, "40 steps for each mm");
    // Up to which step of X each piece of the way goes, and whether it is lit.
    let pieces = [
        (0, 80, true),
        (80, 320, false),
        (320, 400, true),
        (400, 480, false),
        (480, 560, true),
        (560, 640, false),
    ];
    let period = 100 * US;
    for (from, to, lit) in pieces {
        let (first, last) = (moved[from], moved[to - 1]);
        let light: u64 = pulses
            .iter()
            .filter(|(up, _)| (first..=last).contains(up))
            .map(|(up, down)| down - up)
            .sum();
        if lit {
            assert!(light > (last - first) / 10, "steps {from} to {to}: {light}");
        } else {
            // What was begun with the last lit step.
            assert!(light <= period, "steps {from} to {to}: {light}");
        }
        // The time before the first step is a step's, too: 2.5 ms at the start rate.
        let behind = moved.get(to).map_or(u64::MAX, |at| at - 3_000 * US);
        // The interrupt that ends the steps writes what is dark up to 10 us behind the last edge.
        let dark = last + period + 10 * US;
        let rest = pulses.iter().filter(|(_, down)| (dark..behind).contains(down)).count();
        assert_eq!(rest, 0, "at rest behind step {to}");
    }
}

/// Lets a machine work, stops it, and gives its edges from then on with the time of the stop.
fn stopped(profile: &Profile, script: &str, stop: impl FnOnce(&mut Stand)) -> (u64, Vec<Edge>) {
    let mut stand = stand(profile, script);
    pause(&mut stand, 300);
    edges(&mut stand);
    let at = stand.rig().borrow_mut().board().cycles();
    stop(&mut stand);
    pause(&mut stand, 600);
    (at, edges(&mut stand))
}

/// Last instant at which the pin was high, and the last step.
fn last(edges: &[Edge]) -> (u64, u64) {
    let high = pulses(edges).last().map_or(0, |(_, down)| *down);
    let moved = steps(edges, 0).last().copied().unwrap_or(0);
    assert!(edges.iter().rfind(|edge| edge.signal == Signal::Pwm).is_none_or(|edge| !edge.level));
    (high, moved)
}

/// Toward the reference switch of X, input 1.
const LONG: &str = "M3 S300\nG1 X-280 F1200\n";

#[test]
fn a_stop_darkens_the_laser_within_a_period() {
    let period = 20_000 * US;
    // 50 Hz: what is not done by hardware, or at once, shows.
    let laser = machine("kind = \"laser\"\nfrequency_hz = 50\n");
    let contact = |input: u8| {
        move |stand: &mut Stand| {
            let rig = stand.rig();
            let mut rig = rig.borrow_mut();
            rig.board().plant_mut().set_input(input, true);
        }
    };
    let control =
        |control: Control| move |stand: &mut Stand| stand.client().control(control).expect("taken");
    // At once: an emergency stop and a limit switch at the pins, reset.
    for (name, input) in [("emergency stop", 4), ("limit", 1)] {
        let (at, edges) = stopped(&laser, LONG, contact(input));
        let (high, _) = last(&edges);
        assert!(high < at + 10 * US, "{name}: {} us", high.saturating_sub(at) / US);
    }
    let (at, edges) = stopped(&laser, LONG, |stand| stand.rig().borrow_mut().board().reset_pin());
    assert!(last(&edges).0 <= at + US, "reset");
    let (at, edges) = stopped(&laser, LONG, control(Control::EmergencyStop));
    // The request takes a millisecond on the line.
    assert!(last(&edges).0 < at + 4_000 * US, "emergency stop by register");
    // On a ramp: within a period behind the last step.
    for order in [Control::Stop, Control::Pause] {
        let (_, edges) = stopped(&laser, LONG, control(order));
        let (high, moved) = last(&edges);
        assert!(moved != 0 && high < moved + period, "{order:?}");
    }
    // The end of the program, and a fault of the next statement.
    for behind in ["", "DIM n\nn = 1 / n\n"] {
        let (_, edges) = stopped(&laser, &format!("M3 S300\nG1 X10 F1200\n{behind}"), |_| {});
        let (high, moved) = last(&edges);
        assert!(moved != 0 && high < moved + period, "{behind}");
    }
}

#[test]
fn a_stop_switches_the_spindle_off_where_its_profile_says_so() {
    let spindle = machine("kind = \"spindle\"\nfrequency_hz = 50\n");
    for input in [4, 1] {
        let (at, edges) = stopped(&spindle, LONG, |stand| {
            stand.rig().borrow_mut().board().plant_mut().set_input(input, true);
        });
        assert!(last(&edges).0 < at + 10 * US, "input {input}");
    }
    let (_, edges) =
        stopped(&spindle, LONG, |stand| stand.client().control(Control::Stop).expect("taken"));
    let (high, moved) = last(&edges);
    // The main loop ends the run: some ms behind the last step, within the period that has begun.
    assert!(high + 20_000 * US > moved && high < moved + 5_000 * US);
}

#[test]
fn a_contact_lets_go_of_the_pin_without_software() {
    let spindle = machine("kind = \"spindle\"\nfrequency_hz = 20000\n");
    let (at, edges) = stopped(&spindle, "M3\nS700\nWait 5s\n", |stand| {
        let rig = stand.rig();
        let mut rig = rig.borrow_mut();
        // P3.7 pulled up by the chip itself stands for an open contact there.
        let out = rig.board().bus_read8(0x0222);
        rig.board().bus_write8(0x0222, out | 0x80);
    });
    assert!(last(&edges).0 <= at, "high after it");
}

#[test]
fn a_servo_has_pulses_all_the_time() {
    let servo = machine("kind = \"servo\"\nlow_us = 900\nhigh_us = 2100\n");
    let edges =
        run(&servo, "Wait 200ms\nM3 S1000\nWait 200ms\nS500\nWait 200ms\nM5\nWait 200ms\n", 780);
    let pulses = pulses(&edges);
    let widths: Vec<u64> = pulses.iter().map(|(up, down)| (down - up + US / 2) / US).collect();
    let mut kinds = widths.clone();
    kinds.dedup();
    assert_eq!(kinds, [900, 2100, 1500, 900], "{widths:?}");
    assert!(
        pulses.windows(2).all(|pair| (pair[1].1 - pair[0].1).abs_diff(20_000 * US) < US),
        "{pulses:?}"
    );
}

#[test]
fn a_profile_without_a_pwm_leaves_the_pin_alone() {
    let laser = Profile::built_in("laser").expect("built in");
    assert!(pulses(&run(&laser, "M3 S500\nG1 X5 F1200\n", 500)).is_empty());
}

#[test]
fn the_board_keeps_it_and_one_without_a_pwm_refuses_it() {
    let servo = machine("kind = \"servo\"\nlow_us = 900\n");
    let mut stand = Stand::new(&servo).expect("a board");
    let held = stand.client().board_record().expect("read");
    assert_eq!(held, BoardRecord::of(&servo, held.sequence));
    assert_eq!(
        held.into_profile(&machine("kind = \"laser\"\n")).pwm.map(|pwm| pwm.low_us),
        Some(900)
    );
    // A record whose other half never came is refused, and the old one holds.
    let other = BoardRecord::of(&machine("kind = \"laser\"\n"), held.sequence + 1);
    let words: Vec<u16> =
        other.to_bytes().chunks(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect();
    let client = stand.client();
    client.write_all(PROFILE_WINDOW, &words[..16]).expect("taken");
    let refused = client.write_all(PROFILE_WINDOW + 16, &words[16..]).expect_err("half of it");
    assert!(refused.is_exception(Exception::DeviceFailure), "{refused}");
    client.restart().expect("reset");
    client.find().expect("there");
    assert_eq!(client.board_record().expect("read"), held);
    let error = Stand::on(&G2553, &servo).map(|_| ()).expect_err("no such pin");
    assert!(error.contains("this board has no PWM"), "{error}");
}
