//! The least time that a path can take: a planner that knows the whole path, in floating point.
//!
//! It shares nothing with the firmware: the firmware and the host's slow points are measured against it. A path is a series
//! of legs that join at corners. Along each leg the speed changes by the ramps of the axes that move, each axis with its own,
//! and stays below the feed and the axes' top rates. The speed at a corner is one at which
//! - the inscribed arc leaves the path by no more than the corner tolerance (junction deviation), or no
//!   axis jumps by more than its start rate, and
//! - the arc that touches both legs in the middle of the shorter one needs no more than the ramp. This
//!   bounds a polygon of short chords, where the first rule alone would allow any speed.
//!
//! The ramp is the least of both legs' and of the direction in which they differ: an axis that hardly
//! moves along either may have to do all of the turn.
//!
//! All speeds inside are squares, (um/s)^2.

use lang::axis::Axis as Letter;
use lang::profile::Profile;

/// What an axis can do, um and s.
#[derive(Clone, Copy, Debug)]
struct Axis {
    start: f64,
    top: f64,
    accel: f64,
    decel: f64,
}

/// A machine as its profile has it.
#[derive(Clone, Copy, Debug)]
pub struct Machine {
    axes: [Option<Axis>; 3],
    corner_um: f64,
}

/// How a leg goes to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// As fast as the axes can, from rest to rest.
    Rapid,
    /// With the feed.
    Line,
    /// A chord of an arc: each axis carries its whole speed somewhere along the arc.
    Arc,
}

/// A leg of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// Where it ends, um.
    pub to: [f64; 3],
    /// How it goes there.
    pub kind: Kind,
    /// Speed along it, um/s.
    pub feed: f64,
}

/// What follows for a leg of some length.
#[derive(Clone, Copy, Debug)]
struct Shape {
    length: f64,
    unit: [f64; 3],
    start2: f64,
    top2: f64,
    accel: f64,
    decel: f64,
    rapid: bool,
}

/// A path's least time and its shortest leg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Best {
    /// Seconds from rest to rest.
    pub seconds: f64,
    /// Mean time of a leg of its lines, s.
    pub leg: f64,
}

impl Machine {
    /// What a profile says.
    pub fn of(profile: &Profile) -> Machine {
        let axes = Letter::ALL.map(|letter| {
            profile.axis(letter).map(|own| {
                let step = f64::from(own.scale.um) / f64::from(own.scale.steps);
                let um = |steps: i32| f64::from(steps) * step;
                Axis {
                    start: um(own.start_rate),
                    top: um(own.top_rate),
                    accel: um(own.accel),
                    decel: um(own.decel.unwrap_or(own.accel)),
                }
            })
        });
        Machine { axes, corner_um: f64::from(profile.corner_um) }
    }

    /// The least time of the legs, which begin at 0.
    pub fn best(&self, legs: &[Leg]) -> Best {
        let (mut seconds, mut lines) = (0.0, (0.0, 0.0));
        for (shape, [first, last]) in self.passed(legs) {
            let time = shape.seconds(first, last);
            seconds += time;
            if !shape.rapid {
                lines = (lines.0 + time, lines.1 + 1.0);
            }
        }
        Best { seconds, leg: lines.0 / f64::max(lines.1, 1.0) }
    }

    /// Where the speed bends in that time: times, s, and speeds along the path, um/s.
    pub fn speeds(&self, legs: &[Leg]) -> Vec<[f64; 2]> {
        let (mut at, mut points) = (0.0, vec![[0.0; 2]]);
        for (shape, [first, last]) in self.passed(legs) {
            let end = at + shape.seconds(first, last);
            let [v0, v1, v] = [first, last, shape.peak(first, last)].map(f64::sqrt);
            points.extend([
                [at, v0],
                [at + (v - v0) / shape.accel, v],
                [end - (v - v1) / shape.decel, v],
                [end, v1],
            ]);
            at = end;
        }
        points.push([at, 0.0]);
        points
    }

    /// Each leg with the squares of the speeds at its ends.
    fn passed(&self, legs: &[Leg]) -> Vec<(Shape, [f64; 2])> {
        let mut from = [0.0; 3];
        let mut shapes = Vec::new();
        for leg in legs {
            shapes.extend(self.shape(from, leg));
            from = leg.to;
        }
        // The square of the speed that each corner allows, 0 where the path rests.
        let mut corners: Vec<f64> = shapes.windows(2).map(|w| self.corner(&w[0], &w[1])).collect();
        corners.push(0.0);
        // Backward: what can still be braked.
        for n in (0..shapes.len().saturating_sub(1)).rev() {
            let next = &shapes[n + 1];
            let reach =
                corners[n + 1].max(next.start2.min(next.top2)) + 2.0 * next.decel * next.length;
            corners[n] = corners[n].min(reach);
        }
        // Forward: what can be gained.
        let mut before = 0.0_f64;
        let mut passed = Vec::new();
        for (shape, corner) in shapes.iter().zip(&corners) {
            let floor = shape.start2.min(shape.top2);
            let first = before.max(floor).min(shape.top2);
            let last = corner.max(floor).min(first + 2.0 * shape.accel * shape.length);
            passed.push((*shape, [first, last]));
            before = if *corner == 0.0 { 0.0 } else { last };
        }
        passed
    }

    fn shape(&self, from: [f64; 3], leg: &Leg) -> Option<Shape> {
        let by: [f64; 3] = std::array::from_fn(|n| leg.to[n] - from[n]);
        let length = by.iter().map(|by| by * by).sum::<f64>().sqrt();
        if length < 1e-9 {
            return None;
        }
        let mut shape = Shape {
            length,
            unit: by.map(|by| by / length),
            start2: f64::INFINITY,
            top2: f64::INFINITY,
            accel: f64::INFINITY,
            decel: f64::INFINITY,
            rapid: leg.kind == Kind::Rapid,
        };
        for (unit, axis) in shape.unit.iter().zip(&self.axes) {
            let Some(axis) = axis.filter(|_| *unit != 0.0) else { continue };
            let part = if leg.kind == Kind::Arc { 1.0 } else { unit.abs() };
            shape.start2 = shape.start2.min((axis.start / part).powi(2));
            shape.top2 = shape.top2.min((axis.top / part).powi(2));
            shape.accel = shape.accel.min(axis.accel / part);
            shape.decel = shape.decel.min(axis.decel / part);
        }
        if leg.kind != Kind::Rapid {
            shape.top2 = shape.top2.min(leg.feed.powi(2));
        }
        Some(shape)
    }

    /// Square of the speed at the corner between two legs, by its shape and their feeds.
    fn corner(&self, own: &Shape, next: &Shape) -> f64 {
        if own.rapid || next.rapid {
            return 0.0;
        }
        let straight: f64 = own.unit.iter().zip(&next.unit).map(|(a, b)| a * b).sum();
        // Half of the angle by which the path turns.
        let sin2 = (0.5 * (1.0 - straight)).clamp(1e-12, 1.0);
        let (sin, cos) = (sin2.sqrt(), (1.0 - sin2).max(0.0).sqrt());
        let ramp = |shape: &Shape| shape.accel.min(shape.decel);
        let (mut least, mut jump) = (ramp(own).min(ramp(next)), f64::INFINITY);
        for (n, axis) in self.axes.iter().enumerate() {
            let turn = (own.unit[n] - next.unit[n]).abs();
            let Some(axis) = axis.filter(|_| turn > 1e-9) else { continue };
            least = least.min(axis.accel.min(axis.decel) * 2.0 * sin / turn);
            jump = jump.min(axis.start / turn);
        }
        let rounded = least * self.corner_um * cos / (1.0 - cos).max(1e-12);
        let half = 0.5 * least * own.length.min(next.length) * cos / sin;
        rounded.max(jump.powi(2)).min(half).min(own.top2).min(next.top2)
    }
}

impl Shape {
    /// Square of the highest speed between them.
    fn peak(&self, first: f64, last: f64) -> f64 {
        let (up, down) = (self.accel, self.decel);
        let peak = (2.0 * up * down * self.length + down * first + up * last) / (up + down);
        peak.min(self.top2).max(first.max(last))
    }

    /// Time of the leg between two squares of speeds that its ramps can join.
    fn seconds(&self, first: f64, last: f64) -> f64 {
        let (up, down) = (self.accel, self.decel);
        let top = self.peak(first, last);
        let [v0, v1, v] = [first, last, top].map(f64::sqrt);
        let ways = (top - first) / (2.0 * up) + (top - last) / (2.0 * down);
        (v - v0) / up + (v - v1) / down + (self.length - ways).max(0.0) / v
    }
}

#[cfg(test)]
mod tests {
    use super::{Kind, Leg, Machine};
    use lang::profile::Profile;

    fn machine() -> Machine {
        Machine::of(&Profile::built_in("mill").expect("the mill"))
    }

    fn line(to: [f64; 3], feed: f64) -> Leg {
        Leg { to, kind: Kind::Line, feed }
    }

    #[test]
    fn a_line_takes_its_ramps_and_its_feed() {
        // 4 mm/s to 50 mm/s at 250 mm/s2 and back: 0.184 s and 4.968 mm each.
        let best = machine().best(&[line([100_000.0, 0.0, 0.0], 50_000.0)]);
        let seconds = 2.0 * 0.184 + (100.0 - 2.0 * 4.968) / 50.0;
        assert!((best.seconds - seconds).abs() < 1e-9, "{best:?}");
        // On the diagonal the ramps and start rates of both axes together are the root of 2 as much.
        let best = machine().best(&[line([100_000.0, 100_000.0, 0.0], 50_000.0)]);
        let root = 2.0_f64.sqrt();
        let up = (50.0 - 4.0 * root) / (250.0 * root);
        let way = up * (50.0 + 4.0 * root) / 2.0;
        let seconds = 2.0 * up + (100.0 * root - 2.0 * way) / 50.0;
        assert!((best.seconds - seconds).abs() < 1e-9, "{best:?}");
    }

    #[test]
    fn chords_of_a_line_take_what_the_line_takes() {
        let whole = machine().best(&[line([100_000.0, 0.0, 0.0], 50_000.0)]);
        let chords: Vec<Leg> =
            (1..=1000).map(|n| line([f64::from(n) * 100.0, 0.0, 0.0], 50_000.0)).collect();
        assert!((machine().best(&chords).seconds - whole.seconds).abs() < 1e-6);
    }

    #[test]
    fn a_polygon_is_no_faster_than_its_circle_may_be() {
        // v2 / r = 250 mm/s2 with r = 2.5 mm: 25 mm/s, whatever the chords are.
        for chords in [50, 500, 5_000] {
            let at = |n: i32| {
                let angle = f64::from(n) * std::f64::consts::TAU / f64::from(chords);
                [2_500.0 * (1.0 - angle.cos()), 2_500.0 * angle.sin(), 0.0]
            };
            let legs: Vec<Leg> = (1..=20 * chords).map(|n| line(at(n), 50_000.0)).collect();
            let speed = 20.0 * std::f64::consts::TAU * 2.5 / machine().best(&legs).seconds;
            assert!((24.0..36.0).contains(&speed), "{chords} chords at {speed} mm/s");
        }
    }

    #[test]
    fn a_corner_is_passed_at_what_its_tolerance_allows() {
        // 90 degrees: c / (1 - c) = 2.414, 250 * 0.02 * 2.414 = 12.07, of which the root is 3.47 mm/s:
        // below the start rate, which holds then.
        let one = machine().best(&[line([10_000.0, 0.0, 0.0], 50_000.0)]);
        let two = [[10_000.0, 0.0, 0.0], [10_000.0, 10_000.0, 0.0]].map(|to| line(to, 50_000.0));
        assert!((machine().best(&two).seconds - 2.0 * one.seconds).abs() < 0.01);
    }
}
