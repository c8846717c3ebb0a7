//! Finds the columns and reads the rows.

use csv::{ReaderBuilder, StringRecord, Trim};
use lang::front::literal::Decimal;

use super::{List, MAX_UM, MOST_PARTS, Part, Side, Unit};
use crate::codes::Code;
use crate::diag::Diag;
use crate::script::clean;

/// Lines that may stand above the titles.
const LOOK: usize = 60;
/// Longest name, value or package that is kept.
const LONGEST: usize = 60;
/// Diagnostics that are kept.
const MOST_DIAGS: usize = 50;

/// What a column is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    Name,
    Value,
    Package,
    X,
    Y,
    Turn,
    Side,
}

/// Titles, in small letters with blanks for `_`, `-` and points. Of two that fit, the earlier one here is
/// taken: a part's middle before the place of its first pad.
const TITLES: [(Column, &[&str]); 7] = [
    (Column::Name, &["ref", "designator", "refdes", "part id", "reference", "component"]),
    (Column::Value, &["val", "value", "comment", "device", "designation"]),
    (Column::Package, &["package", "footprint", "pattern"]),
    (Column::X, &["posx", "mid x", "center x", "x", "ref x", "pos x", "x pos"]),
    (Column::Y, &["posy", "mid y", "center y", "y", "ref y", "pos y", "y pos"]),
    (Column::Turn, &["rot", "rotation", "rotate", "angle"]),
    (Column::Side, &["side", "layer", "tb"]),
];

/// A unit as um, a fraction.
type Scale = (u32, u32);
const MM: Scale = (1000, 1);
const INCH: Scale = (25_400, 1);

/// Which system's file it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum System {
    /// KiCad's columns with blanks.
    Positions,
    /// Eagle's lines without titles; the side is the file's.
    Eagle(Side),
    /// A table with titles, parted by this.
    Table(u8),
}

/// The system of a file, if it is a placement file.
pub fn system(name: &str, text: &str) -> Option<System> {
    let head = |line: &str| line.starts_with("# Ref") && line.contains("PosX");
    if text.lines().take(LOOK).any(head) {
        return Some(System::Positions);
    }
    let ending = name.rsplit('.').next().unwrap_or_default().to_ascii_lowercase();
    if ending == "mnt" || ending == "mnb" {
        let side = if ending == "mnt" { Side::Top } else { Side::Bottom };
        return Some(System::Eagle(side));
    }
    text.lines().take(LOOK).find_map(|line| {
        b",;\t".iter().find(|by| titles(&record(line, **by)).is_some()).map(|by| System::Table(*by))
    })
}

fn record(line: &str, by: u8) -> StringRecord {
    let mut reader = ReaderBuilder::new()
        .delimiter(by)
        .has_headers(false)
        .flexible(true)
        .trim(Trim::All)
        .from_reader(line.as_bytes());
    reader.records().next().and_then(Result::ok).unwrap_or_default()
}

/// Where the columns are.
#[derive(Clone, Debug, Default)]
struct Plan {
    columns: [Option<usize>; 7],
    scale: Option<Scale>,
    left_out: Vec<String>,
}

impl Plan {
    fn of(&self, column: Column) -> Option<usize> {
        self.columns[column as usize]
    }
}

fn title(text: &str) -> String {
    let name = text.split(['(', '[']).next().unwrap_or_default();
    let name = name.to_lowercase().replace(['_', '-', '.', '#'], " ");
    name.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A title line names a reference, X and Y, and an angle or a side.
fn titles(record: &StringRecord) -> Option<Plan> {
    let names: Vec<String> = record.iter().map(title).collect();
    let mut plan = Plan::default();
    for (column, known) in TITLES {
        let found = known.iter().find_map(|one| names.iter().position(|name| name == one));
        plan.columns[column as usize] = found;
    }
    let (x, _) = (plan.of(Column::X)?, plan.of(Column::Y)?);
    plan.of(Column::Name)?;
    plan.of(Column::Turn).or(plan.of(Column::Side))?;
    let own = record.get(x).and_then(|text| text.split(['(', '[']).nth(1));
    plan.scale = own.and_then(|unit| scale(unit.trim_end_matches([')', ']'])));
    for (at, text) in record.iter().enumerate() {
        if !plan.columns.contains(&Some(at)) && !text.is_empty() {
            plan.left_out.push(clean(text).chars().take(LONGEST).collect());
        }
    }
    Some(plan)
}

fn scale(unit: &str) -> Option<Scale> {
    Some(match unit.trim().to_ascii_lowercase().as_str() {
        "mm" => MM,
        "in" | "inch" | "inches" | "\"" => INCH,
        "mil" | "mils" | "thou" => (254, 10),
        "um" => (1, 1),
        _ => return None,
    })
}

/// The unit that a head tells: `## Unit = mm`, `Units used: mil`, `Units: thou`.
fn told(line: &str) -> Option<Scale> {
    let small = line.to_ascii_lowercase();
    let rest = small.trim_start_matches(['#', ' ', '"']).strip_prefix("unit")?;
    let (_, unit) = rest.split_once(['=', ':'])?;
    scale(unit.split([',', '"']).next()?)
}

struct Reader {
    list: List,
    diags: Vec<Diag>,
    /// The unit of lengths without one.
    scale: Scale,
    /// A length has told its own unit, another one has not.
    own: Option<(Scale, u32)>,
    bare: Option<u32>,
}

/// Reads a file; its diagnostics come with it.
pub fn read(name: &str, text: &str, unit: Option<Unit>) -> (List, Vec<Diag>) {
    let list = List { what: "a table", parts: Vec::new(), left_out: Vec::new(), notes: Vec::new() };
    let usual = match unit {
        Some(Unit::Inch) => INCH,
        _ => MM,
    };
    let mut reader = Reader { list, diags: Vec::new(), scale: usual, own: None, bare: None };
    match system(name, text) {
        None => {
            let words = "no line of this file names a reference, X, Y and a rotation";
            let hint = "a title line such as `Designator,Val,Package,Mid X,Mid Y,Rotation,Layer`";
            reader.diags.push(Diag::new(Code::Unreadable, 1, 1, words).hint(hint));
        }
        Some(System::Positions) => reader.positions(text),
        Some(System::Eagle(side)) => reader.eagle(text, side),
        Some(System::Table(by)) => reader.table(text, by, unit),
    }
    reader.check(text, unit);
    (reader.list, reader.diags)
}

impl Reader {
    fn wrong(&mut self, line: u32, words: impl Into<String>, hint: &str) {
        if self.diags.len() < MOST_DIAGS {
            self.diags.push(Diag::new(Code::Unreadable, line, 1, words).hint(hint));
        }
    }

    /// KiCad's columns. A value may have blanks in it: the last five words are read from the right.
    fn positions(&mut self, text: &str) {
        self.list.what = "KiCad's positions";
        for (number, line) in (1..).zip(text.lines()) {
            if let Some(unit) = told(line) {
                self.scale = unit;
            }
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let words: Vec<&str> = line.split_whitespace().collect();
            let [name, between @ .., package, x, y, turn, side] = &words[..] else {
                let hint = "a line has a reference, value, package, X, Y, rotation and side";
                self.wrong(number, "this is no line of KiCad's positions", hint);
                continue;
            };
            let value = between.join(" ");
            self.part(number, [name, &value, package], [x, y], Some(turn), Some(side), false);
        }
        self.bare = None;
    }

    /// Eagle: `name x y rotation value package`, mm; the value may be missing.
    fn eagle(&mut self, text: &str, side: Side) {
        self.list.what = "Eagle's list";
        let side = if side == Side::Top { "top" } else { "bottom" };
        for (number, line) in (1..).zip(text.lines()) {
            let words: Vec<&str> = line.split_whitespace().collect();
            let (name, x, y, turn, value, package) = match words[..] {
                [] => continue,
                [name, x, y, turn, package] => (name, x, y, turn, "", package),
                [name, x, y, turn, value, package] => (name, x, y, turn, value, package),
                _ => {
                    let hint = "a line has a name, X, Y, rotation, value and package";
                    self.wrong(number, "this is no line of Eagle's list", hint);
                    continue;
                }
            };
            self.part(number, [name, value, package], [x, y], Some(turn), Some(side), false);
        }
        self.bare = None;
    }

    fn table(&mut self, text: &str, by: u8, unit: Option<Unit>) {
        let mut plan: Option<Plan> = None;
        let mut head_told = false;
        let mut ahead = 0;
        for line in text.lines() {
            ahead += 1;
            if let Some(found) = titles(&record(line, by)) {
                plan = Some(found);
                break;
            }
            if let Some(found) = told(line) {
                (self.scale, head_told) = (found, true);
            }
            if line.contains("Altium") {
                self.list.what = "Altium's list";
            } else if line.contains("PROTEUS") {
                self.list.what = "Proteus' list";
            }
        }
        let Some(plan) = plan else { return };
        if let Some(found) = plan.scale {
            (self.scale, head_told) = (found, true);
        }
        self.list.left_out.clone_from(&plan.left_out);
        let body: String = text.lines().skip(ahead).flat_map(|line| [line, "\n"]).collect();
        let mut reader = ReaderBuilder::new()
            .delimiter(by)
            .has_headers(false)
            .flexible(true)
            .trim(Trim::All)
            .from_reader(body.as_bytes());
        for record in reader.records() {
            let Ok(record) = record else {
                self.wrong(1, "a line of this table cannot be read", "export it as UTF-8 text");
                return;
            };
            let own = record.position().map_or(1, csv::Position::line);
            let number = u32::try_from(own + ahead as u64).unwrap_or(u32::MAX);
            if record.iter().all(str::is_empty) {
                continue;
            }
            let get = |column| plan.of(column).map(|at| record.get(at).unwrap_or_default());
            let text = |column| get(column).unwrap_or_default();
            let names = [text(Column::Name), text(Column::Value), text(Column::Package)];
            let place = [text(Column::X), text(Column::Y)];
            self.part(number, names, place, get(Column::Turn), get(Column::Side), by != b',');
        }
        if head_told || unit.is_some() {
            self.bare = None;
        }
        if plan.of(Column::Turn).is_none() {
            let words = "no column is the rotation: parts are not turned";
            self.diags.push(Diag::new(Code::LeftOut, ahead as u32, 1, words).warning());
        }
        if plan.of(Column::Side).is_none() {
            let words = "no column is the side: all parts are taken to lie on the top";
            self.diags.push(Diag::new(Code::Said, ahead as u32, 1, words).note());
        }
    }

    fn part(
        &mut self,
        line: u32,
        [name, value, package]: [&str; 3],
        place: [&str; 2],
        turn: Option<&str>,
        side: Option<&str>,
        comma: bool,
    ) {
        if self.list.parts.len() >= MOST_PARTS {
            if self.list.parts.len() == MOST_PARTS {
                let words = format!("more than {MOST_PARTS} parts");
                self.wrong(line, words, "place the board in pieces, by --only");
            }
            return;
        }
        let mut at = [0; 2];
        for (um, text) in at.iter_mut().zip(place) {
            match self.length(line, text, comma) {
                Ok(found) => *um = found,
                Err(words) => {
                    let hint = "lengths are numbers, with or without a unit: 12.7, 12.7mm, 500mil";
                    return self.wrong(line, format!("{name}: {words}"), hint);
                }
            }
        }
        let turned = match turn.map(|text| angle(text, comma)) {
            None => None,
            Some(Some(found)) => Some(found),
            Some(None) => {
                let shown = clean(turn.unwrap_or_default());
                let words = format!("{name}: its rotation is `{shown}`");
                return self.wrong(line, words, "an angle in degrees: 0, 90, -45.5");
            }
        };
        let side = match side.map(|text| text.to_ascii_lowercase()).as_deref() {
            None | Some("top" | "t" | "f.cu" | "toplayer" | "front") => Side::Top,
            Some("bottom" | "b" | "b.cu" | "bottomlayer" | "back") => Side::Bottom,
            Some(other) => {
                let words = format!("{name}: its side is `{}`", clean(other));
                return self.wrong(line, words, "a side is top or bottom");
            }
        };
        let name = short(name);
        if name.is_empty() {
            return self.wrong(line, "a part without a reference", "name it in the CAD program");
        }
        let part =
            Part { name, value: short(value), package: short(package), at, turned, side, line };
        self.list.parts.push(part);
    }

    /// A length in um.
    fn length(&mut self, line: u32, text: &str, comma: bool) -> Result<i64, String> {
        let text = text.trim();
        let end = text.find(|c: char| !c.is_ascii_digit() && !"+-.,".contains(c));
        let (digits, suffix) = text.split_at(end.unwrap_or(text.len()));
        let no = || format!("`{}` is no length", clean(text));
        let own = match suffix.trim() {
            "" => {
                self.bare.get_or_insert(line);
                self.scale
            }
            suffix => {
                let own = scale(suffix).ok_or_else(no)?;
                if let Some((before, _)) = self.own
                    && before != own
                {
                    return Err("its unit is not that of the lines before".to_owned());
                }
                self.own.get_or_insert((own, line));
                own
            }
        };
        let digits =
            if comma && !digits.contains('.') { digits.replace(',', ".") } else { digits.into() };
        match Decimal::parse(&digits).and_then(|value| value.scaled(own.0, own.1)) {
            Some((um, _)) if um.abs() <= MAX_UM => Ok(um),
            Some(_) => Err(format!("`{}` lies beyond 10 m", clean(text))),
            None => Err(no()),
        }
    }

    /// What holds for the whole file.
    fn check(&mut self, text: &str, unit: Option<Unit>) {
        if let (Some((_, with)), Some(without)) = (self.own, self.bare) {
            let words = format!("line {with} names its unit, this one does not");
            self.wrong(without, words, "one unit for all lengths; --unit says which, if need be");
            return;
        }
        if let (Some(line), None) = (self.bare, unit) {
            let most = self.list.parts.iter().map(|part| part.at[0].abs()).max().unwrap_or(0);
            let words = format!(
                "the file does not say its unit; X goes to {:.1}: mm is taken",
                most as f64 / 1000.0
            );
            let diag = Diag::new(Code::Said, line, 1, words).note();
            self.diags.push(diag.hint("--unit mm, or --unit in, says which"));
        }
        let mut seen = std::collections::BTreeMap::new();
        let mut twice = Vec::new();
        for part in &self.list.parts {
            if let Some(before) = seen.insert(part.name.clone(), part.line) {
                twice.push((part.line, format!("{} is in line {before}, too", part.name)));
            }
        }
        for (line, words) in twice {
            self.wrong(line, words, "each reference once: export one variant, one panel piece");
        }
        let cut = text.contains("## Unit") && !text.contains("## End");
        if cut {
            let words = "the file's last line is missing: it may be cut off";
            self.diags.push(Diag::new(Code::Inconsistent, 1, 1, words).warning());
        }
    }
}

fn short(text: &str) -> String {
    clean(text).trim().chars().take(LONGEST).collect()
}

/// Thousandths of a degree, 0 to 359 999.
fn angle(text: &str, comma: bool) -> Option<i32> {
    let text = text.trim().trim_end_matches('°').trim_end_matches("deg").trim();
    let text = if comma { text.replace(',', ".") } else { text.to_owned() };
    let (value, _) = Decimal::parse(&text)?.scaled(1000, 1)?;
    i32::try_from(value.rem_euclid(360_000)).ok()
}
