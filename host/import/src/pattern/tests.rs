//! Patterns and lists against scripts: what is written compiles, and meets the very points.

use lang::profile::Profile;
use proptest::prelude::*;

use super::table::{Row, find, place, text};
use super::{Act, Down, Frame, Pair, Pattern, Point, Shape, Work, read, write};

const FILES: [(&str, &[u8]); 7] = [
    ("kicad.pos", include_bytes!("data/kicad.pos")),
    ("kicad.csv", include_bytes!("data/kicad.csv")),
    ("glue.csv", include_bytes!("data/glue.csv")),
    ("altium.csv", include_bytes!("data/altium.csv")),
    ("plain.txt", include_bytes!("data/plain.txt")),
    ("drill.gbr", include_bytes!("data/drill.gbr")),
    ("drill.drl", include_bytes!("data/drill.drl")),
];

fn mill() -> Profile {
    Profile::built_in("mill").expect("built in")
}

fn drilling() -> Work {
    let down = Down { surface: -20_000, depth: 1800, clear: 2000, feed: 2000 };
    Work { down: Some(down), spindle: true, act: Act::Nothing }
}

fn pattern(shape: Shape, work: Work) -> Pattern {
    Pattern { shape, origin: [10_000, 5000], frame: None, work, name: "holes".to_owned() }
}

fn written(pattern: &Pattern) -> String {
    match write(pattern, &mill(), None) {
        Ok(made) => {
            let notes: String = made.notes.iter().map(|note| format!("note: {note}\n")).collect();
            format!("{} points\n{notes}{}", made.count, made.text)
        }
        Err(words) => panic!("{words}"),
    }
}

fn refused(pattern: &Pattern) -> String {
    write(pattern, &mill(), None).expect_err("it is refused")
}

#[test]
fn regular_patterns_are_loops() {
    let grid = Shape::Grid { count: [5, 3], pitch: [12_700, 10_000], zigzag: false };
    insta::assert_snapshot!("grid", written(&pattern(grid, drilling())));
    let to_and_fro = Shape::Grid { count: [4, 2], pitch: [2540, -2540], zigzag: true };
    let glue = Work { act: Act::Pulse { output: 3, ms: 250 }, ..Work::default() };
    insta::assert_snapshot!("zigzag", written(&pattern(to_and_fro, glue)));
    let line = Shape::Line { count: 7, way: [60_000, -1000] };
    let wait = Work { act: Act::Wait { ms: 500 }, ..Work::default() };
    insta::assert_snapshot!("line", written(&pattern(line, wait)));
    let sockets = Shape::Sockets { count: 2, apart: 25_400, pins: 7, pitch: 2540, rows: 7620 };
    insta::assert_snapshot!("sockets", written(&pattern(sockets, drilling())));
}

#[test]
fn circles_and_lists_are_tables() {
    let circle = Shape::Circle { count: 6, diameter: 40_000, first_mdeg: 90_000 };
    insta::assert_snapshot!("circle", written(&pattern(circle, drilling())));
    for (name, bytes) in FILES {
        let list = read(name, bytes).unwrap_or_else(|diags| panic!("{name}: {diags:?}"));
        let shape = Shape::Points(list.points.clone());
        let mut pattern = pattern(shape, drilling());
        // KiCad counts Y downward from the sheet's corner.
        pattern.origin = [0, if list.points[0].at[1] < 0 { 60_000 } else { 0 }];
        let told = list.notes.join("\n");
        let shown = format!("{}\n{told}\n{}", list.what, written(&pattern));
        insta::assert_snapshot!(name.replace('.', "_"), shown);
    }
}

#[test]
fn taught_points_shift_and_turn_a_drawing() {
    let grid = Shape::Grid { count: [2, 2], pitch: [50_000, 20_000], zigzag: false };
    let mut pattern = pattern(grid, drilling());
    pattern.origin = [0, 0];
    let pair = |drawn: [i64; 2], taught: [i64; 2]| Pair { drawn, taught };
    // A quarter turn to the left about the zero, which lies at 100, 40.
    let pairs = vec![pair([0, 0], [100_000, 40_000]), pair([50_000, 0], [100_000, 90_000])];
    pattern.frame = Some(Frame { pairs, mirrored: false });
    let text = written(&pattern);
    insta::assert_snapshot!("turned", text);
    assert!(text.contains("100mm, 40mm; 100mm, 90mm; 80mm, 40mm; 80mm, 90mm"), "{text}");
    // A twentieth of an inch per inch too long: refused; a thousandth: told.
    let set = |pattern: &mut Pattern, pairs: Vec<Pair>, mirrored| {
        pattern.frame = Some(Frame { pairs, mirrored });
    };
    set(&mut pattern, vec![pair([0, 0], [0, 0]), pair([50_000, 0], [52_500, 0])], false);
    assert!(refused(&pattern).contains("(+5.00 %)"), "{}", refused(&pattern));
    set(&mut pattern, vec![pair([0, 0], [0, 0]), pair([50_000, 0], [50_100, 0])], false);
    assert!(written(&pattern).contains("note: the machine measures +0.20 %"));
    // Seen from behind: three points tell.
    let mirrored = vec![
        pair([0, 0], [60_000, 10_000]),
        pair([50_000, 0], [10_000, 10_000]),
        pair([0, 20_000], [60_000, 30_000]),
    ];
    set(&mut pattern, mirrored.clone(), false);
    assert!(refused(&pattern).contains("when the drawing is mirrored"), "{}", refused(&pattern));
    set(&mut pattern, mirrored, true);
    assert!(written(&pattern).contains("60mm, 10mm; 10mm, 10mm; 60mm, 30mm; 10mm, 30mm"));
    set(&mut pattern, vec![pair([0, 0], [0, 0]), pair([500, 0], [500, 0])], false);
    assert!(refused(&pattern).contains("closer than 1 mm"));
    set(&mut pattern, Vec::new(), false);
    assert!(refused(&pattern).contains("1 to 8 taught points"));
}

#[test]
fn a_piece_takes_names_that_are_free() {
    let circle = Shape::Circle { count: 3, diameter: 20_000, first_mdeg: 0 };
    let into = "DIM i\nTABLE Holes(2) = 1mm, 2mm\nCONST above = 1mm\nG91 G0 X1\n";
    let made = write(&pattern(circle, drilling()), &mill(), Some(into)).expect("a piece");
    assert!(made.text.contains("TABLE holes_2(2) ="), "{}", made.text);
    assert!(made.text.contains("ABOVE_2 = SURFACE + 2mm"), "{}", made.text);
    assert!(made.text.contains("FOR i_2 = 0 TO COUNT(holes_2) - 1"), "{}", made.text);
    assert!(made.text.contains("\nG90\n") && !made.text.contains("PROFILE"), "{}", made.text);
    assert!(!made.text.contains("Home"), "{}", made.text);
}

#[test]
fn what_a_machine_cannot_do_is_told() {
    let line = |way| Shape::Line { count: 3, way };
    let far = written(&pattern(line([400_000, 0]), drilling()));
    assert!(far.contains("note: 1 of 3 points lie outside of the machine's travel"), "{far}");
    let mut deep = pattern(line([10_000, 0]), drilling());
    deep.work.down = Some(Down { surface: -79_000, depth: 1800, clear: 2000, feed: 2000 });
    assert!(written(&deep).contains("note: Z -80.8mm lies outside"));
    let mut wrong = pattern(
        line([10_000, 0]),
        Work { act: Act::Pulse { output: 17, ms: 5 }, ..Work::default() },
    );
    assert!(refused(&wrong).contains("no output 17"));
    wrong.work.act = Act::Wait { ms: 0 };
    assert!(refused(&wrong).contains("1 ms to 1 h"));
    wrong.work.act = Act::Nothing;
    for name in ["", "5a", "G1", "x", "FOR", "a b", "a\nStopAll", "holes' "] {
        name.clone_into(&mut wrong.name);
        let words = write(&wrong, &mill(), None).expect_err(name);
        assert!(words.contains("is no name"), "{name}: {words}");
    }
    let mut profile = mill();
    profile.y = None;
    let words =
        write(&pattern(line([1000, 0]), Work::default()), &profile, None).expect_err("no Y");
    assert_eq!(words, "the machine `mill` has no axis Y");
    for shape in [
        Shape::Grid { count: [1000, 1000], pitch: [10, 10], zigzag: false },
        Shape::Grid { count: [2, 2], pitch: [0, 10], zigzag: false },
        Shape::Grid { count: [i64::MAX, 2], pitch: [1, 10], zigzag: false },
        Shape::Circle { count: 0, diameter: 10, first_mdeg: 0 },
        Shape::Circle { count: 5, diameter: -10, first_mdeg: i64::MIN },
        Shape::Line { count: 2, way: [0, 0] },
        Shape::Line { count: 2, way: [i64::MIN, 0] },
        Shape::Sockets { count: i64::MAX, apart: i64::MAX, pins: 7, pitch: 1, rows: 1 },
        Shape::Points(Vec::new()),
        Shape::Points(vec![Point { at: [i64::MIN, 0], ..Point::default() }]),
    ] {
        assert!(
            write(&pattern(shape.clone(), Work::default()), &mill(), None).is_err(),
            "{shape:?}"
        );
    }
}

#[test]
fn wrong_lists_are_told_by_line() {
    for (text, wanted) in [
        ("", "a list without a point"),
        ("x;y\n", "a list without a point"),
        ("x,y\n1,2\n3,abc\n", "3:1: `abc` is no length"),
        ("x,y\n1,2\n3\n", "3:1: `` is no length"),
        ("x,y\n1,99999\n", "2:1: `99999` lies beyond 10 m"),
        ("x,y\n1,1e5\n", "2:1: `1e5` is no length"),
        ("hello\nworld\n", "a list without a point"),
        (
            "%FSLAX46Y46*%\n%MOMM*%\n%TF.FileFunction,Copper,L1,Top*%\nD10*\nM02*\n",
            "the layer Copper",
        ),
        ("%FSLAX46Y46*%\n%MOMM*%\nX1Y1D03*\nG36*\nM02*\n", "4:1: a region"),
        ("%FSLAX46Y46*%\nX1Y1D03*\nM02*\n", "2:1: a place before %FS and %MO"),
        ("# Ref Val Package PosX PosY Rot Side\nC1 1 2\n", "2:1: a line of KiCad's"),
        ("M48\nMETRIC\nT1C1\n%\nT1\nX1.0Q2\nM30\n", "6:"),
    ] {
        let diags = match read("a", text.as_bytes()) {
            Ok(list) => panic!("{text}: {list:?}"),
            Err(diags) => diags,
        };
        let shown: Vec<String> =
            diags.iter().map(|diag| format!("{}:{}: {}", diag.line, diag.col, diag.text)).collect();
        assert!(shown.iter().any(|line| line.contains(wanted)), "{text}: {shown:?}");
    }
}

#[test]
fn tables_are_found_and_written_back() {
    let script = "' A job.\nPROFILE \"mill\"\nTABLE spots(2) = 10mm, 5mm; _ ' left clamp\n  -2cm, 0.5in; _\n  \
                  1mm, 2mm ' right: \"b\"\nTABLE pads = 10mm, -12.54mm\nTABLE no(2) = 1, 2; 3, 4\n\
                  TABLE sums = 1mm + 2mm\nHome\nG0 X1\n";
    let script = script.replace("-2cm", "-20mm");
    let tables = find(&script);
    let names: Vec<&str> = tables.iter().map(|table| table.name.as_str()).collect();
    assert_eq!(names, ["spots", "pads"]);
    let rows: Vec<(&str, &[i64])> =
        tables[0].rows.iter().map(|row| (row.name.as_str(), &row.at[..])).collect();
    let wanted: [(&str, &[i64]); 3] = [
        ("left clamp", &[10_000, 5000]),
        ("", &[-20_000, 12_700]),
        ("right: \"b\"", &[1000, 2000]),
    ];
    assert_eq!(rows, wanted);
    let again = text("spots", 2, "", &tables[0].rows).expect("a table");
    insta::assert_snapshot!("rewritten", again);
    assert_eq!(script[tables[1].span[0]..tables[1].span[1]], *"TABLE pads = 10mm, -12.54mm");
    assert_eq!(&script[place(&script)..], "Home\nG0 X1\n");
    assert_eq!(place("Home\n"), 0);
    assert_eq!(place("' a\n' b\n\nHome\n"), 4, "a head's remark stays above");
}

/// A list of rows, with names that may be hostile.
fn rows(columns: usize) -> impl Strategy<Value = Vec<Row>> {
    let row = ("[a-z' _;,:\"]{0,8}", prop::collection::vec(-10_000_000i64..=10_000_000, columns));
    prop::collection::vec(row.prop_map(|(name, at)| Row { name, at }), 1..30)
}

proptest! {
    #[test]
    fn any_table_comes_back(list in (1usize..=3).prop_flat_map(rows)) {
        let columns = list[0].at.len();
        let made = text("spots", columns, "", &list).expect("a table");
        let whole = format!("DIM a\n{made}\nHome\n");
        let found = find(&whole);
        prop_assert_eq!(found.len(), 1, "{}", whole);
        let places: Vec<&Vec<i64>> = found[0].rows.iter().map(|row| &row.at).collect();
        prop_assert_eq!(places, list.iter().map(|row| &row.at).collect::<Vec<_>>(), "{}", &whole);
        for (found, given) in found[0].rows.iter().zip(&list) {
            prop_assert_eq!(&found.name, &crate::script::clean(&given.name), "{}", &whole);
        }
        prop_assert_eq!(&whole[found[0].span[0]..found[0].span[1]], made.as_str());
    }

    #[test]
    fn no_file_does_harm(text in "[-0-9a-zA-Z;,.%*\n\t \"#XYD]{0,200}") {
        let _ = read("a.csv", text.as_bytes());
        let _ = read("a.gbr", format!("%FSLAX46Y46*%\n%MOMM*%\n{text}").as_bytes());
        let _ = read("a.pos", format!("# Ref PosX\n{text}").as_bytes());
        let _ = find(&text);
        let _ = find(&format!("TABLE {text}"));
        prop_assert!(place(&text) <= text.len());
    }

    #[test]
    fn a_frame_brings_each_taught_point_back(
        turn in 0.0f64..6.2, shift in [-500_000i64..500_000, -500_000..500_000],
        points in prop::collection::vec([-300_000i64..300_000, -300_000..300_000], 2..8),
        mirrored: bool,
    ) {
        let there = |at: [i64; 2]| {
            let [x, y] = [if mirrored { -at[0] } else { at[0] } as f64, at[1] as f64];
            let (sin, cos) = turn.sin_cos();
            [shift[0] + (cos * x - sin * y).round() as i64, shift[1] + (sin * x + cos * y).round() as i64]
        };
        let pairs: Vec<Pair> = points.iter().map(|at| Pair { drawn: *at, taught: there(*at) }).collect();
        let apart = pairs.iter().flat_map(|a| pairs.iter().map(move |b| {
            ((a.drawn[0] - b.drawn[0]) as f64).hypot((a.drawn[1] - b.drawn[1]) as f64)
        })).fold(0.0, f64::max);
        prop_assume!(apart > 20_000.0);
        let fit = Frame { pairs: pairs.clone(), mirrored }.fit().expect("it fits");
        for pair in &pairs {
            let at = fit.place(pair.drawn);
            prop_assert!((0..2).all(|i| (at[i] - pair.taught[i]).abs() <= 5), "{at:?} {pair:?} {}", fit.words);
        }
    }
}
