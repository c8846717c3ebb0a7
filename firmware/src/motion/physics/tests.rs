//! Seeded faults: each rule of the checker finds its own.

use super::{Limits, Machine, Step, What, check};

const MILL: Limits = Limits { start: 400.0, top: 8_000.0, accel: 25_000.0, decel: 25_000.0 };
const MACHINE: Machine = Machine { axes: [MILL; 3], um: [10.0; 3], corner_um: 20.0 };

/// A line of so many steps with a slope of Y, on ramps of some steepness up to a rate.
fn line(events: u32, slope: f64, accel: f64, top: f64) -> Vec<Step> {
    let mut now = 1_000.0;
    let mut y = 0.5;
    let event = |n: u32| {
        let left = f64::from(n.min(events - n));
        let rate = (MILL.start.powi(2) + 2.0 * accel * left).sqrt().min(top);
        now += 16e6 / rate;
        y += slope;
        let up = y >= 1.0;
        y -= f64::from(u8::from(up));
        Step { at: now as u64, by: [1, i8::from(up), 0] }
    };
    (0..events).map(event).collect()
}

fn found(steps: &[Step]) -> Option<What> {
    MACHINE.check(steps, false).err().map(|violation| violation.what)
}

#[test]
fn a_line_on_its_ramps_is_a_move() {
    for slope in [0.0, 0.03, 0.4, 1.0] {
        let steps = line(3_000, slope, 24_900.0, 7_900.0);
        let count = MACHINE.check(&steps, false).expect("no violation");
        let made = steps.iter().flat_map(|step| step.by).filter(|by| *by != 0).count();
        assert_eq!((count.moves, count.steps), (1, made), "slope {slope}");
    }
}

/// An instant is a whole tick, so that a first interval, rounded down, is up to one tick short: what the profile allows to the last
/// bit is no violation, whenever in a tick it begins. Told in whole steps/s it was 5780 "against 5779 at most".
#[test]
fn a_rest_at_5780_steps_a_second_is_allowed_where_5779_and_a_fraction_is_the_most() {
    let bound: f64 = 5_779.4;
    let ramp = ((bound / 1.05).powi(2) - 5_500.0 * 5_500.0) / 3.2;
    let limits = Limits { start: 5_500.0, top: 8_000.0, accel: ramp, decel: ramp };
    assert!((limits.jump(ramp) - bound).abs() < 1e-6);
    let steps = |rate: f64, phase: f64| -> Vec<u64> {
        (0..3_u32).map(|n| (1_000.0 + phase + f64::from(n) * 16e6 / rate) as u64).collect()
    };
    let mut told = 0;
    for phase in 0..100 {
        let times = steps(bound, f64::from(phase) / 100.0);
        assert_eq!(check(&times, &limits), Ok(()), "phase {phase}");
        told += u32::from(16e6 / (times[1] - times[0]) as f64 > 5_779.5);
        // Two ticks less are too few.
        let fast = steps(16e6 / (16e6 / bound - 2.0), f64::from(phase) / 100.0);
        assert_eq!(
            check(&fast, &limits).map_err(|found| found.what),
            Err(What::Start),
            "phase {phase}"
        );
    }
    assert!(told > 0, "no instant was rounded to a rate above the bound");
}

#[test]
fn ramps_that_are_too_quick_are_found_on_any_slope() {
    for slope in [0.0, 0.03, 0.4, 1.0] {
        assert_eq!(found(&line(3_000, slope, 31_000.0, 7_900.0)), Some(What::Accel), "{slope}");
        // The same ramp, at the other end.
        let mut steps = line(3_000, slope, 24_900.0, 7_900.0);
        let quick = line(3_000, slope, 31_000.0, 7_900.0);
        let later = steps[1_500].at - quick[1_500].at;
        for (step, quick) in steps[1_500..].iter_mut().zip(&quick[1_500..]) {
            step.at = quick.at + later;
        }
        assert_eq!(found(&steps), Some(What::Decel), "{slope}");
    }
}

#[test]
fn a_rate_above_the_top_and_a_start_above_the_start_rate_are_found() {
    assert_eq!(found(&line(3_000, 0.0, 24_900.0, 8_300.0)), Some(What::Top));
    assert_eq!(found(&line(3_000, 0.4, 24_900.0, 8_300.0)), Some(What::Top));
    for slope in [0.0, 0.4] {
        let steps = line(3_000, slope, 24_900.0, 7_900.0);
        assert_eq!(found(&steps[200..]), Some(What::Start), "{slope}");
        assert_eq!(found(&steps[..2_800]), Some(What::Start), "{slope}");
        assert!(MACHINE.check(&steps[..2_800], true).is_ok(), "it was stopped at once");
        // A step that is missing in the middle of it.
        let mut hole = steps.clone();
        for step in &mut hole[1_500..] {
            step.at += 16_000;
        }
        assert!(found(&hole).is_some(), "a hole of 1 ms on slope {slope}");
    }
}

#[test]
fn an_axis_that_turns_round_at_full_speed_is_found() {
    for slope in [0.0, 0.4] {
        let mut steps = line(3_000, slope, 24_900.0, 7_900.0);
        for step in &mut steps[1_500..] {
            step.by[0] = -1;
        }
        assert_eq!(found(&steps), Some(What::Start), "{slope}");
    }
}

/// A circle, 8 mm across, at a speed of which it asks so many steps/s2 of its axes.
fn circle(bend: f64) -> Vec<Step> {
    let radius = 400.0_f64;
    let speed = (bend * radius).sqrt();
    let mut steps = Vec::new();
    let mut place = [0_i32; 3];
    for n in 0..400_000_u64 {
        let at = 1_000 + 200 * n;
        // From rest along its first quarter, slowly enough.
        let time = at as f64 / 16e6;
        let way = if time < 1.0 { 0.5 * speed * time * time } else { speed * (time - 0.5) };
        let (sin, cos) = (way / radius).sin_cos();
        let want = [radius * sin, radius * (1.0 - cos), 0.0];
        let by: [i8; 3] = std::array::from_fn(|n| (want[n].round() as i32 - place[n]) as i8);
        for (place, by) in place.iter_mut().zip(by) {
            *place += i32::from(by);
        }
        if by != [0; 3] {
            steps.push(Step { at, by });
        }
    }
    steps
}

#[test]
fn a_curve_that_asks_more_than_the_ramps_is_found() {
    let bends = |bend: f64| {
        let steps = circle(bend);
        (0..2).map(|axis| MACHINE.bends(&steps, axis, &MILL)).find(Result::is_err)
    };
    assert_eq!(bends(24_000.0), None);
    for bend in [45_000.0, 100_000.0] {
        let found = bends(bend).and_then(Result::err).map(|violation| violation.what);
        assert_eq!(found, Some(What::Bend), "{bend}");
    }
}

#[test]
fn a_rate_is_judged_as_well_as_whole_ticks_show_it() {
    let most = MILL.jump(MILL.accel);
    let steps = |ticks: f64| {
        let times: Vec<u64> = vec![0, ticks as u64, 400_000, 440_000];
        check(&times, &MILL)
    };
    assert_eq!(steps(16e6 / most), Ok(()));
    assert!(steps(16e6 / most - 1.1).is_err());
}

#[test]
fn up_to_its_start_rate_an_axis_needs_no_ramp_and_above_it_does() {
    // A start rate of 890 beside a ramp of 463. On a curve of short lines Y keeps its rate, or nearly, and the path's
    // speed falls with the part of Z.
    let slow = Limits { start: 890.0, top: 2_672.0, accel: 463.0, decel: 463.0 };
    let machine = Machine { axes: [slow; 3], um: [1.0; 3], corner_um: 100.0 };
    let judged = |rates: [f64; 2], z: [u32; 2]| {
        let (mut at, mut steps) = (0.0, Vec::new());
        for n in 0..2_400_u32 {
            // Up to the first rate on the ramp, then both in turns.
            let second = n > 2_000 && n % 80 < 40;
            let ramp = (880_f64.powi(2) + 2.0 * 463.0 * f64::from(n)).sqrt();
            at += 16e6 / ramp.min(rates[usize::from(second)]);
            let every = z[usize::from(second)];
            steps.push(Step { at: at as u64, by: [0, 1, i8::from(n % every == 0)] });
        }
        machine.check(&steps, true).map(|count| count.moves).map_err(|found| found.what)
    };
    assert_eq!(judged([890.0, 890.0], [1, 2]), Ok(1));
    assert_eq!(judged([890.0, 860.0], [1, 2]), Ok(1));
    // The same faster than the start rate: the path brakes, or speeds up, by more than a corner explains.
    for rates in [[1_400.0, 1_400.0], [1_300.0, 1_100.0]] {
        let found = judged(rates, [1, 2]);
        assert!(matches!(found, Err(What::Accel | What::Decel)), "{found:?}");
    }
    // A straight line that changes its speed at once.
    let found = judged([1_300.0, 1_000.0], [2, 2]);
    assert!(matches!(found, Err(What::Accel | What::Decel)), "{found:?}");
    assert_eq!(judged([1_300.0, 1_300.0], [2, 2]), Ok(1));
}

#[test]
fn an_axis_that_stops_at_a_corner_may_do_so_as_the_corner_allows() {
    let fine = Limits { start: 400.0, top: 8_000.0, accel: 25_000.0, decel: 25_000.0 };
    // X makes 50 steps, then Z does, whose end has one rate throughout.
    let judged = |rate: f64, corner_um: f64, with_x: bool| {
        let machine = Machine { axes: [fine; 3], um: [4.0; 3], corner_um };
        let (mut at, mut steps) = (0.0, Vec::new());
        for _ in 0..if with_x { 50 } else { 0 } {
            at += 16e6 / 400.0;
            steps.push(Step { at: at as u64, by: [1, 0, 0] });
        }
        for n in 0..50_u32 {
            let ramp = (400_f64.powi(2) + 2.0 * 25_000.0 * f64::from(n)).sqrt();
            at += 16e6 / ramp.min(rate);
            steps.push(Step { at: at as u64, by: [0, 0, 1] });
        }
        machine.check(&steps, false).map(|count| count.moves).map_err(|found| found.what)
    };
    // 574 steps/s, where its start rate and its ramp are good for 514 and 20 um of corner for 1380.
    assert_eq!(judged(574.0, 20.0, true), Ok(1));
    assert_eq!(judged(574.0, 0.0, true), Err(What::Start));
    assert_eq!(judged(1_500.0, 20.0, true), Err(What::Start));
    // Alone it comes to rest.
    assert_eq!(judged(574.0, 20.0, false), Err(What::Start));
}
