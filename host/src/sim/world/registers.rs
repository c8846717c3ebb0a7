//! The AT variables of a program, as its world reads and writes them.

use std::collections::BTreeMap;

use lang::hir::{Limits, Program, Storage};
use lang::wire::CELLS;
use rhai::Dynamic;

/// What stands at one even register.
#[derive(Clone, Debug)]
struct Register {
    name: String,
    limits: Limits,
    /// A shared number: the engine's and the world's.
    value: Dynamic,
}

/// Who has the values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Owner {
    /// Nobody: there is a board, but no program that this tool knows.
    #[default]
    Nobody,
    /// A simulation.
    Engine,
    /// A board, which the link brings what is written.
    Board,
}

/// The AT variables of a program by their registers. Clones share the values.
#[derive(Clone, Debug, Default)]
pub struct Registers {
    cells: BTreeMap<u16, Register>,
    owner: Owner,
}

impl Registers {
    /// Those of a program that a simulation runs, with the values at power-up: 0.
    pub fn of(program: &Program) -> Registers {
        let mut cells = BTreeMap::new();
        for var in &program.vars {
            let Storage::At(first) = var.storage else { continue };
            let registers = (first..=u16::MAX).step_by(2).take(var.len as usize);
            for (i, register) in registers.enumerate() {
                let name = if var.array { format!("{}({i})", var.name) } else { var.name.clone() };
                let value = Dynamic::from(0_i32).into_shared();
                cells.insert(register, Register { name, limits: var.panel.limits, value });
            }
        }
        Registers { cells, owner: Owner::Engine }
    }

    /// Those of a program that a board runs.
    pub fn on_board(program: &Program) -> Registers {
        Registers { owner: Owner::Board, ..Registers::of(program) }
    }

    /// Whether the program has none.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// The shared value at a register.
    pub fn shared(&self, register: u16) -> Option<Dynamic> {
        self.cells.get(&register).map(|cell| cell.value.clone())
    }

    /// Each cell's number with its shared value.
    pub fn by_cell(&self) -> impl Iterator<Item = (u16, Dynamic)> {
        self.cells.iter().map(|(register, cell)| ((register - CELLS) / 2, cell.value.clone()))
    }

    fn find(&self, register: i32) -> Result<(u16, &Register), String> {
        if self.owner == Owner::Nobody {
            return Err("the world of a board that stands alone knows no variables; `sim` runs a \
                        program with them, and the link reaches the board's"
                .to_owned());
        }
        let known = |register| self.cells.get(&register).map(|cell| (register, cell));
        u16::try_from(register).ok().and_then(known).ok_or_else(|| {
            let there: Vec<String> =
                self.cells.iter().map(|(at, cell)| format!("{at} {}", cell.name)).collect();
            let there = if there.is_empty() { "none".to_owned() } else { there.join(", ") };
            format!("no variable stands AT {register}; the program has {there}")
        })
    }

    /// The value at a register.
    ///
    /// # Errors
    /// No variable stands there, or a board has it.
    pub fn get(&self, register: i32) -> Result<i32, String> {
        let (_, cell) = self.find(register)?;
        if self.owner == Owner::Board {
            return Err("`at_value` is for the engines vm and rhai: a world has no link on which \
                        to ask the board"
                .to_owned());
        }
        Ok(cell.value.as_int().unwrap_or(0))
    }

    /// Changes the value at a register, which it gives.
    ///
    /// # Errors
    /// No variable stands there, or it may not have this value.
    pub fn set(&mut self, register: i32, value: i32) -> Result<u16, String> {
        let (at, cell) = self.find(register)?;
        let Limits { least, greatest } = cell.limits;
        if !(least..=greatest).contains(&value) {
            return Err(format!("`{}` is {least} to {greatest}, not {value}", cell.name));
        }
        put(&mut cell.value.clone(), value);
        Ok(at)
    }
}

/// Changes a shared number.
pub fn put(shared: &mut Dynamic, value: i32) {
    if let Some(mut place) = shared.write_lock::<i32>() {
        *place = value;
    }
}
