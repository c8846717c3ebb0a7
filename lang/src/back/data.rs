//! The data of an image: texts and table columns in their shortest form.

use std::collections::{HashMap, HashSet};

use crate::back::ir::{Item, TextId, Unit};
use crate::hir::{Program, TableId};

/// A column of a table, or with `None` the whole table row by row.
type ColumnId = (TableId, Option<u32>);

/// Offsets of what the code refers to.
#[derive(Debug, Default)]
pub struct Data {
    /// All bytes but those of the statement table.
    pub bytes: Vec<u8>,
    texts: HashMap<TextId, usize>,
    columns: HashMap<ColumnId, usize>,
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
}

/// A column or a text.
enum Piece {
    Text(TextId),
    Column(ColumnId),
}

/// Lays out what the code uses behind `head` bytes, small things first: an offset below 256 takes
/// one byte in the code.
pub fn lay_out(program: &Program, unit: &Unit, head: Vec<u8>) -> Data {
    let mut columns: HashSet<ColumnId> = HashSet::new();
    let mut texts: HashSet<TextId> = HashSet::new();
    for item in unit.routines.iter().flat_map(|routine| &routine.items) {
        match item {
            Item::Text(id) | Item::Run(id) | Item::Course(id) => {
                texts.insert(*id);
            }
            Item::Table(table, column) => {
                columns.insert((*table, *column));
            }
            _ => {}
        }
    }
    let mut pieces = Vec::new();
    let mut text_ids: Vec<TextId> = texts.into_iter().collect();
    text_ids.sort_unstable();
    for id in text_ids {
        let text = &unit.texts[id.0 as usize];
        let mut bytes = vec![text.len().min(255) as u8];
        bytes.extend(text);
        pieces.push((Piece::Text(id), bytes));
    }
    let mut column_ids: Vec<ColumnId> = columns.into_iter().collect();
    column_ids.sort_unstable();
    for id in column_ids {
        pieces.push((Piece::Column(id), column(&values(program, id.0, id.1))));
    }
    pieces.sort_by_key(|(_, bytes)| bytes.len());
    let mut data = Data { bytes: head, ..Data::default() };
    for (piece, bytes) in pieces {
        match piece {
            Piece::Text(id) => data.texts.insert(id, data.bytes.len()),
            Piece::Column(id) => data.columns.insert(id, data.bytes.len()),
        };
        data.bytes.extend(bytes);
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
pub fn column(values: &[i32]) -> Vec<u8> {
    let mut scale = values.iter().fold(0, |scale, value| gcd(scale, value.unsigned_abs())).max(1);
    if scale > u32::from(u16::MAX) {
        // The largest divisor that two bytes hold.
        scale = (2..=scale)
            .map(|by| scale / by * u32::from(scale % by == 0))
            .find(|&divisor| (1..=u32::from(u16::MAX)).contains(&divisor))
            .unwrap_or(1);
    }
    // The scale fits into 16 bits, so the quotient is exact in 64.
    let scaled = |value: &i32| (i64::from(*value) / i64::from(scale)) as i32;
    let width = width(values.iter().map(scaled));
    let mut out = vec![width];
    out.extend((values.len() as u16).to_le_bytes());
    out.extend((scale as u16).to_le_bytes());
    for value in values {
        out.extend(&scaled(value).to_be_bytes()[4 - usize::from(width)..]);
    }
    out
}
