//! The lock of a board's program and profile (lang's `wire` module, Lock).

use lang::record::BoardRecord;
use lang::wire::{self, Exception};

use super::{Client, ClientError};
use crate::link::Link;

/// The two words of a code: FNV-1a (Fowler, Noll, Vo) of its text, the low one never 0, which is
/// none.
pub fn words_of(code: &str) -> [u16; 2] {
    let hash = code
        .bytes()
        .fold(0x811C_9DC5_u32, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
    [(hash as u16).max(1), (hash >> 16) as u16]
}

impl<L: Link> Client<L> {
    /// Whether program and profile are locked: then the profile's version reads 0.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn is_locked(&mut self) -> Result<bool, ClientError> {
        Ok(self.holding(wire::PROFILE_WINDOW + 1, 1)? == [0])
    }

    /// Opens the lock until the next reset; nothing to do when there is none.
    ///
    /// # Errors
    /// [`ClientError::WrongCode`]; others when the exchange failed.
    pub fn unlock(&mut self, code: &str) -> Result<(), ClientError> {
        if !self.is_locked()? {
            return Ok(());
        }
        // Once: an open lock would take the second request for words of a new profile.
        let words = words_of(code);
        match self.once(|client| client.write_all(wire::LOCK_CODE, &words)) {
            Err(error) if error.is_exception(Exception::DeviceFailure) => {
                Err(ClientError::WrongCode)
            }
            // The reply may have been lost.
            Err(error) if error.may_be_done() && !self.is_locked()? => Ok(()),
            other => other,
        }
    }
}

impl<L: Link> Client<L> {
    /// Gives the board another lock code, or none (a low word of 0), and resets it: then it holds.
    ///
    /// # Errors
    /// See [`ClientError`]; [`ClientError::Locked`] while another one holds.
    pub fn set_lock(&mut self, code: [u16; 2]) -> Result<(), ClientError> {
        let held = self.board_record()?;
        let sequence = held.sequence.wrapping_add(1);
        let wanted = BoardRecord { lock: code, sequence, ..held }.sealed();
        self.set_board_record(&wanted)?;
        self.restart()
    }
}

#[cfg(test)]
mod tests {
    use super::words_of;

    #[test]
    fn words_are_fnv_1a_of_the_code() {
        // Test vector of the algorithm's authors: "foobar" is BF9CF968.
        assert_eq!(words_of("foobar"), [0xF968, 0xBF9C]);
        assert_ne!(words_of("")[0], 0);
    }
}
