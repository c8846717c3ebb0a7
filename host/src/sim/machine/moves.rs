//! Axes on their own.

use firmware::motion::scaled::Scaled;
use firmware::motion::single::{Pace, steps_of};
use lang::axis::Axis;
use lang::effect::{Coord, Rate};
use lang::fault::Fault;
use lang::place::{Place, way};

use super::Machine;
use super::axes::scaled;
use super::motion::Motion;
use super::perform::positive;
use crate::sim::record::SegmentKind;
use crate::sim::trace::{AxisLetter, MoveKind, What};

impl Machine {
    /// Speed and ramps of a move, within what the axis can.
    pub(super) fn pace(&self, axis: Axis, asked: [Option<Rate>; 3]) -> Result<Pace, Fault> {
        let [speed, accel, decel] = asked;
        for rate in asked.into_iter().flatten() {
            positive(rate)?;
        }
        let record = self.motion.record(axis);
        let mut pace = Pace::of(record);
        pace = match speed {
            Some(Rate::Um(um)) => pace.with_um(record, um.unsigned_abs()),
            Some(Rate::Steps(steps)) => pace.with_steps(steps.unsigned_abs()),
            None => pace,
        };
        let ramp = |rate: Option<Rate>, own: u32| match rate {
            Some(Rate::Um(um)) => steps_of(record, um.unsigned_abs()),
            Some(Rate::Steps(steps)) => Scaled::new(steps.unsigned_abs()),
            None => Scaled::new(own),
        };
        pace = pace.with_ramps(ramp(accel, record.accel), ramp(decel.or(accel), record.decel));
        Ok(pace)
    }

    /// MoveAxe, MoveRel.
    pub(super) fn move_axe(
        &mut self,
        axis: Axis,
        word: Coord,
        asked: [Option<Rate>; 3],
        wait: bool,
    ) -> Result<(), Fault> {
        let running = self.axes.is_running(axis);
        let here = self.motion.positions(self.clock.now())[axis.index()];
        let from = if running {
            Place { um: self.axes.length(axis, here)?, steps: here }
        } else {
            self.axes.place(axis)
        };
        let pace = self.pace(axis, asked)?;
        let to = self.axes.aim(axis, word, from)?;
        way(self.motion.positions(self.clock.now())[axis.index()], to.steps)?;
        let moves = running || to.steps != self.axes.steps(axis);
        self.axes.command(axis, to);
        self.axes.set_running(axis, false);
        if moves {
            let line = self.line;
            let targets = self.targets();
            self.write(What::Move { line, kind: MoveKind::Axe, to: targets });
            self.begin_solo(axis, SegmentKind::Move(MoveKind::Axe), to.steps);
            self.motion.go(axis, to.steps, pace, self.clock.now());
            self.log_milestones();
            self.clock.look_anew();
        }
        if wait {
            self.rest_solo(axis);
        }
        Ok(())
    }

    /// Waits until the axis does not move on its own.
    pub(super) fn rest_solo(&mut self, axis: Axis) {
        self.clock.look_anew();
        while !self.is_halted() && !self.motion.is_solo_idle(axis) && self.tick(None) {}
    }

    /// Waits until no axis has anything left to do.
    pub(super) fn rest_all(&mut self) {
        self.clock.look_anew();
        let moves = |motion: &Motion| Axis::ALL.into_iter().any(|axis| motion.is_moving(axis));
        while !self.is_halted() && moves(&self.motion) && self.tick(None) {}
    }

    /// Where an axis rests becomes its commanded place, if it is another one.
    pub(super) fn adopt(&mut self, axis: Axis) {
        let at = self.motion.positions(self.clock.now())[axis.index()];
        self.axes.set_running(axis, false);
        if self.axes.length(axis, at).is_err() {
            // After a long way by MoveSpeed.
            self.axes.command(axis, Place::default());
            self.axes.clear_offset(axis);
            self.renew(axis, at);
        } else if at != self.axes.steps(axis) {
            self.axes.adopt(axis, at);
        }
    }

    /// The machine place of a resting axis begins anew at 0.
    pub(super) fn renew(&mut self, axis: Axis, before: i32) {
        self.plant.renew(axis, before);
        self.motion.set_position(axis, 0);
    }

    /// MoveSpeed.
    pub(super) fn move_speed(&mut self, axis: Axis, speed: Rate) -> Result<(), Fault> {
        if !self.axes.is_present(axis) {
            return Err(Fault::ValueRange);
        }
        let (Rate::Um(value) | Rate::Steps(value)) = speed;
        let negative = value < 0;
        let size = match speed {
            Rate::Um(um) => Rate::Um(um.checked_abs().ok_or(Fault::Overflow)?),
            Rate::Steps(steps) => Rate::Steps(steps.checked_abs().ok_or(Fault::Overflow)?),
        };
        let pace = self.pace(axis, [Some(size), None, None])?;
        let limit = self.axes.travel_end(axis, negative);
        let here = self.motion.positions(self.clock.now())[axis.index()];
        if limit.is_some_and(|end| if negative { here <= end } else { here >= end }) {
            return Err(Fault::SoftLimit);
        }
        let record = self.motion.record(axis);
        let rate = match size {
            Rate::Um(um) => scaled(um, record.steps, record.um).unwrap_or(i32::MAX),
            Rate::Steps(steps) => steps,
        };
        let rate = rate.clamp(1, i32::try_from(record.top_rate).unwrap_or(i32::MAX));
        let v = if negative { -rate } else { rate };
        self.write(What::Speed { line: self.line, axis: AxisLetter(axis), v });
        self.axes.set_running(axis, true);
        self.begin_solo(axis, SegmentKind::Speed, here);
        self.motion.run(axis, negative, limit, pace, self.clock.now());
        self.log_milestones();
        self.clock.look_anew();
        Ok(())
    }

    /// StopAxe, StopAll: returns at rest.
    pub(super) fn stop_axes(&mut self, axes: &[Axis]) {
        for &axis in axes {
            self.write(What::Stop { line: self.line, axis: AxisLetter(axis) });
            self.axes.set_running(axis, false);
            self.motion.stop(axis, self.clock.now());
        }
        for &axis in axes {
            self.rest_solo(axis);
            self.adopt(axis);
        }
    }
}
