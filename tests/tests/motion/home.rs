//! Reference runs on the shipped images of both parts.

use emulator::plant::Contact;
use lang::fault::Fault;
use lang::profile::{Input, InputRole, Profile};
use lang::wire::{FAULT, HOMED, RUN_STATE, RunState};
use pasapas::board::{Build, F5529, G2553};

use crate::lab::{Lab, Run};

/// The mill, looking 5 mm far for its switches.
fn mill() -> Profile {
    let mut profile = Profile::built_in("mill").expect("the mill");
    for axis in [&mut profile.x, &mut profile.y, &mut profile.z].into_iter().flatten() {
        axis.home.stroke_um = 5_000;
    }
    profile
}

/// A board with switches that are closed at their place and beyond it.
fn lab(build: &Build, profile: &Profile, script: &str, switches: [i64; 3]) -> Lab {
    let mut lab = Lab::new(build, profile, script);
    for (axis, position) in switches.into_iter().enumerate() {
        let above = axis == 2;
        lab.board.plant_mut().switches[axis] = Some(Contact { axis, position, above });
    }
    lab
}

fn places(lab: &Lab) -> [i64; 3] {
    lab.board.plant().motors.each_ref().map(|motor| motor.position)
}

/// Steps of an axis in the order in which they were made.
fn own(run: &Run, axis: usize) -> Vec<i8> {
    run.steps.iter().map(|step| step.by[axis]).filter(|by| *by != 0).collect()
}

/// Runs a script that faults.
fn fault(lab: &mut Lab) -> Option<Fault> {
    lab.start();
    for _ in 0..800 {
        if lab.read(RUN_STATE) == RunState::Fault as u16 {
            return Fault::from_number(lab.read(FAULT) as u8);
        }
    }
    None
}

#[test]
fn every_axis_is_homed_in_the_profiles_order_and_leaves_its_switch_by_the_clearance() {
    let mut profile = mill();
    for axis in [&mut profile.x, &mut profile.z].into_iter().flatten() {
        axis.home.clearance_um = 1_500;
    }
    for build in [&G2553, &F5529] {
        let mut lab = lab(build, &profile, "Home", [-120, -90, 75]);
        let run = lab.play(|_| {});
        let begins = [0, 1, 2].map(|axis| run.steps.iter().position(|s| s.by[axis] != 0));
        assert!(begins[2] < begins[1] && begins[1] < begins[0], "{begins:?}");
        // A step off the switch it opens; that is position 0, the clearance goes on from there.
        assert_eq!(places(&lab), [-119 + 150, -89, 74 - 150], "{}", build.part.name);
        assert_eq!(lab.told(), [150, 0, -150], "{}", build.part.name);
        assert_eq!(lab.read(HOMED), 0b111);
    }
}

#[test]
fn a_switch_that_is_closed_at_the_start_is_left_slowly() {
    for build in [&G2553, &F5529] {
        let mut lab = lab(build, &mill(), "Home X", [60, -500, 500]);
        let run = lab.play(|_| {});
        assert!(own(&run, 0).iter().all(|by| *by == 1), "never toward the switch");
        assert_eq!((places(&lab)[0], lab.told()[0]), (61, 0), "{}", build.part.name);
        let times: Vec<u64> = run.steps.iter().map(|step| step.at).collect();
        let fastest = times.windows(2).map(|w| w[1] - w[0]).min().expect("steps");
        assert!(fastest >= 16_000_000 / 202, "{fastest} ticks: faster than 200 st/s");
    }
}

#[test]
fn a_switch_beyond_the_stroke_and_one_that_stays_closed_are_faults() {
    for build in [&G2553, &F5529] {
        let mut lost = lab(build, &mill(), "Home Y", [-500, -900, 500]);
        assert_eq!(fault(&mut lost), Some(Fault::HomeNotFound), "{}", build.part.name);
        assert_eq!((places(&lost)[1], lost.read(HOMED)), (-500, 0), "{}", build.part.name);
        let mut stuck = lab(build, &mill(), "Home Y", [-500, 9_000, 500]);
        assert_eq!(fault(&mut stuck), Some(Fault::HomeStaysClosed), "{}", build.part.name);
        assert_eq!((places(&stuck)[1], stuck.read(HOMED)), (500, 0), "{}", build.part.name);
    }
}

#[test]
fn two_axes_find_one_switch() {
    let mut profile = mill();
    // Both contacts are wired to input 9.
    for role in [InputRole::ReferenceX, InputRole::ReferenceY] {
        let input = Input { n: 9, name: None, role: Some(role), invert: false, filter_ms: 5 };
        profile.inputs.push(input);
    }
    for build in [&G2553, &F5529] {
        let mut lab = lab(build, &profile, "Home Y, X", [-80, -9_000, 500]);
        let run = lab.play(|lab| {
            // The plant has a switch for each axis: Y's contact closes the same input by hand.
            for _ in 0..4_000 {
                let at = places(lab);
                let closed = at[1] <= -110 || at[0] <= -80;
                lab.board.plant_mut().switches[0] = Some(Contact {
                    axis: 0,
                    position: if closed { 9_000 } else { -9_000 },
                    above: false,
                });
                lab.run_ms(1);
                if lab.is_done() {
                    break;
                }
            }
        });
        assert!(!run.steps.is_empty());
        assert_eq!(lab.read(HOMED) & 0b11, 0b11, "{}", build.part.name);
        let at = places(&lab);
        // The hand is a millisecond late, and so is the board.
        assert!((at[1] + 109).abs() <= 1 && (at[0] + 79).abs() <= 1, "{at:?}");
        assert_eq!(&lab.told()[..2], [0, 0]);
    }
}
