//! Lists of variables and of the machine's parts, as an editor shows them.

use lang::kind::Kind;

use super::names::{Binding, Names};
use super::snapshot::Snapshot;
use crate::lsp::quantity;

/// A list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Group {
    /// Variables of the routine of a line.
    Locals(u32),
    /// Variables of the main program.
    Globals(u32),
    /// An array's values: its name, first cell, length and kind.
    Array(String, usize, usize, Kind, u32),
    /// Axes.
    Axes(u32),
    /// One axis, by its place in the view.
    Axis(usize, u32),
    /// Inputs (false) or outputs (true).
    Ports(bool, u32),
    /// Analog outputs.
    Aouts(u32),
}

impl Group {
    /// The line that it is seen from.
    pub const fn line(&self) -> u32 {
        match self {
            Group::Locals(line)
            | Group::Globals(line)
            | Group::Array(.., line)
            | Group::Axes(line)
            | Group::Axis(_, line)
            | Group::Ports(_, line)
            | Group::Aouts(line) => *line,
        }
    }
}

/// The lists of a call at a line: name, the protocol's hint, list.
pub fn groups(names: &Names, line: u32) -> Vec<(&'static str, &'static str, Group)> {
    let mut groups = Vec::new();
    if names.routine_at(line).is_some() {
        groups.push(("Locals", "locals", Group::Locals(line)));
    }
    groups.push(("Globals", "globals", Group::Globals(line)));
    groups.push(("Axes", "registers", Group::Axes(line)));
    groups.push(("Inputs", "registers", Group::Ports(false, line)));
    groups.push(("Outputs", "registers", Group::Ports(true, line)));
    if !names.profile.aouts.is_empty() {
        groups.push(("Analog outputs", "registers", Group::Aouts(line)));
    }
    groups
}

/// A line of a list.
pub struct Entry {
    /// What it is called.
    pub name: String,
    /// What it holds.
    pub value: String,
    /// Its kind.
    pub kind: &'static str,
    /// How a watch names it.
    pub evaluate: Option<String>,
    /// What it consists of.
    pub inside: Option<Group>,
}

/// The lines of a list.
pub fn entries(group: &Group, names: &Names, at: &Snapshot) -> Vec<Entry> {
    let line = group.line();
    match group {
        Group::Locals(_) => variables(names, names.routine_at(line), line, at),
        Group::Globals(_) => variables(names, None, line, at),
        Group::Array(name, cell, len, kind, _) => {
            let entry = |n: usize| {
                let value = quantity(*kind, at.cell(cell + n));
                plain(format!("({n})"), value, kind.name(), Some(format!("{name}({n})")))
            };
            (0..*len).map(entry).collect()
        }
        Group::Axes(_) => {
            let entry = |(n, axis): (usize, &crate::sim::view::AxisView)| Entry {
                name: axis.axis.letter().to_string(),
                value: format!("{}, {}st", quantity(Kind::Length, axis.um), axis.steps),
                kind: "Axis",
                evaluate: None,
                inside: Some(Group::Axis(n, line)),
            };
            at.view.axes.iter().enumerate().map(entry).collect()
        }
        Group::Axis(n, _) => {
            let Some(axis) = at.view.axes.get(*n) else { return Vec::new() };
            let letter = axis.axis.letter();
            let watch = |func: &str| Some(format!("{func}({letter})"));
            let truth = |on: bool| if on { "1" } else { "0" }.to_owned();
            vec![
                plain("POS".to_owned(), quantity(Kind::Length, axis.um), "Length", watch("POS")),
                plain("POSST".to_owned(), format!("{}st", axis.steps), "Steps", watch("POSST")),
                plain("MOVING".to_owned(), truth(axis.moving), "Truth", watch("MOVING")),
                plain("HOMED".to_owned(), truth(axis.homed), "Truth", watch("HOMED")),
            ]
        }
        Group::Ports(output, _) => {
            let (list, func) =
                if *output { (&at.view.outputs, "OUT") } else { (&at.view.inputs, "IN") };
            let entry = |(n, on): &(i32, bool)| {
                let name = match names.port_name(*output, *n) {
                    Some(name) => format!("{n} {name}"),
                    None => n.to_string(),
                };
                let value = if *on { "ON" } else { "OFF" };
                plain(name, value.to_owned(), "Truth", Some(format!("{func}({n})")))
            };
            list.iter().map(entry).collect()
        }
        Group::Aouts(_) => {
            let entry = |(n, value): &(i32, i32)| {
                let own = names.profile.aouts.iter().find(|own| own.n == *n)?;
                let kind = if own.is_share() { Kind::Number } else { Kind::Voltage };
                let name = own.name.as_ref().map_or(n.to_string(), |name| format!("{n} {name}"));
                Some(plain(name, quantity(kind, *value), kind.name(), None))
            };
            at.view.aouts.iter().filter_map(entry).collect()
        }
    }
}

fn plain(name: String, value: String, kind: &'static str, evaluate: Option<String>) -> Entry {
    Entry { name, value, kind, evaluate, inside: None }
}

fn variables(names: &Names, local_to: Option<usize>, line: u32, at: &Snapshot) -> Vec<Entry> {
    let own = names.variables.iter().filter(|variable| variable.local_to == local_to);
    own.map(|variable| match variable.binding {
        Binding::Cells { cell, len, array: true, kind } => Entry {
            name: variable.name.clone(),
            value: format!("{len} values"),
            kind: kind.name(),
            evaluate: None,
            inside: Some(Group::Array(variable.name.clone(), cell, len, kind, line)),
        },
        Binding::Cells { cell, kind, .. } => {
            let value = quantity(kind, at.cell(cell));
            plain(variable.name.clone(), value, kind.name(), Some(variable.name.clone()))
        }
        _ => plain(variable.name.clone(), "not kept: nothing reads it".to_owned(), "", None),
    })
    .collect()
}
