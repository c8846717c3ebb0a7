//! Effects that move axes to a place or at a speed; state and actions behind the rules of paces and single axes.

use crate::machine::chip::Chip;
use crate::machine::controller::Controller;
use crate::machine::motor::AXES;
use crate::motion::math::{signed, size};
use crate::motion::scaled::Scaled;
use crate::motion::{Feed, Pace};
use crate::rules::axes::Axes;
use crate::rules::lines::{self, Courses, Lines, Together};
use crate::rules::pace::{self, Paces};
use crate::rules::{Axis, Progress};
use lang::fault::Fault;
use lang::isa::{Op, SHORT_AXES, first, flags, last};
use lang::place::{Place, Target, way};
use lang::record::MachineRecord;
use lang::wire::TraceKind;

impl<C: Chip> Controller<C> {
    /// The feed that holds when no F was written.
    pub fn default_feed(&self) -> Feed {
        match self.motor.machine.default_feed {
            0 => Feed::Rapid,
            feed => Feed::Um(feed),
        }
    }

    /// MoveSpeed.
    ///
    /// # Errors
    /// F08.
    pub fn move_speed(&mut self) -> Result<bool, Fault> {
        let bits = self.vm.operand();
        let axis = pace::axis_flags(self, bits);
        let value = self.vm.pop();
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
        let first = self.program.first();
        let mut line = Line {
            board: self,
            in_steps: 0,
            frames: 0,
            places: [Place::default(); 3],
            steps: [0; 3],
            um: [0; 3],
            going: 0,
            second: 0,
            tag: 0,
        };
        lines::linear(&mut line, code, first)
    }

    /// Takes back the first operand: the effect begins again later.
    pub fn vm_back(&mut self) {
        self.vm.pc -= 1;
    }
}

impl<C: Chip> Paces for Controller<C> {
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
        self.motor.axis(n.n()).steps
    }
    fn um_of(&self, n: Axis) -> u16 {
        self.motor.axis(n.n()).um
    }
    fn take_pace(&mut self, n: Axis) {
        self.seek.plan.pace = Pace::of(self.motor.axis(n.n()));
    }
    #[inline(never)]
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
    #[inline(never)]
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

impl<C: Chip> Axes for Controller<C> {
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
            self.motor.convert(n, self.motor.position(n), false)?;
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

/// A line while its statement begins.
struct Line<'a, C: Chip> {
    board: &'a mut Controller<C>,
    /// Bit per axis: its word is in steps.
    in_steps: u8,
    /// What each word counts from, two bits of the axis's.
    frames: u8,
    /// Where each word leads.
    places: [Place; 3],
    /// Ways of the axes, steps.
    steps: [i32; 3],
    /// The same in um, where words say so.
    um: [i32; 3],
    /// Bit per axis that has steps to make.
    going: u8,
    /// Those of a rapid move's second line.
    second: u8,
    /// What the block is known by.
    tag: u32,
}

impl<C: Chip> Line<'_, C> {
    fn flags(&self) -> u8 {
        self.board.program.effect.bits
    }
}

impl<C: Chip> Together for Line<'_, C> {
    fn is_named(&self, axis: Axis) -> bool {
        self.flags() & axis.bit() != 0
    }
    fn command_place(&mut self, axis: Axis) -> bool {
        let (i, place) = (axis.i(), self.places[axis.i()]);
        self.um[i] = place.um.wrapping_sub(self.board.motor.um[i]);
        self.steps[i] = self.board.motor.command(axis.n(), place);
        self.steps[i] == 0
    }
    fn going(&self) -> u8 {
        self.going
    }
    fn set_going(&mut self, axes: u8) {
        self.going = axes;
    }
    fn add_going(&mut self, axis: Axis) {
        self.going |= axis.bit();
    }
    fn remove_going(&mut self, axis: Axis) {
        self.going &= !axis.bit();
    }
}

impl<C: Chip> Lines for Line<'_, C> {
    // A feed block joins the path when there is room; axes of their own must rest first, and everything before a rapid
    // move.
    fn has_to_wait(&mut self) -> bool {
        let board = &mut *self.board;
        let rapid = match board.program.effect.code {
            first::Rapid..=last::Rapid => true,
            first::Line..=last::Line => false,
            _ => {
                let bits = board.vm.operand();
                board.vm_back();
                bits & flags::RAPID != 0
            }
        };
        let alone = rapid || board.motor.path_rests();
        let waits = alone && board.motor.busy() != 0 || !board.path_has_room();
        if waits {
            board.program.effect.phase = 0;
        }
        waits
    }
    fn operand(&mut self) -> u8 {
        self.board.vm.operand()
    }
    fn pop(&mut self) -> i32 {
        self.board.vm.pop()
    }
    fn set_code(&mut self, _: u8) {}
    fn is_mixed(&self) -> bool {
        self.board.program.effect.code == first::LinearMixed
    }
    fn short_flags(&self, code: u8) -> u8 {
        match code {
            first::Rapid..=last::Rapid => {
                SHORT_AXES[usize::from(code - first::Rapid)].0 | flags::RAPID
            }
            first::Line..=last::Line => SHORT_AXES[usize::from(code - first::Line)].0,
            _ => 0,
        }
    }
    fn keep_flags(&mut self, flags: u8) {
        self.board.program.effect.bits = flags;
    }
    fn take_frames(&mut self, _: u8) {
        self.frames = self.board.vm.operand();
    }
    // Of each axis its own: see `aim_word`.
    fn next_frame(&mut self) {}
    fn take_frame_of_all(&mut self) {
        let bits = self.flags();
        if self.is_mixed() {
            self.in_steps = bits >> 5;
        } else if self.board.program.effect.code == first::Linear {
            self.frames = (bits >> flags::COMMON_FRAME) * 0b01_0101;
            self.in_steps = if bits & flags::COMMON_STEPS != 0 { 0xFF } else { 0 };
        }
    }
    fn aim_word(&mut self, axis: Axis, target: i32) -> Result<(), Fault> {
        let n = axis.n();
        let target = Target {
            value: target,
            in_steps: self.in_steps >> n & 1 != 0,
            frame: self.frames >> (2 * n) & 3,
        };
        self.places[axis.i()] = self.board.motor.aim(n, target)?;
        Ok(())
    }
    fn is_rapid(&self) -> bool {
        self.flags() & flags::RAPID != 0
    }
    fn tell_way(&mut self, kind: TraceKind, _: i32) {
        self.tag = self.board.tell_block(kind);
    }
    fn begin_line(&mut self, _: u8) {
        let exact = self.flags() & flags::EXACT != 0;
        let feed = self.board.program.feed;
        self.board.motor.line(self.steps, self.um, feed, exact, self.tag);
    }
    fn begin_rapid(&mut self, _: u8) {
        self.board.motor.rapid(self.steps, self.second, self.tag);
    }
    fn second(&self) -> u8 {
        self.second
    }
    fn set_second(&mut self, axes: u8) {
        self.second = axes;
    }
    fn wants_z_apart(&self) -> bool {
        self.board.motor.machine.flags & MachineRecord::RAPID_Z_APART != 0
    }
    fn side(&self, n: Axis) -> u8 {
        self.board.motor.axis(n.n()).flags as u8
    }
    // Its direction is all that counts; of -2^31 there is no opposite.
    fn way_of(&self, axis: Axis) -> i32 {
        if self.steps[axis.i()] < 0 { -1 } else { 1 }
    }
    fn moving(&self) -> u8 {
        u8::from(!self.board.motor.path_rests())
    }
    // A rapid move rests at its end, as the trace of what follows it promises.
    fn is_taken(&self) -> bool {
        self.flags() & (flags::RAPID | flags::EXACT) == 0 || self.board.motor.path_rests()
    }
}

impl<C: Chip> Courses for Line<'_, C> {}
