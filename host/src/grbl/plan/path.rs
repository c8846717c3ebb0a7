//! The motion of a line: straight, along an arc, until a probe answers.

use super::{Planner, Refusal, Sync, distance, feed, target, um};
use crate::grbl::Error;
use crate::grbl::arc::{Arc, Center};
use crate::grbl::modal::{Motion, Point};
use crate::grbl::order::Order;

impl Planner<'_, '_> {
    pub(super) fn rapid(&mut self, to: Point) -> Result<(), Refusal> {
        let from = self.plan.to;
        let target = target(self.here, from, to)?;
        if target != [None; 3] {
            let top = self.here.machine.axes.iter().flatten().map(|axis| axis.top);
            let top = top.fold(1.0, f64::max) / 1000.0;
            self.plan.seconds += distance(from, to) / top / 2.0;
            self.plan.orders.push(Order::Rapid(target));
        }
        self.plan.to = to;
        Ok(())
    }

    pub(super) fn motion(&mut self, motion: Motion) -> Result<(), Refusal> {
        let to = self.words()?;
        let from = self.here.at;
        match motion {
            Motion::Off => Ok(()),
            Motion::Rapid => self.rapid(to),
            Motion::Line => {
                let target = target(self.here, from, to)?;
                let length = distance(from, to);
                let feed = self.feed_for(length);
                if target != [None; 3] {
                    let power = self.power();
                    self.plan.orders.push(Order::Line { to: target, feed, power });
                }
                self.plan.seconds += length * 1000.0 / f64::from(feed);
                self.plan.to = to;
                Ok(())
            }
            Motion::Clockwise | Motion::CounterClockwise => {
                self.arc(to, motion == Motion::Clockwise)
            }
            Motion::Probe { quiet, away } => self.probe(to, quiet, away),
        }
    }

    /// The feed of a path, um/s.
    fn feed_for(&self, length: f64) -> i32 {
        let modal = &self.plan.modal;
        feed(if modal.inverse_time { modal.feed * length } else { modal.feed })
    }

    fn arc(&mut self, to: Point, clockwise: bool) -> Result<(), Refusal> {
        let plane = self.plan.modal.plane;
        let (axes, letters) = match plane {
            18 => ([2, 0], ['K', 'I']),
            19 => ([1, 2], ['J', 'K']),
            _ => ([0, 1], ['I', 'J']),
        };
        let third = 3 - axes[0] - axes[1];
        let words = self.block.axes();
        if axes.iter().all(|i| words[*i].is_none()) {
            return Err(Error::ARC_AXES.into());
        }
        let word = |letter| self.block.value(letter).map(|value| value * self.scale);
        let center = match word('R') {
            Some(radius) => Center::Radius(radius),
            None if letters.iter().all(|letter| word(*letter).is_none()) => {
                return Err(Error::ARC_OFFSETS.into());
            }
            None => Center::Offset(letters.map(|letter| word(letter).unwrap_or(0.0))),
        };
        let from = self.here.at;
        let [start, end] = [from, to].map(|place| axes.map(|i| place[i]));
        let arc = Arc::new(start, end, center, clockwise)?;
        let goal = target(self.here, from, to)?;
        // The farthest points count as ends do.
        let [first, second] = arc.reach(start, end);
        for low in [0, 1] {
            let mut corner = to;
            (corner[axes[0]], corner[axes[1]]) = (first[low], second[low]);
            target(self.here, from, corner)?;
        }
        let length = arc.length().hypot(to[third] - from[third]);
        let feed = self.feed_for(length);
        let power = self.power();
        let (whole_start, whole_end) = (axes.map(|i| um(from[i])), axes.map(|i| um(to[i])));
        // What is shorter than a um is no arc, and a board would take it for a full circle.
        let closed = whole_start == whole_end;
        if !closed || arc.turn.abs() > std::f64::consts::PI {
            let center = [0, 1].map(|i| um(arc.center[i]));
            let mut offset = [0; 2];
            let mut to_all = goal;
            for i in 0..2 {
                offset[i] = center[i]? - um(start[i])?;
                to_all[axes[i]] = Some(um(end[i])?);
            }
            let to = to_all;
            self.plan.orders.push(Order::Arc { plane, clockwise, to, center: offset, feed, power });
        } else if goal != [None; 3] {
            self.plan.orders.push(Order::Line { to: goal, feed, power });
        }
        self.plan.seconds += length * 1000.0 / f64::from(feed);
        self.plan.to = to;
        Ok(())
    }

    fn probe(&mut self, to: Point, quiet: bool, away: bool) -> Result<(), Refusal> {
        let from = self.here.at;
        let goal = target(self.here, from, to)?;
        let mut moving = (0..3).filter(|i| goal[*i].is_some());
        let (Some(axis), None) = (moving.next(), moving.next()) else {
            let words = "a probe goes along one axis".to_owned();
            return Err(Refusal::Told(Error::UNSUPPORTED, words));
        };
        let limit = goal[axis].unwrap_or(0);
        let feed = self.feed_for(distance(from, to));
        let input = self.here.machine.probe;
        self.plan.orders.push(Order::Probe { axis, limit, feed, input, away });
        self.plan.sync = Some(Sync::Probe { quiet });
        self.plan.to = to;
        Ok(())
    }
}
