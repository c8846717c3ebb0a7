//! Probe and ProbeMask.

use crate::controller::Controller;
use crate::moves::rate;
use crate::step;
use crate::vm::{axis, vm};
use firmware::motion::scaled::Scaled;
use firmware::motion::single::steps_of;
use firmware::motion::{Feed, Pace};
use lang::fault::Fault;
use lang::isa::flags;
use lang::place::Target;
use lang::wire::TraceKind;

impl Controller {
    /// Probe, ProbeMask.
    ///
    /// # Errors
    /// F19, F12, those of the limit and of the speed.
    pub fn probe(&mut self) -> Result<bool, Fault> {
        if self.program.effect.phase == 0 {
            let bits = vm().operand();
            let n = bits & flags::AXIS;
            if self.motor.moves(n) {
                self.vm_back();
                return Ok(false);
            }
            let sensor = vm().operand();
            let and;
            let mut xor = 0u32;
            if sensor & flags::MASK != 0 {
                xor = vm().pop() as u32;
                and = vm().pop() as u32;
            } else {
                let mut number = u16::from(self.record.probe);
                let mut on = true;
                if sensor & flags::SENSOR != 0 {
                    on = vm().pop() != 0;
                    number = vm().pop_small(17);
                }
                if number == 0 || number > 17 {
                    return Err(Fault::ValueRange);
                }
                and = 1 << (number - 1);
                if !on {
                    xor = and;
                }
            }
            let mut pace = Pace::of(axis(n));
            if bits & flags::SPEED != 0 {
                pace.speed = pace.speed.least(rate(n, vm().pop(), bits & flags::SPEED_STEPS != 0)?);
            } else {
                pace.speed = match self.program.feed {
                    Feed::Rapid => return Err(Fault::SpeedRange),
                    Feed::Um(feed) => pace.speed.least(steps_of(axis(n), feed)),
                    Feed::Steps(feed) => pace.speed.least(Scaled::new(feed)),
                };
            }
            let limit = Target {
                value: vm().pop(),
                in_steps: bits & flags::STEPS != 0,
                frame: bits >> flags::PROBE_FRAME & 3,
            };
            let place = self.motor.aim(n, limit)?;
            self.program.effect.n = n;
            self.program.effect.bits = bits;
            self.program.effect.phase = 1;
            if let Err(fault) = self.begin_probe(and, xor, place.steps, pace) {
                self.emit_outcome(TraceKind::Probe, n, false, self.motor.position(n));
                return Err(fault);
            }
            return Ok(false);
        }
        let n = self.program.effect.n;
        let i = usize::from(n);
        if self.program.effect.phase == 1 {
            let position = self.motor.position(n);
            let pin = step::hit() != 0;
            if pin || self.probed() {
                let caught = if pin { step::caught(i, position) } else { position };
                self.motor.probed[i] = caught;
                self.motor.probe_ok |= 1 << n;
                self.motor.hit(n, caught);
                self.program.effect.phase = 2;
            } else if !self.motor.moves(n) {
                self.program.effect.phase = 3;
            }
            return Ok(false);
        }
        if self.motor.moves(n) {
            return Ok(false);
        }
        step::watch(0, 0, false);
        let ok = self.program.effect.phase == 2;
        let place = if ok { self.motor.probed[i] } else { self.motor.position(n) };
        self.emit_outcome(TraceKind::Probe, n, ok, place);
        if !ok && self.program.effect.bits & flags::QUERY == 0 {
            return Err(Fault::ProbeMissed);
        }
        Ok(true)
    }

    /// Begins a probe move to `target` steps until `(inputs & and) ^ xor` is not 0.
    ///
    /// # Errors
    /// F19.
    pub fn begin_probe(
        &mut self,
        and: u32,
        xor: u32,
        target: i32,
        pace: Pace,
    ) -> Result<(), Fault> {
        let n = self.program.effect.n;
        self.seek.and = and;
        self.seek.xor = xor;
        self.motor.probe_ok &= !(1 << n);
        if self.probed() {
            return Err(Fault::InputActive);
        }
        // The probe pin stops the counting at its very step.
        let pin = if !self.chained() {
            ((and as u8) << 4) & 0xF0
        } else if and == 1 << 16 {
            crate::chip::ports::PROBE
        } else {
            0
        };
        if pin != 0 {
            let mut inverted = self.record.input_invert_high != 0;
            if !self.chained() {
                inverted = self.record.input_invert & and as u16 != 0;
            }
            let idle = if (xor == 0) != inverted { pin } else { 0 };
            step::watch(pin, idle, false);
        }
        self.motor.settle(n, target);
        self.motor.go(n, target, pace, true);
        Ok(())
    }

    fn probed(&self) -> bool {
        let mut inputs = u32::from(self.io.raw);
        if self.input(17) {
            inputs |= 1 << 16;
        }
        self.seek.probes(inputs)
    }
}
