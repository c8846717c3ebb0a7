//! Paste and glue: a Gerber paste layer or a list of pads becomes a job of dots and beads.
//!
//! [`gerber`] and [`list`] read files into outlines, [`pads`] finds the pads that they cover,
//! [`dots`] spreads dots over each and orders them, [`beads`] draws lines on the long ones, [`job`] writes the script. Lengths are in mm
//! throughout.

mod aperture;
pub mod beads;
pub mod dots;
mod gerber;
pub mod job;
mod list;
pub mod needle;
mod outline;
pub mod pads;
mod sum;
#[cfg(test)]
mod tests;

use crate::Wrong;
use outline::Thing;

/// Largest file that is read, bytes.
pub const MAX_BYTES: usize = 16 << 20;
/// Greatest coordinate, mm.
const FAR: f64 = 10_000.0;

/// The side of a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Seen as it was drawn.
    Top,
    /// Lies upward when the board is turned over.
    Bottom,
}

/// What a file holds.
#[derive(Debug, Default)]
pub struct Layer {
    /// What the file is, for people.
    pub what: String,
    /// The side that the file tells.
    pub side: Option<Side>,
    /// What is drawn, in the file's order.
    things: Vec<Thing>,
    /// Places that get one dot each: name, X and Y, line.
    points: Vec<(String, [f64; 2], u32)>,
    /// What one should know.
    pub notes: Vec<Wrong>,
}

/// Reads a Gerber layer or a list of pads. `unit` is mm of one unit of a list that does not tell it.
///
/// # Errors
/// What is wrong, in the file's order.
pub fn read(text: &str, unit: Option<f64>) -> Result<Layer, Vec<Wrong>> {
    let layer = match gerber::is_gerber(text) {
        true => gerber::read(text)?,
        false => list::read(text, unit)?,
    };
    if layer.things.iter().all(|thing| !thing.dark) && layer.points.is_empty() {
        let words = format!("{} without a pad", layer.what);
        let hint = "is it the layer of the other side? parts through the board need no paste";
        return Err(vec![Wrong::new(1, words, hint)]);
    }
    Ok(layer)
}
