//! Paths with slow points: as fast as the whole path allows, whatever comes between.

use std::time::Duration;

use lang::profile::Profile;
use pasapas::bench::stand::{Stand, gate, image_for};
use pasapas::board::VIRTUAL;
use pasapas::plan;

/// Paths, the seconds that they take at best, and how many times as many the board may take.
const PATHS: [(&str, f64, f64); 3] = [
    (
        "DIM i\nG0 X0\nSetOut 1, ON\nG91\nF3000\nFOR i = 1 TO 500\nG1 X0.2\nNEXT\nSetOut 1, OFF",
        2.17,
        1.03,
    ),
    (
        "DIM i\nG0 X0\nSetOut 1, ON\nG91\nF1500\nFOR i = 1 TO 1000\nG1 X0.1\nNEXT\nSetOut 1, OFF",
        4.07,
        1.03,
    ),
    (
        "DIM i\nG0 X0 Y0\nSetOut 1, ON\nF3000\nFOR i = 1 TO 50\nG1 X[i * 0.4mm]\nNEXT\n\
         FOR i = 1 TO 50\nG1 Y[i * 0.4mm]\nNEXT\nSetOut 1, OFF",
        1.2,
        1.1,
    ),
];

fn seconds(text: &str, rest: Duration) -> f64 {
    let mill = Profile::built_in("mill").expect("the mill");
    let (program, _) = image_for(&mill, text).expect("a script");
    let compiled = lang::back::compile(&program).expect("it fits");
    let bytes = compiled.image.len();
    let image = plan::fitted(&program, compiled, VIRTUAL.part.features, 3_000).image;
    assert!(image.len() > bytes, "it has slow points");
    let mut stand = Stand::on(&VIRTUAL, &mill).expect("a board");
    stand.upload(&image).expect("an upload");
    let edges = stand.run_asking(Duration::from_secs(60), rest).expect("it runs and is judged");
    gate(&edges).expect("output 1") as f64 / 16e6
}

#[test]
fn a_path_of_short_blocks_takes_what_the_whole_path_allows() {
    for (text, best, times) in PATHS {
        let seconds = seconds(text, Duration::from_millis(50));
        assert!(seconds < best * times, "{seconds} s where {best} are possible: {text}");
    }
}

#[test]
fn a_host_that_asks_all_the_while_takes_no_step() {
    for (text, best, times) in PATHS {
        let seconds = seconds(text, Duration::from_millis(1));
        assert!(seconds < best * times * 1.05, "{seconds} s where {best} are possible: {text}");
    }
}
