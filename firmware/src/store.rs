//! The program store: images in flash segments, one of them current.
//!
//! A slot begins at a segment: commit word, spare word, image. The commit word is written last and
//! carries a sequence number, so of two committed slots the later one is current. A word that was cut
//! short may read well once and badly later, or the other way round: at the next reset it is written
//! again where it reads well, which settles it and is told by the spare word, before the older slot
//! is discarded; where it does not, the slot is discarded.
//!
//! The last two segments hold images that use no KEEP, or the KEEP values ([`crate::keep`]).

use lang::part;

/// Bytes of a flash segment.
pub const SEGMENT: u16 = part::SEGMENT as u16;
/// Bytes of a slot before its image.
pub const SLOT_HEAD: u16 = part::SLOT_HEAD as u16;

/// High byte of a commit word; the low byte is the sequence number.
const COMMITTED: u16 = 0xA500;
/// Spare word of a slot whose commit word was written twice.
const SETTLED: u16 = 0;
const ERASED: u16 = 0xFFFF;

/// Flash memory, addressed from the start of the program area.
pub trait Flash {
    /// Segments of the program area.
    const SEGMENTS: u8;
    /// The word at an even offset.
    fn read(&self, offset: u16) -> u16;
    /// Clears bits of the word at an even offset.
    fn write(&mut self, offset: u16, word: u16);
    /// Erases the segment that holds `offset`.
    fn erase(&mut self, offset: u16);
    /// Whether a sound image begins at `offset`; its length in bytes.
    fn image(&self, offset: u16) -> Option<u16>;
}

/// The store's state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Store {
    /// Offset of the current slot, [`Store::NONE`] without one.
    current: u16,
    /// Length of the current image, bytes.
    length: u16,
    /// Offset of the slot that an upload fills, [`Store::NONE`] without one.
    open: u16,
    /// Length announced for it.
    announced: u16,
    /// It may lie in any segment only if it uses no KEEP.
    keep: bool,
}

/// An upload was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Denied {
    /// No upload is open, or its length is none.
    NotBegun,
    /// It does not fit (beside the stored program).
    TooLong,
    /// The flash holds something else than was written.
    Flash,
    /// The image is not sound.
    Image,
}

/// Segments that an image of `length` bytes takes.
fn segments(length: u16) -> u8 {
    (length + SLOT_HEAD).div_ceil(SEGMENT) as u8
}

impl Store {
    const NONE: u16 = ERASED;

    /// An empty store.
    pub const fn new() -> Store {
        Store { current: Store::NONE, length: 0, open: Store::NONE, announced: 0, keep: false }
    }

    /// Finds the current program after a reset and discards an older one.
    pub fn mount<F: Flash>(&mut self, flash: &mut F) {
        *self = Store::new();
        let mut sequence = 0;
        let mut segment = 0;
        while segment < F::SEGMENTS {
            let offset = u16::from(segment) * SEGMENT;
            segment += 1;
            let Some(length) = flash.image(offset + SLOT_HEAD) else { continue };
            let commit = flash.read(offset);
            if commit & 0xFF00 != COMMITTED {
                flash.erase(offset);
                continue;
            }
            let mut older = offset;
            // Sequence numbers differ by one: the signed difference says which is later.
            if self.current == Store::NONE || (commit as u8).wrapping_sub(sequence) as i8 > 0 {
                older = self.current;
                self.current = offset;
                self.length = length;
                sequence = commit as u8;
                if flash.read(offset + 2) != SETTLED {
                    flash.write(offset, commit);
                    flash.write(offset + 2, SETTLED);
                }
            }
            if older != Store::NONE {
                flash.erase(older);
            }
        }
    }

    /// Offset of the current image.
    pub fn image(&self) -> Option<u16> {
        (self.current != Store::NONE).then(|| self.current + SLOT_HEAD)
    }

    /// Offset of the image that an upload fills.
    pub fn open_image(&self) -> Option<u16> {
        (self.open != Store::NONE).then(|| self.open + SLOT_HEAD)
    }

    /// Length of the current image, 0 without one.
    pub fn length(&self) -> u16 {
        self.length
    }

    /// The longest image, bytes.
    pub const fn area<F: Flash>() -> u16 {
        F::SEGMENTS as u16 * SEGMENT - SLOT_HEAD
    }

    /// The longest image that fits beside the current one, bytes.
    pub fn free<F: Flash>(&self) -> u16 {
        if self.current == Store::NONE {
            return Store::area::<F>();
        }
        let before = (self.current / SEGMENT) as u8;
        let behind = F::SEGMENTS - before - segments(self.length);
        let most = u16::from(before.max(behind)) * SEGMENT;
        most.saturating_sub(SLOT_HEAD)
    }

    /// Opens an upload of `length` bytes; `keep`: the image uses KEEP values. `replace` gives the
    /// current program up.
    ///
    /// # Errors
    /// The length is none or the image does not fit.
    pub fn begin<F: Flash>(
        &mut self,
        flash: &mut F,
        length: u16,
        keep: bool,
        replace: bool,
    ) -> Result<(), Denied> {
        self.open = Store::NONE;
        let limit = if keep { F::SEGMENTS - 2 } else { F::SEGMENTS };
        if length == 0 {
            return Err(Denied::NotBegun);
        }
        if length > Store::area::<F>() {
            return Err(Denied::TooLong);
        }
        let wanted = segments(length);
        if replace {
            self.discard(flash);
        }
        let mut first = 0;
        if self.current != Store::NONE {
            let start = (self.current / SEGMENT) as u8;
            if wanted > start {
                first = start + segments(self.length);
            }
        }
        if first + wanted > limit {
            return Err(Denied::TooLong);
        }
        let offset = u16::from(first) * SEGMENT;
        let mut at = 0;
        while at < wanted {
            flash.erase(offset + u16::from(at) * SEGMENT);
            at += 1;
        }
        self.open = offset;
        self.announced = length;
        self.keep = keep;
        Ok(())
    }

    /// Writes a word of the open image, at an even offset in it.
    ///
    /// # Errors
    /// No upload is open, the offset lies outside, or the word does not hold the value.
    pub fn write<F: Flash>(&mut self, flash: &mut F, at: u16, word: u16) -> Result<(), Denied> {
        if self.open == Store::NONE || at >= self.announced {
            return Err(Denied::NotBegun);
        }
        let offset = self.open + SLOT_HEAD + at;
        if flash.read(offset) == ERASED {
            flash.write(offset, word);
        }
        if flash.read(offset) == word { Ok(()) } else { Err(Denied::Flash) }
    }

    /// Checks the open image and makes it the current one.
    ///
    /// # Errors
    /// No upload is open or its image is not sound.
    pub fn commit<F: Flash>(&mut self, flash: &mut F) -> Result<(), Denied> {
        if self.open == Store::NONE {
            return Err(Denied::NotBegun);
        }
        match flash.image(self.open + SLOT_HEAD) {
            Some(length) if length == self.announced => {}
            _ => return Err(Denied::Image),
        }
        let mut sequence = 0;
        if self.current != Store::NONE {
            sequence = (flash.read(self.current) as u8).wrapping_add(1);
        }
        let word = COMMITTED | u16::from(sequence);
        flash.write(self.open, word);
        if flash.read(self.open) != word {
            return Err(Denied::Flash);
        }
        let older = self.current;
        self.current = self.open;
        self.length = self.announced;
        self.open = Store::NONE;
        if older != Store::NONE {
            flash.erase(older);
        }
        Ok(())
    }

    /// Gives the current program up.
    pub fn discard<F: Flash>(&mut self, flash: &mut F) {
        if self.current != Store::NONE {
            flash.erase(self.current);
        }
        self.current = Store::NONE;
        self.length = 0;
    }
}

#[cfg(test)]
pub(crate) mod tests;
