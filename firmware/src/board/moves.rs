//! Effects that move axes to a place or at a speed.

use crate::controller::Controller;
use crate::motor::AXES;
use crate::vm::{axis, machine, vm};
use firmware::motion::math::{signed, size};
use firmware::motion::scaled::Scaled;
use firmware::motion::single::steps_of;
use firmware::motion::{Feed, Pace};
use lang::fault::Fault;
use lang::isa::{SHORT_AXES, first, flags, last};
use lang::place::{Place, Target, way};
use lang::wire::TraceKind;

/// A speed or ramp that must be above 0, in steps.
pub fn rate(n: u8, value: i32, in_steps: bool) -> Result<Scaled, Fault> {
    if value <= 0 {
        return Err(Fault::SpeedRange);
    }
    Ok(if in_steps { Scaled::new(value as u32) } else { steps_of(axis(n), value as u32) })
}

/// The feed that holds when no F was written.
pub fn default_feed() -> Feed {
    match machine().default_feed {
        0 => Feed::Rapid,
        feed => Feed::Um(feed),
    }
}

impl Controller {
    /// MoveAxe and MoveRel.
    ///
    /// # Errors
    /// Those of the target and of the speed.
    pub fn move_axe(&mut self, code: u8) -> Result<bool, Fault> {
        if self.program.first() {
            let bits = match code.wrapping_sub(first::MoveTo) {
                n @ 0..=2 => n,
                n @ 3..=5 => (n - 3) | flags::RELATIVE,
                _ => vm().operand(),
            };
            let n = bits & flags::AXIS;
            let mut ramps = 0;
            if code == first::MoveRamp {
                ramps = vm().operand();
            }
            let mut pace = Pace::of(axis(n));
            let (mut accel, mut decel) = (None, None);
            if ramps & flags::DECEL != 0 {
                decel = Some(rate(n, vm().pop(), ramps & flags::DECEL_STEPS != 0)?);
            }
            if ramps & flags::ACCEL != 0 {
                accel = Some(rate(n, vm().pop(), ramps & flags::ACCEL_STEPS != 0)?);
            }
            if let Some(accel) = accel {
                pace.accel = pace.accel.least(accel);
            }
            if let Some(decel) = decel.or(accel) {
                pace.decel = pace.decel.least(decel);
            }
            if bits & flags::SPEED != 0 {
                let speed = rate(n, vm().pop(), bits & flags::SPEED_STEPS != 0)?;
                pace.speed = pace.speed.least(speed);
            }
            let target = Target {
                value: vm().pop(),
                in_steps: bits & flags::STEPS != 0,
                frame: if bits & flags::RELATIVE != 0 { Target::RELATIVE } else { Target::WORK },
            };
            self.program.effect.n = n;
            self.program.effect.bits = bits;
            // MoveSpeed has no target: what counts from one does so from where the axis is.
            if self.motor.running() >> n & 1 != 0 {
                self.motor.settle_here(n);
            }
            let place = self.motor.aim(n, target)?;
            way(self.motor.position(n), place.steps)?;
            let distance = self.motor.command(n, place);
            if distance != 0 {
                self.emit(TraceKind::Axe, n, 0);
            }
            if distance != 0 || self.motor.moves(n) {
                self.motor.go(n, place.steps, pace, false);
            }
        }
        let busy = self.motor.moves(self.program.effect.n);
        Ok(self.program.effect.bits & flags::START != 0 || !busy)
    }

    /// MoveSpeed.
    ///
    /// # Errors
    /// F08.
    pub fn move_speed(&mut self) -> Result<bool, Fault> {
        let bits = vm().operand();
        let n = bits & flags::AXIS;
        let value = vm().pop();
        let speed = rate(n, size(value) as i32, bits & flags::STEPS != 0)?;
        let mut pace = Pace::of(axis(n));
        pace.speed = pace.speed.least(speed);
        let shown = pace.speed.floor() as i32;
        let limit = self.motor.limit(n, value < 0);
        let here = self.motor.position(n);
        if limit.is_some_and(|end| if value < 0 { here <= end } else { here >= end }) {
            return Err(Fault::SoftLimit);
        }
        self.emit(TraceKind::Speed, n, signed(shown, value));
        self.motor.run(n, value < 0, limit, pace);
        Ok(true)
    }

    /// G0 and G1.
    ///
    /// # Errors
    /// Those of the targets.
    pub fn linear(&mut self, code: u8) -> Result<bool, Fault> {
        // A feed block joins the path when there is room; axes of their own must rest first, and
        // everything before a rapid move.
        if self.program.effect.phase == 0 {
            let rapid = match code {
                first::Rapid..=last::Rapid => true,
                first::Line..=last::Line => false,
                _ => {
                    let bits = vm().operand();
                    self.vm_back();
                    bits & flags::RAPID != 0
                }
            };
            let alone = rapid || self.motor.path_rests();
            if alone && self.motor.moving() != 0 || !self.path_has_room() {
                return Ok(false);
            }
            self.program.effect.phase = 1;
            let mut frames = 0;
            let bits = match code {
                first::Rapid..=last::Rapid => {
                    SHORT_AXES[usize::from(code - first::Rapid)].0 | flags::RAPID
                }
                first::Line..=last::Line => SHORT_AXES[usize::from(code - first::Line)].0,
                _ => vm().operand(),
            };
            let mut in_steps = if bits & flags::COMMON_STEPS != 0 { 0xFF } else { 0 };
            if code == first::LinearMixed {
                frames = vm().operand();
                in_steps = bits >> 5;
            } else if code == first::Linear {
                frames = (bits >> flags::COMMON_FRAME) * 0b01_0101;
            }
            let mut places = [Place::default(); 3];
            let mut n = AXES;
            while n != 0 {
                n -= 1;
                if bits >> n & 1 == 0 {
                    continue;
                }
                let target = Target {
                    value: vm().pop(),
                    in_steps: in_steps >> n & 1 != 0,
                    frame: frames >> (2 * n) & 3,
                };
                places[usize::from(n)] = self.motor.aim(n, target)?;
            }
            let (mut steps, mut um) = ([0; 3], [0; 3]);
            let mut moved = 0;
            n = AXES;
            while n != 0 {
                n -= 1;
                if bits >> n & 1 != 0 {
                    let i = usize::from(n);
                    um[i] = places[i].um.wrapping_sub(self.motor.um[i]);
                    steps[i] = self.motor.command(n, places[i]);
                    moved |= steps[i];
                }
            }
            let rapid = bits & flags::RAPID != 0;
            // A rapid move rests at its end, as the trace of what follows it promises.
            self.program.effect.bits = u8::from(rapid || bits & flags::EXACT != 0);
            if moved == 0 {
                return Ok(true);
            }
            let tag = self.tell_block(if rapid { TraceKind::Rapid } else { TraceKind::Line });
            if rapid {
                self.motor.rapid(steps, tag);
            } else {
                self.motor.line(steps, um, self.program.feed, self.program.effect.bits != 0, tag);
            }
        }
        Ok(self.program.effect.bits == 0 || self.motor.path_rests())
    }

    /// Takes back the first operand: the effect begins again later.
    pub fn vm_back(&mut self) {
        vm().pc -= 1;
    }
}
