//! Speed override while something moves: the path stays, speeds follow within the ramps.

use emulator::TICKS_PER_SECOND;
use firmware::motion::physics;
use lang::profile::Profile;
use lang::wire::OVERRIDES;
use pasapas::board::{Build, F5529, G2553};

use crate::lab::{Lab, Run, Step};

/// Of feeds and axes on their own; of rapid moves.
const FEED: u16 = OVERRIDES;
const RAPID: u16 = OVERRIDES + 1;
/// Top rate of the mill, steps/s.
const TOP: f64 = 8_000.0;

/// Orders in the order of their times, ms: register and percent.
type Orders<'a> = &'a [(u64, u16, u16)];

fn run(board: &'static Build, script: &str, orders: Orders<'_>) -> Run {
    let mill = Profile::built_in("mill").expect("the mill");
    Lab::new(board, &mill, script).play(|lab| {
        let mut now = 0;
        for (at, register, percent) in orders {
            lab.run_ms(at - now);
            now = *at;
            assert!(lab.write(*register, *percent), "{percent} % in {register}");
        }
    })
}

/// Highest rate of the event stream over 50 events in a part of the run, events/s.
fn fastest(steps: &[Step]) -> f64 {
    let rate = |w: &[Step]| 50.0 * TICKS_PER_SECOND as f64 / (w[50].at - w[0].at) as f64;
    steps.windows(51).map(rate).fold(0.0, f64::max)
}

fn directions(run: &Run) -> Vec<[i8; 3]> {
    run.steps.iter().map(|step| step.by).collect()
}

/// Each axis's steps keep to the mill's ramps and top.
fn holds_ramps(run: &Run, axis: usize) {
    let own = run.steps.iter().filter(|step| step.by[axis] != 0);
    let times: Vec<u64> = own.map(|step| step.at).collect();
    let limits = physics::Limits { start: 400.0, top: TOP, accel: 25_000.0, decel: 25_000.0 };
    for part in times.chunk_by(|a, b| b - a < TICKS_PER_SECOND / 50) {
        assert_eq!(physics::check(part, &limits), Ok(()), "axis {axis}");
    }
}

#[test]
fn feeds_rapids_and_axes_of_their_own_follow_their_override() {
    // Script, the register that rules it, its undisturbed rate, and an axis whose steps are all
    // events.
    let cases: [(&str, u16, f64, Option<usize>); 4] = [
        ("G1 X30 F1200", FEED, 2_000.0, Some(0)),
        ("G0 Y90", RAPID, TOP, Some(1)),
        ("MoveAxe X, 30mm, 20mm/s", FEED, 2_000.0, Some(0)),
        ("F1200\nG2 X20 Y20 I20\nG2 X0 Y0 I-20", FEED, 2_000.0, None),
    ];
    let boards = [&G2553, &F5529];
    let tries = boards.iter().flat_map(|board| cases.map(|case| (*board, case)));
    for (board, (script, register, rate, axis)) in tries {
        if board.part == G2553.part && script.contains("G2") {
            continue;
        }
        let whole = run(board, script, &[]);
        let orders = [(150, register, 40), (450, register, 100)];
        let slowed = run(board, script, &orders);
        assert_eq!(directions(&slowed), directions(&whole), "{script}: the path");
        let longer =
            slowed.ended - slowed.began > whole.ended - whole.began + TICKS_PER_SECOND / 10;
        assert!(longer, "{script}: 40 % takes longer");
        let top = fastest(&whole.steps);
        assert!((top / rate - 1.0).abs() < 0.02, "{script}: {top} events/s");
        if let Some(axis) = axis {
            holds_ramps(&slowed, axis);
        }
        // The other register does not touch it.
        let other = if register == FEED { RAPID } else { FEED };
        let same = run(board, script, &[(100, other, 10)]);
        let off = (same.ended - same.began).abs_diff(whole.ended - whole.began);
        assert!(off < TICKS_PER_SECOND / 50, "{script}: {off} ticks by the other override");
    }
}

#[test]
fn two_hundred_percent_double_a_feed_up_to_the_top() {
    for board in [&G2553, &F5529] {
        let fast = run(board, "G1 X30 F1200", &[(50, FEED, 200)]);
        let top = fastest(&fast.steps);
        assert!((top / 4_000.0 - 1.0).abs() < 0.02, "{top} events/s");
        holds_ramps(&fast, 0);
        let limited = run(board, "G1 X60 F3600", &[(50, FEED, 200)]);
        let top = fastest(&limited.steps);
        assert!((top / TOP - 1.0).abs() < 0.02, "{top} events/s");
        holds_ramps(&limited, 0);
    }
    let started = run(
        &F5529,
        "START MoveAxe X, 30mm, 10mm/s\nMoveAxe Y, 30mm, 20mm/s\nWaitMove",
        &[(50, FEED, 200)],
    );
    holds_ramps(&started, 0);
    holds_ramps(&started, 1);
    let own = |axis: usize| {
        let steps = started.steps.iter().filter(|step| step.by[axis] != 0).copied();
        fastest(&steps.collect::<Vec<_>>())
    };
    assert!((own(0) / 2_000.0 - 1.0).abs() < 0.02 && (own(1) / 4_000.0 - 1.0).abs() < 0.02);
}

#[test]
fn homing_and_probing_keep_their_speeds_and_odd_percents_are_refused() {
    let mill = Profile::built_in("mill").expect("the mill");
    for board in [&G2553, &F5529] {
        let mut lab = Lab::new(board, &mill, "Home X\nProbe? Z, -3mm, 5mm/s");
        for (register, percent) in [(FEED, 9), (FEED, 201), (RAPID, 9), (RAPID, 101), (FEED, 0)] {
            assert!(!lab.write(register, percent), "{percent} % in {register}");
        }
        assert!(lab.write(FEED, 200) && lab.write(RAPID, 50));
        assert_eq!((lab.read(FEED), lab.read(RAPID)), (200, 50));
        let seeks = lab.play(|_| {});
        let own = |axis: usize| {
            let steps = seeks.steps.iter().filter(|step| step.by[axis] != 0).copied();
            fastest(&steps.collect::<Vec<_>>())
        };
        // The mill finds its switch at 2000 st/s; the probe was given 500 st/s.
        assert!((own(0) / 2_000.0 - 1.0).abs() < 0.02, "{}", own(0));
        assert!((own(2) / 500.0 - 1.0).abs() < 0.02, "{}", own(2));
    }
}
