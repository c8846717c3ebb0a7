//! Importers against scripts: what they write compiles at once.

mod drill;
mod found;
mod hostile;
mod laser;
mod ncp;

use crate::{Diag, Imported, Options, import};
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};

/// The script and what the compiler says of it; there must be no error.
fn made(name: &str, text: &str) -> String {
    match import(name, text.as_bytes(), &Options::default()) {
        Ok(Imported { script, .. }) => {
            let source = Source::new("made.bas", script.clone());
            let (program, diags) = compile(&source, ProfileChoice::built_in());
            assert!(program.is_some(), "{script}\n{}", diags.render(&source));
            script
        }
        Err(diags) => panic!("{}", shown(name, &diags)),
    }
}

fn shown(name: &str, diags: &[Diag]) -> String {
    diags.iter().map(|diag| diag.render(name)).collect()
}

fn refused(name: &str, text: &str) -> String {
    let diags = import(name, text.as_bytes(), &Options::default()).expect_err("refused");
    shown(name, &diags)
}

#[test]
fn the_binders_relative_example() {
    let text = "@07\n@0i\n0 6600,2000,8200,2000,0,21,0,21\n0 5400,2000,3300,2000,100,350,-100,2000\n\
        0 0,21,4000,2000,100,350,-100,2000\n7 3\n9\n";
    insta::assert_snapshot!(made("a.isel", text));
}

#[test]
fn every_stored_instruction() {
    let text = "@07\n@0i\n77\nm12800,5000,0,5000,100,350,0,21\nn3\nm5400,2000,3300,2000,100,350,0,21\n\
        1 90\n2 55,0\n2 50,-1\n4 1\n4 2\n4 3\n4 4\n4 5\n4 6\n550\n6 0,21,0,21,500,300,0,21\n8 0S\n8 0r1\n\
        e1\n0 100,500,200,500,300,500,0,21\ne0\nZ1\n0 100,500,200,500,300,500,-50,21\nZ0\n\
        F-1\ny 2000,1000,0,1000,0,-1,1\nF0\ny 8000,1000,0,1000,0,-1,-1\n\
        p65529,5,0\np65529,0,10\np65530,4,1\no65531,2,0,2\no65531,0,10,-3\n\
        0 1,100,0,100,0,21,0,21\n0 2,100,0,100,0,21,0,21\n35,-1\n3 10,-3\n3 0,2\n0 7,100,0,100,0,21,0,21\n9\n@0S\n";
    insta::assert_snapshot!(made("a.isel", text));
}

#[test]
fn wrong_lines_name_the_cards_answer() {
    let text = "@0A 5,900\n@09\n@07\n@0R8\n@0A 5,900\n@0i\n0 1,2,3\n0 9000000,900,0,900,0,900,0,900\n\
        0 5,900000,0,900,0,900,0,900\n3 5,0\n3 5,-9\n4 7\nq\n1 20\n3 0,99\n0 60E3,1,2,3,4,5,6,7\n9\n0 1,900\n";
    insta::assert_snapshot!(refused("a.isel", text));
}

#[test]
fn the_clean_pair_of_source_and_instructions() {
    let text = "#axis x;\n#steps 800;\n#elev 2.5;\n#input;\nreference x;\nmoveabs 40(5000);\ndelay 50\n\
        repeat moverel -10(5000); delay 20 until 3;\nstop.\n#start;\n";
    insta::assert_snapshot!(made("a.pal", text));
}

#[test]
fn the_binders_source_with_definitions() {
    let text = "#axis xyz;\t(3 axes XYZ)\n#elev4,4,4;\t(pas)\n#defineR 0(21);\n#define () (2000);\n\
        #define perçage 1(350),-1(2000);\nmove 66 (),82(),R,R;\nmove 54 (),33(),perçage;\n\
        top: wait 50,top;\nset_port 65529,4=1;\non_port 65531,8=1,-2;\nréférence xy;\nstop.\t(fin)\n";
    insta::assert_snapshot!(made("a.pal", text));
}

#[test]
fn wrong_sources_are_refused_by_line() {
    let text = "#axis xyz;\n#elev 4,4;\n#frob 1;\nmove 1(2000);\nuntil 5;\nrepeat;\nmove 1(5),1(2000),0(2000),0(2000);\n\
        fly 3;\nwait 50,nowhere;\nsend 5;\nreference w;\nmove 99999999(2000),0(2000),0(2000),0(2000);\n";
    insta::assert_snapshot!(refused("a.pal", text));
}

#[test]
fn commands_of_the_jediv_card() {
    let text = "// Commande; Depl.X; Depl.Y; Depl.Z; 0; Max depl.; Vitesse; Durée pause; Message\n\
        RAZ_CPT;0;0;0;0;0;0;0;\nMove;0;0;143;0;143;0;0;Mouve  - Z : 15\nMove;48;48;0;0;48;0;0;corner\n\
        Move;0;0;0;0;0;0;71;Vitesse : 71 %\nMove;0;0;-143;0;143;0;0;down\nPause;0;0;0;0;0;1000;0;\n\
        Move;1;0;0;0;1;0;0;\nMove;0;1;0;0;1;0;0;\nMove;1;0;0;0;1;0;0;\nMove;0;1;0;0;1;0;0;\n\
        Move;1;0;0;0;1;0;0;\nMove;0;1;0;0;1;0;0;\nMove;0;0;-5;0;5;250;30;slow\n";
    insta::assert_snapshot!(made("a.cde", text));
    insta::assert_snapshot!(refused(
        "a.cde",
        "Move;1;2\nMove;0;0;0;7;7;0;0;\nMove;a;0;0;0;0;0;0;\nMove;1;0;0;0;1;0;300;\nTurn;0;0;0;0;0;0;0;\nMove;1;0;0;0;1;0;0\nMove"
    ));
}

/// Axes 1 and 3, and 2 and 4, change places until they are told to change back.
#[test]
fn a_jediv_card_swaps_its_axes() {
    let text = "Move;5;7;0;0;7;0;100;\nO=True\nMove;5;0;9;0;9;0;0;\nMove;0;0;0;8;8;0;0;\nO=F\nMove;5;7;0;0;7;0;0;\n";
    let made = import("a.cde", text.as_bytes(), &Options::default()).expect("a script");
    let lines = made.script.lines().filter_map(|line| line.strip_prefix("G1 "));
    let moves: Vec<&str> =
        lines.map(|line| line[..line.find(" F[").unwrap_or(line.len())].trim()).collect();
    let wanted: [&str; 4] = ["X[5st] Y[7st]", "X[9st] Z[5st]", "Y[8st]", "X[5st] Y[7st]"];
    assert_eq!(moves, wanted);
    let told = refused("a.cde", "O=True\nMove;0;7;0;0;7;0;0;\nO=maybe\n");
    assert!(told.contains("a.cde:2:1: error") && told.contains("axis 2 behind `O=True`"), "{told}");
    assert!(told.contains("a.cde:3:3: error") && told.contains("O=False"), "{told}");
}

#[test]
fn a_laser_picture() {
    let text = "; title\n; 3 lines\nG90\nG0 X10 Y5\nM3S0\nF1000\nS0\nG1 X20 S50\nX30 S0\nX40 S255\nM5\nG4P0.5\nG0 X0 Y0\n";
    insta::assert_snapshot!(made("a.gco", text));
    insta::assert_snapshot!(refused(
        "a.gco",
        "G90\nG0 X-1 Y0\nF100\nG1 X310\nX20 S5E\nEO\nG1 Y1 Z2\n"
    ));
}

#[test]
fn holes_become_a_table() {
    let mut text =
        "%\n(MSG,start the pump)\nG21 G90 G64 P0.02\nG0 Z2\nM3 S10000\nG81 X1 Y1 R2 Z-1.8 F100\n"
            .to_owned();
    for i in 0..9 {
        text += &format!("X{}.5 Y{}\n", i, i * 2);
        text += &format!("Y{}\n", i * 2 + 1);
    }
    text += "G80\nM5\nT2 M6 (0.8 mm)\n";
    for i in 0..5 {
        text += &format!("G00 X{i}.25 Y3\nG01 Z-1.7 F60\nG01 Z0\nG00 Z2.\n");
    }
    text += "M30\n%\n";
    insta::assert_snapshot!(made("a.ngc", &text));
}

#[test]
fn g_code_without_meaning_is_refused_by_line() {
    let text = "G21\n#1=5\no100 sub\nG41 D1\nG1 X#1\nX1\nG1 X5\nG55\nG2 X1 X2\nA5 G0\nG0 X[1+2]\nM98 P1\nG1 X99999999 F5\nG0 X\nG43 H1\n";
    insta::assert_snapshot!(refused("a.nc", text));
}

/// A CAM tool that fits arcs to nearly straight curves: 4.39 mm on a radius of 9.4 m leave the line
/// by 0.26 um. The arc behind it without a word of its own is one again.
#[test]
fn arcs_are_checked_before_anything_moves() {
    let text = "G21 G90 F600\nG0 X34.1229 Y32.3278\nG2 X34.9794 Y36.6298 I9238.4725 J-1837.2517\n\
        X35.9794 Y37.6298 I1 J0\nG2 X36.9794 Y36.6298 R1\nM30\n";
    let script = made("a.nc", text);
    assert!(script.contains("\nG1 X34.9794 Y36.6298\nG2 X35.9794 Y37.6298 I1 J0\n"), "{script}");
    let text = "G21 G90 F600\nG0 X10 Y10\nG2 X20 Y10 I5.1 J0\nG3 X30 Y10 R4\nX31 I5000\nX32 I0 J0\n\
        G18\nG2 X42 Z0.4 I5 K0\nG28 X0\nG2 X1 I7\nG91 G3 X2 I1\nX2 I1.5\n";
    let said = refused("a.nc", text);
    let lines: Vec<&str> = said.lines().filter(|line| line.contains("error")).collect();
    let expected = [
        "3:1: error[X012]: this arc cannot be drawn: its end misses the circle by 0.200 mm",
        "4:1: error[X012]: this arc cannot be drawn: the end is 10.000 mm away, more than twice the radius",
        "5:1: error[X012]: this arc cannot be drawn: its radius is 5000.000 mm; 4 m is the most",
        "6:1: error[X012]: this arc cannot be drawn: its radius is 0",
    ];
    assert_eq!(lines.len(), expected.len() + 1, "{said}");
    for (line, expected) in lines.iter().zip(expected) {
        assert_eq!(line.trim_start_matches("a.nc:"), expected);
    }
}

/// FreeCAD writes all three words of a centre; LinuxCNC and the language refuse one outside the
/// plane.
#[test]
fn a_centre_outside_the_plane_counts_when_it_is_not_zero() {
    let text =
        "G21 G90 F600\nG0 X0 Y0\nG2 X2 Y0 I1.000 J0.000 K0.000\nG18 G3 X4 Z0 I1 J-0.0 K0\nM2\n";
    let script = made("a.nc", text);
    assert!(script.contains("\nG2 X2 Y0 I1.000 J0.000\nG18 G3 X4 Z0 I1 K0\n"), "{script}");
    let said = refused("a.nc", &text.replace("K0.000", "K0.001"));
    assert!(said.contains("a.nc:3:1: error[X020]: K lies outside the active plane"), "{said}");
    let said = refused("a.nc", "G21 G90 F600\nG0 X10,5 Y0\n");
    assert!(said.contains("a.nc:2:7: error[X010]: a comma in a number: `,5 Y0`"), "{said}");
}

/// 400 steps/s in the work, 1000 at and above 100 steps; a line of two equal axes runs along its
/// path at the root of 2 times that; 50 % halves it.
#[test]
fn a_jediv_card_travels_above_its_threshold() {
    let text = "RAZ_CPT;0;0;0;0;0;0;0;\nMove;0;0;150;0;150;0;0;up\nMove;80;80;0;0;80;0;0;\n\
        Move;0;0;-50;0;50;0;0;to the threshold\nMove;9;0;0;0;9;0;0;\nMove;0;0;-150;0;150;0;0;down\n\
        Move;30;40;0;0;40;0;50;half\nMove;0;0;200;0;200;0;100;up\nMove;9;0;0;0;9;0;0;\n";
    let card = crate::CardRates { feed: 400, travel: 1000, threshold: Some(100) };
    let options = Options { card: Some(card), ..Options::default() };
    let made = import("a.cde", text.as_bytes(), &options).expect("a script");
    let feeds: Vec<&str> = made
        .script
        .lines()
        .filter(|line| line.starts_with("G1"))
        .map(|line| {
            line.split_once("F[").map_or("-", |(_, feed)| &feed[..feed.find("st").unwrap()])
        })
        .collect();
    // The way up ends above but begins in the work.
    assert_eq!(feeds, ["400", "1414", "1000", "-", "400", "250", "400", "1000"], "{}", made.script);
}

/// Listings of the binder: the card's own number changed and set back, a comma behind the letter,
/// guillemets, and what a listing computes by itself.
#[test]
fn listings_send_what_they_print() {
    let renamed = "110 print#1,\"@01\":gosub1000\n120 print#1,\"@0G1\":gosub1000\n130 print#1,\"@1i\":gosub1000\n\
        140 print#1,\"0 5000,5000\":gosub1000\n150 print#1,\"9\":gosub1000\n160 print#1,\"@1S\"\n\
        170 print#1,\"@1G0\"\n180 print#1,\"@0A,70,900\"\n190 stop\n";
    let script = made("a.lst", renamed);
    let moves: Vec<&str> =
        script.lines().filter_map(|line| line.strip_prefix("MoveRel ")).collect();
    assert!(moves[0].starts_with("X, 5000st, 5000st/s "), "{script}");
    assert!(moves[1].starts_with("X, 70st, 900st/s "), "{script}");
    let script =
        made("a.lst", "110 print#1,»@01»:gosub 1000\n120 print#1,»@0A 500,9000»:gosub1000\n");
    assert!(script.contains("MoveRel X, 500st, 9000st/s"), "{script}");
    let said = refused(
        "a.lst",
        "10 print#1,\"@01\"\n20 for i=1 to 5\n30 print#1,\"@0A\";i;\",900\"\n40 next\n",
    );
    let lines: Vec<&str> = said.lines().filter(|line| line.contains("error[X020]")).collect();
    assert_eq!(lines.len(), 3, "{said}");
}

/// A job that is streamed names its lines and begins at one: each statement stands at the line of
/// the file that it came from, in the file's order.
#[test]
fn plain_scripts_keep_the_files_lines() {
    let cube = "G1 X1 Y1\nX2\nY2\nX1\n";
    let gcode = format!("G21 G90 F600\n{}M5\n{cube}", cube.repeat(40));
    let jediv = "Move;1;0;0;0;1;0;0;\nMove;0;1;0;0;1;0;0;\n".repeat(50);
    for (name, text) in [("a.nc", gcode), ("a.cde", jediv)] {
        let import = |plain: bool| {
            let options = Options { plain, ..Options::default() };
            import(name, text.as_bytes(), &options).expect("a script")
        };
        let (plain, short) = (import(true), import(false));
        assert!(short.script.lines().count() < 40, "{}", short.script);
        let places: Vec<u32> = plain.places.iter().copied().filter(|place| *place > 0).collect();
        let lines = text.lines().count() as u32;
        assert_eq!(places, (1..=lines).collect::<Vec<_>>(), "{}", plain.script);
    }
}
