//! The PWM: power of a laser or a spindle, pulses of a servo.
//!
//! A power is a *level*, 0 to [`FULL`], from S to the timer. A laser's power belongs to the segments of the path: when a
//! segment begins, the step engine's interrupt writes its compare value. At the end of the last segment it writes the value
//! that keeps the pin low, so no beam outlasts the last step by more than a period. The pin itself is driven
//! while the output that the profile names is on. An interrupt that stops the engine sets it low at once.

use crate::machine::chip::Chip;
use crate::motion::path::FULL;
use lang::record::MoreRecord;

/// The compare value that no period reaches: the pin stays low.
pub const DARK: u16 = u16::MAX;

/// What the profile says of it.
pub struct Pwm {
    /// Number of the output that switches it, 0 without a PWM.
    pub output: u8,
    /// As [`MoreRecord::pwm_kind`].
    pub kind: u8,
    /// Where the timer begins again.
    top: u16,
    /// Ticks of the least level above 0, and how many more full power has.
    least: u16,
    span: u16,
}

impl Pwm {
    /// Starts it if the profile has one; interrupts are still off.
    pub fn open<C: Chip>(&mut self, chip: &C, more: &MoreRecord) {
        if more.pwm_hz == 0 {
            return;
        }
        let (top, per_ms) = chip.open_pwm(more.pwm_hz);
        self.output = more.pwm_output;
        self.kind = more.pwm_kind;
        self.top = top;
        let ticks = |us: u16| (u32::from(us) * u32::from(per_ms) / 1000) as u16;
        if self.kind == MoreRecord::SERVO {
            self.least = ticks(more.servo_low);
            self.span = ticks(more.servo_high) - self.least;
        } else {
            self.least = (u32::from(more.pwm_minimum) * u32::from(top) / 1000) as u16;
            self.span = top - self.least;
        }
        if self.is_laser() {
            chip.shine_at_pwm();
        }
    }

    /// Whether there is one.
    pub fn is_open(&self) -> bool {
        self.output != 0
    }

    /// Whether it is this output that switches it.
    pub fn is_switched_by(&self, n: u16) -> bool {
        u16::from(self.output) == n
    }

    /// Whether a laser hangs on it.
    pub fn is_laser(&self) -> bool {
        self.is_open() && self.kind == MoreRecord::LASER
    }

    /// The compare value of a level.
    pub fn compare(&self, level: u16) -> u16 {
        if level == 0 && self.kind != MoreRecord::SERVO {
            return DARK;
        }
        self.top - self.least - ((u32::from(level) * u32::from(self.span)) >> FULL.ilog2()) as u16
    }
}
