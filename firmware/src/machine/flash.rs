//! The program area's flash, as the store uses it, and images by their address.

use crate::machine::chip::Chip;
use crate::store::{Flash, KEEP_SEGMENTS, SEGMENT};
use crate::verify::{self, Bytes};
use lang::image::at;

/// Bytes from an address on.
#[derive(Clone)]
pub struct Image<C>(pub C, pub u16);

impl<C: Chip> Bytes for Image<C> {
    #[inline(always)]
    fn byte(&self, offset: u16) -> u8 {
        self.0.byte(self.1.wrapping_add(offset))
    }

    #[inline(always)]
    fn crc(crc: u16, byte: u8) -> u16 {
        C::crc(crc, byte)
    }
}

/// The program area.
pub struct Area<C>(pub C);

impl<C: Chip> Area<C> {
    /// End of the program area.
    const END: u16 = C::AREA + SEGMENT * C::PART.segments as u16;
}

impl<C: Chip> Flash for Area<C> {
    const SEGMENTS: u8 = C::PART.segments;
    const PROGRAMS: u8 = C::PART.programs;
    fn read(&self, offset: u16) -> u16 {
        self.0.word(C::AREA + offset)
    }
    fn write(&mut self, offset: u16, word: u16) {
        self.0.write(C::AREA + offset, word);
    }
    fn erase(&mut self, offset: u16) {
        self.0.erase(C::AREA + offset);
    }
    fn image(&self, offset: u16) -> Option<u16> {
        let start = C::AREA + offset;
        verify::sound(&Image(self.0.clone(), start), Self::END - start)
    }
    fn length(&self, offset: u16) -> u16 {
        Image(self.0.clone(), C::AREA + offset).word(at::LEN as u16)
    }
}

/// A program's KEEP values: two segments from an offset in the program area.
pub struct Ring<C>(pub C, pub u16);

impl<C: Chip> Ring<C> {
    fn area(&self) -> Area<C> {
        Area(self.0.clone())
    }
}

impl<C: Chip> Flash for Ring<C> {
    const SEGMENTS: u8 = KEEP_SEGMENTS;
    fn read(&self, offset: u16) -> u16 {
        self.area().read(self.1 + offset)
    }
    fn write(&mut self, offset: u16, word: u16) {
        self.area().write(self.1 + offset, word);
    }
    fn erase(&mut self, offset: u16) {
        self.area().erase(self.1 + offset);
    }
    // It holds none.
    fn image(&self, _: u16) -> Option<u16> {
        None
    }
    fn length(&self, _: u16) -> u16 {
        0
    }
}
