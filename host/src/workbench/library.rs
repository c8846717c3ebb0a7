//! The programs that the board holds, on the page.

use serde_json::{Value, json};

use crate::client::ClientError;
use crate::helm::Board;
use lang::wire::{self, Exception};

/// The programs, the one that Start runs, and the bytes that fit beside them; null for a board with one program.
///
/// # Errors
/// The board does not answer.
pub fn list(board: &mut Board) -> Result<Option<Value>, String> {
    let words = |error: ClientError| error.to_string();
    let Some(library) = board.library().map_err(words)? else { return Ok(Some(Value::Null)) };
    let free = board.identity().map_err(words)?.free_bytes;
    let (programs, selected) = (library.entries, library.selected);
    Ok(Some(json!({ "programs": programs, "selected": selected, "free": free })))
}

/// From now on Start runs this one.
///
/// # Errors
/// There is none of that number, or one runs.
pub fn select(board: &mut Board, number: u8) -> Result<Option<Value>, String> {
    board.select(number).map_err(|error| match error {
        error if error.is_exception(Exception::Busy) => {
            "a program runs or an axis moves: stop it first".to_owned()
        }
        error if error.is_exception(Exception::IllegalValue) => {
            format!("the board has no program {number} any more")
        }
        error => error.to_string(),
    })?;
    list(board)
}

/// Erases one.
///
/// # Errors
/// Something runs, or program and profile are locked.
pub fn erase(board: &mut Board, number: u8) -> Result<Option<Value>, String> {
    let number = u16::from(number);
    board.write(wire::UPLOAD_NUMBER, number).map_err(|error| error.to_string())?;
    board.erase().map_err(|error| error.to_string())?;
    list(board)
}
