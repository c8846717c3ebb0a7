//! The axes: their planners, and the step engine that plays the segments of these.

mod path;
mod places;

pub use path::tag;

use crate::machine::chip::Chip;
use crate::machine::pwm::Pwm;
use crate::machine::vm::{axis_of, convert};
use crate::motion::actions::Actions;
use crate::motion::scaled::Scaled;
use crate::motion::{Pace, Path, PathSegment, Segment, Single};
use core::ptr::addr_of_mut;
use lang::fault::Fault;
use lang::record::AxisRecord;

/// The step timer's rate for the planner.
const fn clock<C: Chip>() -> Scaled {
    Scaled::constant(C::RATE)
}

/// Axes.
pub const AXES: u8 = 3;

/// Where the axes are and what they do.
pub struct Motor<C: Chip> {
    /// The chip whose step engine it feeds.
    chip: C,
    /// The axes' part of the profile of the program that the VM stands in.
    pub machine: C::Axes,
    /// Commanded machine positions, um.
    pub um: [i32; 3],
    /// Commanded machine positions, steps.
    pub steps: [i32; 3],
    /// Work offsets: machine position less work position, um.
    pub offset: [i32; 3],
    /// Machine positions where the probe answered, steps.
    pub probed: [i32; 3],
    /// Machine positions at this instant, steps.
    actual: [i32; 3],
    /// Bit per axis: homed.
    pub homed: u8,
    /// Bit per axis: SetPos has said where it is, in this run.
    pub placed: u8,
    /// Bit per axis: the last probe answered.
    pub probe_ok: u8,
    /// Bit per axis: was stopped, so its commanded place follows when it rests.
    stopped: u8,
    /// Bit per axis: MoveSpeed runs it.
    running: u8,
    /// Speed override, percent: of feeds and of axes on their own, of rapid moves.
    pub percents: [u8; 2],
    /// Bit per axis: homing or probing, which no override changes.
    seeks: u8,
    /// Bit per axis: the path moves it.
    path_axes: u8,
    /// Second leg of a rapid move that lifts or lowers Z apart; all 0 for none.
    leg: [i32; 3],
    /// Bit per axis: moves in negative direction; at rest the one in which it moved last.
    pub negative: u8,
    path: Path,
    /// Where the path's block that plays ends, steps.
    block_end: [i32; 3],
    /// Where its statement stands in the program's code.
    block_pc: u16,
    /// A stop or a fault has cut the path there.
    cut: bool,
    /// S: power of a laser, 0 to 1000; with a PWM its level.
    pub power: u16,
    /// M4: a laser's power follows the speed.
    pub follows: bool,
    /// The PWM.
    pub pwm: Pwm,
    segment: PathSegment,
    single: [Single; 3],
    /// Outputs that act on the way.
    pub actions: Actions,
}

/// Everything at 0.
///
/// # Safety
/// As [`crate::machine::Controller::init`].
#[allow(unsafe_code)]
pub unsafe fn init<C: Chip>(motor: *mut Motor<C>, chip: C) {
    let clock = const { clock::<C>() };
    // SAFETY: the caller's; the rest is integers.
    unsafe {
        addr_of_mut!((*motor).machine).write(chip.free_axes());
        addr_of_mut!((*motor).chip).write(chip);
        addr_of_mut!((*motor).percents).write([100; 2]);
        // All 0 is a path, whose overrides are missing.
        (*motor).path.begin(0, clock);
        (*motor).path.set_override(100, 100);
        addr_of_mut!((*motor).segment).write(PathSegment::default());
        addr_of_mut!((*motor).single).write([Single::new(0, clock); 3]);
    }
}

impl<C: Chip> Motor<C> {
    /// An axis's part of the profile.
    #[inline(never)]
    pub fn axis(&self, n: u8) -> &AxisRecord {
        axis_of(&self.machine, n)
    }

    /// um to steps of an axis or back, half away from zero.
    ///
    /// # Errors
    /// F01.
    pub fn convert(&self, n: u8, value: i32, to_steps: bool) -> Result<i32, Fault> {
        convert::<C>(&self.machine, n, value, to_steps)
    }

    /// A new run: work offsets are 0, commanded places are where the axes stand.
    pub fn begin(&mut self) {
        self.offset = [0; 3];
        self.placed = 0;
        self.path.begin(self.machine.corner, const { clock::<C>() });
        self.actions.clear();
        self.cut = false;
        self.running = 0;
        self.stopped = 0;
        let mut n = 0;
        while n < AXES {
            self.place(n, self.actual[usize::from(n)]);
            n += 1;
        }
        self.set_override(self.percents);
    }

    /// The axes are those of this record from now on, with their directions: jogs and homings outside of a run go by it,
    /// too. Nothing moves meanwhile; DIR changes with the next move.
    pub fn take(&mut self, machine: C::Axes) {
        self.machine = machine;
        let mut invert = 0;
        let mut n = 0;
        while n < AXES {
            if self.axis(n).flags & AxisRecord::INVERT != 0 {
                invert |= C::DIR[usize::from(n)];
            }
            n += 1;
        }
        self.chip.set_invert(invert);
    }

    /// Sends an axis to a place on its own ramp; `seeks`: as it looks for a switch or a probe.
    pub fn go(&mut self, n: u8, steps: i32, pace: Pace, seeks: bool) {
        let i = usize::from(n);
        self.face(n, steps < self.actual[i]);
        self.running &= !(1 << n);
        self.seeks &= !(1 << n);
        self.seeks |= u8::from(seeks) << n;
        self.single[i].percent = self.percent(n);
        self.single[i].go(axis_of(&self.machine, n), steps, pace);
    }

    /// A resting axis is about to move: where it stands at its closed switch, away from it is no fault.
    fn face(&mut self, n: u8, negative: bool) {
        if !self.moves(n) {
            self.set_negative(n, negative);
        }
    }

    fn set_negative(&mut self, n: u8, on: bool) {
        self.negative &= !(1 << n);
        self.negative |= u8::from(on) << n;
    }

    /// Axes that MoveSpeed runs.
    pub fn running(&self) -> u8 {
        if self.running == 0 { 0 } else { self.running & self.moving() }
    }

    /// Axes that MoveSpeed has run to the end of their travel, told once. They count as stopped: where one rests becomes its
    /// commanded place, as after any other stop.
    pub fn take_limited(&mut self) -> u8 {
        if self.running == 0 {
            return 0;
        }
        let moving = self.moving();
        let limited = self.running & !moving & !self.stopped;
        self.running &= moving;
        self.stopped |= limited;
        limited
    }

    /// Speed override, percent: see [`Motor::percents`].
    pub fn set_override(&mut self, percents: [u8; 2]) {
        self.percents = percents;
        self.path.set_override(percents[0], percents[1]);
        let mut n = AXES;
        while n != 0 {
            n -= 1;
            let percent = self.percent(n);
            self.single[usize::from(n)].set_override(axis_of(&self.machine, n), percent);
        }
    }

    /// The override that holds for an axis on its own.
    fn percent(&self, n: u8) -> u8 {
        if self.seeks >> n & 1 != 0 { 100 } else { self.percents[0] }
    }

    /// Runs an axis at a speed.
    pub fn run(&mut self, n: u8, negative: bool, limit: Option<i32>, pace: Pace) {
        self.face(n, negative);
        self.running |= 1 << n;
        self.seeks &= !(1 << n);
        self.single[usize::from(n)].percent = self.percents[0];
        self.single[usize::from(n)].run(axis_of(&self.machine, n), negative, limit, pace);
    }

    /// Hands segments to the engine and takes its counts.
    ///
    /// With `hold` commanded places stay what they are: the host has not read those of the event
    /// that waits for it.
    #[inline(never)]
    pub fn poll(&mut self, hold: bool) {
        let mut n = AXES;
        while n != 0 {
            n -= 1;
            let i = usize::from(n);
            let before = self.actual[i];
            self.chip.fold(i, &mut self.actual[i]);
            if self.actual[i] != before {
                // The count of a belt comes round.
                self.set_negative(n, self.actual[i].wrapping_sub(before) < 0);
            }
        }
        if self.path_axes != 0 {
            self.poll_path(hold);
        } else {
            self.poll_singles(hold);
        }
    }

    fn poll_singles(&mut self, hold: bool) {
        for (i, single) in self.single.iter_mut().enumerate() {
            if !single.is_idle() && self.chip.axis_has_room(i) {
                let mut segment = Segment::default();
                if single.next_segment(&mut segment) {
                    self.chip.put_axis(i, &segment, single.negative());
                }
            }
        }
        if hold || self.stopped == 0 {
            return;
        }
        let mut n = AXES;
        while n != 0 {
            n -= 1;
            let i = usize::from(n);
            let rests = self.single[i].is_idle() && !self.chip.axis_is_running(i);
            if self.stopped >> n & 1 != 0 && rests {
                self.stopped &= !(1 << n);
                self.settle_here(n);
            }
        }
    }

    /// Bit per axis that moves or has something left to do.
    pub fn moving(&self) -> u8 {
        if self.path_axes != 0 {
            return self.path_axes;
        }
        // Asked several times in each pass of the main loop: no multiplication for an index.
        let mut moving = self.stopped;
        let mut bit = 1;
        for (i, single) in self.single.iter().enumerate() {
            if !single.is_idle() || self.chip.axis_is_running(i) {
                moving |= bit;
            }
            bit <<= 1;
        }
        moving
    }

    /// Whether an axis moves or has something left to do.
    #[inline(never)]
    pub fn moves(&self, n: u8) -> bool {
        self.moving() >> n & 1 != 0
    }

    /// Whether no step comes any more: everything has ended, or rests in a pause.
    pub fn rests(&self) -> bool {
        if self.chip.is_running() {
            return false;
        }
        if self.path_axes != 0 {
            return self.path.is_idle() || self.path.is_paused();
        }
        let mut n = AXES;
        while n != 0 {
            n -= 1;
            let single = &self.single[usize::from(n)];
            if !single.is_idle() && !single.is_paused() {
                return false;
            }
        }
        true
    }

    /// Whether everything rests and the commanded places of what was stopped are where it stands.
    pub fn settled(&self) -> bool {
        self.stopped == 0 && self.rests()
    }

    /// Bit per axis that moves, or that MoveSpeed has run to its end without the program's knowing yet.
    pub fn busy(&self) -> u8 {
        self.running | self.moving()
    }

    /// Whether an axis was stopped whose commanded place does not follow yet.
    pub fn is_stopping(&self) -> bool {
        self.stopped != 0
    }

    /// Whether the step engine holds as much as it is to hold for now.
    #[cfg(any(test, feature = "physics"))]
    pub fn is_fed(&self) -> bool {
        if self.path_axes != 0 {
            return self.chip.ahead() >= crate::motion::queue::wanted(&self.path, C::RATE)
                || !self.chip.path_has_room();
        }
        let mut singles = self.single.iter().enumerate();
        singles.all(|(i, single)| single.is_idle() || !self.chip.axis_has_room(i))
    }

    /// Speed of an axis of its own, steps/s with sign.
    pub fn velocity(&self, n: u8) -> i32 {
        self.single[usize::from(n)].velocity()
    }

    /// Speed that an axis on its own is to have, steps/s with sign; 0 at rest and on a path.
    pub fn wanted_velocity(&self, n: u8) -> i32 {
        self.single[usize::from(n)].wanted_velocity()
    }

    /// Brakes everything to a pause, or goes on.
    pub fn pause(&mut self, on: bool) {
        self.path.pause(on);
        for single in &mut self.single {
            single.pause(on);
        }
    }

    /// The pause of a run that ends holds nothing any more: what commands move next would rest for ever.
    pub fn end_pause(&mut self) {
        for single in &mut self.single {
            single.pause(false);
        }
        // A path that the stop brakes is cleared where it rests.
        if self.path_axes == 0 {
            self.path.pause(false);
        }
    }

    /// Ramps axes down and forgets the rest.
    pub fn stop(&mut self, axes: u8) {
        let moving = self.moving() & axes;
        self.stopped |= moving;
        self.running &= !axes;
        if self.path_axes & axes != 0 {
            self.path.pause(true);
            return;
        }
        let mut n = AXES;
        while n != 0 {
            n -= 1;
            if moving >> n & 1 != 0 {
                self.single[usize::from(n)].stop();
            }
        }
    }

    /// Steps cease at once.
    pub fn halt(&mut self) {
        self.chip.halt();
        self.cut |= self.path_axes != 0;
        self.path.clear();
        self.leg = [0; 3];
        self.path_axes = 0;
        let mut n = AXES;
        while n != 0 {
            n -= 1;
            self.chip.fold(usize::from(n), &mut self.actual[usize::from(n)]);
            self.single[usize::from(n)].halt(self.actual[usize::from(n)]);
        }
        self.stopped = 0b111;
    }

    /// The probe or switch answered when the axis was at `caught`.
    pub fn hit(&mut self, n: u8, caught: i32) {
        let i = usize::from(n);
        if self.single[i].hit(axis_of(&self.machine, n), caught) {
            self.chip.halt_axis(i);
            self.chip.fold(i, &mut self.actual[i]);
            self.single[i].halt(self.actual[i]);
        }
        self.stopped |= 1 << n;
    }
}
