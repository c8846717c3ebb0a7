//! Keys that only some words of a table read: `depth` is for the expectation holes. Where another word stands the key has
//! no effect, and gets a warning.

use super::{Builder, meant};
use crate::problem::Problem;
use crate::value::Entry;

/// A table, the key whose word decides, a key, and the words that read it.
type Row = (&'static str, &'static str, &'static str, &'static [&'static str]);

const EXPECT: &str = "expect";
const FEEDER: &str = "feeder";
const SENSOR: &str = "sensor";
const PERSON: &str = "person";
const VARY: &str = "vary";

const ADVANCE: &[&str] = &["tape", "tube", "bowl"];
const TIMED: &[&str] = &["pause", "stop", "estop", "door", "power", "gone", "stall"];

const ROWS: &[Row] = &[
    (EXPECT, "what", "within", &["in_place", "holes", "bead", "engraved", "no_drop"]),
    (EXPECT, "what", "place", &["in_place"]),
    (EXPECT, "what", "of", &["in_place", "order"]),
    (EXPECT, "what", "count", &["in_place", "beads", "prints"]),
    (EXPECT, "what", "turn_within_deg", &["in_place"]),
    (EXPECT, "what", "at", &["holes"]),
    (EXPECT, "what", "file", &["holes", "engraved"]),
    (EXPECT, "what", "depth", &["holes"]),
    (EXPECT, "what", "diameter", &["holes"]),
    (EXPECT, "what", "mg", &["beads"]),
    (EXPECT, "what", "mg_within", &["beads", "bead"]),
    (EXPECT, "what", "from", &["bead"]),
    (EXPECT, "what", "to", &["bead"]),
    (EXPECT, "what", "mg_mm", &["bead"]),
    (EXPECT, "what", "places", &["order"]),
    (EXPECT, "what", "below_s", &["time"]),
    (EXPECT, "what", "text", &["prints", "ends"]),
    (EXPECT, "what", "sensor", &["never"]),
    (FEEDER, "kind", "pitch", &["tray"]),
    (FEEDER, "kind", "count", &["tray"]),
    (FEEDER, "kind", "empty", &["tray", "list"]),
    (FEEDER, "kind", "turn_deg", &["tray", "tape", "tube", "bowl"]),
    (FEEDER, "kind", "output", ADVANCE),
    (FEEDER, "kind", "advance_ms", ADVANCE),
    (FEEDER, "kind", "length", ADVANCE),
    (FEEDER, "kind", "spread", &["bowl"]),
    (FEEDER, "kind", "spread_deg", &["bowl"]),
    (FEEDER, "kind", "file", &["list"]),
    (FEEDER, "kind", "offset", &["list"]),
    (SENSOR, "kind", "from", &["beam", "distance"]),
    (SENSOR, "kind", "to", &["beam", "distance"]),
    (SENSOR, "kind", "at", &["box", "colour"]),
    (SENSOR, "kind", "size", &["box"]),
    (SENSOR, "kind", "axis", &["switch"]),
    (SENSOR, "kind", "place", &["switch"]),
    (SENSOR, "kind", "side", &["switch"]),
    (SENSOR, "kind", "sees", &["beam", "box", "distance", "colour"]),
    (SENSOR, "kind", "colour", &["colour"]),
    (SENSOR, "kind", "volts", &["distance"]),
    (PERSON, "does", "hold_ms", &["start", "stop", "estop", "input"]),
    (PERSON, "does", "input", &["input"]),
    (PERSON, "does", "thing", &["take", "put"]),
    (PERSON, "does", "register", &["at"]),
    (PERSON, "does", "value", &["at"]),
    (
        VARY,
        "fault",
        "of",
        &[
            "missing", "stuck", "lost", "double", "turned", "slow", "bounce", "dead_on",
            "dead_off", "stall", "late",
        ],
    ),
    (
        VARY,
        "fault",
        "up_to_ms",
        &["stuck", "lost", "slow", "bounce", "late", "pause", "stop", "estop", "door"],
    ),
    (VARY, "fault", "steps", &["stall"]),
    (VARY, "fault", "within_s", TIMED),
];

impl Builder<'_> {
    /// A warning for each key that its table's word does not read.
    pub(super) fn only(&mut self, entry: &Entry) {
        let rows = ROWS.iter().filter(|row| row.0 == entry.section && entry.has(row.2));
        for (section, selector, key, words) in rows {
            let Some(word) = entry.text(selector).filter(|word| !words.contains(&word.as_str()))
            else {
                continue;
            };
            let text = format!("`{key}` has no effect: {section} {word} does not read it");
            let hint = format!("it is for {}", words.join(", "));
            let problem = Problem::warning("C016", entry.span_of(key), text);
            self.problems.push(problem.hint(hint));
        }
        if entry.section == VARY {
            self.number_or_fault(entry);
        }
    }

    /// Keys of a number in a row of a fault, and the other way round.
    fn number_or_fault(&mut self, entry: &Entry) {
        const NUMBER: &[&str] = &["sigma", "range", "share", "each"];
        const FAULT: &[&str] = &["of", "chance", "up_to_ms", "steps", "within_s"];
        let (keys, has, other) = match (entry.has("key"), entry.has("fault")) {
            (true, false) => (FAULT, "key", "fault"),
            (false, true) => (NUMBER, "fault", "key"),
            _ => return,
        };
        for key in keys.iter().filter(|key| entry.has(key)) {
            let text = format!("`{key}` has no effect beside `{has}`: it is for a `{other}`");
            let problem = Problem::warning("C016", entry.span_of(key), text);
            self.problems.push(problem.hint("leave it out"));
        }
    }

    /// Names of things and places in a person's table.
    pub(super) fn person_names(&mut self, entries: &[Entry]) {
        for entry in entries.iter().filter(|entry| entry.section == PERSON) {
            let scene = &self.scene;
            let who = entry.text("name").unwrap_or_else(|| "somebody".to_owned());
            let mut wrong = Vec::new();
            if let Some(thing) = entry.text("thing")
                && !super::strikes::is_thing(scene, &thing)
            {
                let single = scene.parts.iter().filter(|part| part.at.is_some());
                let mut known: Vec<String> = single.map(|part| part.name.clone()).collect();
                known.extend(scene.feeders.iter().map(|feeder| format!("{}.1", feeder.name)));
                known.extend(
                    scene
                        .conveyors
                        .iter()
                        .filter(|belt| belt.feeds.is_some())
                        .map(|belt| format!("{}.1", belt.name)),
                );
                let known: Vec<&str> = known.iter().map(String::as_str).collect();
                let text =
                    format!("person \"{who}\" names thing \"{thing}\"{}", meant(&thing, &known));
                wrong.push(("thing", text));
            }
            let when = entry.text("when").unwrap_or_default();
            if let Some(place) = when.strip_suffix(" full").filter(|_| !when.starts_with("print "))
            {
                let known: Vec<&str> =
                    scene.places.iter().map(|place| place.name.as_str()).collect();
                if !known.contains(&place) {
                    let text = format!(
                        "person \"{who}\" waits for place \"{place}\"{}",
                        meant(place, &known)
                    );
                    wrong.push(("when", text));
                }
            }
            for (key, text) in wrong {
                self.wrong("C011", entry.span_of(key), text);
            }
        }
    }
}
