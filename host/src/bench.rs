//! `pasapas bench`: the figures that the project promises, measured.
//!
//! Cycles and step rates are those of the emulated chip, taken at its pins; times of the desktop's
//! own engines are this computer's.

mod cell;
pub(crate) mod code;
mod costs;
#[cfg(feature = "gateway")]
mod gateway;
mod grbl;
mod import;
mod jitter;
mod link;
mod motion;
mod passes;
mod path;
pub(crate) mod paths;
mod speed;
pub mod stand;
pub(crate) mod stream;
mod vm;

use std::borrow::Cow;

use serde::Serialize;

/// Which way a figure is good.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Want {
    /// The more the better.
    #[serde(rename = ">=")]
    AtLeast,
    /// The less the better.
    #[serde(rename = "<=")]
    AtMost,
}

/// One line of the bench.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// Its stable name.
    pub figure: Cow<'static, str>,
    /// What was measured.
    pub value: f64,
    /// Unit of all three values.
    pub unit: &'static str,
    /// Which way it is good.
    pub want: Want,
    /// What it must reach.
    pub must: f64,
    /// What it is to reach.
    pub aim: f64,
    /// What it was made from, if that is worth a word.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub note: String,
}

impl Figure {
    /// Whether the figure reaches what it must.
    pub fn is_met(&self) -> bool {
        match self.want {
            Want::AtLeast => self.value >= self.must,
            Want::AtMost => self.value <= self.must,
        }
    }
}

/// A figure that must reach at least so much.
fn at_least(figure: &'static str, unit: &'static str, value: f64, must: f64, aim: f64) -> Figure {
    let (figure, value, note) = (figure.into(), round(value), String::new());
    Figure { figure, value, unit, want: Want::AtLeast, must, aim, note }
}

/// A figure that must stay below so much.
fn at_most(
    figure: impl Into<Cow<'static, str>>,
    unit: &'static str,
    value: f64,
    must: f64,
    aim: f64,
) -> Figure {
    let (figure, value, note) = (figure.into(), round(value), String::new());
    Figure { figure, value, unit, want: Want::AtMost, must, aim, note }
}

/// Three digits behind the point are more than any figure has.
fn round(value: f64) -> f64 {
    (value * 1000.0).round() / 1000.0
}

/// Takes each figure as it is had; the error ends the bench.
pub type Sink<'a> = &'a mut dyn FnMut(Figure) -> Result<(), String>;

/// A group of figures: its name and what measures it.
pub type Group = (&'static str, fn(Sink<'_>) -> Result<(), String>);

/// Every group, the quick ones first.
pub const GROUPS: &[Group] = &[
    ("code", code::run),
    ("import", import::run),
    ("link", link::run),
    #[cfg(feature = "gateway")]
    ("gateway", gateway::run),
    ("vm", vm::run),
    ("costs", costs::run),
    ("passes", passes::run),
    ("motion", motion::run),
    ("stream", stream::run),
    ("grbl", grbl::run),
    ("speed", speed::run),
    ("cell", cell::run),
    ("paths", paths::run),
];

/// Groups that have a short form.
pub const SHORT: &[Group] = &[("paths", paths::run_short)];

#[cfg(test)]
mod tests {
    use super::GROUPS;

    #[test]
    fn every_group_has_its_row_in_the_manual() {
        let manual = include_str!("../../ARCHITECTURE.md");
        let rows = manual.split_once("| group | what it measures |").expect("the table").1;
        let rows = rows.split_once("\n\n").expect("its end").0;
        for (name, _) in GROUPS {
            assert!(rows.contains(&format!("\n| `{name}` |")), "`pasapas bench {name}` has no row");
        }
        // The parts of the time for which a line must last, which slow points are computed with.
        for figure in ["line_planned_x", "line_shaped", "vm_costs"] {
            assert!(
                manual.contains(&format!("\n| `{figure}`")),
                "{figure} has no bound in the manual"
            );
        }
    }
}
