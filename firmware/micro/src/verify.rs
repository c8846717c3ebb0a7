//! What micro-code must keep to, found by following it: each routine by itself, its calls by their rows.
//!
//! - All that a path comes to is an operation, every path can end, and no two operations overlap.
//! - What is taken of the accumulator is there; what it holds at the end is what the row promises.
//! - A flag that a jump looks at was left by what came before and by nothing in between.
//! - An operand of the axis or of the record has its pointer; what the row says of both is so.
//! - A temporary byte that is read was written before, by this routine, and by no call since: each of them has
//!   several names, so what is read otherwise may be another's. What the planner keeps there is not overwritten
//!   where a call reads it.

mod flow;
mod scratch;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use crate::decode::{Code, Kind, Op, decode};
use crate::image::{By, Entry};
use crate::isa::{CALLED, Next, Own, ROUTINES, Routine, Scratch};
use flow::State;

/// What is wrong, and where.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Finding {
    /// The operation's address.
    pub at: u16,
    /// What is wrong with it.
    pub text: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04x}: {}", self.at, self.text)
    }
}

/// What was looked at, and what is wrong.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Operations.
    pub operations: usize,
    /// Their bytes.
    pub bytes: usize,
    /// What is wrong, by address.
    pub findings: BTreeSet<Finding>,
}

/// An image while its routines are looked at.
struct Image<'a> {
    code: &'a dyn Code,
    /// Routines by their addresses.
    rows: BTreeMap<u16, &'static Routine>,
    /// Temporary bytes that a routine, with its calls, may write.
    writes: BTreeMap<u16, Scratch>,
    places: scratch::Places,
}

/// Looks at routines, as [`crate::image::entries`] finds them.
#[must_use]
pub fn verify(code: &dyn Code, entries: &[Entry]) -> Report {
    let rows = CALLED.iter().chain(ROUTINES).filter_map(|row| Some((code.symbol(row.label)?, row)));
    let mut image = Image {
        code,
        rows: rows.collect(),
        writes: BTreeMap::new(),
        places: scratch::Places::of(code),
    };
    image.sum_writes(entries);
    let mut report = Report::default();
    let mut bytes = BTreeMap::new();
    for entry in entries {
        image.follow(entry, &mut report.findings);
        for at in entry.operations(code) {
            let Ok(op) = decode(code, at) else { continue };
            for byte in op.at..op.end() {
                if *bytes.entry(byte).or_insert(at) != at {
                    let text = format!("overlaps the operation at {:04x}", bytes[&byte]);
                    report.findings.insert(Finding { at, text });
                }
            }
        }
    }
    report.bytes = bytes.len();
    report.operations = bytes.values().collect::<BTreeSet<_>>().len();
    report
}

impl Image<'_> {
    /// The row of what an operation calls.
    fn callee(&self, op: &Op) -> Option<Result<&'static Routine, u16>> {
        match op.kind {
            Kind::Routine(n) => Some(Ok(&ROUTINES[n])),
            Kind::Own(Own::Call) => {
                let at = op.operands[0];
                Some(self.rows.get(&at).copied().ok_or(at))
            }
            _ => None,
        }
    }

    /// Temporary bytes that a routine may write, but for those that are its result.
    fn clobbers(&self, row: &Routine) -> Scratch {
        let at = self.code.symbol(row.label).unwrap_or_default();
        let computed = self.writes.get(&at).copied().unwrap_or_default();
        row.writes.and(computed).less(row.leaves)
    }

    fn sum_writes(&mut self, entries: &[Entry]) {
        loop {
            let before = self.writes.clone();
            for entry in entries.iter().filter(|entry| matches!(entry.by, By::Row(_))) {
                let mut sum = Scratch::NONE;
                for at in entry.operations(self.code) {
                    let Ok(op) = decode(self.code, at) else { continue };
                    sum = sum.and(self.places.written(&op));
                    if let Some(Ok(row)) = self.callee(&op) {
                        sum = sum.and(self.clobbers(row)).and(row.leaves);
                    }
                }
                self.writes.insert(entry.at, sum);
            }
            if self.writes == before {
                return;
            }
        }
    }

    /// Follows a routine's paths until nothing new is learned.
    fn follow(&self, entry: &Entry, findings: &mut BTreeSet<Finding>) {
        let mut states = BTreeMap::from([(entry.at, State::at_entry(entry.by))]);
        let mut open = vec![entry.at];
        while let Some(at) = open.pop() {
            let state = states[&at];
            let Ok(op) = decode(self.code, at) else { continue };
            for (next, state) in self.after(&op, state, &mut |_| {}) {
                let met = states.get(&next).map_or(state, |there| there.meet(state));
                if states.insert(next, met) != Some(met) {
                    open.push(next);
                }
            }
        }
        for (&at, &state) in &states {
            let mut tell = |text: String| {
                findings.insert(Finding { at, text });
            };
            match decode(self.code, at) {
                Ok(op) => {
                    self.after(&op, state, &mut tell);
                    self.at_end(&op, state, entry.by, &mut tell);
                }
                Err(wrong) => tell(wrong.to_string()),
            }
        }
        self.ends(&states.into_keys().collect(), findings);
    }

    /// From each operation one that ends the routine can be reached.
    fn ends(&self, operations: &BTreeSet<u16>, findings: &mut BTreeSet<Finding>) {
        let mut good = BTreeSet::new();
        loop {
            let before = good.len();
            for &at in operations {
                let Ok(op) = decode(self.code, at) else { continue };
                let next = op.row().map_or(Next::On, |row| row.next);
                let ends = matches!(next, Next::Returns | Next::Instructions);
                let on = !ends && next != Next::Goto && good.contains(&op.end());
                if ends || on || op.targets.iter().any(|target| good.contains(target)) {
                    good.insert(at);
                }
            }
            if good.len() == before {
                break;
            }
        }
        for &at in operations.difference(&good) {
            findings.insert(Finding { at, text: "never ends".into() });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::isa::{FORMULA, FORMULAS, OWN, ROUTINES};

    /// A routine and the places of what it names.
    struct Small(Vec<u8>);

    const AT: u16 = 0x8001;

    impl Code for Small {
        fn byte(&self, at: u16) -> u8 {
            let offset = usize::from(at.wrapping_sub(AT));
            self.0.get(offset).copied().unwrap_or(0x7F)
        }
        fn symbol(&self, name: &str) -> Option<u16> {
            [("TEMP", 0x0280), ("BYTES", 0x0270), ("V2", 0x0260), ("LEFT", 0x0264)]
                .into_iter()
                .find_map(|(place, at)| (place == name).then_some(at))
        }
        fn places_end(&self, _: u16) -> Option<u16> {
            None
        }
    }

    fn number(name: &str) -> u8 {
        let names = ROUTINES.iter().map(|row| row.name).chain(OWN.iter().map(|row| row.name));
        names.into_iter().position(|it| it == name).expect("a name of the table") as u8
    }

    fn formula(name: &str, mode: u8, operand: u8) -> [u8; 2] {
        let n = FORMULAS.iter().position(|row| row.name == name).expect("a formula") as u8;
        [FORMULA | mode | n, operand]
    }

    /// What is wrong with a statement of these bytes and RETURN.
    fn wrong(code: &[u8]) -> Vec<String> {
        let code = Small([code, &[number("micro_return")]].concat());
        let entry = Entry { at: AT, by: By::Effect(0xC0, 0xC0) };
        verify(&code, &[entry]).findings.into_iter().map(|finding| finding.text).collect()
    }

    #[test]
    fn what_is_sound_passes() {
        let [get, cmpi, equal] = ["micro_get", "micro_cmpi", "micro_if_equal"].map(number);
        assert_eq!(wrong(&[get, 9, cmpi, 3, equal, 1]), Vec::<String>::new());
        let select = number("axis_select");
        let load = formula("load", crate::isa::AXIS, 0);
        assert_eq!(wrong(&[&[select][..], &load].concat()), Vec::<String>::new());
    }

    #[test]
    fn each_rule_refuses_what_breaks_it() {
        let [get, equal, goto] = ["micro_get", "micro_if_equal", "micro_goto"].map(number);
        let [new, settle, pop] = ["new", "settle_here", "pop_level"].map(number);
        let temp = 0x40;
        let cases: &[(&[u8], &str)] = &[
            (&[get, 9, equal, 1], "looks at Z, which says nothing here"),
            (&[new], "takes r13:r12, and r13 holds nothing"),
            (&formula("load", crate::isa::AXIS, 0), "wants an axis, and r8 is none"),
            (&formula("load", crate::isa::RECORD, 0), "wants a record, and r9 is none"),
            (&[settle], "wants an axis, and r8 is none"),
            (&formula("load", 0, temp), "reads a temporary byte that was not written (0xf)"),
            (&formula("store", crate::isa::NEW, 0), "this formula cannot have this operand"),
            (&[goto, 0xFF], "never ends"),
            (
                &[number("output"), number("zero"), number("fx_output")],
                "fx_output reads temporary bytes that were not written (0x4000)",
            ),
            (
                &[number("blocking"), pop, number("output_unit"), number("test_long")],
                "takes r12, which holds nothing",
            ),
        ];
        for (code, text) in cases {
            let found = wrong(code);
            assert!(found.iter().any(|found| found == text), "{code:x?}: {found:?}, not {text}");
        }
    }

    #[test]
    fn operations_do_not_overlap() {
        // Into the operand of what stands behind it, which is an operation, too.
        let [jump, literal, zero] = ["micro_if_not_equal", "micro_literal", "zero"].map(number);
        let found = wrong(&[jump, 2, literal, zero]);
        assert!(found.iter().any(|text| text.starts_with("overlaps")), "{found:?}");
    }
}
