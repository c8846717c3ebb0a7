use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::profile::Profile;

use super::Placed;
use super::feeders::{Feeders, like};
use super::frame::{Mark, onto};
use super::job::{order, script};

const FEEDERS: &str = r#"
clearance = 0
board = -30
vacuum = 3
sensor = 16
discard = [10, 10]

[[feeder]]
name = "R10k"
value = "10k"
package = "R_0603*"
kind = "strip"
first = [50, 160]
second = [54, 160]
count = 20
top = -29.5
height = 0.5

[[feeder]]
name = "C100n"
value = "100n"
package = "C_0402*"
kind = "tape"
at = [60, 170]
top = -29
height = 0.5
advance = { output = 5, pulse_ms = 80 }

[[feeder]]
name = "tray"
package = "SOIC*"
kind = "tray"
first = [100, 150]
columns = 3
rows = 2
pitch = [10, 12]
top = -28
height = 2
turned = 90

[[rotation]]
package = "SOIC-8*"
add = 270
"#;

fn mill() -> Profile {
    Profile::built_in("mill").expect("built in")
}

fn feeders(text: &str) -> Result<Feeders, String> {
    Feeders::parse(text, &mill()).map_err(|wrong| {
        let hint = if wrong.hint.is_empty() { String::new() } else { format!("; {}", wrong.hint) };
        format!("{}: {}{hint}", wrong.at.0, wrong.text)
    })
}

fn some(count: usize) -> Vec<Placed> {
    let part = |n: usize| Placed {
        name: format!("R{n}"),
        what: "10k, \"R_0603\"".to_owned(),
        at: [(n as i64 * 7300) % 180_000, (n as i64 * 11_700) % 140_000],
        turned: 0.0,
        feeder: n % 3,
    };
    (0..count).map(part).collect()
}

fn image(parts: usize) -> Vec<u8> {
    let feeders = feeders(FEEDERS).expect("good");
    let text = script(&order(some(parts), &feeders), &feeders, &mill(), "a.pos").expect("good");
    let source = Source::new("job", text.clone());
    let (program, found) = compile(&source, ProfileChoice::built_in());
    let errors: Vec<String> = found.into_sorted().iter().map(|d| d.message.clone()).collect();
    let program = program.unwrap_or_else(|| panic!("{errors:?}\n{text}"));
    lang::back::compile(&program).expect("it fits").image
}

#[test]
fn a_job_compiles_and_is_small() {
    let (sixty, more) = (image(60).len(), image(400).len());
    assert!(sixty < 1_200 && more < 3_072, "{sixty} {more}");
    // 2 000 parts in 12 KB.
    assert!(image(2_000).len() < 12_288);
}

#[test]
fn low_parts_come_first_and_then_the_nearest() {
    let feeders = feeders(FEEDERS).expect("good");
    let ordered = order(some(30), &feeders);
    let heights: Vec<f64> = ordered.iter().map(|p| feeders.feeders[p.feeder].height).collect();
    assert!(heights.is_sorted());
    assert_eq!((ordered.len(), ordered[0].name.as_str()), (30, "R0"));
}

#[test]
fn feeders_fit_by_pattern_and_what_is_wrong_is_told_where_it_stands() {
    let good = feeders(FEEDERS).expect("good");
    assert_eq!(good.fitting("10k", "R_0603_1608Metric"), [0]);
    assert_eq!(good.fitting("ATtiny", "SOIC-8_3.9x4.9mm"), [2]);
    assert!(good.fitting("1k", "R_0603").is_empty());
    assert_eq!([good.rotation("SOIC-8_W"), good.rotation("R_0603")], [270.0, 0.0]);
    assert!(
        like("*", "")
            && like("a*c", "AbC")
            && !like("a*c", "ab")
            && like("x", "X")
            && !like("x", "xy")
    );
    for (from, to, words) in [
        (
            "board = -30",
            "board = -30\nturn = \"A\"",
            "4: turn = \"A\": the machine mill has no axis",
        ),
        ("count = 20", "cuont = 20", "there is no key `cuont` here; `count` is the nearest key"),
        ("vacuum = 3", "vacum = 3", "there is no key `vacum` here; `vacuum` is the nearest key"),
        (
            "kind = \"strip\"",
            "kind = \"stripe\"",
            "`stripe` is no word that stands here; `strip` is the nearest",
        ),
        (
            "pulse_ms = 80",
            "puls_ms = 80",
            "there is no key `puls_ms` here; `pulse_ms` is the nearest key",
        ),
        ("clearance = 0", "clearance = \"0\"", "expected f64; a line is `key = value`"),
        ("clearance = 0", "", "the key `clearance` is missing; add it"),
        ("count = 20\n", "", "R10k: a strip needs `count`"),
        ("second = [54, 160]", "second = [50, 160]", "the same place"),
        ("at = [60, 170]", "at = [60, 970]", "C100n: Y comes to 970"),
        ("top = -29.5", "top = 3", "R10k: top is 3"),
        ("vacuum = 3", "vacuum = \"pump\"", "no output is named `pump`"),
        ("sensor = 16", "sensor = 18", "inputs are 1 to 17"),
        ("output = 5, pulse_ms = 80", "axis = \"A\", deg = 36", "no axis that turns a tape"),
        ("clearance = 0", "clearance = -29", "reach above the clearance"),
    ] {
        let text = FEEDERS.replacen(from, to, 1);
        let told = feeders(&text).expect_err(to);
        assert!(told.contains(words), "{to}: {told}");
    }
}

#[test]
fn a_board_is_shifted_and_turned_and_a_wrong_point_is_refused() {
    let mark = |drawn: [i64; 2], taught: [i64; 2]| Mark { name: "FID".to_owned(), drawn, taught };
    let none = onto(&[]).expect("as it is");
    assert_eq!(none.place([5, 6]), [5, 6]);
    let shifted = onto(&[mark([3000, 3000], [103_000, 53_000])]).expect("shifted");
    assert_eq!(shifted.place([0, 0]), [100_000, 50_000]);
    let turned = onto(&[mark([0, 0], [100_000, 50_000]), mark([34_000, 0], [100_000, 84_000])])
        .expect("turned");
    assert_eq!(turned.place([10_000, 5000]), [95_000, 60_000]);
    assert!((turned.angle - 90.0).abs() < 1e-3);
    let far = onto(&[mark([0, 0], [0, 0]), mark([34_000, 0], [33_520, 0])]).expect_err("1.4 %");
    assert!(far.contains("34.000 mm in the file and 33.520 mm"), "{far}");
}

#[test]
fn the_manuals_file_is_a_good_one() {
    let page = include_str!("../../place.md");
    let piece = page.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next());
    let read = feeders(piece.expect("a file")).expect("good");
    assert_eq!((read.feeders.len(), read.rotations.len()), (2, 1));
}
