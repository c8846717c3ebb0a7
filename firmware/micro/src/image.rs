//! The routines of an image that are micro-code: where they begin, and what they find there.

use std::collections::BTreeSet;

use crate::decode::{Code, Kind, decode};
use crate::isa::{CALLED, Next, Own, ROUTINES, Routine};

/// Who enters a routine, and so what it finds.
#[derive(Clone, Copy, Debug)]
pub enum By {
    /// Callers that know its row.
    Row(&'static Routine),
    /// The statement that begins or goes on: r12 = its code, from the first to the last of these, Z set in phase 0.
    Effect(u8, u8),
    /// The same of a line, of which the planner keeps in [`Scratch::SPARE_TOO`] what is left while it moves.
    Line(u8, u8),
    /// A register that is read: r12 = 0.
    Register,
    /// Instructions in front of it, which leave all that it looks at.
    Instructions,
}

/// A routine.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// The address of its first operation.
    pub at: u16,
    /// Who enters it.
    pub by: By,
}

impl Entry {
    /// The addresses of the operations that it may come to, those of its calls not among them.
    #[must_use]
    pub fn operations(&self, code: &dyn Code) -> BTreeSet<u16> {
        let mut seen = BTreeSet::new();
        let mut open = vec![self.at];
        while let Some(at) = open.pop() {
            if !seen.insert(at) {
                continue;
            }
            if let Ok(op) = decode(code, at) {
                open.extend(&op.targets);
                let next = op.row().map_or(Next::On, |row| row.next);
                if matches!(next, Next::On | Next::OnOrReturn | Next::If) {
                    open.push(op.end());
                }
            }
        }
        seen
    }
}

/// All routines of an image; a symbol that it lacks is left out.
#[must_use]
pub fn entries(code: &dyn Code) -> Vec<Entry> {
    let mut found = Vec::new();
    let table = code.symbol("micro_table").unwrap_or_default();
    for (routine, place) in ROUTINES.iter().zip((table..).step_by(2)) {
        found.push(Entry { at: code.word(place), by: By::Row(routine) });
    }
    for routine in CALLED {
        let at = code.symbol(routine.label);
        found.extend(at.map(|at| Entry { at, by: By::Row(routine) }));
    }
    // Instructions stand at even places.
    found.retain(|entry| entry.at & 1 == 1);
    found.extend(effects(code));
    found.extend(registers(code).into_iter().map(|at| Entry { at, by: By::Register }));
    found.extend(inline(code).into_iter().map(|at| Entry { at, by: By::Instructions }));
    found
}

/// Of each statement: `effect_codes` has the first code of each row of `effect_table`, the highest one first.
fn effects(code: &dyn Code) -> Vec<Entry> {
    let (Some(codes), Some(table)) = (code.symbol("effect_codes"), code.symbol("effect_table"))
    else {
        return Vec::new();
    };
    let mut found = Vec::new();
    let mut last = 0xFF;
    for (place, row) in (codes..table).zip((table..).step_by(2)) {
        let first = code.byte(place);
        // Behind the last row there may be a byte for an even address.
        if first == 0 {
            break;
        }
        let at = code.word(row);
        let is_line = code.symbol("fx_linear") == Some(at);
        let by = if is_line { By::Line(first, last) } else { By::Effect(first, last) };
        found.push(Entry { at, by });
        last = first - 1;
    }
    found
}

/// Of registers: the rows `MAP_CODE` of the lists.
fn registers(code: &dyn Code) -> Vec<u16> {
    let places = ["MAP_LISTS", "map_list_profile", "MAP_MICRO"].map(|name| code.symbol(name));
    let [Some(first), Some(last), Some(base)] = places else { return Vec::new() };
    let rows = (first..=last).step_by(2);
    let rows = rows.filter(|at| code.byte(*at) & 3 == 1);
    rows.map(|at| base + u16::from(code.byte(at + 1))).collect()
}

/// Behind each `call #micro`.
fn inline(code: &dyn Code) -> Vec<u16> {
    let Some(micro) = code.symbol("micro") else { return Vec::new() };
    let places = (0x8000..0xFFD0u16).step_by(2);
    let calls = places.filter(|at| code.word(*at) == 0x12B0 && code.word(at + 2) == micro);
    calls.map(|at| at + 4).collect()
}

/// Routines that operations call by their address.
#[must_use]
pub fn called(code: &dyn Code, entries: &[Entry]) -> BTreeSet<u16> {
    let mut found = BTreeSet::new();
    for entry in entries {
        for at in entry.operations(code) {
            match decode(code, at) {
                Ok(op) if op.kind == Kind::Own(Own::Call) => found.extend(op.operands),
                _ => {}
            }
        }
    }
    found
}
