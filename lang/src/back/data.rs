//! The data of an image: texts and table columns in their shortest form.

use std::collections::{HashMap, HashSet};

use crate::back::ir::{Item, TextId, Unit};
use crate::hir::{Program, TableId};
use crate::image::{COLUMN_LONG, COLUMN_SCALED};

/// A column of a table, or with `None` the whole table row by row.
type ColumnId = (TableId, Option<u32>);

/// Offsets of what the code refers to.
#[derive(Debug, Default)]
pub struct Data {
    /// All bytes but those of the statement table.
    pub bytes: Vec<u8>,
    texts: HashMap<TextId, usize>,
    columns: HashMap<ColumnId, usize>,
    /// Columns that the next column of the table follows at once.
    paired: HashSet<ColumnId>,
}

impl Data {
    /// Offset of a text.
    pub fn text(&self, id: TextId) -> usize {
        self.texts.get(&id).copied().unwrap_or(0)
    }

    /// Offset of a column.
    pub fn column(&self, id: ColumnId) -> usize {
        self.columns.get(&id).copied().unwrap_or(0)
    }

    /// Offset of a column with its neighbour behind it, where both can be read at once.
    pub fn pair(&self, table: TableId, column: u32) -> Option<u8> {
        let id = (table, Some(column));
        self.paired.get(&id).and_then(|id| u8::try_from(self.column(*id)).ok())
    }
}

/// Columns that stand together, or one text.
enum Piece {
    Text(TextId, Vec<u8>),
    Columns(TableId, Vec<(Option<u32>, Vec<u8>)>),
}

impl Piece {
    fn len(&self) -> usize {
        match self {
            Piece::Text(_, bytes) => bytes.len(),
            Piece::Columns(_, columns) => columns.iter().map(|(_, bytes)| bytes.len()).sum(),
        }
    }
}

/// Lays out what the code uses behind `head` bytes, small things first: an offset below 256 takes
/// one byte in the code.
pub fn lay_out(program: &Program, unit: &Unit, head: Vec<u8>) -> Data {
    let mut columns: HashSet<ColumnId> = HashSet::new();
    let mut texts: HashSet<TextId> = HashSet::new();
    for item in unit.routines.iter().flat_map(|routine| &routine.items) {
        match item {
            Item::Text(id) => {
                texts.insert(*id);
            }
            Item::Table(table, column) => {
                columns.insert((*table, *column));
            }
            Item::Pair(_, table, column) => {
                columns.extend([(*table, Some(*column)), (*table, Some(column + 1))]);
            }
            _ => {}
        }
    }
    let mut pieces = Vec::new();
    let mut text_ids: Vec<TextId> = texts.into_iter().collect();
    text_ids.sort_unstable();
    for id in text_ids {
        let text = &unit.texts[id.0 as usize];
        let mut bytes = vec![text.len() as u8];
        bytes.extend(text);
        pieces.push(Piece::Text(id, bytes));
    }
    let mut column_ids: Vec<ColumnId> = columns.into_iter().collect();
    column_ids.sort_unstable();
    for (table, column) in column_ids {
        let bytes = encode(&values(program, table, column));
        match pieces.last_mut() {
            Some(Piece::Columns(last, group)) if *last == table => group.push((column, bytes)),
            _ => pieces.push(Piece::Columns(table, vec![(column, bytes)])),
        }
    }
    pieces.sort_by_key(Piece::len);
    let mut data = Data { bytes: head, ..Data::default() };
    for piece in pieces {
        match piece {
            Piece::Text(id, bytes) => {
                data.texts.insert(id, data.bytes.len());
                data.bytes.extend(bytes);
            }
            Piece::Columns(table, group) => {
                let mut before = None;
                for (column, bytes) in group {
                    if let (Some(Some(before)), Some(column)) = (before, column)
                        && column == before + 1
                    {
                        data.paired.insert((table, Some(before)));
                    }
                    before = Some(column);
                    data.columns.insert((table, column), data.bytes.len());
                    data.bytes.extend(bytes);
                }
            }
        }
    }
    data
}

fn values(program: &Program, table: TableId, column: Option<u32>) -> Vec<i32> {
    let table = program.table(table);
    match column {
        None => table.values.clone(),
        Some(column) => {
            let columns = table.columns.max(1) as usize;
            table.values.iter().skip(column as usize).step_by(columns).copied().collect()
        }
    }
}

/// Bytes that hold every value, 1..=4.
fn width(values: impl Iterator<Item = i32>) -> u8 {
    let fits = |value: i32| match value {
        -0x80..=0x7F => 1,
        -0x8000..=0x7FFF => 2,
        -0x80_0000..=0x7F_FFFF => 3,
        _ => 4,
    };
    values.map(fits).max().unwrap_or(1)
}

fn gcd(mut a: u32, mut b: u32) -> u32 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// The shortest form of a column ([`crate::image::Column`]).
fn encode(values: &[i32]) -> Vec<u8> {
    let mut scale = values.iter().fold(0, |scale, value| gcd(scale, value.unsigned_abs())).max(1);
    if scale > u32::from(u16::MAX) {
        // The largest divisor that two bytes hold.
        scale = (2..=scale)
            .map(|by| scale / by * u32::from(scale % by == 0))
            .find(|&divisor| (1..=u32::from(u16::MAX)).contains(&divisor))
            .unwrap_or(1);
    }
    // A scale above 1 fits into 16 bits, so the quotient is exact in 64.
    let scaled = |value: &i32| (i64::from(*value) / i64::from(scale)) as i32;
    let (plain_width, scaled_width) =
        (width(values.iter().copied()), width(values.iter().map(scaled)));
    let saved = values.len() * usize::from(plain_width - scaled_width);
    let use_scale = saved > 2;
    let width = if use_scale { scaled_width } else { plain_width };
    let mut out = vec![width - 1, values.len() as u8];
    if values.len() > 255 {
        out[0] |= COLUMN_LONG;
        out.push((values.len() >> 8) as u8);
    }
    if use_scale {
        out[0] |= COLUMN_SCALED;
        out.extend((scale as u16).to_le_bytes());
    }
    for value in values {
        let value = if use_scale { scaled(value) } else { *value };
        out.extend(&value.to_le_bytes()[..usize::from(width)]);
    }
    out
}
