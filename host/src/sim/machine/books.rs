//! Records motion in the log of the run.

use lang::axis::Axis;

use super::Machine;
use super::motion::Milestone;
use crate::sim::record::{Segment, SegmentKind};

impl Machine {
    /// A piece of the path of one axis begins; one that it replaces is over.
    pub(super) fn begin_solo(&mut self, axis: Axis, kind: SegmentKind, to: i32) {
        self.end_solo(axis, self.clock.now());
        let from = self.motion.positions(self.clock.now());
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
            start_us: self.clock.now(),
            end_us: self.clock.now(),
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
                    for what in what {
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
