//! Pictures of a run: an SVG to print, and one HTML page to explore it in.

mod chart;
mod curve;
mod html;
pub(crate) mod scale;
pub(crate) mod svg_page;
mod svg_speed;
mod svg_time;
#[cfg(test)]
mod tests;

use lang::axis::Axis;
use lang::hir::Program;

use crate::scene::picture::Shape;
use crate::sim::Outcome;
use crate::sim::record::{Edge, SegmentKind};
use crate::sim::trace::{MoveKind, Status};
pub use chart::time;
pub(crate) use curve::Curve;
#[cfg(test)]
pub(crate) use curve::Point;
use curve::curves;

/// Segments beyond this are drawn by their ends alone, without the ramps of their speed.
const DETAILED_SEGMENTS: usize = 20_000;

/// The shortest time that is drawn, us.
const LEAST_US: u64 = 10_000;

/// A run to draw.
pub struct Plot<'a> {
    /// Name of the script.
    pub title: &'a str,
    /// Its text.
    pub source: &'a str,
    /// The checked script, for its machine.
    pub program: &'a Program,
    /// What happened.
    pub outcome: &'a Outcome,
}

/// Form of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Scalable Vector Graphics.
    Svg,
    /// A page that needs nothing beside it.
    Html,
}

impl Form {
    /// The form that a file's name asks for.
    pub fn of(path: &str) -> Option<Form> {
        let name = path.to_ascii_lowercase();
        if name.ends_with(".svg") {
            Some(Form::Svg)
        } else if name.ends_with(".html") || name.ends_with(".htm") {
            Some(Form::Html)
        } else {
            None
        }
    }
}

/// What a piece of the path is drawn as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Style {
    /// Travel: G0, homing.
    Rapid,
    /// An axis on its own: MoveAxe, MoveRel, MoveSpeed.
    Axis,
    /// Work: G1, G2, G3.
    Cut,
    /// A probe move.
    Probe,
}

impl Style {
    /// Every style, in the order in which they are drawn over one another.
    pub(crate) const ALL: [Style; 4] = [Style::Rapid, Style::Axis, Style::Cut, Style::Probe];

    const fn of(kind: SegmentKind) -> Style {
        match kind {
            SegmentKind::Move(MoveKind::Rapid) | SegmentKind::Home => Style::Rapid,
            SegmentKind::Move(MoveKind::Line | MoveKind::Arc) => Style::Cut,
            SegmentKind::Move(MoveKind::Axe) | SegmentKind::Speed => Style::Axis,
            SegmentKind::Probe => Style::Probe,
        }
    }

    /// Name in classes and legends.
    const fn name(self) -> &'static str {
        match self {
            Style::Rapid => "rapid",
            Style::Axis => "axis",
            Style::Cut => "cut",
            Style::Probe => "probe",
        }
    }

    /// What the legend says.
    const fn legend(self) -> &'static str {
        match self {
            Style::Rapid => "rapid, homing",
            Style::Axis => "single axis",
            Style::Cut => "line, arc",
            Style::Probe => "probe",
        }
    }
}

/// One row of the timeline: an input or an output with the spans in which it was on.
pub(crate) struct Row {
    pub name: String,
    pub output: bool,
    /// Its number.
    pub n: i32,
    /// Start and end, us.
    pub on: Vec<(u64, u64)>,
}

impl Plot<'_> {
    /// The picture as a file's text.
    pub fn render(&self, form: Form) -> String {
        match form {
            Form::Svg => svg_page::render(self),
            Form::Html => html::render(self),
        }
    }

    pub(crate) fn curves(&self) -> Vec<Curve> {
        curves(&self.outcome.record.path, &self.program.profile, DETAILED_SEGMENTS)
    }

    /// The cell around the machine, from above.
    pub(crate) fn shapes(&self) -> &[Shape] {
        self.outcome.cell.as_ref().map_or(&[], |report| &report.shapes)
    }

    /// Length of the axes of time, us: of a run that takes none, a moment.
    fn duration_us(&self) -> u64 {
        self.outcome.summary.us.max(LEAST_US)
    }

    /// What runs when: begin and end, us, and the line. Of path and reference moves it is the line
    /// of what moves, since statements are read ahead of it; else that of the statement.
    fn running(&self, curves: &[Curve]) -> Vec<(f64, f64, u32)> {
        let end = self.outcome.summary.us as f64;
        let begun = &self.outcome.record.begun;
        let ends = begun.iter().skip(1).map(|next| next.us as f64).chain([end]);
        let statements = begun.iter().zip(ends).map(|(own, to)| (own.us as f64, to, own.line));
        let path = curves.iter().filter(|curve| curve.style != Style::Axis);
        let mut moves = path
            .filter_map(|own| Some((own.points.first()?.us, own.points.last()?.us, own.line)))
            .peekable();
        let mut all: Vec<(f64, f64, u32)> = Vec::new();
        let mut add = |from: f64, to: f64, line: u32| match all.last_mut() {
            Some(last) if last.2 == line && last.1 >= from => last.1 = last.1.max(to),
            _ if to > from => all.push((from, to, line)),
            _ => {}
        };
        let mut told = 0.0_f64;
        for (from, to, line) in statements {
            told = told.max(from);
            while let Some((start, stop, moved)) = moves.next_if(|own| own.0 < to) {
                add(told, start, line);
                told = told.max(start);
                add(told, stop, moved);
                told = told.max(stop);
            }
            add(told, to, line);
            told = told.max(to);
        }
        for (start, stop, moved) in moves {
            add(told.max(start), stop, moved);
            told = told.max(stop);
        }
        all
    }

    /// Curves that decide what part of the plane is shown: reference runs begin at an unknown place,
    /// so they count only when there is nothing else.
    fn shown(curves: &[Curve]) -> impl Iterator<Item = &Curve> + Clone {
        let only_home = curves.iter().all(|curve| curve.home);
        curves.iter().filter(move |curve| only_home || !curve.home)
    }

    fn has_z(&self) -> bool {
        self.program.profile.axis(Axis::Z).is_some()
    }

    /// How the run ended, in words.
    fn ending(&self) -> String {
        let end = self.outcome.end;
        match (end.status, end.fault) {
            (Status::Fault, Some(fault)) => {
                format!("{fault} {} in line {}", fault.text(), end.line)
            }
            (Status::Stopped, _) => format!("stopped in line {}", end.line),
            _ => "done".to_owned(),
        }
    }

    /// Outputs and inputs that changed in the run, outputs first.
    pub(crate) fn rows(&self) -> Vec<Row> {
        let record = &self.outcome.record;
        let profile = &self.program.profile;
        let outputs =
            edge_rows(&record.outputs, self.outcome.summary.us).into_iter().map(|(n, on)| {
                let named = profile.outputs.iter().find(|output| output.n == n);
                let role = named.and_then(|output| output.role).map(|role| format!("{role:?}"));
                let name = self.program.port_name(true, n).map(str::to_owned).or(role);
                Row { name: label("out", n, name), output: true, n, on }
            });
        let inputs =
            edge_rows(&record.inputs, self.outcome.summary.us).into_iter().map(|(n, on)| {
                let role = Axis::ALL
                    .into_iter()
                    .find(|axis| {
                        profile.axis(*axis).is_some() && profile.reference_input(*axis) == n
                    })
                    .map(|axis| format!("ref {}", axis.letter()))
                    .or_else(|| (profile.probe_input() == n).then(|| "probe".to_owned()));
                let name = self.program.port_name(false, n).map(str::to_owned).or(role);
                Row { name: label("in", n, name), output: false, n, on }
            });
        outputs.chain(inputs).collect()
    }
}

/// Longest label that has room beside the charts, characters.
const LONGEST_LABEL: usize = 13;

fn label(what: &str, n: i32, name: Option<String>) -> String {
    let Some(name) = name else { return format!("{what} {n}") };
    let label = format!("{what} {n} {}", name.to_lowercase());
    if label.chars().count() <= LONGEST_LABEL {
        return label;
    }
    let short: String = label.chars().take(LONGEST_LABEL - 1).collect();
    format!("{short}\u{2026}")
}

/// Spans in which each number was on, by ascending number.
fn edge_rows(edges: &[Edge], end_us: u64) -> Vec<(i32, Vec<(u64, u64)>)> {
    let mut rows: std::collections::BTreeMap<i32, Vec<(u64, u64)>> =
        std::collections::BTreeMap::new();
    let mut on_since: std::collections::BTreeMap<i32, u64> = std::collections::BTreeMap::new();
    for edge in edges {
        let row = rows.entry(edge.n).or_default();
        if edge.on {
            on_since.entry(edge.n).or_insert(edge.us);
        } else if let Some(start) = on_since.remove(&edge.n) {
            row.push((start, edge.us));
        }
    }
    for (n, start) in on_since {
        rows.entry(n).or_default().push((start, end_us.max(start)));
    }
    rows.into_iter().collect()
}
