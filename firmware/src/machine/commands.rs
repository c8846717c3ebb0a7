//! State and actions behind the commands; their rules are [`crate::rules::commands`].

use crate::machine::chip::Chip;
use crate::machine::controller::{Controller, Effect};
use crate::machine::motor::AXES;
use crate::motion::math::signed;
use crate::motion::scaled::Scaled;
use crate::motion::{Feed, Pace};
use crate::rules::commands::{self, Commands};
use crate::rules::coords::Stands;
use crate::rules::home::BEGIN;
use crate::rules::pace::Paces;
use crate::rules::probe::MOVES;
use crate::rules::{Answer, Axis};
use lang::fault::Fault;
use lang::isa::first;
use lang::record::AxisRecord;
use lang::wire::{Control, Exception, command};

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

impl<C: Chip> Controller<C> {
    /// Executes the command in the buffer.
    ///
    /// # Errors
    /// See [`commands::execute`].
    pub fn execute(&mut self) -> Answer {
        self.command.next = 2;
        commands::execute(self)
    }

    fn next_at(&mut self) -> usize {
        let at = self.command.next;
        self.command.next += 2;
        at.into()
    }
}

impl<C: Chip> Stands for Controller<C> {
    fn position(&self, axis: Axis) -> i32 {
        self.motor.position(axis.n())
    }
    fn steps(&self, axis: Axis) -> i32 {
        self.motor.steps(axis)
    }
    fn offset(&self, axis: Axis) -> i32 {
        self.motor.offset(axis)
    }
    fn to_steps(&self, axis: Axis, um: i32) -> Option<i32> {
        self.motor.convert(axis.n(), um, true).ok()
    }
    fn to_um(&self, axis: Axis, steps: i32) -> Option<i32> {
        self.motor.convert(axis.n(), steps, false).ok()
    }
}

impl<C: Chip> Commands for Controller<C> {
    fn command(&self) -> u16 {
        self.command.word(0)
    }
    fn argument(&self) -> u16 {
        self.command.word(1)
    }
    #[inline(never)]
    fn next(&mut self) -> i32 {
        let at = self.next_at();
        match at {
            // The buffer stays as the host has written it: a speed has its sign, one ramp is both.
            4 if self.command.word(0) == command::MOVE_SPEED => self.command.long(4).wrapping_abs(),
            6 if self.command.word(0) == command::MOVE_SPEED => self.command.long(2),
            _ => self.command.long(at),
        }
    }
    fn next_thousandths(&mut self) -> i32 {
        let at = self.next_at();
        thousandths(self.command.word(at), self.command.word(at + 1))
    }
    fn force(&mut self, n: u8) -> Answer {
        let level = match self.command.word(2) {
            0 => Some(false),
            1 => Some(true),
            0xFFFF => None,
            _ => return Err(Exception::IllegalValue),
        };
        let record = &self.record;
        let stops: [&[u8]; 5] =
            [&record.stop, &record.hold, &record.door, &record.emergency, &record.reference];
        #[expect(clippy::manual_contains, reason = "a call of memchr is longer")]
        let taken = stops.iter().any(|list| list.iter().any(|&role| role == n));
        if taken {
            return Err(Exception::IllegalValue);
        }
        self.io.inputs.force(1 << (n - 1), level);
        let effect = &self.program.effect;
        if effect.code == first::Probe && effect.phase == MOVES {
            self.watch_probe();
        }
        Ok(())
    }
    fn control(&mut self, code: u8) {
        if let Some(control) = Control::from_number(code.into()) {
            Controller::control(self, control);
        }
    }
    fn is_active(&self) -> bool {
        self.session.is_active()
    }
    fn has_program(&self) -> bool {
        self.image().is_some()
    }
    fn blocking(&self) -> u8 {
        Controller::blocking(self)
    }
    fn is_held(&self) -> bool {
        self.command.jogs
    }
    fn set_held(&mut self) {
        self.command.jogs = true;
    }
    fn effect(&self) -> u8 {
        self.program.effect.code
    }
    fn set_effect(&mut self, code: u8) {
        self.program.effect.code = code;
    }
    fn first_phase(&mut self) {
        let n = self.program.effect.n;
        self.program.effect = Effect { phase: BEGIN, n, ..Effect::NONE };
    }
    fn forget(&mut self) {
        self.chip.watch(0, 0, false);
        self.program.forget();
    }
    fn set_homing_failed(&mut self, axis: Axis) {
        self.command.homing_error |= axis.bit();
    }
    fn set_homing(&mut self, axis: Axis) {
        self.command.homing_error &= !axis.bit();
    }
    fn set_probe_failed(&mut self, axis: Axis) {
        self.command.probe_error |= axis.bit();
    }
    fn set_probing(&mut self, axis: Axis) {
        self.command.probe_error &= !axis.bit();
    }
    fn is_there(&self, n: Axis) -> bool {
        n.n() < AXES && self.motor.axis(n.n()).flags & AxisRecord::PRESENT != 0
    }
    fn is_homed(&self, axis: Axis) -> bool {
        self.motor.homed & axis.bit() != 0
    }
    fn is_moving(&self, axis: Axis) -> bool {
        self.motor.moves(axis.n())
    }
    fn moving(&self) -> u8 {
        self.motor.moving()
    }
    fn in_the_way(&self) -> u8 {
        match self.command.word(0) {
            command::MOVE_SPEED..=command::MOVE_BY => u8::from(!self.motor.path_rests()),
            command::SET_POSITION => 0,
            _ => self.moving(),
        }
    }
    fn set_axes(&mut self, axes: u8) {
        self.command.axes = axes;
    }
    fn is_meant(&self, axis: Axis) -> bool {
        self.command.axes & axis.bit() != 0
    }
    fn brake(&mut self, axis: Axis) {
        self.command.hold = 0;
        self.motor.stop(axis.bit());
    }
    fn brake_all(&mut self) {
        self.command.hold = 0;
        self.motor.stop(0b111);
    }
    fn set_offset(&mut self, axis: Axis, um: i32) {
        self.motor.offset[axis.i()] = um;
    }
    fn start(&self) -> i32 {
        self.command.start
    }
    fn set_start(&mut self, steps: i32) {
        self.command.start = steps;
    }
    fn aim_steps(&mut self, axis: Axis, steps: i32) -> Result<(), Fault> {
        self.command.places[axis.i()] = steps;
        self.motor.allows(axis, steps)
    }
    fn go(&mut self, axis: Axis) {
        let place = self.command.places[axis.i()];
        self.motor.settle(axis.n(), place);
        self.motor.go(axis.n(), place, self.seek.plan.pace, false);
    }
    fn go_in_line(&mut self) {
        let mut steps = [0; 3];
        for axis in Axis::UP {
            if self.is_named(axis) {
                let place = self.command.places[axis.i()];
                self.motor.settle(axis.n(), place);
                steps[axis.i()] = place.wrapping_sub(self.position(axis));
            }
        }
        self.motor.line(steps, [0; 3], Feed::Um(self.command.feed as u32), true, 0);
    }
    fn set_flags(&mut self, flags: u8) {
        self.command.axes = flags;
    }
    fn is_named(&self, axis: Axis) -> bool {
        self.is_meant(axis)
    }
    fn counts_from_here(&self) -> bool {
        self.command.axes & 64 != 0
    }
    fn set_feed(&mut self, feed: i32) {
        self.command.feed = feed;
    }
    fn ramp(&self) -> i32 {
        self.command.long(2)
    }
    // See `next`: the buffer stays as the host has written it.
    fn set_ramp_down(&mut self, _: i32) {}
    fn speed(&self) -> i32 {
        self.command.long(4)
    }
    fn set_speed(&mut self, _: i32) {}
    fn set_far(&mut self) {}
    fn set_far_to(&mut self, _: i32) {}
    fn far(&self) -> i32 {
        signed(1 << 29, self.speed())
    }
    fn travel_begin(&self, n: Axis) -> i32 {
        self.motor.axis(n.n()).min
    }
    fn travel_end(&self, n: Axis) -> i32 {
        self.motor.axis(n.n()).max
    }
    fn travel_steps(&self, axis: Axis, um: i32) -> i32 {
        self.to_steps(axis, um).unwrap_or(0)
    }
    fn set_target(&mut self, _: Axis, steps: i32) {
        self.command.start = steps;
    }
    fn run(&mut self, axis: Axis) {
        let negative = self.command.start < self.position(axis);
        self.motor.run(axis.n(), negative, Some(self.command.start), self.seek.plan.pace);
    }
    fn work_position(&self) -> i32 {
        self.command.long(2)
    }
    fn nothing(&self) -> u16 {
        self.command.word(2)
    }
    fn switch(&self) -> u16 {
        self.command.word(3)
    }
    fn set_switch(&mut self, input: u16) {
        self.seek.plan.input = input as u8 + 1;
        self.seek.plan.closed = true;
    }
    fn closed_level(&self) -> u16 {
        self.command.word(4)
    }
    fn set_inverted(&mut self) {
        self.seek.plan.closed = false;
    }
    fn home_side(&self) -> u16 {
        self.command.word(5)
    }
    fn set_way(&mut self, flags: u8) {
        self.seek.plan.positive = flags != 0;
    }
    fn home_rate(&self, which: Axis) -> i32 {
        self.command.long(6 + 2 * which.i())
    }
    fn take_plan(&mut self, n: Axis) {
        let [speed, up, down] = [6, 10, 12].map(|n| Scaled::new(self.command.long(n) as u32));
        self.seek.plan.pace = Pace::of(self.motor.axis(n.n())).with_ramps(up, down);
        self.least_speed(speed);
        self.seek.plan.slow = self.command.long(8) as u32;
        self.seek.plan.pause = self.command.word(16);
        self.seek.plan.position = self.command.long(17);
        self.seek.plan.clearance = self.command.long(19);
    }
    fn home_stroke(&self) -> i32 {
        self.command.long(14)
    }
    fn set_stroke(&mut self, steps: i32) {
        self.seek.plan.stroke = steps;
    }
    fn home_clearance(&self) -> i32 {
        self.command.long(19)
    }
    // The plan's has its sign.
    fn set_clearance(&mut self, _: i32) {}
    fn plan(&mut self, n: u8) -> Result<(), Fault> {
        self.plan_home(n)
    }
    fn probe_input(&self) -> u16 {
        self.command.word(2)
    }
    fn probe_level(&self) -> u16 {
        self.command.word(3)
    }
    fn and(&self) -> i32 {
        self.command.long(2)
    }
    fn xor(&self) -> i32 {
        self.command.long(4)
    }
}
