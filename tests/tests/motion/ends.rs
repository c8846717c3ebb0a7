//! Ends of a run while axes move: a stop comes to rest on the ramp, an emergency stop at once.

use emulator::TICKS_PER_SECOND;
use firmware::motion::physics;
use lang::fault::Fault;
use lang::profile::Profile;
use lang::wire::{Control, FAULT, HOMED, RUN_CONTROL, RUN_STATE, RunState};
use pasapas::board::{Build, F5529, G2553};

use crate::lab::{Dice, Lab, Step};

/// Moves of X that are long enough for every instant that is tried.
const SCRIPTS: [&str; 3] = ["MoveAxe X, 90mm", "G0 X90 Y20", "G1 X60 Y9 Z-4 F3600"];
/// A stop may take so long, ms: the input filter, what the engine holds, the ramp.
const STOP_MS: u64 = 500;

/// Starts a script, lets it run for a while, does something and gives every step.
fn ended(build: &Build, script: &str, ms: u64, act: impl FnOnce(&mut Lab)) -> (Lab, Vec<Step>) {
    let mill = Profile::built_in("mill").expect("the mill");
    let mut lab = Lab::new(build, &mill, &format!("Home X\n{script}"));
    let plant = lab.board.plant_mut();
    let home = emulator::plant::Contact { axis: 0, position: -20, above: false };
    plant.switches[0] = Some(home);
    lab.start();
    // The reference run takes half a second.
    lab.run_ms(700);
    assert_eq!(lab.read(HOMED) & 1, 1, "homed");
    lab.edges();
    lab.run_ms(ms);
    act(&mut lab);
    let made = lab.steps();
    let places = lab.board.plant().motors.each_ref().map(|motor| motor.position);
    let told = lab.told();
    // Homing counts anew: X opens one step off its switch.
    assert_eq!([told[0] + home.position + 1, told[1], told[2]], places, "{script}");
    (lab, made)
}

/// The dominant axis's steps come to rest within the ramp.
fn rests_on_ramp(made: &[Step], name: &str) {
    let times: Vec<u64> = made.iter().filter(|s| s.by[0] != 0).map(|s| s.at).collect();
    // The record may begin at full speed: what comes before the last second is not looked at.
    let tail = &times[times.len().saturating_sub(400)..];
    let limits = physics::Limits { start: 8_000.0, top: 8_000.0, accel: 25_000.0, decel: 25_000.0 };
    assert_eq!(physics::check(tail, &limits), Ok(()), "{name}");
    let [.., a, b] = tail else { panic!("{name}: no steps") };
    let last = TICKS_PER_SECOND as f64 / (b - a) as f64;
    assert!(last < 520.0, "{name}: the last step came at {last} steps/s");
}

#[test]
fn a_stop_comes_to_rest_on_the_ramp() {
    let mut dice = Dice(5);
    for build in [&G2553, &F5529] {
        for (n, script) in SCRIPTS.iter().enumerate() {
            let name = format!("{script} on {}", build.part.name);
            let ms = 150 + dice.below(300);
            let (mut lab, made) = ended(build, script, ms, |lab| {
                if n == 0 {
                    // Held for 2 s: the pause at once, the end behind it.
                    lab.press(false, 2_100);
                } else {
                    assert!(lab.write(RUN_CONTROL, Control::Stop as u16));
                    lab.run_ms(STOP_MS);
                }
            });
            rests_on_ramp(&made, &name);
            assert_eq!(lab.read(RUN_STATE), RunState::Ready as u16, "{name}");
            assert_eq!(lab.read(HOMED) & 1, 1, "{name}: a stop loses no step");
        }
    }
}

#[test]
fn an_emergency_stop_ceases_within_a_step() {
    let mut dice = Dice(7);
    for build in [&G2553, &F5529] {
        for script in SCRIPTS {
            let ms = 150 + dice.below(300);
            let name = format!("{script} on {} after {ms} ms", build.part.name);
            let mut told = 0;
            let (mut lab, made) = ended(build, script, ms, |lab| {
                lab.stops_abruptly("an emergency stop");
                assert!(lab.write(RUN_CONTROL, Control::EmergencyStop as u16));
                told = lab.now();
                lab.run_ms(50);
            });
            // The request is obeyed before its reply has left: no step behind that.
            let last = made.last().expect("steps").at;
            assert!(last < told, "{name}: a step {} ticks behind the reply", last.abs_diff(told));
            assert_eq!(lab.read(HOMED), 0, "{name}");
            assert_eq!(lab.read(FAULT), u16::from(Fault::EmergencyStop.number()), "{name}");
            assert_eq!(lab.read(RUN_STATE), RunState::Fault as u16, "{name}");
        }
    }
}
