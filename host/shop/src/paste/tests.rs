use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::profile::Profile;
use proptest::prelude::*;

use super::beads::{self, Bead};
use super::dots::{self, Dot};
use super::job::Given;
use super::needle::Needle;
use super::pads::{Pad, pads};
use super::{Layer, Side, job, read};
use crate::Wrong;

const SAMPLE: &str = include_str!("data/sample.gtp");
const NEEDLE: &str = "diameter = 0.4\ndot = 0.6\nstencil = 0.12\noutput = 3\nms = 80\nclearance = 0\n\
                      board = -30\nsuck_ms = 20\n";

fn mill() -> Profile {
    Profile::built_in("mill").expect("built in")
}

fn layer(text: &str) -> Layer {
    read(text, None).unwrap_or_else(|wrong| panic!("{wrong:?}\n{text}"))
}

fn needle(text: &str) -> Result<Needle, Wrong> {
    Needle::parse(text, &mill())
}

fn spread(pads: &[Pad], area: f64) -> Vec<Dot> {
    let of =
        |(n, pad)| dots::spread(pad, dots::count(pad, area)).into_iter().map(move |at| (n, at));
    let all = pads.iter().enumerate().flat_map(of);
    dots::order(all.map(|(pad, at)| Dot { at, pad }).collect())
}

fn script(text: &str, needle: &Needle) -> String {
    let pads = pads(&layer(text)).expect("pads");
    let beads = beads_of(&pads, needle);
    let single = |dot: &Dot| beads.iter().all(|bead| bead.pad != dot.pad);
    let dots: Vec<Dot> = spread(&pads, needle.area()).into_iter().filter(single).collect();
    let given = Given { dots: &dots, beads: &beads, pads: &pads };
    job::script(given, needle, &mill(), "a.gtp").expect("a script")
}

fn beads_of(pads: &[Pad], needle: &Needle) -> Vec<Bead> {
    let Some(asked) = &needle.bead else { return Vec::new() };
    let of = |(n, pad): (usize, &Pad)| {
        let ends = beads::line(pad, asked)?;
        Some(Bead { ends, speed: beads::speed(pad, ends, needle, asked), pad: n })
    };
    beads::order(pads.iter().enumerate().filter_map(of).collect(), [0.0; 2])
}

fn image(text: &str) -> usize {
    let source = Source::new("job", text.to_owned());
    let (program, found) = compile(&source, ProfileChoice::built_in());
    let program = program.unwrap_or_else(|| panic!("{}\n{text}", found.render(&source)));
    lang::back::compile(&program).expect("it fits").image.len()
}

/// The areas of the sample, in mm2, by their middles.
fn areas(text: &str) -> Vec<(String, f64)> {
    let found = pads(&layer(text)).expect("pads");
    let told = |pad: &Pad| {
        (
            format!("{:.2} {:.2}", pad.at[0], pad.at[1]),
            (pad.area.unwrap_or(0.0) * 1e3).round() / 1e3,
        )
    };
    found.iter().map(told).collect()
}

#[test]
fn flashes_regions_macros_clear_parts_and_repetitions_are_pads_of_the_right_area() {
    let found = areas(SAMPLE);
    let near = |at: &str, area: f64| {
        let own = found.iter().find(|(place, _)| place == at);
        let (_, own) = own.unwrap_or_else(|| panic!("no pad at {at}: {found:?}"));
        assert!((own - area).abs() < 0.01 * area + 0.001, "{at}: {own}, wanted {area}");
    };
    near("10.00 5.00", 0.95);
    near("20.00 20.00", 0.2827);
    near("30.00 11.27", 0.6 + 0.2827);
    near("15.00 15.00", 0.96 - (4.0 - std::f64::consts::PI) * 0.04);
    // The slot parts the region.
    near("40.70 11.50", 4.2);
    near("42.30 11.50", 4.2);
    near("55.00 50.00", 0.2827);
    assert_eq!(found.len(), 11, "{found:?}");
    assert_eq!(layer(SAMPLE).side, Some(Side::Top));
}

#[test]
fn a_layer_in_inch_and_one_without_zeros_at_its_end_are_the_same() {
    let mm = "%FSLAX46Y46*%\n%MOMM*%\n%ADD10R,2.54X1.27*%\nD10*\nX25400000Y50800000D03*\nM02*\n";
    let inch = "%FSLAX24Y24*%\n%MOIN*%\n%ADD10R,0.1X0.05*%\nD10*\nX10000Y20000D03*\nM02*\n";
    let old = "%FSTAX24Y24*%\nG70*\n%ADD10R,0.1X0.05*%\nG54D10*\nX01Y02D03*\nM02*\n";
    assert_eq!(areas(mm), areas(inch));
    assert_eq!(areas(mm), areas(old));
    assert_eq!(areas(mm), [("25.40 50.80".to_owned(), 3.226)]);
}

/// Strokes, arcs in both notations, blocks, holes, mirror and scale.
#[test]
fn what_board_tools_draw_otherwise_is_read_too() {
    let head = "%FSLAX33Y33*%\n%MOMM*%\n%ADD10C,1*%\n%ADD11C,2X1*%\n%ADD12R,2X1*%\n";
    let one = |body: &str, area: f64| {
        let found = areas(&format!("{head}{body}M02*\n"));
        let sum: f64 = found.iter().map(|(_, area)| area).sum();
        assert!((sum - area).abs() < 0.01 * area, "{body}: {sum}, wanted {area}");
        found.len()
    };
    let pi = std::f64::consts::PI;
    assert_eq!(one("D10*\nX0Y0D02*\nG01X5000D01*\n", 5.0 + pi / 4.0), 1);
    assert_eq!(one("D11*\nX0Y0D03*\n", pi * 0.75), 1);
    let disc = "G36*\nX0Y0D02*\nG75*\nG03X0Y0I2000J0D01*\nG37*\n";
    assert_eq!(one(disc, 4.0 * pi), 1);
    let quarter = "G36*\nX0Y0D02*\nG74*\nG01X2000D01*\nG03X0Y2000I2000J0D01*\nG01Y0D01*\nG37*\n";
    assert_eq!(one(quarter, pi), 1);
    assert_eq!(
        one("%ABD20*%\nD12*\nX0Y0D03*\nX5000D03*\n%AB*%\nD20*\nX0D03*\nY9000D03*\n", 8.0),
        4
    );
    assert_eq!(one("%LR30*%\n%LS2*%\nD12*\nX0Y0D03*\n", 8.0), 1);
    // A clear disc in the middle of a flash.
    assert_eq!(one("D12*\nX0Y0D03*\n%LPC*%\nD10*\nX0Y0D03*\n%LPD*%\n", 2.0 - pi / 4.0), 2);
    let named = format!("{head}D10*\n%TO.C,R2*%\nX0Y0D03*\n%TD*%\nX9000D03*\nM02*\n");
    let names: Vec<String> =
        pads(&layer(&named)).expect("pads").into_iter().map(|pad| pad.name).collect();
    assert_eq!(names, ["R2", ""]);
}

#[test]
fn dots_lie_evenly_on_their_pads() {
    let of = |ring: &str, count| {
        let text = format!("name,x (mm),y (mm),width,height\nU1,10,10,{ring}\n");
        let pads = pads(&layer(&text)).expect("pads");
        let mut found = dots::spread(&pads[0], count);
        found.sort_by(|a, b| a[1].total_cmp(&b[1]).then(a[0].total_cmp(&b[0])));
        found.iter().map(|[x, y]| format!("{x:.2},{y:.2}")).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(of("1,1", 1), "10.00,10.00");
    assert_eq!(of("0.5,2", 2), "10.00,9.50 10.00,10.50");
    assert_eq!(of("2,2", 4).split(' ').count(), 4);
    assert_eq!(
        of("3,3", 9),
        "9.00,9.00 10.00,9.00 11.00,9.00 9.00,10.00 10.00,10.00 11.00,10.00 9.00,11.00 10.00,11.00 11.00,11.00"
    );
}

#[test]
fn a_job_is_readable_compiles_and_is_small() {
    let text = script(SAMPLE, &needle(NEEDLE).expect("good"));
    insta::assert_snapshot!(text);
    assert!(image(&text) < 600, "{}", image(&text));
    let whole = "touch = [5, 5, -31]\nprobe = 4\npurge = [9, 5]\npurge_ms = 500\nsuck = 5\n";
    let text = script(SAMPLE, &needle(&format!("{NEEDLE}{whole}")).expect("good"));
    insta::assert_snapshot!(text.split("SetOut").skip(1).collect::<Vec<_>>().join("SetOut"));
    image(&text);
    // The most fits the larger chip.
    let pad = Pad { name: "R1".into(), line: 1, at: [0.0; 2], area: None, cells: vec![[0.0; 2]] };
    let at = |n: usize| [(n % 97) as f64 * 3.013, (n / 97) as f64 * 3.127];
    let dots: Vec<Dot> = (0..dots::MOST).map(|n| Dot { at: at(n), pad: 0 }).collect();
    let given = Given { dots: &dots, beads: &[], pads: &[pad] };
    let text = job::script(given, &needle(NEEDLE).expect("good"), &mill(), "a.gtp");
    let size = image(&text.expect("a script"));
    assert!(size < 32_000, "{size}");
}

const BEAD: &str = "[bead]\nfrom = 1.5\nslowest = 1\nfastest = 40\nopens_ms = 15\nthread = 0.3\n";

/// Long narrow pads get a line along their middle at the speed that gives what the stencil would.
#[test]
fn long_pads_get_beads() {
    let needle = needle(&format!("{NEEDLE}{BEAD}")).expect("good");
    let list = "name,x (mm),y (mm),width,height,angle\nU1,10,10,3,0.5,0\nU2,20,10,0.5,3,0\n\
                U3,30,10,3,0.5,30\nU4,40,10,3,2,0\nU5,50,10,1.4,0.3,0\n";
    let pads = pads(&layer(list)).expect("pads");
    let found = beads_of(&pads, &needle);
    let told = |bead: &Bead| {
        let [[ax, ay], [bx, by]] = bead.ends;
        format!("{} {ax:.2},{ay:.2} {bx:.2},{by:.2} {:.1}", pads[bead.pad].name, bead.speed)
    };
    let told: Vec<String> = found.iter().map(told).collect();
    // 1.5 mm2 of stencil in 2.5 mm at a flow of 0.4712 mm2 in 80 ms: 9.8 mm/s.
    let wanted = [
        "U1 8.76,10.00 11.24,10.00 9.8",
        "U2 20.00,11.24 20.00,8.76 9.8",
        "U3 28.92,9.37 31.08,10.63 9.8",
    ];
    assert_eq!(told, wanted);
    for bead in &found {
        assert!((beads::given(bead, &pads[bead.pad], &needle) - 1.0).abs() < 0.02);
    }
    let text = script(list, &needle);
    insta::assert_snapshot!(text);
    image(&text);
}

/// An angle, a ring and a pad that is cut get dots: a bead would lie beside them.
#[test]
fn bent_pads_get_dots() {
    let needle = needle(&format!("{NEEDLE}{BEAD}")).expect("good");
    let bent = "%FSLAX33Y33*%\n%MOMM*%\n%ADD10C,0.5*%\nD10*\nX0Y0D02*\nG01X6000D01*\nX6000Y2500D01*\nM02*\n";
    let pads = pads(&layer(bent)).expect("pads");
    assert_eq!((pads.len(), beads_of(&pads, &needle).len()), (1, 0));
}

#[test]
fn what_is_wrong_with_a_layer_is_told_by_line() {
    let told = |text: &str| {
        let wrong = read(text, None).expect_err(text);
        let Wrong { at, text, hint, .. } = &wrong[0];
        assert!(!hint.is_empty(), "{text}");
        format!("{}:{}: {text}", at.0, at.1)
    };
    let head = "%FSLAX46Y46*%\n%MOMM*%\n%ADD10C,1*%\n";
    for (text, words) in [
        ("%FSLAX46Y46*%\n%MOMM*%\nM02*\n", "1:1: a Gerber layer without a pad"),
        ("%FSLAX46Y46*%\n%MOMM*%\n%ADD10C,-1*%\n", "3:1: aperture D10: an aperture of size -1"),
        ("%FSLAX46Y46*%\n%MOMM*%\nD11*\n", "3:1: aperture D11 is not defined"),
        ("%FSLAX46Y46*%\nX1Y1D03*\n", "2:1: a place before %FS and %MO"),
        ("%FSLéX46Y46*%\n", "1:1: `FSLéX46Y46` is no format of numbers"),
        ("%TF.FileFunction,Copper,L1,Top*%\n%FSLAX46Y46*%\n", "1:1: this file is the layer Copper"),
        (&format!("{head}D10*\nG36*\nX0Y0D03*\n"), "6:1: a flash inside of a region"),
        (&format!("{head}D10*\nX99999999999Y0D03*\n"), "5:1: `X99999999999Y0D03` lies beyond 10 m"),
        (&format!("{head}%AMA*6,1*%\n%ADD11A*%\n"), "5:1: aperture D11: primitive 6 of a macro"),
        ("a,b\n1,2\n", "1:1: no column is called x, or none y"),
        ("x,y,width\n1,2,3\n", "1:1: a pad has a width and a height"),
        ("x,y,width,height\n1,2,0.5,-1\n", "2:1: height is -1 mm"),
        ("x,y,width,height\n1,2,,1\n", "2:1: this pad has no width"),
        ("x;y\n1;2,5\n3;four\n", "3:1: y is `four`, no number"),
        ("", "1:1: a list of pads without a pad"),
    ] {
        let found = told(text);
        assert!(found.contains(words), "{text}: {found}");
    }
}

#[test]
fn what_is_wrong_with_a_needle_is_told_by_key() {
    for (from, to, line, words, hint) in [
        ("stencil", "stensil", 3, "there is no key `stensil` here", "`stencil` is the nearest key"),
        ("ms = 80\n", "", 1, "the key `ms` is missing", "add it"),
        ("dot = 0.6", "dot = -1", 2, "dot is -1", "0.01 to 20 mm"),
        ("diameter = 0.4", "diameter = 4", 2, "a dot 0.6 mm wide", "half as wide"),
        ("ms = 80", "ms = 0", 5, "ms is 0", "1 to 60000 ms"),
        (
            "output = 3",
            "output = \"paste\"",
            4,
            "no output is named `paste`",
            "name of the profile",
        ),
        ("board = -30", "board = 30", 7, "board is at Z 30", "Z goes from -80 to 0 mm"),
        ("clearance = 0", "clearance = -30", 6, "lifts above the clearance", "above board"),
        ("suck_ms = 20", "purge = [1, 1]", 8, "purge and purge_ms go together", "purge_ms = 500"),
        ("suck_ms = 20", "purge_ms = 9\npurge = [1, 900]", 9, "at Y 900", "a place of the machine"),
        (
            "suck_ms = 20",
            "[bead]\nfrom = 2\nslowest = 9\nfastest = 5",
            10,
            "slowest is 9",
            "at most",
        ),
        (
            "suck_ms = 20",
            "[bead]\nfrom = 2\nslowest = 1\nfastest = 5\nopens_ms = 1001",
            12,
            "opens_ms is 1001",
            "0 to 1000",
        ),
        (
            "suck_ms = 20",
            "[bead]\nfrom = 2\nslowest = 1\nfastest = 5\nthread = 2",
            12,
            "thread is 2",
            "shorter",
        ),
        (
            "suck_ms = 20",
            "[bead]\nfrom = nan\nslowest = 1\nfastest = 5",
            9,
            "from is NaN",
            "0.1 to 1000",
        ),
        ("ms = 80", "ms = -80", 5, "invalid value: integer `-80`", "numbers as they are"),
    ] {
        let wrong = needle(&NEEDLE.replacen(from, to, 1)).expect_err(to);
        assert!(wrong.text.contains(words) && wrong.hint.contains(hint), "{to}: {wrong:?}");
        assert_eq!(wrong.at.0, line, "{to}: {wrong:?}");
    }
}

#[test]
fn the_manuals_file_is_a_good_one() {
    let page = include_str!("../../../paste.md");
    let piece = page.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next());
    let read = needle(piece.expect("a file")).expect("good");
    assert!(read.touch.is_some() && (read.area() - 0.4712).abs() < 1e-3, "{}", read.area());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// No text makes the reader panic or hang.
    #[test]
    fn mutilated_layers_are_read_or_refused(at in 0..SAMPLE.len(), cut in 0usize..30, more in ".{0,6}") {
        let mut text = SAMPLE.to_owned();
        text.replace_range(at..(at + cut).min(SAMPLE.len()), &more);
        if let Ok(layer) = read(&text, None) {
            let _ = pads(&layer);
        }
    }

    /// Each dot lies on its pad, none is lost by the order, and their number is the area's.
    #[test]
    fn dots_lie_on_their_pads(
        sizes in prop::collection::vec((0.1f64..4.0, 0.1f64..4.0, -180.0f64..180.0), 1..5),
        area in 0.1f64..1.0,
    ) {
        let mut text = "x (mm),y,width,height,angle\n".to_owned();
        for (n, (w, h, angle)) in sizes.iter().enumerate() {
            text += &format!("{},5,{w},{h},{angle}\n", n * 9);
        }
        let pads = pads(&layer(&text)).expect("pads");
        prop_assert_eq!(pads.len(), sizes.len());
        let found = spread(&pads, area);
        let wanted: usize = sizes.iter().map(|(w, h, _)| ((w * h / area).round() as usize).max(1)).sum();
        // A slanted side's cells are right within a hundredth.
        prop_assert!(found.len().abs_diff(wanted) <= pads.len() + wanted / 50);
        for dot in &found {
            let near = |cell: &[f64; 2]| (cell[0] - dot.at[0]).hypot(cell[1] - dot.at[1]) < 0.03;
            prop_assert!(pads[dot.pad].cells.iter().any(near), "{:?}", dot);
        }
    }
}
