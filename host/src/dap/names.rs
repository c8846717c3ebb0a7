//! Names of a script in a run: their cells, values and positions, for watches and lists.

use std::collections::HashMap;
use std::ops::Range;

use lang::back::Compiled;
use lang::front::Analysis;
use lang::front::index::{Index, Sort};
use lang::hir::{Limits, Program, Storage};
use lang::kind::Kind;
use lang::profile::Profile;

/// What a name stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Binding {
    /// A variable or an array.
    Cells {
        /// First cell.
        cell: usize,
        /// Number of cells.
        len: usize,
        /// Declared with a size.
        array: bool,
        /// Its kind.
        kind: Kind,
    },
    /// A variable that the compiler did without.
    Gone,
    /// A CONST.
    Const(Kind, i32),
    /// An input (false) or output (true).
    Port(bool, i32),
    /// A TABLE: kinds of its columns, values by rows.
    Table(Vec<Kind>, Vec<i32>),
}

/// A variable as it is listed.
#[derive(Clone, Debug)]
pub struct Variable {
    /// As written.
    pub name: String,
    /// Where it is.
    pub binding: Binding,
    /// The routine that it is local to, as index.
    pub local_to: Option<usize>,
}

/// Names, routines and the machine of a program.
#[derive(Clone, Debug)]
pub struct Names {
    bindings: HashMap<(Option<usize>, String), Binding>,
    /// Variables in the order of their declaration.
    pub variables: Vec<Variable>,
    /// Name, first and last line of each routine.
    routines: Vec<(String, u32, u32)>,
    /// Cells of variables with MIN or MAX, and these.
    limits: Vec<(Range<usize>, Limits)>,
    /// What the script, or else the profile, calls inputs (false) and outputs (true).
    ports: HashMap<(bool, i32), String>,
    /// The machine.
    pub profile: Profile,
}

impl Names {
    /// Everything that has a name in a checked and compiled script.
    pub fn new(
        index: &Index,
        analysis: &Analysis,
        program: &Program,
        compiled: &Compiled,
    ) -> Names {
        let mut bindings = HashMap::new();
        let profile = &program.profile;
        let inputs = profile.inputs.iter().map(|port| (&port.name, false, port.n));
        let outputs = profile.outputs.iter().map(|port| (&port.name, true, port.n));
        for (name, output, n) in inputs.chain(outputs) {
            if let Some(name) = name {
                bindings.insert((None, name.to_lowercase()), Binding::Port(output, n));
            }
        }
        for symbol in index.symbols() {
            let fact = analysis.facts.get(&symbol.name.span.start);
            let value = fact.and_then(|fact| fact.value);
            let binding = match (symbol.sort, fact, value) {
                (Sort::Const, Some(fact), Some(value)) => Binding::Const(fact.kinds[0], value),
                (Sort::Input, _, Some(n)) => Binding::Port(false, n),
                (Sort::Output, _, Some(n)) => Binding::Port(true, n),
                (Sort::Table, _, _) => {
                    let at = symbol.name.span.start as usize;
                    match program.tables.iter().find(|table| table.span.start == at) {
                        Some(table) => Binding::Table(table.kinds.clone(), table.values.clone()),
                        None => continue,
                    }
                }
                _ => continue,
            };
            bindings.insert((symbol.local_to, symbol.name.key.to_string()), binding);
        }
        let mut variables = Vec::new();
        let mut limits = Vec::new();
        for (n, var) in program.vars.iter().enumerate() {
            if var.name.contains(' ') {
                continue;
            }
            let place = compiled.vars.iter().find(|place| place.var.0 as usize == n);
            let binding = place.map_or(Binding::Gone, |place| Binding::Cells {
                cell: place.cell as usize,
                len: place.len as usize,
                array: var.array,
                kind: var.kind,
            });
            if let Some(place) = place.filter(|_| var.panel.limits != Limits::default()) {
                let first = place.cell as usize;
                limits.push((first..first + place.len as usize, var.panel.limits));
            }
            let local_to = match var.storage {
                Storage::Local(routine) => (routine.0 as usize).checked_sub(1),
                _ => None,
            };
            bindings.insert((local_to, var.name.to_lowercase()), binding.clone());
            variables.push(Variable { name: var.name.to_string(), binding, local_to });
        }
        let ports = [false, true].into_iter().flat_map(|output| {
            let name = move |n| Some(((output, n), program.port_name(output, n)?.to_owned()));
            (1..=64).filter_map(name)
        });
        let routines = &analysis.script.routines;
        Names {
            ports: ports.collect(),
            bindings,
            variables,
            limits,
            routines: routines
                .iter()
                .map(|routine| (routine.name.text.to_string(), routine.line, routine.end_line))
                .collect(),
            profile: profile.clone(),
        }
    }

    /// MIN and MAX of the variable that a cell belongs to.
    pub fn limits(&self, cell: usize) -> Limits {
        let own = self.limits.iter().find(|(cells, _)| cells.contains(&cell));
        own.map_or_else(Limits::default, |(_, limits)| *limits)
    }

    /// The routine that a line belongs to.
    pub fn routine_at(&self, line: u32) -> Option<usize> {
        self.routines.iter().position(|(_, first, last)| (*first..=*last).contains(&line))
    }

    /// How a list of calls names the routine of a line.
    pub fn routine_name(&self, line: u32) -> &str {
        self.routine_at(line).map_or("main program", |n| &self.routines[n].0)
    }

    /// What an input (false) or output is called.
    pub fn port_name(&self, output: bool, n: i32) -> Option<&str> {
        self.ports.get(&(output, n)).map(String::as_str)
    }

    /// What a name stands for, seen from a line.
    pub fn look(&self, line: u32, name: &str) -> Option<&Binding> {
        let key = name.to_lowercase();
        let own = self.routine_at(line).and_then(|n| self.bindings.get(&(Some(n), key.clone())));
        own.or_else(|| self.bindings.get(&(None, key)))
    }
}
