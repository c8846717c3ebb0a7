//! A laser without a PWM, by the output that switches it.

use crate::machine::chip::Chip;
use crate::machine::motor::Motor;
use lang::record::FULL_POWER;

/// A millisecond of light, thousandths of the timer's ticks.
const fn a_millisecond<C: Chip>() -> i32 {
    C::PER_MS as i32 * FULL_POWER
}
/// So many of these are owed, or were given too much, at most: what a lost line owes is not for the next.
const MOST: i32 = 8;

/// What it has shone, and should have.
pub struct Light {
    /// Light that it owes, thousandths of the timer's ticks; negative when it gave too much.
    owed: i32,
    /// When this was last seen to, by that timer.
    seen: u16,
    /// It is lit.
    lit: bool,
}

impl Light {
    /// Outputs as they go out, with the laser on number `laser`: it is off whenever nothing moves, and on for as much
    /// of the time as its power is of the full one. Milliseconds that come late are as long as they were.
    pub fn shine<C: Chip>(&mut self, chip: &C, laser: u8, outputs: u16, motor: &Motor<C>) -> u16 {
        if motor.pwm.is_open() {
            return outputs;
        }
        let now = chip.now();
        let since = now.wrapping_sub(self.seen);
        self.seen = now;
        let was = core::mem::replace(&mut self.lit, false);
        if chip.is_running() {
            let most = MOST * const { a_millisecond::<C>() };
            let power = motor.shine() as i16;
            let owed = if was { power - FULL_POWER as i16 } else { power };
            self.owed = (self.owed + i32::from(owed) * i32::from(since)).clamp(-most, most);
            self.lit = power != 0 && self.owed >= const { a_millisecond::<C>() };
        }
        if self.lit { outputs } else { outputs & !(1 << ((laser - 1) & 15)) }
    }
}
