//! What a run in a cell gives: its log, its expectations, its sums.

use cell::judge::{self, End, Row};
use cell::log::{Event, What};
use cell::things::Where;
use serde::Serialize;

use super::Scene;

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
    /// Lines of sums.
    pub sums: Vec<String>,
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
        Self {
            held: names(&|thing| matches!(thing.place, Where::Held(_))),
            stayed: names(&|thing| thing.place == thing.home),
            rejected,
            rows,
            log: cell.log().to_vec(),
            sums,
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
            sums: Vec::new(),
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
        for sum in &self.sums {
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
