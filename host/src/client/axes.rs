//! The axes of a board: those of its stored program, which it uses for commanded lines and homing.

use std::fmt;

use lang::profile::{BUILT_IN, DEFAULT_NAME, Profile};
use lang::record::MachineRecord;
use lang::wire::{self, Exception};

use super::{Client, ClientError};
use crate::link::Link;

/// What a board tells of its axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axes {
    /// It holds no program, and so no axes.
    None,
    /// These.
    Known(MachineRecord),
    /// Some with this hash: the board does not tell more, or a lock hides it.
    Hash(u16),
}

impl Axes {
    /// The machine that they are of, without what the board's record tells; `None` where that is not known.
    pub fn profile(&self) -> Option<Profile> {
        let hash = match self {
            Axes::None => return None,
            Axes::Known(record) => record.hash(),
            Axes::Hash(hash) => *hash,
        };
        let built_in = BUILT_IN.iter().filter_map(|(name, _)| Profile::built_in(name).ok());
        let mut known = built_in.filter(|profile| MachineRecord::of(profile).hash() == hash);
        known.next().or_else(|| {
            let Axes::Known(record) = self else { return None };
            let mut base = Profile::built_in(DEFAULT_NAME).ok()?;
            // Names are nobody's.
            base.name = "the board's".to_owned();
            (base.inputs, base.outputs) = (Vec::new(), Vec::new());
            Some(record.into_profile(&base))
        })
    }
}

impl fmt::Display for Axes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Axes::None => "the board holds no program, and so no axes",
            Axes::Known(_) => "the board tells its axes",
            Axes::Hash(_) => "the board does not tell the axes of its program",
        })
    }
}

impl<L: Link> Client<L> {
    /// The axes of the program that the board would run.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn axes(&mut self) -> Result<Axes, ClientError> {
        if self.identity()?.program_bytes == 0 {
            return Ok(Axes::None);
        }
        let hash = self.holding(wire::PROGRAM_PROFILE, 1)?[0];
        let words = match self.holding(wire::STREAM_MACHINE, (MachineRecord::SIZE / 2) as u16) {
            Ok(words) => words,
            Err(error) if error.is_exception(Exception::IllegalAddress) => {
                return Ok(Axes::Hash(hash));
            }
            Err(error) => return Err(error),
        };
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let record =
            bytes.first_chunk().map(|bytes| MachineRecord::from_bytes(bytes).without_program());
        // A lock hides it, and an older firmware does not tell it: then words are 0.
        Ok(record.filter(|record| record.hash() == hash).map_or(Axes::Hash(hash), Axes::Known))
    }
}
