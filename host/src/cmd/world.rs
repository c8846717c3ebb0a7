//! `--world`: the scenario around a simulated machine.

use super::console::Console;
use crate::failure::Failure;
use crate::input;
use crate::render::Note;
use crate::sim::world::{World, WorldError};

/// Reads the scenario, or gives `without`: a board that stays up has its switches where the profile
/// has them and people who press its buttons, a `sim` has nobody ([`World::unattended`]).
///
/// # Errors
/// It cannot be read or is no script; that was written.
pub fn load(file: Option<&str>, without: World, console: &Console) -> Result<World, Failure> {
    let Some(file) = file else { return Ok(without) };
    let text = input::read_text(file).map_err(|note| console.refuse(&note))?;
    World::parse(file, &text).map_err(|error| wrong(&error, console))
}

/// Writes what is wrong with a scenario.
pub fn wrong(error: &WorldError, console: &Console) -> Failure {
    let at = |n: usize| u32::try_from(n).unwrap_or(1).max(1);
    let place = (at(error.line), at(error.column));
    console.refuse(&Note::error(&error.file, error.code, error.text.clone()).at(place))
}
