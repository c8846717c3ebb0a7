//! Outputs and inputs: a bit that walks through the outputs, and back through wires from each to the input
//! of its number.

use std::time::Duration;

use lang::record::BoardRecord;
use lang::wire;

use super::{Bench, Trouble};
use crate::link::Link;

/// Until an input has come through its filter, and the chain through its rounds.
const SETTLE: Duration = Duration::from_millis(60);

impl<L: Link> Bench<'_, L> {
    fn outputs(&self) -> u16 {
        if self.record.flags & BoardRecord::CHAIN != 0 { 16 } else { 2 }
    }

    pub(super) fn contacts(&mut self) -> Result<(), Trouble> {
        if !self.plan.unplugged {
            self.left_out("outputs", "--unplugged says that nothing hangs on them");
            self.left_out("inputs", "--unplugged and --jumpers");
            return Ok(());
        }
        let count = self.outputs();
        let rest = self.board.inputs(wire::INPUT_BITS, 17)?;
        let (mut wrong, mut broken) = (Vec::new(), Vec::new());
        for n in 0..count {
            self.board.set_coil(wire::COILS + n, true)?;
            self.board.link().pause(SETTLE);
            let on = self.board.coils(wire::COILS, count)?;
            let alone = (0..).zip(&on).all(|(at, on)| *on == (at == n));
            if !alone {
                wrong.push(n + 1);
            }
            let seen = self.board.inputs(wire::INPUT_BITS, 17)?;
            let changed: Vec<usize> = (1..)
                .zip(seen.iter().zip(&rest))
                .filter(|(_, (now, before))| now != before)
                .map(|(number, _)| number)
                .collect();
            if changed != [usize::from(n) + 1] {
                broken.push(format!("output {} changes {}", n + 1, list(&changed)));
            }
            self.board.set_coil(wire::COILS + n, false)?;
            self.board.link().pause(SETTLE);
        }
        let found =
            if wrong.is_empty() { "it does".to_owned() } else { format!("not at {wrong:?}") };
        self.row(
            format!("a bit walks through {count} outputs"),
            "it does",
            found,
            wrong.is_empty(),
        );
        if !self.plan.jumpers {
            self.left_out("inputs", "--jumpers says that each output is wired to its input");
            return Ok(());
        }
        let found = if broken.is_empty() { "it does".to_owned() } else { broken.join("; ") };
        let check = format!("it comes back through {count} wires");
        self.row(check, "each output changes its input alone", found, broken.is_empty());
        let after = self.board.inputs(wire::INPUT_BITS, 17)?;
        self.row(
            "inputs are as before",
            "no change",
            if after == rest { "no change" } else { "changed" },
            after == rest,
        );
        self.outputs_after_reset(&rest)
    }

    /// Outputs that were on are off behind a reset, but for that which the profile switches on there.
    fn outputs_after_reset(&mut self, rest: &[bool]) -> Result<(), Trouble> {
        let count = self.outputs();
        let usual = self.record;
        let mut wrong = Vec::new();
        for kept in [0u16, 1, 2] {
            for n in 0..count {
                self.board.set_coil(wire::COILS + n, true)?;
            }
            let reset_on = (1 << kept) >> 1;
            self.set_record(BoardRecord { reset_on, sequence: self.record.sequence, ..usual })?;
            self.board.link().pause(SETTLE);
            let seen = self.board.inputs(wire::INPUT_BITS, 17)?;
            for n in 0..usize::from(count) {
                let on = reset_on >> n & 1 != 0;
                if (seen[n] != rest[n]) != on {
                    wrong.push(n + 1);
                }
            }
        }
        self.set_record(BoardRecord { sequence: self.record.sequence, ..usual })?;
        wrong.sort_unstable();
        wrong.dedup();
        let found =
            if wrong.is_empty() { "they are".to_owned() } else { format!("not {}", list(&wrong)) };
        self.row("outputs behind a reset", "as the profile says", found, wrong.is_empty());
        Ok(())
    }
}

fn list(numbers: &[usize]) -> String {
    match numbers {
        [] => "nothing".to_owned(),
        _ => format!("{numbers:?}"),
    }
}
