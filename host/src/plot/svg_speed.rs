//! Speeds in the SVG: colours of the path, and the step rate of each axis over time.

use std::fmt;

use svg::Node;
use svg::node::element::path::Data;
use svg::node::element::{Group, Path, Rectangle};

use super::curve::{Curve, Point};
use super::scale::{Scale, Span};
use super::svg_page::{Panel, frame, round, text};
use super::{Plot, Style};
use lang::axis::Axis;

/// Colours from slow to fast: even steps of viridis without its pale end.
pub const COLOURS: [&str; 8] =
    ["#440154", "#46327e", "#365c8d", "#277f8e", "#1fa187", "#4ac16d", "#a0da39", "#e3c51b"];
/// Height of the chart of step rates.
const HEIGHT: f64 = 130.0;
/// The chart is drawn in so many columns at most: more than pixels shows nothing more.
const COLUMNS: usize = 2100;

/// The path's speed between two points, mm/s.
fn speed(a: &Point, b: &Point) -> f64 {
    let time = (b.us - a.us) / 1e6;
    let way: f64 = (0..3).map(|i| (b.at[i] - a.at[i]).powi(2)).sum::<f64>().sqrt();
    if time > 0.0 { way / time } else { 0.0 }
}

/// Greys from a dark laser to full power.
pub const GREYS: [&str; 8] =
    ["#e4e8ee", "#c8cdd5", "#acb2bc", "#9197a2", "#767c88", "#5b616d", "#3f4550", "#1b2029"];

/// What the colours of working moves tell: their speed, or on a laser its power.
pub struct Speeds {
    /// The fastest, mm/s.
    top: f64,
    /// The moves' powers are known.
    laser: bool,
    /// S of its full power.
    full: i32,
}

impl Speeds {
    /// The range that the curves have.
    pub fn of(curves: &[Curve], full: i32) -> Speeds {
        let cuts = curves.iter().filter(|curve| curve.style == Style::Cut);
        let pairs = cuts.clone().flat_map(|curve| curve.points.windows(2));
        Speeds {
            top: pairs.map(|pair| speed(&pair[0], &pair[1])).fold(0.0, f64::max),
            laser: cuts.clone().any(|curve| curve.power.is_some()),
            full,
        }
    }

    /// The class of the colour between two points of a curve.
    pub fn class(&self, curve: &Curve, a: &Point, b: &Point) -> Class {
        let index = |part: f64| ((part * COLOURS.len() as f64) as usize).min(COLOURS.len() - 1);
        match curve.power {
            Some(power) => Class::Power(index(power)),
            None if self.top > 0.0 => Class::Speed(index(speed(a, b) / self.top)),
            None => Class::Speed(0),
        }
    }

    /// Samples of the colours with what they mean, its right end at `right`.
    pub fn legend(&self, right: f64, y: f64) -> Group {
        const WIDTH: f64 = 14.0;
        let mut group = Group::new();
        let from = right - WIDTH * COLOURS.len() as f64;
        let (colours, name) = if self.laser {
            (GREYS, format!("laser: S0 to S{}", self.full))
        } else {
            (COLOURS, format!("line, arc: 0 to {:.0} mm/min", self.top * 60.0))
        };
        for (i, colour) in colours.iter().enumerate() {
            group.append(
                Rectangle::new()
                    .set("x", round(from + WIDTH * i as f64))
                    .set("y", y - 5.0)
                    .set("width", WIDTH)
                    .set("height", 7)
                    .set("fill", *colour),
            );
        }
        group.append(text(from - 8.0, y + 2.0, "legend", &name).set("text-anchor", "end"));
        group
    }
}

/// Class of a working move's colour, and its index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Of [`COLOURS`].
    Speed(usize),
    /// Of [`GREYS`].
    Power(usize),
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Class::Speed(index) => write!(f, "v{index}"),
            Class::Power(index) => write!(f, "s{index}"),
        }
    }
}

/// The rate of each axis over time, steps/s, with its sign.
pub fn rates(plot: &Plot<'_>, curves: &[Curve], x: &Scale, top: f64) -> Panel {
    let tracks = Axis::ALL.map(|axis| track(plot, curves, axis, x));
    let values = tracks.iter().flatten().map(|(_, rate)| *rate);
    let mut span = Span::of(values, 10.0, 0.08);
    // The caption stands above the curves.
    span.high += span.width() * 0.2;
    let y = Scale { span, from: top + HEIGHT, to: top };
    let mut group = frame(x, &y, "Step rate, steps/s", (14, 4));
    let mut label = x.from + 136.0;
    for (axis, track) in Axis::ALL.into_iter().zip(&tracks) {
        if track.iter().all(|(_, rate)| *rate == 0.0) {
            continue;
        }
        let mut data = Data::new();
        for (i, (seconds, rate)) in track.iter().enumerate() {
            let place = (round(x.at(*seconds)), round(y.at(*rate)));
            data = if i == 0 { data.move_to(place) } else { data.line_to(place) };
        }
        let class = format!("path rate-{}", axis.letter().to_ascii_lowercase());
        group.append(Path::new().set("class", class.as_str()).set("d", data));
        let name = axis.letter().to_string();
        group.append(text(label, y.to + 16.0, &class.replace("path ", "name-"), &name));
        label += 22.0;
    }
    Panel { group, bottom: top + HEIGHT }
}

/// Times, s, and rates of an axis: both ends of each piece, 0 where it rests. A steady rate is a
/// flat line, and an axis that starts at a rate begins with it.
fn track(plot: &Plot<'_>, curves: &[Curve], axis: Axis, x: &Scale) -> Vec<(f64, f64)> {
    let Some(own) = plot.program.profile.axis(axis) else { return Vec::new() };
    let per_mm = f64::from(own.scale.steps) * 1000.0 / f64::from(own.scale.um);
    let i = axis.index();
    let mut out = vec![(0.0, 0.0)];
    let mut rested = 0.0;
    for curve in curves.iter().filter(|curve| curve.axes[i]) {
        for pair in curve.points.windows(2) {
            let (from, to) = (pair[0].us / 1e6, pair[1].us / 1e6);
            let steps = (pair[1].at[i] - pair[0].at[i]) * per_mm;
            // The points' rates are the curve's; those of its axes have the ratio of their ways.
            let mean = (pair[0].rate + pair[1].rate) / 2.0;
            if to <= from || steps == 0.0 || mean <= 0.0 {
                continue;
            }
            if from > rested + 1e-6 {
                out.extend([(rested, 0.0), (from, 0.0)]);
            }
            let share = steps / (to - from) / mean;
            out.extend([(from, pair[0].rate * share), (to, pair[1].rate * share)]);
            rested = rested.max(to);
        }
    }
    out.extend([(rested, 0.0), (x.span.high / 1.01, 0.0)]);
    // Stable: what stands at one time stays in its order.
    out.sort_by(|a, b| a.0.total_cmp(&b.0));
    thin(out)
}

/// Lowest and highest of each column, when there are more points than columns show.
fn thin(track: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let Some(end) = track.last().map(|point| point.0).filter(|_| track.len() > COLUMNS) else {
        return track;
    };
    let column = |point: &(f64, f64)| (point.0 / end * (COLUMNS / 2) as f64) as usize;
    let ends = |run: &[(f64, f64)]| {
        let low = run.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1));
        let high = run.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1));
        let mut both: Vec<(f64, f64)> = low.into_iter().chain(high).collect();
        both.sort_by(|a, b| a.0.total_cmp(&b.0));
        both
    };
    track.chunk_by(|a, b| column(a) == column(b)).flat_map(ends).collect()
}
