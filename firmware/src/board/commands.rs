//! InterpCNC commands in holding registers 2000 and up (InterpCNC V3 Modbus protocol, Commands).

use crate::controller::{Controller, Effect, Plan};
use crate::motor::AXES;
use crate::vm::{axis, convert};
use firmware::motion::math::{signed, size};
use firmware::motion::scaled::Scaled;
use firmware::motion::{Feed, Pace};
use firmware::rules::home::BEGIN;
use firmware::rules::{Axis, coords};
use lang::isa::Op;
use lang::record::AxisRecord;
use lang::wire::{Control, Direct, Exception, command};

/// A 32-bit float as thousandths, rounded half up; saturates.
fn thousandths(low: u16, high: u16) -> i32 {
    let exponent = (high >> 7 & 0xFF) as i16;
    if exponent == 0 {
        return 0;
    }
    let mantissa = u32::from(high & 0x7F | 0x80) << 16 | u32::from(low);
    // value = mantissa * 2^(exponent - 150); 1000 = 125 * 2^3.
    let mut value = mantissa * 125;
    let mut shift = exponent - 147;
    while shift < 0 && value != 0 {
        value = if shift == -1 { (value + 1) >> 1 } else { value >> 1 };
        shift += 1;
    }
    while shift > 0 && value < 1 << 30 {
        value <<= 1;
        shift -= 1;
    }
    let value = if shift > 0 { i32::MAX } else { value as i32 };
    signed(value, i32::from(high as i16))
}

impl Controller {
    /// Argument 1 as an axis.
    fn axis_argument(&self) -> Result<u8, Exception> {
        let n = self.command.word(1).wrapping_sub(1);
        if n >= u16::from(AXES) || axis(n as u8).flags & AxisRecord::PRESENT == 0 {
            return Err(Exception::IllegalValue);
        }
        Ok(n as u8)
    }

    /// A speed or ramp, not above the machine's; 0 or less is refused.
    fn rate_argument(&self, at: usize) -> Result<Scaled, Exception> {
        let value = self.command.long(at);
        if value <= 0 { Err(Exception::IllegalValue) } else { Ok(Scaled::new(value as u32)) }
    }

    fn pace(&self, n: u8, accel: usize, speed: usize, decel: usize) -> Result<Pace, Exception> {
        let mut pace = Pace::of(axis(n));
        pace.accel = pace.accel.least(self.rate_argument(accel)?);
        pace.speed = pace.speed.least(self.rate_argument(speed)?);
        pace.decel = pace.decel.least(self.rate_argument(decel)?);
        Ok(pace)
    }

    /// Executes the command in the buffer.
    ///
    /// # Errors
    /// Illegal value, busy, or no program whose profile 1110 and 1111 need.
    pub fn execute(&mut self) -> Result<(), Exception> {
        let code = self.command.word(0);
        match code {
            command::STOP_AXIS | command::STOP_AXES => {
                let axes = if code == command::STOP_AXIS {
                    1 << self.axis_argument()?
                } else {
                    (self.command.word(1) & 0b111) as u8
                };
                if self.session.is_active() {
                    self.control(Control::Stop);
                } else {
                    self.abandon();
                    self.motor.stop(axes);
                }
                return Ok(());
            }
            command::FORCE_INPUT => return self.force(),
            command::DIRECT => return self.direct(),
            _ => {}
        }
        if self.session.is_active() || self.program.effect.code != 0 {
            return Err(Exception::Busy);
        }
        if self.first_on(&self.record.emergency) != 0 {
            return Err(Exception::Busy);
        }
        match code {
            command::MOVE_SPEED => {
                let n = self.free_axis()?;
                let speed = self.command.long(4);
                if speed == 0 {
                    self.motor.stop(1 << n);
                    return Ok(());
                }
                let mut pace = Pace::of(axis(n));
                let ramp = self.rate_argument(2)?;
                pace.accel = pace.accel.least(ramp);
                pace.decel = pace.decel.least(ramp);
                pace.speed = pace.speed.least(Scaled::size(speed));
                self.command.jogs = true;
                self.motor.run(n, speed < 0, self.motor.limit(n, speed < 0), pace);
            }
            command::MOVE_TO | command::MOVE_BY => {
                let n = self.free_axis()?;
                let pace = self.pace(n, 2, 4, 6)?;
                let value = self.command.long(8);
                let from = if code == command::MOVE_BY {
                    self.motor.position(n)
                } else {
                    self.offset_steps(n)
                };
                let target = from.checked_add(value).ok_or(Exception::IllegalValue)?;
                if !self.motor.within(n, target) {
                    return Err(Exception::IllegalValue);
                }
                self.motor.settle(n, target);
                self.motor.go(n, target, pace, false);
            }
            command::SET_POSITION => {
                let n = self.axis_argument()?;
                return self.set_work_position(n, self.command.long(2));
            }
            command::HOME => {
                let n = self.resting_axis()?;
                let input = self.command.word(3);
                if self.command.word(2) != 0
                    || input > 16
                    || self.command.word(4) > 1
                    || self.command.word(5) > 1
                {
                    return Err(Exception::IllegalValue);
                }
                let pace = self.pace(n, 10, 6, 12)?;
                self.rate_argument(8)?;
                self.seek.plan = Plan {
                    input: input as u8 + 1,
                    closed: self.command.word(4) != 0,
                    positive: self.command.word(5) != 0,
                    pace,
                    slow: self.command.long(8) as u32,
                    stroke: size(self.command.long(14)) as i32,
                    pause: self.command.word(16),
                    position: self.command.long(17),
                    clearance: self.command.long(19),
                };
                self.command.homing_error &= !(1 << n);
                self.program.effect =
                    Effect { code: Op::Home as u8 + n, phase: BEGIN, n, bits: 0, left: 0 };
            }
            command::HOME_PROFILE => {
                if self.image().is_none() {
                    return Err(Exception::DeviceFailure);
                }
                let n = self.resting_axis()?;
                self.command.homing_error &= !(1 << n);
                self.plan_home(n).map_err(|_| Exception::IllegalValue)?;
                self.program.effect =
                    Effect { code: Op::Home as u8 + n, phase: BEGIN, n, bits: 0, left: 0 };
            }
            command::PROBE | command::PROBE_MASK => {
                let n = self.resting_axis()?;
                let mask = code == command::PROBE_MASK;
                let at = if mask { 6 } else { 4 };
                let pace = self.pace(n, at, at + 2, at + 4)?;
                let (and, xor);
                if mask {
                    and = self.command.long(2) as u32;
                    xor = self.command.long(4) as u32;
                } else {
                    let input = self.command.word(2);
                    if input > 16 || self.command.word(3) > 1 {
                        return Err(Exception::IllegalValue);
                    }
                    and = 1 << input;
                    xor = if self.command.word(3) == 0 { and } else { 0 };
                }
                let target = self.motor.position(n).checked_add(self.command.long(at + 6));
                let target = target.ok_or(Exception::IllegalValue)?;
                if !self.motor.within(n, target) {
                    return Err(Exception::IllegalValue);
                }
                self.command.probe_error &= !(1 << n);
                self.program.effect =
                    Effect { code: Op::Probe as u8, phase: 1, n, bits: 0, left: 0 };
                if self.begin_probe(and, xor, target, pace).is_err() {
                    self.program.forget();
                    self.command.probe_error |= 1 << n;
                }
            }
            command::JOG => {
                if self.image().is_none() {
                    return Err(Exception::DeviceFailure);
                }
                return self.jog();
            }
            _ => return Err(Exception::IllegalValue),
        }
        Ok(())
    }

    /// An axis that a position or speed command may take: no path moves it.
    fn free_axis(&self) -> Result<u8, Exception> {
        let n = self.axis_argument()?;
        if self.motor.path_rests() { Ok(n) } else { Err(Exception::Busy) }
    }

    /// An axis at rest.
    fn resting_axis(&self) -> Result<u8, Exception> {
        let n = self.axis_argument()?;
        if self.motor.moving() == 0 { Ok(n) } else { Err(Exception::Busy) }
    }

    /// The axis's work offset in steps.
    pub fn offset_steps(&self, n: u8) -> i32 {
        coords::offset_steps(&self.motor, Axis::new(n))
    }

    /// SetPos on a resting axis: its work position becomes `value` steps.
    ///
    /// # Errors
    /// Busy while it moves.
    pub fn set_work_position(&mut self, n: u8, value: i32) -> Result<(), Exception> {
        if self.motor.moves(n) {
            return Err(Exception::Busy);
        }
        let offset = self.motor.position(n).wrapping_sub(value);
        self.motor.offset[usize::from(n)] =
            convert(n, offset, false).map_err(|_| Exception::IllegalValue)?;
        Ok(())
    }

    fn force(&mut self) -> Result<(), Exception> {
        let n = self.command.word(1);
        let level = match self.command.word(2) {
            0 => Some(false),
            1 => Some(true),
            0xFFFF => None,
            _ => return Err(Exception::IllegalValue),
        };
        let number = n as u8 + 1;
        let record = self.record;
        let stops: [&[u8]; 5] =
            [&record.stop, &record.hold, &record.door, &record.emergency, &record.reference];
        #[expect(clippy::manual_contains, reason = "a call of memchr is longer")]
        let taken = || stops.iter().any(|list| list.iter().any(|&role| role == number));
        if n >= 16 || taken() {
            return Err(Exception::IllegalValue);
        }
        self.io.inputs.force(1 << n, level);
        Ok(())
    }

    fn direct(&mut self) -> Result<(), Exception> {
        match Direct::from_number(self.command.word(1)).ok_or(Exception::IllegalValue)? {
            Direct::Acknowledge => self.control(Control::Acknowledge),
            Direct::Resume => self.control(Control::Resume),
            Direct::Pause => self.control(Control::Pause),
            Direct::StopJog if self.command.jogs => self.motor.stop(0b111),
            Direct::StopJog => {}
            Direct::Stop if self.session.is_active() => self.control(Control::Stop),
            Direct::Stop => {
                self.abandon();
                self.motor.stop(0b111);
            }
        }
        Ok(())
    }

    /// A homing or probing command that was stopped counts as failed.
    fn abandon(&mut self) {
        let bit = 1 << self.program.effect.n;
        match self.program.effect.code {
            0 => return,
            code if code == Op::Probe as u8 => self.command.probe_error |= bit,
            _ => self.command.homing_error |= bit,
        }
        crate::step::watch(0, 0, false);
        self.program.forget();
    }

    fn jog(&mut self) -> Result<(), Exception> {
        if self.motor.moving() != 0 {
            return Err(Exception::Busy);
        }
        let axes = self.command.word(1);
        if axes & 0b111 == 0 || axes & !0b100_0111 != 0 {
            return Err(Exception::IllegalValue);
        }
        // um/min, so a sixtieth of it is um/s.
        let feed = thousandths(self.command.word(2), self.command.word(3)) / 60;
        if feed <= 0 {
            return Err(Exception::IllegalValue);
        }
        let mut steps = [0; 3];
        let mut targets = [0; 3];
        let mut at = 4;
        for n in 0..AXES {
            let i = usize::from(n);
            targets[i] = self.motor.position(n);
            if axes >> n & 1 == 0 {
                continue;
            }
            let um = thousandths(self.command.word(at), self.command.word(at + 1));
            at += 2;
            let value = convert(n, um, true).map_err(|_| Exception::IllegalValue)?;
            let from = if axes & 0x40 != 0 { targets[i] } else { self.offset_steps(n) };
            targets[i] = from.checked_add(value).ok_or(Exception::IllegalValue)?;
            if !self.motor.within(n, targets[i]) {
                return Err(Exception::IllegalValue);
            }
            steps[i] = targets[i].wrapping_sub(self.motor.position(n));
        }
        for n in 0..AXES {
            self.motor.settle(n, targets[usize::from(n)]);
        }
        self.command.jogs = true;
        self.motor.line(steps, [0; 3], Feed::Um(feed as u32), true, 0);
        Ok(())
    }
}
