//! Time in the SVG: what runs, outputs and inputs, what was printed, where the run failed.

use svg::Node;
use svg::node::element::{Group, Rectangle, Text, Title};

use super::chart::{self, Lines};
use super::curve::Curve;
use super::scale::Scale;
use super::svg_page::{LEFT, Panel, RIGHT, line, round, text};
use super::{Plot, Row};
use crate::sim::trace::Status;

/// Height of a row.
const ROW: f64 = 24.0;
/// Bars of a row that are nearer to one another than this are drawn as one, px: an endless loop has
/// thousands.
const LEAST_GAP: f64 = 0.5;
/// Width of a letter in the row of what was printed, px.
const LETTER: f64 = 6.2;

/// Rows over time: what runs (by statement), what is printed, outputs, inputs.
pub fn timeline(
    plot: &Plot<'_>,
    lines: &Lines<'_>,
    curves: &[Curve],
    x: &Scale,
    top: f64,
) -> Panel {
    let rows = plot.rows();
    let prints = !plot.outcome.record.printed.is_empty();
    let height = ROW * (rows.len() + 1 + usize::from(prints)) as f64 + 30.0;
    let mut group = Group::new().add(
        Rectangle::new()
            .set("x", LEFT)
            .set("y", round(top))
            .set("width", RIGHT - LEFT)
            .set("height", height)
            .set("rx", 4)
            .set("class", "panel"),
    );
    group.append(text(LEFT + 8.0, top + 16.0, "caption", "Time, s"));
    let (ticks, digits) = x.span.ticks(14);
    for value in ticks {
        let at = x.at(value);
        group.append(line(at, top + 24.0, at, top + height, "grid"));
        group.append(
            text(at, top + height + 15.0, "tick", &format!("{value:.digits$}"))
                .set("text-anchor", "middle"),
        );
    }
    let mut row_top = top + 26.0;
    group.append(statements(plot, lines, curves, x, row_top));
    if prints {
        row_top += ROW;
        group.append(printed(plot, x, row_top));
    }
    for row in &rows {
        row_top += ROW;
        group.append(bars(row, x, row_top));
    }
    if plot.outcome.end.status == Status::Fault {
        group.append(failure(plot, x, top, height));
    }
    Panel { group, bottom: top + height + 16.0 }
}

fn bar(x: &Scale, top: f64, from_us: f64, to_us: f64, class: &str, title: &str) -> Rectangle {
    let (from, to) = (x.at(from_us / 1e6), x.at(to_us / 1e6));
    Rectangle::new()
        .set("x", round(from))
        .set("y", round(top + 4.0))
        .set("width", round((to - from).max(1.0)))
        .set("height", ROW - 8.0)
        .set("rx", 2)
        .set("class", class)
        .add(Title::new(title))
}

/// The row of statements: a bar for each stretch of one, with its line number where it fits.
fn statements(plot: &Plot<'_>, lines: &Lines<'_>, curves: &[Curve], x: &Scale, top: f64) -> Group {
    let mut group = Group::new();
    group.append(row_name(top, "line"));
    let mut drawn_to = f64::NEG_INFINITY;
    for (from_us, to_us, number) in plot.running(curves) {
        let (from, to) = (x.at(from_us / 1e6), x.at(to_us / 1e6));
        if to < drawn_to + LEAST_GAP {
            continue;
        }
        drawn_to = to;
        group.append(bar(x, top, from_us, to_us, "statement", &lines.title(number)));
        if to - from > 20.0 {
            group.append(
                text((from + to) / 2.0, top + ROW / 2.0 + 4.0, "tick", &number.to_string())
                    .set("text-anchor", "middle"),
            );
        }
    }
    group
}

/// The row of PRINT: a mark for each line, its text where it fits.
fn printed(plot: &Plot<'_>, x: &Scale, top: f64) -> Group {
    let mut group = Group::new();
    group.append(row_name(top, "print"));
    let list = &plot.outcome.record.printed;
    let (mut marked_to, mut written_to) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
    for (i, print) in list.iter().enumerate() {
        let at = x.at(print.us as f64 / 1e6);
        if at < marked_to + LEAST_GAP {
            continue;
        }
        marked_to = at;
        let us = print.us as f64;
        let title = format!("line {}: {}", print.line, print.text);
        group.append(bar(x, top, us, us, "print", &title));
        let next = list.get(i + 1).map_or(RIGHT, |next| x.at(next.us as f64 / 1e6));
        let width = print.text.chars().count() as f64 * LETTER + 6.0;
        if at > written_to && at + width < next.min(RIGHT) {
            written_to = at + width;
            group.append(text(at + 4.0, top + ROW / 2.0 + 4.0, "tick", &print.text));
        }
    }
    group
}

/// Where the run failed, with the reason.
fn failure(plot: &Plot<'_>, x: &Scale, top: f64, height: f64) -> Group {
    let at = x.at(plot.outcome.summary.us as f64 / 1e6);
    let mut group = Group::new();
    group.append(line(at, top + 20.0, at, top + height, "failed"));
    let (place, anchor) = if at > (LEFT + RIGHT) / 2.0 { (-6.0, "end") } else { (6.0, "start") };
    group
        .append(text(at + place, top + 16.0, "failure", &plot.ending()).set("text-anchor", anchor));
    group
}

fn row_name(top: f64, name: &str) -> Text {
    text(LEFT - 8.0, top + ROW / 2.0 + 4.0, "row", name).set("text-anchor", "end")
}

fn bars(row: &Row, x: &Scale, top: f64) -> Group {
    let mut group = Group::new();
    group.append(row_name(top, &row.name));
    let class = if row.output { "on" } else { "in" };
    let place = |us: u64| x.at(us as f64 / 1e6);
    let close = |a: &(u64, u64), b: &(u64, u64)| place(b.0) - place(a.1) < LEAST_GAP;
    for run in row.on.chunk_by(close) {
        let (from, to) = (run[0].0, run[run.len() - 1].1);
        let title = match run.len() {
            1 => format!("{} on for {}", row.name, chart::time(to - from)),
            count => format!("{} on {count} times in {}", row.name, chart::time(to - from)),
        };
        group.append(bar(x, top, from as f64, to as f64, class, &title));
    }
    group
}
