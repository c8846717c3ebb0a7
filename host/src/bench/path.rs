//! Accuracy of a path: pins of the emulated board against geometry and against the simulator.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use emulator::{Edge, Signal, TICKS_PER_SECOND};
use firmware::motion::physics;
use lang::axis::Axis;
use lang::part::Part;
use lang::profile::Profile;

use super::stand::{Stand, gate, image_for, rises};
use super::{Sink, at_least, at_most};
use crate::board::{F5529, G2553};
use crate::sim::trace::{Event, What};
use crate::sim::world::World;
use crate::sim::{self, Engine, Options};

/// Steps per millimetre of the built-in mill.
const STEPS_PER_MM: f64 = 100.0;
/// Vertices of the polygon of short chords.
const CORNERS: u32 = 60;
/// Chords into which an ideal arc is cut for the comparison: of 20 mm they leave it by 0.0001 steps.
const CHORDS: u32 = 2000;
/// Moves of which every step is held against the profile's ramps.
const MOVES: u32 = 60;

/// A path as a script and as the ideal places along it, mm.
struct Course {
    text: String,
    ideal: Vec<[f64; 3]>,
}

impl Course {
    fn new() -> Course {
        Course { text: "SetOut 1, ON\n".to_owned(), ideal: vec![[0.0; 3]] }
    }

    fn here(&self) -> [f64; 3] {
        self.ideal.last().copied().unwrap_or_default()
    }

    fn line(&mut self, to: [f64; 3]) {
        self.text += &format!("G1 X{:.3} Y{:.3} Z{:.3}\n", to[0], to[1], to[2]);
        self.ideal.push(to.map(|mm| (mm * 1000.0).round() / 1000.0));
    }

    /// Counterclockwise about a centre by a part of a turn, with a rise in Z.
    fn arc(&mut self, offset: [f64; 2], turn: f64, rise: f64) {
        let [x, y, z] = self.here();
        let center = [x + offset[0], y + offset[1]];
        let radius = offset[0].hypot(offset[1]);
        let begin = (-offset[1]).atan2(-offset[0]);
        let at = |part: f64| {
            let angle = begin + part * turn * std::f64::consts::TAU;
            let place = [center[0] + radius * angle.cos(), center[1] + radius * angle.sin()];
            [place[0], place[1], z + part * rise]
        };
        let [ex, ey, ez] = at(1.0);
        self.text +=
            &format!("G3 X{ex:.3} Y{ey:.3} Z{ez:.3} I{:.3} J{:.3}\n", offset[0], offset[1]);
        self.ideal.extend((1..=CHORDS).map(|i| at(f64::from(i) / f64::from(CHORDS))));
    }

    /// Lines in every direction.
    fn of_lines() -> Course {
        let mut course = Course::new();
        course.text += "F1500\n";
        for to in [[31.0, 7.0, 0.0], [12.34, 29.99, -3.0], [40.0, 30.0, -1.0], [5.0, 5.0, -2.0]] {
            course.line(to);
        }
        course
    }

    /// Lines in every direction, a rounded pocket, a polygon of 0.5 mm chords, a circle, a helix.
    fn of_every_kind() -> Course {
        let mut course = Course::of_lines();
        course.line([40.0, 5.0, -2.0]);
        course.arc([0.0, 5.0], 0.25, 0.0);
        course.line([45.0, 30.0, -2.0]);
        course.arc([-5.0, 0.0], 0.25, 0.0);
        course.line([15.0, 35.0, -2.0]);
        course.arc([0.0, -5.0], 0.25, 0.0);
        course.line([10.0, 15.0, -2.0]);
        course.arc([12.0, 0.0], 1.0, 0.0);
        course.arc([-6.0, 0.0], 1.0, 2.5);
        course.text += "F900\n";
        let radius = 0.5 / (std::f64::consts::PI / f64::from(CORNERS)).sin() / 2.0;
        let [x, y, z] = course.here();
        for i in 1..=CORNERS {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(CORNERS)).sin_cos();
            course.line([x + radius * (cos - 1.0), y + radius * sin, z]);
        }
        course.text += "G61\nG1 X10 Y15\nSetOut 1, OFF\n";
        course.ideal.push([10.0, 15.0, z]);
        course
    }
}

/// Figures `path_error`, `path_time`, `moves_in_limits` of the F5529, `path_error_g2553` of lines.
///
/// # Errors
/// The board does not run the path.
pub fn run(sink: Sink<'_>) -> Result<(), String> {
    let mill = Profile::built_in("mill").map_err(|error| error.to_string())?;
    let course = Course::of_every_kind();
    let (program, image) = image_for(&mill, &course.text)?;
    let mut stand = Stand::new(&mill)?;
    stand.upload(&image)?;
    let edges = stand.run(Duration::from_secs(60))?;
    sink(at_most("path_error", "steps", error(&edges, &course.ideal), 1.0, 0.75))?;
    let there = gate(&edges)? as f64 / TICKS_PER_SECOND as f64;
    let planned = simulated(&program, &F5529.part)?;
    let off = (there - planned).abs() / planned * 100.0;
    sink(at_most("path_time", "%", off, 0.1, 0.02))?;
    let moves = moves_within_limits(&mill)?;
    let all = f64::from(MOVES);
    sink(at_least("moves_in_limits", "moves", moves as f64, all, all))?;
    let course = Course::of_lines();
    let (_, image) = image_for(&mill, &course.text)?;
    let mut stand = Stand::on(&G2553, &mill)?;
    stand.upload(&image)?;
    let edges = stand.run(Duration::from_secs(60))?;
    sink(at_most("path_error_g2553", "steps", error(&edges, &course.ideal), 1.0, 0.75))
}

/// Farthest place of the pins from the ideal path, steps.
fn error(edges: &[Edge], ideal: &[[f64; 3]]) -> f64 {
    let ideal: Vec<[f64; 3]> = ideal.iter().map(|p| p.map(|mm| mm * STEPS_PER_MM)).collect();
    let mut negative = [false; 3];
    let mut place = [0.0; 3];
    // The path passes near itself: only what lies around the last nearest piece counts.
    let (mut at, mut worst) = (0, 0.0_f64);
    let mut instant = 0;
    for edge in edges {
        match edge.signal {
            Signal::Dir(axis) => negative[usize::from(axis)] = !edge.level,
            Signal::Step(axis) if edge.level => {
                // Axes that step at the same instant make one move.
                if edge.cycle != instant {
                    let (near, distance) = nearest(&ideal, at, &place);
                    (at, worst) = (near, worst.max(distance));
                    instant = edge.cycle;
                }
                let i = usize::from(axis);
                place[i] += if negative[i] { -1.0 } else { 1.0 };
            }
            _ => {}
        }
    }
    worst.max(nearest(&ideal, at, &place).1)
}

/// The piece nearest to a place, from the last one on, and its distance.
fn nearest(ideal: &[[f64; 3]], from: usize, place: &[f64; 3]) -> (usize, f64) {
    let mut best = (from, f64::INFINITY);
    for (i, pair) in ideal.windows(2).enumerate().skip(from).take(8) {
        let (a, b) = (pair[0], pair[1]);
        let along: [f64; 3] = std::array::from_fn(|n| b[n] - a[n]);
        let to: [f64; 3] = std::array::from_fn(|n| place[n] - a[n]);
        let dot = |u: &[f64; 3], v: &[f64; 3]| u.iter().zip(v).map(|(x, y)| x * y).sum::<f64>();
        let length = dot(&along, &along).max(1e-12);
        let part = (dot(&to, &along) / length).clamp(0.0, 1.0);
        let off: [f64; 3] = std::array::from_fn(|n| to[n] - part * along[n]);
        let distance = dot(&off, &off).sqrt();
        if distance < best.1 {
            best = (i, distance);
        }
    }
    best
}

/// Seconds from output 1 going on to its going off on a part, as the simulator has it.
pub(super) fn simulated(program: &lang::hir::Program, part: &Part) -> Result<f64, String> {
    between(&simulated_trace(program, part)?)
}

/// The simulator's trace of a run on a part, with times.
pub(super) fn simulated_trace(
    program: &lang::hir::Program,
    part: &Part,
) -> Result<Vec<Event>, String> {
    let told = Rc::new(RefCell::new(Vec::new()));
    let heard = Rc::clone(&told);
    let sink = Box::new(move |event: &Event| heard.borrow_mut().push(event.clone()));
    let options = Options { record: false, times: true, part: *part, ..Options::default() };
    sim::run(program, Engine::Vm, &World::empty(), &options, sink)
        .map_err(|error| error.to_string())?;
    Ok(told.take())
}

/// Seconds between the first and the last switching of outputs in a trace with times.
pub(super) fn between(trace: &[Event]) -> Result<f64, String> {
    let switched = |event: &&Event| matches!(event.what, What::Out { .. });
    let times: Vec<u64> = trace.iter().filter(switched).filter_map(|event| event.us).collect();
    match times.as_slice() {
        [on, .., off] => Ok((off - on) as f64 / 1e6),
        _ => Err("the trace does not switch output 1".to_owned()),
    }
}

/// Moves one axis by lengths of every size and counts the moves whose steps keep the start rate,
/// the top rate and the ramps of the profile; the first that does not is an error.
fn moves_within_limits(mill: &Profile) -> Result<usize, String> {
    let mut text = String::new();
    let mut length = 1_u32;
    for i in 0..MOVES {
        // 1 to 9999 steps in an order that mixes short and long ones.
        length = (length * 7919 + i) % 9_999 + 1;
        let way = if i % 2 == 0 { "" } else { "-" };
        text += &format!("MoveRel X, {way}{}st\nWait 20ms\n", (length >> (i % 8)).max(1));
    }
    let (_, image) = image_for(mill, &text)?;
    let mut stand = Stand::new(mill)?;
    stand.upload(&image)?;
    let edges = stand.run(Duration::from_secs(60))?;
    let own = mill.axis(Axis::X).ok_or("the mill has no X")?;
    let limits = physics::Limits {
        start: own.start_rate.into(),
        top: own.top_rate.into(),
        accel: own.accel.into(),
        decel: own.decel.unwrap_or(own.accel).into(),
    };
    let steps = rises(&edges, Signal::Step(0));
    let rest = TICKS_PER_SECOND / 100;
    let moves = steps.chunk_by(|a, b| b - a < rest);
    let mut count = 0;
    for one in moves {
        physics::check(one, &limits).map_err(|violation| format!("move {count}: {violation:?}"))?;
        count += 1;
    }
    Ok(count)
}
