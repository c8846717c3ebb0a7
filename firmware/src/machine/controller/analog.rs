//! Analog inputs as the program and the roles of the profile see them.

use super::Controller;
use crate::analog::{ANALOGS, FIRST_THRESHOLD, LAST_THRESHOLD, crosses, filtered, millivolts};
use crate::machine::chip::Chip;
use lang::isa::Look;
use lang::record::ThresholdRecord;

impl<C: Chip> Controller<C> {
    /// The analog inputs that the profile uses, as bits from 0.
    pub(super) fn analog_used(&self) -> u8 {
        let mut used = 0;
        for (n, levels) in self.record.more().thresholds.iter().enumerate() {
            if levels.off & ThresholdRecord::USED != 0 {
                used |= 1 << n;
            }
        }
        used
    }

    /// The analog inputs that the profile uses get their pins.
    pub fn open_analog(&self) {
        self.chip.open_analog(self.analog_used());
    }

    /// A millisecond of the analog inputs.
    pub(super) fn sample_analog(&mut self) {
        let used = self.analog_used();
        if used == 0 {
            return;
        }
        let record = self.record.clone();
        let thresholds = &record.more().thresholds;
        let analog = &mut self.io.analog;
        for (n, levels) in thresholds.iter().enumerate() {
            let sample = self.chip.analog(n as u8);
            let value = &mut analog.values[n];
            *value = if analog.begun { filtered(*value, sample, levels.filter()) } else { sample };
        }
        analog.begun = true;
        for (n, levels) in thresholds.iter().enumerate() {
            let source = usize::from(levels.analog());
            if source != 0 {
                let value = analog.values[(source - 1) % ANALOGS];
                let was = analog.on >> n & 1 != 0;
                analog.on = analog.on & !(1 << n) | u8::from(crosses(*levels, value, was)) << n;
            }
        }
        self.chip.convert_analog();
    }

    /// Whether no analog input is on its way through its filter.
    #[cfg(any(test, feature = "physics"))]
    pub fn analog_is_settled(&self) -> bool {
        self.io.analog.is_settled(|n| self.chip.analog(n), self.analog_used())
    }

    /// The voltage at an analog input, from 0, mV.
    pub fn millivolts(&self, n: u8) -> u16 {
        millivolts(self.io.analog.values[usize::from(n) % ANALOGS], C::mul_div)
    }

    /// Whether the board has the input: one of the wiring, or one that a threshold makes.
    pub fn has_input(&self, n: u8) -> bool {
        match n {
            FIRST_THRESHOLD..=LAST_THRESHOLD => {
                self.record.more().thresholds[usize::from(n - FIRST_THRESHOLD)].analog() != 0
            }
            _ => n != 0 && n < FIRST_THRESHOLD,
        }
    }

    /// Where the operand of `read` asks for an analog input, its voltage goes on the stack, and `true` comes back; else the
    /// operand is still there.
    pub fn look_at_analog(&mut self) -> bool {
        let look = self.vm.next_operand();
        if look >> 2 != Look::Analog as u8 {
            return false;
        }
        self.vm.operand();
        let mv = self.millivolts(look & 3);
        self.vm.push(mv.into());
        true
    }
}
