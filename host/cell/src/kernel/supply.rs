//! Feeders that advance, and what people take away and put back.

use super::{Action, Cell, Timer};
use crate::law::Steps;
use crate::log::What;
use crate::scene::{V3, When};
use crate::things::{self, Where};

impl Cell {
    /// Feeders at the begin of a run: their inputs say whether a part is ready.
    pub(super) fn begin_feeders(&mut self) {
        self.fed = self.scene.feeders.iter().map(|_| 1).collect();
        for index in 0..self.scene.feeders.len() {
            if let Some(input) = self.scene.feeders[index].input
                && self.ready(index).is_some()
            {
                self.actions.push(Action::Input(input, true));
            }
        }
    }

    /// Whether a feeder brings one part after the other to one place.
    fn advances(&self, index: usize) -> bool {
        self.scene.feeders[index].advances()
    }

    /// The thing that stands where a feeder has it taken.
    fn ready(&self, index: usize) -> Option<usize> {
        self.things.iter().position(|thing| {
            thing.feeder.is_some_and(|(own, _)| own == index)
                && matches!(thing.place, Where::Stands(_))
                && thing.place == thing.home
        })
    }

    /// An output that may advance feeders goes on.
    pub(super) fn advance_feeders(&mut self, output: u32, us: u64) {
        for index in 0..self.scene.feeders.len() {
            let feeder = &self.scene.feeders[index];
            if feeder.output == Some(output) && self.advances(index) {
                self.timers.push((us + feeder.advance_us, Timer::Feed(index)));
            }
        }
    }

    /// A thing was taken: its feeder is not ready, and one without an output sends the next by itself.
    pub(super) fn left_feeder(&mut self, which: usize, us: u64) {
        let Some((index, _)) = self.things[which].feeder.filter(|(own, _)| self.advances(*own))
        else {
            return;
        };
        let feeder = &self.scene.feeders[index];
        if self.ready(index).is_none()
            && let Some(input) = feeder.input
        {
            self.actions.push(Action::Input(input, false));
        }
        if feeder.output.is_none() {
            self.timers.push((us + feeder.advance_us, Timer::Feed(index)));
        }
    }

    /// The next part comes. A tape carries the one that nobody took on with it; a tube and a bowl wait.
    pub(super) fn feed(&mut self, index: usize, at: &Steps, us: u64) {
        let scene = self.scene.clone();
        let feeder = &scene.feeders[index];
        if let Some(which) = self.ready(index) {
            if feeder.kind != "tape" {
                return;
            }
            self.things[which].place = Where::Gone;
            let thing = self.things[which].name.clone();
            self.tell(us, What::Lost { thing, why: "its tape was advanced before it was taken" });
        }
        let more = feeder.length.is_none_or(|length| self.fed[index] < length);
        if more && self.things.len() < things::MOST {
            self.fed[index] += 1;
            let number = self.fed[index];
            let Some(&(mut place, turn)) = feeder.pockets.first() else { return };
            let mut form = scene.parts[feeder.part].form;
            form.turn_deg += turn;
            if feeder.kind == "bowl" {
                let [x, y, deg] = scattered(number);
                place[0] += x * feeder.spread[0];
                place[1] += y * feeder.spread[0];
                form.turn_deg += deg * feeder.spread[1];
            }
            let name = format!("{}.{number}", feeder.name);
            let pocket = number as usize - 1;
            let place = Where::Stands(place);
            self.things.push(things::thing(name, feeder.part, Some((index, pocket)), form, place));
            self.arrives(self.things.len() - 1, us);
        }
        if let Some(input) = feeder.input {
            self.actions.push(Action::Input(input, self.ready(index).is_some()));
        }
        self.rebuild(at, us);
        self.look_again(us);
    }

    /// A person takes a thing away, or puts it where it was at the start.
    pub fn hands(&mut self, name: &str, puts: bool, at: &Steps, us: u64) {
        let Some(which) = self.things.iter().position(|thing| thing.name == name) else { return };
        if matches!(self.things[which].place, Where::Held(_)) {
            return; // nobody reaches under a tool that holds it
        }
        self.belts_until(us);
        self.things[which].place = if puts { self.things[which].home } else { Where::Gone };
        self.things[which].stored = false;
        self.plan_belts(us);
        self.rebuild(at, us);
        self.look_again(us);
    }

    /// A thing came to rest here: people who wait until the place around it is full act.
    pub(super) fn filled(&mut self, at: V3, us: u64) {
        let scene = self.scene.clone();
        for own in scene.places.iter().filter(|own| own.block.holds(at)) {
            let inside = self.things.iter().filter(|thing| match thing.place {
                Where::Stands(at) => own.block.holds(at),
                _ => false,
            });
            if (inside.count() as u32) < own.room.max(1) {
                continue;
            }
            for (index, person) in scene.persons.iter().enumerate() {
                if matches!(&person.when, When::Full(name) if *name == own.name) {
                    self.person(index, us);
                }
            }
        }
    }
}

/// Three numbers from -1 to 1 that belong to a part's number: how it lies in the bowl's outlet.
fn scattered(number: u32) -> [f64; 3] {
    let mut state = u64::from(number);
    [0, 1, 2].map(|_| {
        // splitmix64 (Steele, Lea, Flood 2014).
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = state;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (mixed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    })
}
