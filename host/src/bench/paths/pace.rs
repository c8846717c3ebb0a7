//! The speeds of several runs of one path over time, in one chart.

use svg::node::element::path::Data;
use svg::node::element::{Path, Style as Css};
use svg::{Document, Node};

use crate::plot::scale::{Scale, Span};
use crate::plot::svg_page::{CSS, LEFT, RIGHT, WIDTH, frame, line, round, text};

/// Height of the chart, px.
const HEIGHT: f64 = 360.0;
/// Its upper edge: title and legend stand above.
const TOP: f64 = 92.0;
/// Colours of the runs, in their order.
const COLOURS: [&str; 3] = ["#9fadc2", "#1f62e0", "#d6403a"];

/// A run of the path.
pub struct Pace {
    /// What it is called in the legend.
    pub name: &'static str,
    /// What it takes, s.
    pub seconds: f64,
    /// Times, s, and speeds along the path, mm/s.
    pub points: Vec<[f64; 2]>,
}

/// Draws up to three runs, the first at the bottom; the title tells what each takes.
pub fn paces(title: &str, runs: &[Pace]) -> String {
    let values = |n: usize| runs.iter().flat_map(move |run| run.points.iter().map(move |p| p[n]));
    let most = |n: usize| values(n).fold(0.0, f64::max).max(0.001);
    let x = Scale { span: Span { low: 0.0, high: most(0) * 1.01 }, from: LEFT, to: RIGHT };
    let y = Scale { span: Span { low: 0.0, high: most(1) * 1.15 }, from: TOP + HEIGHT, to: TOP };
    let mut css = CSS.to_owned();
    for (n, colour) in COLOURS.iter().enumerate() {
        css += &format!(".pace-{n} {{ stroke: {colour}; stroke-width: 1.5; }}\n");
    }
    let mut page = Document::new().add(Css::new(css));
    let times: Vec<String> = runs.iter().map(|run| format!("{:.2} s", run.seconds)).collect();
    page.append(text(LEFT, 40.0, "title", &format!("{title}: {}", times.join(", "))));
    page.append(frame(&x, &y, "Speed along the path, mm/s", (14, 8)));
    let mut left = LEFT;
    for (n, run) in runs.iter().enumerate() {
        let class = format!("path pace-{n}");
        let mut data = Data::new();
        for (first, [seconds, speed]) in run.points.iter().enumerate() {
            let place = (round(x.at(*seconds)), round(y.at(*speed)));
            data = if first == 0 { data.move_to(place) } else { data.line_to(place) };
        }
        page.append(Path::new().set("class", class.as_str()).set("d", data));
        page.append(line(left, 68.0, left + 26.0, 68.0, &class));
        let legend = format!("{}, {:.2} s", run.name, run.seconds);
        page.append(text(left + 32.0, 72.0, "legend", &legend));
        left += 250.0;
    }
    let under = TOP + HEIGHT + 34.0;
    page.append(text(RIGHT, under, "caption", "Time, s").set("text-anchor", "end"));
    let bottom = under + 16.0;
    page.set("viewBox", (0, 0, WIDTH as i64, bottom as i64))
        .set("width", WIDTH)
        .set("height", bottom)
        .to_string()
}
