//! Soft limits before a move starts, limit switches while it runs, and the probe's very step.

use emulator::plant::Contact;
use lang::fault::Fault;
use lang::profile::{Profile, Wiring};
use lang::wire::{FAULT, FAULT_INPUT, HOMED, RUN_STATE, RunState};
use pasapas::board::{Build, F5529, G2553};

use crate::lab::{Dice, Lab};

/// Places of the switches, steps: X and Y find theirs at once, Z too.
const SWITCHES: [i64; 3] = [-10, -10, 10];

fn lab(build: &Build, script: &str) -> Lab {
    let mill = Profile::built_in("mill").expect("the mill");
    let mut lab = Lab::new(build, &mill, script);
    for (axis, position) in SWITCHES.into_iter().enumerate() {
        let above = axis == 2;
        lab.board.plant_mut().switches[axis] = Some(Contact { axis, position, above });
    }
    lab
}

fn faults(lab: &mut Lab) -> Option<Fault> {
    lab.start();
    for _ in 0..800 {
        if lab.read(RUN_STATE) == RunState::Fault as u16 {
            return Fault::from_number(lab.read(FAULT) as u8);
        }
        assert!(!lab.is_done(), "no fault");
    }
    None
}

#[test]
fn a_move_beyond_its_travel_makes_no_step() {
    // Where the machine rests when the fault comes, mm.
    let both = [
        ("Home\nG1 X10 Y10 F1200\nG1 X20 Y-0.01", [10, 10, 0]),
        ("Home\nG0 X10 Y10\nG0 X300.01", [10, 10, 0]),
        ("Home\nMoveAxe Z, -3mm\nMoveAxe Z, -80.01mm", [0, 0, -3]),
    ];
    // Ends inside, the leftmost point of the arc lies outside.
    let large = [
        ("Home\nG0 X5 Y20\nG2 X5 Y30 J5 F900", None),
        ("Home\nG0 X4.99 Y20\nG2 X4.99 Y30 J5 F900", Some([5, 20, 0])),
        ("Home\nG0 X5 Y2 Z-2\nG18 G2 X5 I2.01 F900", Some([5, 2, -2])),
    ];
    for build in [&G2553, &F5529] {
        for (script, rest) in both {
            let mut lab = lab(build, script);
            assert_eq!(faults(&mut lab), Some(Fault::SoftLimit), "{script}");
            let told = lab.told().map(|steps| steps / 100);
            assert_eq!(told, rest, "{script} on {}", build.part.name);
        }
    }
    for (script, rest) in large {
        let mut lab = lab(&F5529, script);
        let Some(rest) = rest else {
            lab.play(|_| {});
            continue;
        };
        assert_eq!(faults(&mut lab), Some(Fault::SoftLimit), "{script}");
        assert_eq!(lab.told().map(|steps| (steps + steps.signum() * 50) / 100), rest, "{script}");
    }
}

/// Steps that an axis makes beyond its closed switch at 4000 st/s, a script and what it may be.
fn beyond(build: &Build, wiring: Wiring, script: &str, instants: u64) -> usize {
    let mut mill = Profile::built_in("mill").expect("the mill");
    mill.wiring = wiring;
    let mut most = 0;
    for n in 0..instants {
        let place = 1_500 + n as i64;
        let mut lab = Lab::new(build, &mill, script);
        lab.board.plant_mut().switches[0] =
            Some(Contact { axis: 0, position: -place, above: false });
        lab.stops_abruptly("a limit switch");
        let name = format!("{script} on {}, {wiring:?}", build.part.name);
        assert_eq!(faults(&mut lab), Some(Fault::LimitSwitch), "{name}");
        let input = if wiring == Wiring::Chain { 9 } else { 1 };
        assert_eq!(lab.read(FAULT_INPUT), input, "{name}: the input is named");
        assert_eq!(lab.read(HOMED), 0);
        let made = lab.steps();
        let own = made.iter().filter(|s| s.by[0] != 0).count();
        assert_eq!(lab.told()[0], -(own as i64), "{name}");
        most = most.max(own - place as usize);
    }
    most
}

#[test]
fn a_limit_switch_stops_the_axes_within_a_step_at_a_pin_and_a_millisecond_in_the_chain() {
    for script in ["MoveAxe X, -90mm, 40mm/s", "G1 X-60 Y30 F2400"] {
        // A millisecond is 4 steps, one more is armed. The G2553 looks at its pins as at the chain,
        // behind a piece of its plan.
        for wiring in [Wiring::Direct, Wiring::Chain] {
            let steps = beyond(&G2553, wiring, script, 1);
            assert!(steps <= 6, "{script}, {wiring:?}: {steps} steps");
        }
        let steps = beyond(&F5529, Wiring::Direct, script, 4);
        assert!(steps <= 1, "{script}: {steps} steps");
        let steps = beyond(&F5529, Wiring::Chain, script, 4);
        assert!(steps <= 5, "{script}: {steps} steps");
    }
}

#[test]
fn a_probe_tells_its_very_step_at_every_speed() {
    let mut dice = Dice(11);
    for build in [&G2553, &F5529] {
        for _ in 0..4 {
            let (speed, plate) = (300 + dice.below(7_000), 100 + dice.below(1_500) as i64);
            let script = format!("Probe Z, -40mm, {speed}st/s\nMoveAxe Z, PROBEDST(Z)");
            let mut lab = lab(build, &script);
            lab.board.plant_mut().probes[2] =
                Some(Contact { axis: 2, position: -plate, above: false });
            lab.play(|_| {});
            let name = format!("{speed} st/s to {plate} on {}", build.part.name);
            assert_eq!(lab.told()[2], -plate, "{name}");
            assert_eq!(lab.board.plant().motors[2].position, -plate, "{name}");
        }
    }
}

#[test]
fn an_axis_leaves_its_closed_switch_and_does_not_move_on_toward_it() {
    // Z stands 2 mm beyond its switch, as behind a fault or by hand.
    let closed = |build: &Build, script: &str| {
        let mut lab = lab(build, script);
        let switch = Contact { axis: 2, position: -200, above: true };
        lab.board.plant_mut().switches[2] = Some(switch);
        lab
    };
    let both =
        ["MoveAxe Z, -5mm", "G0 Z-5", "G1 X4 F1200\nG1 Z-5", "MoveRel Z, -5mm\nMoveRel X, 1mm"];
    let large =
        ["START MoveAxe Z, -5mm\nWaitMove", "MoveSpeed Z, -9mm/s\nWait 500ms\nStopAll\nWaitMove"];
    let small = both.iter().map(|script| (&G2553, *script));
    let large = both.iter().chain(&large).map(|script| (&F5529, *script));
    for (build, script) in small.chain(large) {
        let mut lab = closed(build, script);
        lab.play(|_| {});
        assert!(lab.told()[2] < -300, "{script} on {}", build.part.name);
    }
    for build in [&G2553, &F5529] {
        for script in ["MoveAxe Z, 5mm", "G1 X4 F1200\nG1 Z5"] {
            let mut lab = closed(build, script);
            assert_eq!(faults(&mut lab), Some(Fault::LimitSwitch), "{script}");
            lab.stops_abruptly("a limit switch");
            assert!(lab.told()[2] < 10, "{script} on {}: {:?}", build.part.name, lab.told());
        }
    }
}
