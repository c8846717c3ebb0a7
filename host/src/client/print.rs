//! PRINT output over the link (lang's `wire` module, Print).

use lang::wire;

use super::{Client, ClientError};
use crate::link::Link;

/// Bytes of the window.
const WINDOW: u16 = 32;

/// Ends a printed line.
pub const LINE_END: u8 = b'\n';

impl<L: Link> Client<L> {
    /// Takes the bytes that wait, at most 32 of them.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn take_print(&mut self) -> Result<Vec<u8>, ClientError> {
        self.take(false)
    }

    /// Takes the bytes that wait up to the first line's end, at most 32 of them: in trace mode the
    /// next line belongs to the next event.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn take_print_line(&mut self) -> Result<Vec<u8>, ClientError> {
        self.take(true)
    }

    /// Drops the bytes that wait, as those of a line that the end of a run cut short.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn drop_print(&mut self) -> Result<(), ClientError> {
        let words = self.holding(wire::PRINT_COUNT, 2)?;
        self.write(wire::PRINT_TAIL, words[1].wrapping_add(words[0]))
    }

    fn take(&mut self, one_line: bool) -> Result<Vec<u8>, ClientError> {
        let words = self.holding(wire::PRINT_COUNT, 2 + WINDOW / 2)?;
        let (count, tail) = (words[0].min(WINDOW), words[1]);
        if count == 0 {
            return Ok(Vec::new());
        }
        let bytes = words[2..].iter().flat_map(|word| word.to_be_bytes());
        let mut bytes: Vec<u8> = bytes.take(usize::from(count)).collect();
        if one_line && let Some(end) = bytes.iter().position(|byte| *byte == LINE_END) {
            bytes.truncate(end + 1);
        }
        // Writing the same number again takes nothing more, so a lost reply does no harm.
        self.write(wire::PRINT_TAIL, tail.wrapping_add(bytes.len() as u16))?;
        Ok(bytes)
    }
}
