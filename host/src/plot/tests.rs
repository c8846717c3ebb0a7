//! Pictures of a made-up run.

use lang::axis::Axis;
use lang::hir::Program;
use lang::profile::Profile;

use super::curve::curves;
use super::{Form, Plot};
use crate::sim::record::{
    ArcShape, Begun, Edge, OutputUse, Printed, Record, Segment, SegmentKind, Summary,
};
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
        power: None,
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
        analogs: Vec::new(),
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
        begun: [(0, 1), (1_100_000, 6), (1_200_000, 2), (1_700_000, 7), (2_500_000, 4)]
            .map(|(us, line)| Begun { us, line })
            .to_vec(),
        printed: vec![Printed { us: 1_800_000, line: 7, text: "hole <1>".to_owned() }],
        truncated: false,
        ..Record::default()
    };
    Outcome {
        late_line: false,
        end: End { status: Status::Done, fault: None, line: 9 },
        summary: Summary {
            status: Status::Done,
            fault: None,
            stopped: None,
            line: 9,
            program: None,
            us: 5_200_000,
            statements: 9,
            steps: [5000, 4000, 800],
            travel_um: [50_000, 40_000, 8_000],
            outputs: vec![OutputUse { n: 1, switched_on: 1, on_us: 500_000 }],
        },
        record,
        vars: Vec::new(),
        failures: Vec::new(),
        unattended: Default::default(),
        program: 0,
        onward: None,
        cell: None,
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

/// The data that the page's viewer gets.
fn data_of(page: &str) -> serde_json::Value {
    let line = page.lines().find_map(|line| line.strip_prefix("const RUN = ")).expect("the data");
    serde_json::from_str(line.trim_end_matches(';')).expect("JSON")
}

#[test]
fn the_line_that_runs_is_that_of_the_statement_and_of_the_move_where_one_moves() {
    let page = data_of(&drawn(Form::Html));
    let told: Vec<(u64, u64)> = page["running"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|own| (own[0].as_u64().expect("us"), own[2].as_u64().expect("a line")))
        .collect();
    // 6 switches an output between two moves; 7 waits, while the move before it ends.
    let wanted = [
        (0, 1),
        (1_100_000, 6),
        (1_200_000, 2),
        (1_500_000, 3),
        (1_700_000, 7),
        (2_500_000, 4),
        (3_600_000, 5),
        (5_000_000, 4),
    ];
    assert_eq!(told, wanted);
    assert_eq!(page["prints"], serde_json::json!([[1_800_000, 7, "hole <1>"]]));
    let svg = drawn(Form::Svg).replace('\n', "");
    assert!(svg.contains("line 7: hole &lt;1&gt;"), "{svg}");
}

#[test]
fn both_pictures_have_the_same_colours_of_axes() {
    let (svg, page) = (drawn(Form::Svg), drawn(Form::Html));
    for axis in ["x", "y", "z"] {
        let (_, own) = page.split_once(&format!("--{axis}: ")).expect("a colour");
        let colour = &own[..7];
        for class in ["rate", "name-rate"] {
            let rule = svg.split_once(&format!("\n.{class}-{axis} {{")).expect("a rule").1;
            assert!(rule.split('}').next().is_some_and(|rule| rule.contains(colour)), "{axis}");
        }
    }
}

#[test]
fn a_laser_is_drawn_in_the_greys_of_its_power() {
    let (program, mut outcome) = (program(), outcome());
    for (segment, power) in outcome.record.path.iter_mut().zip([0, 1000, 0, 250, 1000]) {
        segment.power = Some(power);
    }
    let plot = Plot { title: "a", source: SOURCE, program: &program, outcome: &outcome };
    let svg = plot.render(Form::Svg);
    for class in ["path cut s7", "path cut s2", "laser: S0 to S1000"] {
        assert!(svg.contains(class), "no {class}");
    }
    let page = data_of(&plot.render(Form::Html));
    assert_eq!((&page["full"], &page["curves"][3][4]), (&1000.into(), &0.25.into()));
}

#[test]
fn an_endless_loop_makes_no_endless_picture() {
    let (program, mut outcome) = (program(), outcome());
    let axe = SegmentKind::Move(MoveKind::Axe);
    let us = |i: u64| i * 1_000_000;
    outcome.record.path = (0..80_000)
        .map(|i| {
            let [from, to] = if i % 2 == 0 { [0, 1000] } else { [1000, 0] };
            segment(axe, 2, [from, 0, 0], [to, 0, 0], (us(i), us(i) + 400_000))
        })
        .collect();
    outcome.record.outputs =
        (0..80_000).map(|i| Edge { us: us(i), n: 1, on: i % 2 == 0 }).collect();
    outcome.record.printed =
        (0..80_000).map(|i| Printed { us: us(i), line: 3, text: "one more".to_owned() }).collect();
    outcome.summary.us = us(80_000);
    let plot = Plot { title: "a", source: SOURCE, program: &program, outcome: &outcome };
    let (svg, page) = (plot.render(Form::Svg).len(), plot.render(Form::Html).len());
    assert!(svg < 1_500_000, "{svg} bytes of SVG");
    assert!(page < 12_000_000, "{page} bytes of HTML");
}

#[test]
fn a_steady_rate_is_a_flat_line() {
    let (program, mut outcome) = (program(), outcome());
    let mut slow = segment(SegmentKind::Home, 1, [0, 0, 0], [200, 0, 0], (100_000, 1_100_000));
    slow.peak_rate = 200.0;
    outcome.record.path = vec![slow];
    let plot = Plot { title: "a", source: SOURCE, program: &program, outcome: &outcome };
    let svg = plot.render(Form::Svg);
    let (_, rest) = svg.split_once("class=\"path rate-x\" d=\"").expect("a line");
    let numbers = rest.split('"').next().unwrap_or_default();
    let numbers = numbers.split(|c: char| c.is_ascii_alphabetic() || c == ' ' || c == ',');
    let numbers: Vec<f64> = numbers.filter_map(|own| own.parse().ok()).collect();
    let mut heights: Vec<f64> = numbers.chunks(2).map(|place| place[1]).collect();
    heights.dedup();
    // 0, the rate, 0.
    assert_eq!(heights.len(), 3, "{numbers:?}");
}
