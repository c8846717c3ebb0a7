use std::f64::consts::TAU;

use lang::effect::{Frame, Plane};
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::hir::{Block, Program, StmtKind};
use lang::profile::{Profile, Scale};
use proptest::prelude::*;

use super::curve::{Center, Shape, tolerance_um};
use super::known::length;
use super::{Cost, drawn};
use crate::sim::world::World;
use crate::sim::{Engine, Options, run_traced};

/// Centre and angle of an arc in its plane from the start, as pure geometry has it.
#[derive(Debug)]
struct True {
    center: [f64; 2],
    radii: [f64; 2],
    begin: f64,
    sweep: f64,
}

/// The arc of RS274/NGC 3.5.3 by the formulas of a textbook, in floating point.
fn by_the_book(shape: &Shape) -> True {
    let [a, b] = shape.plane.axes().map(|axis| f64::from(shape.end[axis.index()]));
    let center = match shape.center {
        Center::Offset([i, j]) => [f64::from(i), f64::from(j)],
        Center::Radius(radius) => {
            let half = a.hypot(b) / 2.0;
            let beside = (f64::from(radius).powi(2) - half * half).max(0.0).sqrt();
            let left = if shape.clockwise == (radius < 0) { 1.0 } else { -1.0 };
            [a / 2.0 - left * beside * b / (2.0 * half), b / 2.0 + left * beside * a / (2.0 * half)]
        }
    };
    let begin = (-center[1]).atan2(-center[0]);
    let end = (b - center[1]).atan2(a - center[0]);
    let turn = if shape.clockwise { begin - end } else { end - begin };
    let turn = turn.rem_euclid(TAU);
    let sweep = if [a, b] == [0.0, 0.0] || turn < 1e-9 { TAU } else { turn };
    True {
        center,
        radii: [center[0].hypot(center[1]), (a - center[0]).hypot(b - center[1])],
        begin,
        sweep: if shape.clockwise { -sweep } else { sweep },
    }
}

impl True {
    /// How far a point lies from the arc's point at this part of it, along the radius; and whether it
    /// lies at that angle within `slack` um.
    fn off(&self, at: [f64; 2], part: f64) -> f64 {
        let radius = self.radii[0] + (self.radii[1] - self.radii[0]) * part;
        ((at[0] - self.center[0]).hypot(at[1] - self.center[1]) - radius).abs()
    }

    fn point(&self, part: f64) -> [f64; 2] {
        let radius = self.radii[0] + (self.radii[1] - self.radii[0]) * part;
        let (sine, cosine) = (self.begin + self.sweep * part).sin_cos();
        [self.center[0] + radius * cosine, self.center[1] + radius * sine]
    }
}

/// Ends and middles of all chords lie on the arc as far as the tolerance says, the ends at their
/// angle, and the last end is the one of the words.
fn stays_on_the_arc(shape: &Shape, tolerance: f64) -> Result<usize, TestCaseError> {
    let Ok(ends) = shape.chords(tolerance) else {
        return Err(TestCaseError::reject("no such arc"));
    };
    let book = by_the_book(shape);
    let [a, b] = shape.plane.axes().map(|axis| axis.index());
    let c = 3 - a - b;
    let mut before = [0; 3];
    let count = ends.len() as f64;
    // A centre found by R is a whole micrometre, and half a step of one beside the chord is more of an
    // angle the nearer the arc comes to a half circle.
    let found = match shape.center {
        Center::Offset(_) => 1.0,
        Center::Radius(_) => 3.0,
    };
    for (n, end) in ends.iter().enumerate() {
        let part = (n + 1) as f64 / count;
        let at = [f64::from(end[a]), f64::from(end[b])];
        let middle = [0, 1].map(|i| (at[i] + f64::from(before[[a, b][i]])) / 2.0);
        prop_assert!(
            book.off(at, part) <= found,
            "end {n} of {count}: {} um off",
            book.off(at, part)
        );
        let middle_off = book.off(middle, part - 0.5 / count);
        prop_assert!(
            middle_off <= tolerance + found,
            "middle {n}: {middle_off} um off of {tolerance}"
        );
        let there = book.point(part);
        let along = (there[0] - at[0]).hypot(there[1] - at[1]);
        prop_assert!(along <= 4.0 * found, "end {n} of {count}: {along} um along the arc");
        let rise = f64::from(shape.end[c]) * part;
        prop_assert!((f64::from(end[c]) - rise).abs() <= 0.5);
        before = *end;
    }
    prop_assert_eq!(before, shape.end);
    Ok(ends.len())
}

fn planes() -> impl Strategy<Value = Plane> {
    prop_oneof![Just(Plane::Xy), Just(Plane::Zx), Just(Plane::Yz)]
}

/// Arcs by I and J whose end lies on the circle as far as whole micrometres go, full circles and helices among them.
fn around() -> impl Strategy<Value = Shape> {
    let radius = prop_oneof![20.0f64..200.0, 200.0..20_000.0, 20_000.0..4_000_000.0];
    let sweep = prop_oneof![4 => 0.01f64..TAU, 1 => Just(TAU)];
    (any::<bool>(), planes(), radius, 0.0..TAU, sweep, -80_000i32..80_000).prop_map(
        |(clockwise, plane, radius, begin, sweep, rise)| {
            let offset = [radius * begin.cos(), radius * begin.sin()].map(|x| x.round() as i32);
            let begin = f64::from(-offset[1]).atan2(f64::from(-offset[0]));
            let radius = f64::from(offset[0]).hypot(f64::from(offset[1]));
            let angle = if clockwise { begin - sweep } else { begin + sweep };
            let [a, b] = plane.axes().map(|axis| axis.index());
            let mut end = [0; 3];
            if sweep < TAU {
                end[a] = offset[0] + (radius * angle.cos()).round() as i32;
                end[b] = offset[1] + (radius * angle.sin()).round() as i32;
            }
            end[3 - a - b] = rise;
            Shape { clockwise, plane, end, center: Center::Offset(offset) }
        },
    )
}

/// Arcs by R.
fn with_radius() -> impl Strategy<Value = Shape> {
    let far = prop_oneof![50i32..2_000, 2_000..100_000];
    (any::<bool>(), planes(), far, 0.0..TAU, 1.01f64..40.0, any::<bool>()).prop_map(
        |(clockwise, plane, chord, angle, wide, long)| {
            let [a, b] = plane.axes().map(|axis| axis.index());
            let mut end = [0; 3];
            end[a] = (f64::from(chord) * angle.cos()).round() as i32;
            end[b] = (f64::from(chord) * angle.sin()).round() as i32;
            let radius = (f64::from(chord) / 2.0 * wide).ceil() as i32;
            let center = Center::Radius(if long { -radius } else { radius });
            Shape { clockwise, plane, end, center }
        },
    )
}

/// Machines from 10 to 1000 steps/mm with tolerances over the whole range.
fn machines() -> impl Strategy<Value = Profile> {
    (prop_oneof![Just(10u16), Just(25), Just(100), Just(1000)], 0i32..300).prop_map(
        |(steps, corner)| {
            let mut profile = Profile::built_in("mill").expect("a profile");
            for axis in [&mut profile.x, &mut profile.y, &mut profile.z].into_iter().flatten() {
                axis.scale = Scale { steps, um: 1000 };
            }
            profile.corner_um = corner;
            profile
        },
    )
}

proptest! {
    #[test]
    fn chords_stay_within_the_tolerance(shape in around(), profile in machines()) {
        stays_on_the_arc(&shape, tolerance_um(&profile, shape.plane))?;
    }

    #[test]
    fn chords_of_a_radius_too(shape in with_radius(), profile in machines()) {
        stays_on_the_arc(&shape, tolerance_um(&profile, shape.plane))?;
    }
}

#[test]
fn no_more_chords_than_the_tolerance_needs() {
    let shape = |radius| Shape {
        clockwise: false,
        plane: Plane::Xy,
        end: [0; 3],
        center: Center::Offset([radius, 0]),
    };
    let count = |radius, tolerance| shape(radius).chords(tolerance).expect("a circle").len();
    // pi / acos(1 - 19/5000) is 36.03.
    assert_eq!(count(5_000, 20.0), 37);
    assert_eq!(count(5_000, 50.0), 23);
    assert_eq!(count(30, 50.0), 8);
    assert!(shape(0).chords(20.0).is_err() && shape(5_000_000).chords(20.0).is_err());
}

fn program(text: &str) -> Program {
    let source = Source::new("t.bas", text.to_owned());
    let (program, diags) = compile(&source, ProfileChoice::built_in());
    program.unwrap_or_else(|| panic!("{}", diags.render(&source)))
}

/// Why each arc stays one: its line and the reason.
fn refusals(text: &str) -> Vec<(u32, String)> {
    let refused = drawn(&program(text)).expect_err("arcs that stay");
    refused.into_iter().map(|own| (own.line, own.why.to_string())).collect()
}

fn cost(text: &str) -> Cost {
    match drawn(&program(text)) {
        Ok((program, cost)) => {
            lang::back::compile(&program).expect("it compiles");
            cost
        }
        Err(refused) => panic!("{refused:?}"),
    }
}

/// Where a program with its arcs ends, and where with chords.
fn ends_alike(text: &str) {
    let with_arcs = program(text);
    let (with_chords, _) = drawn(&with_arcs).expect("chords");
    for engine in [Engine::Rhai, Engine::Vm] {
        let end = |program: &Program| {
            let world = World::unattended();
            let (_, events) =
                run_traced(program, engine, &world, &Options::default()).expect("a run");
            events.last().expect("an end").what.clone()
        };
        assert_eq!(end(&with_arcs), end(&with_chords), "{text}");
    }
}

#[test]
fn every_form_of_an_arc_ends_where_it_should() {
    for text in [
        "G0 X10 Y5\nG2 X20 Y15 I10 J0 F600\n",
        "G0 X10 Y5\nG3 X20 Y15 R-10 F600\nG2 X10 Y5 R10\n",
        "G91 G3 X0 Y0 I3.3333 J0 F600\nX3 Y3 J3 I0\n",
        "G20 G0 X1 Y0.333\nG2 X1.5 Y0.833 I0.5 F20\n",
        "G18 G0 X3 Y0 Z-4\nG2 X5 Z-2 R2 Y1 F600\n",
        "G19 G0 Y3 Z-4 X0\nG3 Y5 Z-6 R2 X1.37 F600\n",
        "G0 X1999.999 Y1999.998 Z0\nG3 X1999.999 Y1999.998 I-0.5 Z-3 F900\n",
        "MoveAxe X, 3mm : MoveAxe Y, 4mm\nMoveRel X, 1mm\nG2 X6 Y6 I2 F300\n",
        "G0 X5 Y5\nSetPos X, 0mm\nG92 Y[1mm]\nG2 X2 Y3 R2 F300\n",
        "CONST R = 2mm\nREPEAT 3\nG91 G2 X[R] Y[R] I[R] F600\nEND REPEAT\n",
        "DIM i\nFOR i = 1 TO 3\nG0 X[i * 3mm] Y[i * 1mm]\nG91 G3 I1 F600\nG90\nNEXT\n",
    ] {
        ends_alike(text);
    }
}

#[test]
fn a_start_is_followed_through_the_text() {
    let half = "G2 X20 Y0 I5 F300\n";
    for (before, known) in [
        ("G0 X10 Y0\n", true),
        ("G0 X10\n", false),
        ("Home\n", false),
        ("G0 X10 Y0\nHome Z\n", true),
        ("G0 X10 Y0\nHome X\n", false),
        ("G0 X10 Y0\nMoveAxe X, 1000st\n", false),
        ("G0 X10 Y0\nProbe? Z, -5mm, 5mm/s\n", true),
        ("G0 X10 Y0\nProbe? Y, 5mm, 5mm/s\n", false),
        ("G0 X10 Y0\nIF IN(3) THEN G0 X11\n", false),
        ("IF IN(3) THEN\nG0 X10 Y0\nELSE\nG0 X9 Y0\nG91 G0 X1\nG90\nEND IF\n", true),
        ("G0 X10 Y0\nREPEAT 2\nSetOut 3, ON\nEND REPEAT\n", true),
        ("G0 X10 Y0\nREPEAT 2\nG91 G0 X1\nEND REPEAT\nG90\n", false),
        ("G0 X10 Y0\nagain:\nIF IN(3) THEN GOTO again\n", false),
        ("G0 X10 Y0\npen\n", true),
        ("G0 X10 Y0\nshift\n", false),
        ("G0 X10 Y0\nGOSUB shift\n", false),
        ("G0 X10 Y0\nDIM n\nn = moved()\n", false),
        ("ON EVERY 1s GOSUB pen\nG0 X10 Y0\n", true),
        ("ON ERROR GOTO trouble\nG0 X10 Y0\n", false),
    ] {
        let text = format!(
            "{before}{half}END\ntrouble:\nIF IN(8) THEN END\n{}\nEND\nSUB pen\nMoveAxe Z, -1mm\nEND SUB\nSUB shift\nG91 G0 X1\nG90\nEND SUB\n\
             FUNCTION moved()\nMoveRel Y, 1mm\nRETURN 1\nEND FUNCTION\n",
            if before.contains("ON ERROR") { "RESUME NEXT" } else { "PRINT 1" }
        );
        let result = drawn(&program(&text));
        assert_eq!(result.is_ok(), known, "{text}{:?}", result.err());
    }
}

#[test]
fn what_cannot_be_drawn_has_its_reason() {
    let text = "DIM i AS LENGTH\nG2 X10 Y0 I5 F300\nG0 X0 Y0\nG2 X10 Y0 I[i]\nG91 G2 X[i] Y1 R3\nG2 X5 Y5 R1\nG90 G3 X[20st] Y5 I1\n";
    assert_eq!(
        refusals(text),
        [
            (2, "where X is when it begins is only known while it runs".to_owned()),
            (4, "I is only known while it runs".to_owned()),
            (5, "X is only known while it runs".to_owned()),
            (6, lang::fault::Fault::Arc.cause().to_owned()),
            (7, "X is only known while it runs".to_owned()),
        ]
    );
    let handler =
        "ON EVERY 1s GOSUB away\nG91 G2 X2 I1 F300\nEND\nSUB away\nMoveRel X, 1mm\nEND SUB\n";
    assert_eq!(refusals(handler), [(2, "a handler may move X meanwhile".to_owned())]);
}

/// Importers of programs in steps write them so: a step is a known length on a known machine.
#[test]
fn relative_arcs_in_steps_are_those_of_the_same_length() {
    let mm = "F300\nG91\nG3 X-2 Y2 I-2\nG2 X1 Y1 R1\nG2 I5\n";
    let st =
        "F300\nG91\nG3 X[-200st] Y[200st] I[-200st]\nG2 X[100st] Y[100st] R[100st]\nG2 I[500st]\n";
    assert_eq!(cost(st), Cost { line: 3, ..cost(mm) });
    let ends = |text: &str| {
        let (program, _) = drawn(&program(text)).expect("chords");
        format!("{:?}", lang::back::compile(&program).expect("it fits").image)
    };
    assert_eq!(ends(st), ends(mm));
}

#[test]
fn the_cost_is_told() {
    let text = "F300\nG91\nSetOut 3, ON\nG2 I5\nG3 I5\nSUB never\nG2 I5 F300\nEND SUB\n";
    assert_eq!(cost(text), Cost { arcs: 2, chords: 74, tolerance_um: 20.0, line: 4 });
    assert_eq!(cost("Wait 1s\n"), Cost::default());
}

/// The lines of an arc are relative, so that it costs few bytes far out; the last has the words'.
#[test]
fn the_last_chord_has_the_words_of_the_arc() {
    let (program, _) = drawn(&program("G0 X900 Y1\nG2 X902 Y3 I2 F300\n")).expect("chords");
    let lines = |block: &Block| -> Vec<[Option<(i32, Frame)>; 3]> {
        let linear = |kind: &StmtKind| match kind {
            StmtKind::Linear { rapid: false, to, .. } => Some(
                to.clone()
                    .map(|word| word.and_then(|word| Some((length(&word.value)?, word.frame)))),
            ),
            _ => None,
        };
        block.iter().filter_map(|stmt| linear(&stmt.kind)).collect()
    };
    let lines = lines(&program.routines[0].body);
    let (last, others) = lines.split_last().expect("chords");
    assert_eq!(*last, [Some((902_000, Frame::Work)), Some((3_000, Frame::Work)), None]);
    assert!(others.iter().flatten().flatten().all(|word| word.1 == Frame::Relative), "{others:?}");
}
