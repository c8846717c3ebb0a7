//! The client that moves a board's axes by a command that lasts as long as the client polls.
//!
//! The board ends such a motion 2 s after the last request on its line. Where several clients share the line the board cannot
//! know whose request that was: the gateway, or the virtual board's TCP port, watches the client that moves.

use std::time::Duration;

use lang::wire::{self, Direct, command};

/// Such a motion ends so long after its client's last request, as on the board.
const SILENCE: Duration = Duration::from_millis(2_000);

/// The request that ends it: function 16 with command 1200 and 133. In a run and in a homing it does nothing.
pub const END_JOG: [u8; 10] = {
    let [at, low] = wire::COMMAND.to_be_bytes();
    let [high, own] = command::DIRECT.to_be_bytes();
    [16, at, low, 0, 2, 4, high, own, 0, Direct::StopJog as u8]
};

/// Of one board.
#[derive(Clone, Debug, Default)]
pub struct Mover {
    /// The clients, and when each asked last.
    own: Vec<(u64, Duration)>,
}

/// Whether a request begins such a motion.
fn moves(pdu: &[u8]) -> bool {
    let word = |at: usize| pdu.get(at..at + 2).map(|pair| u16::from_be_bytes([pair[0], pair[1]]));
    let code = match pdu.first() {
        Some(6) => word(3),
        Some(16) => word(6),
        _ => None,
    };
    word(1) == Some(wire::COMMAND) && matches!(code, Some(command::MOVE_SPEED | command::JOG))
}

impl Mover {
    /// A client asks the board at `now`.
    pub fn asks(&mut self, client: u64, pdu: &[u8], now: Duration) {
        match self.own.iter_mut().find(|(own, _)| *own == client) {
            Some((_, heard)) => *heard = now,
            None if moves(pdu) => self.own.push((client, now)),
            None => {}
        }
    }

    /// When the motion is to be ended, unless its client asks again. The board's command ends the motion of all axes, so the
    /// first client that falls silent ends that of the others, too.
    pub fn until(&self) -> Option<Duration> {
        self.own.iter().map(|(_, heard)| *heard + SILENCE).min()
    }

    /// Whether that has come. It comes once.
    pub fn ends(&mut self, now: Duration) -> bool {
        let over = self.until().is_some_and(|until| now >= until);
        if over {
            self.own.clear();
        }
        over
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const READ: [u8; 5] = [3, 0x13, 0x88, 0, 1];
    const RUN: [u8; 14] = [16, 0x07, 0xD0, 0, 4, 8, 0, 102, 0, 1, 0x4E, 0x20, 0, 0];

    fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    #[test]
    fn it_ends_two_seconds_behind_the_last_request_of_who_moves() {
        assert_eq!(END_JOG, [16, 0x07, 0xD0, 0, 2, 4, 0x04, 0xB0, 0, 133]);
        let mut own = Mover::default();
        own.asks(1, &READ, ms(0));
        assert_eq!(own.until(), None);
        own.asks(1, &RUN, ms(0));
        own.asks(2, &READ, ms(1_500));
        let mut over = own.clone();
        assert!(!own.ends(ms(1_999)) && over.ends(ms(2_000)));
        own.asks(1, &READ, ms(1_999));
        assert!(!own.ends(ms(3_998)));
        // Another one moves, too: whoever of the two falls silent ends it.
        own.asks(2, &[6, 0x07, 0xD0, 0x04, 0x57], ms(3_998));
        let mut first = own.clone();
        first.asks(2, &READ, ms(3_999));
        assert!(!first.ends(ms(3_998)) && first.ends(ms(3_999)) && !first.ends(ms(9_000)));
        own.asks(1, &READ, ms(5_000));
        assert!(own.ends(ms(5_998)) && !own.ends(ms(9_000)));
        // A move of a known length goes on to its end.
        own.asks(1, &[6, 0x07, 0xD0, 0, 103], ms(6_000));
        assert_eq!(own.until(), None);
    }
}
