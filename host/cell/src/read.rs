//! Reads the tables of a cell file by the table of keys: each value is of its kind and within its bounds, or there
//! is a problem with its place.

use super::keys::{self, Kind};
use super::problem::{Problem, nearest};
use super::value::{
    Entry, Value, boxes, colour, form, name, number, numbers, rows, texts, whole, within,
};
use std::collections::BTreeMap;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// What the profile and the script call by a name. A name that neither knows is an error in the cell.
pub trait Names {
    /// Number of an input.
    fn input(&self, name: &str) -> Option<u32>;
    /// Number of an output.
    fn output(&self, name: &str) -> Option<u32>;
    /// Number of an analog input.
    fn analog(&self, name: &str) -> Option<u32>;
    /// Number of a counter.
    fn counter(&self, name: &str) -> Option<u32>;
    /// All names of a kind of port, for messages.
    fn known(&self, port: Port) -> Vec<String>;
    /// Name of the profile, for messages.
    fn profile(&self) -> &str;
    /// Whether the chip has analog inputs.
    fn has_analog(&self) -> bool;
    /// Whether the machine has the port of this number. Inputs and outputs are all that the wiring has.
    fn has(&self, port: Port, n: u32) -> bool;
    /// Letters of the axes that the machine has.
    fn axes(&self) -> &str;
    /// Number of the input or output to which the profile gives this role: `door`, `probe`, `spindle`, `laser`. Of a
    /// profile without roles there is none.
    fn with_role(&self, _port: Port, _role: &str) -> Option<u32> {
        None
    }
}

/// A kind of port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Port {
    /// A digital input.
    Input,
    /// A digital output.
    Output,
    /// An analog input.
    Analog,
    /// A counter.
    Counter,
}

impl Port {
    /// The word in messages.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Input => "input",
            Self::Output => "output",
            Self::Analog => "analog input",
            Self::Counter => "counter",
        }
    }

    fn find(self, names: &dyn Names, name: &str) -> Option<u32> {
        match self {
            Self::Input => names.input(name),
            Self::Output => names.output(name),
            Self::Analog => names.analog(name),
            Self::Counter => names.counter(name),
        }
    }
}

/// All tables of a file: the top first.
///
/// Problems are added to `problems`; a table with one is read as far as it goes.
pub fn tables(text: &str, names: &dyn Names, problems: &mut Vec<Problem>) -> Vec<Entry> {
    let (document, errors) = DeTable::parse_recoverable(text);
    if let Some(error) = errors.first() {
        let span = error.span().unwrap_or(0..0);
        let reason = error.message().replace('\n', " ");
        problems.push(Problem::error("C001", span, format!("this is not TOML: {reason}")));
        return Vec::new();
    }
    let document = document.get_ref();
    let mut reader = Reader { names, problems };
    let mut entries = vec![reader.top(document)];
    for (section, list) in keys::tables() {
        let Some(value) = document.get(section) else { continue };
        match (value.get_ref(), list) {
            (DeValue::Table(table), false) => {
                entries.push(reader.entry(section, table, value.span()))
            }
            (DeValue::Array(items), true) => {
                for item in items.iter() {
                    match item.get_ref() {
                        DeValue::Table(table) => {
                            entries.push(reader.entry(section, table, item.span()))
                        }
                        other => reader.wrong(
                            "C004",
                            item.span(),
                            format!("`{section}` is a list of tables, not of {}", other.type_str()),
                        ),
                    }
                }
            }
            (DeValue::Table(_), true) => reader.hint(
                Problem::error("C004", value.span(), format!("`{section}` is a list")),
                format!("write `[[{section}]]`"),
            ),
            (other, _) => reader.wrong(
                "C004",
                value.span(),
                format!("`{section}` is a table, not {}", other.type_str()),
            ),
        }
    }
    entries
}

struct Reader<'a> {
    names: &'a dyn Names,
    problems: &'a mut Vec<Problem>,
}

impl Reader<'_> {
    fn wrong(&mut self, code: &'static str, span: Range<usize>, text: impl Into<String>) {
        self.problems.push(Problem::error(code, span, text));
    }

    fn hint(&mut self, problem: Problem, hint: impl Into<String>) {
        self.problems.push(problem.hint(hint));
    }

    fn top(&mut self, document: &DeTable<'_>) -> Entry {
        let mut entry = Entry {
            section: "",
            variant: String::new(),
            span: 0..0,
            values: BTreeMap::new(),
            spoilt: Vec::new(),
        };
        let sections: Vec<&str> = keys::tables().map(|(name, _)| name).collect();
        self.fill(&mut entry, document, &sections);
        entry
    }

    fn entry(&mut self, section: &'static str, table: &DeTable<'_>, span: Range<usize>) -> Entry {
        // Only a tool's keys depend on its kind.
        let variant = match table.get("kind").map(|kind| kind.get_ref()) {
            Some(DeValue::String(kind)) if section == "tool" => kind.to_string(),
            _ => String::new(),
        };
        let (values, spoilt) = (BTreeMap::new(), Vec::new());
        let mut entry = Entry { section, variant, span, values, spoilt };
        self.fill(&mut entry, table, &[]);
        entry
    }

    /// Checks each key of a table, and adds what is left out.
    fn fill(&mut self, entry: &mut Entry, table: &DeTable<'_>, besides: &[&str]) {
        let known: Vec<&keys::Key> = keys::keys_of(entry.section, &entry.variant).collect();
        for (name, _) in table.iter() {
            let word = name.get_ref().as_ref();
            if besides.contains(&word) || known.iter().any(|key| key.name == word) {
                continue;
            }
            let all = known.iter().map(|key| key.name).chain(besides.iter().copied());
            let meant = nearest(word, all.clone())
                .map(|meant| format!("; `{meant}` is meant?"))
                .unwrap_or_default();
            let place = match (entry.section, entry.variant.as_str()) {
                ("", _) => "a cell".to_owned(),
                (section, "") => format!("[{section}]"),
                (section, variant) => format!("[{section}] of kind {variant}"),
            };
            let problem =
                Problem::error("C002", name.span(), format!("unknown key `{word}`{meant}"));
            self.hint(problem, format!("{place} has {}", all.collect::<Vec<_>>().join(", ")));
        }
        for key in known {
            match table.get(key.name) {
                Some(value) => match self.value(entry.section, key, value) {
                    Some(checked) => {
                        entry.values.insert(key.name, (checked, value.span()));
                    }
                    None => entry.spoilt.push(key.name),
                },
                None if key.default == "must" => {
                    let title = title(entry.section, table);
                    self.wrong(
                        "C003",
                        entry.span.clone(),
                        format!("missing `{}` of {title}", key.name),
                    );
                }
                None if key.default == "none" => {}
                None => {
                    if let Ok(value) = DeValue::parse(key.default)
                        && let Some(checked) = self.value(entry.section, key, &value)
                    {
                        entry.values.insert(key.name, (checked, 0..0));
                    }
                }
            }
        }
    }

    /// A value of its kind, or a problem and nothing.
    fn value(
        &mut self,
        section: &str,
        key: &keys::Key,
        value: &Spanned<DeValue<'_>>,
    ) -> Option<Value> {
        let span = value.span();
        let result = match (key.kind, value.get_ref()) {
            (Kind::Text, DeValue::String(text)) => Ok(Value::Text(text.to_string())),
            (Kind::Name, DeValue::String(text)) => name(text),
            (Kind::Colour, DeValue::String(text)) => colour(text),
            (Kind::Word(words), DeValue::String(text)) => {
                match words.iter().find(|word| *word == text) {
                    Some(word) => Ok(Value::Text((*word).to_owned())),
                    None => {
                        let meant = nearest(text, words.iter().copied())
                            .map(|meant| format!("; \"{meant}\" is meant?"));
                        Err(format!(
                            "\"{text}\" is none of {}{}",
                            words.join(", "),
                            meant.unwrap_or_default()
                        ))
                    }
                }
            }
            (Kind::Flag, DeValue::Boolean(flag)) => Ok(Value::Flag(*flag)),
            (Kind::Number(least, most), other) => {
                number(other).and_then(|number| within(number, least, most))
            }
            (Kind::Count(least, most), other) => number(other).and_then(|number| {
                if number.fract() == 0.0 {
                    within(number, least as f64, most as f64)
                } else {
                    Err(format!("is {number}; it must be a whole number"))
                }
            }),
            (Kind::Point2 | Kind::Range, DeValue::Array(items)) => numbers(items, 2, 2),
            (Kind::Point3, DeValue::Array(items)) => numbers(items, 3, 3),
            (Kind::Start, DeValue::Array(items)) => numbers(items, 3, 4),
            (Kind::Size, DeValue::Array(items)) => {
                numbers(items, 3, 3).and_then(|size| self.size(size, span.clone()))
            }
            (Kind::Grid, DeValue::Array(items)) => {
                numbers(items, 2, 2).and_then(|grid| whole(grid, 1.0, 1000.0))
            }
            (Kind::Numbers, DeValue::Array(items)) => {
                numbers(items, 0, 100_000).and_then(|list| whole(list, 1.0, 1e9))
            }
            (Kind::Texts, DeValue::Array(items)) => texts(items),
            (Kind::Points, DeValue::Array(items)) => rows(items, 2),
            (Kind::Boxes, DeValue::Array(items)) => boxes(items),
            (Kind::Input, other) => return self.port(Port::Input, other, span),
            (Kind::Output, other) => return self.port(Port::Output, other, span),
            (Kind::Analog, other) => return self.port(Port::Analog, other, span),
            (Kind::Counter, other) => return self.port(Port::Counter, other, span),
            (Kind::Axis, DeValue::String(text)) => self.axis(text),
            (Kind::Drive, DeValue::String(text)) if text.len() == 1 => self.axis(text),
            (Kind::Drive, other) => return self.port(Port::Output, other, span),
            (kind, other) => Err(format!("is {}; it must be {}", other.type_str(), form(kind))),
        };
        match result {
            Ok(value) => Some(value),
            Err(reason) => {
                let place =
                    if section.is_empty() { String::new() } else { format!(" of [{section}]") };
                let joined = if reason.starts_with('"') { ": " } else { " " };
                self.wrong("C004", span, format!("`{}`{place}{joined}{reason}", key.name));
                None
            }
        }
    }

    fn size(&mut self, size: Value, span: Range<usize>) -> Result<Value, String> {
        if let Value::Numbers(numbers) = &size {
            if let Some(number) = numbers.iter().find(|&&number| number <= 0.0) {
                return Err(format!("has {number}; each must be above 0"));
            }
            if let Some(number) = numbers.iter().find(|&&number| !(0.05..=3000.0).contains(&number))
            {
                let problem = Problem::warning("C004", span, format!("a size of {number}: mm?"));
                self.hint(problem, "sizes are full widths in mm");
            }
        }
        Ok(size)
    }

    fn axis(&self, text: &str) -> Result<Value, String> {
        let letter = text.to_ascii_uppercase();
        match letter.chars().next() {
            Some(axis) if letter.len() == 1 && self.names.axes().contains(axis) => {
                Ok(Value::Axis(axis))
            }
            _ => Err(format!(
                "\"{text}\" is no axis of the profile \"{}\"; it has {}",
                self.names.profile(),
                self.names.axes()
            )),
        }
    }

    fn port(&mut self, port: Port, value: &DeValue<'_>, span: Range<usize>) -> Option<Value> {
        if port == Port::Analog && !self.names.has_analog() {
            self.wrong("C014", span, "analog inputs need part f5529");
            return None;
        }
        if port == Port::Counter && (1..100).all(|n| !self.names.has(port, n)) {
            let problem = Problem::error("C014", span, "no part has counters yet");
            self.hint(
                problem,
                "leave `counter` and `counts_mm` out; a sensor on an input sees each part",
            );
            return None;
        }
        match value {
            DeValue::String(name) => {
                if let Some(number) = port.find(self.names, name) {
                    return Some(Value::Number(f64::from(number)));
                }
                let known = self.names.known(port);
                let word = port.word();
                let has = if known.is_empty() {
                    format!("no named {word}s")
                } else {
                    format!("{word}s {}", known.join(", "))
                };
                let text = format!(
                    "{word} \"{name}\": the profile \"{}\" has {has}; or a number",
                    self.names.profile()
                );
                let mut problem = Problem::error("C006", span, text);
                if let Some(meant) = nearest(name, known.iter().map(String::as_str)) {
                    problem = problem.hint(format!("\"{meant}\" is meant?"));
                }
                self.problems.push(problem);
                None
            }
            other => match number(other).and_then(|number| {
                if number.fract() == 0.0 {
                    within(number, 1.0, 99.0)
                } else {
                    Err("is no whole number".to_owned())
                }
            }) {
                Ok(Value::Number(n)) if port == Port::Analog && !self.names.has(port, n as u32) => {
                    let profile = self.names.profile();
                    let text = format!("the profile \"{profile}\" has no analog input {n}");
                    let hint = format!(
                        "write `[[analog]]` with `n = {n}` into the profile; it may be 1 to 4"
                    );
                    self.hint(Problem::error("C006", span, text), hint);
                    None
                }
                Ok(value) => Some(value),
                Err(reason) => {
                    self.wrong(
                        "C006",
                        span,
                        format!("{} {reason}: a number from 1, or a name", port.word()),
                    );
                    None
                }
            },
        }
    }
}

/// How a table is called in messages.
fn title(section: &str, table: &DeTable<'_>) -> String {
    match table.get("name").map(|name| name.get_ref()) {
        Some(DeValue::String(name)) => format!("{section} \"{name}\""),
        _ if section.is_empty() => "the cell".to_owned(),
        _ => format!("a [[{section}]]"),
    }
}
