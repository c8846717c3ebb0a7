//! What a host moves by hand: commands 102 and 1111, and how they end (InterpCNC V3 Modbus protocol,
//! Commands).

use lang::wire::{Exception, command};

use crate::commands::{BUSY, ILLEGAL, board, long, mill, move_to, order};
use crate::live::Live;

/// A float's registers, low word first.
fn float(value: f32) -> [u16; 2] {
    long(value.to_bits().cast_signed())
}

/// Command 1111: axes, speed in mm/min, places or distances in mm.
fn jog(live: &mut Live, axes: u16, speed: f32, places: &[f32]) -> u8 {
    let floats: Vec<u16> = [speed].iter().chain(places).flat_map(|&value| float(value)).collect();
    order(live, command::JOG, &[&[axes], &floats])
}

/// Command 102 with a ramp of 20 000 steps/s2.
fn run(live: &mut Live, axis: u16, speed: i32) -> u8 {
    order(live, command::MOVE_SPEED, &[&[axis], &long(20_000), &long(speed)])
}

/// Steps of an axis in this many um.
fn steps(axis: usize, um: i64) -> i64 {
    let profile = mill();
    let axes = [&profile.x, &profile.y, &profile.z];
    let axis = axes[axis].as_ref().expect("the mill has it");
    let (steps, um_of) = (i64::from(axis.scale.steps), i64::from(axis.scale.um));
    (um * steps + um_of / 2).div_euclid(um_of)
}

#[test]
fn axes_jog_by_distances_and_to_places() {
    let mut live = board("Wait 1s\n");
    assert_eq!(jog(&mut live, 0x45, 600.0, &[1.5, -0.25]), 0);
    assert_eq!(jog(&mut live, 0x41, 600.0, &[1.0]), BUSY);
    live.run_ms(1_500);
    let [x, z] = [steps(0, 1_500), steps(2, -250)];
    assert_eq!(live.motors(), [x, 0, z]);
    assert_eq!(live.longs("STEPS").map(i64::from), [x, 0, z]);
    // Z's work position becomes 10 steps; absolute places are work positions.
    assert_eq!(order(&mut live, command::SET_POSITION, &[&[3], &long(10)]), 0);
    assert_eq!(jog(&mut live, 6, 600.0, &[0.75, 0.5]), 0);
    live.run_ms(1_500);
    assert_eq!(live.motors(), [x, steps(1, 750), z - 10 + steps(2, 500)]);
    assert_eq!(live.byte("MOTION"), 0);
}

#[test]
fn a_jog_has_the_speed_that_it_was_given() {
    let mut live = board("Wait 1s\n");
    // 240 mm/min are 4 mm/s along the path of 3, 4, 5.
    assert_eq!(jog(&mut live, 0x43, 240.0, &[6.0, 8.0]), 0);
    live.run_ms(960);
    let first = live.motors();
    live.run_ms(1_000);
    let second = live.motors();
    let gone = [0, 1].map(|n| second[n] - first[n]);
    for (n, um) in [(0, 2_400), (1, 3_200)] {
        assert!((gone[n] - steps(n, um)).abs() <= steps(n, um) / 100, "{gone:?}");
    }
}

#[test]
fn a_jog_that_makes_no_sense_is_refused() {
    let mut live = board("Wait 1s\n");
    for (axes, speed, place) in [
        (0, 100.0, 1.0),
        (0x40, 100.0, 1.0),
        (8, 100.0, 1.0),
        (0x81, 100.0, 1.0),
        (0x141, 100.0, 1.0),
        (1, 0.0, 1.0),
        (1, -100.0, 1.0),
        (1, 100.0, 1e9),
        (1, 100.0, -1e9),
        (1, 100.0, 3e38),
        (1, 100.0, f32::INFINITY),
    ] {
        assert_eq!(jog(&mut live, axes, speed, &[place]), ILLEGAL, "{axes:#x} {speed} {place}");
    }
    let homed = live.at("HOMED");
    live.board.poke8(homed, 2);
    // Y is refused before X has begun.
    assert_eq!(jog(&mut live, 0x43, 100.0, &[1.0, -1.0]), ILLEGAL, "beyond the travel");
    live.run_ms(100);
    assert_eq!((live.motors(), live.byte("MOVING")), ([0; 3], 0));
    assert_eq!(jog(&mut live, 0x41, 100.0, &[0.0]), 0, "nowhere to go");
    live.run_ms(30);
    assert_eq!(live.byte("MOTION"), 0);
    let code = live.at("VM_CODE");
    live.board.poke16(code, 0);
    assert_eq!(jog(&mut live, 0x41, 100.0, &[1.0]), Exception::DeviceFailure as u8);
}

#[test]
fn a_silent_host_ends_what_it_began() {
    for begins in
        [|live: &mut Live| run(live, 1, 500), |live: &mut Live| jog(live, 0x41, 60.0, &[50.0])]
    {
        let mut live = board("Wait 1s\n");
        assert_eq!(begins(&mut live), 0);
        let moves = |live: &Live| live.byte("MOVING") != 0;
        // Any sound request keeps it going.
        for _ in 0..3 {
            live.run_ms(1_500);
            assert!(moves(&live));
            assert_eq!(order(&mut live, command::MOVE_SPEED, &[&[2]]), BUSY);
        }
        live.run_ms(1_900);
        assert!(moves(&live));
        live.run_ms(300);
        assert!(!moves(&live));
        let rests = live.motors();
        assert!(rests[0] > 0);
        assert_eq!(rests[1..], [0; 2]);
        live.run_ms(2_100);
        assert_eq!(live.motors(), rests);
        assert_eq!(live.longs("STEPS").map(i64::from), rests);
        // What goes on without the host does so.
        assert_eq!(move_to(&mut live, 2, 6_000), 0);
        live.run_ms(4_000);
        assert_eq!(live.motors()[1], 6_000);
    }
}

#[test]
fn an_axis_runs_at_a_speed_until_it_is_stopped() {
    let mut live = board("Wait 1s\n");
    assert_eq!(run(&mut live, 2, -1_000), 0);
    live.run_ms(300);
    let first = live.motors();
    live.run_ms(1_000);
    let gone = live.motors()[1] - first[1];
    assert!((-1_010..=-990).contains(&gone), "{gone}");
    assert_eq!(run(&mut live, 1, 1_000), BUSY);
    assert_eq!(run(&mut live, 1, 0), 0, "another axis stops, which rests");
    live.run_ms(200);
    assert_ne!(live.byte("MOVING"), 0);
    assert_eq!(run(&mut live, 2, 0), 0);
    live.run_ms(200);
    assert_eq!((live.byte("MOVING"), live.byte("MOTION")), (0, 0));
    let rests = live.motors();
    assert_eq!(live.longs("STEPS").map(i64::from), rests);
    assert_eq!([rests[0], rests[2]], [0; 2]);
    // No ramp; no axis.
    let stands = [&[1u16][..], &long(0), &long(5)];
    assert_eq!(order(&mut live, command::MOVE_SPEED, &stands), ILLEGAL);
    assert_eq!(run(&mut live, 4, 10), ILLEGAL);
}

#[test]
fn a_homed_axis_runs_to_the_end_of_its_travel() {
    let mut live = board("Wait 1s\n");
    let homed = live.at("HOMED");
    live.board.poke8(homed, 1);
    assert_eq!(move_to(&mut live, 1, 700), 0);
    live.run_ms(1_000);
    assert_eq!(run(&mut live, 1, -2_000), 0);
    live.run_ms(1_000);
    assert_eq!((live.motors()[0], live.byte("MOVING")), (0, 0));
}

#[test]
fn a_direct_function_ends_a_jog_and_nothing_else() {
    let mut live = board("MoveAxe X, 20mm\n");
    assert_eq!(move_to(&mut live, 1, 4_000), 0);
    assert_eq!(order(&mut live, command::DIRECT, &[&[133]]), 0);
    live.run_ms(3_000);
    assert_eq!(live.motors(), [4_000, 0, 0]);
    assert_eq!(jog(&mut live, 0x42, 300.0, &[40.0]), 0);
    live.run_ms(500);
    assert_eq!(order(&mut live, command::DIRECT, &[&[133]]), 0);
    live.run_ms(200);
    assert_eq!((live.byte("MOVING"), live.byte("MOTION")), (0, 0));
    let rests = live.motors();
    assert!(rests[1] > 0 && rests[1] < steps(1, 10_000));
    // A run begins afterwards; its moves are no jog.
    live.start();
    live.run_ms(100);
    assert_eq!(order(&mut live, command::DIRECT, &[&[133]]), 0);
    live.run_ms(10_000);
    assert_eq!(live.motors()[0], steps(0, 20_000));
}
