//! How fast each line of a course may end, by all that comes behind it.

use firmware::motion::path::Feed;
use firmware::motion::path::geometry::{Geometry, Shape, Tail};
use firmware::motion::scaled::Scaled;
use lang::hir::Program;
use lang::record::MachineRecord;

use super::Pace;
use super::walk::Line;

/// What a square may be too high by where numbers of 24 bits were rounded: this part of it is left away.
const ROUNDING: f64 = 1e-4;
/// The part of a ramp that the chip uses ([`firmware::motion::ramp`]).
const RAMP: f64 = 31.0 / 32.0;
/// Faster than any machine, um/s: a corner without a feed.
const ANY: u32 = 1 << 30;

/// Squares of speeds along a course, (um/s)^2, one for each line.
#[derive(Clone, Debug)]
pub struct Bounds {
    /// What its end may have at most; 0 where it must rest.
    pub most: Vec<f64>,
    /// What its end has when everything behind it is known.
    pub best: Vec<f64>,
    /// What its braking takes away.
    pub ramp: Vec<f64>,
    /// That of a speed at which every axis may rest: no more is no speed at all.
    pub rest: f64,
}

/// The number that stands in 24 bits and an exponent.
fn number(of: Scaled) -> f64 {
    let (exponent, mantissa) = ((of.0 >> 24) as i32, of.0 & 0xFF_FFFF);
    f64::from(mantissa) * 2f64.powi(exponent - 128)
}

impl Bounds {
    /// Those of the lines of a course, of a machine whose planner takes so long.
    pub fn of(lines: &[Line], program: &Program, pace: &Pace) -> Bounds {
        let machine = MachineRecord::of(&program.profile);
        let shapes: Vec<Geometry> = lines
            .iter()
            .map(|line| {
                Geometry::of(
                    &machine.axes,
                    &Shape::Line(&line.steps, &line.um),
                    Feed::Um(line.feed),
                )
            })
            .collect();
        let square = |of: Scaled| number(of).powi(2);
        let rest = shapes.iter().map(|g| number(g.start2())).fold(f64::INFINITY, f64::min);
        let ramped = |g: &Geometry| 2.0 * RAMP * number(g.decel) * number(g.length);
        let ramp: Vec<f64> = shapes.iter().map(ramped).collect();
        // A line whose end is passed at speed lasts as long as planning the next one takes.
        let paced = |n: usize| {
            let g = &shapes[n];
            let thought = lines.get(n + 1).map_or(0, |next| next.thought_us);
            let least_us = pace.line_us + pace.event_us * number(g.events) + f64::from(thought);
            (number(g.length) * 1e6 / least_us).powi(2)
        };
        let count = lines.len();
        let mut most = vec![0.0; count];
        for n in (0..count.saturating_sub(1)).rev() {
            let (own, next) = (&shapes[n], &shapes[n + 1]);
            let mut bound = square(own.top).min(square(next.top)).min(paced(n));
            bound = bound.min(number(corner(own, next, machine.corner)));
            if number(next.feed) < number(own.feed) {
                bound = bound.min(square(next.feed));
            }
            if n + 2 < count {
                bound = bound.min(paced(n + 1));
            }
            bound = bound.min(f64::max(most[n + 1], rest) + ramp[n + 1]) * (1.0 - ROUNDING);
            most[n] = if bound > rest { bound } else { 0.0 };
        }
        let mut best = vec![0.0; count];
        let mut before = 0.0;
        for (n, g) in shapes.iter().enumerate() {
            let gained = f64::max(before, rest) + 2.0 * RAMP * number(g.accel) * number(g.length);
            before = most[n].min(gained).min(square(g.feed));
            best[n] = before;
        }
        Bounds { most, best, ramp, rest }
    }
}

/// Square of the speed that the corner between two lines allows, whatever their feeds are.
fn corner(own: &Geometry, next: &Geometry, tolerance: u16) -> Scaled {
    let fast = Scaled::constant(ANY);
    let before = Tail { length: own.length, fast, unit: own.unit };
    next.corner2(&before, own.ramp().least(next.ramp()), fast, tolerance)
}
