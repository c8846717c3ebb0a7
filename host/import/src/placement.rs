//! Placement files: where a circuit board's parts lie, as KiCad, Altium, Eagle, EasyEDA, JLC and Proteus
//! write it, and bills of material beside them.
//!
//! One reader finds the columns by their titles, in any order. Lengths are um, angles thousandths of a
//! degree, counter-clockwise as seen from the part's own side of the footprint.

mod bom;
mod table;
#[cfg(test)]
mod tests;
mod text;

pub use bom::{Bom, Entry, read as read_bom};

use crate::codes::Code;
use crate::diag::Diag;

/// Parts of one file.
pub const MOST_PARTS: usize = 10_000;
/// Greatest coordinate, um.
const MAX_UM: i64 = 10_000_000;

/// Which side of the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Seen when the file's X counts to the right.
    Top,
    /// The other one.
    Bottom,
}

/// A part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its reference, `R1`.
    pub name: String,
    /// Its value; empty for none.
    pub value: String,
    /// Its package; empty for none.
    pub package: String,
    /// X and Y, um, as they stand in the file.
    pub at: [i64; 2],
    /// How it is turned, thousandths of a degree, 0 to 359 999; none where the file has no such column.
    pub turned: Option<i32>,
    /// Its side.
    pub side: Side,
    /// Line of the file.
    pub line: u32,
}

impl Part {
    /// Whether it is a mark for cameras and no part: `FID1`, or a package that begins with `Fiducial`.
    pub fn is_fiducial(&self) -> bool {
        let rest = self.name.to_ascii_uppercase();
        let numbered = |rest: &str| !rest.is_empty() && rest.bytes().all(|c| c.is_ascii_digit());
        ["FID", "REF"].iter().any(|begin| rest.strip_prefix(begin).is_some_and(numbered))
            || self.package.to_ascii_lowercase().starts_with("fiducial")
    }
}

/// A unit that a file may be in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Millimetres.
    Mm,
    /// Inches.
    Inch,
}

/// A file that was read.
#[derive(Clone, Debug)]
pub struct List {
    /// Which system's it is, as far as that shows.
    pub what: &'static str,
    /// The parts, in the file's order.
    pub parts: Vec<Part>,
    /// Columns that nothing is made of.
    pub left_out: Vec<String>,
    /// Warnings and notes.
    pub notes: Vec<Diag>,
}

/// Whether a text looks like a placement file: something names a reference, X, Y and an angle.
pub fn is_placement(name: &str, text: &str) -> bool {
    table::system(name, text).is_some()
}

/// Reads a file. `unit` is that of lengths where the file does not tell.
///
/// # Errors
/// What is wrong, by line, in the file's order.
pub fn read(name: &str, bytes: &[u8], unit: Option<Unit>) -> Result<List, Vec<Diag>> {
    let text = text::decode(bytes).map_err(|diag| vec![diag])?;
    let (list, diags) = table::read(name, &text, unit);
    if diags.iter().any(|diag| diag.severity == crate::Severity::Error) {
        return Err(diags);
    }
    let mut list = list;
    list.notes = diags;
    if list.parts.is_empty() {
        let words = "a placement file without a part";
        return Err(vec![Diag::new(Code::NoProgram, 1, 1, words)]);
    }
    Ok(list)
}
