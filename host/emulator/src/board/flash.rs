//! The board's flash seen from outside: content, wear, and cuts of power while it is written.

use super::Board;
use super::chip::with;
use crate::periph::flash::Wear;
use crate::rng::Rng;

impl Board {
    /// Lets power fail during a flash operation: the first from now has number 1. A write leaves each
    /// of its bits done or not, an erase leaves a half erased segment, both as `seed` decides; so
    /// does what unstable bits read as at later power-ups.
    pub fn cut_at_flash_operation(&mut self, number: u64, seed: u64) {
        with!(&mut self.chip, c => {
            c.bus.flash.cut = Some((c.bus.flash.wear.operations + number, seed));
        });
        self.noise = Rng::new(seed);
    }

    /// Asks `run_until` to return after each flash operation. With a clone of the board between two
    /// of them, every cut of a long run can be tried without repeating what led to it.
    pub fn stop_at_flash(&mut self, on: bool) {
        self.stop_at_flash = on;
        with!(&mut self.chip, c => c.bus.flash_written = false);
    }

    /// Erase counts of the segments and the number of flash operations so far.
    #[must_use]
    pub fn wear(&self) -> &Wear {
        with!(&self.chip, c => &c.bus.flash.wear)
    }

    /// Information memory and main flash, lowest address first: what survives power-off.
    #[must_use]
    pub fn flash_contents(&self) -> Vec<u8> {
        let (info, main) = self.flash_ranges();
        let memory = with!(&self.chip, c => c.bus.memory());
        [&memory[info], &memory[main]].concat()
    }

    /// Puts back what `flash_contents` gave.
    ///
    /// # Errors
    /// When the length is not that of the part's flash.
    pub fn set_flash_contents(&mut self, content: &[u8]) -> Result<(), FlashSize> {
        let (info, main) = self.flash_ranges();
        let want = info.len() + main.len();
        if content.len() != want {
            return Err(FlashSize { want, got: content.len() });
        }
        let (a, b) = content.split_at(info.len());
        let memory = with!(&mut self.chip, c => c.bus.memory_mut());
        memory[info].copy_from_slice(a);
        memory[main].copy_from_slice(b);
        Ok(())
    }

    fn flash_ranges(&self) -> (std::ops::Range<usize>, std::ops::Range<usize>) {
        let part = self.part();
        let range = |r: &std::ops::RangeInclusive<u32>| *r.start() as usize..*r.end() as usize + 1;
        (range(&part.info), range(&part.flash))
    }
}

/// Flash content of the wrong length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FlashSize {
    /// Bytes that the part has.
    pub want: usize,
    /// Bytes that were given.
    pub got: usize,
}

impl std::fmt::Display for FlashSize {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "flash content of {} bytes, but the part has {}", self.got, self.want)
    }
}

impl std::error::Error for FlashSize {}
