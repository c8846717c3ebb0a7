//! The tasks of each millisecond.

use super::Controller;
use super::keep::SECOND;
use crate::machine::chip::Chip;
use crate::rules::session;
use crate::rules::ticks::{self, Starts};
use lang::fault::Fault;
use lang::record::BoardRecord;
use lang::wire::{Control, RunState};

/// Milliseconds without a valid request after which commands 102 and 1111 ramp down, and without one of the host that
/// feeds it after which a streamed job ends.
const SILENCE: u16 = 2000;

/// Milliseconds, and what is counted in them at any time.
pub struct Clock {
    /// Those handled.
    pub tick: u16,
    /// Those served more than 2 ms late.
    pub missed: u16,
    /// Phase of the input filter.
    phase: u8,
    /// For so long has Stop been held.
    held: u16,
    /// Since KEEP values went to flash.
    pub kept: u16,
    /// Until motion goes on after a pause.
    pub spin: u16,
    /// Of the status lamp.
    pub blink: u16,
}

#[cfg(any(test, feature = "physics"))]
impl Clock {
    /// The input filter's phase after so many milliseconds, in a profile's filter.
    pub(super) fn skip_phase(&mut self, ms: u32, filter: u8) {
        // A phase ends with the first millisecond at which four times it is the filter's time.
        let period = u32::from(filter.div_ceil(4).max(1));
        self.phase = ((u32::from(self.phase) + ms) % period) as u8;
    }
}

impl<C: Chip> Controller<C> {
    /// Milliseconds that have passed since the last call, one by one.
    pub fn ticks(&mut self) {
        let late = self.chip.millis().wrapping_sub(self.clock.tick);
        if late == 0 {
            return;
        }
        if late > 2 {
            self.clock.missed = self.clock.missed.saturating_add(1);
        }
        self.clock.tick = self.clock.tick.wrapping_add(1);
        self.millisecond();
    }

    fn millisecond(&mut self) {
        let before = self.io.inputs.levels();
        let raw = self.exchange();
        let paused = self.session.is(RunState::Paused);
        let held = if paused { self.io.resume & !self.io.outputs } else { 0 };
        let crossed = self.io.analog.on;
        self.sample_analog();
        self.limits();
        self.chip.look_after_clock();
        self.clock.phase += 1;
        if self.clock.phase * 4 >= self.record.filter {
            self.clock.phase = 0;
            self.io.inputs.sample(raw);
            let pressed = self.io.buttons.accepted();
            // An input may be a second Start button.
            let second = u16::from(self.input(self.record.start)) << 1;
            self.io.buttons.sample(self.chip.buttons() | second);
            self.pressed(self.io.buttons.accepted() & !pressed);
            self.next_program();
            // Hold, door and a second Stop.
            if self.blocking() != 0 {
                self.control(Control::Pause);
            }
        }
        let now = self.io.inputs.levels();
        let probe = self.input(17);
        let probe_was = core::mem::replace(&mut self.io.probe, probe);
        // Not filtered: a stop must not wait, and one too many does no harm.
        // An acknowledged fault can still be read: only one that is latched has been dealt with,
        // unless something moves all the same.
        let latched =
            self.session.is(RunState::Fault) && self.session.fault == Fault::EmergencyStop.number();
        let dealt_with = latched && self.motor.moving() == 0;
        let emergency = self.emergency_now();
        if emergency != 0 && !dealt_with {
            self.emergency(emergency);
        }
        if self.io.buttons.accepted() & 1 != 0 {
            self.clock.held = self.clock.held.saturating_add(1);
            if self.clock.held == 2000 {
                session::stop(self);
            }
        } else {
            self.clock.held = 0;
        }
        self.lines.tick();
        self.clock.kept = self.clock.kept.saturating_add(1);
        self.trace.tick();
        if self.command.jogs && (self.lines.silence > SILENCE || self.motor.moving() == 0) {
            self.command.jogs = false;
            self.motor.stop(0b111);
        }
        if self.command.hold != 0 {
            self.command.hold -= 1;
            if self.session.is_active() || self.motor.moving() == 0 {
                self.command.hold = 0;
            } else if self.command.hold == 0 {
                self.motor.stop(0b111);
            }
        }
        // Once: the count stays at its end.
        if self.vm.is_piece && self.lines.unfed == SILENCE + 1 && self.session.is_active() {
            self.fail(Fault::LinkLost);
        }
        if self.clock.spin != 0 {
            self.clock.spin -= 1;
            if self.clock.spin == 0 {
                self.motor.pause(false);
            }
        }
        self.lamp();
        ticks::autorun(self);
        self.program.pulse_tick(&mut self.io);
        self.motor.actions.tick(held);
        if !self.session.is_active() {
            self.program.effect.count_down();
        }
        if self.session.executes() {
            self.program.timer = self.program.timer.wrapping_add(1);
            self.program.effect.count_down();
            self.program.outer.count_down();
            if self.clock.kept >= SECOND && self.motor.rests() && self.lines.rests {
                self.save();
            }
        }
        let high = |probe: bool, crossed: u8| u32::from(probe) << 16 | u32::from(crossed) << 17;
        let was = u32::from(before) | high(probe_was, crossed);
        let is = u32::from(now) | high(self.io.probe, self.io.analog.on);
        self.program.listen(self.session.executes(), is & !was, was & !is);
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

impl<C: Chip> Starts for Controller<C> {
    fn has_booted(&self) -> bool {
        self.reset.booted
    }
    fn boots(&self) -> bool {
        self.clock.tick != 500
    }
    fn set_booted(&mut self) {
        self.reset.booted = true;
    }
    fn has_host(&self) -> bool {
        self.lines.spoken
    }
    fn wants_autorun(&self) -> bool {
        self.record.flags & BoardRecord::AUTORUN != 0
    }
    fn was_powered_up(&self) -> bool {
        // Of watchdog, power and RST.
        self.reset.cause & 0b1101 == 1 << 2
    }
}
