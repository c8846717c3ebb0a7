//! What real files had and were refused for.

use super::{made, refused};
use crate::{Options, import};

const HEAD: &str = "G21 G90 G17\nG0 X0 Y0 Z5\nF300\n";

fn gcode(text: &str) -> String {
    made("a.nc", &format!("{HEAD}{text}M2\n"))
}

#[test]
fn blocks_begin_with_any_word() {
    let script = gcode("G2 X10 Y0 I5 J0\nI-5 J0 X0\nR5 X10\nI-5 J0\nI5 J0\n");
    assert!(script.contains("\nI-5 J0 X0\n") && script.contains("\nG2 I5 J0\n"), "{script}");
}

#[test]
fn outputs_that_act_on_the_way_stay_what_they_are() {
    let script = gcode("M64 P2\nG1 X1\nM62 P1\nG1 X2\nM63 P1 G1 X3\nM65 P2\n");
    for wanted in ["M64 P2\n", "G1 X1\nM62 P1\n", "X2\nM63 P1 ", "\nM65 P2\n"] {
        assert!(script.contains(wanted), "{wanted} in {script}");
    }
    let said = refused("a.nc", &format!("{HEAD}M67 E0 Q50\n"));
    assert!(said.contains("an analog output"), "{said}");
}

#[test]
fn long_comments_are_cut_off_and_long_lines_are_none() {
    for comment in ["; ", "("] {
        let script = gcode(&format!("{comment}{}\nG1 X1\n", "x".repeat(5000)));
        assert!(script.contains("G1 X1") && script.len() < 1500, "{script}");
    }
    let text = format!("{HEAD}G1 X1 ({}) X2\n", "x".repeat(5000));
    assert!(refused("a.nc", &text).contains("a line of"));
    let text = format!("{HEAD}({}) G1 X2\n", "x".repeat(5000));
    assert!(refused("a.nc", &text).contains("a line of"));
}

#[test]
fn axes_that_stay_at_0_are_left_out() {
    let script = gcode("G0 X1 Y2 A0.\nA0.\nG1 X2 B-0\n");
    assert!(script.contains("G0 X1 Y2\n") && !script.contains(['A', 'B']), "{script}");
    assert!(refused("a.nc", &format!("{HEAD}G0 X1 A5.\n")).contains("A5."));
    // Without an axis they would be about all of them.
    for block in ["G28 A0.", "A0 G28", "G92 A0."] {
        assert!(refused("a.nc", &format!("{HEAD}{block}\n")).contains("axes that are not there"));
    }
}

#[test]
fn parameters_and_expressions_are_worth_their_values() {
    let script = gcode(
        "#1=5 (five)\n#<safe> = 2.5\nG1 X#1 Y[#1*2+1] Z-#<safe>\n#1 = [#1 + 10] / 4\n\
         X#1 Y[-[2-6]*.5]\n#1=7 X#1\n",
    );
    for wanted in ["G1 X5 Y11 Z[-safe]\n", "\nX3.75 Y2\n", "\nX3.75 "] {
        assert!(script.contains(wanted), "{wanted} in {script}");
    }
    for (text, wanted) in [
        ("G1 X#9", "nothing has set `#9`"),
        ("#1=1/0", "division by 0"),
        ("G1 X[SIN[3]]", "expressions take"),
        ("#1=2**3", "parameters take"),
        ("#1=5\nO100 WHILE [#1 GT 0]\nG1 X1\nO100 ENDWHILE", "O-words"),
    ] {
        let said = refused("a.nc", &format!("{HEAD}{text}\n"));
        assert!(said.contains(wanted), "{text}: {said}");
    }
    // Plain numbers in plain words keep a name, others their values.
    let script = gcode(
        "#1=5\n#<safe> = 2.5\n#2=300\n#3=1\n#4=2\n#5=3.\n#6=.5\n#<G1>=7\nG0 Z#<safe>\nG1 X#1 Y#3 F#2\nX-#1 Y[#3]\n#1=-7.5\nX#1 Z#<G1>\n\
         G4 P#5\nX#4\nF#4\nG20 X#6 Z1\n",
    );
    for wanted in [
        "\nDIM p1",
        "\nCONST safe = 2.5mm",
        "\nCONST p2 = 300mm/min",
        "\nCONST p6 = 0.5in",
        "\nCONST p_g1 = 7mm",
        "\np1 = 5mm\n",
        "\nG0 Z[safe]\n",
        "\nG1 X[p1] Y1 F[p2]\n",
        "\nX[-p1] Y1\n",
        "\np1 = -7.5mm\nX[p1] Z[p_g1]\n",
        "\nG4 P3\nX2\nF2\n",
        "\nG20 X[p6] Z1\n",
    ] {
        assert!(script.contains(wanted), "{wanted} in {script}");
    }
    // A part without arcs wants to know them before the run.
    let script = gcode("#1=5\nG0 X#1\n#1=6\n#2=1\nG2 X7 I#2\nG1 X#1\n");
    assert!(script.contains("\nG0 X5\n") && script.contains("I[p2]\nG1 X6\n"), "{script}");
    let deep = format!("{HEAD}G1 X{}1{}\n", "[".repeat(1500), "]".repeat(1500));
    assert!(refused("a.nc", &deep).contains("nested too deeply"));
}

#[test]
fn an_empty_drill_file_is_an_empty_program() {
    let text = "M48\n; #@! TF.FileFunction,NonPlated,1,2,NPTH\nFMAT,2\nMETRIC\n%\nG90\nG05\nM30\n";
    let made = import("a-NPTH.drl", text.as_bytes(), &Options::default()).expect("no error");
    assert!(made.notes.iter().any(|note| note.text.contains("no hole")));
    // A file that was cut off is none.
    assert!(refused("a.drl", "M48\nMETRIC\n%\nG90\n").contains("no hole"));
}

#[test]
fn pal_pc_drops_surplus_values_and_has_a_usual_speed() {
    let script = made(
        "a.pal",
        "#axis x;\n#steps 800;\n#elev 2.5;\n#input;\nmoverel 10(5000),0(3000),0(3000);\nstop.\n#start;\n",
    );
    assert!(script.contains("X 10mm"), "{script}");
    let script = made(
        "a.pal",
        "#axis xyz;\n#elev 4,4,4;\n#define R 0(21);\n#define () (2000);\n#input;\nmove 66 (),82,R,R;\nstop.\n#start;\n",
    );
    assert!(script.contains("X66 Y82 F[2828st/s]"), "{script}");
    let said = refused(
        "a.pal",
        "#axis xyz;\n#elev 4,4,4;\n#input;\nmove 66 (2000),82,0(21),0(21);\nstop.\n",
    );
    assert!(said.contains("`82` has no speed"), "{said}");
}

/// Any axes, in any order; Z wants its way back, too.
#[test]
fn every_subset_of_the_axes_is_a_machine() {
    for (axes, values, moves) in [
        ("X", "10(2000)", &["MoveRel X, 10mm, 2000st/s"][..]),
        ("y", "10(2000)", &["MoveRel Y, 10mm, 2000st/s"]),
        ("Z", "10(2000),-10(3000)", &["MoveRel Z, 10mm, 2000st/s", "MoveRel Z, -10mm, 3000st/s"]),
        ("xy", "3(2000),4(1000)", &["G91 G1 X3 Y4 F["]),
        (
            "XZ",
            "3(2000),4(1000),-4(500)",
            &["MoveRel X, 3mm, 2000st/s", "Z, 4mm, 1000st/s", "Z, -4mm, 500st/s"],
        ),
        (
            "yz",
            "3(2000),4(1000),-4(500)",
            &["MoveRel Y, 3mm, 2000st/s", "Z, 4mm, 1000st/s", "Z, -4mm, 500st/s"],
        ),
        (
            "xyz",
            "3(2000),4(2000),5(1000),-5(500)",
            &["G91 G1 X3 Y4 F[", "Z, 5mm, 1000st/s", "Z, -5mm, 500st/s"],
        ),
    ] {
        let text = format!(
            "#axis {axes};\n#steps 400;\n#elev 4;\n#input;\nmove {values};\nstop.\n#start;\n"
        );
        let script = made("a.pal", &text);
        for line in moves {
            assert!(script.contains(line), "#axis {axes}, {line}:\n{script}");
        }
        let others =
            ["X", "Y", "Z"].into_iter().filter(|other| !axes.to_uppercase().contains(other));
        for other in others {
            assert!(!script.contains(&format!("MoveRel {other}")), "#axis {axes}:\n{script}");
        }
    }
    // One value too few is refused by the number that the axes want.
    let said =
        refused("a.pal", "#axis xz;\n#elev 4;\n#input;\nmove 3(2000),4(1000);\nstop.\n#start;\n");
    assert!(said.contains("`#axis` asks for 3") && said.contains("two for Z"), "{said}");
}

#[test]
fn blanks_stand_between_the_words_of_a_hole() {
    let head = "M48\nINCH,LZ\nT1C0.0320\n%\nT1\n";
    let apart = made("a.drl", &format!("{head}X 010000 Y030000\nX 020000  Y 030000\nM30\n"));
    let joined = made("a.drl", &format!("{head}X010000Y030000\nX020000Y030000\nM30\n"));
    assert_eq!(apart, joined);
    let said = refused("a.drl", &format!("{head}X010000 7 Y030000\nM30\n"));
    assert!(said.contains("does not belong here"), "{said}");
}

#[test]
fn reference_speeds_may_stand_in_the_next_line() {
    let head = "#axis XY;\n#steps 800;\n#elev 4;\n";
    let tail = "#input;\nmove 10(2000),0(2000);\nstop.\n#start;\n";
    let apart = made("a.pal", &format!("{head}#reference\n3000,5000;\n{tail}"));
    assert!(!apart.contains("Home") && apart.contains("MoveRel X, 2000st"), "{apart}");
    // Anywhere else such a line is no statement.
    let said = refused("a.pal", &format!("{head}3000,5000;\n{tail}"));
    assert!(said.contains("is no statement"), "{said}");
}

#[test]
fn the_binders_unit_of_a_tenth_with_its_blank() {
    let script = made(
        "a.pal",
        "# units inch/1 0\n#axis xy;\n#steps 800;\n#elev 2.54;\n# input\nmove 2 (9000),2(9000);\nstop.\n#start;\n",
    );
    assert!(script.contains("X 5.08mm Y 5.08mm"), "{script}");
}

/// Fusion's posts for Mach3: the mode before the cycle is back after G80, and G73 pecks.
#[test]
fn after_g80_the_mode_before_the_cycle_is_back() {
    let script = gcode("G0 Z15.\nG98 G81 X1 Y1 Z-3 R5 F300\nX2\nG80\nZ15.\nX5\nG1 Z1\n");
    assert!(script.contains("\nG80\nG0 Z15\nX5\nG1 Z1\n"), "{script}");
    let script = gcode("G1 Z3\nG81 X1 Y1 Z-3 R5\nG80 Z15.\n");
    assert!(script.contains("\nG1 Z15\n"), "{script}");
    let script = gcode("G98 G73 X1 Y1 Z-3 R5 Q1 F300\nX2\nG80\nG0 Z5\n");
    assert!(script.contains("\nG98 G83 X1 Y1 Z-3 R5 Q1 F300\nX2\n"), "{script}");
    // Without a mode before the cycle there is nothing to go back to.
    let said = refused("a.nc", "G21 G90\nG81 X1 Y1 Z-3 R5 F300\nG80\nZ5\n");
    assert!(said.contains("a.nc:4:1: error[X010]: axis words before any of G0"), "{said}");
}

#[test]
fn a_refused_cycle_is_told_once() {
    let said = refused("a.nc", "G21 G90\nG84 X1 Y1 Z-3 R5 F300\nX2\nX3\nG80\nG0 X4\n");
    let errors = said.lines().filter(|line| line.contains("error[")).count();
    assert_eq!(errors, 1, "{said}");
}

/// Fanuc's posts with G90.1: the words of the centre are a place.
#[test]
fn centres_that_fit_as_places_are_told_so() {
    let said =
        refused("a.nc", "G21 G90 F600\nG0 X100 Y50\nG2 X120 Y50 I110 J50\nG2 X120 Y50 I11 J50\n");
    let absolute = "hint: I, J and K fit as places of the centre";
    assert_eq!(said.matches(absolute).count(), 1, "{said}");
}
