//! Lines of paths on the G2553 come in time, whatever is computed between them and whatever a host asks: the path is slow then, and
//! never ends in a fault.

use std::time::Duration;

use emulator::{Edge, Rng, Signal, TICKS_PER_SECOND};
use lang::profile::{BUILT_IN, Profile};
use pasapas::bench::stand::{Stand, image_on};
use pasapas::board::{Build, F5529, G2553};

/// The mill with 400 steps/mm, these rates and no end of travel.
fn mill(start: u64, accel: u64, top: u64) -> Profile {
    let text = BUILT_IN[0]
        .1
        .replace("scale = { steps = 400, um = 4000 }", "scale = { steps = 400, um = 1000 }")
        .replace("start_rate = 400", &format!("start_rate = {start}"))
        .replace("accel = 25000", &format!("accel = {accel}"))
        .replace("top_rate = 8000", &format!("top_rate = {top}"))
        .replace("min_um = 0", "min_um = -9000000")
        .replace("max_um = 300000", "max_um = 9000000")
        .replace("max_um = 200000", "max_um = 9000000")
        .replace("min_um = -80000", "min_um = -9000000");
    Profile::parse(&text).expect("a profile")
}

/// A run while a host asks again `rest` after each answer.
fn run(build: &Build, profile: &Profile, text: &str, rest: Duration) -> Result<Vec<Edge>, String> {
    let (_, image) = image_on(&build.part, profile, text)?;
    let mut stand = Stand::on(build, profile)?;
    stand.rig().borrow_mut().board().plant_mut().switches = [None; 3];
    stand.upload(&image)?;
    stand.run_asking(Duration::from_secs(60), rest)
}

const ASKS: Duration = Duration::from_millis(2);

fn comes_in_time(profile: &Profile, text: &str) {
    match run(&G2553, profile, text, ASKS) {
        // What the judge says of ramps is for other tests.
        Err(error) if error.contains("fault") || error.contains("not end") => {
            panic!("{error}\n{text}")
        }
        _ => {}
    }
}

#[test]
fn whatever_is_computed_and_however_fast_the_axes_are() {
    let mut rng = Rng::new(34);
    let mut one = |from: &[u64]| from[rng.below(from.len() as u64) as usize];
    for _ in 0..16 {
        let top = one(&[4_000, 8_000, 20_000, 30_000, 45_000, 60_000]);
        let profile = mill(one(&[1, 100, 400, 1_000]), top * one(&[2, 4, 16]), top);
        let ms = one(&[4, 5, 7, 9, 14, 20, 35, 60]);
        let um = (top * ms * 1_000 / 400_000).max(3);
        let count = (400 / ms).max(8);
        let feed = top * 60 / 400 * one(&[5, 10, 17]) / 10;
        let parts = [um, um * one(&[100, 93, 50]) / 100, um * one(&[100, 87, 20]) / 100];
        let axes = one(&[1, 2, 3]) as usize;
        let thought = match one(&[0, 1, 2, 3]) {
            0 => String::new(),
            1 => format!("FOR k = 1 TO {}\nNEXT\n", one(&[130, 260, 400, 800, 2_500, 10_000])),
            2 => "j = SQR(i * 1000000)\n".repeat(one(&[1, 2, 4]) as usize),
            _ => "j = 1000000 / i MOD 7\n".repeat(one(&[2, 6]) as usize),
        };
        let words: String =
            (0..axes).map(|n| format!(" {}[i * {}um]", ["X", "Y", "Z"][n], parts[n])).collect();
        comes_in_time(
            &profile,
            &format!(
                "DIM i, j, k\nG0 X0 Y0 Z0\nF{feed}\nFOR i = 1 TO {count}\n{thought}G1{words}\nNEXT\n"
            ),
        );
    }
}

#[test]
fn a_delay_between_two_lines_and_three_axes_at_the_top_rate() {
    let built_in = Profile::built_in("mill").expect("one");
    comes_in_time(
        &built_in,
        "DIM i, k\nG0 X0 Y0\nF3000\nFOR i = 1 TO 12\nFOR k = 1 TO 1500\nNEXT\n\
                              G1 X[i * 2mm] Y[(i MOD 2) * 0.2mm]\nNEXT\n",
    );
    for um in [2_100, 5_250] {
        let line = |n: u64| {
            format!(
                "G1 X{:.3} Y{:.3} Z-{:.3}\n",
                (n * um) as f64 / 1e3,
                (n * um * 93 / 100) as f64 / 1e3,
                (n * um * 87 / 100) as f64 / 1e3
            )
        };
        let text: String = (1..=20).map(line).collect();
        comes_in_time(&mill(400, 300_000, 60_000), &format!("G0 X0 Y0 Z0\nF18000\n{text}"));
    }
}

/// Times from one change of output 3 to the next, s.
fn passes(edges: &[Edge]) -> Vec<f64> {
    let changes: Vec<u64> =
        edges.iter().filter(|edge| edge.signal == Signal::Out(3)).map(|edge| edge.cycle).collect();
    changes.windows(2).map(|two| (two[1] - two[0]) as f64 / TICKS_PER_SECOND as f64).collect()
}

#[test]
fn each_path_has_its_slow_points_whatever_stands_between_them() {
    let profile = Profile::built_in("mill").expect("one");
    let path = |back: bool| -> String {
        let at = |n: u32| if back { 30 - n } else { n };
        (1..=30)
            .map(|n| {
                format!("G1 X{:.1} Y{:.1}\n", 0.5 * f64::from(at(n)), f64::from(at(n) % 3) / 10.0)
            })
            .collect()
    };
    for between in ["", "Wait 0ms\n", "PRINT 1\n"] {
        let mut text = String::from("G0 X0 Y0\nF1200\nSetOut 3, ON\n");
        for n in 0..4 {
            text += &path(n % 2 == 1);
            text += between;
            text += if n % 2 == 0 { "SetOut 3, OFF\n" } else { "SetOut 3, ON\n" };
        }
        // The end of the run switches the output, too: not at once after the last path, or its edge is not seen.
        text += "Wait 20ms\n";
        let edges = run(&G2553, &profile, &text, Duration::from_millis(50)).expect("it runs");
        let passes: Vec<f64> = passes(&edges).into_iter().filter(|own| *own > 0.5).collect();
        assert_eq!(passes.len(), 4, "{between}{passes:?}");
        let (least, most) = passes
            .iter()
            .fold((f64::MAX, 0.0), |(least, most), own| (own.min(least), own.max(most)));
        assert!(most < 1.15 * least, "{between}{passes:?}");
    }
}

#[test]
fn a_line_below_half_a_step_takes_nothing_from_the_next_path() {
    let profile = Profile::built_in("mill").expect("one");
    let time = |small: bool| {
        let mut text = String::from("G0 X0 Y0\nF1200\nSetOut 3, ON\n");
        for n in 1..=60_u32 {
            text += &format!("G1 X{:.1} Y{:.1}\n", 0.5 * f64::from(n), f64::from(n % 3) / 10.0);
            if small && n % 12 == 0 {
                text += &format!("G1 X{:.3}\n", 0.5 * f64::from(n) + 0.001);
            }
        }
        let edges = run(&G2553, &profile, &(text + "SetOut 3, OFF\n"), Duration::from_millis(50));
        passes(&edges.expect("it runs"))[0]
    };
    let (with, without) = (time(true), time(false));
    // Each of them is a rest.
    assert!(with < without + 5.0 * 0.12, "{with} {without}");
}

#[test]
fn a_long_step_of_one_axis_leaves_the_others_their_speed() {
    let text = BUILT_IN[0].1;
    for (steps, um) in [(2, 1_000), (10, 1_000), (25, 1_000)] {
        let (before, y) = text.split_once("[y]").expect("an axis");
        let y = y.replacen(
            "scale = { steps = 400, um = 4000 }",
            &format!("scale = {{ steps = {steps}, um = {um} }}"),
            1,
        );
        let profile = Profile::parse(&format!("{before}[y]{y}")).expect("a profile");
        let lines: String = (1..=60_u32)
            .map(|n| format!("G1 X{:.2} Y{:.3}\n", 0.2 * f64::from(n), 0.02 * f64::from(n)))
            .collect();
        for build in [&F5529, &G2553] {
            let made = run(
                build,
                &profile,
                &format!("G0 X0 Y0\nF3000\n{lines}"),
                Duration::from_millis(50),
            );
            assert!(made.is_ok(), "{steps} {}: {:?}", build.part.name, made.err());
        }
    }
}
