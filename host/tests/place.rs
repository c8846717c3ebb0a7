//! `pasapas place` as a user has it: a board of 60 parts from KiCad's list to a job that runs alike on the
//! simulator and on the emulated F5529.

mod common;

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;

use common::{pasapas, text};

/// A board of 60 parts and three marks, as KiCad 8 lists it.
fn board() -> String {
    let mut list = "### Footprint positions - created on 2026-01-01T10:00:00 ###\n\
                    ### Printed by KiCad version 8.0.4\n## Unit = mm, Angle = deg.\n## Side : All\n\
                    # Ref     Val           Package                PosX       PosY       Rot  Side\n"
        .to_owned();
    for n in 0..60 {
        let (letter, value, package) = match n % 3 {
            0 => ('R', "10k", "R_0603"),
            1 => ('C', "100n", "C_0402"),
            _ => ('U', "ATtiny85", "SOIC-8"),
        };
        let (x, y) = (f64::from(n % 10) * 4.0 + 2.0, f64::from(n / 10) * 5.0 + 2.5);
        writeln!(list, "{letter}{n}  {value}  {package}  {x:.4}  {y:.4}  90.0000  top")
            .expect("text");
    }
    for (n, x, y) in [(1, 0.0, 0.0), (2, 40.0, 0.0), (3, 0.0, 30.0)] {
        writeln!(list, "FID{n}  FID  Fiducial_1mm  {x:.4}  {y:.4}  0.0000  top").expect("text");
    }
    list + "## End\n"
}

const FEEDERS: &str = "clearance = 0\nboard = -30\nvacuum = 3\npick_ms = 50\ndrop_ms = 20\n
[[feeder]]\nname = \"R10k\"\nvalue = \"10k\"\npackage = \"R_0603*\"\nkind = \"strip\"\nfirst = [50, 160]
second = [54, 160]\ncount = 30\ntop = -29.5\nheight = 0.5\nturned = 90\n
[[feeder]]\nname = \"C100n\"\nvalue = \"100n\"\nkind = \"tape\"\nat = [60, 170]\ntop = -29\nheight = 0.5
turned = 90\nadvance = { output = 5, pulse_ms = 20 }\n
[[feeder]]\nname = \"tray\"\npackage = \"SOIC*\"\nkind = \"tray\"\nfirst = [100, 150]\ncolumns = 5\nrows = 4
pitch = [10, 8]\ntop = -28\nheight = 2\nturned = 0\n
[[rotation]]\npackage = \"SOIC-8*\"\nadd = 270\n";

fn write(folder: &Path, name: &str, content: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, content).expect("a file");
    text(&path).to_owned()
}

#[test]
fn a_board_of_60_parts_becomes_a_job_that_runs_alike_on_both_engines() {
    let folder = tempfile::tempdir().expect("a folder");
    let list = write(folder.path(), "board.pos", &board());
    let feeders = write(folder.path(), "feeders.toml", FEEDERS);
    let job = text(&folder.path().join("job.bas")).to_owned();
    let marks = ["--at", "FID1=100,50", "--at", "FID2=140,50.4", "--at", "FID3=99.7,80"];
    let args = [&["place", &list, "--feeders", &feeders, "-o", &job][..], &marks].concat();
    let (code, said) = pasapas(&args);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("60 parts, way ") && said.contains("FID3 is "), "{said}");
    let angle = "the board lies turned by 0.6 degrees, and parts up to 0.6 degrees off their angle";
    assert!(said.contains(angle), "{said}");
    let (code, said) = pasapas(&["check", &job]);
    assert_eq!(code, 0, "{said}");
    let (code, said) = pasapas(&["sim", &job, "--engine", "vm", "--part", "f5529"]);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("the board is done"), "{said}");
    assert!(said.contains("on 60 times") && said.contains("on 20 times"), "{said}");
    // The emulated chip takes its time: a few of them.
    let (code, said) = pasapas(&[&args[..], &["--only", "R0,C1,U2,R3"]].concat());
    assert_eq!(code, 0, "{said}");
    let mut ends = Vec::new();
    for engine in ["vm", "board"] {
        let (code, said) = pasapas(&["sim", &job, "--engine", engine, "--part", "f5529"]);
        assert_eq!(code, 0, "{said}");
        assert!(said.contains("the board is done"), "{said}");
        assert!(said.contains("on 4 times"), "{said}");
        let ways: Vec<&str> = said.lines().filter(|line| line.contains("travelled")).collect();
        ends.push(ways.join("\n"));
    }
    assert_eq!(ends[0], ends[1]);
}

/// Where Z counts downward every height is the same number with the other sign.
#[test]
fn parts_are_laid_down_from_above_whichever_way_z_counts() {
    let folder = tempfile::tempdir().expect("a folder");
    let list = write(folder.path(), "board.pos", &board());
    let [job, trace] =
        ["job.bas", "run.trace"].map(|name| text(&folder.path().join(name)).to_owned());
    let mill = include_str!("../../examples/profiles/mill.toml");
    let (rest, z) = mill.split_once("[z]").expect("a Z");
    let z =
        z.replacen("min_um = -80000", "min_um = 0", 1).replacen("max_um = 0", "max_um = 80000", 1);
    let down = format!("{rest}[z]{}", z.replacen("positive", "negative", 1))
        .replace("\"mill\"", "\"down\"");
    let down = write(folder.path(), "down.toml", &down);
    let heights = |profile: &str, feeders: &str| -> BTreeSet<i64> {
        let feeders = write(folder.path(), "feeders.toml", feeders);
        let marks = ["--at", "FID1=100,50", "--at", "FID2=140,50", "--only", "R0,C1,U2"];
        let args = ["place", &list, "--feeders", &feeders, "--profile", profile, "-o", &job];
        let (code, said) = pasapas(&[&args[..], &marks].concat());
        assert_eq!(code, 0, "{said}");
        let (code, said) = pasapas(&["sim", &job, "--profile", profile, "--trace", &trace]);
        assert_eq!(code, 0, "{said}");
        let lines = std::fs::read_to_string(&trace).expect("a trace");
        let event = |line: &str| serde_json::from_str::<serde_json::Value>(line).expect("an event");
        lines.lines().filter_map(|line| event(line)["to"]["Z"].as_i64()).collect()
    };
    let up = heights("mill", FEEDERS);
    assert_eq!(up, BTreeSet::from([0, -2950, -2900, -2800]));
    let downward = FEEDERS.replace("= -", "= ");
    assert_eq!(heights(&down, &downward), up.iter().map(|z| -z).collect());
    // Written as for a machine that counts upward, it would be driven through the board.
    let feeders =
        write(folder.path(), "feeders.toml", &downward.replace("clearance = 0", "clearance = 60"));
    let (code, said) =
        pasapas(&["place", &list, "--feeders", &feeders, "--profile", &down, "-o", &job]);
    assert!(matches!(code, 1 | 2) && said.contains("counts downward"), "{said}");
}

#[test]
fn what_cannot_be_placed_is_named_with_its_remedy_and_nothing_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let list = write(folder.path(), "board.pos", &board());
    let job = folder.path().join("job.bas");
    let bom = write(folder.path(), "bom.csv", "Reference,Value\nR0,10k\nR99,1k\n");
    for (from, to, more, words) in [
        ("R_0603*", "R_0805*", &[][..], "R0 (R_0603, 10k) has no feeder"),
        ("add = 270", "add = 0", &[], "is to lie at 90 degrees, its feeder gives 0"),
        ("clearance", "clearence", &[], "no key `clearence` here"),
        ("", "", &["--at", "FID1=0,0", "--at", "FID2=39,0"], "wrong point, or wrong unit?"),
        (
            "",
            "",
            &["--at", "FID1=100,50", "--at", "FID2=139.945,52.093"],
            "the board lies turned by 3.0 degrees: lay it straight, within 2 degrees",
        ),
        ("", "", &["--at", "FID9=0,0"], "no part is called FID9"),
        ("", "", &["--at", "FID1=280,0"], "outside the travel"),
        ("", "", &["--skip", "R1000"], "no part is called R1000"),
        ("", "", &["--bom", bom.as_str()], "R99 is in no placement file"),
        ("", "", &["--side", "bottom"], "no part is left to place"),
    ] {
        let feeders = write(folder.path(), "feeders.toml", &FEEDERS.replacen(from, to, 1));
        let args = ["place", &list, "--feeders", &feeders, "-o", text(&job)];
        let (code, said) = pasapas(&[&args[..], more].concat());
        assert!(matches!(code, 1 | 2), "{words}: {code} {said}");
        assert!(said.contains(words), "{words}: {said}");
        assert!(!job.exists(), "{words}");
    }
    let feeders = write(folder.path(), "feeders.toml", FEEDERS);
    let (code, said) = pasapas(&["place", &list, "--feeders", &feeders, "-o", &feeders]);
    assert_eq!(code, 2, "{said}");
    assert_eq!(std::fs::read_to_string(&feeders).expect("it is there"), FEEDERS);
}
