//! Programs of isel's controllers, and lists of points.

use super::{made, refused, shown};
use crate::{Format, Imported, Options, detect, import};
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};

/// As gerbv writes them, with DOS line ends.
const DRILL: &str = "IMF_PBL_V1.0\r\n\r\n; 1/1000 mm/s\r\nVEL 5000\r\nFASTVEL 10000\r\nDRILLDEF S2000\r\nDRILLDEF V1000\r\n\
    DRILLDEF D1800 ; through\r\nDRILLDEF C1 P0\r\nGETTOOL 1\r\nDRILL X001000 Y002540\r\nDRILL X003540 Y002540\r\nPROGEND\r\n";

/// As FreeCAD writes them: each line has its number.
const MILL: &str = "N000001 IMF_PBL_V1.0\nN000002 ;- a pocket\nN000003 GETTOOL 1\nN000004 SPINDLE CW RPM12000 TIME2000\n\
    N000005 FASTABS Z5000\nN000006 FASTABS X0 Y0\nN000007 VEL 2500\nN000008 MOVEABS Z-1500\nN000009 VEL 10000\n\
    N000010 MOVEABS X10000\nN000011 CCWABS I10000 J5000 X15000 Y5000\nN000012 MOVEREL Y-2500\n\
    N000013 MOVEABS X0 Y0\nN000014 WAIT 500\nN000015 SPINDLE OFF\nN000016 COOLANT OFF\nN000017 PROGEND\n";

#[test]
fn a_drilling_program_becomes_cycles() {
    let script = made("a.ncp", DRILL);
    assert!(script.contains("M6 T1\n"), "{script}");
    assert!(script.contains("G99 G81 X1 Y2.54 Z-1.8 R2 F60\n"), "{script}");
    assert!(script.contains("G99 G81 X3.54 Y2.54 Z-1.8 R2 F60\n"), "{script}");
}

#[test]
fn a_milling_program_becomes_lines_and_arcs() {
    let script = made("a.ncp", MILL);
    let wanted = [
        "M6 T1",
        "M3 S12000 G4 P2",
        "G0 Z5",
        "G0 X0 Y0",
        "G1 Z-1.5 F150",
        "G1 X10 F600",
        "G3 X15 Y5 I0 J5",
        "G91 G1 Y-2.5",
        "G90 G1 X0 Y0",
        "G4 P0.5",
        "M5",
        "M9",
        "M30",
    ];
    let lines: Vec<&str> = script.lines().filter(|line| line.starts_with(['G', 'M'])).collect();
    assert_eq!(lines, wanted, "{script}");
    // What is said of a line has the file's number.
    let told = refused("a.ncp", &MILL.replace("MOVEABS X10000", "MOVEABS X10000 Q"));
    assert!(told.contains("a.ncp:10:1: error[X010]: `Q` is no word of MOVEABS"), "{told}");
}

#[test]
fn the_first_line_tells_what_it_is_whatever_its_name() {
    for name in ["a.ncp", "a.txt", "a.nc", "a.isel"] {
        assert_eq!(detect(name, DRILL), Some(Format::Ncp), "{name}");
        assert_eq!(detect(name, MILL), Some(Format::Ncp), "{name}");
    }
    assert_eq!(detect("a.ncp", "IMF_PBL flatcam\n\nFASTABS Z2000\n"), Some(Format::Ncp));
}

/// Where the tools that write these files disagree nothing is guessed.
#[test]
fn what_is_not_sure_is_refused() {
    for (from, to, wanted) in [
        ("D1800", "D2", "DRILLDEF D2 would be 2 um"),
        ("S2000", "L15", "DRILLDEF L15 would be 15 um"),
        ("DRILLDEF S2000\r\n", "\r\n", "without a height between the holes"),
        ("DRILLDEF D1800 ; through", "", "before DRILLDEF has said how deep"),
        ("C1 P0", "C2 P0", "pecks without a depth"),
        ("FASTVEL 10000", "SETPORT A4=00000001", "SETPORT"),
        ("FASTVEL 10000", "INCH", "INCH"),
        ("FASTVEL 10000", "FLY X1", "`FLY` is no command"),
        ("FASTVEL 10000", "CWABS I0 J0 X1000 Y1000", "where CWABS begins is not known"),
        ("FASTVEL 10000", "PLANE XZ\r\nCWABS I0 K0 X1000 Z1000", "outside the plane XY"),
        ("FASTVEL 10000", "MOVEABS X99999999999", "is no word of MOVEABS"),
        ("FASTVEL 10000", "MOVEABS", "MOVEABS without a place"),
        ("FASTVEL 10000", "WPCLEAR\r\nMOVEABS X1", "counts from the machine's zero"),
        ("FASTVEL 10000", "WPREG1ACT\r\nWPREG2ACT", "a second work zero"),
        ("FASTVEL 10000", "SPINDLE CW RPM-5", "is no word of SPINDLE"),
        ("VEL 5000", "VEL 0", "VEL without a speed"),
    ] {
        let text = DRILL.replace(from, to);
        assert_ne!(text, DRILL, "{from}");
        let told = refused("a.ncp", &text);
        assert!(told.contains(wanted), "{to}: {told}");
    }
    // The reference plane counts, and pecks take the lesser of both depths.
    let script = made("a.ncp", &DRILL.replace("C1 P0", "C2 P500 F800 O400 T20"));
    assert!(script.contains("G99 G83 X1 Y2.54 Z-1.3 R2.5 Q0.4 F60"), "{script}");
    let script = made("a.ncp", &DRILL.replace("C1 P0", "C3 P0 T250"));
    assert!(script.contains("G99 G82 X1 Y2.54 Z-1.8 R2 P0.25 F60"), "{script}");
}

/// Any bytes behind the first line end in a diagnostic or a script.
#[test]
fn damaged_programs_are_told() {
    for text in [DRILL, MILL] {
        for at in 14..text.len() {
            for sign in ["", "-", "9999999999", "\u{e9}", " ", "\n", "X"] {
                let mut damaged = text.to_owned();
                damaged.replace_range(at..at + 1, sign);
                let _ = import(
                    "a.ncp",
                    damaged.as_bytes(),
                    &Options { plain: true, ..Options::default() },
                );
            }
        }
    }
}

const POSITIONS: &str = "### Footprint positions ###\n## Unit = mm, Angle = deg.\n\
    # Ref     Val       Package         PosX       PosY       Rot  Side\n\
    C1        100n      C_0402_1005    25.4000    12.7000  180.0000  top\n\
    R1        10k       R_0603_1608    10.0000    20.0000   90.0000  top\n## End\n";

/// A list of points is what the user says it is.
fn points() -> Options {
    Options { from: Some(Format::Points), ..Options::default() }
}

#[test]
fn a_list_of_positions_becomes_a_table_and_names_the_columns_left_out() {
    let table = "Ref,Val,Package,PosX,PosY,Rot,Side\n\"C1\",\"100n\",\"C_0402\",25.4,12.7,180,top\n\
        \"R1\",\"10k\",\"R_0603\",10,20,90,top\n";
    for (name, text, line) in [("board.pos", POSITIONS, 3), ("board.csv", table, 1)] {
        // Parts that are to be placed: nothing is made of them unasked, and both ways are named.
        let told = refused(name, text);
        assert!(told.contains("pasapas place") && told.contains("--from points"), "{told}");
        let Imported { script, notes, .. } =
            import(name, text.as_bytes(), &points()).expect("a script");
        let source = Source::new("made.bas", script.clone());
        let (program, diags) = compile(&source, ProfileChoice::built_in());
        assert!(program.is_some(), "{script}\n{}", diags.render(&source));
        let row = script.lines().find(|line| line.contains("25.4mm"));
        assert!(row.is_some_and(|row| row.contains("12.7mm")), "{script}");
        assert!(
            script.contains("TABLE points(2)") && script.contains("G0 X[points(i, 0)]"),
            "{script}"
        );
        assert!(!script.contains("M3"), "{script}");
        let told = shown(name, &notes);
        let wanted =
            format!("{name}:{line}:1: note[X021]: the columns are left out: Val, Package, Rot");
        assert!(told.contains(&wanted), "{told}");
        assert!(
            told.contains("2 points; what is done at each of them stands in no list"),
            "{told}"
        );
    }
    let text = POSITIONS.replace("25.4000", "left");
    let diags = import("board.pos", text.as_bytes(), &points()).expect_err("refused");
    let told = shown("board.pos", &diags);
    assert!(told.contains("board.pos:4:1: error[X010]: `left` is no length"), "{told}");
}
