//! Pictures of a made-up run.

use lang::axis::Axis;
use lang::hir::Program;
use lang::profile::Profile;

use super::curve::curves;
use super::{Form, Plot};
use crate::sim::record::{ArcShape, Edge, OutputUse, Record, Segment, SegmentKind, Summary};
use crate::sim::trace::{MoveKind, Status};
use crate::sim::{End, Outcome};

fn segment(kind: SegmentKind, line: u32, from: [i32; 3], to: [i32; 3], us: (u64, u64)) -> Segment {
    Segment {
        kind,
        line,
        from,
        to,
        axes: [0, 1, 2].map(|i| from[i] != to[i]),
        arc: None,
        start_us: us.0,
        end_us: us.1,
        peak_rate: 4000.0,
        exit_speed: None,
    }
}

fn program() -> Program {
    Program {
        profile: Profile::built_in("mill").expect("built in"),
        vars: Vec::new(),
        tables: Vec::new(),
        routines: Vec::new(),
        labels: Vec::new(),
        ports: Vec::new(),
        statements: 0,
        last_line: 9,
    }
}

fn outcome() -> Outcome {
    let rapid = SegmentKind::Move(MoveKind::Rapid);
    let line = SegmentKind::Move(MoveKind::Line);
    let mut arc = segment(
        SegmentKind::Move(MoveKind::Arc),
        4,
        [3000, 1000, 0],
        [1000, 3000, 0],
        (2_500_000, 3_600_000),
    );
    arc.arc = Some(ArcShape {
        center: [10_000.0, 10_000.0, 0.0],
        plane: [Axis::X, Axis::Y],
        start: 0.0,
        sweep: std::f64::consts::FRAC_PI_2,
    });
    let path = vec![
        segment(rapid, 1, [0, 0, 0], [3000, 1000, 0], (0, 1_000_000)),
        segment(line, 2, [3000, 1000, 0], [3000, 1000, -400], (1_200_000, 1_500_000)),
        segment(rapid, 3, [3000, 1000, -400], [3000, 1000, 0], (1_500_000, 1_700_000)),
        arc,
        segment(line, 5, [1000, 3000, 0], [0, 0, 0], (3_600_000, 5_000_000)),
    ];
    let record = Record {
        path,
        inputs: vec![Edge { us: 2_000_000, n: 3, on: true }],
        outputs: vec![
            Edge { us: 1_100_000, n: 1, on: true },
            Edge { us: 1_600_000, n: 1, on: false },
            Edge { us: 4_000_000, n: 5, on: true },
        ],
        truncated: false,
    };
    Outcome {
        end: End { status: Status::Done, fault: None, line: 9 },
        summary: Summary {
            status: Status::Done,
            fault: None,
            stopped: None,
            line: 9,
            us: 5_200_000,
            statements: 9,
            steps: [5000, 4000, 800],
            travel_um: [50_000, 40_000, 8_000],
            outputs: vec![OutputUse { n: 1, switched_on: 1, on_us: 500_000 }],
        },
        record,
        vars: Vec::new(),
        failures: Vec::new(),
    }
}

const SOURCE: &str = "G0 X30 Y10\nG1 Z-4 F300\nG0 Z0\nG3 X10 Y30 I-20 J0\nG1 X0 Y0 ' </script>\n";

fn drawn(form: Form) -> String {
    let (program, outcome) = (program(), outcome());
    Plot { title: "a & b.bas", source: SOURCE, program: &program, outcome: &outcome }.render(form)
}

#[test]
fn the_svg_shows_styles_holes_rows_and_lines() {
    let text = drawn(Form::Svg).replace('\n', "");
    for part in [
        "a &amp; b.bas",
        "class=\"path rapid\"",
        "class=\"path cut v7\"",
        "line, arc: 0 to",
        "Step rate, steps/s",
        "class=\"path rate-x\"",
        "line 4: G3 X10 Y30 I-20 J0",
        "line 2: G1 Z-4 F300 at X 30.000 Y 10.000",
        "out 1 spindle on for 500 ms",
        ">out 5<",
        ">in 3<",
    ] {
        assert!(text.contains(part), "no `{part}` in\n{text}");
    }
}

#[test]
fn the_page_holds_its_data_and_nothing_in_it_ends_the_script() {
    let text = drawn(Form::Html);
    assert_eq!(text.matches("</script>").count(), 1);
    assert!(text.contains("a &amp; b.bas") && text.contains("\\u003c/script>"));
    assert!(!text.contains("{{") && !text.contains("http"), "a mark was left or a link made");
}

#[test]
fn points_follow_time_and_an_arc_follows_its_circle() {
    let (program, outcome) = (program(), outcome());
    for curve in curves(&outcome.record.path, &program.profile, 100) {
        let times: Vec<f64> = curve.points.iter().map(|point| point.us).collect();
        assert!(times.is_sorted(), "{times:?}");
        let segment = outcome.record.path.iter().find(|segment| segment.line == curve.line);
        let end = segment.map(|segment| segment.to.map(|steps| f64::from(steps) / 100.0));
        let last = curve.points.last().map(|point| point.at.map(|mm| (mm * 1e6).round() / 1e6));
        assert_eq!(last, end);
        if curve.arc {
            for point in &curve.points {
                let radius = (point.at[0] - 10.0).hypot(point.at[1] - 10.0);
                assert!((radius - 20.0).abs() < 1e-6, "{radius}");
            }
            assert!(curve.points.len() >= 9);
        }
    }
}

#[test]
fn axes_that_run_together_are_drawn_together() {
    let axe = SegmentKind::Move(MoveKind::Axe);
    let path = [
        segment(axe, 1, [0, 0, 0], [1000, 0, 0], (0, 1_000_000)),
        segment(axe, 2, [0, 0, 0], [0, 2000, 0], (500_000, 2_000_000)),
    ];
    let curves = curves(&path, &program().profile, 100);
    let second = curves[1].points.last().expect("points");
    assert_eq!(second.at, [10.0, 20.0, 0.0]);
    let halfway = curves[1].points.iter().find(|point| point.us == 500_000.0).expect("its begin");
    assert!(halfway.at[0] > 1.0 && halfway.at[0] < 9.0, "{halfway:?}");
}

#[test]
fn a_run_without_moves_or_time_is_drawn_too() {
    let program = program();
    let mut outcome = outcome();
    outcome.record = Record::default();
    outcome.summary.us = 0;
    let plot = Plot { title: "", source: "", program: &program, outcome: &outcome };
    assert!(!plot.render(Form::Svg).contains("NaN"));
    let page = plot.render(Form::Html);
    let data = page.lines().find(|line| line.starts_with("const RUN")).expect("the data");
    assert!(data.contains("\"curves\":[]") && !data.contains("null"), "{data}");
}

#[test]
fn a_corner_is_drawn_at_the_speed_that_the_planner_tells() {
    let line = SegmentKind::Move(MoveKind::Line);
    let mut path = [
        segment(line, 1, [0, 0, 0], [1000, 0, 0], (0, 500_000)),
        segment(line, 2, [1000, 0, 0], [1000, 1000, 0], (500_000, 1_000_000)),
    ];
    // 1000 steps are 10 mm: 7 mm/s are 700 steps/s.
    path[0].exit_speed = Some(7_000.0);
    let program = program();
    let corner = |path: &[_]| {
        let curves = curves(path, &program.profile, 100);
        let exit = curves[0].points.last().map(|point| point.rate.round());
        (exit, curves[1].points.first().map(|point| point.rate.round()))
    };
    assert_eq!(corner(&path), (Some(700.0), Some(700.0)));
    // At rest, both leave and come at the start rate.
    path[0].exit_speed = Some(0.0);
    assert_eq!(corner(&path), (Some(400.0), Some(400.0)));
}
