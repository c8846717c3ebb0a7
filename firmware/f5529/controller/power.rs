//! S, and what the PWM makes of it.

use super::Controller;
use crate::chip::pwm::{self, DARK};
use crate::{guard, step};
use firmware::motion::path::FULL;
use lang::record::{FULL_POWER, MoreRecord};

impl Controller {
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
                let shines = step::is_running() && !self.motor.follows;
                pwm::set(if shines { own.compare(power) } else { DARK });
            }
            MoreRecord::SPINDLE => pwm::set(own.compare(power)),
            _ => pwm::set(own.compare(if on { power } else { 0 })),
        }
        let servo = own.kind == MoreRecord::SERVO;
        pwm::gate(on || servo);
        // Looked at after the pin was given to the timer: a stop that came before, or between, has darkened it in vain.
        if guard::tripped() != 0 {
            pwm::gate(false);
        }
    }

    /// The PWM's pin goes low at once, until it is driven again.
    pub fn darken(&self) {
        pwm::gate(false);
    }
}
