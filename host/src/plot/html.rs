//! The picture as one HTML page with nothing beside it: the run as data, and a viewer for it.

use lang::axis::Axis;
use serde::Serialize;

use super::curve::Curve;
use super::{Plot, Style, chart};

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
    rows: Vec<FlatRow>,
}

/// A curve: style, line, flags (1: its rate is that along an arc, 2: reference run), then us, x, y,
/// z, rate of each point one after the other.
#[derive(Serialize)]
struct Flat(usize, u32, u8, Vec<f64>);

/// A row of the timeline: name, whether it is an output, spans of on in us.
#[derive(Serialize)]
struct FlatRow(String, bool, Vec<(u64, u64)>);

/// Writes the page.
pub fn render(plot: &Plot<'_>) -> String {
    let profile = &plot.program.profile;
    let data = Data {
        title: plot.title,
        subtitle: chart::subtitle(plot.outcome, &plot.ending()),
        source: plot.source.lines().collect(),
        styles: Style::ALL.map(|style| [style.name(), style.legend()]).to_vec(),
        scale: Axis::ALL.map(|axis| {
            profile
                .axis(axis)
                .map_or(0.0, |own| f64::from(own.scale.steps) * 1000.0 / f64::from(own.scale.um))
        }),
        end: plot.outcome.summary.us,
        curves: plot.curves().iter().map(flat).collect(),
        rows: plot.rows().into_iter().map(|row| FlatRow(row.name, row.output, row.on)).collect(),
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
    Flat(style, curve.line, flags, points.collect())
}
