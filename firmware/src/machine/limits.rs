//! Limit switches and the emergency stop while axes move.

use crate::machine::chip::Chip;
use crate::machine::controller::Controller;
use crate::machine::motor::AXES;
use lang::fault::Fault;
use lang::isa::Op;
use lang::record::{AxisRecord, BoardRecord};

impl<C: Chip> Controller<C> {
    /// Reference switches outside homing: an axis that moves toward its closed switch stops (F06).
    pub fn limits(&mut self) {
        let axes = self.approaching();
        let (mut pins, mut inputs) = (0, 0);
        let mut watch = |record: &BoardRecord, input: u8| {
            pins |= record.pin(input);
            if record.flags & BoardRecord::CHAIN != 0 && matches!(input, 1..=16) {
                inputs |= 1 << (input - 1);
            }
        };
        for n in self.record.emergency {
            // One that is pressed already has been seen to.
            if !self.unfiltered(n) {
                watch(&self.record, n);
            }
        }
        let mut n = AXES;
        while n != 0 {
            n -= 1;
            if axes >> n & 1 != 0 {
                let input = self.record.reference[usize::from(n)];
                watch(&self.record, input);
                if self.unfiltered(input) {
                    self.limited(n);
                }
            }
        }
        self.chip.guard(pins, inputs);
    }

    /// Bit per axis that moves toward its reference switch without looking for it.
    fn approaching(&self) -> u8 {
        let moving = self.motor.moving();
        // What was halted at once says that it moves until it has been looked at.
        if moving == 0 || self.motor.rests() {
            return 0;
        }
        let homing = (Op::Home as u8..=Op::HomeQuery as u8).contains(&self.program.effect.code);
        let mut axes = 0;
        let mut n = AXES;
        while n != 0 {
            n -= 1;
            let toward = self.motor.axis(n).flags & AxisRecord::HOME_POSITIVE != 0;
            let positive = self.motor.negative >> n & 1 == 0;
            if moving >> n & 1 != 0 && toward == positive && !(homing && self.program.effect.n == n)
            {
                axes |= 1 << n;
            }
        }
        axes
    }

    /// An axis has met its limit switch.
    #[inline(never)]
    fn limited(&mut self, n: u8) {
        self.motor.halt();
        self.motor.homed &= !(1 << n);
        self.program.fault_input = self.record.reference[usize::from(n)];
        self.fail(Fault::LimitSwitch);
    }

    /// An input has stopped the engine: what follows from it.
    #[inline(never)]
    pub fn tripped(&mut self) {
        let pins = self.chip.tripped();
        if pins == 0 {
            return;
        }
        let answered = self.chip.answered();
        self.motor.halt();
        let record = self.record.clone();
        let has = |input: u8| {
            let chained = matches!(input, 1..=16) && answered >> (input - 1) & 1 != 0;
            chained || pins & record.pin(input) != 0
        };
        if let Some(n) = record.emergency.into_iter().find(|n| has(*n)) {
            self.emergency(n);
            return;
        }
        let mut n = AXES;
        while n != 0 {
            n -= 1;
            if has(record.reference[usize::from(n)]) {
                self.limited(n);
            }
        }
    }
}
