//! Drill files, as the tools of several makers write them.

use super::{made, refused, shown};
use crate::{Options, import};

#[test]
fn a_drill_file() {
    let text = "M48\n;FORMAT={-:-/ absolute / metric / decimal}\nMETRIC,TZ\nT1C0.800\nT2C1.0\n%\nG90\nG05\nT1\n\
        X1.5Y2.5\nX3.0\nY4.\nT2\nX-10.25Y0.0\nM30\n";
    insta::assert_snapshot!(made("a.drl", text));
    let text = "M48\nINCH,LZ\nT1C0.03\n%\nT1\nX0125Y01\nX+013Y-00005\nM30\n";
    assert!(
        made("a.drl", text).contains("TABLE holes(2) = 31.75mm, 25.4mm; 33.02mm, -0.127mm"),
        "{}",
        made("a.drl", text)
    );
}

#[test]
fn slots_routes_and_repeated_holes() {
    let text = "M48\nMETRIC\nT1C0.8\nT2C1.0\n%\nG90\nG05\nT1\nX1.0Y2.0\nR3X2.54\nX0.0Y0.0\nR2Y-1.5\nT2\n\
        X5.0Y5.0G85X8.0Y5.0\nG00X1.0Y9.0\nM15\nG01X2.0Y9.0\nG01X2.0Y8.0\nM16\nG05\nX7.0Y7.0\nM30\n";
    insta::assert_snapshot!(made("a.drl", text));
    let text = "M48\nMETRIC\nT1C0.8\n%\nT1\nR3X2.54\nX1.0Y1.0\nR9999999X1.0\nR3X4999.0\nX1.0G85\nG02X1.0Y2.0A1\nR2\nM30\n";
    insta::assert_snapshot!(refused("a.drl", text));
}

#[test]
fn a_bottom_side_is_mirrored_and_shifted() {
    use crate::Turn;
    use lang::axis::Axis;
    let text = "M48\nMETRIC\nT1C1.0\n%\nG90\nG05\nT1\nX1.5Y2.5\nX3.0Y4.0\nX1.0Y1.0G85X4.0Y2.0\n\
        G00X1.0Y9.0\nM15\nG01X2.0Y9.0\nG02X4.0Y7.0I0.0J-2.0\nG03X6.0Y7.0A1.0\nM16\nG05\nM30\n";
    let script = |mirror, shift| {
        let options = Options { turn: Turn { mirror, shift }, ..Options::default() };
        let made = import("a.drl", text.as_bytes(), &options);
        made.unwrap_or_else(|diags| panic!("{}", shown("a.drl", &diags))).script
    };
    let plain = script(None, [0; 2]);
    assert!(plain.contains("= 1.5mm, 2.5mm; 3mm, 4mm") && !plain.contains("The file's places"));
    assert!(plain.contains("G2 X4 Y7 I0 J-2") && plain.contains("G3 X6 Y7 R1"), "{plain}");
    // Seen from behind: X counts the other way, arcs turn the other way.
    let bottom = script(Some(Axis::X), [10_000, 500]);
    for line in [
        "8.5mm, 3mm; 7mm, 4.5mm",
        "9mm, 1.5mm, 6mm, 2.5mm",
        "G0 X9 Y9.5",
        "G3 X6 Y7.5 I0 J-2",
        "G2 X4 Y7.5 R1",
    ] {
        assert!(bottom.contains(line), "{line}:\n{bottom}");
    }
    assert!(
        bottom.contains("mirrored: X has the other sign, then shifted by X 10mm, Y 0.5mm"),
        "{bottom}"
    );
    let turned = script(Some(Axis::Y), [0, 10_000]);
    assert!(
        turned.contains("1.5mm, 7.5mm; 3mm, 6mm") && turned.contains("G3 X4 Y3 I0 J2"),
        "{turned}"
    );
    let shifted = script(None, [-1_000, 0]);
    assert!(shifted.contains("0.5mm, 2.5mm") && shifted.contains("G2 X3 Y7 I0 J-2"), "{shifted}");
}

#[test]
fn lists_of_points_turn_too_and_other_files_do_not() {
    use crate::{Format, Turn};
    use lang::axis::Axis;
    let turn = Turn { mirror: Some(Axis::X), shift: [20_000, 0] };
    let options = Options { turn, from: Some(Format::Points), ..Options::default() };
    let made = import("a.csv", b"X,Y\n1,2\n5,6\n", &options).expect("points");
    assert!(made.script.contains("19mm, 2mm; 15mm, 6mm"), "{}", made.script);
    assert!(made.script.contains("' The file's places are mirrored"), "{}", made.script);
    for (name, text) in
        [("a.nc", "G21 G90\nG0 X1\nG1 X2 F300\nM30\n"), ("a.isel", "@07\n@0R7\n@0A100,100\n")]
    {
        let options = Options { turn, ..Options::default() };
        let told = import(name, text.as_bytes(), &options).expect_err("it is refused");
        let told = shown(name, &told);
        assert!(
            told.contains("neither mirrored nor shifted") && told.contains("work zero"),
            "{told}"
        );
    }
}

/// The first hole or slot of a file, and what was said about it.
fn first(text: &str) -> (String, String) {
    let made = import("a.drl", text.as_bytes(), &Options::default());
    let made = made.unwrap_or_else(|diags| panic!("{}", shown("a.drl", &diags)));
    let table = made.script.lines().find(|line| line.starts_with("TABLE"));
    let row = table.and_then(|line| line.split_once("= ")).map_or("", |(_, row)| row);
    (row.split("; ").next().unwrap_or("").to_owned(), shown("a.drl", &made.notes))
}

/// Worked by hand from each tool's own words; a wrong point would be ten times too far.
#[test]
fn the_point_stands_where_each_tool_means_it() {
    for (maker, text, hole) in [
        (
            "Altium, 4.4",
            "M48\n;FILE_FORMAT=4:4\nMETRIC,LZ\nT1F00S00C0.3\n%\nT01\nX002365Y0015\nX0Y0\nM30\n",
            "23.65mm, 15mm",
        ),
        (
            "Altium, 2.5",
            "M48\n;FILE_FORMAT=2:5\nINCH,LZ\nT01C0.02\n%\nT01\nX0113Y01\nM30\n",
            "28.702mm, 25.4mm",
        ),
        (
            "Altium, old",
            "M48\n;FILE_FORMAT=2:2\nINCH,TZ\nT01C0.01\n%\nT01\nX+0150Y-0025\nM30\n",
            "38.1mm, -6.35mm",
        ),
        (
            "KiCad, 4.2",
            "M48\n; FORMAT={4:2/ absolute / metric / suppress leading zeros}\nFMAT,2\nMETRIC,TZ\nT1C0.8\n%\nG90\nG05\nT1\nX1270Y-254\nT0\nM30\n",
            "12.7mm, -2.54mm",
        ),
        (
            "KiCad, kept zeros",
            "M48\n;FORMAT={2:4/ absolute / inch / keep zeros}\nFMAT,2\nINCH,TZ\nT1C0.03\n%\nT1\nX010000Y005000\nM30\n",
            "25.4mm, 12.7mm",
        ),
        (
            "Eagle",
            "%\nM48\nM72\nT01C0.0236\n%\nT01\nX9250Y4000\nX12100Y0\nM30\n",
            "23.495mm, 10.16mm",
        ),
        (
            "DipTrace",
            "M48\nMETRIC,0000.00\nT1C0.8\n%\nT1\nX+001270Y+000254\nM30\n",
            "12.7mm, 2.54mm",
        ),
        ("PADS", "%\nT1C.015F095S3\nX0362Y049\nX11Y015\nM30\n", "91.948mm, 124.46mm"),
        (
            "Upverter",
            "M48\nM71,TZ\nFMAT,2\nT1C0.635\n%\nT1\nX-12.7Y2.54\nT00\nM30\n",
            "-12.7mm, 2.54mm",
        ),
        (
            "Allegro",
            ";LEADER: 12\n;T01 Holesize 1. = 12.000000 Tolerance = +0.0/-0.0 PLATED MILS Quantity = 2\n%\nG90\nT01\nX004450Y000200\nX009874Y002026\nM30\n",
            "11.303mm, 0.508mm",
        ),
        (
            "Siemens",
            "; Format  : 3.3 / Absolute / MM / Leading\nM48\nMETRIC,TZ\nFMAT,2\nICI,OFF\nT05C1.0\n%\nM71\nG90\nG93X0Y0\nT05\nX12700Y2540\nX5000\nT00\nM30\n",
            "12.7mm, 2.54mm",
        ),
    ] {
        let (row, said) = first(text);
        assert_eq!(row, hole, "{maker}\n{said}");
    }
}

#[test]
fn what_a_header_leaves_open_is_told() {
    let (row, said) = first("M48\nT1C0.03\n%\nT1\nX1.0Y0.5\nM30\n");
    assert_eq!(row, "25.4mm, 12.7mm");
    assert!(said.contains("a.drl:5:1: warning[X023]: neither METRIC nor INCH"), "{said}");
    let (_, said) = first("M48\nM72\nT1C0.03\n%\nT1\nX9250Y4064\nM30\n");
    assert!(said.contains("note[X030]: neither LZ nor TZ is named"), "{said}");
    let (_, said) = first("M48\nMETRIC\nT1C0.03\n%\nT1\nX1.0Y1.0\nT9\nX2.0Y1.0\nM30\n");
    assert!(said.contains("a.drl:7:1: warning[X023]: tool T9"), "{said}");
    let said = refused("a.drl", "M48\nINCH\nT1C0.03\n%\nT1\nX00130500Y00184500\nM30\n");
    assert!(said.contains("a.drl:6:1: error[X012]: `X00130500` has more digits"), "{said}");
    assert!(said.contains("FILE_FORMAT=3:5"), "{said}");
}

/// A route keeps the tool down round its corners and arcs; its places go on without G01.
#[test]
fn routes_have_corners_and_arcs() {
    let text = "M48\nMETRIC,TZ\nT5C1.0\nT6C2.0\n%\nG90\nT5\nG00X120759Y9560\nM15\nG01Y8660\nY10460\nM16\n\
        G00X1000Y1000\nM15\nG01X3000\nG02X4000Y2000A1000\nG03X5000Y3000I1000J0\nX6000Y2000I0J-1000\nM17\n\
        G05\nX7000Y7000\nT6\nX1000Y1000G85X1000Y3000\nM30\n";
    insta::assert_snapshot!(made("a.drl", text));
    let text = "M48\nMETRIC,TZ\nT1C1.0\n%\nT1\nG00X0Y0\nG01X1000\nG05\nX1000Y1000\nM30\n";
    let (_, said) = first(text);
    assert!(said.contains("a.drl:7:1: warning[X021]: a route with the tool up"), "{said}");
    let text = "M48\nMETRIC,TZ\nT1C1.0\n%\nT1\nG00X0Y0\nM15\nG02X1000\nG41\nM97,PART 7\nX100\nG82\nG93X5Y5\n\
        M47,load\nG33X1Y1\nX1Y1Z1\nX1X2\nM02X10\nM30\n";
    insta::assert_snapshot!(refused("a.drl", text));
}

/// Two holes, then both of them 10 mm further to the right, and 10 mm above that.
#[test]
fn patterns_are_repeated() {
    let text = "M48\nMETRIC\nT1C0.8\n%\nT1\nX9.0Y9.0\nM25\nX1.0Y1.0\nX2.0Y1.0\nM01\nM02X10.0\nM02Y10.0\nM08\n\
        X20.0Y1.0\nM30\n";
    let script = made("a.drl", text);
    assert!(
        script.contains(
            "TABLE holes(2) = 9mm, 9mm; 1mm, 1mm; 2mm, 1mm; 11mm, 1mm; _\n  \
             12mm, 1mm; 11mm, 11mm; 12mm, 11mm; 20mm, 1mm"
        ),
        "{script}"
    );
}

#[test]
fn other_files_of_a_board_are_named() {
    let said = refused("a.gtl", "%FSLAX33Y33*%\n%MOMM*%\n%ADD10C,0.6*%\nD10*\nX1Y2D03*\nM02*\n");
    assert!(said.contains("a.gtl:1:1: error[X003]: this is a Gerber file"), "{said}");
}

/// The same holes line by line are a script of their own, which has so many bytes.
#[test]
fn a_table_says_what_it_saves() {
    let holes: String = (0..300).map(|i| format!("X{}.5Y{}.25\n", i % 20, i / 20)).collect();
    let (_, said) = first(&format!("M48\nMETRIC\nT1C0.8\n%\nT1\n{holes}M30\n"));
    let line =
        said.lines().find(|line| line.contains("saved by tables and loops")).expect("a note");
    let numbers: Vec<usize> =
        line.split(|c: char| !c.is_ascii_digit()).filter_map(|text| text.parse().ok()).collect();
    let [.., after, before, saved] = numbers[..] else { panic!("{line}") };
    assert_eq!(before - after, saved, "{line}");
    // A table of small multiples has one byte for each value, the loop a few dozen; three moves
    // have ten bytes or more for each hole.
    assert!((600..700).contains(&after) && before > 3000, "{line}");
}

#[test]
fn a_plain_script_drills_line_by_line() {
    let text =
        "M48\nMETRIC\nT1C0.8\n%\nT1\nX1.0Y1.0\nX2.0Y1.0\nG00X3.0Y3.0\nM15\nG01X4.0\nM16\nM30\n";
    let options = Options { plain: true, ..Options::default() };
    let made = import("a.drl", text.as_bytes(), &options).expect("a script");
    let at = |line: &str| {
        let index = made.script.lines().position(|known| known == line);
        made.places[index.unwrap_or_else(|| panic!("{line}\n{}", made.script))]
    };
    assert_eq!([at("G0 X1 Y1"), at("G0 X2 Y1"), at("G0 X3 Y3")], [6, 7, 11]);
}
