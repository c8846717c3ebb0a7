//! Slow points of scripts: which there are, and that they are never too fast.

use std::process::Command;

use firmware::motion::scaled::Scaled;
use lang::back::{self, Compiled, Courses};
use lang::front::source::Source;
use lang::front::{self, ProfileChoice};
use lang::hir::Program;
use lang::image::course::{Entry, MOST, entries};
use lang::part::{G2553, Part};
use lang::record::MachineRecord;
use proptest::prelude::*;

use super::bounds::Bounds;
use super::held::{self, Taken};
use super::{Found, Obstacle, Pace, join, points, walk};

/// A part that takes slow points.
const PART: Part = Part { course_pool: 24, ..G2553 };

fn program(text: &str) -> (Program, Compiled) {
    let source = Source::new("test.bas", text.to_owned());
    let (program, diags) = front::compile(&source, ProfileChoice::built_in());
    let program = program.unwrap_or_else(|| panic!("{text}\n{}", diags.render(&source)));
    let compiled = back::compile(&program).expect("it fits");
    (program, compiled)
}

fn courses(text: &str) -> Option<Courses> {
    let (program, compiled) = program(text);
    Found::of(&program, &compiled, &PART).map(|(found, _)| found.courses(&PART))
}

fn only(text: &str) -> Vec<Entry> {
    let courses = courses(text).unwrap_or_else(|| panic!("no slow points\n{text}"));
    assert_eq!(courses.records.len(), 1, "{text}\n{courses:?}");
    entries(&courses.records[0].1).collect()
}

/// An entry names up to 127 lines, which is what a path at one speed takes; its two ramps take fewer than 8 more.
fn most_entries(lines: usize) -> usize {
    lines.div_ceil(127) + 8
}

#[test]
fn a_straight_line_of_chords_wants_its_end_alone() {
    // Chords of 1 mm last 20 ms and more: nothing binds but the end of the line.
    let text = "G90\nG0 X0 Y0\nG91\nF3000\nREPEAT 100\nG1 X1\nEND REPEAT\n";
    let entries = only(text);
    assert!(entries.len() <= 2, "{entries:?}");
    assert_eq!(entries.iter().map(|entry| u32::from(entry.lines)).sum::<u32>(), 100);
    // Two feeds, so that none are joined: those of 0.1 mm, of 2 ms, are held to what planning and F take.
    let text = "G90\nG0 X0 Y0\nG91\nREPEAT 250\nG1 X0.1 F3000\nG1 X0.1 F2999\nEND REPEAT\n";
    let entries = only(text);
    let speed = points::value(entries[0].bound).sqrt();
    assert!(entries[0].holds && (21_000.0..29_500.0).contains(&speed), "{speed} {entries:?}");
    assert!(entries.len() < most_entries(500), "{entries:?}");
}

#[test]
fn lines_too_short_to_be_planned_are_joined_where_they_are_straight() {
    let joined = |text: &str| {
        let (program, compiled) = program(text);
        let (found, _) = Found::of(&program, &compiled, &PART).expect("slow points");
        found.made[0].iter().map(|line| line.joined).collect::<Vec<_>>()
    };
    let loops = |times: u32, line: &str| {
        format!("G90\nG0 X0 Y0\nG91\nF3000\nREPEAT {times}\n{line}\nEND REPEAT\n")
    };
    // 1 ms each: with the first segment of what follows two take 4.4 ms, three 5.2, and no more than 5.1 are there.
    let each = joined(&loops(2_000, "G1 X0.05"));
    assert_eq!((each[0], each[1], each.len()), (0, 1, 1001));
    let text = loops(2_000, "G1 X0.05");
    let entries = only(&text);
    assert!(entries.len() < most_entries(1001), "{entries:?}");
    assert_eq!(entries.iter().map(|entry| u32::from(entry.lines)).sum::<u32>(), 1001);
    assert_eq!((entries[0].joins, entries[entries.len() - 1].joins), (1, 0));
    // 2 ms each, of two axes; 20 ms each.
    assert_eq!(joined(&loops(99, "G1 X0.06 Y0.08"))[1..4], [1, 1, 1]);
    assert!(joined(&loops(99, "G1 X1")).iter().all(|joined| *joined == 0));
    // A curve that stays within half a step of 10 um of its chord, and one that does not.
    assert_eq!(joined(&loops(99, "G1 X0.05 Y0.05\nG1 X0.05 Y0.052"))[1..4], [1, 1, 1]);
    assert_eq!(joined(&loops(99, "G1 X0.1 Y0.1\nG1 X0.1 Y0.13"))[1..4], [0, 0, 0]);
    // Not in steps, not with another axis, not at another feed, not round a corner.
    for two in [
        "G1 X[4st]\nG1 X0.05",
        "G1 X0.05\nG1 X0.05 Y0.01",
        "G1 X0.05 F3000\nG1 X0.05 F2990",
        "G1 X0.5\nG1 X-0.05",
    ] {
        let text = loops(99, two);
        let (program, compiled) = program(&text);
        let Some((found, _)) = Found::of(&program, &compiled, &PART) else { continue };
        assert!(found.made.iter().flatten().all(|line| line.joined == 0), "{two}");
    }
}

#[test]
fn a_sharp_corner_rests_and_a_blunt_one_is_passed() {
    let sharp = "G90\nG0 X0 Y0\nF1500\nG1 X10\nG1 Y10\nG1 X20\n";
    assert_eq!(courses(sharp), None);
    let blunt = "G90\nG0 X0 Y0\nF1500\nG1 X10\nG1 X20 Y1\nG1 X30 Y1\n";
    let (program, compiled) = program(blunt);
    let (found, _) = Found::of(&program, &compiled, &PART).expect("slow points");
    let ends = held::ends(&found.records, &found.made[0], &found.bounds[0]);
    let speeds: Vec<f64> = ends.iter().flatten().map(|end| end.sqrt()).collect();
    assert!(matches!(speeds[..], [a, b, 0.0] if a > 4_000.0 && b > 4_000.0), "{speeds:?}");
}

#[test]
fn feeds_between_lines_bound_the_corners_between_them() {
    let entries = only("G90\nG0 X0 Y0\nG1 X10 F3000\nG1 X20 F600\nG1 X30 F3000\nG1 X40 F3000\n");
    let slow = points::value(entries[0].bound).sqrt();
    assert!((9_000.0..=10_000.0).contains(&slow), "{slow} {entries:?}");
}

#[test]
fn what_hangs_on_the_machine_has_none() {
    let path = "G1 X10 F1500\nG1 X20 Y1\nG1 X30 Y1\n";
    let on = |before: &str| courses(&format!("{before}G90\nG0 X0 Y0\n{path}"));
    assert!(on("").is_some());
    assert!(on("WaitIn 3, ON\nHome X, Y\nPRINT 5\n").is_some());
    for before in [
        "IF IN(3) THEN PRINT 1\n",
        "IF POS(X) > 5mm THEN PRINT 1\n",
        "DIM i AT 3000\n",
        "KEEP parts\nparts = parts + 1\n",
        "WaitIn? 3, ON, 5s\nIF TIMEDOUT THEN PRINT 1\n",
    ] {
        assert_eq!(on(before), None, "{before}");
        let (program, compiled) = program(&format!("{before}G90\nG0 X0 Y0\n{path}"));
        assert!(super::obstacle(&program, &compiled, &PART).is_some(), "{before}");
    }
    // Where the axes are when it begins is not known: a line says it of those that it names, and is no part of a course.
    assert_eq!(on("").map(|courses| courses.records.len()), Some(1));
    assert_eq!(courses(&format!("G90\n{path}")), None);
    let longer = format!("G90\n{path}G1 X40 Y1.1\n");
    let (program, compiled) = program(&longer);
    let lines = walk::walk(&program, &compiled).expect("an image").courses;
    assert_eq!(lines.iter().map(Vec::len).collect::<Vec<_>>(), [2]);
    // Without an absolute word nothing ever says where they are.
    assert_eq!(courses("G91\nF1500\nREPEAT 9\nG1 X5\nEND REPEAT\n"), None);
}

#[test]
fn a_loop_without_an_end_is_known_when_it_repeats_itself() {
    let text = "G90\nDO\nWaitStart\nG0 X0 Y0\nG1 X10 F1500\nG1 X20 Y1\nG1 X30 Y1\nLOOP\n";
    assert_eq!(only(text).len(), only(&text.replace("DO\n", "").replace("LOOP\n", "")).len());
    // One that counts what it has made never does.
    let counts = format!("DIM n\n{}", text.replace("LOOP", "n = n + 1\nLOOP"));
    assert_eq!(courses(&counts), None);
    let (program, compiled) = program(&counts);
    assert_eq!(super::obstacle(&program, &compiled, &PART), Some(Obstacle::Long));
}

#[test]
fn a_path_that_counts_on_without_an_end_is_told_of() {
    let told = |text: &str| {
        let (program, compiled) = program(text);
        assert_eq!(courses(text), None);
        super::obstacle(&program, &compiled, &PART)
    };
    let one = "DIM i\nF3000\nG90\nG0 X0 Y0\nDO\ni = i + 1\nG1 X[(i MOD 50) * 0.2mm] Y[(i MOD 7) * 0.1mm]\nLOOP\n";
    assert_eq!(told(one), Some(Obstacle::Long));
    let many = "DIM i, k\nF3000\nG90\nG0 X0 Y0\nDO\ni = i + 1\nFOR k = 1 TO 9\n\
                G1 X[((i + k) MOD 50) * 0.2mm] Y[(k MOD 7) * 0.1mm]\nNEXT\nSetOut 1, ON\nLOOP\n";
    assert_eq!(told(many), Some(Obstacle::Long));
    let differs = "SUB go(a AS LENGTH)\nG90\nG0 X0 Y0\nG1 X[a] F1500\nG1 X[a + 10mm] Y1\nG1 X[a + 20mm] Y1\nEND SUB\n\
                   go 10mm\ngo 0.3mm\n";
    assert_eq!(told(differs), Some(Obstacle::Differs(4)));
}

#[test]
fn a_switch_that_is_not_found_leaves_the_place_unknown() {
    let path = "F4000\nG1 X20 Y20\nG1 X40 Y40\nG1 X60 Y60\n";
    assert!(courses(&format!("G90\nG0 Y0\nHome X\n{path}")).is_some());
    assert_eq!(courses(&format!("G90\nG0 Y0\nHome? X\n{path}")), None);
}

#[test]
fn what_is_computed_between_lines_slows_them_down_to_rest() {
    let path = |statement: &str| {
        format!(
            "DIM i, j, k\nG90\nG0 X0 Y0\nF3000\nFOR i = 1 TO 40\n{statement}\nG1 X[i * 2mm] Y[(i MOD 2) * 0.2mm]\nNEXT\n"
        )
    };
    assert!(courses(&path("j = i * 3")).is_some());
    for statement in ["FOR k = 1 TO 1500\nNEXT", "j = SQR(i): j = SQR(i): j = SQR(i): j = SQR(i)"] {
        assert_eq!(courses(&path(statement)), None, "{statement}");
    }
}

#[test]
fn a_line_that_begins_different_courses_has_none() {
    let text = "SUB go(a AS LENGTH)\nG90\nG0 X0 Y0\nG1 X[a] F1500\nG1 X[a + 10mm] Y1\nG1 X[a + 20mm] Y1\nEND SUB\n";
    assert!(courses(&format!("{text}go 10mm\n")).is_some());
    assert_eq!(courses(&format!("{text}go 10mm\ngo 0.3mm\n")), None);
}

#[test]
fn a_line_outside_of_the_travel_ends_the_course_before_it() {
    // X ends at 300 mm.
    let text =
        "G90\nG0 X280 Y0\nG1 X290 F1500\nG1 X299 Y1\nG1 X305 Y1\nG1 X307 Y1.1\nG1 X309 Y1.1\n";
    let (program, compiled) = program(text);
    let lines = walk::walk(&program, &compiled).expect("an image").courses;
    // Whoever has passed there is not homed.
    assert_eq!(lines.iter().map(Vec::len).collect::<Vec<_>>(), [2, 2]);
}

/// Ctrl-C is of the whole process, so a process of its own is asked.
#[test]
fn ctrl_c_ends_the_search_for_slow_points() {
    let name = "course::tests::lines_rest_once_the_end_is_asked_for";
    let own = std::env::current_exe().expect("this test");
    let output = Command::new(own).args(["--exact", name, "--ignored"]).output();
    let output = output.expect("it runs");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && said.contains("1 passed"), "{said}");
}

#[test]
#[ignore = "asks for the end of its process"]
fn lines_rest_once_the_end_is_asked_for() {
    let (program, compiled) =
        program("G90\nG0 X0 Y0\nG91\nF3000\nREPEAT 100\nG1 X1\nG1 X1 Y0.05\nEND REPEAT\n");
    let pace = Pace::of(&PART, program.profile.pulse_us).expect("one");
    let lines = walk::walk(&program, &compiled).expect("an image").courses.remove(0);
    let before = Bounds::of(&lines, &program, &pace);
    assert!(points::entries(&before, points::FINEST).is_some());
    crate::interrupt::ask();
    assert_eq!(points::entries(&before, points::FINEST), None);
    let behind = Bounds::of(&lines, &program, &pace);
    assert_eq!((behind.most.len(), behind.most.iter().sum::<f64>()), (lines.len(), 0.0));
}

#[test]
fn an_entrys_bound_is_the_upper_half_of_a_number_of_the_planner() {
    for square in [1_u32, 16_000_000, 2_500_000_000, 77_777_777] {
        let number = Scaled::new(square).0;
        let bound = (number >> 16) as u16;
        let value = points::value(bound);
        let square = f64::from(square);
        assert!(value <= square && value > square * 0.99, "{square} {value}");
    }
}

#[test]
fn a_loop_is_one_course_though_its_last_lines_rest() {
    let text = "DIM i\nTABLE p(2) = 10mm, 0mm; 20mm, 1mm; 30mm, 1mm; 30mm, 20mm; 5mm, 20mm\nG90\nF1500\n\
                G0 X0 Y0\nFOR i = 0 TO COUNT(p) - 1\nG1 X[p(i, 0)] Y[p(i, 1)]\nNEXT\n";
    let lines: u32 = only(text).iter().map(|entry| u32::from(entry.lines)).sum();
    assert_eq!(lines, 5);
}

#[test]
fn a_line_that_is_also_made_alone_or_without_a_step_begins_no_course() {
    let table = |rows: &str, before: &str| {
        format!(
            "DIM i\nTABLE p(2) = {rows}\nG90\nF1500\n{before}\nFOR i = 0 TO COUNT(p) - 1\n\
             G1 X[p(i, 0)] Y[p(i, 1)]\nNEXT\n"
        )
    };
    let rows = "10mm, 0mm; 20mm, 1mm; 30mm, 1mm; 40mm, 1.2mm";
    assert!(courses(&table(rows, "G0 X0 Y0")).is_some());
    // Nobody knows where it begins: the first line is alone.
    assert_eq!(courses(&table(rows, "")), None);
    // The first one has no steps to make.
    assert_eq!(courses(&table(rows, "G0 X10 Y0")), None);
}

/// Words of relative lines: mostly small turns, as curves have them.
fn script() -> impl Strategy<Value = String> {
    let line = (-3.2_f64..3.2, 60.0_f64..4_000.0, prop_oneof![4 => Just(false), 1 => Just(true)]);
    let pieces = prop_oneof![3 => Just(1_usize), 1 => 2..30_usize];
    let lines = prop::collection::vec((line, pieces), 2..40);
    (lines, 1_u32..8, prop_oneof![Just(600), Just(1500), Just(3000), Just(4800)], any::<bool>())
        .prop_map(|(lines, times, feed, diagonal)| {
            let mut angle = if diagonal { 0.8 } else { 0.0_f64 };
            let mut text = format!("G90\nG0 X150 Y100\nG91\nF{feed}\nREPEAT {times}\n");
            for ((turn, um, sharp), pieces) in lines {
                angle += if sharp { turn } else { turn / 20.0 };
                let um = if pieces == 1 { um } else { um / 20.0 + 40.0 };
                let [x, y] = [angle.cos(), angle.sin()]
                    .map(|part| (part * um / 1000.0 * 100.0).round() / 100.0);
                text += &format!("G1 X{x:.2} Y{y:.2}\n").repeat(pieces);
            }
            text + "END REPEAT\n"
        })
}

proptest! {
    /// Each line that a record serves ends no faster than it may, and hardly slower than it can.
    #[test]
    fn records_are_never_too_fast_and_hardly_slow(text in script()) {
        let (program, compiled) = program(&text);
        let pace = Pace::of(&PART, program.profile.pulse_us).expect("one");
        for lines in walk::walk(&program, &compiled).unwrap_or_default().courses {
            let made = join::join(&lines, &MachineRecord::of(&program.profile), &pace);
            let whole: usize = made.iter().map(|line| usize::from(line.joined) + 1).sum();
            prop_assert_eq!(whole, lines.len());
            let lines = made;
            let bounds = Bounds::of(&lines, &program, &pace);
            let Some(record) = points::entries(&bounds, points::FINEST) else {
                prop_assert!(bounds.most.iter().all(|most| *most == 0.0));
                continue;
            };
            prop_assert!(record.iter().all(|entry| (1..=MOST).contains(&entry.lines)));
            let mut taken = Taken::new(&record);
            for n in 0..lines.len() {
                if taken.is_over() {
                    prop_assert!(bounds.most[n..].iter().all(|most| *most == 0.0), "line {}", n);
                    break;
                }
                let end = taken.next(bounds.ramp[n]);
                prop_assert_eq!(taken.joins, bounds.joins[n]);
                prop_assert!(end <= bounds.most[n].max(bounds.rest), "line {}: {} of {}", n, end, bounds.most[n]);
                let wanted = bounds.best[n] * 0.95 - bounds.rest;
                prop_assert!(end >= wanted, "line {}: {} of {}", n, end, bounds.best[n]);
            }
            prop_assert!(taken.is_over());
        }
    }
}
