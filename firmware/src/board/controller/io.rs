//! Inputs and outputs as the program and the roles of the profile see them.

use super::Controller;
use crate::chain;
use crate::chip::timer;
use lang::record::{BoardRecord, FULL_POWER};
use lang::wire::RunState;

/// A millisecond of light, thousandths of the timer's ticks.
const A_MILLISECOND: i32 = timer::PER_MS as i32 * FULL_POWER;
/// As much light is owed, or was given too much, at most: what a lost line owes is not for the next.
const MOST: i32 = 8 * A_MILLISECOND;

impl Controller {
    /// Whether Stop is held or a hold, door or emergency stop input is active.
    pub fn blocked(&self) -> bool {
        self.buttons.accepted() & 1 != 0 || self.blocking() != 0
    }

    /// The input that blocks, 0 for none.
    pub fn blocking(&self) -> u8 {
        let record = self.record;
        let rest = [&record.stop, &record.hold, &record.door].map(|numbers| self.first_on(numbers));
        rest.into_iter().find(|n| *n != 0).unwrap_or_else(|| self.first_on(&record.emergency))
    }

    /// The first of these inputs that is on, 0 for none.
    pub fn first_on(&self, numbers: &[u8]) -> u8 {
        numbers.iter().copied().find(|n| self.input(*n)).unwrap_or(0)
    }

    /// The emergency stop that is pressed, before the filter; 0 for none.
    pub fn emergency_now(&self) -> u8 {
        let stops = self.record.emergency;
        stops.into_iter().find(|n| *n != 0 && self.unfiltered(*n)).unwrap_or(0)
    }

    /// Input `n` from 1; false beyond those there are.
    pub fn input(&self, n: u8) -> bool {
        match n {
            1..=16 => self.inputs.levels() >> (n - 1) & 1 != 0,
            17 if self.chained() => chain::probe() != (self.record.input_invert_high != 0),
            _ => false,
        }
    }

    /// An input before its filter: switches and probes are watched step by step.
    pub fn unfiltered(&self, number: u8) -> bool {
        match number {
            1..=16 => self.raw >> (number - 1) & 1 != 0,
            _ => self.input(number),
        }
    }

    /// Chain wiring, otherwise direct.
    pub fn chained(&self) -> bool {
        self.record.flags & BoardRecord::CHAIN != 0
    }

    /// Sets an output, numbered from 1; `false` beyond those there are.
    pub fn set_output(&mut self, n: u16, on: bool) -> bool {
        let most = if self.chained() { 16 } else { 2 };
        if n == 0 || n > most {
            return false;
        }
        let bit = 1 << (n - 1);
        self.outputs &= !bit;
        if on {
            self.outputs |= bit;
        }
        true
    }

    /// Sends the outputs and takes the inputs 1 to 16, before the filter.
    pub(super) fn exchange(&mut self) -> u16 {
        self.drive_pwm();
        let levels = self.levels() ^ self.record.output_invert;
        let fault = self.outputs & self.record.fault.keep | self.record.fault.on;
        crate::chip::flash::remember_stop(fault ^ self.record.output_invert);
        let raw = if self.chained() { chain::exchange(levels) } else { chain::pins(levels) };
        self.raw = raw ^ self.record.input_invert;
        self.raw
    }

    /// Outputs as they go out: a laser without a PWM is off whenever nothing moves, and on for as much of the time
    /// as its power is of the full one. Milliseconds that come late are as long as they were.
    fn levels(&mut self) -> u16 {
        let laser = self.record.laser;
        if laser == 0 || self.motor.pwm.is_open() {
            return self.outputs;
        }
        let now = timer::now();
        let since = now.wrapping_sub(self.shone);
        self.shone = now;
        let was = core::mem::replace(&mut self.lit, false);
        if crate::step::is_running() {
            let power = self.motor.shine() as i16;
            let owed = if was { power - FULL_POWER as i16 } else { power };
            self.shine = (self.shine + i32::from(owed) * i32::from(since)).clamp(-MOST, MOST);
            self.lit = power != 0 && self.shine >= A_MILLISECOND;
        }
        if self.lit { self.outputs } else { self.outputs & !(1 << ((laser - 1) & 15)) }
    }

    /// The status lamp: off without a program, lit when ready, blinking slowly in a run and fast in
    /// a pause, a fault's number in blinks, and once that of a program that the button for the next one chose.
    pub(super) fn lamp(&mut self) {
        let n = self.record.lamp;
        if n == 0 {
            return;
        }
        self.blink = self.blink.wrapping_add(1);
        let on = match self.session.state() {
            RunState::Empty => false,
            RunState::Ready if self.library.shown != 0 => {
                let blinks = u16::from(self.library.shown);
                if self.blink >= (blinks + 4) * 256 {
                    self.library.shown = 0;
                }
                self.blink < blinks * 256 && self.blink & 128 != 0
            }
            RunState::Ready => true,
            RunState::Running | RunState::WaitStart => self.blink & 512 != 0,
            RunState::Paused | RunState::Stopping => self.blink & 128 != 0,
            RunState::Fault => {
                let blinks = u16::from(self.session.fault());
                if self.blink >= (blinks + 4) * 256 {
                    self.blink = 0;
                }
                self.blink < blinks * 256 && self.blink & 128 != 0
            }
        };
        self.set_output(u16::from(n), on);
    }
}
