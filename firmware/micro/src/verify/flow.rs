//! What is known at an operation, and after it.

use super::Image;
use crate::decode::{Kind, Op};
use crate::image::By;
use crate::isa::{Flags, Formula, Gives, LOST, Next, Own, Routine, Scratch, Takes};

/// Half of the accumulator, or a pointer: whether it may be used, and whether it is what the caller left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Value {
    good: bool,
    same: bool,
}

impl Value {
    const NEW: Value = Value { good: true, same: false };
    const LOST: Value = Value { good: false, same: false };

    const fn given(good: bool) -> Value {
        Value { good, same: true }
    }

    fn meet(self, other: Value) -> Value {
        Value { good: self.good && other.good, same: self.same && other.same }
    }
}

/// What is known in front of an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct State {
    low: Value,
    high: Value,
    axis: Value,
    record: Value,
    /// Those of Z, N, C and V that hold.
    flags: u8,
    /// Temporary bytes that this routine has written and no call since, or that its caller leaves.
    written: Scratch,
}

const LETTERS: [char; 4] = ['Z', 'N', 'C', 'V'];

fn bits(letters: &str) -> u8 {
    (0..4).filter(|n| letters.contains(LETTERS[*n])).map(|n| 1 << n).sum()
}

impl State {
    /// What a routine finds.
    pub fn at_entry(by: By) -> State {
        let state = |low, high, flags: &str, pointers: &str, written| State {
            low: Value::given(low),
            high: Value::given(high),
            axis: Value::given(pointers.contains('a')),
            record: Value::given(pointers.contains('r')),
            flags: bits(flags),
            written,
        };
        match by {
            By::Row(row) => {
                let written = row.reads.and(row.planner).and(row.finds);
                let low = row.takes != Takes::Nothing;
                state(low, row.takes == Takes::Long, "", row.needs, written)
            }
            By::Effect(..) => state(true, false, "Z", "", Scratch::NONE),
            By::Line(..) => state(true, false, "Z", "", Scratch::SPARE_TOO),
            By::Register => state(true, false, "", "", Scratch::NONE),
            By::Instructions => state(true, true, "ZNCV", "ar", Scratch::ALL),
        }
    }

    /// What is known whichever way was taken.
    pub fn meet(self, other: State) -> State {
        State {
            low: self.low.meet(other.low),
            high: self.high.meet(other.high),
            axis: self.axis.meet(other.axis),
            record: self.record.meet(other.record),
            flags: self.flags & other.flags,
            written: Scratch(self.written.0 & other.written.0),
        }
    }

    fn take(self, takes: Takes, tell: &mut dyn FnMut(String)) {
        if takes != Takes::Nothing && !self.low.good {
            tell("takes r12, which holds nothing".into());
        } else if takes == Takes::Long && !self.high.good {
            tell("takes r13:r12, and r13 holds nothing".into());
        }
    }

    fn give(&mut self, gives: Gives) {
        let [low, high] = match gives {
            Gives::Kept => return,
            Gives::Low => [Value::NEW, self.high],
            Gives::Only => [Value::NEW, Value::LOST],
            Gives::Long => [Value::NEW; 2],
            Gives::Lost => [Value::LOST; 2],
        };
        (self.low, self.high) = (low, high);
    }

    fn want(self, pointers: &str, tell: &mut dyn FnMut(String)) {
        if pointers.contains('a') && !self.axis.good {
            tell("wants an axis, and r8 is none".into());
        }
        if pointers.contains('r') && !self.record.good {
            tell("wants a record, and r9 is none".into());
        }
    }

    fn point(&mut self, pointers: &str, value: Value) {
        if pointers.contains('a') {
            self.axis = value;
        }
        if pointers.contains('r') {
            self.record = value;
        }
    }
}

impl Image<'_> {
    /// Where an operation goes to, with what is known there; what is wrong with it is told.
    pub fn after(
        &self,
        op: &Op,
        mut state: State,
        tell: &mut dyn FnMut(String),
    ) -> Vec<(u16, State)> {
        let read = self.places.read(op).less(state.written);
        if !read.is_none() {
            tell(format!("reads a temporary byte that was not written ({:#x})", read.0));
        }
        match self.callee(op) {
            Some(Ok(row)) => {
                self.call(row, &mut state, tell);
                return vec![(op.end(), state)];
            }
            Some(Err(at)) => {
                tell(format!("calls {at:04x}, which has no row"));
                return Vec::new();
            }
            None => {}
        }
        let Some(row) = op.row() else { return Vec::new() };
        state.take(if is_sum(op) { Takes::Low } else { row.takes }, tell);
        state.want(row.needs, tell);
        if let Kind::Formula(_, place) = op.kind {
            state.want(if place.record { "r" } else { "" }, tell);
            state.want(if place.axis { "a" } else { "" }, tell);
        }
        if let Kind::Own(own) = op.kind
            && let Some((flag, _)) = own.looks_at()
            && state.flags & bits(&flag.to_string()) == 0
        {
            tell(format!("looks at {flag}, which says nothing here"));
        }
        let before = state;
        state.give(row.gives);
        let mut flags = row.flags;
        if is_sum(op) && !before.high.good {
            // The lower halves alone are added.
            state.high = Value::LOST;
            flags = LOST;
        }
        state.point(row.sets, Value::NEW);
        state.written = state.written.and(self.places.written(op));
        if let Flags::Are(letters) = flags {
            state.flags = bits(letters);
        }
        // Along an axis loop r8 is another axis, or none behind the last.
        let counts = matches!(op.kind, Kind::Own(Own::NextAxis | Own::UpAxis));
        let jumped = State { axis: if counts { Value::NEW } else { before.axis }, ..before };
        let mut next = op.targets.iter().map(|at| (*at, jumped)).collect::<Vec<_>>();
        if counts {
            state.axis = Value::LOST;
        }
        if matches!(row.next, Next::On | Next::OnOrReturn | Next::If) {
            next.push((op.end(), state));
        }
        next
    }

    fn call(&self, row: &Routine, state: &mut State, tell: &mut dyn FnMut(String)) {
        state.take(row.takes, tell);
        state.want(row.needs, tell);
        let missing = row.reads.less(state.written);
        if !missing.is_none() {
            tell(format!(
                "{} reads temporary bytes that were not written ({:#x})",
                row.name, missing.0
            ));
        }
        let lies_over = Scratch(row.planner.0 & state.written.0);
        if !lies_over.is_none() {
            tell(format!("{} reads the planner's numbers, which were overwritten", row.name));
        }
        state.give(row.gives);
        state.flags = bits(row.flags);
        state.point(row.sets, Value::NEW);
        state.point(row.loses, Value::LOST);
        state.written = state.written.less(self.clobbers(row)).and(row.leaves);
    }

    /// What must hold where a routine ends.
    pub fn at_end(&self, op: &Op, mut state: State, by: By, tell: &mut dyn FnMut(String)) {
        let Some(row) = op.row().filter(|row| row.next == Next::Returns) else { return };
        state.give(row.gives);
        match by {
            By::Row(row) => promised(row, state, tell),
            By::Effect(..) | By::Line(..) | By::Register if !state.low.good => {
                tell("ends with nothing in r12".into())
            }
            _ => {}
        }
    }
}

/// Whether an operation adds or subtracts: r13 does not matter for r12.
fn is_sum(op: &Op) -> bool {
    matches!(op.kind, Kind::Formula(Formula::Add | Formula::Sub, _))
}

fn promised(row: &Routine, state: State, tell: &mut dyn FnMut(String)) {
    let name = row.name;
    let holds = match row.gives {
        Gives::Kept => state.low.same && state.high.same,
        Gives::Low => state.low.good && state.high.same,
        Gives::Only => state.low.good,
        Gives::Long => state.low.good && state.high.good,
        Gives::Lost => true,
    };
    if !holds {
        tell(format!("{name} ends without what it promises of r13:r12"));
    }
    if bits(row.flags) & !state.flags != 0 {
        tell(format!("{name} ends without its flags {}", row.flags));
    }
    for (letter, value) in [("a", state.axis), ("r", state.record)] {
        let holds = if row.sets.contains(letter) { value.good } else { value.same };
        if !row.loses.contains(letter) && !holds {
            tell(format!("{name} does not keep its pointer {letter}"));
        }
    }
    if !row.leaves.less(state.written).is_none() {
        tell(format!("{name} ends without its result in temporary bytes"));
    }
}
