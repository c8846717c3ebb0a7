//! Expectations: what was wanted, what was, and whether it holds.

mod engraved;

use super::kernel::Cell;
use super::list;
use super::log::What;
use super::scene::{Expect, ToolKind};
use super::things::{self, Thing, Where};

/// What the machine says of a run at its end.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct End {
    /// Time of the run, us.
    pub us: u64,
    /// `done`, `stopped`, or the fault, `F13`.
    pub how: String,
    /// Lines that were printed.
    pub printed: Vec<String>,
    /// Outputs that are on.
    pub on: Vec<u32>,
    /// Sensors that came on at any time.
    pub seen: Vec<String>,
}

/// A row of the table of expectations.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Name of the expectation.
    pub name: String,
    /// What it is about.
    pub what: String,
    /// What was wanted.
    pub wanted: String,
    /// What was.
    pub was: String,
    /// Whether it holds.
    pub holds: bool,
    /// Things that keep it from holding.
    pub things: Vec<String>,
    /// Of these so many need not be where they are wanted: `count` asks for fewer than there are.
    pub spare: usize,
}

/// Two places are the same within this, mm.
const SAME: f64 = 0.01;

/// Judges a run. `files` reads the files that expectations name.
#[must_use]
pub fn judge(cell: &Cell, end: &End, files: super::build::Files<'_>) -> Vec<Row> {
    cell.scene().expects.iter().map(|expect| Judge { cell, end, expect, files }.row()).collect()
}

struct Judge<'a> {
    cell: &'a Cell,
    end: &'a End,
    expect: &'a Expect,
    files: super::build::Files<'a>,
}

impl Judge<'_> {
    fn row(&self) -> Row {
        let (wanted, was, holds, things) = match self.expect.what.as_str() {
            "in_place" => self.in_place(),
            "holes" => self.holes(),
            "beads" => self.beads(),
            "engraved" => self.engraved(),
            "no_collision" => {
                let hits: Vec<String> = self
                    .cell
                    .log()
                    .iter()
                    .filter(|event| event.is_collision())
                    .map(|event| hit(&event.what))
                    .collect();
                (
                    String::from("none"),
                    hits.first().cloned().unwrap_or_else(|| "none".to_owned()),
                    hits.is_empty(),
                    Vec::new(),
                )
            }
            "no_drop" => self.no_drop(),
            "nothing_held" => {
                let held: Vec<String> = self
                    .things()
                    .filter(|thing| matches!(thing.place, Where::Held(_)))
                    .map(|thing| thing.name.clone())
                    .collect();
                ("nothing".to_owned(), words(&held, "nothing"), held.is_empty(), held)
            }
            "nothing_on" => {
                let on: Vec<String> =
                    self.end.on.iter().map(|output| format!("output {output}")).collect();
                ("nothing".to_owned(), words(&on, "nothing"), on.is_empty(), Vec::new())
            }
            "time" => {
                let below = self.number("below_s").unwrap_or(0.0);
                let seconds = self.end.us as f64 / 1e6;
                (format!("below {below} s"), format!("{seconds:.2} s"), seconds < below, Vec::new())
            }
            "prints" => {
                let text = self.text("text");
                let count = self.end.printed.iter().filter(|line| line.contains(&text)).count();
                match self.count() {
                    Some(wanted) => (
                        format!("\"{text}\" {wanted} times"),
                        format!("{count} times"),
                        count == wanted,
                        Vec::new(),
                    ),
                    None => {
                        (format!("\"{text}\""), format!("{count} times"), count > 0, Vec::new())
                    }
                }
            }
            "ends" => {
                let wanted = self.text("text");
                (wanted.clone(), self.end.how.clone(), self.end.how == wanted, Vec::new())
            }
            "never" => {
                let sensor = self.text("sensor");
                let seen = self.cell.log().iter().find(
                    |event| matches!(&event.what, What::Sense { name, v: true } if *name == sensor),
                );
                let was = seen.map_or("never".to_owned(), |event| {
                    format!("on at {:.3} s", event.us as f64 / 1e6)
                });
                ("never".to_owned(), was, seen.is_none(), Vec::new())
            }
            "bead" => self.bead(),
            "order" => self.order(),
            other => (other.to_owned(), "this cannot be judged yet".to_owned(), false, Vec::new()),
        };
        Row {
            name: self.expect.name.clone(),
            what: self.expect.what.clone(),
            wanted,
            was,
            holds,
            things,
            spare: self.spare(),
        }
    }

    /// How many parts of `in_place` need not come to the place.
    fn spare(&self) -> usize {
        let count = self.count().filter(|_| self.expect.what == "in_place");
        count.map_or(0, |count| self.wanted_things().len().saturating_sub(count))
    }

    /// Things that may come to the place of `in_place`.
    fn wanted_things(&self) -> Vec<&Thing> {
        self.of().into_iter().filter(|thing| thing.home != Where::Gone).collect()
    }

    fn things(&self) -> impl Iterator<Item = &Thing> {
        self.cell.things().iter()
    }

    fn number(&self, key: &str) -> Option<f64> {
        self.expect.entry.number(key)
    }

    fn text(&self, key: &str) -> String {
        self.expect.entry.text(key).unwrap_or_default()
    }

    fn count(&self) -> Option<usize> {
        self.number("count").map(|count| count as usize)
    }

    /// Things of the feeder, conveyor or part that `of` names; all where it names none.
    fn of(&self) -> Vec<&Thing> {
        let scene = self.cell.scene();
        let wanted = self.expect.entry.text("of");
        self.things()
            .filter(|thing| match (&wanted, thing.feeder) {
                (None, _) => true,
                (Some(name), Some((feeder, _))) => {
                    scene.feeders[feeder].name == *name || scene.parts[thing.part].name == *name
                }
                // A single part, or one that a belt has brought.
                (Some(name), None) => {
                    let from = thing.name.rsplit_once('.').map(|(belt, _)| belt);
                    thing.name == *name
                        || from == Some(name.as_str())
                        || from.is_some() && scene.parts[thing.part].name == *name
                }
            })
            .collect()
    }

    fn in_place(&self) -> (String, String, bool, Vec<String>) {
        let scene = self.cell.scene();
        let name = self.text("place");
        let Some(place) = scene.places.iter().find(|place| place.name == name) else {
            return (name, "there is no such place".to_owned(), false, Vec::new());
        };
        let within = self.number("within");
        let turn = self.number("turn_within_deg");
        let lies = |thing: &Thing| match thing.place {
            Where::Stands(at) => {
                let near = within.is_none_or(|within| {
                    (at[0] - place.at[0]).hypot(at[1] - place.at[1]) <= within
                });
                let turned = turn.is_none_or(|turn| off_turn(thing.form.turn_deg) <= turn);
                let inside = (0..2).all(|axis| {
                    (place.block.low[axis] - SAME..=place.block.high[axis] + SAME)
                        .contains(&at[axis])
                });
                inside && at[2] >= place.at[2] - SAME && near && turned
            }
            _ => false,
        };
        let parts = self.wanted_things();
        let there = parts.iter().filter(|thing| lies(thing)).count();
        // Two at once: what came with a part is one too many wherever parts are counted.
        let too_many: Vec<String> = self
            .things()
            .filter(|thing| thing.name.ends_with(things::TWIN) && lies(thing))
            .map(|thing| thing.name.clone())
            .collect();
        let wanted = self.count().unwrap_or(parts.len());
        let missing = parts.iter().filter(|thing| !lies(thing)).map(|thing| thing.name.clone());
        let holds = there == wanted && too_many.is_empty();
        // Nothing that is missing excuses one too many.
        let missing = missing.filter(|_| there <= wanted);
        let was = match too_many.as_slice() {
            [] => there.to_string(),
            twins => format!("{there}, and {}", twins.join(", ")),
        };
        (wanted.to_string(), was, holds, missing.chain(too_many).collect())
    }

    fn no_drop(&self) -> (String, String, bool, Vec<String>) {
        let within = self.number("within").unwrap_or(1.0);
        let deepest = self.things().max_by(|a, b| a.fell.total_cmp(&b.fell));
        let lost: Vec<String> = self
            .cell
            .log()
            .iter()
            .filter_map(|event| match &event.what {
                What::Lost { thing, .. } => Some(thing.clone()),
                _ => None,
            })
            .collect();
        let was = match (lost.first(), deepest) {
            (Some(thing), _) => format!("{thing} was lost"),
            (None, Some(thing)) if thing.fell > 0.0 => {
                format!("{} fell {:.2} mm", thing.name, thing.fell)
            }
            _ => "none".to_owned(),
        };
        let holds = lost.is_empty() && deepest.is_none_or(|thing| thing.fell <= within);
        let things = if holds {
            Vec::new()
        } else {
            self.things()
                .filter(|thing| thing.fell > within)
                .map(|thing| thing.name.clone())
                .chain(lost)
                .collect()
        };
        (format!("no deeper than {within} mm"), was, holds, things)
    }

    fn holes(&self) -> (String, String, bool, Vec<String>) {
        let within = self.number("within").unwrap_or(0.05);
        let depth = self.number("depth").unwrap_or(0.0);
        let mut wanted: Vec<[f64; 2]> =
            self.expect.entry.rows("at").iter().map(|row| [row[0], row[1]]).collect();
        if let Some(file) = self.expect.entry.text("file") {
            match (self.files)(&file).and_then(|text| list::points(&file, &text)) {
                Ok(points) => wanted.extend(points),
                Err(reason) => return ("holes".to_owned(), reason, false, Vec::new()),
            }
        }
        let holes: Vec<([f64; 2], f64)> = self
            .cell
            .log()
            .iter()
            .filter_map(|event| match event.what {
                What::Hole { at, depth } => Some((at, depth)),
                _ => None,
            })
            .collect();
        let (mut missing, mut shallow, mut worst) = (0, 0, 0.0f64);
        for place in &wanted {
            let near = holes
                .iter()
                .map(|(at, depth)| ((at[0] - place[0]).hypot(at[1] - place[1]), *depth))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            match near {
                Some((off, _)) if off > within => missing += 1,
                Some((off, made)) => {
                    worst = worst.max(off);
                    if made < depth - 1e-6 {
                        shallow += 1;
                    }
                }
                None => missing += 1,
            }
        }
        let extra = holes.len().saturating_sub(wanted.len() - missing);
        let mut was = vec![format!("{} holes", holes.len())];
        for (count, word) in [(missing, "missing"), (shallow, "too shallow"), (extra, "too many")] {
            if count > 0 {
                was.push(format!("{count} {word}"));
            }
        }
        was.push(format!("worst {worst:.3} mm"));
        let mut asked = format!("{} holes within {within} mm", wanted.len());
        let mut fits = true;
        if let Some(diameter) = self.number("diameter") {
            asked += &format!(", {diameter} mm wide");
            if let Some(made) = self.drill().filter(|made| (made - diameter).abs() > SAME) {
                was.push(format!("{made} mm wide"));
                fits = false;
            }
        }
        (asked, was.join(", "), fits && missing + shallow + extra == 0, Vec::new())
    }

    /// Diameter of the drill, mm.
    fn drill(&self) -> Option<f64> {
        self.cell.scene().tools.iter().find_map(|tool| match tool.kind {
            ToolKind::Drill { diameter, .. } => Some(diameter),
            _ => None,
        })
    }

    fn beads(&self) -> (String, String, bool, Vec<String>) {
        let beads: Vec<f64> = self
            .cell
            .log()
            .iter()
            .filter_map(|event| match event.what {
                What::Bead { mg, .. } => Some(mg),
                _ => None,
            })
            .collect();
        let wanted = self.count().unwrap_or(beads.len());
        let off = match (self.number("mg"), self.number("mg_within")) {
            (Some(mg), within) => beads
                .iter()
                .filter(|&&made| (made - mg).abs() > within.unwrap_or(0.0) + 1e-9)
                .count(),
            _ => 0,
        };
        let of = self.number("mg").map_or(String::new(), |mg| format!(" of {mg} mg"));
        let was = format!("{} beads, {off} outside", beads.len());
        (format!("{wanted} beads{of}"), was, off == 0 && beads.len() == wanted, Vec::new())
    }

    fn bead(&self) -> (String, String, bool, Vec<String>) {
        let from: [f64; 2] = self.expect.entry.numbers("from").unwrap_or_default();
        let to: [f64; 2] = self.expect.entry.numbers("to").unwrap_or_default();
        let within = self.number("within").unwrap_or(0.5);
        let near = |a: [f64; 2], b: [f64; 3]| (a[0] - b[0]).hypot(a[1] - b[1]) <= within;
        let found = self.cell.log().iter().find_map(|event| match event.what {
            What::Bead { from: begins, to: ends, mm, mg }
                if near(from, begins) && near(to, ends) =>
            {
                Some((mm, mg))
            }
            _ => None,
        });
        let wanted = format!("from {} {} to {} {}", from[0], from[1], to[0], to[1]);
        match (found, self.number("mg_mm")) {
            (None, _) => (wanted, "no such bead".to_owned(), false, Vec::new()),
            (Some((mm, mg)), Some(mg_mm)) => {
                let made = if mm > 0.0 { mg / mm } else { f64::INFINITY };
                let off = self.number("mg_within").unwrap_or(mg_mm * 0.1);
                (
                    format!("{wanted}, {mg_mm} mg/mm"),
                    format!("{made:.3} mg/mm"),
                    (made - mg_mm).abs() <= off,
                    Vec::new(),
                )
            }
            (Some((mm, _)), None) => (wanted, format!("{mm:.2} mm"), true, Vec::new()),
        }
    }

    /// The things came to rest in these places in this order.
    fn order(&self) -> (String, String, bool, Vec<String>) {
        let wanted = self.expect.entry.texts("places");
        let of: Vec<&str> = self.of().iter().map(|thing| thing.name.as_str()).collect();
        let was: Vec<String> = self
            .cell
            .log()
            .iter()
            .filter_map(|event| match &event.what {
                What::Rest { thing, on } if of.contains(&thing.as_str()) => Some(on.clone()),
                _ => None,
            })
            .collect();
        let holds = was == wanted;
        (wanted.join(", "), words(&was, "nothing"), holds, Vec::new())
    }
}

/// Degrees off the nearest full turn.
fn off_turn(deg: f64) -> f64 {
    let rest = deg.rem_euclid(360.0);
    rest.min(360.0 - rest)
}

fn words(list: &[String], none: &str) -> String {
    if list.is_empty() { none.to_owned() } else { list.join(", ") }
}

fn hit(what: &What) -> String {
    match what {
        What::Hit { thing, with, pos, line } => {
            format!(
                "{thing} hit {with} at {:.2} {:.2} {:.2} in line {line}",
                pos[0], pos[1], pos[2]
            )
        }
        What::Broke { tool, why, pos, line } => {
            format!("{tool} {why} at {:.2} {:.2} {:.2} in line {line}", pos[0], pos[1], pos[2])
        }
        _ => String::new(),
    }
}

/// The rows as a table: expectation, wanted, was, holds.
#[must_use]
pub fn table(rows: &[Row]) -> String {
    let cells: Vec<[String; 4]> =
        std::iter::once(["expectation", "wanted", "was", "holds"].map(str::to_owned))
            .chain(rows.iter().map(|row| {
                let holds = if row.holds { "yes" } else { "NO" };
                [row.name.clone(), row.wanted.clone(), row.was.clone(), holds.to_owned()]
            }))
            .collect();
    let widths: [usize; 4] = std::array::from_fn(|column| {
        cells.iter().map(|row| row[column].chars().count()).max().unwrap_or(0)
    });
    let mut out = String::new();
    for row in cells {
        let line: String =
            row.iter().zip(widths).map(|(cell, width)| format!("{cell:width$}  ")).collect();
        out += line.trim_end();
        out.push('\n');
    }
    out
}
