//! What is known between two operations.

use std::collections::{BTreeMap, BTreeSet};

use micro::isa::{Gives, Takes};

use crate::ops::Op;
use crate::tree::{Number, Place, Var};

/// What the accumulator holds.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Held {
    /// A number.
    Number(Number),
    /// A variable.
    Var(Var),
    /// What a place holds.
    Place(Place),
    /// The bit of an axis.
    Bit(Var),
}

/// What r9 points to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Record {
    /// The axis's record.
    Axis(Var),
    /// That of the axis that was just made.
    New,
    /// One that leaves have named.
    Named(String),
}

/// See the module.
#[derive(Clone, Debug, Default)]
pub struct State {
    /// Execution does not come here.
    pub dead: bool,
    /// No operation was yet: Z says that this is the first call.
    pub first: bool,
    /// What the accumulator holds, all at once.
    pub held: BTreeSet<Held>,
    /// r13 is 0.
    pub wide: bool,
    /// r12 is 0.
    pub zero: bool,
    /// Z says whether the accumulator is 0.
    pub z: bool,
    /// N is its sign.
    pub n: bool,
    /// Z, behind a jump by it.
    pub equal: Option<bool>,
    /// The axis of r8.
    pub axis: Option<Var>,
    /// What r9 points to.
    pub record: Option<Record>,
    /// Variables that were put by.
    pub stored: BTreeSet<Var>,
    /// Bytes whose values are known.
    pub known: BTreeMap<String, u16>,
}

impl State {
    /// Where ways meet: a jump that is taken leaves the flags.
    pub fn on_way(&self) -> State {
        State { first: false, ..self.clone() }
    }

    /// What two ways agree on.
    pub fn meet(self, other: &State) -> State {
        let same = |a: &Option<Record>, b: &Option<Record>| if a == b { a.clone() } else { None };
        State {
            dead: self.dead && other.dead,
            first: false,
            held: self.held.intersection(&other.held).cloned().collect(),
            wide: self.wide && other.wide,
            zero: self.zero && other.zero,
            z: self.z && other.z,
            n: self.n && other.n,
            equal: if self.equal == other.equal { self.equal } else { None },
            axis: if self.axis == other.axis { self.axis } else { None },
            record: same(&self.record, &other.record),
            stored: self.stored.intersection(&other.stored).copied().collect(),
            known: self
                .known
                .into_iter()
                .filter(|(byte, value)| other.known.get(byte) == Some(value))
                .collect(),
        }
    }

    /// Whether a variable can be had.
    pub fn has(&self, var: Var) -> bool {
        self.dead || self.stored.contains(&var) || self.held.contains(&Held::Var(var))
    }

    /// Variables that only the accumulator holds.
    pub fn alone(&self) -> Vec<Var> {
        let held = self.held.iter().filter_map(|held| match held {
            Held::Var(var) if !self.stored.contains(var) => Some(*var),
            _ => None,
        });
        held.collect()
    }

    /// The accumulator is the variable's new value.
    pub fn set(&mut self, var: Var) {
        self.stored.remove(&var);
        self.held.insert(Held::Var(var));
    }

    /// The accumulator holds something, which is all that is known of it.
    pub fn hold(&mut self, held: Held) {
        self.held.insert(held);
    }

    /// A place of memory is written.
    pub fn forget(&mut self, symbol: &str) {
        self.held.retain(|held| !matches!(held, Held::Place(place) if place.symbol == symbol));
        self.known.remove(symbol);
    }

    /// Memory may have changed.
    pub fn forget_all(&mut self) {
        self.held.retain(|held| !matches!(held, Held::Place(_)));
        self.known.clear();
    }

    /// An operation is done.
    pub fn after(&mut self, op: &Op) {
        let facts = op.facts();
        self.first = false;
        self.equal = None;
        let changes = facts.gives != Gives::Kept;
        if changes {
            self.held.clear();
            self.zero = false;
            self.wide = self.wide && facts.gives == Gives::Low;
        }
        match op.name.as_str() {
            "LIT" => (self.wide, self.zero) = (true, op.first() == "0"),
            "GET" => self.wide = true,
            _ => {}
        }
        // Or those of what it looks at and leaves.
        let result = changes || facts.takes == Takes::Long;
        self.z = result
            && facts.flags.contains('Z')
            && !op.name.ends_with("add")
            && !op.name.ends_with("sub");
        self.n = changes && facts.flags.contains('N');
        if facts.sets.contains('a') {
            (self.axis, self.record) = (None, None);
            if facts.sets.contains('r') {
                self.record = Some(Record::New);
            }
        } else if facts.sets.contains('r') {
            self.record = match (op.first(), self.axis) {
                ("axis_at", Some(axis)) => Some(Record::Axis(axis)),
                _ => None,
            };
        }
        if facts.loses.contains('a') {
            self.axis = None;
        }
        if facts.loses.contains('r') {
            self.record = None;
        }
        self.dead = facts.is_end;
    }
}
