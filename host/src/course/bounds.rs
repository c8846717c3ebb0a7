//! How fast each line of a course may end, by all that comes after it.

use firmware::motion::path::Feed;
use firmware::motion::path::geometry::{Geometry, Shape, Tail};
use firmware::motion::scaled::Scaled;
use lang::hir::Program;
use lang::record::MachineRecord;

use super::Pace;
use super::walk::Line;
use crate::interrupt;

/// What a square may be too high by where numbers of 24 bits were rounded: this part of it is subtracted.
const ROUNDING: f64 = 1e-4;
/// The part of a ramp that the chip uses ([`firmware::motion::ramp`]).
const RAMP: f64 = 31.0 / 32.0;
/// What a line that rests at its end loses beside its ramps, s: the next one is planned only then.
const REST_S: f64 = 0.004;
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
    /// What its acceleration may add.
    gain: Vec<f64>,
    /// That of its feed.
    feed: Vec<f64>,
    /// Its length, um.
    length: Vec<f64>,
    /// What the lines behind it are joined by: [`Entry::joins`](lang::image::course::Entry::joins).
    pub joins: Vec<u8>,
    /// That of a speed at which every axis may rest: no more is no speed at all.
    pub rest: f64,
}

/// The number that stands in 24 bits and an exponent.
pub fn number(of: Scaled) -> f64 {
    let (exponent, mantissa) = ((of.0 >> 24) as i32, of.0 & 0xFF_FFFF);
    f64::from(mantissa) * 2f64.powi(exponent - 128)
}

impl Bounds {
    /// Those of the lines of a course, of a machine whose planner takes so long.
    ///
    /// Two passes, as of grbl's `planner_recalculate` and Klipper's look-ahead, over all lines of the course at once:
    /// - backward, from the last line, which rests: the end of a line is no faster than its corner, the top speeds, and what
    ///   the next line can brake from, `end^2 <= next end^2 + 2 d length`. This is `most`, which the record must never
    ///   exceed;
    /// - forward: an end is no faster than the line can become, `end^2 <= end^2 before + 2 a length`, and than its feed. This is
    ///   `best`, what the run will really have, by which lost time is judged.
    ///
    /// An end no faster than `rest`, the lowest start rate, is a stop: 0. All rest when somebody has asked for the end.
    pub fn of(lines: &[Line], program: &Program, pace: &Pace) -> Bounds {
        let machine = MachineRecord::of(&program.profile);
        let each = lines.iter().take_while(|_| !interrupt::asked());
        let shapes: Vec<Geometry> = each.map(|line| shape(line, &machine)).collect();
        if shapes.len() < lines.len() {
            return Bounds::resting(lines.len());
        }
        let square = |of: Scaled| number(of).powi(2);
        let rest = shapes.iter().map(|g| number(g.start2())).fold(f64::INFINITY, f64::min);
        let ramped = |g: &Geometry| 2.0 * RAMP * number(g.decel) * number(g.length);
        let ramp: Vec<f64> = shapes.iter().map(ramped).collect();
        // A line is passed no faster than the next one comes in time.
        let passed: Vec<f64> = (0..lines.len())
            .map(|n| match lines.get(n + 1) {
                Some(_) if interrupt::asked() => 0.0,
                Some(next) => pace.passed(&shapes[n], &lines[n], next).powi(2),
                None => f64::INFINITY,
            })
            .collect();
        let count = lines.len();
        let mut most = vec![0.0; count];
        for n in (0..count.saturating_sub(1)).rev().take_while(|_| !interrupt::asked()) {
            let (own, next) = (&shapes[n], &shapes[n + 1]);
            let mut bound = square(own.top).min(square(next.top)).min(passed[n]);
            bound = bound.min(number(corner(&machine, own, next)));
            bound = bound.min(steady(&machine, [&lines[n], &lines[n + 1]], [own, next]).powi(2));
            if number(next.feed) < number(own.feed) {
                bound = bound.min(square(next.feed));
            }
            if n + 2 < count && passed[n + 1] > rest {
                bound = bound.min(passed[n + 1]);
            }
            bound = bound.min(f64::max(most[n + 1], rest) + ramp[n + 1]) * (1.0 - ROUNDING);
            most[n] = if bound > rest { bound } else { 0.0 };
        }
        let gained = |g: &Geometry| 2.0 * RAMP * number(g.accel) * number(g.length);
        let gain: Vec<f64> = shapes.iter().map(gained).collect();
        let feed: Vec<f64> = shapes.iter().map(|g| square(g.feed).min(square(g.top))).collect();
        let mut best = vec![0.0; count];
        let mut before = 0.0;
        for n in 0..count {
            before = most[n].min(f64::max(before, rest) + gain[n]).min(feed[n]);
            best[n] = before;
        }
        let length = shapes.iter().map(|g| number(g.length)).collect();
        let joined = |line: &Line| line.joined * line.named.count_ones() as u8;
        let joins = (1..=count).map(|n| lines.get(n).map_or(0, joined)).collect();
        Bounds { most, best, ramp, gain, feed, length, joins, rest }
    }

    /// Those of lines that all rest.
    fn resting(count: usize) -> Bounds {
        let [most, best, ramp, gain, feed, length] = [(); 6].map(|()| vec![0.0; count]);
        Bounds { most, best, ramp, gain, feed, length, joins: vec![0; count], rest: f64::INFINITY }
    }

    /// How long lines last whose ends have these squares of speeds, nothing of joined ones, s.
    ///
    /// Along a line v^2 rises by `up` over its whole length and falls by `down`, both straight. They meet at
    /// `(from * down + to * up + up * down) / (up + down)`. Each ramp takes its part of the length over the mean of the
    /// speeds at both of its ends, as acceleration is constant; the rest of the length takes the top speed.
    pub fn seconds(&self, ends: &[Option<f64>]) -> f64 {
        let mut before = 0.0;
        let each = ends.iter().flatten().enumerate().map(|(n, end)| {
            let [from, to] = [before, *end].map(|square| f64::max(square, self.rest));
            before = *end;
            let (up, down) = (self.gain[n], self.ramp[n]);
            // The highest speed, where both ramps meet, or its feed; what is left goes at that.
            let meet = (from * down + to * up + up * down) / (up + down);
            let top = meet.min(self.feed[n]).max(from).max(to);
            let ramps = ((top - from) / up + (top - to) / down).min(1.0);
            let speed = |a: f64, b: f64| (a.sqrt() + b.sqrt()) / 2.0;
            let [rise, fall] = [(top - from) / up, (top - to) / down];
            let time = rise / speed(from, top) + fall / speed(top, to) + (1.0 - ramps) / top.sqrt();
            time * self.length[n] + if *end > self.rest { 0.0 } else { REST_S }
        });
        each.sum()
    }

    /// What it costs that the square of the speed at the end of the n-th line is no more than this, s, nearly: a dip on its
    /// ramps, or the whole line as slow as that.
    ///
    /// A dip from `fast` to `slow` and back at the ramp `d` takes `2 (fast - slow) / d` where `(fast^2 - slow^2) / (d fast)`
    /// would do: it loses `(fast - slow)^2 / (d fast)`, with `d = ramp / (2 length)`.
    pub fn lost(&self, n: usize, end: f64) -> f64 {
        let (best, end) = (self.best[n], f64::max(end, 0.0));
        if end >= best || best <= self.rest {
            return 0.0;
        }
        let (fast, slow) = (best.sqrt(), f64::max(end, self.rest).sqrt());
        let dip = (fast - slow).powi(2) * 2.0 * self.length[n] / (self.ramp[n] * fast);
        let whole = self.length[n] * (1.0 / slow - 1.0 / fast);
        f64::min(dip, whole) + if end > self.rest { 0.0 } else { REST_S }
    }
}

/// A line as the chip plans it, along the way of its whole steps, in the direction that was commanded.
pub fn shape(line: &Line, machine: &MachineRecord) -> Geometry {
    let feed = Feed::Um(line.feed);
    let whole = Geometry::of(&machine.axes, &Shape::Line(&line.steps, &[0; 3]), feed);
    let commanded = Geometry::of(&machine.axes, &Shape::Line(&line.steps, &line.um), feed);
    Geometry { unit: commanded.unit, ..whole }
}

/// The highest speed, um/s, at which rounding to whole steps makes no axis jump by more than half of its start rate from one
/// line to the next.
///
/// At path speed v an axis runs at `v * steps / length`. The corner already limits the change that the commanded directions
/// ask for; this is the change beyond it: an axis with long steps makes a short line longer or shorter for all axes. A
/// step more or less in either line is ordinary rounding and does not count: `slack`.
fn steady(machine: &MachineRecord, lines: [&Line; 2], shapes: [&Geometry; 2]) -> f64 {
    let lengths = shapes.map(|shape| number(shape.length));
    let commanded =
        lines.map(|line| line.um.iter().map(|um| f64::from(*um).powi(2)).sum::<f64>().sqrt());
    let slack = 1.0 / lengths[0] + 1.0 / lengths[1];
    let each = machine.axes.iter().enumerate().map(|(a, axis)| {
        let made = [0, 1].map(|n: usize| f64::from(lines[n].steps[a]) / lengths[n]);
        let scale = f64::from(axis.steps) / f64::from(axis.um.max(1));
        let asked =
            [0, 1].map(|n: usize| f64::from(lines[n].um[a]) / commanded[n].max(1.0) * scale);
        let change = ((made[0] - made[1]) - (asked[0] - asked[1])).abs() - slack;
        if change > 0.0 { f64::from(axis.start_rate.max(1)) / 2.0 / change } else { f64::INFINITY }
    });
    each.fold(f64::INFINITY, f64::min)
}

/// Square of the speed that the corner between two lines allows, whatever their feeds are.
fn corner(machine: &MachineRecord, own: &Geometry, next: &Geometry) -> Scaled {
    let fast = Scaled::constant(ANY);
    let before = Tail { length: own.length, fast, unit: own.unit };
    let ramp = own.ramp().least(next.ramp());
    next.corner2(&machine.axes, &before, ramp, fast, machine.corner)
}
