//! Values of a cell file: how each kind is written, and a table with its checked values.

use super::keys::Kind;
use std::collections::BTreeMap;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeArray, DeValue};

/// A checked value.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A text, name, word or colour.
    Text(String),
    /// A flag.
    Flag(bool),
    /// A number, or the number of a port.
    Number(f64),
    /// Numbers: a point, a size, a range, a grid.
    Numbers(Vec<f64>),
    /// Texts.
    Texts(Vec<String>),
    /// Boxes as `[x, y, z, width, depth, height]`, or points as `[x, y]`.
    Rows(Vec<Vec<f64>>),
    /// An axis by its letter.
    Axis(char),
}

/// A table of the file with its checked values.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Name of the table.
    pub section: &'static str,
    /// Its word of `kind`, if its keys depend on it.
    pub variant: String,
    /// The table's bytes.
    pub span: Range<usize>,
    pub(super) values: BTreeMap<&'static str, (Value, Range<usize>)>,
    /// Keys of the file whose value is wrong, which has been told.
    pub(super) spoilt: Vec<&'static str>,
}

impl Entry {
    /// The value of a key and its bytes.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<&(Value, Range<usize>)> {
        self.values.get(key)
    }

    /// Moves all places by so many bytes: the text stands behind others.
    pub(super) fn shift(&mut self, by: usize) {
        let moved = |span: &Range<usize>| span.start + by..span.end + by;
        self.span = moved(&self.span);
        // A key that is left out has no place.
        for (_, span) in self.values.values_mut().filter(|(_, span)| !span.is_empty()) {
            *span = moved(span);
        }
    }

    /// Whether the file itself has the key.
    #[must_use]
    pub fn has(&self, key: &str) -> bool {
        self.values.get(key).is_some_and(|(_, span)| !span.is_empty())
    }

    /// Whether the key is neither there nor has a default. One with a wrong value is there.
    #[must_use]
    pub fn lacks(&self, key: &str) -> bool {
        self.get(key).is_none() && !self.is_spoilt(&[key])
    }

    /// Whether one of these keys is there with a wrong value.
    #[must_use]
    pub fn is_spoilt(&self, keys: &[&str]) -> bool {
        self.spoilt.iter().any(|key| keys.contains(key))
    }

    /// The bytes of a key's value; the table's where it is left out.
    #[must_use]
    pub fn span_of(&self, key: &str) -> Range<usize> {
        self.values
            .get(key)
            .map(|(_, span)| span.clone())
            .filter(|span| !span.is_empty())
            .unwrap_or(self.span.clone())
    }

    /// A number.
    #[must_use]
    pub fn number(&self, key: &str) -> Option<f64> {
        match self.values.get(key) {
            Some((Value::Number(number), _)) => Some(*number),
            _ => None,
        }
    }

    /// A text.
    #[must_use]
    pub fn text(&self, key: &str) -> Option<String> {
        match self.values.get(key) {
            Some((Value::Text(text), _)) => Some(text.clone()),
            _ => None,
        }
    }

    /// A flag; false when there is none.
    #[must_use]
    pub fn flag(&self, key: &str) -> bool {
        matches!(self.values.get(key), Some((Value::Flag(true), _)))
    }

    /// `N` numbers.
    #[must_use]
    pub fn numbers<const N: usize>(&self, key: &str) -> Option<[f64; N]> {
        match self.values.get(key) {
            Some((Value::Numbers(numbers), _)) => {
                numbers.get(..N).and_then(|first| first.try_into().ok())
            }
            _ => None,
        }
    }

    /// All numbers of a list.
    #[must_use]
    pub fn list(&self, key: &str) -> Vec<f64> {
        match self.values.get(key) {
            Some((Value::Numbers(numbers), _)) => numbers.clone(),
            _ => Vec::new(),
        }
    }

    /// A list of texts.
    #[must_use]
    pub fn texts(&self, key: &str) -> Vec<String> {
        match self.values.get(key) {
            Some((Value::Texts(texts), _)) => texts.clone(),
            _ => Vec::new(),
        }
    }

    /// Rows of numbers.
    #[must_use]
    pub fn rows(&self, key: &str) -> Vec<Vec<f64>> {
        match self.values.get(key) {
            Some((Value::Rows(rows), _)) => rows.clone(),
            _ => Vec::new(),
        }
    }

    /// The number of a port.
    #[must_use]
    pub fn port(&self, key: &str) -> Option<u32> {
        self.number(key).map(|number| number as u32)
    }

    /// An axis.
    #[must_use]
    pub fn axis(&self, key: &str) -> Option<char> {
        match self.values.get(key) {
            Some((Value::Axis(axis), _)) => Some(*axis),
            _ => None,
        }
    }
}

pub(super) fn form(kind: Kind) -> &'static str {
    match kind {
        Kind::Text | Kind::Name | Kind::Word(_) => "a text in quotes",
        Kind::Colour => "a colour as \"#rrggbb\"",
        Kind::Flag => "true or false",
        Kind::Number(..) => "a number",
        Kind::Count(..) => "a whole number",
        Kind::Point2 => "[x, y]",
        Kind::Point3 => "[x, y, z]",
        Kind::Start => "[x, y, z] or [x, y, z, a]",
        Kind::Size => "[width, depth, height]",
        Kind::Range => "[least, greatest]",
        Kind::Grid => "[columns, rows]",
        Kind::Numbers => "a list of numbers",
        Kind::Texts => "a list of texts",
        Kind::Points => "a list of [x, y]",
        Kind::Boxes => "a list of { at = [x, y, z], size = [w, d, h] }",
        Kind::Input | Kind::Output | Kind::Analog | Kind::Counter => "a number or a name",
        Kind::Axis => "the letter of an axis",
        Kind::Drive => "an output or the letter of an axis",
    }
}

pub(super) fn number(value: &DeValue<'_>) -> Result<f64, String> {
    let number = match value {
        DeValue::Integer(number) => {
            i64::from_str_radix(&number.as_str().replace('_', ""), number.radix())
                .ok()
                .map(|number| number as f64)
        }
        DeValue::Float(number) => number.as_str().replace('_', "").parse::<f64>().ok(),
        other => return Err(format!("is {}; it must be a number", other.type_str())),
    };
    number
        .filter(|number| number.is_finite() && number.abs() < 1e15)
        .ok_or_else(|| "is no number that can be used".to_owned())
}

pub(super) fn within(number: f64, least: f64, most: f64) -> Result<Value, String> {
    if (least..=most).contains(&number) {
        Ok(Value::Number(number))
    } else if most >= 1e15 {
        Err(format!("is {number}; it must be at least {least}"))
    } else {
        Err(format!("is {number}; it must lie between {least} and {most}"))
    }
}

pub(super) fn numbers(items: &DeArray<'_>, least: usize, most: usize) -> Result<Value, String> {
    let list =
        items.iter().map(|item| number(item.get_ref())).collect::<Result<Vec<f64>, String>>();
    let list = list.map_err(|_| "holds something else than numbers".to_owned())?;
    if (least..=most).contains(&list.len()) {
        Ok(Value::Numbers(list))
    } else if least == most {
        Err(format!("has {} numbers; it must have {least}", list.len()))
    } else {
        Err(format!("has {} numbers; it must have {least} to {most}", list.len()))
    }
}

pub(super) fn whole(value: Value, least: f64, most: f64) -> Result<Value, String> {
    if let Value::Numbers(list) = &value
        && let Some(number) =
            list.iter().find(|number| number.fract() != 0.0 || !(least..=most).contains(*number))
    {
        return Err(format!("has {number}; each must be a whole number from {least} to {most}"));
    }
    Ok(value)
}

pub(super) fn texts(items: &DeArray<'_>) -> Result<Value, String> {
    let list = items
        .iter()
        .map(|item| item.get_ref().as_str().map(str::to_owned))
        .collect::<Option<Vec<String>>>();
    list.map(Value::Texts).ok_or_else(|| "holds something else than texts".to_owned())
}

pub(super) fn rows(items: &DeArray<'_>, width: usize) -> Result<Value, String> {
    let row = |item: &Spanned<DeValue<'_>>| match item.get_ref() {
        DeValue::Array(row) => match numbers(row, width, width)? {
            Value::Numbers(row) => Ok(row),
            _ => Err("holds something else than points".to_owned()),
        },
        _ => Err("holds something else than points".to_owned()),
    };
    items.iter().map(row).collect::<Result<Vec<_>, String>>().map(Value::Rows)
}

pub(super) fn boxes(items: &DeArray<'_>) -> Result<Value, String> {
    let mut list = Vec::new();
    for item in items.iter() {
        let DeValue::Table(table) = item.get_ref() else {
            return Err(format!("is a list of {}", form(Kind::Boxes)));
        };
        if let Some((key, _)) =
            table.iter().find(|(key, _)| !matches!(key.get_ref().as_ref(), "at" | "size"))
        {
            return Err(format!(
                "has the unknown key `{}`: each box has `at` and `size`",
                key.get_ref()
            ));
        }
        let mut row = Vec::new();
        for key in ["at", "size"] {
            match table.get(key).map(|value| value.get_ref()) {
                Some(DeValue::Array(items)) => match numbers(items, 3, 3)? {
                    Value::Numbers(three) => row.extend(three),
                    _ => return Err(format!("has a box whose `{key}` is not three numbers")),
                },
                _ => return Err(format!("has a box without `{key}`")),
            }
        }
        if row[3..].iter().any(|&width| width <= 0.0) {
            return Err("has a box whose size is not above 0".to_owned());
        }
        list.push(row);
    }
    Ok(Value::Rows(list))
}

pub(super) fn name(text: &str) -> Result<Value, String> {
    if !text.is_empty()
        && text.chars().all(|letter| letter.is_ascii_alphanumeric() || "_- ".contains(letter))
    {
        Ok(Value::Text(text.to_owned()))
    } else {
        Err(format!("\"{text}\": a name has letters, digits, `_`, `-` and blanks"))
    }
}

pub(super) fn colour(text: &str) -> Result<Value, String> {
    let digits = text.strip_prefix('#').filter(|digits| {
        digits.len() == 6 && digits.chars().all(|digit| digit.is_ascii_hexdigit())
    });
    digits
        .map(|_| Value::Text(text.to_lowercase()))
        .ok_or_else(|| format!("\"{text}\" is no colour; write \"#rrggbb\""))
}
