//! TB0: the PWM, whose channel 5 is P3.5. Each period begins low; the pin is high from the compare value to the
//! period's end. New values hold from the next period on.

use super::clock::RATE;
use super::ports;
use super::reg::{TB0CCR0, TB0CCR5, TB0CCTL5, TB0CTL};

/// Control of the channel: 0 puts the pin low at once.
pub const CCTL: u16 = TB0CCTL5.0;
/// Its compare register.
pub const CCR: u16 = TB0CCR5.0;
/// The compare value that no period reaches: the pin stays low.
pub const DARK: u16 = u16::MAX;

/// Output mode set/reset; the value is latched when the counter is 0.
const RUNS: u16 = 1 << 9 | 3 << 5;

/// Lets it count `hz` periods in a second, its pin driven low. Returns how far it counts, and its ticks in a
/// millisecond.
pub fn open(hz: u16) -> (u16, u16) {
    let mut divider = 0;
    let mut top = RATE / u32::from(hz);
    while top > u32::from(u16::MAX) {
        divider += 1;
        top >>= 1;
    }
    let top = top as u16 - 1;
    // A watchdog reset leaves the timer as it was.
    TB0CTL.set(0);
    TB0CCTL5.set(0);
    TB0CCR0.set(top);
    TB0CCR5.set(DARK);
    // SMCLK, up, cleared.
    TB0CTL.set(0b10 << 8 | divider << 6 | 0b01 << 4 | 1 << 2);
    ports::open_pwm();
    (top, ((RATE / 1000) >> divider) as u16)
}

/// What the pin is high for from the next period on.
#[inline(always)]
pub fn set(compare: u16) {
    TB0CCR5.set(compare);
}

/// Lets the pin follow, or puts it low at once.
#[inline(always)]
pub fn gate(on: bool) {
    TB0CCTL5.set(if on { RUNS } else { 0 });
}
