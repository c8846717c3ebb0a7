//! The program store: images in flash segments.
//!
//! A slot begins at a segment: commit word, spare word, on parts with a library the program's name, image. The
//! commit word is written last and carries a sequence number; of two committed slots of one
//! program the later one counts. A commit word whose write was cut short may read right once and wrong later, or the
//! other way round. At the next reset it is written again if it reads right, and the spare word records that,
//! before the older slot is discarded; if it reads wrong, the slot is discarded.
//!
//! A part with one program uses the last two segments for images without KEEP, or for the KEEP values
//! ([`crate::keep`]). In a library each slot of a program with KEEP ends with two segments for its values.

use lang::part;

/// Bytes of a flash segment.
pub const SEGMENT: u16 = part::SEGMENT as u16;
/// Registers, and words of a slot's head, that hold a program's name.
pub const NAME: usize = part::NAME / 2;
/// Segments that hold a program's KEEP values.
pub const KEEP_SEGMENTS: u8 = 2;
/// Programs of the largest library.
const MOST: usize = part::F5529.programs as usize;

/// Segments that the beginning of an upload erases: at most 200 ms, which the host waits. The others of a library are
/// erased while the next request arrives.
const fn at_once(programs: u8) -> u8 {
    if programs > 1 { 1 } else { 6 }
}

/// High byte of a commit word; the low byte is the sequence number.
const COMMITTED: u16 = 0xA500;
/// Spare word of a slot whose commit word was written twice.
const SETTLED: u16 = 0;
const ERASED: u16 = 0xFFFF;
/// Offset in a slot's head of the program's number and, in the high byte, the segments of the slot.
const NUMBER_AT: u16 = 4;
/// Offset of the name.
const NAME_AT: u16 = 6;

/// Flash memory, addressed from the start of the program area.
pub trait Flash {
    /// Segments of the program area.
    const SEGMENTS: u8;
    /// Programs that it holds.
    const PROGRAMS: u8 = 1;
    /// Bytes of a slot before its image.
    const HEAD: u16 = part::slot_head(Self::PROGRAMS) as u16;
    /// The word at an even offset.
    fn read(&self, offset: u16) -> u16;
    /// Clears bits of the word at an even offset.
    fn write(&mut self, offset: u16, word: u16);
    /// Erases the segment that holds `offset`.
    fn erase(&mut self, offset: u16);
    /// Whether a sound image begins at `offset`; its length in bytes.
    fn image(&self, offset: u16) -> Option<u16>;
    /// What the image at `offset` says is its length in bytes.
    fn length(&self, offset: u16) -> u16;
}

/// What an upload brings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Upload {
    /// The program that it replaces, or the first one's place, from 1.
    pub number: u8,
    /// Bytes of its image.
    pub length: u16,
    /// The image uses KEEP values.
    pub keeps: bool,
}

/// The store's state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Store {
    /// First segment of each program's slot, [`Store::NONE`] without one.
    slots: [u8; MOST],
    /// Number of the program that runs next, or ran last; 0 for none.
    current: u8,
    /// First segment of the slot that an upload fills, [`Store::NONE`] without one.
    open: u8,
    /// Segments of the open slot that are erased; the others are when their first word is written.
    erased: u8,
    /// What fills it.
    upload: Upload,
    /// The last upload was committed, and nothing was begun or given up since.
    committed: bool,
}

/// An upload was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Denied {
    /// No upload is open, or its length is none.
    NotBegun,
    /// It does not fit (beside the stored programs).
    TooLong,
    /// The flash holds something else than was written.
    Flash,
    /// The image is not sound.
    Image,
}

/// Bytes of a set of segments of the largest part.
const MAP: usize = (part::F5529.segments as usize).div_ceil(8);

/// Segments, a bit each.
struct Segments([u8; MAP]);

impl Segments {
    fn set(&mut self, segment: u8) {
        if let Some(byte) = self.0.get_mut(usize::from(segment >> 3)) {
            *byte |= 1 << (segment & 7);
        }
    }

    fn has(&self, segment: u8) -> bool {
        self.0.get(usize::from(segment >> 3)).is_some_and(|byte| byte >> (segment & 7) & 1 != 0)
    }
}

/// Segments that an image of `length` bytes takes.
fn segments<F: Flash>(length: u16) -> u8 {
    (length + F::HEAD).div_ceil(SEGMENT) as u8
}

const fn at(segment: u8) -> u16 {
    segment as u16 * SEGMENT
}

impl Store {
    const NONE: u8 = 0xFF;

    /// An empty store.
    pub const fn new() -> Store {
        let upload = Upload { number: 1, length: 0, keeps: false };
        Store {
            slots: [Store::NONE; MOST],
            current: 0,
            open: Store::NONE,
            erased: 0,
            upload,
            committed: false,
        }
    }

    fn slot(&self, number: u8) -> u8 {
        self.slots.get(usize::from(number.wrapping_sub(1))).copied().unwrap_or(Store::NONE)
    }

    fn set_slot(&mut self, number: u8, segment: u8) {
        if let Some(slot) = self.slots.get_mut(usize::from(number.wrapping_sub(1))) {
            *slot = segment;
        }
    }

    /// Number of the program in a slot, none of its business when it is no such number.
    fn number_in<F: Flash>(flash: &F, segment: u8) -> u8 {
        if F::PROGRAMS == 1 { 1 } else { flash.read(at(segment) + NUMBER_AT) as u8 }
    }

    /// Segments of a program's slot.
    fn size<F: Flash>(flash: &F, segment: u8) -> u8 {
        if F::PROGRAMS == 1 {
            segments::<F>(flash.length(at(segment) + F::HEAD))
        } else {
            (flash.read(at(segment) + NUMBER_AT) >> 8) as u8
        }
    }

    /// Finds the programs after a reset and discards older ones of the same number. The only one is the
    /// current one.
    pub fn mount<F: Flash>(&mut self, flash: &mut F) {
        *self = Store::new();
        let mut segment = 0;
        while segment < F::SEGMENTS {
            let here = segment;
            segment += 1;
            if flash.image(at(here) + F::HEAD).is_none() {
                continue;
            }
            let commit = flash.read(at(here));
            let number = Store::number_in(flash, here);
            if commit & 0xFF00 != COMMITTED || !(1..=F::PROGRAMS).contains(&number) {
                flash.erase(at(here));
                continue;
            }
            let other = self.slot(number);
            let mut older = here;
            // Sequence numbers differ by one: the signed difference says which is later.
            if other == Store::NONE
                || (commit as u8).wrapping_sub(flash.read(at(other)) as u8) as i8 > 0
            {
                older = other;
                self.set_slot(number, here);
                if flash.read(at(here) + 2) != SETTLED {
                    flash.write(at(here), commit);
                    flash.write(at(here) + 2, SETTLED);
                }
                if F::PROGRAMS > 1 {
                    segment = here + Store::size(flash, here).max(1);
                }
            }
            if older != Store::NONE {
                flash.erase(at(older));
            }
        }
        let mut present = (1..=F::PROGRAMS).filter(|number| self.slot(*number) != Store::NONE);
        if let (Some(only), None) = (present.next(), present.next()) {
            self.current = only;
        }
    }

    /// Offset of a program's image.
    pub fn image_of<F: Flash>(&self, number: u8) -> Option<u16> {
        let slot = self.slot(number);
        (slot != Store::NONE).then(|| at(slot) + F::HEAD)
    }

    /// Offset of the current image.
    pub fn image<F: Flash>(&self) -> Option<u16> {
        self.image_of::<F>(self.current)
    }

    /// Number of the current program, 0 for none.
    pub fn current(&self) -> u8 {
        self.current
    }

    /// Makes a program the current one; `false` when there is none of that number.
    pub fn choose(&mut self, number: u8) -> bool {
        let there = self.slot(number) != Store::NONE;
        if there {
            self.current = number;
        }
        there
    }

    /// Word `n` of a program's name, 0 without one.
    pub fn name<F: Flash>(&self, flash: &F, number: u8, n: u16) -> u16 {
        let slot = self.slot(number);
        if slot == Store::NONE || F::PROGRAMS == 1 || n >= NAME as u16 {
            return 0;
        }
        flash.read(at(slot) + NAME_AT + 2 * n)
    }

    /// Offset of the two segments that hold the current program's KEEP values.
    pub fn keeps_at<F: Flash>(&self, flash: &F) -> u16 {
        let slot = self.slot(self.current);
        if F::PROGRAMS == 1 || slot == Store::NONE {
            return at(F::SEGMENTS - KEEP_SEGMENTS);
        }
        // A program without KEEP values may have one segment; its place for them is asked for, and not used.
        at((slot + Store::size(flash, slot)).saturating_sub(KEEP_SEGMENTS))
    }

    /// Offset of the image that an upload fills.
    pub fn open_image<F: Flash>(&self) -> Option<u16> {
        (self.open != Store::NONE).then(|| at(self.open) + F::HEAD)
    }

    /// Offset of the segments of its own for its KEEP values, if its image has any, in a library.
    ///
    /// # Errors
    /// It has them without saying so before, and another program follows.
    pub fn open_keeps<F: Flash>(&mut self, flash: &F, keeps: bool) -> Result<Option<u16>, Denied> {
        if F::PROGRAMS == 1 || self.open == Store::NONE || !keeps {
            return Ok(None);
        }
        let behind = self.open + segments::<F>(self.upload.length);
        let taken = self.taken(flash);
        let free = (behind..behind + KEEP_SEGMENTS)
            .all(|segment| segment < F::SEGMENTS && !taken.has(segment));
        if !free {
            return Err(Denied::TooLong);
        }
        self.upload.keeps = true;
        Ok(Some(at(behind)))
    }

    /// Number of the program that it replaces or becomes.
    pub fn open_number(&self) -> u8 {
        self.upload.number
    }

    /// Length of the current image, 0 without one.
    pub fn length<F: Flash>(&self, flash: &F) -> u16 {
        self.image::<F>().map_or(0, |image| flash.length(image))
    }

    /// The longest image, bytes.
    pub const fn area<F: Flash>() -> u16 {
        F::SEGMENTS as u16 * SEGMENT - F::HEAD
    }

    /// Which segments slots take.
    fn taken<F: Flash>(&self, flash: &F) -> Segments {
        let mut taken = Segments([0; MAP]);
        for &slot in &self.slots {
            if slot != Store::NONE {
                let end = slot + Store::size(flash, slot);
                let mut segment = slot;
                while segment < end {
                    taken.set(segment);
                    segment += 1;
                }
            }
        }
        taken
    }

    /// Where `wanted` segments in front of `limit` are free.
    fn fit<F: Flash>(&self, flash: &F, wanted: u8, limit: u8) -> Option<u8> {
        let taken = self.taken(flash);
        let (mut segment, mut free) = (0, 0);
        while segment < limit {
            free = if taken.has(segment) { 0 } else { free + 1 };
            segment += 1;
            if free == wanted {
                return Some(segment - wanted);
            }
        }
        None
    }

    /// The longest image that fits beside those that are there, bytes.
    pub fn free<F: Flash>(&self, flash: &F) -> u16 {
        let taken = self.taken(flash);
        let (mut segment, mut free, mut most) = (0, 0, 0);
        while segment < F::SEGMENTS {
            free = if taken.has(segment) { 0 } else { free + 1 };
            most = most.max(free);
            segment += 1;
        }
        at(most).saturating_sub(F::HEAD)
    }

    /// Opens an upload. `replace` gives the program that it replaces up.
    ///
    /// # Errors
    /// The length is none or the image does not fit.
    pub fn begin<F: Flash>(
        &mut self,
        flash: &mut F,
        upload: Upload,
        replace: bool,
    ) -> Result<(), Denied> {
        self.open = Store::NONE;
        self.committed = false;
        if upload.length == 0 || !(1..=F::PROGRAMS).contains(&upload.number) {
            return Err(Denied::NotBegun);
        }
        if upload.length > Store::area::<F>() {
            return Err(Denied::TooLong);
        }
        let image = segments::<F>(upload.length);
        let keeps = if upload.keeps { KEEP_SEGMENTS } else { 0 };
        let (wanted, limit) = match F::PROGRAMS {
            1 => (image, F::SEGMENTS - keeps),
            _ => (image + keeps, F::SEGMENTS),
        };
        if replace {
            self.discard(flash, upload.number);
        }
        let first = self.fit(flash, wanted, limit).ok_or(Denied::TooLong)?;
        self.erased = 0;
        while self.erased < image.min(at_once(F::PROGRAMS)) {
            flash.erase(at(first + self.erased));
            self.erased += 1;
        }
        self.open = first;
        self.upload = upload;
        Ok(())
    }

    /// Whether an upload is open whose image has a word at this offset.
    pub fn takes(&self, offset: u16) -> bool {
        self.open != Store::NONE && offset < self.upload.length
    }

    /// Writes a word of the open image, at an even offset in it.
    ///
    /// # Errors
    /// No upload is open, the offset lies outside, or the word does not hold the value.
    pub fn write<F: Flash>(&mut self, flash: &mut F, offset: u16, word: u16) -> Result<(), Denied> {
        if !self.takes(offset) {
            return Err(Denied::NotBegun);
        }
        let place = at(self.open) + F::HEAD + offset;
        let segment = ((F::HEAD + offset) / SEGMENT) as u8;
        if segment >= self.erased {
            flash.erase(place);
            self.erased = segment + 1;
        }
        if flash.read(place) == ERASED {
            flash.write(place, word);
        }
        if flash.read(place) == word { Ok(()) } else { Err(Denied::Flash) }
    }

    /// Checks the open image and makes it its program, called so in a library. It is the current one when the
    /// one that it replaces was, or when there is none. A repeated commit, whose first reply was lost, succeeds again.
    ///
    /// # Errors
    /// No upload is open or its image is not sound.
    pub fn commit<F: Flash>(&mut self, flash: &mut F, name: &[u16; NAME]) -> Result<(), Denied> {
        if self.open == Store::NONE {
            return if self.committed { Ok(()) } else { Err(Denied::NotBegun) };
        }
        let slot = at(self.open);
        match flash.image(slot + F::HEAD) {
            Some(length) if length == self.upload.length => {}
            _ => return Err(Denied::Image),
        }
        if F::PROGRAMS > 1 {
            let keeps = if self.upload.keeps { KEEP_SEGMENTS } else { 0 };
            let size = segments::<F>(self.upload.length) + keeps;
            flash.write(slot + NUMBER_AT, u16::from_le_bytes([self.upload.number, size]));
            for (&word, place) in name.iter().zip((slot + NAME_AT..).step_by(2)) {
                flash.write(place, word);
            }
        }
        let older = self.slot(self.upload.number);
        let mut sequence = 0;
        if older != Store::NONE {
            sequence = (flash.read(at(older)) as u8).wrapping_add(1);
        }
        let word = COMMITTED | u16::from(sequence);
        flash.write(slot, word);
        if flash.read(slot) != word {
            return Err(Denied::Flash);
        }
        self.set_slot(self.upload.number, self.open);
        if self.current == 0 {
            self.current = self.upload.number;
        }
        self.open = Store::NONE;
        self.committed = true;
        if older != Store::NONE {
            flash.erase(at(older));
        }
        Ok(())
    }

    /// Gives a program up.
    pub fn discard<F: Flash>(&mut self, flash: &mut F, number: u8) {
        self.committed = false;
        let slot = self.slot(number);
        if slot != Store::NONE {
            flash.erase(at(slot));
        }
        self.set_slot(number, Store::NONE);
        if self.current == number {
            self.current = 0;
        }
    }
}

impl Default for Store {
    fn default() -> Store {
        Store::new()
    }
}

#[cfg(test)]
pub(crate) mod tests;
