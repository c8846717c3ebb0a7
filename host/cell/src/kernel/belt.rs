//! Conveyors. A thing on a belt that runs goes along with it at a constant speed, so the times at which it comes into the
//! sight of a sensor, leaves it, or comes to the end of the belt are computed, not looked for. While its belt runs a thing
//! obstructs nothing and cannot be taken; it rests where the belt stops.

use super::Cell;
use crate::law::Steps;
use crate::log::What;
use crate::scene::{Block, Conveyor, Drive, Eye, Gap, V3};
use crate::things::{self, Where};

/// A time that a belt takes for a way, whole us; the way is done then.
fn time_for(mm: f64, mm_s: f64) -> u64 {
    // A billionth is rounding.
    (mm.max(0.0) / mm_s * 1e6 - 1e-6).ceil().max(0.0) as u64
}

/// Bounds of a block along a belt, from the place of its middle: least and greatest.
fn along(block: &Block, along: [f64; 2]) -> [f64; 2] {
    let axis = usize::from(along[0] == 0.0);
    let sign = along[axis];
    let (a, b) = (block.low[axis] * sign, block.high[axis] * sign);
    [a.min(b), a.max(b)]
}

impl Cell {
    /// An output that may drive belts changes.
    pub(super) fn drive(&mut self, output: u32, on: bool, at: &Steps, us: u64) {
        for index in 0..self.belts.len() {
            if self.scene.conveyors[index].drive == Drive::Output(output) {
                self.move_on(index, us);
                self.belts[index].runs = on.then_some(us);
                if on {
                    let conveyor = self.scene.conveyors[index].clone();
                    self.feed_due(index, &conveyor, us);
                }
                self.rebuild(at, us);
                self.look_again(us);
            }
        }
        self.plan_belts(us);
    }

    /// Whether a thing lies on a belt that runs.
    pub(super) fn rides(&self, which: usize) -> bool {
        self.belts.iter().enumerate().any(|(index, belt)| {
            belt.runs.is_some() && self.lies_on(which, &self.scene.conveyors[index])
        })
    }

    fn lies_on(&self, which: usize, conveyor: &Conveyor) -> bool {
        let thing = &self.things[which];
        let Where::Stands(at) = thing.place else { return false };
        let block = &conveyor.block;
        !thing.stored
            && (0..2).all(|axis| (block.low[axis]..=block.high[axis]).contains(&at[axis]))
            && (at[2] - block.high[2]).abs() < 0.01
    }

    /// Moves what lies on a belt by what it ran since it was last looked at.
    fn move_on(&mut self, index: usize, us: u64) {
        let conveyor = self.scene.conveyors[index].clone();
        let Some(since) = self.belts[index].runs.filter(|&since| since < us || since == 0) else {
            return;
        };
        let mm = (us - since) as f64 / 1e6 * conveyor.mm_s;
        self.belts[index].runs = Some(us);
        for which in 0..self.things.len() {
            if !self.lies_on(which, &conveyor) {
                continue;
            }
            if let Where::Stands(place) = &mut self.things[which].place {
                place[0] += mm * conveyor.along[0];
                place[1] += mm * conveyor.along[1];
            }
            self.at_end(which, &conveyor, us);
        }
        self.belts[index].to_next -= mm;
        self.feed_due(index, &conveyor, us);
    }

    /// Parts whose turn it is to come onto a belt.
    fn feed_due(&mut self, index: usize, conveyor: &Conveyor, us: u64) {
        while conveyor.feeds.is_some() && self.belts[index].to_next <= 1e-6 {
            self.feed_belt(index, conveyor, us);
        }
    }

    /// What has come to the end of its belt goes into the place after it, or falls.
    fn at_end(&mut self, which: usize, conveyor: &Conveyor, us: u64) {
        let Where::Stands(at) = self.things[which].place else { return };
        let middle = at[0] * conveyor.along[0] + at[1] * conveyor.along[1];
        if middle < along(&conveyor.block, conveyor.along)[1] - 1e-6 {
            return;
        }
        let thing = self.things[which].name.clone();
        let place = conveyor.takes.as_ref();
        let place = self.scene.places.iter().find(|own| Some(&own.name) == place).cloned();
        match place {
            Some(place) => {
                self.things[which].place = Where::Stands(place.at);
                self.things[which].stored = place.room == 0;
                self.tell(us, What::Rest { thing, on: place.name.clone() });
                self.filled(place.at, us);
            }
            None => {
                self.things[which].place = Where::Gone;
                self.tell(us, What::Lost { thing, why: "fell off the end of its belt" });
            }
        }
    }

    /// A new part comes onto the begin of a belt.
    fn feed_belt(&mut self, index: usize, conveyor: &Conveyor, us: u64) {
        let Some((part, gap)) = conveyor.feeds else { return };
        let gap = match gap {
            Gap::Way(mm) => mm,
            Gap::Time(us) => us as f64 / 1e6 * conveyor.mm_s,
        };
        let belt = &mut self.belts[index];
        belt.to_next += gap.max(0.01);
        belt.fed += 1;
        let name = format!("{}.{}", conveyor.name, belt.fed);
        let block = &conveyor.block;
        let middle = |axis: usize| (block.low[axis] + block.high[axis]) / 2.0;
        let begin = |axis: usize| match conveyor.along[axis] {
            way if way > 0.0 => block.low[axis],
            way if way < 0.0 => block.high[axis],
            _ => middle(axis),
        };
        let at: V3 = [begin(0), begin(1), block.high[2]];
        if self.things.len() < things::MOST {
            let form = self.scene.parts[part].form;
            self.things.push(things::thing(name, part, None, form, Where::Stands(at)));
            self.arrives(self.things.len() - 1, us);
        }
    }

    /// Everything on belts is where it is now.
    pub(super) fn belts_until(&mut self, us: u64) {
        for index in 0..self.belts.len() {
            self.move_on(index, us);
        }
    }

    /// Something on a belt comes into sight of a sensor, leaves it, or comes to an end.
    pub(super) fn belts(&mut self, at: &Steps, us: u64) {
        if self.next_belt.is_none_or(|when| when > us) {
            return;
        }
        self.belts_until(us);
        self.rebuild(at, us);
        self.look_again(us);
        self.plan_belts(us);
    }

    /// When the next of these happens.
    pub(super) fn plan_belts(&mut self, us: u64) {
        let mut first: Option<u64> = None;
        for (belt, conveyor) in self.belts.iter().zip(&self.scene.conveyors) {
            let Some(since) = belt.runs else { continue };
            if conveyor.mm_s <= 0.0 {
                continue;
            }
            // The way that things have gone since they were last moved.
            let gone = us.saturating_sub(since) as f64 / 1e6 * conveyor.mm_s;
            let mut soon = |mm: f64| {
                if mm > gone + 1e-6 {
                    let when = since + time_for(mm, conveyor.mm_s).max(1);
                    first = Some(first.map_or(when, |other| other.min(when)));
                }
            };
            if conveyor.feeds.is_some() {
                soon(belt.to_next.max(gone + 2e-6));
            }
            let end = along(&conveyor.block, conveyor.along)[1];
            for which in 0..self.things.len() {
                if !self.lies_on(which, conveyor) {
                    continue;
                }
                let Where::Stands(at) = self.things[which].place else { continue };
                soon(end - (at[0] * conveyor.along[0] + at[1] * conveyor.along[1]));
                for sensor in self.scene.sensors.iter().filter(|sensor| sensor.sees[0]) {
                    let Some(sight) = sight(&sensor.eye) else { continue };
                    for block in self.things[which].standing() {
                        let [from, to] = along(&block, conveyor.along);
                        let [near, far] = along(&sight, conveyor.along);
                        // It comes in when its front is there, and is gone a hair after its back has passed.
                        soon(near - to);
                        soon(far - from + 2e-6);
                    }
                }
            }
        }
        self.next_belt = first;
    }
}

/// The block that an eye looks at.
pub fn sight(eye: &Eye) -> Option<Block> {
    match eye {
        Eye::Beam(from, to) | Eye::Distance(from, to, _) => Some(Block {
            low: std::array::from_fn(|axis| from[axis].min(to[axis])),
            high: std::array::from_fn(|axis| from[axis].max(to[axis])),
        }),
        Eye::Box(block) => Some(*block),
        Eye::Colour(at, _) => Some(Block { low: *at, high: *at }),
        Eye::Switch(..) => None,
    }
}
