//! Makes a scene of the checked tables of a file.

mod around;
mod only;
pub(crate) mod tool;
mod top;

use super::check::strikes;
use super::list;
use super::problem::{Problem, nearest};
use super::read::{Names, tables};
use super::scene::{
    Block, Expect, Feeder, Fixture, Form, Part, Place, Scene, Spread, Stock, V3, Vary,
};
pub use super::source::Files;
use super::source::Sources;
use super::value::Entry;
use std::ops::Range;

/// Version of the format that this program reads.
pub const VERSION: f64 = 1.0;

/// Parts that feeders of a scene hold at most: what looks for neighbours compares each with each.
const MOST_PARTS: usize = 10_000;

/// Reads a cell file.
///
/// # Errors
/// All problems, when one of them is an error; else warnings come with the scene.
pub fn scene(
    sources: &Sources,
    names: &dyn Names,
    files: Files<'_>,
) -> Result<(Scene, Vec<Problem>), Vec<Problem>> {
    let mut problems = Vec::new();
    let mut entries = Vec::new();
    for (text, from) in sources.texts() {
        let known = problems.len();
        let mut own = tables(text, names, &mut problems);
        own.iter_mut().for_each(|entry| entry.shift(from));
        for problem in &mut problems[known..] {
            problem.span = problem.span.start + from..problem.span.end + from;
        }
        entries.append(&mut own);
    }
    let mut builder =
        Builder { scene: Scene::default(), problems, files, taken: Vec::new(), names };
    if builder.problems.iter().all(|problem| problem.code != "C001") {
        builder.all(entries);
    }
    let Builder { scene, mut problems, .. } = builder;
    problems.sort_by_key(|problem| (problem.span.start, !problem.error));
    if problems.iter().any(|problem| problem.error) { Err(problems) } else { Ok((scene, problems)) }
}

struct Builder<'a> {
    scene: Scene,
    problems: Vec<Problem>,
    files: Files<'a>,
    /// Names of things so far.
    taken: Vec<String>,
    /// The profile's names.
    names: &'a dyn Names,
}

fn us(ms: f64) -> u64 {
    (ms * 1000.0).round() as u64
}

impl Builder<'_> {
    fn wrong(&mut self, code: &'static str, span: Range<usize>, text: impl Into<String>) {
        self.problems.push(Problem::error(code, span, text));
    }

    fn all(&mut self, entries: Vec<Entry>) {
        // Parts first: feeders and conveyors name them.
        let (parts, others): (Vec<Entry>, Vec<Entry>) =
            entries.into_iter().partition(|entry| entry.section == "part");
        let mut first = true;
        let several_tools = others.iter().filter(|entry| entry.section == "tool").count() > 1;
        let persons: Vec<Entry> =
            others.iter().filter(|entry| entry.section == "person").cloned().collect();
        for entry in &parts {
            self.name(entry);
            self.part(entry);
        }
        for entry in others {
            self.name(&entry);
            self.only(&entry);
            match entry.section {
                "" if std::mem::take(&mut first) => self.top(&entry),
                "" => self.included(&entry),
                "tool" => self.tool(&entry, several_tools),
                "feeder" => self.feeder(&entry),
                "place" => self.place(&entry),
                "fixture" => self.fixture(&entry),
                "stock" => self.stock(&entry),
                "conveyor" => self.conveyor(&entry),
                "sensor" => self.sensor(&entry),
                "person" => self.person(&entry),
                "expect" => self.expect(entry),
                "vary" => self.vary(&entry),
                _ => {}
            }
        }
        // Of a file that is read in part only, names would be missed that are there.
        if self.problems.iter().all(|problem| !problem.error) {
            self.person_names(&persons);
        }
    }

    /// A thing's name is its own.
    fn name(&mut self, entry: &Entry) {
        if matches!(entry.section, "" | "expect" | "vary" | "stock") {
            return;
        }
        let Some(name) = entry.text("name") else { return };
        if self.taken.contains(&name) {
            self.problems.push(
                Problem::error(
                    "C005",
                    entry.span_of("name"),
                    format!("two things are named \"{name}\""),
                )
                .hint("messages and expectations name things: give each its own name"),
            );
        }
        self.taken.push(name);
    }

    /// `at`, or what `corner` says.
    fn stands(&mut self, entry: &Entry, size: V3, must: bool) -> Option<V3> {
        if let Some(at) = entry.numbers::<3>("at") {
            if entry.has("corner") {
                self.wrong(
                    "C004",
                    entry.span_of("corner"),
                    "`corner` and `at` both say where it stands: keep one",
                );
            }
            return Some(at);
        }
        if let Some([x, y, z]) = entry.numbers::<3>("corner") {
            return Some([x + size[0] / 2.0, y + size[1] / 2.0, z]);
        }
        if must && !entry.has("at") && !entry.is_spoilt(&["at", "corner"]) {
            let name = entry.text("name").unwrap_or_default();
            self.wrong(
                "C003",
                entry.span.clone(),
                format!("missing `at` of {} \"{name}\"", entry.section),
            );
        }
        None
    }

    fn form(entry: &Entry) -> Option<Form> {
        Some(Form {
            size: entry.numbers::<3>("size")?,
            round: entry.text("shape").as_deref() == Some("cylinder"),
            turn_deg: entry.number("turn_deg").unwrap_or(0.0),
        })
    }

    fn part(&mut self, entry: &Entry) {
        let (Some(name), Some(form)) = (entry.text("name"), Self::form(entry)) else { return };
        let at = self.stands(entry, form.size, false);
        self.scene.parts.push(Part {
            name,
            form,
            at,
            mass_g: entry.number("mass_g").unwrap_or(1.0),
            colour: entry.text("colour").unwrap_or_default(),
            metal: entry.flag("metal"),
        });
    }

    fn part_named(&mut self, entry: &Entry, key: &str) -> Option<usize> {
        let name = entry.text(key)?;
        if let Some(index) = self.scene.parts.iter().position(|part| part.name == name) {
            return Some(index);
        }
        let known: Vec<&str> = self.scene.parts.iter().map(|part| part.name.as_str()).collect();
        let text =
            format!("`{key}` of {} names part \"{name}\"{}", entry.section, meant(&name, &known));
        self.wrong("C011", entry.span_of(key), text);
        None
    }

    fn feeder(&mut self, entry: &Entry) {
        let (Some(name), Some(part)) = (entry.text("name"), self.part_named(entry, "part")) else {
            return;
        };
        let kind = entry.text("kind").unwrap_or_default();
        let turn = entry.number("turn_deg").unwrap_or(0.0);
        let mut pockets = Vec::new();
        if kind == "list" {
            let offset: [f64; 2] = entry.numbers("offset").unwrap_or_default();
            let height = entry.numbers::<3>("at").map_or(0.0, |at| at[2]);
            match entry.text("file") {
                Some(file) => {
                    match (self.files)(&file).and_then(|text| list::placements(&file, &text)) {
                        Ok(rows) => pockets.extend(rows.iter().map(|row| {
                            ([row.x + offset[0], row.y + offset[1], height], row.turn_deg)
                        })),
                        Err(reason) => self.wrong("C015", entry.span_of("file"), reason),
                    }
                }
                None if entry.lacks("file") => self.wrong(
                    "C003",
                    entry.span.clone(),
                    format!("missing `file` of feeder \"{name}\""),
                ),
                None => {}
            }
        } else {
            let Some(at) = self.stands(entry, [0.0; 3], true) else { return };
            let [columns, rows] = entry.numbers("count").unwrap_or([1.0, 1.0]);
            let pitch: [f64; 2] = entry.numbers("pitch").unwrap_or_default();
            let (columns, rows) =
                if kind == "tray" { (columns as usize, rows as usize) } else { (1, 1) };
            let before: usize = self.scene.feeders.iter().map(|feeder| feeder.pockets.len()).sum();
            if before + columns * rows > MOST_PARTS {
                let text = format!(
                    "`count` of feeder \"{name}\" makes {} parts of the scene; it has at most {MOST_PARTS}",
                    before + columns * rows
                );
                self.wrong("C004", entry.span_of("count"), text);
                return;
            }
            for row in 0..rows {
                for column in 0..columns {
                    let x = at[0] + pitch[0] * column as f64;
                    pockets.push(([x, at[1] + pitch[1] * row as f64, at[2]], turn));
                }
            }
            self.pitch(entry, part, columns, rows, pitch);
        }
        let mut empty = Vec::new();
        for pocket in entry.list("empty") {
            if pocket as usize > pockets.len() {
                let text = format!(
                    "`empty` of feeder \"{name}\" names pocket {pocket}; it has {}",
                    pockets.len()
                );
                self.wrong("C004", entry.span_of("empty"), text);
            } else {
                empty.push(pocket as usize - 1);
            }
        }
        self.scene.feeders.push(Feeder {
            name,
            kind,
            part,
            pockets,
            empty,
            output: entry.port("output"),
            advance_us: us(entry.number("advance_ms").unwrap_or(0.0)),
            input: entry.port("input"),
            length: entry.port("length"),
            spread: [
                entry.number("spread").unwrap_or(0.0),
                entry.number("spread_deg").unwrap_or(0.0),
            ],
        });
    }

    /// Parts of a tray must not stand in one another.
    fn pitch(&mut self, entry: &Entry, part: usize, columns: usize, rows: usize, pitch: [f64; 2]) {
        let size = self.scene.parts[part].form.size;
        for (axis, count) in [(0, columns), (1, rows)] {
            if count > 1 && pitch[axis].abs() < size[axis].min(size[1 - axis]) {
                let text = format!(
                    "`pitch` is {} in {}: parts \"{}\" of {} mm stand in one another",
                    pitch[axis],
                    ["X", "Y"][axis],
                    self.scene.parts[part].name,
                    size[axis]
                );
                self.wrong("C010", entry.span_of("pitch"), text);
            }
        }
    }

    fn place(&mut self, entry: &Entry) {
        let (Some(name), Some(at), Some(size)) =
            (entry.text("name"), entry.numbers::<3>("at"), entry.numbers::<3>("size"))
        else {
            return;
        };
        self.scene.places.push(Place {
            name,
            block: Block::standing(at, size),
            at,
            room: entry.number("room").unwrap_or(1.0) as u32,
            reject: entry.flag("reject"),
        });
    }

    fn fixture(&mut self, entry: &Entry) {
        let (Some(name), Some(form)) = (entry.text("name"), Self::form(entry)) else { return };
        let Some(at) = self.stands(entry, form.size, true) else { return };
        let door = match (entry.port("opens_by"), entry.numbers::<3>("open_at")) {
            (Some(output), Some(open)) => {
                Some((output, open, us(entry.number("move_ms").unwrap_or(0.0))))
            }
            (Some(_), None) if entry.lacks("open_at") => {
                self.wrong(
                    "C003",
                    entry.span.clone(),
                    format!("missing `open_at` of fixture \"{name}\", which `opens_by` an output"),
                );
                None
            }
            _ => None,
        };
        let slices = entry.number("slices").unwrap_or(8.0) as u32;
        self.scene.fixtures.push(Fixture {
            name,
            form,
            at,
            slices,
            solid: entry.flag("solid"),
            door,
        });
    }

    fn stock(&mut self, entry: &Entry) {
        let (Some(at), Some(size)) = (entry.numbers::<3>("at"), entry.numbers::<3>("size")) else {
            return;
        };
        let heights = entry.text("heights");
        if let Some(file) = &heights
            && let Err(reason) = (self.files)(file).and_then(|text| list::heights(file, &text))
        {
            self.wrong("C015", entry.span_of("heights"), reason);
        }
        self.scene.stock = Some(Stock {
            at,
            size,
            grid: entry.number("grid").unwrap_or(0.5),
            tilt: entry.numbers("tilt").unwrap_or_default(),
            heights,
            touch: entry.port("touch"),
        });
    }

    fn expect(&mut self, entry: Entry) {
        let Some(what) = entry.text("what") else { return };
        let must: &[&str] = match what.as_str() {
            "in_place" => &["place"],
            "beads" => &["count"],
            "bead" => &["from", "to"],
            "engraved" => &["file"],
            "order" => &["places"],
            "time" => &["below_s"],
            "prints" | "ends" => &["text"],
            "never" => &["sensor"],
            _ => &[],
        };
        for key in must {
            if entry.lacks(key) {
                self.wrong(
                    "C003",
                    entry.span.clone(),
                    format!("missing `{key}` of expectation {what}"),
                );
            }
        }
        if what == "holes" && entry.lacks("at") && entry.lacks("file") {
            self.wrong("C003", entry.span.clone(), "missing `at` or `file` of expectation holes");
        }
        let name = entry.text("name").unwrap_or_else(|| match entry.text("place") {
            Some(place) => format!("{what} {place}"),
            None => what.clone(),
        });
        self.scene.expects.push(Expect { what, name, entry });
    }

    /// A fault strikes somebody, at a time, by how much.
    fn strikes(&mut self, entry: &Entry, fault: &str) {
        let missing = |key: &str, hint: &str| {
            let text = format!("missing `{key}` of fault {fault}");
            Problem::error("C003", entry.span.clone(), text).hint(hint)
        };
        let zero = |key: &str, hint: &str| {
            let text = format!("`{key}` of fault {fault} is 0; it must be above 0");
            Problem::error("C004", entry.span_of(key), text).hint(hint)
        };
        let mut number = |key: &str, hint: &str| match entry.number(key) {
            None if entry.lacks(key) => self.problems.push(missing(key, hint)),
            Some(0.0) => self.problems.push(zero(key, hint)),
            _ => {}
        };
        if strikes::needs_time(fault) {
            number("within_s", "write the length of the run: it comes at some time of it");
        }
        if strikes::needs_delay(fault) {
            number("up_to_ms", "write the longest delay");
        }
        if fault == "stall" {
            number("steps", "write the steps that the motor loses");
        }
        // Of a file that is read in part only, names would be missed that are there.
        if self.problems.iter().any(|problem| problem.error) {
            return;
        }
        let of = entry.text("of");
        if let Err(text) = strikes::target(&self.scene, self.names, fault, of.as_deref()) {
            let (code, span) = match of {
                Some(_) => ("C011", entry.span_of("of")),
                None if fault == "door" => ("C011", entry.span_of("fault")),
                None => ("C003", entry.span.clone()),
            };
            self.wrong(code, span, text);
        }
    }

    fn vary(&mut self, entry: &Entry) {
        match (entry.text("key"), entry.text("fault")) {
            (Some(key), None) => {
                let spreads = [
                    entry.number("sigma").map(Spread::Sigma),
                    entry.numbers::<2>("range").map(|[least, most]| Spread::Range(least, most)),
                    entry.number("share").map(Spread::Share),
                ];
                let mut given = spreads.into_iter().flatten();
                match (given.next(), given.next()) {
                    (Some(Spread::Range(least, most)), None) if least > most => {
                        self.wrong(
                            "C004",
                            entry.span_of("range"),
                            format!("`range` is [{least}, {most}]: the least comes first"),
                        );
                    }
                    (Some(spread), None) => self.scene.varies.push(Vary::Number {
                        key,
                        spread,
                        each: entry.flag("each"),
                    }),
                    _ if entry.is_spoilt(&["sigma", "range", "share"]) => {}
                    _ => self.wrong(
                        "C003",
                        entry.span.clone(),
                        format!("vary of `{key}`: write one of `sigma`, `range`, `share`"),
                    ),
                }
            }
            (None, Some(fault)) => {
                self.strikes(entry, &fault);
                if entry.number("chance") == Some(0.0) && fault != "slow" && fault != "late" {
                    self.problems.push(
                        Problem::warning(
                            "C003",
                            entry.span.clone(),
                            format!("fault {fault} never happens: its `chance` is 0"),
                        )
                        .hint("write `chance = 0.01`"),
                    );
                }
                self.scene.varies.push(Vary::Fault {
                    fault,
                    of: entry.text("of"),
                    chance: entry.number("chance").unwrap_or(0.0),
                    up_to_us: entry.number("up_to_ms").map(us),
                    steps: entry.number("steps").map(|steps| steps as i32),
                    within_us: entry.number("within_s").map(|seconds| us(seconds * 1000.0)),
                });
            }
            _ if entry.is_spoilt(&["key", "fault"]) => {}
            _ => self.wrong("C003", entry.span.clone(), "a vary has either `key` or `fault`"),
        }
    }
}

/// `; "belt" is meant?`, or what there is.
pub fn meant(name: &str, known: &[&str]) -> String {
    match nearest(name, known.iter().copied()) {
        Some(other) => format!("; \"{other}\" is meant?"),
        None if known.is_empty() => "; there is none".to_owned(),
        None => format!("; there is {}", known.join(", ")),
    }
}
