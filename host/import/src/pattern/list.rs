//! Lists of points: CSV of any tool, and KiCad's positions (.pos).

use csv::{ReaderBuilder, StringRecord, Trim};
use lang::front::literal::Decimal;

use super::{MAX_UM, MOST_POINTS, Point};
use crate::codes::Code;
use crate::diag::{Diag, Diags};
use crate::script::clean;

/// Lines that are looked at to find out what parts the columns.
const LOOK: usize = 50;
/// Longest name of a point.
const LONGEST_NAME: usize = 60;

/// A unit of a file, by what a header or a value calls it: its name, and um as a fraction.
const UNITS: [(&str, u32, u32); 9] = [
    ("mm", 1000, 1),
    ("um", 1, 1),
    ("cm", 10_000, 1),
    ("inches", 25_400, 1),
    ("inch", 25_400, 1),
    ("in", 25_400, 1),
    ("mils", 254, 10),
    ("mil", 254, 10),
    ("\"", 25_400, 1),
];

/// What a column is, by its title.
const TITLES: [(&str, Column); 32] = [
    ("x", Column::X),
    ("posx", Column::X),
    ("pos x", Column::X),
    ("x pos", Column::X),
    ("xpos", Column::X),
    ("mid x", Column::X),
    ("midx", Column::X),
    ("center x", Column::X),
    ("x coord", Column::X),
    ("y", Column::Y),
    ("posy", Column::Y),
    ("pos y", Column::Y),
    ("y pos", Column::Y),
    ("ypos", Column::Y),
    ("mid y", Column::Y),
    ("midy", Column::Y),
    ("center y", Column::Y),
    ("y coord", Column::Y),
    ("name", Column::Name),
    ("ref", Column::Name),
    ("refdes", Column::Name),
    ("designator", Column::Name),
    ("reference", Column::Name),
    ("label", Column::Name),
    ("point", Column::Name),
    ("id", Column::Name),
    ("side", Column::Group),
    ("layer", Column::Group),
    ("tb", Column::Group),
    ("tool", Column::Group),
    ("group", Column::Group),
    ("diameter", Column::Group),
];

#[derive(Clone, Copy, PartialEq, Eq)]
enum Column {
    X,
    Y,
    Name,
    Group,
}

/// A unit as a fraction of um.
type Unit = (u32, u32);

const MM: Unit = (1000, 1);

/// Where the columns of a list are, and what X and Y count in.
#[derive(Default)]
struct Plan {
    x: (usize, Option<Unit>),
    y: (usize, Option<Unit>),
    name: Option<usize>,
    group: Option<usize>,
}

/// Says which columns of a list are not used; a point has a place, a name and a group.
fn left_out(columns: &[&str], line: u32, diags: &mut Diags) {
    if columns.is_empty() {
        return;
    }
    let plural = if columns.len() == 1 { " is" } else { "s are" };
    let text = format!("the column{plural} left out: {}", columns.join(", "));
    diags.push(Diag::new(Code::LeftOut, line, 1, text).note());
}

/// Reads KiCad's list: `C1 100n C_0603 12.7 -20.32 90 top`, values and packages without blanks.
pub(super) fn positions(text: &str, diags: &mut Diags) -> Vec<Point> {
    let mut unit = MM;
    let mut points = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.trim();
        if let Some(remark) = line.strip_prefix('#') {
            let words = remark.trim_start_matches('#').trim();
            if words.starts_with("Ref") && words.contains("PosX") {
                let used = ["Ref", "PosX", "PosY", "Side"];
                let columns = words.split_whitespace().filter(|column| !used.contains(column));
                left_out(&columns.collect::<Vec<_>>(), number, diags);
            }
            let named = words.strip_prefix("Unit").and_then(|rest| rest.split_once('='));
            if let Some(found) = named.and_then(|(_, rest)| unit_of(rest.split(',').next()?)) {
                unit = found;
            }
            continue;
        }
        if line.is_empty() {
            continue;
        }
        let words: Vec<&str> = line.split_whitespace().collect();
        let [first, .., x, y, _, side] = words[..] else {
            let words = "a line of KiCad's positions has a name, value, package, X, Y, angle, side";
            diags.push(Diag::new(Code::WrongCount, number, 1, words));
            continue;
        };
        let at = [x, y].map(|text| place(text, Some(unit), false));
        push(&mut points, diags, number, (first, side), at);
    }
    points
}

/// Reads CSV: with or without a line of titles, parted by commas, semicolons, tabs or blanks.
pub(super) fn table(text: &str, diags: &mut Diags) -> Vec<Point> {
    let parted = delimiter(text);
    let blanks;
    let text = if parted == b' ' {
        blanks = text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "));
        &blanks.collect::<Vec<_>>().join("\n")
    } else {
        text
    };
    let mut reader = ReaderBuilder::new()
        .delimiter(parted)
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .trim(Trim::All)
        .from_reader(text.as_bytes());
    let comma = parted != b',';
    let mut plan: Option<Plan> = None;
    let mut points = Vec::new();
    let mut ahead = 0;
    for record in reader.records() {
        let record = match record {
            Ok(record) => record,
            Err(error) => {
                let line = error.position().map_or(1, csv::Position::line);
                let words = format!("this is no line of a list: {error}");
                diags.push(Diag::new(Code::Unreadable, clamp(line), 1, words));
                return points;
            }
        };
        let line = clamp(record.position().map_or(1, csv::Position::line));
        if record.iter().all(str::is_empty) {
            continue;
        }
        let Some(plan) = &plan else {
            if let Some(found) = titles(&record) {
                let used = [Some(found.x.0), Some(found.y.0), found.name, found.group];
                let columns = record.iter().enumerate();
                let columns =
                    columns.filter(|(at, title)| !used.contains(&Some(*at)) && !title.is_empty());
                left_out(&columns.map(|(_, title)| title).collect::<Vec<_>>(), line, diags);
                plan = Some(found);
            } else if let Some(found) = by_values(&record, comma) {
                add(&mut points, diags, line, &record, &found, comma);
                plan = Some(found);
            } else {
                // What stands above the titles: a report's head.
                ahead += 1;
                if ahead > LOOK {
                    let hint = "a title line names X and Y, or each line begins with two numbers";
                    let words = "no column of this list is X or Y";
                    diags.push(Diag::new(Code::Unreadable, line, 1, words).hint(hint));
                    return points;
                }
            }
            continue;
        };
        add(&mut points, diags, line, &record, plan, comma);
        if diags.hopeless() || points.len() > MOST_POINTS {
            break;
        }
    }
    points
}

fn clamp(line: u64) -> u32 {
    u32::try_from(line).unwrap_or(u32::MAX)
}

/// The sign that parts most lines.
fn delimiter(text: &str) -> u8 {
    let lines = || text.lines().filter(|line| !line.trim().is_empty()).take(LOOK);
    let with = |c: char| lines().filter(|line| line.contains(c)).count();
    // A comma may be a decimal's: the others come first.
    let best = ['\t', ';', ','].into_iter().find(|c| 2 * with(*c) > lines().count());
    best.map_or(b' ', |c| c as u8)
}

/// A title line: it names X and Y.
fn titles(record: &StringRecord) -> Option<Plan> {
    let mut plan = Plan::default();
    let (mut x, mut y) = (None, None);
    for (at, title) in record.iter().enumerate() {
        let title = title.to_ascii_lowercase().replace(['_', '-', '.'], " ");
        let (title, unit) = match title.split_once(['(', '[']) {
            Some((name, unit)) => {
                (name.trim().to_owned(), unit_of(unit.trim_end_matches([')', ']'])))
            }
            None => (title.trim().to_owned(), None),
        };
        match TITLES.iter().find(|(known, _)| *known == title).map(|(_, column)| column) {
            Some(Column::X) if x.is_none() => x = Some((at, unit)),
            Some(Column::Y) if y.is_none() => y = Some((at, unit)),
            Some(Column::Name) if plan.name.is_none() => plan.name = Some(at),
            Some(Column::Group) if plan.group.is_none() => plan.group = Some(at),
            _ => {}
        }
    }
    (plan.x, plan.y) = (x?, y?);
    Some(plan)
}

/// A line without titles: its first two numbers are X and Y, its first word is the name.
fn by_values(record: &StringRecord, comma: bool) -> Option<Plan> {
    let is_number = |text: &str| place(text, None, comma).is_ok();
    let mut numbers = (0..record.len()).filter(|at| is_number(&record[*at]));
    let (x, y) = (numbers.next()?, numbers.next()?);
    let name = (0..record.len()).find(|at| !is_number(&record[*at]) && !record[*at].is_empty());
    Some(Plan { x: (x, None), y: (y, None), name, group: None })
}

fn add(
    points: &mut Vec<Point>,
    diags: &mut Diags,
    line: u32,
    record: &StringRecord,
    plan: &Plan,
    comma: bool,
) {
    let text = |at: Option<usize>| at.and_then(|at| record.get(at)).unwrap_or_default();
    let at = [plan.x, plan.y].map(|(at, unit)| place(text(Some(at)), unit, comma));
    push(points, diags, line, (text(plan.name), text(plan.group)), at);
}

fn push(
    points: &mut Vec<Point>,
    diags: &mut Diags,
    line: u32,
    (name, group): (&str, &str),
    [x, y]: [Result<i64, String>; 2],
) {
    match (x, y) {
        (Ok(x), Ok(y)) => points.push(Point {
            name: clean(name).chars().take(LONGEST_NAME).collect(),
            at: [x, y],
            group: clean(group).chars().take(LONGEST_NAME).collect(),
        }),
        (Err(words), _) | (_, Err(words)) => {
            let hint =
                "lengths are in mm unless they or their title name a unit: 12.7, 0.5in, 100mil";
            diags.push(Diag::new(Code::Unreadable, line, 1, words).hint(hint));
        }
    }
}

fn unit_of(text: &str) -> Option<Unit> {
    let text = text.trim();
    let found = UNITS.iter().find(|(name, ..)| text.eq_ignore_ascii_case(name));
    found.map(|(_, num, den)| (*num, *den))
}

/// A length in um: a number, with a unit of its own or in that of its column, else in mm.
fn place(text: &str, unit: Option<Unit>, comma: bool) -> Result<i64, String> {
    let text = text.trim();
    let end = text.find(|c: char| !c.is_ascii_digit() && !"+-.,".contains(c));
    let (digits, suffix) = text.split_at(end.unwrap_or(text.len()));
    let own = match suffix.trim() {
        "" => unit.unwrap_or(MM),
        suffix => unit_of(suffix).ok_or_else(|| format!("`{}` is no length", clean(text)))?,
    };
    let digits =
        if comma && !digits.contains('.') { digits.replace(',', ".") } else { digits.into() };
    let um = Decimal::parse(&digits).and_then(|value| value.scaled(own.0, own.1));
    match um {
        Some((um, _)) if um.abs() <= MAX_UM => Ok(um),
        Some(_) => Err(format!("`{}` lies beyond 10 m", clean(text))),
        None => Err(format!("`{}` is no length", clean(text))),
    }
}
