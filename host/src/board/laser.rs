//! Checks a laser's output at the board's pins: power over time, and dark whenever it must be.

use std::time::Duration;

use emulator::{Edge, Signal};
use lang::back;
use lang::profile::Profile;
use lang::record::{FULL_POWER, feature};

use crate::bench::code::program;
use crate::bench::stand::Stand;

/// Runs a script on the laser's board and gives the edges of its output.
fn beam(text: &str) -> Vec<Edge> {
    let laser = Profile::built_in("laser").expect("built in");
    let (_, compiled) = program("laser", &format!("PROFILE \"laser\"\n{text}")).expect("a script");
    let mut stand = Stand::new(&laser).expect("a board");
    stand.upload(&compiled.image).expect("stored");
    let mut edges = stand.run(Duration::from_secs(30)).expect("it ends");
    edges.retain(|edge| edge.signal == Signal::Out(1));
    edges
}

/// Milliseconds of light.
fn light(edges: &[Edge]) -> f64 {
    let pairs = edges.windows(2).filter(|pair| pair[0].level && !pair[1].level);
    pairs.map(|pair| (pair[1].cycle - pair[0].cycle) as f64).sum::<f64>() / 16_000.0
}

#[test]
fn power_is_the_part_of_the_time_that_the_beam_is_on() {
    // 20 mm at 10 mm/s: two seconds in motion, then a second of rest with M3 still on.
    for (power, wanted) in [(0, 0.0), (1, 2.0), (300, 600.0), (999, 1998.0), (1000, 2000.0)] {
        let edges = beam(&format!("F600 S{power}\nM3\nG1 X20\nWait 1s\nM5\n"));
        let light = light(&edges);
        assert!((light - wanted).abs() <= 0.02 * wanted + 8.0, "S{power}: {light} ms of light");
    }
    assert_eq!(FULL_POWER, 1000);
}

/// Short lines in quick succession keep the main loop busy for milliseconds at a time: the light of
/// one that came late is taken from the next.
#[test]
fn power_holds_while_the_board_is_busy() {
    // 200 lines of 0.1 mm at 20 mm/s: a second in motion.
    for (power, wanted) in [(100, 100.0), (300, 300.0), (700, 700.0)] {
        let text =
            format!("F1200 S{power}\nM3\nG91\nREPEAT 100\nG1 X0.1\nG1 Y0.1\nEND REPEAT\nM5\n");
        let edges = beam(&text);
        let all = beam(&text.replace(&format!("S{power}"), "S1000"));
        let (light, time) = (light(&edges), light(&all));
        println!("{power}: {light} of {time}");
        let wanted = wanted / 1000.0 * time;
        assert!((light - wanted).abs() <= 0.01 * wanted + 3.0, "S{power}: {light} of {time} ms");
    }
}

#[test]
fn each_line_has_the_power_that_stood_before_it() {
    // Lines of 200 ms that join one another: dark, full, dark; then a rapid move, dark by itself.
    let edges = beam("F600 S0\nM3\nG1 X2\nS1000\nG1 X4\nS0\nG1 X6\nS1000\nG0 X0\nM5\n");
    let times: Vec<u64> = edges.iter().map(|edge| edge.cycle / 16_000).collect();
    assert_eq!(times.len(), 2, "{times:?}");
    let long = times[1] - times[0];
    assert!((195..=210).contains(&long), "{long} ms of light");
}

#[test]
fn only_parts_with_the_feature_take_power() {
    let (_, graded) = program("a", "PROFILE \"laser\"\nM3 S500\n").expect("a script");
    let (_, plain) = program("a", "PROFILE \"laser\"\nM3\n").expect("a script");
    let (_, mill) = program("a", "M3 S500\n").expect("a script");
    let needs = |compiled: &back::Compiled| u16::from(compiled.image[1]) & feature::POWER != 0;
    assert_eq!([needs(&graded), needs(&plain), needs(&mill)], [true, false, false]);
    let image = lang::image::Image::new(&graded.image).expect("an image");
    let lack = lang::part::G2553.lacks(&image, 3).expect("no room for it");
    assert!(lack.to_string().contains("laser's power"), "{lack}");
    assert_eq!(lang::part::F5529.lacks(&image, 3), None);
}
