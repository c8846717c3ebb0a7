//! S, and the PWM value that follows from it.

use super::Controller;
use crate::machine::chip::Chip;
use crate::machine::pwm::DARK;
use crate::motion::path::FULL;
use lang::record::{FULL_POWER, MoreRecord};

impl<C: Chip> Controller<C> {
    /// The level of an S, `None` above full power.
    pub fn level(&self, s: i32) -> Option<u16> {
        let range = u32::from(self.record.more().pwm_range);
        if s as u32 > range {
            return None;
        }
        // Rounded up: what is not dark stays so.
        Some(((s as u32) * u32::from(FULL)).div_ceil(range) as u16)
    }

    /// What holds before any S.
    pub fn full_power(&self) -> u16 {
        if self.motor.pwm.is_open() { FULL } else { FULL_POWER as u16 }
    }

    /// The PWM does as outputs, S and axes say.
    pub fn drive_pwm(&mut self) {
        let own = &self.motor.pwm;
        if !own.is_open() {
            return;
        }
        let on = self.io.outputs >> ((own.output - 1) & 15) & 1 != 0;
        let power = self.motor.power;
        match own.kind {
            // The path's own segments say what it is.
            MoreRecord::LASER if !self.motor.path_rests() => {}
            MoreRecord::LASER => {
                let shines = self.chip.is_running() && !self.motor.follows;
                self.chip.set_pwm(if shines { own.compare(power) } else { DARK });
            }
            MoreRecord::SPINDLE => self.chip.set_pwm(own.compare(power)),
            _ => self.chip.set_pwm(own.compare(if on { power } else { 0 })),
        }
        let servo = own.kind == MoreRecord::SERVO;
        self.chip.gate_pwm(on || servo);
        // Looked at after the pin was given to the timer: a stop that came before, or between, has darkened it in vain.
        if self.chip.tripped() != 0 {
            self.chip.gate_pwm(false);
        }
    }

    /// The pins of PWM and analog output go low at once, until they are driven again.
    pub fn darken(&self) {
        self.chip.gate_pwm(false);
        self.chip.darken_aout();
    }
}
