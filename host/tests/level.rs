//! `pasapas level` as a user has it: a surface is probed, and a job laid onto it, on two machines.

mod common;

use common::{pasapas, text};

const JOB: &str =
    "G21 G90\nG0 X10 Y10 Z-5\nG1 Z-11 F300\nX60 F600\nG2 X60 Y20 I0 J5\nG0 Z-5\nM30\n";
const HEIGHTS: &str = "x,y,z\n0,0,0\n100,0,1\n0,50,0.25\n100,50,1.25\n";

#[test]
fn a_job_on_its_heights_runs_on_two_machines() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| text(&folder.path().join(name)).to_owned();
    std::fs::write(at("heights.csv"), HEIGHTS).expect("a file");
    for (profile, depth) in [("mill", "-"), ("charly", "")] {
        std::fs::write(at("job.nc"), JOB.replace("Z-", &format!("Z{depth}"))).expect("a file");
        let args = ["level", &at("heights.csv"), &at("job.nc"), "-o", &at("out.nc")];
        let (code, said) = pasapas(&args);
        assert_eq!(code, 0, "{said}");
        assert!(said.contains("5 moves became") && said.contains("2 x 2 heights"), "{said}");
        let (code, said) = pasapas(&["sim", &at("out.nc"), "--profile", profile]);
        assert_eq!(code, 0, "{said}");
    }
}

#[test]
fn what_is_not_covered_is_told_with_its_remedy_and_nothing_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| text(&folder.path().join(name)).to_owned();
    std::fs::write(at("heights.csv"), HEIGHTS).expect("a file");
    std::fs::write(at("short.csv"), "x,y,z\n0,0,0\n100,0,1\n0,50,0.25\n").expect("a file");
    std::fs::write(at("job.nc"), JOB).expect("a file");
    std::fs::write(at("far.nc"), JOB.replace("X60", "X160")).expect("a file");
    for (heights, job, words) in [
        (
            "heights.csv",
            "far.nc",
            "far.nc:4:1: error[X038]: X 110 Y 10 lies outside of the heights",
        ),
        ("short.csv", "job.nc", "error[X037]: the grid has no height at X 100 Y 50"),
        ("job.nc", "job.nc", "is no height"),
    ] {
        let (code, said) = pasapas(&["level", &at(heights), &at(job), "-o", &at("out.nc")]);
        assert_eq!(code, 1, "{said}");
        assert!(said.contains(words), "{words}: {said}");
        assert!(!folder.path().join("out.nc").exists(), "{words}");
    }
    let (code, said) = pasapas(&["level", "--probe", "0,0,100", "-o", &at("probe.bas")]);
    assert_eq!(code, 2, "{said}");
    let (code, said) = pasapas(&[
        "level",
        "--probe",
        "0,0,100,50",
        "--lift=-5",
        "--deepest=-20",
        "-o",
        &at("probe.bas"),
    ]);
    assert_eq!(code, 0, "{said}");
    let (code, said) = pasapas(&["check", &at("probe.bas")]);
    assert_eq!(code, 0, "{said}");
}

/// From above the work's zero to below it, whichever way the machine counts.
#[test]
fn a_surface_is_probed_from_above_on_two_machines() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = text(&folder.path().join("probe.bas")).to_owned();
    for (profile, lift, deepest) in [("mill", "2mm", "-2mm"), ("charly", "-2mm", "2mm")] {
        let args = ["level", "--probe", "0,0,100,50", "--profile", profile, "-o", &out];
        let (code, said) = pasapas(&args);
        assert_eq!(code, 0, "{said}");
        let script = std::fs::read_to_string(&out).expect("a script");
        let heights = format!("CONST LIFT = {lift}\nCONST DEEPEST = {deepest}\n");
        assert!(script.contains(&heights), "{profile}: {script}");
        // The other way round it would be driven into the work.
        let wrong = [&args[..], &[&format!("--lift={deepest}"), &format!("--deepest={lift}")]];
        let (code, said) = pasapas(&wrong.concat());
        assert_eq!((code, said.contains("from the lift downward")), (2, true), "{said}");
    }
}
