//! ADC12_A: the analog inputs A4, A5, A6 and A12 against the supply, four conversions of each in a millisecond.
//!
//! The main loop begins one sequence of 16 conversions each millisecond and reads what the one before has left in the module's
//! memories: no interrupt, no RAM. By its own oscillator, 4.2 to 5.4 MHz (SLAS590), a sequence takes 86 to 110 us, so it is
//! over when the next begins; where two milliseconds are made up for at once the second one leaves it running.

use super::ports;
use super::reg::{ADC12CTL0, ADC12CTL1, ADC12CTL2, ADC12MCTL, ADC12MEM};

/// Each sampled for 16 cycles, 3.0 us at least: enough for sources of up to 10 kOhm (SLAS590: 1 us and 25 pF).
const SET_UP: u16 = 0x2200 | 1 << 7 | 1 << 4;
const ENABLE: u16 = 1 << 1;
const START: u16 = 1;
const BUSY: u16 = 1;
/// Sampling by its own timer, a sequence of channels.
const SEQUENCE: u16 = 1 << 9 | 1 << 1;
const TWELVE_BITS: u16 = 0x20;
const LAST: u8 = 1 << 7;
/// The channel of each analog input.
const CHANNELS: [u8; 4] = [4, 5, 6, 12];
/// Memories of the module.
const MEMORIES: u16 = 16;

/// Gives these inputs, bit 0 for A4, their pins, and begins the first conversions.
pub fn open(inputs: u8) {
    if inputs == 0 {
        return;
    }
    ports::open_analog(inputs);
    ADC12CTL0.set(SET_UP);
    ADC12CTL1.set(SEQUENCE);
    ADC12CTL2.set(TWELVE_BITS);
    for n in 0..MEMORIES {
        let end = if n == MEMORIES - 1 { LAST } else { 0 };
        ADC12MCTL.after(n).set(CHANNELS[usize::from(n & 3)] | end);
    }
    convert();
}

/// Begins the next conversions, unless the last ones are not over.
pub fn convert() {
    if ADC12CTL1.get() & BUSY == 0 {
        ADC12CTL0.set(SET_UP);
        ADC12CTL0.set(SET_UP | ENABLE | START);
    }
}

/// The sum of the last four conversions of an input, from 0.
pub fn sum(n: u8) -> u16 {
    let mut sum = 0;
    let mut at = u16::from(n);
    while at < MEMORIES {
        sum += ADC12MEM.after(2 * at).get();
        at += 4;
    }
    sum
}
