//! What moves, sees and acts around the machine: conveyors, sensors, people.

use super::{Builder, us};
use crate::scene::{Block, Conveyor, Drive, Eye, Gap, Person, Sensor, When};
use crate::value::Entry;

impl Builder<'_> {
    pub(super) fn conveyor(&mut self, entry: &Entry) {
        let (Some(name), Some(at), Some(size)) =
            (entry.text("name"), entry.numbers::<3>("at"), entry.numbers::<3>("size"))
        else {
            return;
        };
        let drive = match (entry.axis("drive"), entry.port("drive")) {
            (Some(axis), _) => Drive::Axis(axis),
            (None, Some(output)) => Drive::Output(output),
            (None, None) => Drive::Always,
        };
        if !matches!(drive, Drive::Axis(_))
            && !entry.has("mm_s")
            && !entry.is_spoilt(&["drive", "mm_s"])
        {
            self.wrong(
                "C003",
                entry.span.clone(),
                format!("missing `mm_s` of conveyor \"{name}\""),
            );
        }
        let counter = match (entry.port("counter"), entry.number("counts_mm")) {
            (Some(counter), Some(counts)) => Some((counter, counts)),
            (Some(_), None) if entry.lacks("counts_mm") => {
                self.wrong(
                    "C003",
                    entry.span.clone(),
                    format!("missing `counts_mm` of conveyor \"{name}\", which has a `counter`"),
                );
                None
            }
            _ => None,
        };
        let feeds = if entry.has("feeds") {
            match (self.part_named(entry, "feeds"), entry.number("every_ms"), entry.number("gap")) {
                (Some(part), Some(ms), None) if ms > 0.0 => Some((part, Gap::Time(us(ms)))),
                (Some(part), None, Some(gap)) if gap > 0.0 => Some((part, Gap::Way(gap))),
                (Some(_), _, _) if !entry.is_spoilt(&["every_ms", "gap"]) => {
                    self.wrong("C003", entry.span.clone(), format!("conveyor \"{name}\" feeds parts: write either `every_ms` or `gap`, above 0"));
                    None
                }
                _ => None,
            }
        } else {
            None
        };
        if let Some((_, Gap::Time(every_us))) = feeds
            && every_us < 1000
        {
            self.wrong(
                "C004",
                entry.span_of("every_ms"),
                format!("`every_ms` of conveyor \"{name}\" must be 1 or more"),
            );
        }
        // More than a part in a millisecond is a slip, and a run that never comes to its end.
        if let (Some((_, Gap::Way(gap))), Some(speed)) = (feeds, entry.number("mm_s"))
            && gap * 1000.0 < speed
        {
            self.wrong(
                "C004",
                entry.span_of("gap"),
                format!("`gap` of conveyor \"{name}\" is {gap}: at {speed} mm/s it must be {} or more, a part each ms", speed / 1000.0),
            );
        }
        if let Some(speed) = entry.number("mm_s").filter(|speed| *speed <= 0.0) {
            self.wrong(
                "C004",
                entry.span_of("mm_s"),
                format!("`mm_s` of conveyor \"{name}\" is {speed}; it must be above 0: `along` is the direction"),
            );
        }
        let along = match entry.text("along").as_deref() {
            Some("y") => [0.0, 1.0],
            Some("-x") => [-1.0, 0.0],
            Some("-y") => [0.0, -1.0],
            _ => [1.0, 0.0],
        };
        self.scene.conveyors.push(Conveyor {
            name,
            block: Block::standing(at, size),
            along,
            drive,
            mm_s: entry.number("mm_s").unwrap_or(0.0),
            ramp_us: us(entry.number("ramp_ms").unwrap_or(0.0)),
            counter,
            feeds,
            takes: entry.text("takes"),
        });
    }

    pub(super) fn sensor(&mut self, entry: &Entry) {
        let (Some(name), Some(kind)) = (entry.text("name"), entry.text("kind")) else { return };
        let eye = match kind.as_str() {
            "beam" => {
                entry.numbers("from").zip(entry.numbers("to")).map(|(from, to)| Eye::Beam(from, to))
            }
            "box" => entry
                .numbers("at")
                .zip(entry.numbers("size"))
                .map(|(at, size)| Eye::Box(Block::standing(at, size))),
            "switch" => entry.axis("axis").zip(entry.number("place")).map(|(axis, place)| {
                Eye::Switch(axis, place, if entry.number("side") == Some(-1.0) { -1 } else { 1 })
            }),
            "distance" => entry.numbers("from").zip(entry.numbers("to")).map(|(from, to)| {
                Eye::Distance(from, to, entry.numbers("volts").unwrap_or_default())
            }),
            _ => entry
                .numbers("at")
                .zip(entry.text("colour"))
                .map(|(at, colour)| Eye::Colour(at, colour)),
        };
        let Some(eye) = eye else {
            let keys = match kind.as_str() {
                "beam" | "distance" => ["from", "to"],
                "box" => ["at", "size"],
                "switch" => ["axis", "place"],
                _ => ["at", "colour"],
            };
            let lacking = keys.iter().filter(|key| entry.lacks(key));
            let lacking: Vec<String> = lacking.map(|key| format!("`{key}`")).collect();
            if !lacking.is_empty() {
                self.wrong(
                    "C003",
                    entry.span.clone(),
                    format!("missing {} of sensor \"{name}\", a {kind}", lacking.join(" and ")),
                );
            }
            return;
        };
        let mut sees = [false; 3];
        for word in entry.texts("sees") {
            match ["part", "tool", "held"].iter().position(|known| *known == word) {
                Some(index) => sees[index] = true,
                None => self.wrong(
                    "C004",
                    entry.span_of("sees"),
                    format!("`sees` of sensor \"{name}\": \"{word}\" is none of part, tool, held"),
                ),
            }
        }
        self.scene.sensors.push(Sensor {
            name,
            eye,
            input: entry.port("input"),
            analog: entry.port("analog"),
            sees,
            on_us: us(entry.number("on_ms").unwrap_or(0.0)),
            off_us: us(entry.number("off_ms").unwrap_or(0.0)),
            bounce_us: us(entry.number("bounce_ms").unwrap_or(0.0)),
            invert: entry.flag("invert"),
        });
    }

    pub(super) fn person(&mut self, entry: &Entry) {
        let Some(does) = entry.text("does") else { return };
        let name = entry.text("name").unwrap_or_else(|| "somebody".to_owned());
        let when = match (entry.number("at_s"), entry.text("when")) {
            (Some(at), None) => Some(When::At(us(at * 1000.0))),
            (None, Some(when)) if when == "wait_start" => Some(When::WaitStart),
            (None, Some(when)) => match (when.strip_prefix("print "), when.strip_suffix(" full")) {
                (Some(text), _) => Some(When::Print(text.to_owned())),
                (None, Some(place)) => Some(When::Full(place.to_owned())),
                (None, None) => {
                    let text = format!(
                        "`when` of person \"{name}\" is \"{when}\"; write wait_start, PLACE full, or print TEXT"
                    );
                    self.wrong("C004", entry.span_of("when"), text);
                    None
                }
            },
            (Some(_), Some(_)) => {
                self.wrong(
                    "C004",
                    entry.span_of("when"),
                    format!("person \"{name}\" has `at_s` and `when`: keep one"),
                );
                None
            }
            (None, None) if entry.lacks("at_s") && entry.lacks("when") => {
                self.wrong(
                    "C003",
                    entry.span.clone(),
                    format!("missing `at_s` or `when` of person \"{name}\""),
                );
                None
            }
            (None, None) => None,
        };
        for (deed, key) in
            [("input", "input"), ("take", "thing"), ("put", "thing"), ("at", "register")]
        {
            if does == deed && entry.lacks(key) {
                self.wrong(
                    "C003",
                    entry.span.clone(),
                    format!("missing `{key}` of person \"{name}\", who does {deed}"),
                );
            }
        }
        let Some(when) = when else { return };
        self.scene.persons.push(Person {
            name,
            does,
            when,
            after_us: us(entry.number("after_s").unwrap_or(0.0) * 1000.0),
            hold_us: us(entry.number("hold_ms").unwrap_or(0.0)),
            input: entry.port("input"),
            thing: entry.text("thing"),
            register: entry.port("register"),
            value: entry.number("value").unwrap_or(0.0) as i32,
            times: entry.number("times").unwrap_or(1.0) as u32,
        });
    }
}
