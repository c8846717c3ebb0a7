//! The analog output: channel 6 of TB0, whose pin is P3.6. Each period begins low; the pin is high from the compare value to
//! the period's end, as that of [`super::pwm`].
//!
//! A new value that the counter has passed, while it has not reached the old one, would leave a period dark. Such a value is
//! not written: the pin goes high a little later instead, by a compare value just ahead, and with a pin that is high the value
//! itself holds from the next period on. So each period has a pulse between the older value's and the newer one's.

use super::ports;
use super::pwm;
use super::reg::{TB0CCR0, TB0CCR6, TB0CCTL6, TB0R};

/// Control of the channel: 0 puts the pin low at once.
pub const CCTL: u16 = TB0CCTL6.0;
/// Output mode set/reset.
const RUNS: u16 = 3 << 5;
/// Counts from reading the counter to a compare value that is written for sure before they are over, with interrupts off.
const SOON: u16 = 64;
/// Looks at the counter until another pass of the main loop goes on with it.
const TRIES: u8 = 8;

/// Starts the timer, its pin driven low. Returns how far it counts.
pub fn open(hz: u16) -> u16 {
    TB0CCTL6.set(0);
    TB0CCR6.set(pwm::DARK);
    let (top, _) = pwm::count(hz);
    ports::open_aout();
    top
}

/// From which count on the pin is high, from now on.
pub fn set(compare: u16) {
    // Its flags come while it is off, too.
    if TB0CCTL6.get() & RUNS == 0 {
        // The pin is low, and stays so until the counter comes to the new value.
        TB0CCR6.set(compare);
        TB0CCTL6.set(RUNS);
    }
    let mut tries = TRIES;
    while TB0CCR6.get() != compare && tries != 0 {
        tries -= 1;
        msp430::interrupt::disable();
        let now = TB0R.get();
        let old = TB0CCR6.get();
        let soon = now + SOON;
        let is_high = now >= old;
        let ends = soon >= TB0CCR0.get();
        if old == pwm::DARK || compare > soon || is_high && !(ends && compare <= SOON) {
            TB0CCR6.set(compare);
        } else if is_high {
            // The next period may have begun by then.
            TB0CCR6.set(SOON);
        } else if soon < old {
            TB0CCR6.set(soon);
        }
        // SAFETY: only the main loop calls this, with interrupts on.
        unsafe { msp430::interrupt::enable() };
    }
}

/// Puts the pin low at once.
#[inline(always)]
pub fn darken() {
    TB0CCTL6.set(0);
}
