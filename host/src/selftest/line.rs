//! The link at each rate, and the board's own counters behind all of it.

use lang::profile::Parity;
use lang::record::BoardRecord;
use lang::wire;

use super::{Bench, Trouble};
use crate::link::{Link, Mode};

/// Rates and parities by their numbers in the record.
const MODES: [(u8, u32, Parity); 6] = [
    (0x00, 9_600, Parity::None),
    (0x01, 19_200, Parity::None),
    (0x02, 57_600, Parity::None),
    (0x13, 115_200, Parity::Even),
    (0x23, 115_200, Parity::Odd),
    (0x03, 115_200, Parity::None),
];
/// Requests at each.
const REQUESTS: u32 = 40;

impl<L: Link> Bench<'_, L> {
    pub(super) fn rates(&mut self) -> Result<(), Trouble> {
        if !self.plan.rates {
            self.left_out("link at each rate", "this port has no rate of its own");
            return Ok(());
        }
        for (number, rate, parity) in MODES {
            self.set_record(BoardRecord { rate: number, ..self.record })?;
            let mode = Mode { rate, parity };
            let found = self.board.mode();
            let mut good = 0;
            for _ in 0..REQUESTS {
                let answered = self.board.once(|board| board.holding(wire::OWN, 15)).is_ok();
                good += u32::from(answered);
            }
            let check = format!("link at {mode}");
            let expected = format!("{REQUESTS} of {REQUESTS} answered at once");
            let at = if found == mode { String::new() } else { format!(", at {found}") };
            let found_all = good == REQUESTS && at.is_empty();
            self.row(check, expected, format!("{good} of {REQUESTS}{at}"), found_all);
        }
        Ok(())
    }

    /// What the board has counted meanwhile.
    pub(super) fn health(&mut self) -> Result<(), Trouble> {
        let stack = self.board.identity()?.stack_free;
        self.row("stack never used", "some", format!("{stack} bytes"), stack > 0);
        Ok(())
    }
}
