//! Effects that move axes.

use crate::core::Core;
use crate::motor::{AXES, Target};
use crate::vm::{axis, convert, machine, vm};
use crate::{guard, step};
use firmware::motion::math::{signed, size};
use firmware::motion::scaled::Scaled;
use firmware::motion::single::steps_of;
use firmware::motion::{Feed, Pace};
use lang::fault::Fault;
use lang::isa::{Op, SHORT_AXES, flags};
use lang::record::{AxisRecord, BoardRecord, FULL_POWER};
use lang::wire::TraceKind;

/// Phases of homing.
const FAST: u8 = 1;
const REST: u8 = 2;
const PAUSE: u8 = 3;
const SLOW: u8 = 4;
const OPEN: u8 = 5;
const CLEAR: u8 = 6;
/// The plan is made.
pub const BEGIN: u8 = 7;

/// A reference run, in steps.
pub struct Plan {
    /// Input number of the switch.
    pub input: u8,
    /// Its level when closed.
    pub closed: bool,
    /// It lies in positive direction.
    pub positive: bool,
    /// Speed toward it and ramps.
    pub pace: Pace,
    /// Speed off it, steps/s.
    pub slow: u32,
    /// How far to look for it.
    pub stroke: i32,
    /// Rest between the two, ms.
    pub pause: u16,
    /// Position where it opens.
    pub position: i32,
    /// Clearance move, signed.
    pub clearance: i32,
}

/// A speed or ramp that must be above 0, in steps.
fn rate(n: u8, value: i32, in_steps: bool) -> Result<Scaled, Fault> {
    if value <= 0 {
        return Err(Fault::SpeedRange);
    }
    Ok(if in_steps { Scaled::new(value as u32) } else { steps_of(axis(n), value as u32) })
}

impl Core {
    /// The feed that holds when no F was written.
    pub fn default_feed(&self) -> Feed {
        match machine().default_feed {
            0 => Feed::Rapid,
            feed => Feed::Um(feed),
        }
    }

    /// F and S.
    ///
    /// # Errors
    /// F08, F20.
    pub fn set_feed(&mut self, code: u8, value: i32) -> Result<(), Fault> {
        if code == Op::Spindle as u8 {
            if self.record.laser != 0 {
                if value as u32 > FULL_POWER as u32 {
                    return Err(Fault::ValueRange);
                }
                self.motor.power = value as u16;
            }
            return Ok(());
        }
        if value <= 0 {
            return Err(Fault::SpeedRange);
        }
        self.feed =
            if code == Op::Feed as u8 { Feed::Um(value as u32) } else { Feed::Steps(value as u32) };
        Ok(())
    }

    /// MoveAxe and MoveRel.
    ///
    /// # Errors
    /// Those of the target and of the speed.
    pub fn move_axe(&mut self, code: u8) -> Result<bool, Fault> {
        if self.first() {
            let bits = match code.wrapping_sub(Op::MoveTo as u8) {
                n @ 0..=2 => n,
                n @ 3..=5 => n - 3 | flags::RELATIVE,
                _ => vm().operand(),
            };
            let n = bits & flags::AXIS;
            let mut ramps = 0;
            if code == Op::MoveRamp as u8 {
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
                frame: if bits & flags::RELATIVE != 0 { 2 } else { 0 },
            };
            self.effect.n = n;
            self.effect.bits = bits;
            let place = self.motor.aim(n, target)?;
            let distance = self.motor.command(n, place);
            if distance != 0 {
                self.emit(TraceKind::Axe, n, 0);
            }
            if distance != 0 || self.motor.moves(n) {
                self.motor.go(n, place.1, pace, false);
            }
        }
        let busy = self.motor.moves(self.effect.n);
        Ok(self.effect.bits & flags::START != 0 || !busy)
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
        const RAPID: u8 = Op::Rapid as u8;
        const LINE: u8 = Op::Line as u8;
        const LINEAR: u8 = Op::Linear as u8;
        const MIXED: u8 = Op::LinearMixed as u8;
        // A feed block joins the path when there is room; axes of their own must rest first, and
        // everything before a rapid move.
        if self.effect.phase == 0 {
            let rapid = match code {
                RAPID..LINE => true,
                LINE..LINEAR => false,
                _ => {
                    let bits = vm().operand();
                    self.vm_back();
                    bits & flags::RAPID != 0
                }
            };
            let alone = rapid || self.motor.path_rests();
            if alone && self.motor.moving() != 0 || !self.motor.path_has_room() {
                return Ok(false);
            }
            self.effect.phase = 1;
            let mut frames = 0;
            let bits = match code {
                RAPID..LINE => SHORT_AXES[usize::from(code - RAPID)].0 | flags::RAPID,
                LINE..LINEAR => SHORT_AXES[usize::from(code - LINE)].0,
                _ => vm().operand(),
            };
            let mut in_steps = if bits & flags::COMMON_STEPS != 0 { 0xFF } else { 0 };
            if code == MIXED {
                frames = vm().operand();
                in_steps = bits >> 5;
            } else if code == LINEAR {
                frames = (bits >> flags::COMMON_FRAME) * 0b01_0101;
            }
            let mut places = [(0, 0); 3];
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
            let mut steps = [0; 3];
            let mut moved = 0;
            n = AXES;
            while n != 0 {
                n -= 1;
                if bits >> n & 1 != 0 {
                    let distance = self.motor.command(n, places[usize::from(n)]);
                    steps[usize::from(n)] = distance;
                    moved |= distance;
                }
            }
            let rapid = bits & flags::RAPID != 0;
            // A rapid move rests at its end, as the trace of what follows it promises.
            self.effect.bits = u8::from(rapid || bits & flags::EXACT != 0);
            if moved == 0 {
                return Ok(true);
            }
            self.emit(if rapid { TraceKind::Rapid } else { TraceKind::Line }, 0, 0);
            if rapid {
                self.motor.rapid(steps);
            } else {
                self.motor.line(steps, self.feed, self.effect.bits != 0);
            }
        }
        Ok(self.effect.bits == 0 || self.motor.path_rests())
    }

    /// An input before its filter: switches and probes are watched step by step.
    pub fn unfiltered(&self, number: u8) -> bool {
        match number {
            1..=16 => self.raw >> (number - 1) & 1 != 0,
            _ => self.input(number),
        }
    }

    /// Plans a reference run by the profile.
    ///
    /// # Errors
    /// F01.
    pub fn plan_home(&mut self, n: u8) -> Result<(), Fault> {
        let record = axis(n);
        let positive = record.flags & AxisRecord::HOME_POSITIVE != 0;
        let position = convert(n, record.home_position, true)?;
        let away = if positive { -record.home_clearance } else { record.home_clearance };
        let rest = convert(n, record.home_position.wrapping_add(away), true)?;
        self.plan = Plan {
            input: self.record.reference[usize::from(n)],
            closed: true,
            positive,
            pace: Pace::of(record).with_steps(u32::from(record.home_fast)),
            slow: u32::from(record.home_slow),
            stroke: convert(n, record.home_stroke, true)?,
            pause: record.home_pause,
            position,
            clearance: rest.wrapping_sub(position),
        };
        Ok(())
    }

    fn closed(&self) -> bool {
        self.unfiltered(self.plan.input) == self.plan.closed
    }

    /// Home: fast to the switch, rest, slowly off it, clearance.
    ///
    /// # Errors
    /// F10, F11.
    pub fn home(&mut self, code: u8) -> Result<bool, Fault> {
        if self.effect.phase == 0 {
            self.effect.n = code.wrapping_sub(Op::Home as u8);
            if code == Op::HomeQuery as u8 {
                self.effect.n = vm().operand();
            }
            if axis(self.effect.n).flags & AxisRecord::PRESENT == 0 {
                return Err(Fault::ValueRange);
            }
            self.plan_home(self.effect.n)?;
            self.effect.phase = BEGIN;
        }
        let n = self.effect.n;
        let rests = !self.motor.moves(n);
        match self.effect.phase {
            BEGIN => {
                self.motor.homed &= !(1 << n);
                self.motor.placed &= !(1 << n);
                self.motor.offset[usize::from(n)] = 0;
                self.effect.phase = REST;
                if !self.closed() {
                    self.effect.phase = FAST;
                    self.seek(n, self.plan.positive, self.plan.pace);
                }
            }
            FAST => {
                if self.closed() {
                    self.motor.stop(1 << n);
                    self.effect.phase = REST;
                } else if rests {
                    return self.not_homed(n, Fault::HomeNotFound);
                }
            }
            REST => {
                if rests {
                    self.effect.left = i32::from(self.plan.pause);
                    self.effect.phase = PAUSE;
                }
            }
            PAUSE => {
                if self.effect.left == 0 {
                    let pace = self.plan.pace.with_steps(self.plan.slow);
                    self.seek(n, !self.plan.positive, pace);
                    self.effect.phase = SLOW;
                }
            }
            SLOW => {
                if !self.closed() {
                    self.motor.hit(n, self.motor.position(n));
                    self.effect.phase = OPEN;
                } else if rests {
                    return self.not_homed(n, Fault::HomeStaysClosed);
                }
            }
            OPEN => {
                if rests {
                    self.motor.place(n, self.plan.position);
                    self.motor.homed |= 1 << n;
                    let steps = self.plan.position.wrapping_add(self.plan.clearance);
                    self.motor.settle(n, steps);
                    self.motor.go(n, steps, self.plan.pace, true);
                    self.effect.phase = CLEAR;
                }
            }
            _ => {
                if rests {
                    let position = self.motor.position(n);
                    self.emit_outcome(TraceKind::Home, n, true, position);
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    /// Whether the effect under way looks for a switch or a probe at this instant.
    pub fn seeks(&self) -> bool {
        const HOME: u8 = Op::Home as u8;
        const HOME_QUERY: u8 = Op::HomeQuery as u8;
        const PROBE: u8 = Op::Probe as u8;
        match self.effect.code {
            HOME..=HOME_QUERY => matches!(self.effect.phase, FAST | SLOW),
            PROBE => self.effect.phase == 1,
            _ => false,
        }
    }

    fn not_homed(&mut self, n: u8, fault: Fault) -> Result<bool, Fault> {
        let position = self.motor.position(n);
        self.motor.settle(n, position);
        self.emit_outcome(TraceKind::Home, n, false, position);
        let query = self.effect.code == Op::HomeQuery as u8;
        if query && fault as u8 == Fault::HomeNotFound as u8 { Ok(true) } else { Err(fault) }
    }

    /// Sends an axis toward or off its reference switch, by the stroke at most.
    fn seek(&mut self, n: u8, positive: bool, pace: Pace) {
        let position = self.motor.position(n);
        let stroke = self.plan.stroke;
        let target =
            if positive { position.wrapping_add(stroke) } else { position.wrapping_sub(stroke) };
        self.motor.go(n, target, pace, true);
    }

    /// Probe, ProbeMask.
    ///
    /// # Errors
    /// F19, F12, those of the limit and of the speed.
    pub fn probe(&mut self) -> Result<bool, Fault> {
        if self.effect.phase == 0 {
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
                pace.speed = match self.feed {
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
            self.effect.n = n;
            self.effect.bits = bits;
            self.effect.phase = 1;
            if let Err(fault) = self.begin_probe(and, xor, place.1, pace) {
                self.emit_outcome(TraceKind::Probe, n, false, self.motor.position(n));
                return Err(fault);
            }
            return Ok(false);
        }
        let n = self.effect.n;
        let i = usize::from(n);
        if self.effect.phase == 1 {
            let position = self.motor.position(n);
            let pin = step::hit() != 0;
            if pin || self.probed() {
                let caught = if pin { step::caught(i, position) } else { position };
                self.motor.probed[i] = caught;
                self.motor.probe_ok |= 1 << n;
                self.motor.hit(n, caught);
                self.effect.phase = 2;
            } else if !self.motor.moves(n) {
                self.effect.phase = 3;
            }
            return Ok(false);
        }
        if self.motor.moves(n) {
            return Ok(false);
        }
        step::watch(0, 0, false);
        let ok = self.effect.phase == 2;
        let place = if ok { self.motor.probed[i] } else { self.motor.position(n) };
        self.emit_outcome(TraceKind::Probe, n, ok, place);
        if !ok && self.effect.bits & flags::QUERY == 0 {
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
        let n = self.effect.n;
        self.probe_and = and;
        self.probe_xor = xor;
        self.motor.probe_ok &= !(1 << n);
        if self.probed() {
            return Err(Fault::InputActive);
        }
        // The probe pin stops the counting at its very step.
        let pin = if !self.chained() {
            ((and as u8) << 4) & 0xF0
        } else if and == 1 << 16 {
            crate::pins::P1_REF_X_OR_PROBE
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

    /// Takes back the first operand: the effect begins again later.
    fn vm_back(&mut self) {
        vm().pc -= 1;
    }

    fn probed(&self) -> bool {
        let mut inputs = u32::from(self.raw);
        if self.input(17) {
            inputs |= 1 << 16;
        }
        (inputs & self.probe_and) ^ self.probe_xor != 0
    }

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
        // One that is pressed already has been seen to.
        if !self.unfiltered(self.record.emergency) {
            watch(self.record, self.record.emergency);
        }
        let mut n = AXES;
        while n != 0 {
            n -= 1;
            if axes >> n & 1 != 0 {
                let input = self.record.reference[usize::from(n)];
                watch(self.record, input);
                if self.unfiltered(input) {
                    self.limited(n);
                }
            }
        }
        guard::watch(pins, inputs);
    }

    /// Bit per axis that moves toward its reference switch without looking for it.
    fn approaching(&self) -> u8 {
        let moving = self.motor.moving();
        // What was halted at once says that it moves until it has been looked at.
        if moving == 0 || self.motor.rests() {
            return 0;
        }
        let homing = (Op::Home as u8..=Op::HomeQuery as u8).contains(&self.effect.code);
        let mut axes = 0;
        let mut n = AXES;
        while n != 0 {
            n -= 1;
            let toward = axis(n).flags & AxisRecord::HOME_POSITIVE != 0;
            let positive = self.motor.negative >> n & 1 == 0;
            if moving >> n & 1 != 0 && toward == positive && !(homing && self.effect.n == n) {
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
        self.fault_input = self.record.reference[usize::from(n)];
        self.fail(Fault::LimitSwitch);
    }

    /// An input has stopped the engine: what follows from it.
    #[inline(never)]
    pub fn tripped(&mut self) {
        let pins = guard::tripped();
        if pins == 0 {
            return;
        }
        let answered = guard::answered();
        self.motor.halt();
        let record = self.record;
        let has = |input: u8| {
            let chained = matches!(input, 1..=16) && answered >> (input - 1) & 1 != 0;
            chained || pins & record.pin(input) != 0
        };
        if has(record.emergency) {
            self.emergency(record.emergency);
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
