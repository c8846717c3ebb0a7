//! The flash controller.

use crate::chip::AREA;
use crate::chip::clock::kick;
use crate::chip::{self, PART};
use crate::link;
use firmware::store::SEGMENT;

/// End of the program area.
const AREA_END: u16 = AREA + SEGMENT * PART.segments as u16;

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
