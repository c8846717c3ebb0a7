//! Patterns of points as scripts that a person would have written: grids, circles, lines, rows of
//! sockets, and lists that other tools wrote (CSV, KiCad's positions, drill files), where two or
//! three taught points may shift and turn what was drawn elsewhere.
//!
//! Lengths are in um throughout, places of the machine.

mod check;
mod frame;
mod gerber;
mod list;
mod shape;
pub mod table;
#[cfg(test)]
mod tests;
mod write;

use serde::{Deserialize, Serialize};

pub use frame::{Fit, Frame, Pair};
pub use shape::Shape;
pub use write::write;

use crate::codes::Code;
use crate::diag::{Diag, Diags};
use crate::text::Lines;
use crate::{detect, excellon};

/// Points of one pattern.
pub const MOST_POINTS: usize = 10_000;
/// Greatest coordinate, um.
pub const MAX_UM: i64 = 10_000_000;

/// A place of a list.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Point {
    /// What it is called; empty for none.
    #[serde(default)]
    pub name: String,
    /// X and Y, um.
    pub at: [i64; 2],
    /// Tool or side that it belongs to; empty for none.
    #[serde(default)]
    pub group: String,
}

/// What is to be written.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pattern {
    /// The points.
    pub shape: Shape,
    /// Where the first of them lies, of a circle its centre, um; a list's places count from there.
    #[serde(default)]
    pub origin: [i64; 2],
    /// How the drawing lies on the machine.
    #[serde(default)]
    pub frame: Option<Frame>,
    /// What happens at each point.
    pub work: Work,
    /// What the points are called in the script, such as `holes`.
    pub name: String,
}

/// What happens at each point, in this order.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Work {
    /// Z goes down before and up behind it.
    #[serde(default)]
    pub down: Option<Down>,
    /// The spindle turns meanwhile, where the machine has one: a drill wants it, a needle does not.
    #[serde(default)]
    pub spindle: bool,
    /// Something that is done there.
    #[serde(default)]
    pub act: Act,
}

/// The way of Z.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Down {
    /// Z of the work's surface, um.
    pub surface: i64,
    /// How deep below it, um, positive.
    pub depth: i64,
    /// How far above it the tool travels, um, positive.
    pub clear: i64,
    /// How fast it goes down, um/s.
    pub feed: i64,
}

/// Something that is done at a point.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Act {
    /// Nothing.
    #[default]
    Nothing,
    /// It waits.
    Wait {
        /// How long, ms.
        ms: i64,
    },
    /// An output goes on.
    Pulse {
        /// Its number.
        output: i32,
        /// How long, ms.
        ms: i64,
    },
}

/// A pattern as a script, or as a piece of one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Written {
    /// The text.
    pub text: String,
    /// How many points it has.
    pub count: usize,
    /// Where the first of them lie, X and Y in um, as many as a picture wants.
    pub places: Vec<[i64; 2]>,
    /// What one should know.
    pub notes: Vec<String>,
}

/// A list that was read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct List {
    /// What the file is.
    pub what: String,
    /// Its points, in its order.
    pub points: Vec<Point>,
    /// What one should know.
    pub notes: Vec<String>,
}

/// Reads the points of a file: Excellon or Gerber drill, KiCad's positions, or CSV.
///
/// # Errors
/// The diagnostics, in the file's order.
pub fn read(name: &str, bytes: &[u8]) -> Result<List, Vec<Diag>> {
    let mut diags = Diags::new(false);
    let lines = Lines::decode(bytes, &mut diags).map_err(|diag| vec![diag])?;
    let (what, points) = points(name, &lines, &mut diags);
    let refused = diags.has_errors();
    let told = diags.into_sorted();
    if refused {
        return Err(told);
    }
    let notes = told.iter().map(|diag| format!("line {}: {}", diag.line, diag.text)).collect();
    Ok(List { what: what.to_owned(), points, notes })
}

/// What a file is, and its points.
pub(crate) fn points(name: &str, lines: &Lines, diags: &mut Diags) -> (&'static str, Vec<Point>) {
    let text = lines.text();
    let (what, points) = if gerber::is_gerber(text) {
        ("a Gerber drill file", gerber::read(text, diags))
    } else if detect::is_columns(text) {
        ("KiCad's positions", list::positions(text, diags))
    } else if detect(name, text) == Some(crate::Format::Excellon) {
        ("a drill file", excellon::holes(lines, diags))
    } else {
        ("a list", list::table(text, diags))
    };
    if points.is_empty() && !diags.has_errors() {
        let hint = "a list has a line for each point: X, Y and, if you like, a name";
        diags.push(Diag::new(Code::NoProgram, 1, 1, format!("{what} without a point")).hint(hint));
    }
    if points.len() > MOST_POINTS {
        let words = format!("{} points; at most {MOST_POINTS} are taken", points.len());
        diags.push(Diag::new(Code::TooLong, 1, 1, words).hint("cut the file in pieces"));
    }
    (what, points)
}
