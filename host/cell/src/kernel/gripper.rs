//! Two jaws: what lies between them when they have closed is held.

use super::{Action, Cell, Timer};
use crate::law::Steps;
use crate::scene::{Gripper, ToolKind};
use crate::things::Where;

impl Cell {
    fn gripper(&self) -> Option<Gripper> {
        match &self.own()?.kind {
            ToolKind::Gripper(gripper) => Some(gripper.clone()),
            _ => None,
        }
    }

    /// The gripper's output changes: it closes while that is on. What it holds falls as soon as the jaws begin to open.
    pub(super) fn jaws(&mut self, close: bool, at: &Steps, us: u64) {
        let Some(gripper) = self.gripper() else { return };
        // Jaws that turn back before they have met close on nothing.
        self.timers.retain(|timer| timer.1 != Timer::Jaws(self.hand));
        if close {
            self.timers.push((us + gripper.close_us, Timer::Jaws(self.hand)));
            return;
        }
        for input in [gripper.input_closed, gripper.input_gripped].into_iter().flatten() {
            self.actions.push(Action::Input(input, false));
        }
        if let Some(which) = self.tool.held() {
            self.release(which, at, us);
        }
    }

    /// Closed jaws have lost what they held: they meet.
    pub(super) fn slipped(&mut self) {
        let Some(gripper) = self.gripper().filter(|_| self.tool.is_on()) else { return };
        let inputs = [(gripper.input_gripped, false), (gripper.input_closed, true)];
        let actions = inputs.map(|(input, on)| input.map(|input| Action::Input(input, on)));
        self.actions.extend(actions.into_iter().flatten());
    }

    /// The jaws have closed: on what lies between them in both directions, if its width can be held, else on themselves.
    pub(super) fn closed(&mut self, at: &Steps, us: u64) {
        let Some(gripper) = self.gripper().filter(|_| self.tool.is_on()) else { return };
        if self.tool.held().is_some() {
            // It stuck to the open jaws, and they have come back.
            self.actions.extend(gripper.input_gripped.map(|input| Action::Input(input, true)));
            return;
        }
        let tip = self.here(at);
        let across = usize::from(!gripper.along_x);
        let found = (0..self.things.len()).find(|&which| {
            if self.rides(which) {
                return false;
            }
            let thing = &self.things[which];
            let Where::Stands(middle) = thing.place else { return false };
            let blocks = thing.standing();
            let bounds = |axis: usize| {
                let low = blocks.iter().map(|block| block.low[axis]).fold(f64::INFINITY, f64::min);
                let high =
                    blocks.iter().map(|block| block.high[axis]).fold(f64::NEG_INFINITY, f64::max);
                (low, high)
            };
            let (low, high) = bounds(across);
            let width = high - low;
            let half = gripper.opens / 2.0;
            let between = low >= tip[across] - half && high <= tip[across] + half;
            let (side_low, side_high) = bounds(1 - across);
            let beside = (side_low..=side_high).contains(&tip[1 - across]);
            let top = bounds(2).1;
            let deep = (middle[2]..=top).contains(&tip[2]);
            let fits = (gripper.grips[0]..=gripper.grips[1]).contains(&width);
            between && beside && deep && fits
        });
        match found {
            Some(which) => {
                self.take(which, at, us);
                if let Some(input) = gripper.input_gripped {
                    self.actions.push(Action::Input(input, true));
                }
            }
            None => {
                if let Some(input) = gripper.input_closed {
                    self.actions.push(Action::Input(input, true));
                }
            }
        }
    }
}
