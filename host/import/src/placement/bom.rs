//! Bills of material: which part a reference is, and which are not fitted.

use csv::{ReaderBuilder, Trim};

use super::text::decode;
use crate::codes::Code;
use crate::diag::Diag;
use crate::script::clean;

/// A line of a bill.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// A reference.
    pub name: String,
    /// Its value, where the bill has one.
    pub value: String,
    /// Its package, where the bill has one.
    pub package: String,
    /// It is not fitted.
    pub out: bool,
    /// Line of the file.
    pub line: u32,
}

/// A bill.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Bom {
    /// Its references, one by one.
    pub entries: Vec<Entry>,
}

const NAMES: [&str; 4] = ["designator", "reference", "references", "ref"];
const VALUES: [&str; 4] = ["comment", "value", "designation", "val"];
const PACKAGES: [&str; 2] = ["footprint", "package"];
/// Longest range such as `R1-R4`.
const LONGEST: u32 = 1000;

/// Reads a bill: titles in any order, references as lists (`"R1,R2"`) and ranges (`R1-R4`).
///
/// # Errors
/// What is wrong, by line.
pub fn read(bytes: &[u8]) -> Result<Bom, Vec<Diag>> {
    let text = decode(bytes).map_err(|diag| vec![diag])?;
    let first = text.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
    let by =
        *b",;\t".iter().max_by_key(|by| first.matches(char::from(**by)).count()).unwrap_or(&b',');
    let mut reader = ReaderBuilder::new()
        .delimiter(by)
        .has_headers(false)
        .flexible(true)
        .trim(Trim::All)
        .from_reader(text.as_bytes());
    let mut bom = Bom::default();
    let mut plan: Option<[Option<usize>; 4]> = None;
    let mut diags = Vec::new();
    for record in reader.records().flatten() {
        let line = record.position().map_or(1, |at| u32::try_from(at.line()).unwrap_or(u32::MAX));
        let Some([name, value, package, out]) = plan else {
            let small: Vec<String> = record.iter().map(|text| text.to_lowercase()).collect();
            let find =
                |known: &[&str]| known.iter().find_map(|k| small.iter().position(|s| s == k));
            let Some(name) = find(&NAMES) else { continue };
            plan = Some([Some(name), find(&VALUES), find(&PACKAGES), find(&["dnp", "dnf"])]);
            continue;
        };
        let text = |at: Option<usize>| at.and_then(|at| record.get(at)).unwrap_or_default();
        let out = matches!(
            text(out).to_ascii_lowercase().as_str(),
            "dnp" | "dnf" | "x" | "1" | "true" | "yes"
        );
        for one in text(name).split([',', ' ', ';']).filter(|one| !one.is_empty()) {
            match range(one) {
                Ok(names) => bom.entries.extend(names.into_iter().map(|name| Entry {
                    name,
                    value: clean(text(value)),
                    package: clean(text(package)),
                    out,
                    line,
                })),
                Err(words) => diags.push(Diag::new(Code::Unreadable, line, 1, words)),
            }
        }
    }
    if plan.is_none() {
        let words = "no column of this bill of material is the reference";
        let hint = "a title line with Designator or Reference";
        diags.push(Diag::new(Code::Unreadable, 1, 1, words).hint(hint));
    }
    if diags.is_empty() { Ok(bom) } else { Err(diags) }
}

/// `R1`, or all of `R1-R4`.
fn range(text: &str) -> Result<Vec<String>, String> {
    let parted = |text: &str| {
        let at = text.find(|c: char| c.is_ascii_digit())?;
        Some((text[..at].to_owned(), text[at..].parse::<u32>().ok()?))
    };
    let Some((low, high)) = text.split_once('-') else { return Ok(vec![clean(text)]) };
    match (parted(low), parted(high)) {
        (Some((a, from)), Some((b, to))) if a == b && from <= to && to - from < LONGEST => {
            Ok((from..=to).map(|n| format!("{a}{n}")).collect())
        }
        _ => Err(format!("`{}` is no range of references", clean(text))),
    }
}
