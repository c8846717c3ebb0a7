//! Pause by Stop at random instants of every kind of move, and resume: no step lost, the path
//! unchanged.

use emulator::plant::Contact;
use firmware::motion::physics;
use lang::profile::{Profile, SafeState};
use pasapas::board::{Build, F5529, G2553};

use crate::lab::{Dice, Lab, MS, PRESS_MS, Run};

/// A move and what it needs around it.
struct Case {
    name: &'static str,
    script: &'static str,
    /// Runs on the G2553, too.
    small: bool,
    same: Same,
    /// Axes move one by one or on their own: each from rest to rest within the ramps.
    ramps: bool,
}

/// What a pause must leave as it is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Same {
    /// Every step, in order.
    Path,
    /// The steps of each axis; their order among one another is free.
    Axes,
    /// Where it ends: how far it overruns a switch hangs on the millisecond that sees it.
    End,
    /// What the board says of its place, which hangs on time.
    Count,
}

const CASES: [Case; 12] = [
    Case {
        name: "one axis",
        script: "MoveAxe X, 12mm\nMoveRel X, -4mm, 20mm/s, 100mm/s2, 50mm/s2",
        small: true,
        same: Same::Path,
        ramps: true,
    },
    Case {
        name: "rapid",
        script: "G0 X12 Y-7 Z-3\nG0 X0 Y0",
        small: true,
        same: Same::Path,
        ramps: false,
    },
    Case {
        name: "line",
        script: "G1 X9 Y4 Z-2 F900\nG1 X2 Y6 F300",
        small: true,
        same: Same::Path,
        ramps: false,
    },
    Case { name: "homing", script: "Home Z, X", small: true, same: Same::End, ramps: true },
    Case {
        name: "probing",
        script: "Probe Z, -9mm, 5mm/s",
        small: true,
        same: Same::Path,
        ramps: true,
    },
    Case {
        name: "canned cycle",
        script: "G0 X5 Y5\nG99 G83 X6 Y7 Z-5 R-1 Q1.5 F600\nG80",
        small: true,
        same: Same::Path,
        ramps: false,
    },
    Case {
        name: "dwell",
        script: "G4 P0.3\nWait 200ms",
        small: true,
        same: Same::Path,
        ramps: false,
    },
    Case {
        name: "arcs",
        script: "F1200\nG3 X4 Y4 J4\nG2 X8 Y8 Z-1 I4\nG18 G3 X8 Z-1 I-3",
        small: false,
        same: Same::Path,
        ramps: false,
    },
    Case {
        name: "path",
        script: "F1500\nG1 X5\nG1 X9 Y1\nG3 X11 Y3 J2\nG1 Y8\nG61 G1 X5 Y9\nG64 G1 X1\nG1 X0 Y1",
        small: false,
        same: Same::Path,
        ramps: false,
    },
    Case {
        name: "polygon",
        script: "DIM i\nFOR i = 1 TO 24\nG91 G1 X0.5 Y0.1 F900\nNEXT",
        small: false,
        same: Same::Path,
        ramps: false,
    },
    Case {
        name: "started axes",
        script: "START MoveAxe X, 12mm\nSTART MoveAxe Y, -9mm, 30mm/s\n\
            START MoveAxe Z, -3mm, 9mm/s\nWaitMove X\nSTART MoveAxe X, -2mm\nWaitMove",
        small: false,
        same: Same::Axes,
        ramps: true,
    },
    Case {
        name: "axes at a speed",
        script: "MoveSpeed X, 25mm/s\nMoveSpeed Y, -3mm/s\nWait 200ms\nStopAll",
        small: false,
        same: Same::Count,
        ramps: true,
    },
];

/// The plate stands here, steps.
const PLATE: i64 = -600;

fn lab(build: &Build, case: &Case) -> Lab {
    let mill = Profile::built_in("mill").expect("the mill");
    let mut lab = Lab::new(build, &mill, case.script);
    let plant = lab.board.plant_mut();
    plant.probes[2] = Some(Contact { axis: 2, position: PLATE, above: false });
    for (axis, side) in [(0, -1), (2, 1)] {
        plant.switches[axis] = Some(Contact { axis, position: side * 500, above: side > 0 });
    }
    lab
}

/// The path: every step, or those of each axis, or nothing.
fn path(run: &Run, same: Same) -> Vec<Vec<[i8; 3]>> {
    let all = run.steps.iter().map(|step| step.by);
    match same {
        Same::Path => return vec![all.collect()],
        Same::Axes => {}
        Same::End | Same::Count => return Vec::new(),
    }
    let own = |axis: usize| all.clone().filter(move |by| by[axis] != 0);
    (0..3)
        .map(|axis| {
            own(axis).map(move |by| std::array::from_fn(|a| if a == axis { by[a] } else { 0 }))
        })
        .map(Iterator::collect)
        .collect()
}

/// Presses Stop at some instants of the run, waits for rest, and presses Start again. Gives the
/// time that the machine rested.
fn interrupt(lab: &mut Lab, dice: &mut Dice, span_ms: u64) {
    for _ in 0..1 + dice.below(3) {
        lab.board.run_us(dice.below(span_ms * 1_000));
        if lab.is_done() {
            return;
        }
        lab.press(false, 20 + dice.below(60));
        lab.settle(30 + dice.below(100));
        if lab.is_done() {
            return;
        }
        lab.press(true, PRESS_MS);
    }
}

/// Every part of an axis's way, from rest to rest, is one that its motor can follow.
fn holds_ramps(run: &Run, axis: usize, name: &str) {
    let own: Vec<_> = run.steps.iter().filter(|step| step.by[axis] != 0).collect();
    let limits = physics::Limits { start: 400.0, top: 8_000.0, accel: 25_000.0, decel: 25_000.0 };
    let rest = 15 * MS;
    for part in own.chunk_by(|a, b| b.at - a.at < rest && a.by[axis] == b.by[axis]) {
        let times: Vec<u64> = part.iter().map(|step| step.at).collect();
        assert_eq!(physics::check(&times, &limits), Ok(()), "{name}, axis {axis}");
    }
}

/// Where the motors are, steps.
fn places(lab: &Lab) -> [i64; 3] {
    lab.board.plant().motors.each_ref().map(|motor| motor.position)
}

/// Pauses a case `count` times on one build; what a pause must not change is compared.
fn holds(build: &Build, case: &Case, count: u64) {
    let fresh = lab(build, case);
    let name = format!("{} on {}", case.name, build.part.name);
    let mut lab = fresh.clone();
    let still = lab.play(|_| {});
    let end = places(&lab);
    let span_ms = (still.ended - still.began) / MS;
    let whole = path(&still, case.same);
    for n in 0..count {
        let mut dice = Dice(n ^ 0x5EED << 16 ^ case.script.len() as u64);
        println!("{name}, pause {n}");
        let mut lab = fresh.clone();
        let run = lab.play(|lab| interrupt(lab, &mut dice, span_ms));
        for axis in 0..3 {
            if case.ramps {
                holds_ramps(&run, axis, &format!("{name}, pause {n}"));
            }
        }
        let paused = path(&run, case.same);
        for (axis, (paused, whole)) in paused.iter().zip(&whole).enumerate() {
            let at = paused.iter().zip(whole).position(|(a, b)| a != b);
            assert_eq!(at, None, "{name}, pause {n}: stream {axis} differs first at this step");
            assert_eq!(paused.len(), whole.len(), "{name}, pause {n}: steps");
        }
        if case.same != Same::Count {
            assert_eq!(places(&lab), end, "{name}, pause {n}: where it ends");
        }
        if case.same != Same::End {
            assert_eq!(lab.told(), places(&lab), "{name}, pause {n}: what the board says");
        }
    }
}

#[test]
fn a_pause_at_any_instant_leaves_the_path_as_it_is() {
    for case in &CASES {
        holds(&F5529, case, 2);
        if case.small {
            holds(&G2553, case, 2);
        }
    }
}

#[test]
#[ignore = "minutes: the long form"]
fn pauses_in_great_number_leave_the_path_as_it_is() {
    for case in &CASES {
        holds(&F5529, case, 200);
        if case.small {
            holds(&G2553, case, 200);
        }
    }
}

#[test]
fn a_pause_while_the_spindle_comes_up_again_stays_one() {
    for build in [&G2553, &F5529] {
        let mut mill = Profile::built_in("mill").expect("the mill");
        mill.run.spin_up_ms = 1_000;
        mill.outputs[0].pause = SafeState::Off;
        let mut lab = Lab::new(build, &mill, "M3\nG1 X20 F600");
        lab.start();
        lab.run_ms(500);
        lab.press(false, PRESS_MS);
        lab.settle(50);
        let rests = places(&lab);
        assert!((200..1_500).contains(&rests[0]), "{rests:?}");
        assert!(!lab.board.plant().output(1), "the spindle rests in a pause");
        // Start, and Stop before it is up.
        lab.start();
        lab.run_ms(300);
        assert!(lab.board.plant().output(1));
        lab.press(false, PRESS_MS);
        lab.run_ms(3_000);
        assert_eq!(places(&lab), rests, "{}", build.part.name);
        // Start once more: now it goes on, when the spindle is up.
        lab.start();
        lab.run_ms(700);
        assert_eq!(places(&lab), rests, "{}", build.part.name);
        lab.run_ms(4_000);
        assert_eq!(places(&lab), [2_000, 0, 0], "{}", build.part.name);
    }
}
