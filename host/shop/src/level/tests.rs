use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::profile::Profile;
use proptest::prelude::*;

use super::{Heights, Probe, correct, probe};

/// A plane that rises by 1 mm in 100 mm of X, and half of that in Y.
const PLANE: &str = "x,y,z\n0,0,0\n50,0,0.5\n100,0,1\n0,50,0.25\n50,50,0.75\n100,50,1.25\n";
const JOB: &str = "(a pocket)\nG21 G90\nG0 X10 Y10 Z5\nG1 Z-1 F300 (down)\nX60 F600\nG2 X60 Y20 I0 J5\n\
                   G91\nG1 X-10\nG90\nG0 Z5\nM5\nM30\n";

fn heights(text: &str) -> Heights {
    Heights::parse(text).unwrap_or_else(|wrong| panic!("{wrong:?}"))
}

fn corrected(job: &str) -> super::Corrected {
    correct(job, &heights(PLANE), 20.0).unwrap_or_else(|wrong| panic!("{wrong:?}"))
}

#[test]
fn lines_are_split_arcs_become_lines_and_each_gets_the_height_below_it() {
    let made = corrected(JOB);
    insta::assert_snapshot!(made.text);
    assert_eq!(made.text.lines().count(), made.places.len());
    assert_eq!((made.moves[0], made.places.last()), (6, Some(&12)));
}

#[test]
fn inches_stay_inches() {
    let made = corrected("G20\nG0 X1 Y1 Z0.1\nG1 Z-0.05 F10\nX2\n");
    let last = made.text.lines().last().expect("a line");
    // 50.8 mm and 25.4 mm: 0.508 + 0.127 mm higher.
    assert_eq!(last, "G1 X2.00000 Y1.00000 Z-0.02500");
}

#[test]
fn heights_come_from_what_a_script_printed_or_from_a_table() {
    let table = heights(PLANE);
    let printed: String = PLANE
        .lines()
        .skip(1)
        .map(|line| format!("  1.2 s PRINT height {}\n", line.replace(',', "mm ") + "mm"))
        .collect();
    assert_eq!(heights(&format!("Loading\n{printed}done 1 2 3\n")), table);
    assert!(
        (table.at(25.0, 25.0) - 0.375).abs() < 1e-9 && (table.at(200.0, 0.0) - 1.0).abs() < 1e-9
    );
    assert!((table.pitch() - 50.0).abs() < 1e-9);
    for (text, words) in [
        ("", "a file without heights"),
        ("1,2,3\n1,2,x\n", "`1,2,x` is no height"),
        ("0,0,1\n0,1,1\n", "1 columns and 2 rows are no surface"),
        ("0,0,1\n0,1,1\n1,0,1\n", "no height at X 1 Y 1"),
        ("0,0,1\n0,1,1\n1,0,1\n1,1,1\n1,1,2\n", "a second height at X 1 Y 1"),
        ("0,0,0\n0,1,0\n1,0,0\n1,1,900\n", "a height of 900 mm"),
        ("0,0,nan\n", "`0,0,nan` is no height"),
    ] {
        let wrong = Heights::parse(text).expect_err(text);
        assert!(wrong.text.contains(words) && !wrong.hint.is_empty(), "{wrong:?}");
    }
}

#[test]
fn what_cannot_be_corrected_is_told_by_line() {
    for (job, words) in [
        (
            "G0 X0 Y0 Z1\nG1 X120 F100\n",
            "2: X 120 Y 0 lies outside of the heights: X 0 to 100, Y 0 to 50",
        ),
        ("G1 X10 F100\n", "1: the job has not said where X, Y and Z are"),
        ("G0 X0 Y0 Z1\nG81 X5 Z-1 R1\n", "2: G81 cannot be corrected"),
        ("G0 X#1\n", "1: `X#1` is no word of G-code"),
        ("PRINT 1\n", "1: `PRINT 1` is no word"),
        ("G91\nG0 X1\n", "2: a relative move from a place"),
        ("G0 X0 Y0 Z1\nG2 X5 Y5\n", "2: an arc without a middle"),
        ("M3\n", "1: a job without a move"),
        ("G0 X0 Y0 Z1\nG53 G0 Z0\nG1 X5\n", "3: the job has not said where"),
    ] {
        let wrong = correct(job, &heights(PLANE), 20.0).expect_err(job);
        let told = format!("{}: {}", wrong[0].at.0, wrong[0].text);
        assert!(told.contains(words) && !wrong[0].hint.is_empty(), "{job}: {told}");
    }
}

#[test]
fn the_probing_script_compiles() {
    let mill = Profile::built_in("mill").expect("built in");
    let wish =
        Probe { low: [10.0, 10.0], high: [90.0, 60.0], count: [5, 4], lift: -10.0, deepest: -20.0 };
    let text = probe(&wish, &mill).expect("a script");
    insta::assert_snapshot!(text);
    let source = Source::new("job", text.clone());
    let (program, found) = compile(&source, ProfileChoice::built_in());
    assert!(program.is_some(), "{}\n{text}", found.render(&source));
    for wish in [
        Probe { high: [5.0, 60.0], ..wish },
        Probe { count: [1, 4], ..wish },
        Probe { deepest: 0.0, ..wish },
    ] {
        assert!(probe(&wish, &mill).is_err(), "{wish:?}");
    }
}

/// Places of the corrected job.
fn places(text: &str) -> Vec<[f64; 3]> {
    let mut out = Vec::new();
    for line in text.lines().filter(|line| line.starts_with("G1 X")) {
        let mut words = line.split(' ').skip(1).map(|word| word[1..].parse::<f64>());
        let mut next = || words.next().expect("a word").expect("a number");
        out.push([next(), next(), next()]);
    }
    out
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    /// Each place of a corrected line lies on it, as deep as the job says, and no piece is too long.
    #[test]
    fn corrected_lines_keep_their_depth(
        from in (0.0f64..100.0, 0.0f64..50.0),
        to in (0.0f64..100.0, 0.0f64..50.0),
        split in 0.5f64..30.0,
    ) {
        let job = format!("G0 X{:.3} Y{:.3} Z2\nG1 Z-1 F100\nX{:.3} Y{:.3}\n", from.0, from.1, to.0, to.1);
        let made = correct(&job, &heights(PLANE), split).expect("covered");
        let places = places(&made.text);
        let far = |a: &[f64; 3], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        for pair in places.windows(2) {
            prop_assert!(far(&pair[0], [pair[1][0], pair[1][1]]) <= split + 0.002);
        }
        for [x, y, z] in &places {
            prop_assert!((z - (x / 100.0 + y / 200.0 - 1.0)).abs() < 0.002, "{} {} {}", x, y, z);
        }
        prop_assert!(far(places.last().expect("a place"), [to.0, to.1]) < 0.002);
    }

    /// No text makes it panic.
    #[test]
    fn any_text_is_corrected_or_refused(at in 0..JOB.len(), cut in 0usize..9, more in ".{0,6}") {
        let mut job = JOB.to_owned();
        job.replace_range(at..(at + cut).min(JOB.len()), &more);
        let _ = correct(&job, &heights(PLANE), 5.0);
        let _ = Heights::parse(&job);
    }
}
