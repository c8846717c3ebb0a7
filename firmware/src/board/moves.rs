//! Effects that move axes to a place or at a speed; what the rules of paces and of axes on their own look at and do.

use crate::controller::Controller;
use crate::motor::AXES;
use crate::vm::{axis, machine, vm};
use firmware::motion::math::{signed, size};
use firmware::motion::scaled::Scaled;
use firmware::motion::{Feed, Pace};
use firmware::rules::axes::Axes;
use firmware::rules::pace::{self, Paces};
use firmware::rules::{Axis, Progress};
use lang::fault::Fault;
use lang::isa::{Op, SHORT_AXES, first, flags, last};
use lang::place::{Place, Target, way};
use lang::wire::TraceKind;

/// The feed that holds when no F was written.
pub fn default_feed() -> Feed {
    match machine().default_feed {
        0 => Feed::Rapid,
        feed => Feed::Um(feed),
    }
}

impl Controller {
    /// MoveSpeed.
    ///
    /// # Errors
    /// F08.
    pub fn move_speed(&mut self) -> Result<bool, Fault> {
        let bits = vm().operand();
        let axis = pace::axis_flags(self, bits);
        let value = vm().pop();
        if bits & flags::STEPS != 0 {
            self.count_in_steps();
        } else {
            self.count_in_um();
        }
        let speed = pace::rate_of(self, axis, size(value) as i32);
        let speed = pace::speed_least(self, speed);
        if speed == Scaled::ZERO {
            return Err(Fault::SpeedRange);
        }
        let shown = speed.floor() as i32;
        let n = axis.n();
        let limit = self.motor.limit(n, value < 0);
        let here = self.motor.position(n);
        if limit.is_some_and(|end| if value < 0 { here <= end } else { here >= end }) {
            return Err(Fault::SoftLimit);
        }
        self.emit(TraceKind::Speed, n, signed(shown, value));
        self.motor.run(n, value < 0, limit, self.seek.plan.pace);
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

impl Paces for Controller {
    fn flags(&self) -> u8 {
        self.program.effect.bits
    }
    fn keep_flags(&mut self, flags: u8) {
        self.program.effect.bits = flags;
    }
    fn set_unit(&mut self, flags: u8) {
        self.command.unit = flags;
    }
    fn brings_rate(&self) -> bool {
        self.command.unit & (flags::ACCEL | flags::DECEL | flags::SPEED) != 0
    }
    fn counts_steps(&self) -> bool {
        self.command.unit & (flags::ACCEL_STEPS | flags::DECEL_STEPS | flags::SPEED_STEPS) != 0
    }
    fn count_in_steps(&mut self) {
        self.command.unit = flags::ACCEL_STEPS;
    }
    fn count_in_um(&mut self) {
        self.command.unit = 0;
    }
    fn steps_of(&self, n: Axis) -> u16 {
        axis(n.n()).steps
    }
    fn um_of(&self, n: Axis) -> u16 {
        axis(n.n()).um
    }
    fn take_pace(&mut self, n: Axis) {
        self.seek.plan.pace = Pace::of(axis(n.n()));
    }
    fn least_up(&mut self, rate: Scaled) -> Scaled {
        let pace = &mut self.seek.plan.pace;
        pace.accel = pace.accel.least(rate);
        pace.accel
    }
    #[inline(never)]
    fn least_speed(&mut self, rate: Scaled) -> Scaled {
        let pace = &mut self.seek.plan.pace;
        pace.speed = pace.speed.least(rate);
        pace.speed
    }
    fn least_down(&mut self, rate: Scaled) -> Scaled {
        let pace = &mut self.seek.plan.pace;
        pace.decel = pace.decel.least(rate);
        pace.decel
    }
    fn pace_up(&self) -> Scaled {
        self.seek.plan.pace.accel
    }
    fn pace_speed(&self) -> Scaled {
        self.seek.plan.pace.speed
    }
}

impl Axes for Controller {
    fn set_code(&mut self, _: u8) {}
    fn is_move(&self) -> bool {
        self.program.effect.code == Op::Move as u8
    }
    fn short_flags(&self, code: u8) -> u8 {
        match code.wrapping_sub(first::MoveTo) {
            n @ 0..=2 => n,
            n => (n - 3) | flags::RELATIVE,
        }
    }
    fn ramps(&self) -> u8 {
        self.program.effect.left as u8
    }
    fn set_ramps(&mut self, flags: u8) {
        self.program.effect.left = flags.into();
    }
    fn has_decel(&self) -> bool {
        self.ramps() & flags::DECEL != 0
    }
    fn take_move_frame(&mut self) {}
    // Nothing fails behind it: the place is commanded at once.
    fn aim_move(&mut self, axis: Axis, target: i32) -> Result<(), Fault> {
        let (n, bits) = (axis.n(), self.program.effect.bits);
        let target = Target {
            value: target,
            in_steps: bits & flags::STEPS != 0,
            frame: if bits & flags::RELATIVE != 0 { Target::RELATIVE } else { Target::WORK },
        };
        // MoveSpeed has no target: what counts from one does so from where the axis is.
        if self.motor.running() >> n & 1 != 0 {
            self.motor.settle_here(n);
        }
        let place = self.motor.aim(n, target)?;
        way(self.motor.position(n), place.steps)?;
        self.program.effect.left = self.motor.command(n, place);
        Ok(())
    }
    fn command_place(&mut self, _: Axis) -> bool {
        self.program.effect.left == 0
    }
    fn is_sent_again(&self, axis: Axis) -> bool {
        self.motor.moves(axis.n())
    }
    fn set_out(&mut self, axis: Axis) -> Progress {
        let place = self.motor.steps[axis.i()];
        self.motor.go(axis.n(), place, self.seek.plan.pace, false);
        Ok(self.program.effect.bits & flags::START != 0 || Axes::moving(self) == 0)
    }
    fn moving(&self) -> u8 {
        self.motor.moving() & 1 << self.program.effect.n
    }
    fn goes_on(&mut self) -> bool {
        !self.program.first()
    }
    fn stop_axis(&mut self, n: u8) {
        self.program.effect.bits = 1 << n;
        self.motor.stop(1 << n);
    }
    fn stop_axes(&mut self) {
        self.program.effect.bits = 0b111;
        self.motor.stop(0b111);
    }
    fn tells_stops(&mut self) -> bool {
        while self.program.effect.n < AXES {
            self.emit(TraceKind::Stop, self.program.effect.n, 0);
            self.program.effect.n += 1;
            if self.trace.full {
                return true;
            }
        }
        false
    }
    fn await_axis(&mut self, n: u8) -> Result<(), Fault> {
        let axes = if n < AXES { 1 << n } else { 0b111 };
        self.program.effect.bits = axes;
        if self.motor.running() & axes != 0 { Err(Fault::ValueRange) } else { Ok(()) }
    }
    fn awaits_move(&self) -> bool {
        self.motor.moving() & self.program.effect.bits != 0
    }
}
