//! What comes to a path from outside: how motors are wired, doors, feed holds, power that fails.

use lang::profile::{BUILT_IN, Profile};
use lang::record::MachineRecord;
use lang::wire::RunState;

use super::rig::{Mill, in_order, mill};
use super::{board, circle, whole};

/// An axis that no line has moved yet has a DIR pin, too: it is right when a line turns it at speed.
#[test]
fn axes_that_join_a_path_later_go_the_right_way() {
    let lines = [[0.0, 9.0, 0.0], [0.4, 18.0, 0.0], [0.8, 27.0, -0.4], [0.5, 36.0, -0.8]];
    for inverted in 0..8_u8 {
        for way in [1.0, -1.0] {
            let mut mill = mill();
            let axes = [&mut mill.profile.x, &mut mill.profile.y, &mut mill.profile.z];
            for (a, axis) in axes.into_iter().flatten().enumerate() {
                axis.invert = inverted & 1 << a != 0;
            }
            mill.axes = MachineRecord::of(&mill.profile).axes;
            let places = lines.map(|place| place.map(|mm| mm * way));
            let (mut mover, lines) = board(&mill, &places);
            mover.wire(inverted);
            mover.start();
            mover.end(20);
            whole(&mill, &mover, &lines);
        }
    }
}

/// X makes a step with the last event of each line, and turns round as the next one begins, faster than from rest, as Y may
/// only start slowly: its STEP falls before its DIR changes.
#[test]
fn an_axis_that_turns_at_speed_keeps_its_direction_until_its_step_is_over() {
    let mut mill = mill();
    mill.profile.y.as_mut().expect("Y").start_rate = 1;
    mill.axes = MachineRecord::of(&mill.profile).axes;
    let places: Vec<_> = (1..=40).map(|n| [f64::from(n % 2), 0.05 * f64::from(n), 0.0]).collect();
    let (mut mover, lines) = board(&mill, &places);
    for line in &lines[..39] {
        assert!(line.exit > 2.0 * mill.ramp(line, |axis| axis.start_rate.into()), "{line:?}");
    }
    mover.start();
    mover.end(30);
    whole(&mill, &mover, &lines);
}

/// The same mill with another role of an input.
fn with_role(role: &str, n: u8) -> Mill {
    let text = Profile::built_in("mill").map(|_| BUILT_IN[0].1).expect("the mill");
    let text = format!("{text}\n[[input]]\nn = {n}\nrole = \"{role}\"\n");
    let profile = Profile::parse(&text).expect("a role");
    let mut mill = mill();
    mill.profile = Profile { require_homing: false, ..profile };
    mill
}

#[test]
fn a_door_and_a_feed_hold_brake_along_the_path_and_lose_nothing() {
    for (role, at) in [("hold", 150), ("hold", 640), ("door", 333), ("door", 905)] {
        let mill = with_role(role, 9);
        let (mut mover, lines) = board(&mill, &circle(150, 10.0, 0.0));
        mover.start();
        mover.run_us(at * 1000);
        mover.board.plant_mut().set_input(9, true);
        mover.run_us(400_000);
        assert_eq!(mover.state(), RunState::Paused, "{role} at {at} ms");
        let rests = mover.motors();
        // Nothing goes on while it is open.
        mover.board.plant_mut().press_start(true);
        mover.run_us(100_000);
        mover.board.plant_mut().press_start(false);
        mover.run_us(100_000);
        assert_eq!((mover.state(), mover.motors()), (RunState::Paused, rests), "{role} at {at} ms");
        mover.board.plant_mut().set_input(9, false);
        mover.run_us(100_000);
        assert_eq!(mover.motors(), rests, "{role} at {at} ms");
        mover.start();
        mover.end(20);
        whole(&mill, &mover, &lines);
    }
}

/// Its flash holds the program whole: the next run is the first one.
#[test]
fn a_path_that_lost_its_power_begins_anew() {
    let mill = mill();
    let (mut mover, lines) = board(&mill, &circle(150, 10.0, 0.0));
    for at in [120, 480, 850] {
        mover.start();
        mover.run_us(at * 1000);
        in_order(&mover.steps, &lines, false);
        mover.power_cut();
        assert_eq!((mover.state(), mover.byte("HOMED")), (RunState::Ready, 0), "at {at} ms");
    }
    mover.start();
    mover.end(20);
    whole(&mill, &mover, &lines);
}
