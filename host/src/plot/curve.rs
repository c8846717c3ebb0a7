//! From the pieces of a path to points with time and speed.

use lang::axis::Axis;
use lang::profile::Profile;

use super::Style;
use crate::sim::record::{ArcShape, Segment, SegmentKind};

/// Largest angle between two points of a drawn arc, radians: 0.05 % of the radius off the circle.
const ARC_STEP: f64 = 0.06;
/// Points that a ramp of the speed is drawn with.
const RAMP_POINTS: usize = 5;

/// A point of the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// When, us.
    pub us: f64,
    /// Where, mm, machine position.
    pub at: [f64; 3],
    /// Rate of the axis that steps most, steps/s.
    pub rate: f64,
}

/// One statement's piece of the path.
#[derive(Clone, Debug)]
pub struct Curve {
    /// What it is drawn as.
    pub style: Style,
    /// Line of the statement.
    pub line: u32,
    /// At least two.
    pub points: Vec<Point>,
    /// Axes that it moves.
    pub axes: [bool; 3],
    /// It is part of a reference run.
    pub home: bool,
    /// Its rate is that along the path, not that of the axis that steps most.
    pub arc: bool,
    /// A laser's power in it, 0 to 1; `None` without a laser.
    pub power: Option<f64>,
}

impl Curve {
    /// Whether it goes straight up or down.
    pub fn is_vertical(&self) -> bool {
        let [first, .., last] = self.points[..] else { return false };
        first.at[..2] == last.at[..2] && first.at[2] != last.at[2]
    }
}

/// Time course of the speed along one segment: up, steady, down.
#[derive(Clone, Copy, Debug)]
struct Ramp {
    entry: f64,
    peak: f64,
    exit: f64,
    up: f64,
    down: f64,
    total: f64,
}

impl Ramp {
    /// Fits ramps of one acceleration to the distance (steps) and time (s) that are known.
    fn fit(entry: f64, peak: f64, exit: f64, distance: f64, total: f64) -> Ramp {
        let mean = distance / total;
        let peak = peak.max(mean);
        let (entry, exit) = (entry.min(peak), exit.min(peak));
        let (rise, fall) = (peak - entry, peak - exit);
        // distance = peak * total - (rise^2 + fall^2) / (2 a)
        let missing = 2.0 * (peak * total - distance);
        let squares = rise * rise + fall * fall;
        let (mut up, mut down) = if squares > 0.0 && missing > 0.0 {
            (rise * missing / squares, fall * missing / squares)
        } else {
            (0.0, 0.0)
        };
        let long = (up + down) / total;
        if long > 1.0 {
            up /= long;
            down /= long;
        }
        Ramp { entry, peak, exit, up, down, total }
    }

    fn rate(&self, t: f64) -> f64 {
        if t < self.up {
            self.entry + (self.peak - self.entry) * t / self.up
        } else if t > self.total - self.down && self.down > 0.0 {
            self.exit + (self.peak - self.exit) * (self.total - t) / self.down
        } else {
            self.peak
        }
    }

    /// Distance covered after `t`.
    fn distance(&self, t: f64) -> f64 {
        let steady_end = self.total - self.down;
        let up = t.min(self.up);
        let steady = (t.min(steady_end) - self.up).max(0.0);
        let down = (t - steady_end).max(0.0);
        up * (self.entry + self.rate(up)) / 2.0
            + steady * self.peak
            + down * (self.peak + self.rate(t)) / 2.0
    }

    /// Times at which the course bends, and some in the ramps.
    fn times(&self) -> Vec<f64> {
        let mut times = vec![0.0];
        let part = |i: usize| i as f64 / RAMP_POINTS as f64;
        if self.up > 0.0 {
            times.extend((1..=RAMP_POINTS).map(|i| self.up * part(i)));
        }
        if self.down > 0.0 {
            let from = self.total - self.down;
            times.extend((0..RAMP_POINTS).map(|i| from + self.down * part(i)));
        }
        times.push(self.total);
        times
    }
}

/// The path as curves. Pieces beyond `detailed` are drawn without the ramps of their speed.
pub fn curves(path: &[Segment], profile: &Profile, detailed: usize) -> Vec<Curve> {
    let detail = path.len() <= detailed;
    let mut out: Vec<Curve> = Vec::with_capacity(path.len());
    for (i, segment) in path.iter().enumerate() {
        let before = i.checked_sub(1).and_then(|before| path.get(before));
        let entry = before.and_then(|before| joined(before, segment, segment, profile));
        let exit = path.get(i + 1).and_then(|after| joined(segment, after, segment, profile));
        let rest = start_rate(segment, profile);
        out.push(curve(segment, entry.unwrap_or(rest), exit.unwrap_or(rest), profile, detail));
    }
    weave(&mut out);
    out
}

/// The rate of `of`, one of the two, at which one segment runs into the next, when it does without a
/// stop.
fn joined(a: &Segment, b: &Segment, of: &Segment, profile: &Profile) -> Option<f64> {
    let cut = |segment: &Segment| Style::of(segment.kind) == Style::Cut;
    if a.end_us != b.start_us || !cut(a) || !cut(b) {
        return None;
    }
    let Some(speed) = a.exit_speed else {
        return (a.kind == b.kind).then(|| a.peak_rate.min(b.peak_rate));
    };
    let length = length(of, profile) * 1000.0;
    (speed > 0.0 && length > 0.0).then(|| speed * longest(of, profile) / length)
}

/// Length of the path, mm.
fn length(segment: &Segment, profile: &Profile) -> f64 {
    let (from, to) = (straight(segment, 0.0, profile), straight(segment, 1.0, profile));
    let mut squares: f64 = (0..3).map(|i| (to[i] - from[i]).powi(2)).sum();
    if let Some(arc) = segment.arc {
        let rise = (0..3).find(|i| arc.plane.iter().all(|axis| axis.index() != *i));
        let rise = rise.map_or(0.0, |i| to[i] - from[i]);
        squares = (radius(segment, &arc, profile) * arc.sweep).powi(2) + rise.powi(2);
    }
    squares.sqrt()
}

fn start_rate(segment: &Segment, profile: &Profile) -> f64 {
    let moving = profile.axes().filter(|(axis, _)| segment.axes[axis.index()]);
    moving.map(|(_, part)| f64::from(part.start_rate)).fold(0.0, f64::max)
}

fn curve(segment: &Segment, entry: f64, exit: f64, profile: &Profile, detail: bool) -> Curve {
    let total = segment.end_us.saturating_sub(segment.start_us) as f64 / 1e6;
    let longest = longest(segment, profile);
    let mut parts: Vec<(f64, f64, f64)> = Vec::new();
    if total > 0.0 && longest > 0.0 && detail {
        let ramp = Ramp::fit(entry, segment.peak_rate, exit, longest, total);
        let whole = ramp.distance(total).max(f64::MIN_POSITIVE);
        parts.extend(
            ramp.times()
                .into_iter()
                .map(|t| (t, (ramp.distance(t) / whole).clamp(0.0, 1.0), ramp.rate(t))),
        );
    } else {
        parts.extend([(0.0, 0.0, segment.peak_rate), (total, 1.0, segment.peak_rate)]);
    }
    if let Some(arc) = segment.arc {
        parts = refine(&parts, arc.sweep.abs());
    }
    let points = parts.into_iter().map(|(t, part, rate)| Point {
        us: segment.start_us as f64 + t * 1e6,
        at: place(segment, part, profile),
        rate,
    });
    Curve {
        style: Style::of(segment.kind),
        line: segment.line,
        points: points.collect(),
        axes: segment.axes,
        home: segment.kind == SegmentKind::Home,
        arc: segment.arc.is_some(),
        power: segment.power.map(|s| f64::from(s) / f64::from(profile.full_power())),
    }
}

/// Steps of the axis that steps most; of an arc, its length in steps.
fn longest(segment: &Segment, profile: &Profile) -> f64 {
    if let Some(arc) = segment.arc
        && let Some(own) = profile.axis(arc.plane[0])
    {
        let steps_per_um = f64::from(own.scale.steps) / f64::from(own.scale.um);
        return radius(segment, &arc, profile) * 1000.0 * arc.sweep.abs() * steps_per_um;
    }
    (0..3)
        .map(|i| f64::from(segment.to[i]) - f64::from(segment.from[i]))
        .fold(0.0, |most: f64, steps| most.max(steps.abs()))
}

/// Radius in mm: that of the start, where the centre's offsets count from.
fn radius(segment: &Segment, arc: &ArcShape, profile: &Profile) -> f64 {
    let [a, b] = arc.plane.map(Axis::index);
    let from = straight(segment, 0.0, profile);
    (from[a] - arc.center[a] / 1000.0).hypot(from[b] - arc.center[b] / 1000.0)
}

/// Adds points until no two lie further apart on the arc than [`ARC_STEP`].
fn refine(parts: &[(f64, f64, f64)], sweep: f64) -> Vec<(f64, f64, f64)> {
    let mut out = Vec::with_capacity(parts.len());
    for pair in parts.windows(2) {
        let ((t0, p0, r0), (t1, p1, r1)) = (pair[0], pair[1]);
        let count = ((p1 - p0) * sweep / ARC_STEP).ceil().clamp(1.0, 200.0) as usize;
        for i in 0..count {
            let part = i as f64 / count as f64;
            out.push((t0 + (t1 - t0) * part, p0 + (p1 - p0) * part, r0 + (r1 - r0) * part));
        }
    }
    out.extend(parts.last());
    out
}

/// Position in mm at a part 0..=1 of the segment.
fn place(segment: &Segment, part: f64, profile: &Profile) -> [f64; 3] {
    let mut at = straight(segment, part, profile);
    if let Some(arc) = segment.arc {
        let [a, b] = arc.plane.map(Axis::index);
        let radius = radius(segment, &arc, profile);
        let angle = arc.start + arc.sweep * part;
        at[a] = arc.center[a] / 1000.0 + radius * angle.cos();
        at[b] = arc.center[b] / 1000.0 + radius * angle.sin();
    }
    at
}

/// The same along the straight line from its begin to its end.
fn straight(segment: &Segment, part: f64, profile: &Profile) -> [f64; 3] {
    Axis::ALL.map(|axis| {
        let i = axis.index();
        let from = f64::from(segment.from[i]);
        let steps = from + (f64::from(segment.to[i]) - from) * part;
        profile.axis(axis).map_or(0.0, |own| {
            steps * f64::from(own.scale.um) / f64::from(own.scale.steps) / 1000.0
        })
    })
}

/// Where axes run on their own at the same time, lets each curve follow the others too.
fn weave(curves: &mut [Curve]) {
    let mut first = 0;
    while first < curves.len() {
        let mut end = last_us(&curves[first]);
        let mut next = first + 1;
        while next < curves.len() && curves[next].points[0].us < end {
            end = end.max(last_us(&curves[next]));
            next += 1;
        }
        if next - first > 1 {
            weave_together(&mut curves[first..next]);
        }
        first = next;
    }
}

fn last_us(curve: &Curve) -> f64 {
    curve.points.last().map_or(0.0, |point| point.us)
}

fn weave_together(curves: &mut [Curve]) {
    // More than this together is a long chain of overlaps: its picture may stay coarse.
    const MOST: usize = 64;
    if curves.len() > MOST {
        return;
    }
    let plain = curves.to_vec();
    let mut times: Vec<f64> =
        plain.iter().flat_map(|curve| curve.points.iter().map(|point| point.us)).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    for (own, curve) in curves.iter_mut().enumerate() {
        let (from, to) = (curve.points[0].us, last_us(curve));
        let inside = times.iter().filter(|us| (from..=to).contains(*us));
        let points = inside.map(|&us| {
            let mut point = sample(&plain[own], us);
            for other in plain.iter().filter(|other| other.points[0].us <= us) {
                let there = sample(other, us);
                for axis in (0..3).filter(|axis| other.axes[*axis] && !plain[own].axes[*axis]) {
                    point.at[axis] = there.at[axis];
                }
            }
            point
        });
        curve.points = points.collect();
    }
}

/// The curve's point at a time, its ends before and after it.
fn sample(curve: &Curve, us: f64) -> Point {
    let points = &curve.points;
    let after = points.partition_point(|point| point.us < us);
    let (Some(a), Some(b)) = (points.get(after.saturating_sub(1)), points.get(after)) else {
        return points[points.len() - 1];
    };
    let part = if b.us > a.us { (us - a.us) / (b.us - a.us) } else { 1.0 };
    let mix = |from: f64, to: f64| from + (to - from) * part.clamp(0.0, 1.0);
    Point { us, at: [0, 1, 2].map(|i| mix(a.at[i], b.at[i])), rate: mix(a.rate, b.rate) }
}
