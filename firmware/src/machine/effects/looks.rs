//! State and actions behind the rules of F, S, SetPos and of what a program reads from the machine.

use crate::machine::chip::Chip;
use crate::machine::controller::Controller;
use crate::machine::motor::AXES;
use crate::motion::Feed;
use crate::rules::Axis;
use crate::rules::moves::Moves;
use lang::fault::Fault;
use lang::isa::Op;
use lang::place;
use lang::record::FULL_POWER;

/// Its place in what is kept for each.
fn i(axis: Axis) -> usize {
    axis.i() % usize::from(AXES)
}

impl<C: Chip> Moves for Controller<C> {
    fn operand(&mut self) -> u8 {
        self.vm.operand()
    }
    fn pop(&mut self) -> i32 {
        self.vm.pop()
    }
    fn push_long(&mut self, value: i32) {
        self.vm.push(value);
    }
    fn set_code(&mut self, _: u8) {}
    fn is_spindle(&self) -> bool {
        self.program.effect.code == Op::Spindle as u8
    }
    fn is_feed(&self) -> bool {
        self.program.effect.code == Op::Feed as u8
    }
    fn set_power(&mut self, value: i32) -> Result<(), Fault> {
        if self.motor.pwm.is_open() {
            self.motor.power = self.level(value).ok_or(Fault::ValueRange)?;
            self.drive_pwm();
        } else if self.record.laser != 0 {
            if value as u32 > FULL_POWER as u32 {
                return Err(Fault::ValueRange);
            }
            self.motor.power = value as u16;
        }
        Ok(())
    }
    fn set_feed(&mut self, feed: i32) {
        self.program.feed =
            if feed < 0 { Feed::Steps(feed.unsigned_abs()) } else { Feed::Um(feed as u32) };
    }
    fn must_rest(&self, axis: Axis) -> Result<(), Fault> {
        if self.motor.moves(axis.n()) { Err(Fault::ValueRange) } else { Ok(()) }
    }
    fn um(&self, axis: Axis) -> i32 {
        self.motor.um[i(axis)]
    }
    fn offset(&self, axis: Axis) -> i32 {
        self.motor.offset[i(axis)]
    }
    // An axis that only feeds on may do so for ever: nobody has homed it, so its machine place may begin anew.
    fn set_offset(&mut self, axis: Axis, mut um: i32) {
        let motor = &mut self.motor;
        let (before, steps) = (motor.um[i(axis)], motor.steps[i(axis)]);
        if motor.homed & axis.bit() == 0 && place::is_far(before, steps) {
            um = um.wrapping_sub(before);
            motor.place(axis.n() % AXES, 0);
        }
        motor.offset[i(axis)] = um;
    }
    fn set_placed(&mut self, axis: Axis) {
        self.motor.placed |= axis.bit();
    }
    fn position(&self, axis: Axis) -> i32 {
        self.motor.position(axis.n() % AXES)
    }
    fn probed(&self, axis: Axis) -> i32 {
        self.motor.probed[i(axis)]
    }
    #[inline(always)]
    fn to_um(&self, axis: Axis, steps: i32) -> Option<i32> {
        self.motor.convert(axis.n(), steps, false).ok()
    }
    fn has_probed(&self, axis: Axis) -> bool {
        self.motor.probe_ok & axis.bit() != 0
    }
    fn is_moving(&self, axis: Axis) -> bool {
        self.motor.moves(axis.n())
    }
    fn is_homed(&self, axis: Axis) -> bool {
        self.motor.homed & axis.bit() != 0
    }
    fn port(&self) -> i32 {
        let wired = i32::from(self.io.inputs.levels()) | i32::from(self.input(17)) << 16;
        wired | i32::from(self.io.analog.on) << 17
    }
    fn timer(&self) -> i32 {
        self.program.timer
    }
    fn char_in(&self) -> u8 {
        self.talk.char_in
    }
    fn set_char_in(&mut self, c: u8) {
        self.talk.char_in = c;
    }
}
