//! What is done each millisecond.

use super::Controller;
use crate::{chain, link};
use lang::fault::Fault;
use lang::record::BoardRecord;
use lang::wire::{Control, RunState};

/// Autorun gives up after so many watchdog resets in a row.
const BITES: u16 = 3;

/// Milliseconds without a valid request after which commands 102 and 1111 ramp down.
const SILENCE: u16 = 2000;

impl Controller {
    /// Milliseconds that have passed since the last call, one by one.
    pub fn ticks(&mut self) {
        let late = link::millis().wrapping_sub(self.tick);
        if late == 0 {
            return;
        }
        if late > 2 {
            self.missed = self.missed.saturating_add(1);
        }
        self.tick = self.tick.wrapping_add(1);
        self.millisecond();
    }

    fn millisecond(&mut self) {
        let before = self.inputs.levels();
        let raw = self.exchange();
        self.limits();
        self.phase += 1;
        if self.phase * 4 >= self.record.filter {
            self.phase = 0;
            self.inputs.sample(raw);
            let pressed = self.buttons.accepted();
            // An input may be a second Start button.
            let second = u16::from(self.input(self.record.start)) << 1;
            self.buttons.sample(chain::buttons() | second);
            self.pressed(self.buttons.accepted() & !pressed);
            self.next_program();
            // Hold, door and a second Stop.
            if self.blocking() != 0 {
                self.control(Control::Pause);
            }
        }
        let now = self.inputs.levels();
        let probe = self.input(17);
        let probe_was = core::mem::replace(&mut self.probe, probe);
        // Not filtered: a stop must not wait, and one too many does no harm.
        // An acknowledged fault can still be read: only one that is latched has been dealt with,
        // unless something moves all the same.
        let latched = self.session.state() as u8 == RunState::Fault as u8
            && self.session.fault() == Fault::EmergencyStop.number();
        let dealt_with = latched && self.motor.moving() == 0;
        let emergency = self.emergency_now();
        if emergency != 0 && !dealt_with {
            self.emergency(emergency);
        }
        if self.buttons.accepted() & 1 != 0 {
            self.held = self.held.saturating_add(1);
            if self.held == 2000 {
                let order = self.session.stop();
                self.obey(order);
            }
        } else {
            self.held = 0;
        }
        self.silence = self.silence.saturating_add(1);
        self.helm_left = self.helm_left.saturating_sub(1);
        self.trace.tick();
        if self.jog && self.silence > SILENCE {
            self.jog = false;
            self.motor.stop(0b111);
        }
        if self.hold != 0 {
            self.hold -= 1;
            if self.session.is_active() || self.motor.moving() == 0 {
                self.hold = 0;
            } else if self.hold == 0 {
                self.motor.stop(0b111);
            }
        }
        // Once: the count stays at its end.
        if crate::streams() && self.silence == SILENCE + 1 && self.session.is_active() {
            self.fail(Fault::LinkLost);
        }
        if self.spin != 0 {
            self.spin -= 1;
            if self.spin == 0 {
                self.motor.pause(false);
            }
        }
        self.lamp();
        self.autorun();
        self.pulse_tick();
        if !self.session.is_active() {
            self.effect.count_down();
        }
        if self.session.executes() {
            self.timer = self.timer.wrapping_add(1);
            self.effect.count_down();
            self.outer.count_down();
            if (self.timer as u16).is_multiple_of(1024) && self.motor.rests() && self.line_rests {
                self.save();
            }
        }
        let was = u32::from(before) | u32::from(probe_was) << 16;
        let is = u32::from(now) | u32::from(self.probe) << 16;
        self.listen(is & !was, was & !is);
    }

    /// Auto-run half a second after power-up, unless a host has spoken or Stop is held.
    fn autorun(&mut self) {
        if self.tick != 500 || self.booted {
            return;
        }
        self.booted = true;
        let wanted = self.record.flags & BoardRecord::AUTORUN != 0 && self.bites < BITES;
        if wanted && !self.host && !self.blocked() {
            // The first start acknowledges what a watchdog reset has latched.
            if self.bites != 0 && self.session.state() as u8 == RunState::Fault as u8 {
                self.control(Control::Start);
            }
            self.control(Control::Start);
        }
    }

    fn pressed(&mut self, keys: u16) {
        if keys & 1 != 0 {
            self.control(Control::Pause);
        }
        if keys & 2 != 0 {
            self.control(Control::Start);
        }
    }
}
