//! The picture as one SVG: the path from above, its side view, inputs and outputs over time.

use std::collections::HashSet;

use svg::node::element::{
    Circle, ClipPath, Group, Line, Path, Rectangle, Style as Css, Text, Title,
};
use svg::{Document, Node};

use super::chart::Lines;
use super::curve::Curve;
use super::scale::{Scale, Span};
use super::svg_speed::{COLOURS, GREYS, Speeds, rates};
use super::svg_time::timeline;
use super::{Plot, Style, chart};
use crate::scene::picture::Shape;

/// Width of the page, px.
pub const WIDTH: f64 = 1180.0;
/// Left edge of every panel.
pub const LEFT: f64 = 96.0;
/// Right edge of every panel.
pub const RIGHT: f64 = WIDTH - 32.0;
/// Height that the view from above may take.
const TOP_VIEW: f64 = 560.0;
/// Height of the side view.
const SIDE_VIEW: f64 = 150.0;
/// Line numbers that are written beside the path.
const MOST_LABELS: usize = 80;

/// How everything looks.
pub const CSS: &str = "
svg { background: #fbfcfe; font: 12px 'Segoe UI', Roboto, 'DejaVu Sans', Helvetica, sans-serif; }
text { fill: #46536b; }
.title { font-size: 21px; font-weight: 600; fill: #17202e; }
.caption { font-size: 12px; font-weight: 600; fill: #17202e; }
.panel { fill: #ffffff; stroke: #d8dfea; }
.grid { stroke: #e9edf4; stroke-width: 1; }
.zero { stroke: #b9c4d6; stroke-width: 1; }
.tick { font-size: 11px; fill: #7a879d; }
.path { fill: none; stroke-linejoin: round; stroke-linecap: round; }
.rapid { stroke: #9fadc2; stroke-width: 1.1; stroke-dasharray: 5 4; }
.axis { stroke: #12967f; stroke-width: 1.6; }
.cut { stroke: #1f62e0; stroke-width: 2.2; }
.rate-x, .rate-y, .rate-z { stroke-width: 1.3; }
.rate-x { stroke: #d6403a; }
.rate-y { stroke: #15955b; }
.rate-z { stroke: #2f6fe4; }
.name-rate-x, .name-rate-y, .name-rate-z { font-weight: 600; }
.name-rate-x { fill: #d6403a; }
.name-rate-y { fill: #15955b; }
.name-rate-z { fill: #2f6fe4; }
.probe { stroke: #e07b12; stroke-width: 2; }
circle.cut { fill: #1f62e0; fill-opacity: .18; stroke-width: 1.6; }
circle.axis { fill: #12967f; fill-opacity: .18; }
circle.probe { fill: #e07b12; fill-opacity: .2; }
circle.rapid { display: none; }
.start { fill: #12967f; stroke: #ffffff; stroke-width: 1.5; }
.end { fill: #c8324b; stroke: #ffffff; stroke-width: 1.5; }
.label { font-size: 10px; fill: #7a879d; paint-order: stroke; stroke: #ffffff; stroke-width: 3px; }
.on { fill: #f0a52b; }
.in { fill: #6d8fd8; }
.statement { fill: #c9d4e6; }
.print { fill: #66748b; }
.failed { stroke: #c8324b; stroke-width: 1.5; }
.cell { fill: none; stroke-width: 1; }
.cell-stock { fill: #efe6d3; stroke: #c9b58a; }
.cell-belt { fill: #eef0f3; stroke: #aab3c2; }
.cell-place { stroke: #c98a1b; stroke-dasharray: 3 2; }
.cell-fixture { fill: #dfe3ea; stroke: #8b96a8; }
.cell-thing { fill: #cfe0fb; stroke: #4472c4; }
.cell-sensor { stroke: #a03fc0; }
.cell-hole { fill: #17202e; }
.cell-bead { stroke: #e0a012; stroke-width: 2.5; }
.cell-hit { stroke: #c8324b; stroke-width: 2.5; }
.failure { font-size: 11px; font-weight: 600; fill: #c8324b; }
";

/// Draws the page.
pub fn render(plot: &Plot<'_>) -> String {
    let curves = plot.curves();
    let lines = Lines::of(plot.source);
    let speeds = Speeds::of(&curves, plot.program.profile.full_power());
    let mut css = CSS.to_owned();
    for (name, colours) in [("v", COLOURS), ("s", GREYS)] {
        for (i, colour) in colours.iter().enumerate() {
            css += &format!(".{name}{i} {{ stroke: {colour}; }}\n");
        }
    }
    let mut page = Document::new().add(Css::new(css));
    page.append(text(LEFT, 40.0, "title", plot.title));
    let subtitle = chart::subtitle(plot.outcome, &plot.ending());
    page.append(text(LEFT, 62.0, "subtitle", &subtitle));
    page.append(legend(&curves, &speeds));
    let mut y = 84.0;
    let shapes = plot.shapes();
    let (view, x_scale) = top_view(&lines, &curves, &speeds, shapes, y);
    y = view.bottom + 40.0;
    page.append(view.group);
    if plot.has_z() && moves_z(&curves) {
        let view = side_view(&lines, &curves, &speeds, x_scale, y);
        y = view.bottom + 40.0;
        page.append(view.group);
    }
    let end = plot.duration_us() as f64 / 1e6;
    let x = Scale { span: Span { low: 0.0, high: end * 1.01 }, from: LEFT, to: RIGHT };
    if !curves.is_empty() {
        let view = rates(plot, &curves, &x, y);
        y = view.bottom + 30.0;
        page.append(view.group);
    }
    let timeline = timeline(plot, &lines, &curves, &x, y);
    y = timeline.bottom + 24.0;
    page.append(timeline.group);
    page.set("viewBox", (0, 0, WIDTH as i64, y.ceil() as i64))
        .set("width", WIDTH)
        .set("height", y.ceil())
        .to_string()
}

/// A panel that was drawn, and where it ends.
pub struct Panel {
    /// What was drawn.
    pub group: Group,
    /// Its lower edge.
    pub bottom: f64,
}

/// A text that begins at a place.
pub fn text(x: f64, y: f64, class: &str, content: &str) -> Text {
    Text::new(content).set("x", round(x)).set("y", round(y)).set("class", class)
}

/// Two decimals are a hundredth of a pixel: enough, and a third of the file.
pub fn round(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

fn moves_z(curves: &[Curve]) -> bool {
    let mut heights = curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.at[2]));
    let first = heights.next();
    heights.any(|z| Some(z) != first)
}

/// Samples of the styles that occur, and of the colours of working moves, right-aligned above the
/// panels.
fn legend(curves: &[Curve], speeds: &Speeds) -> Group {
    let mut group = Group::new();
    let occurs = |style: Style| curves.iter().any(|curve| curve.style == style);
    if occurs(Style::Cut) {
        group.append(speeds.legend(RIGHT, 60.0));
    }
    let used: Vec<Style> =
        Style::ALL.into_iter().filter(|style| *style != Style::Cut && occurs(*style)).collect();
    let mut x = RIGHT - 128.0 * used.len() as f64 + 12.0;
    for style in used {
        group.append(line(x, 36.0, x + 26.0, 36.0, &format!("path {}", style.name())));
        group.append(text(x + 32.0, 40.0, "legend", style.legend()));
        x += 128.0;
    }
    group
}

/// A straight line.
pub fn line(x1: f64, y1: f64, x2: f64, y2: f64, class: &str) -> Line {
    Line::new()
        .set("x1", round(x1))
        .set("y1", round(y1))
        .set("x2", round(x2))
        .set("y2", round(y2))
        .set("class", class)
}

/// X to the right, Y up, both in the same scale.
fn top_view(
    lines: &Lines<'_>,
    curves: &[Curve],
    speeds: &Speeds,
    shapes: &[Shape],
    top: f64,
) -> (Panel, Scale) {
    let values = |axis: usize| {
        let path = Plot::shown(curves)
            .flat_map(move |curve| curve.points.iter().map(move |point| point.at[axis]));
        let cell = shapes.iter().flat_map(|shape| &shape.points).map(move |point| point[axis]);
        path.chain(cell)
    };
    let (mut x, mut y) = (Span::of(values(0), 1.0, 0.06), Span::of(values(1), 1.0, 0.06));
    let height = (y.width() / x.width() * (RIGHT - LEFT)).clamp(180.0, TOP_VIEW);
    // One scale for both: the axis with room to spare gets a wider span.
    let per_mm = ((RIGHT - LEFT) / x.width()).min(height / y.width());
    x = widen(x, (RIGHT - LEFT) / per_mm);
    y = widen(y, height / per_mm);
    let x = Scale { span: x, from: LEFT, to: RIGHT };
    let y = Scale { span: y, from: top + height, to: top };
    let mut group = frame(&x, &y, "X / Y from above, mm", (12, (height / 60.0) as usize));
    let inside = clip("above", &x, &y);
    let path = Group::new()
        .set("clip-path", "url(#above)")
        .add(cell(shapes, &x, &y))
        .add(drawing(lines, curves, speeds, (&x, &y), [0, 1]))
        .add(holes(lines, curves, &x, &y))
        .add(marks(curves, &x, &y))
        .add(labels(curves, &x, &y));
    group.append(inside);
    group.append(path);
    (Panel { group, bottom: top + height }, x)
}

/// The cell from above; each shape has its name as title.
fn cell(shapes: &[Shape], x: &Scale, y: &Scale) -> Group {
    let mut group = Group::new();
    for shape in shapes {
        let mut data = String::new();
        for (i, [px, py]) in shape.points.iter().enumerate() {
            let command = if i == 0 { 'M' } else { 'L' };
            data += &format!("{command}{},{} ", round(x.at(*px)), round(y.at(*py)));
        }
        let class = format!("cell cell-{}", shape.kind.word());
        let path = Path::new().set("class", class).set("d", data.trim_end());
        group.append(path.add(Title::new(shape.name.as_str())));
    }
    group
}

fn widen(span: Span, width: f64) -> Span {
    let room = (width - span.width()).max(0.0) / 2.0;
    Span { low: span.low - room, high: span.high + room }
}

/// Z over X, below the view from above and in line with it.
fn side_view(lines: &Lines<'_>, curves: &[Curve], speeds: &Speeds, x: Scale, top: f64) -> Panel {
    let values = Plot::shown(curves).flat_map(|curve| curve.points.iter().map(|point| point.at[2]));
    let mut span = Span::of(values, 0.5, 0.08);
    // The caption stands above the path.
    span.high += span.width() * 0.16;
    let z = Scale { span, from: top + SIDE_VIEW, to: top };
    let mut group = frame(&x, &z, "X / Z from the front, mm (Z has its own scale)", (12, 5));
    group.append(clip("front", &x, &z));
    group.append(Group::new().set("clip-path", "url(#front)").add(drawing(
        lines,
        curves,
        speeds,
        (&x, &z),
        [0, 2],
    )));
    Panel { group, bottom: top + SIDE_VIEW }
}

/// Nothing is drawn outside a panel.
fn clip(name: &str, x: &Scale, y: &Scale) -> ClipPath {
    ClipPath::new().set("id", name).add(rectangle(x, y))
}

fn rectangle(x: &Scale, y: &Scale) -> Rectangle {
    Rectangle::new()
        .set("x", round(x.from))
        .set("y", round(y.to))
        .set("width", round(x.to - x.from))
        .set("height", round(y.from - y.to))
        .set("rx", 4)
}

/// Panel, grid and tick values.
pub fn frame(x: &Scale, y: &Scale, caption: &str, ticks: (usize, usize)) -> Group {
    let mut group = Group::new().add(rectangle(x, y).set("class", "panel"));
    let class = |value: f64| if value.abs() < 1e-9 { "zero" } else { "grid" };
    let (values, digits) = x.span.ticks(ticks.0);
    for value in values {
        let at = x.at(value);
        group.append(line(at, y.from, at, y.to, class(value)));
        group.append(
            text(at, y.from + 15.0, "tick", &format!("{:.digits$}", value + 0.0))
                .set("text-anchor", "middle"),
        );
    }
    let (values, digits) = y.span.ticks(ticks.1.max(3));
    for value in values {
        let at = y.at(value);
        group.append(line(x.from, at, x.to, at, class(value)));
        group.append(
            text(x.from - 8.0, at + 4.0, "tick", &format!("{:.digits$}", value + 0.0))
                .set("text-anchor", "end"),
        );
    }
    group.add(text(x.from + 8.0, y.to + 16.0, "caption", caption))
}

/// The path in two axes. Pieces of one statement and style that follow one another are one element,
/// whose title names line and text; working moves are one for each of their colours.
fn drawing(
    lines: &Lines<'_>,
    curves: &[Curve],
    speeds: &Speeds,
    (x, y): (&Scale, &Scale),
    axes: [usize; 2],
) -> Group {
    let mut group = Group::new();
    let mut seen = HashSet::new();
    for style in Style::ALL {
        let own: Vec<&Curve> = curves.iter().filter(|curve| curve.style == style).collect();
        for run in own.chunk_by(|a, b| a.line == b.line) {
            let title = lines.title(run[0].line);
            let pairs =
                run.iter().flat_map(|curve| curve.points.windows(2).map(move |pair| (curve, pair)));
            let coloured = pairs.map(|(curve, pair)| match style {
                Style::Cut => (Some(speeds.class(curve, &pair[0], &pair[1])), pair),
                _ => (None, pair),
            });
            let coloured: Vec<_> = coloured.collect();
            for same in coloured.chunk_by(|a, b| a.0 == b.0) {
                let class = match same[0].0 {
                    Some(colour) => format!("path cut {colour}"),
                    None => format!("path {}", style.name()),
                };
                let mut data = String::new();
                let mut pen = None;
                for (_, pair) in same {
                    for (i, point) in pair.iter().enumerate() {
                        let place =
                            (round(x.at(point.at[axes[0]])), round(y.at(point.at[axes[1]])));
                        if pen == Some(place) {
                            continue;
                        }
                        let command = if i == 0 { 'M' } else { 'L' };
                        data += &format!("{command}{},{} ", place.0, place.1);
                        pen = Some(place);
                    }
                }
                // A loop goes the same way again and again.
                if seen.insert((class.clone(), data.clone())) {
                    let path = Path::new().set("class", class).set("d", data.trim_end());
                    group.append(path.add(Title::new(title.as_str())));
                }
            }
        }
    }
    group
}

/// Straight strokes of Z are points from above: they get a ring.
fn holes(lines: &Lines<'_>, curves: &[Curve], x: &Scale, y: &Scale) -> Group {
    let mut group = Group::new();
    let mut seen = HashSet::new();
    for curve in curves.iter().filter(|curve| curve.style != Style::Rapid && curve.is_vertical()) {
        let [px, py, _] = curve.points[0].at;
        let (cx, cy) = (round(x.at(px)), round(y.at(py)));
        if !seen.insert(((cx * 4.0) as i64, (cy * 4.0) as i64)) {
            continue;
        }
        let title = format!("{} at X {px:.3} Y {py:.3}", lines.title(curve.line));
        group.append(
            Circle::new()
                .set("cx", cx)
                .set("cy", cy)
                .set("r", 4.5)
                .set("class", curve.style.name())
                .add(Title::new(title)),
        );
    }
    group
}

/// Where the run begins and ends.
fn marks(curves: &[Curve], x: &Scale, y: &Scale) -> Group {
    let mut group = Group::new();
    let first = curves.first().and_then(|curve| curve.points.first());
    let last = curves.last().and_then(|curve| curve.points.last());
    for (point, class, name) in [(last, "end", "end"), (first, "start", "start")] {
        if let Some(point) = point {
            group.append(
                Circle::new()
                    .set("cx", round(x.at(point.at[0])))
                    .set("cy", round(y.at(point.at[1])))
                    .set("r", 4)
                    .set("class", class)
                    .add(Title::new(name)),
            );
        }
    }
    group
}

/// Each statement's line number where it moved the machine to, as far as there is room.
fn labels(curves: &[Curve], x: &Scale, y: &Scale) -> Group {
    let mut group = Group::new();
    let mut taken: HashSet<(i64, i64)> = HashSet::new();
    let mut told = HashSet::new();
    for curve in curves {
        let Some(end) = curve.points.last() else { continue };
        let (px, py) = (x.at(end.at[0]), y.at(end.at[1]));
        // One label in each field of 26 by 14 px.
        let field = ((px / 26.0) as i64, (py / 14.0) as i64);
        if told.contains(&curve.line) || taken.contains(&field) || told.len() >= MOST_LABELS {
            continue;
        }
        taken.insert(field);
        told.insert(curve.line);
        group.append(text(px + 7.0, py - 6.0, "label", &curve.line.to_string()));
    }
    group
}
