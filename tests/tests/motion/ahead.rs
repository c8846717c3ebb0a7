//! Fine paths at speed, of which the board knows many blocks ahead: whatever happens around them, no step is lost,
//! none comes too late, and every axis keeps its ramps at the pins.

use emulator::plant::Contact;
use lang::profile::Profile;
use lang::wire::{Control, OVERRIDES, RUN_CONTROL};
use pasapas::bench::stand::fast_mill;
use pasapas::board::F5529;

use crate::lab::{Dice, Lab, PRESS_MS, Run};

/// Chords in a straight line, of a slow bend, of a wave with arcs between, and with handlers that want the path
/// to rest.
const SCRIPTS: [&str; 4] = [
    "DIM i\nG91\nF3000\nFOR i = 1 TO 300\nG1 X0.1\nNEXT",
    "DIM i\nG91\nF3000\nFOR i = 1 TO 150\nG1 X0.1 Y0.02\nG1 X0.1 Y0.024\nNEXT\nFOR i = 1 TO 60\nG1 X-0.3 Y0.1\nNEXT",
    "DIM i\nG91\nF2400\nFOR i = 1 TO 12\nREPEAT 12\nG1 X0.15\nEND REPEAT\nG3 X1 Y1 J1\nREPEAT 8\nG1 Y0.1\n\
     END REPEAT\nG2 X1 Y1 I1\nNEXT",
    "DIM i\nG91\nF3000\nON EVERY 90ms GOSUB lamp\nFOR i = 1 TO 300\nG1 X0.1\nNEXT\nON EVERY OFF\n\
     SUB lamp\nSetOut 3, ON\nSetOut 3, OFF\nEND SUB",
];

fn machines() -> [Profile; 2] {
    let mill = Profile::built_in("mill").expect("the mill");
    [mill, fast_mill(20_000, 400_000).expect("a steep mill")]
}

fn directions(run: &Run) -> Vec<[i8; 3]> {
    run.steps.iter().map(|step| step.by).collect()
}

/// People and clients around a run: pauses, overrides up and down, requests one behind the other.
fn crowd(lab: &mut Lab, dice: &mut Dice) {
    for _ in 0..3 + dice.below(8) {
        lab.board.run_us(dice.below(250_000));
        if lab.is_done() {
            return;
        }
        match dice.below(4) {
            0 => {
                lab.press(false, 20 + dice.below(60));
                lab.settle(30 + dice.below(60));
                lab.press(true, PRESS_MS);
            }
            1 => (0..dice.below(40)).for_each(|_| {
                lab.told();
            }),
            _ => {
                let percent = 10 + dice.below(191) as u16;
                assert!(lab.write(OVERRIDES, percent), "{percent} %");
            }
        }
    }
    lab.write(OVERRIDES, 200);
}

#[test]
fn nothing_around_a_fine_path_changes_it() {
    for (machine, profile) in machines().iter().enumerate() {
        for (script, text) in SCRIPTS.iter().enumerate() {
            let fresh = Lab::new(&F5529, profile, text);
            let whole = directions(&fresh.clone().play(|_| {}));
            for n in 0..4 {
                let mut dice = Dice(n ^ (script as u64) << 8 ^ (machine as u64) << 16);
                let run = fresh.clone().play(|lab| crowd(lab, &mut dice));
                assert!(directions(&run) == whole, "machine {machine}, script {script}, try {n}");
            }
        }
    }
}

#[test]
fn a_stop_ends_a_fine_path_on_its_ramp_and_knows_where() {
    for profile in machines() {
        for (n, text) in SCRIPTS.iter().enumerate() {
            let fresh = Lab::new(&F5529, &profile, text);
            for at in [40, 130, 333, 700] {
                let mut lab = fresh.clone();
                lab.start();
                lab.run_ms(at);
                if !lab.is_done() {
                    assert!(lab.write(RUN_CONTROL, Control::Stop as u16));
                }
                lab.settle(60);
                let stands = lab.board.plant().motors.each_ref().map(|motor| motor.position);
                assert_eq!(lab.told(), stands, "script {n} stopped at {at} ms");
            }
        }
    }
}

#[test]
fn a_limit_switch_ends_a_fine_path_at_once() {
    for profile in machines() {
        let mut lab =
            Lab::new(&F5529, &profile, "DIM i\nG91\nF3000\nFOR i = 1 TO 300\nG1 X-0.1\nNEXT");
        lab.board.plant_mut().switches[0] = Some(Contact { axis: 0, position: -700, above: false });
        lab.stops_abruptly("the limit switch");
        lab.start();
        lab.settle(100);
        let x = lab.board.plant().motors[0].position;
        assert!((-760..=-700).contains(&x), "{x}");
        assert!(!lab.is_done());
    }
}
