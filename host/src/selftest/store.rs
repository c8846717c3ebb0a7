//! The program's flash: erased and written under requests, read back by its CRC.

use std::time::Duration;

use lang::image::crc_in;
use lang::wire::{self, Upload};

use super::{Bench, Trouble};
use crate::client::ClientError;
use crate::link::Link;

/// A program that takes some of the area.
const FILLER: &str = "DIM a\nREPEAT 3\n  a = a + 1\nEND REPEAT\nPRINT a\n";
/// Longest time to the answer of an erase of the whole area (`wire`, Upload).
const ERASE: Duration = Duration::from_millis(250);

impl<L: Link> Bench<'_, L> {
    pub(super) fn store(&mut self) -> Result<(), Trouble> {
        self.program(FILLER)?;
        self.board.write(wire::UPLOAD_LENGTH, 2)?;
        let asked = self.board.link().now();
        // Once: an answer that is lost must be seen.
        let erased =
            self.board.once(|board| board.write(wire::UPLOAD_CONTROL, Upload::Replace as u16));
        let took = self.board.link().now() - asked;
        let expected = format!("an answer within {} ms", ERASE.as_millis());
        let found = match &erased {
            Ok(()) => format!("{} ms", took.as_millis()),
            Err(error) => error.to_string(),
        };
        self.row("erase of the program area", expected, found, erased.is_ok() && took <= ERASE);
        if let Err(error @ ClientError::Port(_)) = erased {
            return Err(error.into());
        }
        let image = self.program(FILLER)?;
        let held = self.board.identity()?;
        let crc = crc_in(&image);
        let same = usize::from(held.program_bytes) == image.len() && held.program_crc == crc;
        self.row(
            "program as it was sent",
            format!("{} bytes, CRC {crc:04X}", image.len()),
            format!("{} bytes, CRC {:04X}", held.program_bytes, held.program_crc),
            same,
        );
        Ok(())
    }
}
