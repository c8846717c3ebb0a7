//! `pasapas engrave` as a user has it: a drawing and a picture to jobs that run on the simulator, on two
//! machines.

mod common;

use common::{pasapas, text};

/// A picture of 16 x 8: its left half is dark.
const PICTURE: &[u8] = include_bytes!("../shop/src/engrave/data/grey.jpg");
const DRAWING: &str = "<svg xmlns='http://www.w3.org/2000/svg' width='20' height='10'>\
    <rect x='1' y='1' width='4' height='2'/></svg>";

#[test]
fn pictures_and_drawings_become_jobs_that_run_on_two_machines() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| text(&folder.path().join(name)).to_owned();
    std::fs::write(at("a.jpg"), PICTURE).expect("a file");
    std::fs::write(at("a.svg"), DRAWING).expect("a file");
    let mill = lang::profile::BUILT_IN[0].1;
    let laser = mill.replacen("role = \"spindle\"", "role = \"laser\"", 1);
    let laser = laser.replacen("name = \"mill\"", "name = \"burner\"", 1);
    std::fs::write(at("burner.toml"), laser).expect("a file");
    for profile in ["laser".to_owned(), at("burner.toml")] {
        for (name, job, more) in [
            ("a.jpg", "a.bas", &["--dither", "none", "--lines", "2"][..]),
            ("a.jpg", "a.nc", &["--lines", "1", "--one-way", "--feed", "1200"]),
            ("a.svg", "b.bas", &["--trace"]),
        ] {
            let args =
                ["engrave", &at(name), "--size", "16mm", "-o", &at(job), "--profile", &profile];
            let (code, said) = pasapas(&[&args[..], more].concat());
            assert_eq!(code, 0, "{said}");
            assert!(said.contains(" m burnt, "), "{said}");
            let (code, said) = pasapas(&["sim", &at(job), "--profile", &profile]);
            assert_eq!(code, 0, "{job} {profile}: {said}");
        }
    }
}

#[test]
fn what_cannot_be_burnt_is_told_with_its_remedy_and_nothing_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| text(&folder.path().join(name)).to_owned();
    std::fs::write(at("a.jpg"), PICTURE).expect("a file");
    std::fs::write(at("cut.jpg"), &PICTURE[..100]).expect("a file");
    std::fs::write(at("a.svg"), DRAWING).expect("a file");
    std::fs::write(at("none.svg"), DRAWING.replace("rect", "text")).expect("a file");
    for (name, more, words) in [
        ("cut.jpg", &["--size", "16mm"][..], "cut.jpg:1:1: error[X036]: the JPEG cannot be read"),
        ("none.svg", &["--size", "16mm", "--trace"], "an SVG without paths\n  hint: "),
        ("a.svg", &["--size", "16mm"], "--trace follows its paths"),
        ("a.jpg", &["--size", "16mm", "--trace"], "this is none"),
        ("a.jpg", &["--size", "-5mm"], "is no size"),
        ("a.jpg", &[], "--size"),
        ("a.jpg", &["--size", "400mm"], "X goes from"),
        ("a.jpg", &["--size", "16mm", "--profile", "mill"], "the machine mill has no laser"),
        ("a.jpg", &["--size", "16mm", "--power", "2000"], "S1000 is full power"),
    ] {
        let (code, said) =
            pasapas(&[&["engrave", &at(name), "-o", &at("job.bas")][..], more].concat());
        assert!(matches!(code, 1 | 2), "{words}: {code} {said}");
        assert!(said.contains(words), "{words}: {said}");
        assert!(!folder.path().join("job.bas").exists(), "{words}");
    }
}
