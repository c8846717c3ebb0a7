//! Faults that strike a run while it runs: parts that miss, stick or get lost, inputs that hang, motors that stall, people
//! who press what they should not. Faults that only change a number or a time are in [`crate::vary::applied`].

use super::{Action, Cell, Timer};
use crate::scene::ToolKind;
use crate::things::{self, Where};
use crate::vary::Deviation;

/// A button is pressed for so long, us.
const PRESS_US: u64 = 100_000;
/// Who stops the machine holds Stop for so long, us: pressed for less than 2 s it only pauses.
const STOP_US: u64 = 2_500_000;
/// Who has closed the door presses Start so long after it, us.
const RESUME_US: u64 = 500_000;
/// A pause lasts so long where the deviation does not say, us.
const PAUSE_US: u64 = 2_000_000;
/// A part is lost so long after it was taken where the deviation does not say, us.
const LOST_US: u64 = 200_000;
/// A part lies so much turned where the deviation does not say, degrees.
const TURNED_DEG: f64 = 90.0;

impl Cell {
    /// Lets deviations that are faults strike; those of numbers are in the scene already.
    pub fn strike(&mut self, deviations: &[Deviation]) {
        for deviation in deviations {
            if !deviation.what.contains('.') {
                self.fault(deviation, 0);
            } else if let Some(which) = self.brought(&deviation.of) {
                self.differs(which, deviation);
            }
            if self.things.iter().all(|thing| thing.name != deviation.of) {
                self.struck.coming.push(deviation.clone());
            }
        }
        if deviations.is_empty() {
            return;
        }
        self.rebuild(&[0; 4], 0);
        for index in 0..self.scene.sensors.len() {
            self.look(index, 0);
        }
    }

    /// The first part of a tape, tube or bowl: the only one that stands there at the begin.
    fn brought(&self, name: &str) -> Option<usize> {
        self.things.iter().position(|thing| {
            let feeder = thing.feeder.map(|(index, _)| &self.scene.feeders[index]);
            thing.name == name && feeder.is_some_and(|feeder| feeder.advances())
        })
    }

    /// A part lies elsewhere than the others of its feeder, or turned.
    fn differs(&mut self, which: usize, deviation: &Deviation) {
        let thing = &mut self.things[which];
        match (deviation.what.rsplit('.').next(), &mut thing.place) {
            (Some("at" | "corner"), Where::Stands(at)) => {
                for (number, by) in at.iter_mut().zip(&deviation.by).take(2) {
                    *number += by;
                }
                thing.home = thing.place;
            }
            (Some("turn_deg"), _) => {
                thing.form.turn_deg += deviation.by.first().copied().unwrap_or(0.0);
            }
            _ => {}
        }
    }

    /// A feeder or a belt has brought a part: what was to strike it does.
    pub(super) fn arrives(&mut self, which: usize, us: u64) {
        let name = &self.things[which].name;
        let own: Vec<Deviation> =
            self.struck.coming.iter().filter(|own| own.of == *name).cloned().collect();
        for deviation in own {
            if deviation.what.contains('.') {
                self.differs(which, &deviation);
            } else {
                self.fault(&deviation, us);
            }
        }
    }

    /// `now` is when a part is brought, us.
    fn fault(&mut self, deviation: &Deviation, now: u64) {
        let Deviation { what, of, by, at_us } = deviation;
        let by = by.first().copied();
        let us = by.map(|us| us.max(0.0) as u64);
        let at_us = at_us.unwrap_or(0);
        let thing = self.things.iter().position(|thing| thing.name == *of);
        match (what.as_str(), thing) {
            ("missing", Some(which)) => {
                self.things[which].place = Where::Gone;
                self.left_feeder(which, now);
            }
            ("turned", Some(which)) => self.things[which].form.turn_deg += TURNED_DEG,
            ("stuck", Some(which)) => {
                self.struck.stuck.insert(which, us.unwrap_or(LOST_US));
            }
            ("lost", Some(which)) => {
                self.struck.lost.insert(which, us.unwrap_or(LOST_US));
            }
            ("double", Some(which)) => {
                self.struck.double.insert(which);
            }
            ("gone", _) => self.timers.push((at_us, Timer::Act(Action::Gone))),
            ("slow", _) => {
                // Of sensors and feeders it is in the scene already.
                let slow = self.scene.tools.iter().position(|tool| tool.name == *of);
                self.struck.slow_us.extend(slow.zip(us.filter(|us| *us > 0)));
            }
            ("dead_on" | "dead_off", _) => {
                if let Some(input) = self.input_of(of) {
                    let on = what == "dead_on";
                    self.struck.forced.insert(input, on);
                    self.actions.push(Action::Input(input, on));
                }
            }
            ("stall", _) => {
                if let Some(axis) = of.chars().next().and_then(|letter| "XYZ".find(letter)) {
                    let steps = by.unwrap_or(0.0) as i32;
                    self.timers.push((at_us, Timer::Act(Action::Stall(axis, steps))));
                }
            }
            ("pause", _) => {
                self.timers.push((at_us, Timer::Act(Action::Pause(true))));
                let end = at_us + us.unwrap_or(PAUSE_US);
                self.timers.push((end, Timer::Act(Action::Pause(false))));
            }
            ("stop" | "estop" | "door", _) => {
                let (make, least): (fn(bool) -> Action, _) = match what.as_str() {
                    "stop" => (Action::Stop, STOP_US),
                    "door" => (Action::Door, PRESS_US),
                    _ => (Action::Emergency, PRESS_US),
                };
                self.timers.push((at_us, Timer::Act(make(true))));
                let end = at_us + us.unwrap_or(least).max(least);
                self.timers.push((end, Timer::Act(make(false))));
                if what == "door" {
                    let start = end + RESUME_US;
                    self.timers.push((start, Timer::Act(Action::Resume(true))));
                    self.timers.push((start + PRESS_US, Timer::Act(Action::Resume(false))));
                }
            }
            _ => {}
        }
    }

    /// A thing that was taken brings a second one of its kind, which hangs under it.
    pub(super) fn doubles(&mut self, which: usize) {
        let Where::Held(offset) = self.things[which].place else { return };
        if !self.struck.double.remove(&which) {
            return;
        }
        let thing = &self.things[which];
        let below = [offset[0], offset[1], offset[2] - thing.form.size[2]];
        let name = format!("{}{}", thing.name, things::TWIN);
        let mut twin = things::thing(name, thing.part, None, thing.form, Where::Held(below));
        twin.home = Where::Gone;
        self.struck.twins.insert(which, self.things.len());
        self.things.push(twin);
    }

    /// The input that a sensor or a tool drives.
    fn input_of(&self, name: &str) -> Option<u32> {
        let sensor = self.scene.sensors.iter().find(|sensor| sensor.name == name);
        let tool = self.scene.tools.iter().find(|tool| tool.name == name);
        sensor.and_then(|sensor| sensor.input).or_else(|| match &tool?.kind {
            ToolKind::Vacuum(vacuum) => vacuum.input,
            ToolKind::Gripper(gripper) => gripper.input_gripped,
            ToolKind::Probe { input, .. } => *input,
            _ => None,
        })
    }

    /// Actions on inputs that hang are lost.
    pub(super) fn without_forced(&self, actions: Vec<Action>) -> Vec<Action> {
        let hangs = |action: &Action| match action {
            Action::Input(n, on) => self.struck.forced.get(n).is_some_and(|own| own != on),
            _ => false,
        };
        actions.into_iter().filter(|action| !hangs(action)).collect()
    }
}
