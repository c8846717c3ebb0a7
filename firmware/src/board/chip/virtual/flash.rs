//! The flash controller.

use super::reg::{self, set};
use crate::flash::Key;

/// Levels of the outputs behind an emergency stop: the processor stands still while flash is busy, and sees to them
/// afterwards.
#[inline(always)]
pub fn remember_stop(_levels: u16) {}

/// One operation: unlocked, triggered by a write of `word`, locked again. The processor stands still
/// meanwhile: 75 us for a word, 12 ms for a segment. Interrupts are off.
#[inline(always)]
pub fn operate(key: Key, mode: u16, address: u16, word: u16) {
    let flash = reg::flash();
    // MCLK / 40 = 400 kHz, in its limits with a DCO that is 19 % too fast or 35 % too slow.
    set!(flash.fctl2, key.0 | 0b01 << 6 | 39);
    set!(flash.fctl3, key.0);
    set!(flash.fctl1, key.0 | mode);
    // SAFETY: the caller has tested that the address lies in flash that no code runs from.
    unsafe { (address as *mut u16).write_volatile(word) };
    set!(flash.fctl1, key.0);
    set!(flash.fctl3, key.0 | 1 << 4);
}
