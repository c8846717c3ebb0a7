//! Opens a line, and finds the rate and parity at which its boards answer.

use std::time::Duration;

use super::line::Board;
use crate::client::{Client, ClientError, Patience};
use crate::link::{self, Mode};

/// Wait for a reply while modes are tried.
const TRYING: Duration = Duration::from_millis(150);

/// Opens a port. Without a mode each is tried until one of the boards answers; when none does the
/// line is open all the same, for boards that come later.
///
/// # Errors
/// The port cannot be opened; in words.
pub fn open(port: &str, addresses: &[u8], mode: Option<Mode>) -> Result<Board, String> {
    let words = |error: ClientError| format!("{port}: {error}");
    let mut board = Client::new(link::open(port)?, 1);
    if let Some(mode) = mode {
        board.set_mode(mode).map_err(words)?;
        return Ok(board);
    }
    if !board.set_mode(Mode::DEFAULT).map_err(words)? {
        return Ok(board);
    }
    board.set_patience(Patience { reply: TRYING, attempts: 1 });
    for mode in Mode::all() {
        board.set_mode(mode).map_err(words)?;
        for address in addresses {
            board.set_address(*address);
            match board.holding(lang::wire::VERSION, 1) {
                Ok(_) | Err(ClientError::Exception(_)) => return Ok(board),
                Err(error @ ClientError::Port(_)) => return Err(words(error)),
                Err(_) => {}
            }
        }
    }
    board.set_mode(Mode::DEFAULT).map_err(words)?;
    Ok(board)
}
