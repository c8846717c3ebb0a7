//! The profile in the making, without a board.

use lang::profile::Profile;
use proptest::prelude::*;
use serde_json::json;

use super::{Setup, choices, pins, steps};

fn open(folder: &tempfile::TempDir, base: Option<&str>) -> Result<Setup, String> {
    Setup::open(folder.path(), "bench", base)
}

#[test]
fn a_set_up_is_left_and_taken_up_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut setup = open(&folder, Some("mill")).expect("it begins");
    setup.change(&json!({ "x": { "invert": true } })).expect("a profile");
    setup.done("direction_x", "right").expect("a step");
    assert!(setup.done("direction_a", "right").is_err(), "no such axis");
    drop(setup);
    assert_eq!(choices(folder.path())["begun"], json!(["bench"]));
    let mut setup = open(&folder, None).expect("it goes on");
    assert!(setup.profile().x.as_ref().is_some_and(|x| x.invert));
    let step = |setup: &Setup, id: &str| {
        let shown = setup.shown();
        let list = shown["steps"].as_array().expect("steps").clone();
        let found = list.into_iter().find(|step| step["id"] == id).expect("the step");
        (found["done"] == true, found["stale"] == true)
    };
    assert_eq!(step(&setup, "direction_x"), (true, false));
    // What it was tried with changed: it is to be tried again.
    setup.change(&json!({ "x": { "invert": false } })).expect("a profile");
    assert_eq!(step(&setup, "direction_x"), (false, true));
    // Nothing is written before the board has the machine.
    assert!(
        setup.finish("today", true).expect_err("not applied").contains("bring it to the board")
    );
    let profile = setup.profile().clone();
    setup.applied(profile.clone());
    setup.done("outputs", "<b>spindle</b> & lamp").expect("a step");
    let error = setup.finish("today", false).expect_err("no emergency stop");
    assert!(error.contains("emergency stop was not tried"), "{error}");
    setup.finish("23 November", true).expect("it is written");
    let text = std::fs::read_to_string(folder.path().join("bench.toml")).expect("a file");
    assert_eq!(Profile::parse(&text), Ok(profile));
    let report =
        std::fs::read_to_string(folder.path().join("bench.report.html")).expect("a report");
    assert!(report.contains("&lt;b&gt;spindle&lt;/b&gt; &amp; lamp"), "{report}");
    assert!(report.contains("not tried") && report.contains("P2.0, P2.1, P2.4"), "{report}");
    // A file that somebody else changed is not written over.
    std::fs::write(folder.path().join("bench.toml"), "mine").expect("a file");
    assert!(setup.finish("today", true).expect_err("changed").contains("another program"));
    assert_eq!(std::fs::read_to_string(folder.path().join("bench.toml")).expect("a file"), "mine");
}

#[test]
fn what_is_wrong_is_told_and_changes_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["", "mill", "../a", "a b", "a.toml", "\u{e9}"] {
        assert!(Setup::open(folder.path(), name, None).is_err(), "{name}");
    }
    assert!(open(&folder, Some("../../etc/passwd")).is_err());
    std::fs::write(folder.path().join("bench.setup.json"), "{}").expect("a file");
    assert!(open(&folder, None).expect_err("no state").contains("bench.setup.json"));
    std::fs::remove_file(folder.path().join("bench.setup.json")).expect("it goes");
    let mut setup = open(&folder, None).expect("it begins");
    let before = setup.profile().clone();
    for patch in [
        json!(null),
        json!([]),
        json!({ "x": null, "y": null, "z": null }),
        json!({ "name": "other" }),
        json!({ "x": { "top_rate": 1_000_000 } }),
        json!({ "x": { "surprise": 1 } }),
        json!({ "link": { "rate": 1 } }),
        json!({ "input": [{ "n": 1, "role": "probe" }, { "n": 2, "role": "probe" }] }),
        json!({ "output": [{ "n": 99 }] }),
    ] {
        assert!(setup.change(&patch).is_err(), "{patch}");
        assert_eq!(setup.profile(), &before, "{patch}");
    }
    for (asked, measured) in [(0, 0), (100_000, -100_000), (100_000, 5_000), (i64::MAX, i64::MIN)] {
        assert!(setup.scale('X', asked, measured).is_err(), "{asked} {measured}");
    }
    assert!(setup.scale('W', 100_000, 99_000).is_err());
    assert_eq!(setup.profile(), &before);
    let words = setup.scale('X', 100_000, 98_700).expect("a scale");
    assert_eq!(words, "asked 100 mm, measured 98.7 mm: 101.317 steps per mm instead of 100.000");
}

#[test]
fn pins_come_from_the_manual() {
    for (chip, heading) in pins::chips() {
        for wiring in [lang::profile::Wiring::Direct, lang::profile::Wiring::Chain] {
            let rows = pins::table(heading, wiring);
            assert!(rows.len() >= 9, "{chip}: {rows:?}");
            assert!(
                rows.iter().any(|[_, words]| words.contains("STEP X, Y, Z")),
                "{chip}: {rows:?}"
            );
            assert!(!rows.iter().any(|[_, words]| words == "the same"), "{chip}");
        }
    }
}

proptest! {
    #[test]
    fn a_measured_scale_is_nearly_exact(asked in 1_000i64..2_000_000, part in 700i64..1_400) {
        let mill = Profile::built_in("mill").expect("built in");
        let measured = asked * part / 1000;
        prop_assume!((1_000..=2_000_000).contains(&measured));
        let (next, _) = steps::scaled(&mill, 'X', asked, measured).expect("a scale");
        let scale = next.x.expect("X").scale;
        let wanted = 0.1 * asked as f64 / measured as f64;
        let got = f64::from(scale.steps) / f64::from(scale.um);
        prop_assert!((got / wanted - 1.0).abs() < 1e-4, "{got} {wanted}");
    }
}
