//! Generated moves of every kind, undisturbed and disturbed: what `lab` holds every test to is all that
//! is asked of them.

use emulator::plant::Contact;
use lang::profile::Profile;
use lang::wire::OVERRIDES;
use pasapas::board::{Build, F5529, G2553};

use crate::lab::{Dice, Lab, PRESS_MS};

/// What else a script does.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Moves alone: their range and their ends are known.
    Moves,
    /// It begins with a reference run and probes between moves.
    Seeks,
    /// Axes run at a speed until they are stopped.
    Speeds,
}

fn mm(dice: &mut Dice, low: u64, high: u64) -> String {
    let hundredths = 100 * low + dice.below(100 * (high - low));
    format!("{}.{:02}", hundredths / 100, hundredths % 100)
}

/// A script of some statements; `down` is Z's direction away from its reference.
fn script(dice: &mut Dice, kind: Kind, large: bool, down: &str) -> String {
    let mut text = String::from("F1200\n");
    if kind == Kind::Seeks {
        text += ["Home\n", "Home Z, X\n"][dice.below(2) as usize];
    }
    // Away from the switches: an arc may reach 36 mm below its start.
    text += "G0 X50 Y50\n";
    for _ in 0..6 + dice.below(5) {
        let at = |dice: &mut Dice| {
            let (x, y, z) = (mm(dice, 40, 100), mm(dice, 40, 90), mm(dice, 2, 30));
            format!("X{x} Y{y} Z{down}{z}")
        };
        text += &match dice.below(if large { 9 } else { 5 }) {
            0 => format!("MoveAxe X, {}mm\n", mm(dice, 30, 110)),
            1 => format!("MoveAxe Z, {down}{}mm, {}mm/s\n", mm(dice, 2, 30), 1 + dice.below(70)),
            2 => format!("G0 {}\n", at(dice)),
            3 => format!("G1 {} F{}\n", at(dice), 300 + dice.below(4_000)),
            // The plate may be met, or not be reached.
            4 if kind == Kind::Seeks => {
                let to = mm(dice, 50, 90);
                format!("G0 Y40\nProbe? Y, {to}mm, {}mm/s\n", 1 + dice.below(40))
            }
            4 => format!("G4 P0.0{}\n", dice.below(9)),
            5 | 6 => {
                // Away from here and back, tangentially.
                let r = mm(dice, 1, 18);
                format!(
                    "G91\nG3 X{r} Y{r} J{r}\nG2 X-{r} Y-{r} J-{r}\nG1 X-1.5 Y0.{}\nG90\n",
                    dice.below(9)
                )
            }
            7 if kind == Kind::Speeds => {
                let (v, u) = (1 + dice.below(70), 1 + dice.below(20));
                let ms = 20 + dice.below(200);
                format!("MoveSpeed X, {v}mm/s\nMoveSpeed Y, -{u}mm/s\nWait {ms}ms\nStopAll\n")
            }
            _ => format!(
                "START MoveAxe X, {}mm\nSTART MoveAxe Y, {}mm, {}mm/s\nWait {}ms\n\
                 START MoveAxe X, {}mm\nWaitMove\n",
                mm(dice, 40, 100),
                mm(dice, 40, 90),
                2 + dice.below(50),
                dice.below(400),
                mm(dice, 40, 100)
            ),
        };
    }
    text
}

/// Presses Stop now and then, and turns at the override.
fn disturb(lab: &mut Lab, dice: &mut Dice, large: bool) {
    for _ in 0..dice.below(4) {
        lab.board.run_us(dice.below(2_500_000));
        if lab.is_done() {
            return;
        }
        if large && dice.below(2) == 0 {
            let (register, percent) = (dice.below(2) as u16, 10 + dice.below(90) as u16);
            assert!(lab.write(OVERRIDES + register, percent));
            continue;
        }
        lab.press(false, 20 + dice.below(60));
        lab.settle(100);
        if lab.is_done() {
            return;
        }
        lab.press(true, PRESS_MS);
    }
}

fn plays(build: &Build, number: u64) {
    let mut dice = Dice(number << 8 | u64::from(build.part.look_ahead));
    let large = build.part == F5529.part;
    let name = ["mill", "charly"][dice.below(2) as usize];
    let profile = Profile::built_in(name).expect("a profile");
    let down = if name == "mill" { "-" } else { "" };
    let kind = [Kind::Moves, Kind::Moves, Kind::Seeks, Kind::Speeds][dice.below(4) as usize];
    let script = script(&mut dice, kind, large, down);
    println!("{number} on {}, {name}:\n{script}", build.part.name);
    let mut lab = Lab::new(build, &profile, &script);
    let plant = lab.board.plant_mut();
    for (axis, own) in profile.axes() {
        let (axis, side) = (axis.index(), i64::from(own.home.direction.sign()));
        plant.switches[axis] = Some(Contact { axis, position: side * 300, above: side > 0 });
    }
    // What the probe meets on its way in Y.
    plant.probes[1] = Some(Contact { axis: 1, position: 6_500, above: true });
    lab.play(|lab| disturb(lab, &mut dice, large));
}

#[test]
fn generated_moves_are_what_motors_and_drivers_follow() {
    for number in 0..6 {
        plays(&G2553, number);
        plays(&F5529, number);
    }
}

#[test]
#[ignore = "minutes: the long form"]
fn generated_moves_in_great_number_are_what_motors_and_drivers_follow() {
    for number in 100..400 {
        plays(&G2553, number);
        plays(&F5529, number);
    }
}
