//! Cells of variables.
//!
//! AT variables lie where they say and the others after the last of them: KEEP values in a row,
//! globals, then locals. The device keeps the cells before the first KEEP cell from run to run, so no
//! other variable may fill the gaps between AT variables. Locals of routines that never run at the same time share cells:
//! a routine's begin after those of all its callers, an event handler's after the main
//! program's, an error handler's after both.

use std::collections::HashMap;

use crate::back::graph::{Graph, context};
use crate::back::ir::Unit;
use crate::back::report::MAX_DEPTH;
use crate::hir::{Program, RoutineId, Span, Storage, VarId};
use crate::wire::{CRC_START, crc16};

/// First register of the cells on the link.
const FIRST_REGISTER: u16 = 3000;

/// Where everything lies.
#[derive(Clone, Debug, Default)]
pub struct Cells {
    /// First cell of each variable that is alive.
    pub of: HashMap<VarId, u32>,
    /// Cells in all.
    pub count: usize,
    /// KEEP variables in order.
    pub keeps: Vec<VarId>,
    /// Cells of these.
    pub kept: usize,
    /// First KEEP cell: how many cells the AT variables take, also without KEEP values.
    pub keep_base: u32,
}

impl Cells {
    /// The cell of a variable.
    pub fn cell(&self, var: VarId) -> u32 {
        self.of.get(&var).copied().unwrap_or(0)
    }

    /// Declaration of the first variable that lies beyond `available` cells.
    pub fn beyond(&self, program: &Program, available: usize) -> Span {
        let ends = |var: VarId| self.cell(var) as usize + program.var(var).len as usize;
        let mut beyond: Vec<VarId> =
            self.of.keys().copied().filter(|&var| ends(var) > available).collect();
        beyond.sort_unstable_by_key(|&var| (ends(var), var));
        beyond.first().map_or(0..0, |&var| program.var(var).span.clone())
    }
}

/// Cells that are taken, for variables that stay.
#[derive(Default)]
struct Taken {
    cells: Vec<bool>,
    /// No cell before this one is free.
    low: usize,
}

impl Taken {
    fn take(&mut self, first: usize, len: usize) {
        if self.cells.len() < first + len {
            self.cells.resize(first + len, false);
        }
        self.cells[first..first + len].fill(true);
        while self.cells.get(self.low) == Some(&true) {
            self.low += 1;
        }
    }

    /// The lowest run of `len` free cells, taken.
    fn lowest(&mut self, len: usize) -> usize {
        let free = |first: &usize| {
            (*first..first + len).all(|cell| !self.cells.get(cell).copied().unwrap_or(false))
        };
        let end = self.cells.len();
        let first = (self.low..=end).find(free).unwrap_or(end);
        self.take(first, len);
        first
    }
}

/// Gives every variable its cells.
pub fn allocate(program: &Program, unit: &Unit, graph: &Graph) -> Cells {
    let mut cells = Cells::default();
    let mut taken = Taken::default();
    let vars = || (0..program.vars.len() as u32).map(VarId);
    for id in vars() {
        let var = program.var(id);
        match var.storage {
            Storage::At(register) => {
                let first = usize::from(register.saturating_sub(FIRST_REGISTER) / 2);
                taken.take(first, var.len as usize);
                cells.of.insert(id, first as u32);
            }
            Storage::Keep(_) => cells.keeps.push(id),
            _ => {}
        }
    }
    cells.keeps.sort_by_key(|&id| match program.var(id).storage {
        Storage::Keep(index) => index,
        _ => u8::MAX,
    });
    taken.low = taken.cells.len();
    cells.keep_base = taken.low as u32;
    for &id in &cells.keeps {
        cells.of.insert(id, cells.keep_base + cells.kept as u32);
        cells.kept += program.var(id).len as usize;
    }
    taken.take(taken.low, cells.kept);
    // Scalars first: the lowest cells have instructions of one byte.
    let main_local = |storage| matches!(storage, Storage::Global | Storage::Local(RoutineId(0)));
    for arrays in [false, true] {
        for id in vars() {
            let var = program.var(id);
            if main_local(var.storage) && var.array == arrays {
                let first = taken.lowest(var.len.max(1) as usize);
                cells.of.insert(id, first as u32);
            }
        }
    }
    let shared = taken.cells.len();
    cells.count = locals(program, unit, graph, shared, &mut cells.of);
    cells
}

/// Places the locals from cell `first` on; gives the number of cells in all.
fn locals(
    program: &Program,
    unit: &Unit,
    graph: &Graph,
    first: usize,
    of: &mut HashMap<VarId, u32>,
) -> usize {
    let position: HashMap<RoutineId, usize> =
        unit.routines.iter().enumerate().map(|(r, routine)| (routine.id, r)).collect();
    let mut variables: HashMap<RoutineId, Vec<VarId>> = HashMap::new();
    for (i, var) in program.vars.iter().enumerate() {
        if let Storage::Local(id) = var.storage
            && id.0 != 0
            && position.contains_key(&id)
        {
            variables.entry(id).or_default().push(VarId(i as u32));
        }
    }
    let size = |r: usize| -> usize {
        let own = variables.get(&unit.routines[r].id);
        own.map_or(0, |own| own.iter().map(|&id| program.var(id).len.max(1) as usize).sum())
    };
    let mut end = first;
    for bit in [context::MAIN, context::EVENT, context::ERROR] {
        let base = end;
        let mut bases: Vec<usize> = vec![base; unit.routines.len()];
        // Longest path: as many rounds as a chain of calls has links at most; of one that is too
        // long for any device the cells do not matter.
        for _ in 0..=graph.calls.min(MAX_DEPTH) {
            let mut moved = false;
            for (r, callees) in graph.callees.iter().enumerate() {
                let behind = bases[r] + size(r);
                for (callee, _) in callees.iter().filter(|(_, context)| *context == bit) {
                    let Some(&callee) = position.get(callee) else { continue };
                    if bases[callee] < behind {
                        bases[callee] = behind;
                        moved = true;
                    }
                }
            }
            if !moved {
                break;
            }
        }
        for (r, routine) in unit.routines.iter().enumerate() {
            // A routine of several contexts has no locals; the checker sees to it. Were it
            // otherwise, the outermost context's place would hold.
            if graph.contexts[r] & bit == 0 {
                continue;
            }
            let mut cell = bases[r];
            for &id in variables.get(&routine.id).into_iter().flatten() {
                of.insert(id, cell as u32);
                cell += program.var(id).len.max(1) as usize;
            }
            end = end.max(cell);
        }
    }
    end
}

fn hash(bytes: &[u8]) -> u16 {
    bytes.iter().fold(CRC_START, |crc, &byte| crc16(crc, byte))
}

/// [`MachineRecord::keeps`](crate::record::MachineRecord::keeps) of names and kinds in their order.
pub fn keeps_id(program: &Program, cells: &Cells) -> u8 {
    let declared = cells.keeps.iter().map(|&id| program.var(id));
    let one = |var: &crate::hir::Var| {
        let size = if var.array { format!("({})", var.len) } else { String::new() };
        format!("{}{size} {}\n", var.name.to_ascii_lowercase(), var.kind)
    };
    let text: String = declared.map(one).collect();
    if text.is_empty() { 0 } else { (1 + hash(text.as_bytes()) % 254) as u8 }
}
