//! The program's flash: erased and written under requests, read back by its CRC.

use std::time::Duration;

use lang::image::crc_in;
use lang::record::feature;
use lang::wire::{self, Control, Upload};

use super::{Bench, Trouble};
use crate::client::{ClientError, Patience};
use crate::link::Link;

/// A program that takes some of the area.
const FILLER: &str = "DIM a\nREPEAT 3\n  a = a + 1\nEND REPEAT\nPRINT a\n";
/// Eight KEEP values that change all the while: a pause writes them, and each 14 such records fill a segment.
const KEEPER: &str = "KEEP a, b, c, d, e, f, g, h\nDO\n  a = a + 1\n  b = b + 1\n  c = c + 1\n  d = d + 1\n  e = e + 1\n  \
                      f = f + 1\n  g = g + 1\n  h = h + 1\n  Wait 2ms\nLOOP\n";
/// Pauses, which two erases and more fall to.
const PAUSES: u32 = 32;
/// From one order to the next: longer than a pause with an erase takes.
const PAUSING: Duration = Duration::from_millis(60);
/// Longest time to the answer of an erase of the whole area (`wire`, Upload).
const ERASE: Duration = Duration::from_millis(250);
/// Erases that are looked at before one counts as too slow.
const TRIES: u32 = 5;
/// An answer to an erase that comes later than this is lost: a virtual board on a busy computer takes longer than it
/// should.
const LATE: Patience = Patience { reply: Duration::from_secs(3), attempts: 4 };

impl<L: Link> Bench<'_, L> {
    pub(super) fn store(&mut self) -> Result<(), Trouble> {
        // The board takes at most as long as the link's clock says, which a busy computer lets run on: the quickest of
        // some counts.
        let (mut erased, mut took) = self.erase_once()?;
        for _ in 1..TRIES {
            if erased.is_ok() && took <= ERASE {
                break;
            }
            (erased, took) = self.erase_once()?;
        }
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

    /// Erases a stored program, once: an answer that is lost must be seen. The answer, and how long it took.
    fn erase_once(&mut self) -> Result<(Result<(), ClientError>, Duration), Trouble> {
        self.program(FILLER)?;
        self.board.write(wire::UPLOAD_LENGTH, 2)?;
        let usual = self.board.set_patience(LATE);
        let asked = self.board.link().now();
        let erased =
            self.board.once(|board| board.write(wire::UPLOAD_CONTROL, Upload::Replace as u16));
        let took = self.board.link().now() - asked;
        self.board.set_patience(usual);
        Ok((erased, took))
    }

    /// Requests all the while KEEP values are written, and segments erased for them: none may be lost.
    pub(super) fn erase_under_requests(&mut self) -> Result<(), Trouble> {
        const CHECK: &str = "requests while flash is erased";
        if self.part.lacks_feature(feature::STREAM) {
            self.left_out(CHECK, "this chip stands still meanwhile");
            return Ok(());
        }
        self.program(KEEPER)?;
        self.board.control(Control::Start)?;
        let (mut asked, mut lost) = (0, 0);
        for _ in 0..PAUSES {
            for control in [Control::Pause, Control::Resume] {
                // An order that an erase swallows is given again: both may come twice.
                self.board.write(wire::RUN_CONTROL, control as u16)?;
                let until = self.board.link().now() + PAUSING;
                while self.board.link().now() < until {
                    asked += 1;
                    match self.board.once(|board| board.run_state()) {
                        Ok(_) => {}
                        Err(error) if error.may_be_done() => lost += 1,
                        Err(error) => return Err(error.into()),
                    }
                }
            }
        }
        self.board.control(Control::Stop)?;
        self.at_rest()?;
        let found = format!("{lost} of {asked} lost");
        self.row(CHECK, "none lost", found, lost == 0);
        Ok(())
    }
}
