//! Inputs and outputs as the program and the roles of the profile see them.

use super::Controller;
use crate::analog::{Analog, FIRST_THRESHOLD, LAST_THRESHOLD};
use crate::inputs::Inputs;
use crate::machine::chip::Chip;
use lang::record::BoardRecord;
use lang::wire::{RunState, UNWIRED};

/// States that the lamp shows in ways of their own.
const EMPTY: u8 = RunState::Empty as u8;
const READY: u8 = RunState::Ready as u8;
const RUNNING: u8 = RunState::Running as u8;
const FAULT: u8 = RunState::Fault as u8;

/// Inputs and outputs, number n in bit n - 1.
pub struct Io {
    /// Filtered inputs 1..16.
    pub inputs: Inputs,
    /// Start and Stop as they were accepted: bit 0 Stop, bit 1 Start.
    pub buttons: Inputs,
    /// Outputs 1..16.
    pub outputs: u16,
    /// Outputs as they were before a pause.
    pub resume: u16,
    /// Levels of the inputs before the filter, forced ones included: what probes and reference runs look at.
    pub raw: u16,
    /// Level of input 17, which has no filter, in the last millisecond.
    pub probe: bool,
    /// Analog inputs and what thresholds make of them.
    pub analog: Analog,
    /// The analog output.
    pub aout: Aout,
}

/// The analog output. Values are mV, or steps of a share, as the profile says.
#[derive(Default)]
pub struct Aout {
    /// Where its timer begins again, 0 without an output.
    pub top: u16,
    /// Count from which on the pin is high.
    pub compare: u16,
    /// Its value.
    pub value: u16,
    /// The value before a pause.
    pub resume: u16,
}

impl<C: Chip> Controller<C> {
    /// Whether Stop is held or a hold, door or emergency stop input is active.
    pub fn blocked(&self) -> bool {
        self.io.buttons.accepted() & 1 != 0 || self.blocking() != 0
    }

    /// The input that blocks, 0 for none, [`UNWIRED`] while nobody has said how the board is wired.
    pub fn blocking(&self) -> u8 {
        if !self.wired() {
            return UNWIRED as u8;
        }
        let record = &self.record;
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
            1..=16 => self.io.inputs.levels() >> (n - 1) & 1 != 0,
            17 if self.chained() => self.chip.probe() != (self.record.input_invert_high != 0),
            FIRST_THRESHOLD..=LAST_THRESHOLD => self.io.analog.on >> (n - FIRST_THRESHOLD) & 1 != 0,
            _ => false,
        }
    }

    /// An input before its filter: switches and probes are watched step by step.
    pub fn unfiltered(&self, number: u8) -> bool {
        match number {
            1..=16 => self.io.raw >> (number - 1) & 1 != 0,
            _ => self.input(number),
        }
    }

    /// Chain wiring, otherwise direct.
    pub fn chained(&self) -> bool {
        self.record.flags & BoardRecord::CHAIN != 0
    }

    /// Whether somebody has said how the board is wired. Before that each of its pins is left to its resistor, as what is
    /// off or at rest in one wiring is on in another, and nothing starts or moves.
    pub fn wired(&self) -> bool {
        self.record.flags & BoardRecord::UNWIRED == 0
    }

    /// Outputs that there are, as a mask.
    pub fn all_outputs(&self) -> u16 {
        match (self.wired(), self.chained()) {
            (false, _) => 0,
            (true, true) => 0xFFFF,
            (true, false) => 0b11,
        }
    }

    /// Whether output `n`, from 1, is there and a program may switch it: enable and lamp are the controller's.
    pub fn may_switch(&self, n: u8) -> bool {
        let own = self.record.enable == n || self.record.lamp == n;
        !own && self.all_outputs() >> (n.wrapping_sub(1) & 15) & 1 != 0
    }

    /// Sets an output as a program or a host asks, so that no pulse that lasts there switches it off later.
    #[inline(never)]
    pub fn command_output(&mut self, n: u16, on: bool) -> bool {
        self.motor.actions.take_over(1 << (n.wrapping_sub(1) & 15));
        self.set_output(n, on)
    }

    /// Sets an output, numbered from 1; `false` beyond those there are.
    pub fn set_output(&mut self, n: u16, on: bool) -> bool {
        if n == 0 || n > 16 || self.all_outputs() >> (n - 1) & 1 == 0 {
            return false;
        }
        let bit = 1 << (n - 1);
        self.io.outputs &= !bit;
        if on {
            self.io.outputs |= bit;
        }
        true
    }

    /// Sends the outputs and takes the inputs 1 to 16, before the filter: as they are, for that, without forcing.
    pub(super) fn exchange(&mut self) -> u16 {
        self.drive_pwm();
        self.drive_aout();
        let outputs = match self.record.laser {
            0 => self.io.outputs,
            laser => self.light.shine(&self.chip, laser, self.io.outputs, &self.motor),
        };
        let levels = outputs ^ self.record.output_invert;
        let fault = self.io.outputs & self.record.fault.keep | self.record.fault.on;
        self.chip.remember_stop(fault ^ self.record.output_invert);
        let raw = match (self.wired(), self.chained()) {
            (false, _) => 0,
            (true, true) => self.chip.exchange(levels),
            (true, false) => self.chip.pins(levels),
        };
        let raw = raw ^ self.record.input_invert;
        self.io.raw = self.io.inputs.forced(raw);
        raw
    }

    /// The status lamp: off without a program, lit when ready, blinking slowly in a run and fast in
    /// a pause, a fault's number in blinks, and once that of a program that the button for the next one chose.
    pub(super) fn lamp(&mut self) {
        let n = self.record.lamp;
        if n == 0 {
            return;
        }
        self.clock.blink = self.clock.blink.wrapping_add(1);
        let on = match self.session.state {
            EMPTY => false,
            READY if self.library.shown != 0 => {
                let blinks = u16::from(self.library.shown);
                if self.clock.blink >= (blinks + 4) * 256 {
                    self.library.shown = 0;
                }
                self.clock.blink < blinks * 256 && self.clock.blink & 128 != 0
            }
            READY => true,
            RUNNING => self.clock.blink & 512 != 0,
            FAULT => {
                let blinks = u16::from(self.session.fault);
                if self.clock.blink >= (blinks + 4) * 256 {
                    self.clock.blink = 0;
                }
                self.clock.blink < blinks * 256 && self.clock.blink & 128 != 0
            }
            _ => self.clock.blink & 128 != 0,
        };
        self.set_output(u16::from(n), on);
    }
}
