//! The picture as one self-contained HTML page: the run as data, and a viewer for it.

use lang::axis::Axis;
use serde::Serialize;

use super::curve::Curve;
use super::{Plot, Row, Style, chart};
use crate::scene::picture::Shape;
use crate::sim::trace::Status;

const PAGE: &str = include_str!("page/page.html");
const CSS: &str = include_str!("page/page.css");
const VIEWER: &str = include_str!("page/viewer.js");

/// What the viewer gets.
#[derive(Serialize)]
struct Data<'a> {
    title: &'a str,
    subtitle: String,
    /// Source lines.
    source: Vec<&'a str>,
    /// Names of the styles, and what the legend says.
    styles: Vec<[&'static str; 2]>,
    /// Steps per mm of X, Y, Z; 0 for an axis that the machine lacks.
    scale: [f64; 3],
    /// Length of the run, us.
    end: u64,
    curves: Vec<Flat>,
    /// What runs: begin and end, us, and the line.
    running: Vec<(u64, u64, u32)>,
    /// Lines of PRINT: us, line of the statement, text.
    prints: Vec<(u64, u32, &'a str)>,
    /// Why the run failed; empty if it did not.
    fault: String,
    /// S of a laser at full power; 0 without a laser.
    full: i32,
    rows: Vec<FlatRow>,
    /// The cell from above.
    #[serde(skip_serializing_if = "<[Shape]>::is_empty")]
    cell: &'a [Shape],
}

/// A curve: style, line, flags (1: its rate is that along an arc, 2: reference run), then us, x, y,
/// z, rate of each point one after the other, and a laser's power from 0 to 1.
#[derive(Serialize)]
struct Flat(usize, u32, u8, Vec<f64>, f64);

/// A row of the timeline: name, whether it is an output, spans of on in us.
#[derive(Serialize)]
struct FlatRow(String, bool, Vec<(u64, u64)>);

/// Lines of PRINT that a page has at most: an endless loop prints without end.
const MOST_PRINTS: usize = 5_000;
/// What is shorter than this part of the run is not told apart in its rows, once there is so much of
/// it: it is less than a pixel until one zooms in.
const MOMENTS: u64 = 20_000;

/// Writes the page.
pub fn render(plot: &Plot<'_>) -> String {
    let profile = &plot.program.profile;
    let curves = plot.curves();
    let printed = &plot.outcome.record.printed;
    let printed = &printed[..printed.len().min(MOST_PRINTS)];
    let data = Data {
        cell: plot.shapes(),
        title: plot.title,
        subtitle: chart::subtitle(plot.outcome, &plot.ending()),
        source: plot.source.lines().collect(),
        styles: Style::ALL.map(|style| [style.name(), style.legend()]).to_vec(),
        scale: Axis::ALL.map(|axis| {
            profile
                .axis(axis)
                .map_or(0.0, |own| f64::from(own.scale.steps) * 1000.0 / f64::from(own.scale.um))
        }),
        end: plot.duration_us(),
        running: thinned(plot.running(&curves), plot.duration_us()),
        prints: printed.iter().map(|own| (own.us, own.line, own.text.as_str())).collect(),
        fault: if plot.outcome.end.status == Status::Fault { plot.ending() } else { String::new() },
        full: if curves.iter().any(|own| own.power.is_some()) { profile.full_power() } else { 0 },
        curves: curves.iter().map(flat).collect(),
        rows: plot.rows().into_iter().map(|row| flat_row(row, plot.duration_us())).collect(),
    };
    // `</script>` or `<!--` in a script's text must not end the page's own script.
    let json = serde_json::to_string(&data).unwrap_or_default().replace('<', "\\u003c");
    let title = escape(plot.title);
    fill(PAGE, &[("title", &title), ("css", CSS), ("data", &json), ("viewer", VIEWER)])
}

/// Fills in the page's `{{marks}}`. What is filled in is not looked at again: a script may be called
/// like a mark.
fn fill(page: &str, marks: &[(&str, &str)]) -> String {
    let mut parts = page.split("{{");
    let mut filled = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (mark, rest) = part.split_once("}}").unwrap_or((part, ""));
        let text = marks.iter().find(|(name, _)| *name == mark).map_or("", |(_, text)| *text);
        filled.push_str(text);
        filled.push_str(rest);
    }
    filled
}

/// Leaves out the shortest of very many stretches.
fn thinned(running: Vec<(f64, f64, u32)>, end: u64) -> Vec<(u64, u64, u32)> {
    let least = if running.len() as u64 > MOMENTS { (end / MOMENTS) as f64 } else { 0.0 };
    let kept = running.into_iter().filter(|(from, to, _)| to - from >= least);
    kept.map(|(from, to, line)| (from.round() as u64, to.round() as u64, line)).collect()
}

/// Joins spans of a row that has very many.
fn flat_row(row: Row, end: u64) -> FlatRow {
    let least = if row.on.len() as u64 > MOMENTS { end / MOMENTS } else { 0 };
    let spans =
        row.on.chunk_by(|a, b| b.0 - a.1 < least).map(|run| (run[0].0, run[run.len() - 1].1));
    let spans = spans.collect();
    FlatRow(row.name, row.output, spans)
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

fn flat(curve: &Curve) -> Flat {
    let style = Style::ALL.iter().position(|style| *style == curve.style).unwrap_or(0);
    let round = |value: f64, digits: f64| (value * digits).round() / digits;
    let points = curve.points.iter().flat_map(|point| {
        let [x, y, z] = point.at.map(|value| round(value, 10_000.0));
        [point.us.round(), x, y, z, point.rate.round()]
    });
    let flags = u8::from(curve.arc) | u8::from(curve.home) << 1;
    Flat(style, curve.line, flags, points.collect(), round(curve.power.unwrap_or(1.0), 1000.0))
}
