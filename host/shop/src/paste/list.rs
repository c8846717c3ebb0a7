//! A list of pads: a table with titles, a pad a line.

use csv::{ReaderBuilder, StringRecord, Trim};

use super::outline::{Piece, Thing, rectangle, turned};
use super::{FAR, Layer};
use crate::Wrong;

/// Pads of one list.
const MOST: usize = 20_000;
/// Largest side of a pad, mm.
const MOST_SIDE: f64 = 200.0;
/// What a column is, by its title.
const TITLES: [(&str, usize); 15] = [
    ("x", X),
    ("posx", X),
    ("y", Y),
    ("posy", Y),
    ("width", WIDTH),
    ("w", WIDTH),
    ("height", HEIGHT),
    ("h", HEIGHT),
    ("angle", ANGLE),
    ("rotation", ANGLE),
    ("rot", ANGLE),
    ("name", NAME),
    ("ref", NAME),
    ("designator", NAME),
    ("pad", NAME),
];
const X: usize = 0;
const Y: usize = 1;
const WIDTH: usize = 2;
const HEIGHT: usize = 3;
const ANGLE: usize = 4;
const NAME: usize = 5;

/// Which columns there are, and mm of a unit.
struct Plan {
    columns: [Option<usize>; 6],
    unit: f64,
}

/// Reads a list. Without width and height each line is a place for one dot.
pub(super) fn read(text: &str, unit: Option<f64>) -> Result<Layer, Vec<Wrong>> {
    let parting = [b'\t', b';', b','];
    let first = text.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
    let delimiter = parting.into_iter().find(|sign| first.as_bytes().contains(sign));
    let delimiter = delimiter.unwrap_or(b',');
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(Trim::All)
        .comment(Some(b'#'))
        .delimiter(delimiter)
        .from_reader(text.as_bytes());
    let mut layer = Layer { what: "a list of pads".to_owned(), ..Layer::default() };
    let mut plan = None;
    let mut wrong = Vec::new();
    for record in reader.records() {
        let line = |record: &StringRecord| {
            record.position().map_or(1, |at| u32::try_from(at.line()).unwrap_or(u32::MAX))
        };
        let outcome = match (&plan, record) {
            (_, Err(error)) => {
                let at = error.position().map_or(1, |at| at.line());
                let line = u32::try_from(at).unwrap_or(u32::MAX);
                Err(Wrong::new(line, format!("the table cannot be read: {error}"), HINT))
            }
            (None, Ok(titles)) => titled(&titles, line(&titles), unit, &mut layer.notes)
                .map(|found| plan = Some(found)),
            (Some(plan), Ok(record)) => pad(&record, line(&record), plan, delimiter, &mut layer),
        };
        if let Err(what) = outcome {
            wrong.push(what);
            if plan.is_none() || wrong.len() >= 20 {
                break;
            }
        }
        if layer.things.len() + layer.points.len() > MOST {
            wrong.push(Wrong::new(1, format!("more than {MOST} pads"), "cut the list in pieces"));
            break;
        }
    }
    if wrong.is_empty() { Ok(layer) } else { Err(wrong) }
}

const HINT: &str =
    "a list begins with its titles, such as `name,x,y,width,height,angle`; a paste layer is Gerber";

/// Finds the columns by the titles: `x`, `X (mm)`, `width [in]`.
fn titled(
    record: &StringRecord,
    line: u32,
    unit: Option<f64>,
    notes: &mut Vec<Wrong>,
) -> Result<Plan, Wrong> {
    let mut columns = [None; 6];
    let mut told = None;
    let mut left_out = Vec::new();
    for (n, title) in record.iter().enumerate() {
        let title = title.to_lowercase();
        let mut words = title.split(|c: char| !c.is_ascii_alphanumeric());
        let word = words.next().unwrap_or_default();
        match TITLES.iter().find(|(known, _)| *known == word) {
            Some((_, column)) if columns[*column].is_none() => columns[*column] = Some(n),
            _ => left_out.push(title.clone()),
        }
        for word in words {
            told = match word {
                "mm" => Some(1.0),
                "in" | "inch" => Some(25.4),
                "mil" => Some(0.0254),
                _ => told,
            };
        }
    }
    if columns[X].is_none() || columns[Y].is_none() {
        return Err(Wrong::new(line, "no column is called x, or none y", HINT));
    }
    if columns[WIDTH].is_some() != columns[HEIGHT].is_some() {
        let words = "a pad has a width and a height; one of the columns is missing";
        return Err(Wrong::new(line, words, HINT));
    }
    if !left_out.is_empty() {
        let words = format!("columns left out: {}", left_out.join(", "));
        notes.push(Wrong::new(line, words, "").warning());
    }
    let unit = told.or(unit).unwrap_or_else(|| {
        let words = "the list does not tell its unit: mm is taken";
        notes.push(Wrong::new(line, words, "--unit in, or a title such as `x (in)`").warning());
        1.0
    });
    Ok(Plan { columns, unit })
}

/// Takes a line.
fn pad(
    record: &StringRecord,
    line: u32,
    plan: &Plan,
    delimiter: u8,
    layer: &mut Layer,
) -> Result<(), Wrong> {
    const NAMES: [&str; 5] = ["x", "y", "width", "height", "angle"];
    let text = |column: usize| plan.columns[column].and_then(|n| record.get(n)).unwrap_or_default();
    let number = |column: usize| {
        let name = NAMES[column];
        let word = text(column);
        let plain = match delimiter {
            b',' => word.to_owned(),
            _ => word.replace(',', "."),
        };
        let value = plain.parse::<f64>().ok().filter(|value| value.is_finite());
        value.ok_or_else(|| {
            let words = match word {
                "" => format!("this pad has no {name}"),
                _ => format!("{name} is `{word}`, no number"),
            };
            Wrong::new(line, words, "write a number in the list's unit")
        })
    };
    let place = |column: usize| {
        let mm = number(column)? * plan.unit;
        let far = || {
            Wrong::new(line, format!("{} lies beyond 10 m", NAMES[column]), "is the unit right?")
        };
        if mm.abs() <= FAR { Ok(mm) } else { Err(far()) }
    };
    let side = |column: usize| {
        let mm = number(column)? * plan.unit;
        let words = || format!("{} is {} mm", NAMES[column], mm);
        if mm > 0.0 && mm <= MOST_SIDE {
            Ok(mm)
        } else {
            Err(Wrong::new(
                line,
                words(),
                format!("a side is more than 0 and at most {MOST_SIDE} mm"),
            ))
        }
    };
    let at = [place(X)?, place(Y)?];
    let name = text(NAME).to_owned();
    if plan.columns[WIDTH].is_none() {
        layer.points.push((name, at, line));
        return Ok(());
    }
    let angle = if text(ANGLE).is_empty() { 0.0 } else { number(ANGLE)? };
    let ring = rectangle([0.0; 2], side(WIDTH)?, side(HEIGHT)?);
    let ring = ring.into_iter().map(|spot| {
        let [x, y] = turned(spot, angle);
        [x + at[0], y + at[1]]
    });
    let pieces = vec![Piece { add: true, ring: ring.collect() }];
    layer.things.push(Thing { dark: true, pieces, name, line });
    Ok(())
}
