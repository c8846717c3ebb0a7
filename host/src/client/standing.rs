//! The place in a program at which trace mode has halted it.

use lang::record::feature;
use lang::wire;

use super::{Client, ClientError};
use crate::link::Link;

/// An open call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Call {
    /// How the routine was entered ([`lang::vm::entry`]).
    pub kind: u8,
    /// Where in the code it goes back to, or of an error handler what failed.
    pub address: u16,
}

/// What [`wire::WAITS`] and the registers behind it show.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Standing {
    /// The program waits with its next effect for whoever takes the events.
    pub waits: bool,
    /// Where in the code that effect is, or the one under way.
    pub place: u16,
    /// Open calls, the newest first.
    pub calls: Vec<Call>,
}

/// Calls that a board may have open.
const MOST_CALLS: u16 = 16;

impl<L: Link> Client<L> {
    /// Where the program stands, in one exchange. Of use on parts whose
    /// [`halts`](lang::part::Part::halts) are exact; on others all of it is 0.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn standing(&mut self) -> Result<Standing, ClientError> {
        // Boards with room for long programs have a word for each of the two.
        let large = self.holding(wire::FEATURES, 1)?[0] & feature::LIBRARY != 0;
        let entry = if large { 2 } else { 1 };
        let count = wire::OPEN_CALLS + entry * MOST_CALLS - wire::WAITS;
        let words = self.holding(wire::WAITS, count)?;
        let at = |register: u16| usize::from(register - wire::WAITS);
        let entries = words[at(wire::OPEN_CALLS)..].chunks(entry.into());
        // No call goes back to the start of the code.
        let open = entries.take_while(|entry| entry[0] != 0);
        let call = |entry: &[u16]| match *entry {
            [address, kind, ..] => Call { kind: (kind >> 12) as u8, address },
            [packed] => Call { kind: (packed >> 12) as u8, address: packed & 0x0FFF },
            [] => Call { kind: 0, address: 0 },
        };
        let mut calls: Vec<Call> = open.map(call).collect();
        calls.reverse();
        Ok(Standing { waits: words[0] != 0, place: words[at(wire::EFFECT_PLACE)], calls })
    }
}
