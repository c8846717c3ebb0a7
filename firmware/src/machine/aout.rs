//! The analog output: a second PWM, whose pulses a filter or a converter makes a voltage of.
//!
//! Its value changes by `SetAout` and M68, on the way of a path, and by its register. Resets, faults and the ends of runs give it
//! the safe value of the profile, pauses where the profile says so. What stops the step engine by itself (an emergency stop)
//! puts the pin low in the same interrupt, as it does the PWM of [`super::pwm`]; the safe value follows from the main loop.

use crate::machine::chip::Chip;
use crate::machine::controller::Controller;
use crate::machine::pwm::DARK;
use lang::fault::Fault;
use lang::record::MoreRecord;
use lang::wire::{TRACE_SHARE, TraceKind};

impl<C: Chip> Controller<C> {
    /// Starts it with its safe value, if the profile has one; interrupts are still off.
    pub fn open_aout(&mut self) {
        let more = self.record.more();
        if more.aout_full != 0 {
            let hz = more.aout_hz;
            self.io.aout.top = self.chip.open_aout(hz);
            self.go_safe();
        }
    }

    /// The greatest value of analog output `n`, from 1; `None` where there is no such output.
    fn aout_full(&self, n: i32) -> Option<u16> {
        let there = n == 1 && self.io.aout.top != 0;
        there.then(|| self.record.more().aout_full & MoreRecord::VALUE)
    }

    /// Whether analog output `n` can have this value.
    pub fn takes_aout(&self, n: i32, value: i32) -> bool {
        self.aout_full(n).is_some_and(|full| (0..=i32::from(full)).contains(&value))
    }

    /// Gives the output a value that it can have; the pin follows with the next [`Controller::drive_aout`].
    pub fn set_aout(&mut self, value: u16) {
        let full = self.record.more().aout_full & MoreRecord::VALUE;
        let own = &mut self.io.aout;
        own.value = value;
        let high = C::mul_div(value.into(), own.top.into(), full.into()) as u16;
        // What is less than a tick of the timer is dark: no period ends where it is to go high.
        own.compare = if high == 0 { DARK } else { own.top - high };
    }

    /// Its safe value.
    pub fn safe_aout(&self) -> u16 {
        self.record.more().aout_safe & MoreRecord::VALUE
    }

    /// It gets its safe value.
    pub fn go_safe(&mut self) {
        if self.io.aout.top != 0 {
            self.set_aout(self.safe_aout());
        }
    }

    /// A pause begins.
    pub fn pause_aout(&mut self) {
        self.io.aout.resume = self.io.aout.value;
        if self.pauses_aout() {
            self.go_safe();
        }
    }

    /// Whether it has its safe value in a pause.
    pub fn pauses_aout(&self) -> bool {
        self.record.more().aout_safe & MoreRecord::PAUSES != 0
    }

    /// A pause is over.
    pub fn resume_aout(&mut self) {
        if self.io.aout.top != 0 {
            self.set_aout(self.io.aout.resume);
        }
    }

    /// The pin does as its value says.
    pub fn drive_aout(&mut self) {
        if self.io.aout.top == 0 {
            return;
        }
        if self.chip.tripped() == 0 {
            self.chip.set_aout(self.io.aout.compare);
        }
        // A stop that came before, or between, has darkened the pin in vain.
        if self.chip.tripped() != 0 {
            self.chip.darken_aout();
        }
    }

    /// The argument of an event of analog output `n`.
    pub fn aout_argument(&self, n: u8) -> u8 {
        let is_share = self.record.more().aout_full & MoreRecord::SHARE != 0;
        if is_share { n | TRACE_SHARE } else { n }
    }

    /// SetAout.
    ///
    /// # Errors
    /// F20: no such output, or a value that it does not have.
    pub fn take_aout(&mut self) -> Result<(), Fault> {
        let [value, n] = [self.vm.pop(), self.vm.pop()];
        if !self.takes_aout(n, value) {
            return Err(Fault::ValueRange);
        }
        self.set_aout(value as u16);
        self.drive_aout();
        self.emit(TraceKind::Aout, self.aout_argument(n as u8), value);
        Ok(())
    }
}
