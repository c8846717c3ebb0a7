//! The link at each rate, and the board's own error counters after all of it.

use lang::profile::Parity;
use lang::record::BoardRecord;
use lang::wire;

use super::{Bench, Trouble};
use crate::client::ClientError;
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
/// Long requests, and words that each writes: 9 bytes are around them.
const LONG_REQUESTS: u32 = 100;
const LONG_WORDS: usize = 63;
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

    /// Requests as long as the pieces of a streamed job: an adapter that pauses between its packets tears them apart, and
    /// the board answers a torn one with silence.
    pub(super) fn long_requests(&mut self) -> Result<(), Trouble> {
        const CHECK: &str = "requests of 135 bytes";
        if !self.has_crystal() {
            self.left_out(CHECK, "this chip takes none of that length");
            return Ok(());
        }
        let mut lost = 0;
        for _ in 0..LONG_REQUESTS {
            // No stream is open: a refusal is an answer as good as any.
            let answer =
                self.board.once(|board| board.write_all(wire::STREAM_PIECE, &[0; LONG_WORDS]));
            match answer {
                Err(error) if error.may_be_done() => lost += 1,
                Ok(()) | Err(ClientError::Exception(_)) => {}
                Err(error) => return Err(error.into()),
            }
        }
        self.row(CHECK, "none lost", format!("{lost} of {LONG_REQUESTS} lost"), lost == 0);
        Ok(())
    }

    /// What the board has counted meanwhile.
    pub(super) fn health(&mut self) -> Result<(), Trouble> {
        let stack = self.board.identity()?.stack_free;
        self.row("stack never used", "some", format!("{stack} bytes"), stack > 0);
        Ok(())
    }
}
