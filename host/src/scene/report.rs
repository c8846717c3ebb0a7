//! What a run in a cell gives: its log, its expectations, its sums.

use cell::judge::{self, End, Row};
use cell::log::{Event, What};
use cell::things::Where;
use serde::Serialize;

use super::Scene;
use super::picture::Shape;

/// See the module.
#[derive(Clone, Debug)]
pub struct Report {
    /// Expectations, in the order of the file.
    pub rows: Vec<Row>,
    /// What happened, in order.
    pub log: Vec<Event>,
    /// How the run ended.
    pub end: End,
    /// Things that hang on the tool at the end.
    pub held: Vec<String>,
    /// Things that stand where they stood at the start.
    pub stayed: Vec<String>,
    /// Things that lie in a place with `reject`.
    pub rejected: Vec<String>,
    /// What became of the first things that keep expectations from holding.
    pub stories: Vec<String>,
    /// Lines of sums.
    pub sums: Vec<String>,
    /// The cell from above, for pictures; empty unless it was asked for.
    pub shapes: Vec<Shape>,
}

/// A row as a line of JSON.
#[derive(Serialize)]
struct Line<'a> {
    expect: &'a str,
    name: &'a str,
    want: &'a str,
    was: &'a str,
    ok: bool,
}

impl Report {
    /// Judges a cell at the end of its run. `line_at` gives the script's line at a time, us.
    #[must_use]
    pub fn of(
        scene: &Scene,
        cell: &mut cell::kernel::Cell,
        end: End,
        line_at: &dyn Fn(u64) -> u32,
    ) -> Self {
        cell.set_lines(line_at);
        let rows = judge::judge(cell, &end, &|name| scene.file_named(name));
        let things = cell.things();
        let names = |test: &dyn Fn(&cell::things::Thing) -> bool| {
            things.iter().filter(|thing| test(thing)).map(|thing| thing.name.clone()).collect()
        };
        let rejects: Vec<&cell::scene::Place> =
            cell.scene().places.iter().filter(|place| place.reject).collect();
        let rejected = names(&|thing| match thing.place {
            Where::Stands(at) => rejects.iter().any(|place| place.block.holds(at)),
            _ => false,
        });
        let sums = sums(cell, &end);
        let stories = stories(cell, &rows, line_at);
        Self {
            stories,
            held: names(&|thing| matches!(thing.place, Where::Held(_))),
            stayed: names(&|thing| thing.place == thing.home),
            rejected,
            rows,
            log: cell.log().to_vec(),
            sums,
            shapes: Vec::new(),
            end,
        }
    }

    /// The report of a run that had no cell: its time alone.
    #[must_use]
    pub fn without_cell(us: u64) -> Self {
        Self {
            rows: Vec::new(),
            log: Vec::new(),
            end: End { us, ..End::default() },
            held: Vec::new(),
            stayed: Vec::new(),
            rejected: Vec::new(),
            stories: Vec::new(),
            sums: Vec::new(),
            shapes: Vec::new(),
        }
    }

    /// Whether all expectations hold.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.rows.iter().all(|row| row.holds)
    }

    /// Whether an expectation says how the run ends.
    #[must_use]
    pub fn judges_end(&self) -> bool {
        self.rows.iter().any(|row| row.what == "ends")
    }

    /// The table for people, with what is not modelled at its foot.
    #[must_use]
    pub fn table(&self) -> String {
        let mut text = judge::table(&self.rows);
        for sum in self.stories.iter().chain(&self.sums) {
            text += sum;
            text.push('\n');
        }
        text + "not modelled: " + NEVER + "\n"
    }

    /// A line of JSON for each expectation.
    #[must_use]
    pub fn json(&self) -> Vec<String> {
        let line = |row: &Row| {
            let Row { what, name, wanted, was, holds, .. } = row;
            let line = Line { expect: what, name, want: wanted, was, ok: *holds };
            serde_json::to_string(&line).unwrap_or_default()
        };
        self.rows.iter().map(line).collect()
    }
}

/// Things whose way is told at most.
const MOST_STORIES: usize = 3;

/// What became of the things that keep expectations from holding, a line each.
fn stories(cell: &cell::kernel::Cell, rows: &[Row], line_at: &dyn Fn(u64) -> u32) -> Vec<String> {
    let mut told: Vec<&String> = Vec::new();
    for name in rows.iter().filter(|row| !row.holds).flat_map(|row| &row.things) {
        if !told.contains(&name) && told.len() < MOST_STORIES {
            told.push(name);
        }
    }
    told.into_iter().map(|name| story(cell, name, line_at)).collect()
}

fn story(cell: &cell::kernel::Cell, name: &str, line_at: &dyn Fn(u64) -> u32) -> String {
    let mut parts = Vec::new();
    for event in cell.log() {
        let what = match &event.what {
            What::Take { thing, by } if thing == name => format!("taken by {by}"),
            What::Drop { thing, mm } if thing == name && *mm >= 0.01 => format!("fell {mm:.2} mm"),
            What::Rest { thing, on } if thing == name => format!("came to rest on {on}"),
            What::Lost { thing, why } if thing == name => (*why).to_owned(),
            What::Hit { thing, with, .. } if thing == name => format!("hit {with}"),
            _ => continue,
        };
        let (seconds, line) = (event.us as f64 / 1e6, line_at(event.us));
        parts.push(format!("{what} at {seconds:.3} s in line {line}"));
    }
    // The last of a long way are what explains the end.
    let late = parts.len().saturating_sub(4);
    let mut parts = parts.split_off(late);
    if parts.is_empty() {
        parts.push("never taken".to_owned());
    }
    let thing = cell.things().iter().find(|thing| thing.name == name);
    match thing.map(|thing| (thing.place, thing.form.turn_deg.rem_euclid(360.0))) {
        Some((Where::Stands([x, y, z]), turn)) => {
            let turned =
                if turn == 0.0 { String::new() } else { format!(", turned by {turn:.1} deg") };
            parts.push(format!("stands at {x:.2} {y:.2} {z:.2}{turned}"));
        }
        Some((Where::Held(_), _)) => parts.push("hangs on the tool".to_owned()),
        Some((Where::Gone, _)) | None => parts.push("is not there".to_owned()),
    }
    format!("{name}: {}", parts.join("; "))
}

/// What no cell models.
pub const NEVER: &str = "friction, bounce, elastic tools, heat, cutting force, cables";

/// Parts that came to rest in places, and how many an hour that are.
fn sums(cell: &cell::kernel::Cell, end: &End) -> Vec<String> {
    let places: Vec<&str> = cell.scene().places.iter().map(|place| place.name.as_str()).collect();
    let rested = |event: &&Event| matches!(&event.what, What::Rest { on, .. } if places.contains(&on.as_str()));
    let placed = cell.log().iter().filter(rested).count();
    let mut sums = Vec::new();
    if placed > 0 && end.us > 0 {
        let an_hour = placed as f64 * 3.6e9 / end.us as f64;
        sums.push(format!("{placed} parts put into places, {an_hour:.0} an hour"));
    }
    sums
}
