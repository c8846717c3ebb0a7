//! The effect of G2 and G3.

use crate::machine::chip::Chip;
use crate::machine::controller::Controller;
use crate::machine::motor::AXES;
use crate::motion::{Arc, Ends};
use lang::effect::Plane;
use lang::fault::Fault;
use lang::isa::{Op, flags};
use lang::place::{Place, Target};
use lang::vm::effects::ALL_RELATIVE;
use lang::wire::TraceKind;

impl<C: Chip> Controller<C> {
    /// G2 and G3.
    ///
    /// # Errors
    /// Those of the targets, F09, F05 when an extreme lies outside the travel.
    pub fn arc(&mut self, code: u8) -> Result<bool, Fault> {
        if self.program.effect.phase == 0 {
            let alone = self.motor.path_rests() && self.motor.busy() != 0;
            if alone || !self.path_has_room() {
                return Ok(false);
            }
            self.program.effect.phase = 1;
            let bits = self.vm.operand();
            let (mut frames, mut in_steps) = (0, 0);
            if code == Op::ArcMixed as u8 {
                frames = self.vm.operand();
                in_steps = self.vm.operand();
            } else if code == Op::ArcBy as u8 {
                frames = ALL_RELATIVE;
            }
            self.program.effect.bits = u8::from(bits & flags::EXACT != 0);
            let arc = self.pop_arc(bits, frames, in_steps)?;
            let tag = self.tell_block(TraceKind::Arc);
            self.motor.arc(&arc, self.program.feed, self.program.effect.bits != 0, tag);
        }
        Ok(self.program.effect.bits == 0 || self.motor.path_rests())
    }

    /// Takes the words from the stack, tests them, and makes the end the commanded place.
    fn pop_arc(&mut self, bits: u8, frames: u8, in_steps: u8) -> Result<Arc, Fault> {
        let first = match bits >> flags::PLANE {
            n if n == Plane::Xy as u8 => 0,
            n if n == Plane::Yz as u8 => 1,
            _ => 2,
        };
        let around = bits & flags::OFFSETS != 0;
        // Offsets lie on the stack in axis order, the last on top.
        let mut offsets = [0; 3];
        let mut radius = 0;
        if around {
            let mut n = AXES;
            while n != 0 {
                n -= 1;
                // The axis before the plane's first one is the helix axis.
                if n != (first + 2) % AXES {
                    offsets[usize::from(n)] = self.length(n, in_steps >> (3 + n) & 1 != 0)?;
                }
            }
        } else {
            radius = self.length(first, in_steps >> 3 & 1 != 0)?;
        }
        let (from_um, start) = (self.motor.um, self.motor.steps);
        let mut places = [Place::default(); 3];
        let (mut to_um, mut end) = (from_um, start);
        let mut n = AXES;
        while n != 0 {
            n -= 1;
            if bits >> n & 1 != 0 {
                let target = Target {
                    value: self.vm.pop(),
                    in_steps: in_steps >> n & 1 != 0,
                    frame: frames >> (2 * n) & 3,
                };
                let i = usize::from(n);
                let place = self.motor.aim(n, target)?;
                places[i] = place;
                (to_um[i], end[i]) = (place.um, place.steps);
            }
        }
        let clockwise = bits & flags::CLOCKWISE != 0;
        let ends = Ends { first, clockwise, from_um, to_um, start, end };
        let arc = if around {
            let (a, b) = (usize::from(first), usize::from((first + 1) % AXES));
            ends.around([offsets[a], offsets[b]])?
        } else {
            ends.with_radius(radius)?
        };
        for (i, span) in arc.extremes().iter().enumerate() {
            let n = (first + i as u8) % AXES;
            let homed = self.motor.homed >> n & 1 != 0;
            if homed && (span[0] < self.motor.axis(n).min || span[1] > self.motor.axis(n).max) {
                return Err(Fault::SoftLimit);
            }
        }
        n = AXES;
        while n != 0 {
            n -= 1;
            if bits >> n & 1 != 0 {
                self.motor.command(n, places[usize::from(n)]);
            }
        }
        Ok(arc)
    }

    /// A length from the stack, um.
    fn length(&mut self, n: u8, in_steps: bool) -> Result<i32, Fault> {
        let value = self.vm.pop();
        if in_steps { self.motor.convert(n, value, false) } else { Ok(value) }
    }
}
