//! Moves of machines drawn from the whole range that a profile may have: scales from 65 535 steps in a
//! micrometre to one in 65 mm, start rates from 1 step/s, ramps to 10 000 000 steps/s2, any top rate that
//! goes with the pulse width, any corner. What `lab` holds every test to is all that is asked.

use lang::part::Part;
use lang::profile::{Profile, Scale};
use pasapas::board::{Build, F5529, G2553};

use crate::lab::{Dice, Lab};

/// Longest way of an axis in a move, steps.
const LONGEST: i64 = 6_000;
/// Longest way that a profile may know, steps (`lang::profile`).
const FARTHEST: i64 = 1 << 30;

/// The most that a start rate and those of a reference run may be, steps/s (`lang::profile`).
const RATE: i32 = 65_535;

/// A number from `low` to `high`, each of its sizes as often as any other.
fn any(dice: &mut Dice, low: i64, high: i64) -> i64 {
    let span = (high - low + 1) as u64;
    let bits = dice.below(u64::from(span.ilog2()) + 1);
    low + dice.below((2u64 << bits).min(span)) as i64
}

/// A machine of any axes, of which none has a lower top than that, steps/s.
fn machine(dice: &mut Dice, part: &Part, slowest: i64) -> Profile {
    let mut profile = Profile::built_in("mill").expect("a profile");
    profile.pulse_us = any(dice, 2, 30) as u8;
    profile.dir_setup_us = any(dice, 1, 30) as u8;
    profile.corner_um = any(dice, 0, 10_000) as i32;
    let possible = i64::from(part.top_rate(profile.pulse_us, false));
    let scale = |dice: &mut Dice| Scale {
        steps: any(dice, 1, 65_535) as u16,
        um: any(dice, 1, 65_535) as u16,
    };
    // Every other machine has axes alike, as arcs want them.
    let alike = (dice.below(2) == 0).then(|| scale(dice));
    for axis in [&mut profile.x, &mut profile.y, &mut profile.z] {
        let own = axis.as_mut().expect("a mill has three");
        own.scale = alike.unwrap_or_else(|| scale(dice));
        own.top_rate = any(dice, slowest, possible) as i32;
        own.start_rate = any(dice, 1, own.top_rate.min(RATE).into()) as i32;
        own.accel = any(dice, 100, 10_000_000) as i32;
        own.decel = (dice.below(2) == 0).then(|| any(dice, 100, 10_000_000) as i32);
        own.invert = dice.below(2) == 0;
        let farthest = FARTHEST * i64::from(own.scale.um) / i64::from(own.scale.steps);
        own.max_um = farthest.min(10_000_000) as i32;
        own.min_um = -own.max_um;
        own.home.fast_rate = own.top_rate.min(RATE);
        own.home.slow_rate = own.start_rate.min(own.top_rate);
        own.home.stroke_um = own.max_um.max(1);
        own.home.position_um = 0;
        own.home.clearance_um = 0;
    }
    // What the checker refuses is no machine.
    Profile::parse(&text(&profile)).expect("the ranges of the checker")
}

fn text(profile: &Profile) -> String {
    toml::to_string(profile).expect("a profile is TOML")
}

/// Some moves of about a second each, in steps; arcs where the part and the scales are for them.
fn script(dice: &mut Dice, profile: &Profile, build: &Build) -> String {
    let mut text = String::new();
    let mut reach = [0; 3];
    for (axis, own) in profile.axes() {
        let ramp = own.accel.min(own.decel.unwrap_or(own.accel));
        let most = i64::from((own.top_rate / 2).min(ramp / 2));
        reach[axis.index()] = most.clamp(3, LONGEST);
    }
    let mut place = [0; 3];
    for _ in 0..3 + dice.below(4) {
        let mut to = place;
        for (place, reach) in to.iter_mut().zip(reach) {
            if dice.below(3) != 0 {
                *place = any(dice, 0, reach) * [1, -1][dice.below(2) as usize];
            }
        }
        let [x, y, z] = to;
        let words = format!("X[{x}st] Y[{y}st] Z[{z}st]");
        let scales = [&profile.x, &profile.y].map(|axis| axis.as_ref().map(|own| own.scale));
        // An arc is drawn to the micrometre: ten of them are its least radius here.
        let least = scales[0].map_or(0, |own| 10 * i64::from(own.steps / own.um)).max(20);
        match dice.below(if build.part.look_ahead { 4 } else { 3 }) {
            0 => {
                text += &format!("MoveAxe X, {x}st\n");
                to = [x, place[1], place[2]];
            }
            1 => text += &format!("G53 G0 {words}\n"),
            3 if scales[0] == scales[1] && least <= reach[0].min(reach[1]) => {
                let r = any(dice, least, reach[0].min(reach[1]));
                let (a, b) = (r, [r, -r][dice.below(2) as usize]);
                text += &format!(
                    "G91\nG2 X[{a}st] Y[{b}st] I[{a}st] F[{}st/s]\nG3 I[{r}st] J[0st]\nG90\n",
                    any(dice, r / 5, 60_000)
                );
                to = [place[0] + a, place[1] + b, place[2]];
            }
            _ => {
                let rate = any(dice, 1, 60_000);
                text += &format!("G53 G1 {words} F[{rate}st/s]\n");
            }
        }
        place = to;
    }
    text
}

/// A curve of short lines, in steps, with an edge here and there: most lines turn by less than 20 degrees and take
/// 6 to 40 ms at the feed.
fn curve(dice: &mut Dice, profile: &Profile, _: &Build) -> String {
    let rate = any(dice, 1, 60_000);
    let mut text = format!("G91\nF[{rate}st/s]\n");
    let [x, y, z] = [&profile.x, &profile.y, &profile.z].map(|own| {
        let own = own.as_ref().expect("a mill has three");
        (own.accel.min(own.decel.unwrap_or(own.accel)) / 8).clamp(3, 600)
    });
    let reach = f64::from(x.min(y));
    let (mut heading, mut left) = (0.0f64, [0i64; 3]);
    for _ in 0..20 + dice.below(30) {
        heading += match dice.below(12) {
            0 => dice.below(7) as f64,
            _ => (dice.below(200) as f64 - 100.0) / 300.0,
        };
        let length = (rate as f64 * (6 + dice.below(35)) as f64 / 1_000.0).clamp(1.0, reach);
        let down = if dice.below(3) == 0 { any(dice, 0, z.into()).min(length as i64) } else { 0 };
        let way = [
            (length * heading.cos()).round() as i64,
            (length * heading.sin()).round() as i64,
            -down,
        ];
        let [a, b, c] = way;
        text += &format!("G1 X[{a}st] Y[{b}st] Z[{c}st]\n");
        left = std::array::from_fn(|axis| left[axis] - way[axis]);
    }
    let [a, b, c] = left;
    text += &format!("G1 X[{a}st] Y[{b}st] Z[{c}st]\nG90\n");
    text
}

/// Of a curve, steps/s: at less it takes longer than a test waits.
const SLOWEST: i64 = 20;

/// Draws a script for a machine on a part.
type Draw = fn(&mut Dice, &Profile, &Build) -> String;

fn plays(build: &Build, number: u64, slowest: i64, draw: Draw) {
    let mut dice = Dice(0xA11 << 32 | number << 8 | u64::from(build.part.look_ahead));
    let profile = machine(&mut dice, &build.part, slowest);
    let script = draw(&mut dice, &profile, build);
    println!("{number} on {}:\n{}{script}", build.part.name, text(&profile));
    let mut lab = Lab::new(build, &profile, &script);
    // Nobody homes: no move may find a limit switch.
    lab.board.plant_mut().switches = [None; 3];
    lab.play(|_| {});
}

#[test]
fn machines_of_every_kind_move_as_their_profiles_say() {
    for number in 0..8 {
        plays(&G2553, number, 1, script);
        plays(&F5529, number, 1, script);
    }
}

#[test]
fn machines_of_every_kind_run_through_corners_as_their_profiles_say() {
    for number in 0..12 {
        plays(&G2553, number, SLOWEST, curve);
        plays(&F5529, number, SLOWEST, curve);
    }
}
