//! host/profiles.md: keys are those that the reader of profiles knows, and each range, choice and
//! default is tried on the page's own example.

use std::collections::BTreeSet;

use lang::profile::Profile;
use toml::{Table, Value};

const PAGE: &str = include_str!("../../../host/profiles.md");

/// Heading and the place of its keys in a file.
const SECTIONS: [(&str, &str); 11] = [
    ("## The machine", ""),
    ("## An axis", "x"),
    ("## Start, Stop", "run"),
    ("## The serial link", "link"),
    ("## Inputs", "input"),
    ("## Outputs", "output"),
    ("## Analog", "analog"),
    ("## The analog output", "aout"),
    ("## Thresholds", "threshold"),
    ("## The PWM", "pwm"),
    ("## RS-485", "rs485"),
];
/// Keys of a section that hold sections of their own.
const INNER: [(&str, &[&str]); 2] = [
    (
        "",
        &[
            "x",
            "y",
            "z",
            "run",
            "link",
            "rs485",
            "pwm",
            "input",
            "output",
            "analog",
            "threshold",
            "aout",
        ],
    ),
    ("x", &["scale", "home"]),
];

#[derive(Clone, Debug)]
struct Row {
    section: &'static str,
    key: String,
    range: String,
    default: String,
}

impl Row {
    /// Names from the file's top to the value.
    fn path(&self) -> Vec<&str> {
        let section = (!self.section.is_empty()).then_some(self.section);
        section.into_iter().chain(self.key.split('.')).collect()
    }

    /// Names of what the example says that excludes this key, or bounds it.
    fn apart(&self) -> &'static [&'static [&'static str]] {
        match (self.section, self.last()) {
            ("aout", "frequency_hz") => &[&["pwm"]],
            ("aout", "full_mv") => &[&["aout", "safe"]],
            ("aout", "range") => &[&["aout", "safe"], &["aout", "full_mv"]],
            _ => &[],
        }
    }

    fn last(&self) -> &str {
        self.key.rsplit('.').next().unwrap_or_default()
    }

    /// The choices that the range names, as values.
    fn choices(&self) -> Vec<Value> {
        quoted(&self.range).iter().map(|text| value(text)).collect()
    }
}

fn value(text: &str) -> Value {
    let table: Table = format!("v = {text}").parse().expect("a value");
    table["v"].clone()
}

/// What stands in backticks.
fn quoted(text: &str) -> Vec<&str> {
    text.split('`').skip(1).step_by(2).collect()
}

/// Cells of the tables with so many columns, with their section.
fn cells(columns: usize) -> Vec<(&'static str, Vec<String>)> {
    let mut section = None;
    let mut found = Vec::new();
    for line in PAGE.lines() {
        if line.starts_with("## ") {
            section = SECTIONS.iter().find(|(head, _)| line.starts_with(head)).map(|(_, at)| *at);
        }
        let cells: Vec<String> = line.split('|').map(|cell| cell.trim().to_owned()).collect();
        if let Some(section) = section
            && line.starts_with("| `")
            && cells.len() == columns + 2
        {
            found.push((section, cells[1..=columns].to_vec()));
        }
    }
    found
}

fn rows() -> Vec<Row> {
    let row = |(section, cells): (&'static str, Vec<String>)| Row {
        section,
        key: cells[0].trim_matches('`').to_owned(),
        range: cells[2].clone(),
        default: cells[3].trim_matches('`').to_owned(),
    };
    let rows: Vec<Row> = cells(5).into_iter().map(row).collect();
    assert!(rows.len() > 40, "{} rows", rows.len());
    rows
}

/// The profile at the end of the page.
fn example() -> Table {
    let (_, rest) = PAGE.split_once("```toml\n").expect("an example");
    rest.split("```").next().expect("its end").parse().expect("TOML")
}

/// The table that holds the last name of `path`; of several inputs or outputs the first.
fn holder<'a>(table: &'a mut Table, path: &[&str]) -> &'a mut Table {
    let Some((first, rest)) = path.split_first() else { return table };
    if rest.is_empty() {
        return table;
    }
    match table.get_mut(*first) {
        Some(Value::Table(inner)) => holder(inner, rest),
        Some(Value::Array(list)) => match list.first_mut() {
            Some(Value::Table(inner)) => holder(inner, rest),
            _ => panic!("{first} is empty"),
        },
        _ => panic!("the example has no {first}"),
    }
}

fn parse(table: &Table) -> Result<Profile, String> {
    Profile::parse(&toml::to_string(table).expect("TOML")).map_err(|error| error.to_string())
}

/// The example with another value there, or without one.
fn changed(row: &Row, to: Option<Value>) -> Result<Profile, String> {
    let mut table = example();
    let own = holder(&mut table, &row.path());
    let Some(to) = to else {
        own.remove(row.last());
        return parse(&table);
    };
    own.insert(row.last().to_owned(), to);
    for path in row.apart() {
        let [.., last] = path else { continue };
        holder(&mut table, path).remove(*last);
    }
    parse(&table)
}

/// Names that the reader would have taken instead.
fn expected(error: &str) -> BTreeSet<&str> {
    let (_, list) = error.rsplit_once("expected").unwrap_or_else(|| panic!("{error}"));
    quoted(list).into_iter().collect()
}

#[test]
fn the_example_and_the_built_in_profiles_are_read() {
    parse(&example()).expect("the example");
    for (name, _) in lang::profile::BUILT_IN {
        assert!(PAGE.contains(name), "{name} is not named");
    }
}

#[test]
fn every_key_has_its_row_and_every_row_its_key() {
    let rows = rows();
    let keys = |section: &str, inner: &str| -> BTreeSet<String> {
        let prefix = if inner.is_empty() { String::new() } else { format!("{inner}.") };
        let own = rows.iter().filter(|row| row.section == section);
        let own = own.filter_map(|row| row.key.strip_prefix(&prefix));
        own.filter(|key| !key.contains('.')).map(str::to_owned).collect()
    };
    let nested = [("x", "scale"), ("x", "home")];
    let places = SECTIONS.iter().map(|(_, at)| (*at, "")).chain(nested);
    for (section, inner) in places {
        let path: Vec<&str> =
            [section, inner, "no_key"].into_iter().filter(|s| !s.is_empty()).collect();
        let mut table = example();
        holder(&mut table, &path).insert("no_key".to_owned(), Value::Integer(1));
        let error = parse(&table).expect_err("an unknown key");
        let mut known = expected(&error);
        for (_, names) in INNER.iter().filter(|(at, _)| inner.is_empty() && *at == section) {
            names.iter().for_each(|name| assert!(known.remove(name), "{name}"));
        }
        let known: BTreeSet<String> = known.into_iter().map(str::to_owned).collect();
        assert_eq!(keys(section, inner), known, "[{section}] {inner}");
    }
}

#[test]
fn ranges_end_where_the_page_says() {
    let mut tried = 0;
    for row in rows() {
        let Some((low, high)) = row.range.split_once("..") else { continue };
        let mut names = vec![row.last().to_owned()];
        let mut bound = |text: &str| {
            text.parse::<i64>().unwrap_or_else(|_| {
                names.push(text.rsplit('.').next().unwrap_or_default().to_owned());
                let other = Row { key: text.to_owned(), ..row.clone() };
                let mut table = example();
                let value = holder(&mut table, &other.path())[other.last()].clone();
                value.as_integer().expect("a number")
            })
        };
        let (low, high) = (bound(low), bound(high));
        for good in [low, high] {
            let read = changed(&row, Some(Value::Integer(good)));
            assert!(read.is_ok(), "{} = {good}: {read:?}", row.key);
        }
        for bad in [low - 1, high + 1] {
            let error = changed(&row, Some(Value::Integer(bad))).expect_err(&row.key);
            let named = names.iter().any(|name| error.contains(name.as_str()));
            assert!(named, "{} = {bad}: {error}", row.key);
        }
        tried += 1;
    }
    assert!(tried >= 20, "{tried} ranges");
}

#[test]
fn choices_are_all_there_are() {
    let mut tried = 0;
    for row in rows() {
        let choices = row.choices();
        let Some(first) = choices.first() else { continue };
        for choice in &choices {
            let read = changed(&row, Some(choice.clone()));
            // The later ones of the inputs that choose a program want those in front of them.
            let later = ("select_2"..="select_6").contains(&choice.as_str().unwrap_or_default());
            assert_eq!(read.is_ok(), !later, "{} = {choice}: {read:?}", row.key);
        }
        let wrong =
            if first.is_integer() { Value::Integer(12_345) } else { value("\"none of them\"") };
        let error = changed(&row, Some(wrong)).expect_err(&row.key);
        if !first.is_str() {
            assert!(error.contains(row.last()), "{error}");
            continue;
        }
        for name in expected(&error) {
            let choice = Value::String(name.to_owned());
            let read = changed(&row, Some(choice.clone()));
            assert!(choices.contains(&choice) || read.is_err(), "{} = {name} is not told", row.key);
        }
        tried += 1;
    }
    assert!(tried >= 9, "{tried} choices");
}

#[test]
fn defaults_hold_where_a_key_is_left_out() {
    for row in rows() {
        let read = changed(&row, None);
        if row.default.is_empty() {
            let error = read.expect_err(&row.key);
            assert!(error.contains(row.last()), "{}: {error}", row.key);
            continue;
        }
        let read = read.unwrap_or_else(|error| panic!("{}: {error}", row.key));
        let mut table = Table::try_from(&read).expect("a table");
        let got = holder(&mut table, &row.path()).get(row.last()).cloned();
        let wanted = (row.default != "none").then(|| value(&row.default));
        assert_eq!(got, wanted, "{}", row.key);
    }
}

#[test]
fn every_role_is_explained() {
    for section in ["input", "output"] {
        let explained: BTreeSet<String> = cells(2)
            .into_iter()
            .filter(|(at, _)| *at == section)
            .flat_map(|(_, cells)| {
                quoted(&cells[0]).iter().map(|s| s.to_string()).collect::<Vec<_>>()
            })
            .collect();
        let row = rows().into_iter().find(|row| row.section == section && row.key == "role");
        let roles = row.expect("a row").choices().into_iter();
        let roles: BTreeSet<String> =
            roles.filter_map(|role| role.as_str().map(str::to_owned)).collect();
        assert_eq!(explained, roles, "{section}");
    }
}
