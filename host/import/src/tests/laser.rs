//! Laser files as LightBurn and other tools write them.

use super::{made, refused, shown};
use crate::{Format, Imported, Options, detect, import, is_importable};

/// A picture whose origin is its middle.
const CENTRED: &str = "; LightBurn 1.3.01\n; GRBL device profile, absolute coords\n\
    G00 G17 G40 G21 G54\nG90\nM4\nM8\nG0 X-20Y-28.288\nG1 X20S500F1000\nY30\nX-20\nM9\nG1 S0\nM5\nM2\n";

fn laser(name: &str, text: &str) -> Imported {
    import(name, text.as_bytes(), &Options::default())
        .unwrap_or_else(|diags| panic!("{}", shown(name, &diags)))
}

/// Most tools put the origin into the middle of the picture. Where it lies on the table is decided
/// by the work zero.
#[test]
fn a_picture_around_its_origin_goes_in_and_says_where_the_work_zero_may_lie() {
    made("a.gco", CENTRED);
    let told = shown("a.gco", &laser("a.gco", CENTRED).notes);
    let wanted = "note[X030]: Y goes from -28.288mm to 30mm; the travel of `laser` is 0mm to 200mm";
    assert!(told.contains(wanted), "{told}");
    assert!(told.contains("set the work zero between Y 28.288mm and 170mm"), "{told}");
    // One that lies on the table as it is says nothing.
    let told = shown("a.gco", &laser("a.gco", &CENTRED.replace('-', "")).notes);
    assert!(!told.contains("work zero"), "{told}");
}

#[test]
fn a_picture_larger_than_the_table_is_refused_once_for_each_axis() {
    let text = CENTRED.replace("X20S", "X290.5S").replace("X-20\n", "X300\nX-20\n");
    let told = refused("a.gco", &text);
    let errors: Vec<&str> = told.lines().filter(|line| line.contains("error")).collect();
    let wanted = "a.gco:8:1: error[X012]: the picture is wider in X than the table of `laser`: it goes from -20mm to 290.5mm";
    assert_eq!(errors, [wanted], "{told}");
}

/// A zero set on the way is a new origin: the ways before and after it do not add up.
#[test]
fn a_picture_that_sets_its_zero_on_the_way_is_measured_from_there() {
    let text = "; LightBurn\nG90\nM4 S0\nF1000\nG1 X200 S9\nG92 X0\nG1 X-200\nM5\n";
    made("a.gco", text);
}

/// LightBurn writes M4, and S in the first G1 only; air assist is M8.
#[test]
fn a_vector_file_of_lightburn_is_a_lasers() {
    for name in ["a.gc", "a.nc", "a.txt"] {
        assert!(is_importable(name, CENTRED.as_bytes()), "{name}");
        assert_eq!(detect(name, CENTRED), Some(Format::Laser), "{name}");
        let Imported { profile, notes, script, .. } = laser(name, CENTRED);
        assert_eq!(profile, "laser", "{name}");
        let told = shown(name, &notes);
        assert!(told.contains("warning[X021]: M7, M8 and M9"), "{told}");
        assert!(!script.contains("M8") && !script.contains("M9"), "{script}");
    }
    // A script that was made of one is none itself.
    let script = laser("a.gc", CENTRED).script;
    assert!(!is_importable("a.txt", script.as_bytes()), "{script}");
}

/// What `check` says of the script `import` says, too, however long the file is.
#[test]
fn a_long_file_is_refused_for_what_the_machine_lacks() {
    let body = "G1 X10 Y5\nG1 X5 Y10\n".repeat(20_000);
    let text = format!("G90\nG21\nF600\n{body}G2 X6 Y11 I1\nG1 X5 Y10\nM3\nM2\n");
    let mill = lang::profile::Profile::built_in("mill").expect("mill");
    let profile = lang::profile::Profile { outputs: Vec::new(), ..mill.clone() };
    let options = |profile| Options { profile: Some(profile), plain: true, ..Options::default() };
    let told = import("a.nc", text.as_bytes(), &options(profile)).expect_err("no spindle");
    let told = shown("a.nc", &told);
    let wanted = "a.nc:40006:1: error[X020]: the machine `mill` has no spindle output";
    assert!(told.contains(wanted), "{told}");
    assert!(import("a.nc", text.as_bytes(), &options(mill)).is_ok());
}

/// A file of several passes lowers the focus between them.
#[test]
fn focus_moves_are_left_out_where_there_is_no_z() {
    let text = CENTRED.replace("Y30\n", "Y30\nG0Z-1\nG1X5\n");
    let Imported { script, notes, .. } = laser("a.gc", &text);
    assert!(script.contains("\nG0\nG1 X5\n") && !script.contains('Z'), "{script}");
    let told = shown("a.gc", &notes);
    assert!(told.contains("a.gc:10:3: warning[X021]: Z moves a laser's focus"), "{told}");
}

/// Each REPEAT takes one of the controller's 256 cells.
#[test]
fn a_long_picture_has_no_more_loops_than_a_controller_has_cells() {
    let mut text = "; LightBurn\nG91\nM4 S0\nF1000\n".to_owned();
    for line in 0..1000 {
        let pixel = format!("G1 X0.{} S5\nG1 X0.1 S0\n", 1 + line % 9);
        text += &pixel.repeat(10 + line % 7);
        text += &format!("G90 G1 X0\nG91 G1 Y0.{}\n", 1 + line % 3);
    }
    let script = laser("a.gc", &text).script;
    let loops = script.lines().filter(|line| line.starts_with("REPEAT")).count();
    assert!((50..=100).contains(&loops), "{loops}");
}
