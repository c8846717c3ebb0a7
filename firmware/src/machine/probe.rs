//! Probe and ProbeMask: state and actions behind [`crate::rules::probe`].

use crate::machine::chip::Chip;
use crate::machine::controller::Controller;
use crate::motion::Feed;
use crate::rules::Axis;
use crate::rules::probe::{MOVES, Probes};
use lang::fault::Fault;
use lang::isa::flags;
use lang::place::Target;

impl<C: Chip> Controller<C> {
    fn inputs_answer(&self) -> bool {
        let mut inputs = u32::from(self.io.raw);
        if self.input(17) {
            inputs |= 1 << 16;
        }
        inputs |= u32::from(self.io.analog.on) << 17;
        self.seek.probes(inputs)
    }

    /// The probe pin stops the counting at its very step. That of a forced input says nothing: its level is looked at
    /// each millisecond.
    pub fn watch_probe(&mut self) {
        let and = self.seek.and;
        let pin = if !self.chained() {
            ((and as u8 & !self.io.inputs.is_forced() as u8) << 4) & 0xF0
        } else if and == 1 << 16 {
            C::PROBE
        } else {
            0
        };
        if pin != 0 {
            let mut inverted = self.record.input_invert_high != 0;
            if !self.chained() {
                inverted = self.record.input_invert & and as u16 != 0;
            }
            let idle = if (self.seek.xor == 0) != inverted { pin } else { 0 };
            self.chip.watch(pin, idle, false);
        } else {
            self.chip.watch(0, 0, false);
        }
    }
}

impl<C: Chip> Probes for Controller<C> {
    fn comes_later(&mut self, axis: Axis) -> bool {
        let later = self.motor.moves(axis.n());
        if later {
            self.vm_back();
            self.program.effect.phase = 0;
        }
        later
    }
    fn take_sensor(&mut self) {
        self.program.effect.left = self.vm.operand().into();
    }
    fn has_masks(&self) -> bool {
        self.program.effect.left as u8 & flags::MASK != 0
    }
    fn has_sensor(&self) -> bool {
        self.program.effect.left as u8 & flags::SENSOR != 0
    }
    fn sensor(&self) -> u8 {
        self.record.probe
    }
    fn await_off(&mut self, inputs: i32) {
        self.seek.xor = inputs as u32;
    }
    fn await_of(&mut self, inputs: i32) {
        self.seek.and = inputs as u32;
    }
    #[inline(never)]
    fn await_input(&mut self, n: u8) {
        self.seek.and = 1 << ((n - 1) & 31);
        self.seek.xor = if self.program.level != 0 { 0 } else { self.seek.and };
    }
    fn has_speed(&self) -> bool {
        self.program.effect.bits & flags::SPEED != 0
    }
    fn feed(&self) -> i32 {
        match self.program.feed {
            Feed::Rapid => 0,
            Feed::Um(feed) => feed as i32,
            Feed::Steps(feed) => (feed as i32).wrapping_neg(),
        }
    }
    fn take_frame(&mut self) {}
    fn aim_at(&mut self, axis: Axis, limit: i32) -> Result<(), Fault> {
        let bits = self.program.effect.bits;
        let limit = Target {
            value: limit,
            in_steps: bits & flags::STEPS != 0,
            frame: bits >> flags::PROBE_FRAME & 3,
        };
        self.command.places[axis.i()] = self.motor.aim(axis.n(), limit)?.steps;
        Ok(())
    }
    fn begin_probe(&mut self, axis: Axis) -> bool {
        self.motor.probe_ok &= !axis.bit();
        if self.inputs_answer() {
            return false;
        }
        self.watch_probe();
        let target = self.command.places[axis.i()];
        self.motor.settle(axis.n(), target);
        self.motor.go(axis.n(), target, self.seek.plan.pace, true);
        self.program.effect.phase = MOVES;
        true
    }
    fn axis(&self) -> Axis {
        Axis::new(self.program.effect.n)
    }
    fn phase(&self) -> u8 {
        self.program.effect.phase
    }
    fn set_phase(&mut self, phase: u8) {
        self.program.effect.phase = phase;
    }
    fn next_phase(&mut self) {
        self.program.effect.phase += 1;
    }
    fn hit(&self) -> u8 {
        self.chip.hit()
    }
    fn caught(&mut self, axis: Axis) -> i32 {
        self.chip.caught(axis.i(), self.motor.position(axis.n()))
    }
    fn answers(&self) -> bool {
        self.inputs_answer()
    }
    fn moving_of(&self, axis: Axis) -> u8 {
        u8::from(self.motor.moves(axis.n()))
    }
    fn probed(&self, axis: Axis) -> i32 {
        self.motor.probed[axis.i()]
    }
    fn set_probed(&mut self, axis: Axis, steps: i32) {
        self.motor.probed[axis.i()] = steps;
    }
    fn set_answered(&mut self, axis: Axis) {
        self.motor.probe_ok |= axis.bit();
    }
    fn brake_from(&mut self, axis: Axis, steps: i32) {
        self.motor.hit(axis.n(), steps);
    }
    fn watch_nothing(&mut self) {
        self.chip.watch(0, 0, false);
    }
    fn is_asked(&self) -> bool {
        self.program.effect.bits & flags::QUERY != 0
    }
}
