//! Axes on their own, outputs, and what motion leaves in the books.

use std::collections::VecDeque;

use firmware::motion::scaled::Scaled;
use firmware::motion::single::{Pace, steps_of};
use lang::axis::Axis;
use lang::effect::{Coord, Rate};
use lang::fault::Fault;
use lang::place::{Place, way};

use super::Machine;
use super::axes::scaled;
use super::motion::Milestone;
use super::perform::positive;
use crate::sim::record::{Segment, SegmentKind};
use crate::sim::trace::{AxisLetter, MoveKind, What};

/// Pieces of the path that are under way.
#[derive(Debug, Default)]
pub struct Pieces {
    /// One for each block that waits for its beginning, with what is written then.
    pub blocks: VecDeque<(Option<What>, Segment)>,
    /// Line of the block that plays.
    pub line: Option<u32>,
    /// Power of the block that plays.
    pub beam: Option<i32>,
    /// Number in the record of the piece that the path plays.
    path: Option<usize>,
    /// The same for each axis on its own.
    solo: [Option<usize>; 3],
}

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
        let here = self.motion.positions(self.now)[axis.index()];
        let from = if running {
            Place { um: self.axes.length(axis, here)?, steps: here }
        } else {
            self.axes.place(axis)
        };
        let pace = self.pace(axis, asked)?;
        let to = self.axes.aim(axis, word, from)?;
        way(self.motion.positions(self.now)[axis.index()], to.steps)?;
        let moves = running || to.steps != self.axes.steps(axis);
        self.axes.command(axis, to);
        self.axes.set_running(axis, false);
        if moves {
            let line = self.line;
            let targets = self.targets();
            self.write(What::Move { line, kind: MoveKind::Axe, to: targets });
            self.begin_solo(axis, SegmentKind::Move(MoveKind::Axe), to.steps);
            self.motion.go(axis, to.steps, pace, self.now);
            self.log_milestones();
            self.next = 0;
        }
        if wait {
            self.rest_solo(axis);
        }
        Ok(())
    }

    /// Waits until the axis does not move on its own.
    pub(super) fn rest_solo(&mut self, axis: Axis) {
        self.next = 0;
        while self.halt.is_none() && !self.motion.is_solo_idle(axis) && self.tick(None) {}
    }

    /// Whether no axis has anything left to do.
    pub(super) fn all_rest(&self) -> bool {
        Axis::ALL.into_iter().all(|axis| !self.motion.is_moving(axis))
    }

    /// Where an axis rests becomes its commanded place, if it is another one.
    pub(super) fn adopt(&mut self, axis: Axis) {
        let at = self.motion.positions(self.now)[axis.index()];
        self.axes.set_running(axis, false);
        if at != self.axes.steps(axis) {
            self.axes.adopt(axis, at);
        }
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
        let here = self.motion.positions(self.now)[axis.index()];
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
        self.motion.run(axis, negative, limit, pace, self.now);
        self.log_milestones();
        self.next = 0;
        Ok(())
    }

    /// An axis that ran by MoveSpeed rests at its soft limit: F05 comes by itself.
    pub(super) fn run_limits(&mut self) {
        for axis in Axis::ALL {
            if self.axes.is_running(axis) && self.motion.is_solo_idle(axis) {
                self.adopt(axis);
                self.late = Some(Fault::SoftLimit);
                self.attention = true;
            }
        }
    }

    /// StopAxe, StopAll: returns at rest.
    pub(super) fn stop_axes(&mut self, axes: &[Axis]) {
        for &axis in axes {
            self.write(What::Stop { line: self.line, axis: AxisLetter(axis) });
            self.axes.set_running(axis, false);
            self.motion.stop(axis, self.now);
        }
        for &axis in axes {
            self.rest_solo(axis);
            self.adopt(axis);
        }
    }

    /// SetOut.
    pub(super) fn set_out(&mut self, n: i32, on: bool) -> Result<(), Fault> {
        self.outputs.set(n, on)?;
        self.write(What::Out { line: self.line, n, v: on.into() });
        self.outputs_changed();
        Ok(())
    }

    /// SetPort.
    pub(super) fn set_port(&mut self, value: i32) {
        for n in self.outputs.port() {
            let on = value >> (n - 1) & 1 != 0;
            if self.outputs.set(n, on).is_ok() {
                self.write(What::Out { line: self.line, n, v: on.into() });
            }
        }
        self.outputs_changed();
    }

    /// A piece of the path of one axis begins; one that it replaces is over.
    pub(super) fn begin_solo(&mut self, axis: Axis, kind: SegmentKind, to: i32) {
        self.end_solo(axis, self.now);
        let from = self.motion.positions(self.now);
        let mut axes = [false; 3];
        axes[axis.index()] = true;
        let mut end = from;
        end[axis.index()] = to;
        let segment = Segment {
            kind,
            line: self.line,
            from,
            to: end,
            axes,
            arc: None,
            start_us: self.now,
            end_us: self.now,
            peak_rate: 0.0,
            exit_speed: None,
            power: self.light(),
        };
        self.pieces.solo[axis.index()] = self.log.begin_segment(segment);
    }

    fn end_solo(&mut self, axis: Axis, us: u64) {
        let at = self.motion.positions(us)[axis.index()];
        let number = self.pieces.solo[axis.index()].take();
        if let Some(segment) = self.log.segment(number) {
            segment.to[axis.index()] = at;
            segment.end_us = us;
        }
    }

    /// Enters what motion did into the books.
    pub(super) fn log_milestones(&mut self) {
        for (us, what) in std::mem::take(&mut self.motion.milestones) {
            match what {
                Milestone::BlockBegins(power) => {
                    self.pieces.beam = Some(power.into());
                    let Some((what, mut segment)) = self.pieces.blocks.pop_front() else {
                        continue;
                    };
                    if let Some(what) = what {
                        self.log.write(us, what);
                    }
                    self.pieces.line = Some(segment.line);
                    segment.start_us = us;
                    segment.end_us = us;
                    self.end_path(us);
                    self.pieces.path = self.log.begin_segment(segment);
                }
                Milestone::PathEnds => {
                    self.end_path(us);
                    self.pieces.path = None;
                    self.pieces.blocks.clear();
                    self.pieces.beam = None;
                    self.pieces.line = None;
                }
                Milestone::PathRate(rate, speed) => {
                    if let Some(segment) = self.log.segment(self.pieces.path) {
                        segment.peak_rate = segment.peak_rate.max(rate);
                        segment.exit_speed = Some(speed);
                    }
                }
                Milestone::AxisRate(axis, rate) => {
                    if let Some(segment) = self.log.segment(self.pieces.solo[axis.index()]) {
                        segment.peak_rate = segment.peak_rate.max(rate);
                    }
                }
                Milestone::AxisRests(axis) => self.end_solo(axis, us),
            }
        }
    }

    fn end_path(&mut self, us: u64) {
        if let Some(segment) = self.log.segment(self.pieces.path) {
            segment.end_us = us;
        }
    }
}
