//! The flash controller, the program area behind the store, and images in it.

pub use crate::chip::AREA;
use crate::chip::clock::kick;
use crate::chip::{self, PART};
use crate::link;
use firmware::store::{Flash, KEEP_SEGMENTS, SEGMENT};
use firmware::verify::{self, Bytes};
use lang::image::at;

/// End of the program area.
pub const AREA_END: u16 = AREA + SEGMENT * PART.segments as u16;

/// FCTL keys (SLAU144, 7.4): A5 in the high byte. It is the caller's part of every write, so a
/// program counter that has gone astray into this code finds no key on the stack.
#[derive(Clone, Copy)]
pub struct Key(pub u16);

impl Key {
    /// For code that means to write flash.
    #[inline(always)]
    pub const fn new() -> Key {
        Key(0xA500)
    }
}

const WRITE: u16 = 1 << 6;
const ERASE: u16 = 1 << 1;

/// One flash operation; interrupts wait meanwhile.
#[inline(never)]
fn operate(key: Key, mode: u16, address: u16, word: u16) {
    // Only the program area and the profile's and journal's segments of the information memory.
    if !(AREA..AREA_END).contains(&address) && !chip::INFORMATION.contains(&address) {
        return;
    }
    kick();
    msp430::interrupt::disable();
    chip::flash::operate(key, mode, address, word);
    link::catch_up();
    // SAFETY: interrupts were on, no critical section is open in the main loop.
    unsafe { msp430::interrupt::enable() };
    kick();
}

/// Clears bits of a word.
pub fn write(key: Key, address: u16, word: u16) {
    operate(key, WRITE, address, word);
}

/// Erases a segment.
pub fn erase(key: Key, address: u16) {
    operate(key, ERASE, address, 0);
}

/// The word at an even address.
#[inline(always)]
pub fn read(address: u16) -> u16 {
    // SAFETY: any address can be read.
    unsafe { (address as *const u16).read_volatile() }
}

/// Bytes from an address on.
#[derive(Clone, Copy)]
pub struct Image(pub u16);

impl Bytes for Image {
    #[inline(always)]
    fn byte(&self, offset: u16) -> u8 {
        // SAFETY: any address can be read.
        unsafe { (self.0.wrapping_add(offset) as *const u8).read_volatile() }
    }

    #[inline(always)]
    fn crc(crc: u16, byte: u8) -> u16 {
        // 3 KB take 20 ms, and the check of the code follows.
        kick();
        crate::math::crc16(crc, byte)
    }
}

impl Image {
    /// The stored image here, taken apart as the host does it.
    pub fn parts(self) -> Option<lang::image::Image<'static>> {
        let length = self.word(lang::image::at::LEN as u16);
        // SAFETY: a stored image lies in flash whole; what erases it keeps nothing of it.
        let bytes = unsafe { core::slice::from_raw_parts(self.0 as *const u8, length.into()) };
        lang::image::Image::new(bytes).ok()
    }
}

/// The program area.
pub struct Area;

impl Flash for Area {
    const SEGMENTS: u8 = PART.segments;
    const PROGRAMS: u8 = PART.programs;
    fn read(&self, offset: u16) -> u16 {
        read(AREA + offset)
    }
    fn write(&mut self, offset: u16, word: u16) {
        write(Key::new(), AREA + offset, word);
    }
    fn erase(&mut self, offset: u16) {
        erase(Key::new(), AREA + offset);
    }
    fn image(&self, offset: u16) -> Option<u16> {
        let start = AREA + offset;
        verify::sound(&Image(start), AREA_END - start)
    }
    fn length(&self, offset: u16) -> u16 {
        Image(AREA + offset).word(at::LEN as u16)
    }
}

/// A program's KEEP values: two segments from an offset in the program area.
#[derive(Clone, Copy)]
pub struct Ring(pub u16);

impl Flash for Ring {
    const SEGMENTS: u8 = KEEP_SEGMENTS;
    fn read(&self, offset: u16) -> u16 {
        Area.read(self.0 + offset)
    }
    fn write(&mut self, offset: u16, word: u16) {
        Area.write(self.0 + offset, word);
    }
    fn erase(&mut self, offset: u16) {
        Area.erase(self.0 + offset);
    }
    // It holds none.
    fn image(&self, _: u16) -> Option<u16> {
        None
    }
    fn length(&self, _: u16) -> u16 {
        0
    }
}
