//! Sensors and people.

use super::belt::sight;
use super::{About, Action, Cell, Timer};
use crate::region::Region;
use crate::scene::{Block, Eye, Sensor, When};

impl Cell {
    pub(super) fn sensor_regions(
        &self,
        index: usize,
        sensor: &Sensor,
        body: &[Block],
        hanging: &[Block],
        regions: &mut Vec<(About, Region)>,
    ) {
        if let Eye::Switch(axis, place, side) = &sensor.eye {
            let Some(axis) = "XYZ".find(*axis).filter(|_| self.hand == 0) else { return };
            let mut low = [i32::MIN; 3];
            let mut high = [i32::MAX; 3];
            let steps = ((place - self.frame.start[axis]) * self.frame.scale[axis]).round() as i32;
            if (*side > 0) == (self.frame.scale[axis] > 0.0) {
                low[axis] = steps
            } else {
                high[axis] = steps
            }
            regions.push((About::Switch(index), Region { low, high }));
            return;
        }
        let Some(block) = sight(&sensor.eye) else { return };
        // What hangs on the tool has one colour.
        let hanging = match (&sensor.eye, self.tool.held()) {
            (Eye::Colour(_, colour), Some(which)) if !self.has_colour(which, colour) => &[],
            _ => hanging,
        };
        if sensor.sees[1] {
            regions.extend(
                body.iter()
                    .map(|part| (About::Sensor(index), self.region(self.hand, &block, part, 0.0))),
            );
        }
        if sensor.sees[0] || sensor.sees[2] {
            regions.extend(
                hanging
                    .iter()
                    .map(|part| (About::Sensor(index), self.region(0, &block, part, 0.0))),
            );
        }
    }

    /// A sensor looks: it answers after its delay.
    pub(super) fn look(&mut self, index: usize, us: u64) {
        let scene = self.scene.clone();
        let sensor = &scene.sensors[index];
        let block = sight(&sensor.eye);
        let standing = sensor.sees[0]
            && block.is_some_and(|block| {
                self.things.iter().enumerate().any(|(which, thing)| {
                    let right = match &sensor.eye {
                        Eye::Colour(_, colour) => self.has_colour(which, colour),
                        _ => true,
                    };
                    right && thing.standing().iter().any(|other| covers(&block, other))
                })
            });
        let sees = self.seen[index] > 0 || standing;
        if self.looked[index].replace(sees) == Some(sees) {
            return;
        }
        // What it was about to say is no longer so.
        self.timers.retain(|timer| !matches!(timer.1, Timer::Sense(own, _) if own == index));
        let delay = if sees { sensor.on_us } else { sensor.off_us };
        self.timers.push((us + delay, Timer::Sense(index, sees)));
        // It bounces: the last change is the true one.
        let mut bounce = sensor.bounce_us / 4;
        let mut state = sees;
        while bounce > 0 && bounce <= sensor.bounce_us {
            state = !state;
            self.timers.push((us + delay + bounce, Timer::Sense(index, state)));
            self.timers
                .push((us + delay + bounce + sensor.bounce_us / 8, Timer::Sense(index, !state)));
            state = !state;
            bounce += sensor.bounce_us / 4;
        }
    }

    fn has_colour(&self, which: usize, colour: &str) -> bool {
        self.scene.parts[self.things[which].part].colour.eq_ignore_ascii_case(colour)
    }

    pub(super) fn person(&mut self, index: usize, us: u64) {
        let person = self.scene.persons[index].clone();
        if self.done[index] >= person.times {
            return;
        }
        self.done[index] += 1;
        let when = us + person.after_us;
        let mut button = |make: fn(bool) -> Action| {
            self.timers.push((when, Timer::Act(make(true))));
            self.timers.push((when + person.hold_us, Timer::Act(make(false))));
        };
        match person.does.as_str() {
            "start" => button(Action::Start),
            "stop" => button(Action::Stop),
            "estop" => button(Action::Emergency),
            "input" => {
                if let Some(input) = person.input {
                    self.timers.push((when, Timer::Act(Action::Input(input, true))));
                    self.timers
                        .push((when + person.hold_us, Timer::Act(Action::Input(input, false))));
                }
            }
            "take" | "put" => {
                self.timers.push((when, Timer::Hands(index, person.does == "put")));
            }
            "at" => {
                if let Some(register) = person.register {
                    self.timers.push((when, Timer::Act(Action::Register(register, person.value))));
                }
            }
            _ => {}
        }
    }

    /// The script waits for Start: people who wait for that act. Gives whether anybody does.
    pub fn waits_for_start(&mut self, us: u64) -> bool {
        let mut acts = false;
        for index in 0..self.scene.persons.len() {
            let person = &self.scene.persons[index];
            if person.when == When::WaitStart && self.done[index] < person.times {
                acts = true;
                self.person(index, us);
            }
        }
        acts
    }

    /// The script prints a line.
    pub fn prints(&mut self, text: &str, us: u64) {
        for index in 0..self.scene.persons.len() {
            if matches!(&self.scene.persons[index].when, When::Print(wanted) if text.contains(wanted.as_str()))
            {
                self.person(index, us);
            }
        }
    }
}

/// Whether two blocks share a place, a touch included.
fn covers(one: &Block, other: &Block) -> bool {
    (0..3).all(|axis| one.low[axis] <= other.high[axis] && other.low[axis] <= one.high[axis])
}
