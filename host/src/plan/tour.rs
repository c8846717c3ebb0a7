//! A program's path, block by block, followed on the host.

use std::collections::{HashMap, HashSet};
use std::hash::{DefaultHasher, Hash, Hasher};

use firmware::motion::path::{Block, Feed as Speed, Geometry};
use lang::axis::Axis;
use lang::back::Compiled;
use lang::effect::{Effect, Frame, Rate, Read};
use lang::hir::Program;
use lang::place::Place;
use lang::profile::Profile;
use lang::record::MachineRecord;

use crate::sim::machine::path::arc_between;
use crate::stream::feed::{Feed, Step};
use crate::stream::place::Track;

/// What the program has come through.
#[derive(Clone, Copy, Debug)]
pub enum Stop {
    /// The beginning of a statement, by its number ([`lang::back::Sidecar::statements`]).
    Statement(usize),
    /// A block that joins its neighbours: its shape, and its direction at its end.
    Block(Geometry, [i16; 3]),
    /// The path comes to rest here.
    Rest,
}

/// Effects that are followed at most, in some seconds; a longer program gets no slow points.
pub const MOST_EFFECTS: usize = 1_000_000;
/// Slices of [`crate::stream::feed::BUDGET`] instructions without an effect at most.
const MOST_THOUGHT: usize = 5_000;

/// What is known of the axes while a path is followed.
#[derive(Debug)]
pub struct Tour {
    record: MachineRecord,
    track: Track,
    /// The axis's commanded place is the one on the board.
    known: [bool; 3],
    /// Its work zero lies at a place that is not known, so nothing is before the next Home.
    lost: [bool; 3],
    stops: Vec<Stop>,
}

/// The program's blocks and rests in the order in which they are executed; of a program without an end
/// up to where it does what it did before. `None` when that hangs on the outside or takes too long.
pub fn follow(program: &Program, compiled: &Compiled) -> Option<Vec<Stop>> {
    let mut feed = Feed::new(compiled).ok()?;
    let mut tour = Tour::new(&program.profile);
    let statements = compiled.sidecar.statements.iter().enumerate();
    // Of statements without code the last one has what follows.
    let numbers: HashMap<usize, usize> = statements.map(|(number, pc)| (*pc, number)).collect();
    let mut starts = vec![false; feed.image().code.len()];
    for pc in numbers.keys() {
        starts[*pc] = true;
    }
    let mut passed = Vec::new();
    let mut seen = HashSet::new();
    let mut thought = 0;
    for _ in 0..MOST_EFFECTS {
        let step = feed.step_through(&starts, &mut passed);
        let begun = passed.drain(..).filter_map(|pc| numbers.get(&pc));
        tour.stops.extend(begun.map(|number| Stop::Statement(*number)));
        match step {
            Step::Effect(effect, _) => {
                thought = 0;
                let value = tour.effect(&effect)?;
                feed.complete(value);
                let rests = matches!(tour.stops.last(), Some(Stop::Rest));
                if rests && !seen.insert(tour.state(&feed)) {
                    return Some(tour.stops);
                }
            }
            Step::Thinks => {
                thought += 1;
                if thought > MOST_THOUGHT {
                    return None;
                }
            }
            Step::Guard(..) | Step::Left(..) => return None,
            Step::End | Step::Fault(..) => {
                tour.stops.push(Stop::Rest);
                return Some(tour.stops);
            }
        }
    }
    None
}

impl Tour {
    /// Nothing is known of where the axes of a machine stand.
    pub fn new(profile: &Profile) -> Tour {
        Tour {
            record: MachineRecord::of(profile),
            track: Track::new(profile, [0; 3], 0),
            known: [false; 3],
            lost: [false; 3],
            stops: Vec::new(),
        }
    }

    /// What has been come through since the last call.
    pub fn take_stops(&mut self) -> Vec<Stop> {
        std::mem::take(&mut self.stops)
    }

    /// Deviation that a corner may have, um.
    pub fn corner(&self) -> u16 {
        self.record.corner
    }

    /// Everything that what comes hangs on, as a number.
    fn state(&self, feed: &Feed<'_>) -> u64 {
        let mut hasher = DefaultHasher::new();
        feed.hash_state(&mut hasher);
        for axis in Axis::ALL {
            let place = self.track.axes().place(axis);
            (place.um, place.steps, self.track.axes().work_at(axis, place.steps).ok())
                .hash(&mut hasher);
        }
        let feed = self.track.feed().map(|rate| match rate {
            Rate::Um(um) => (true, um),
            Rate::Steps(steps) => (false, steps),
        });
        (feed, self.known, self.lost).hash(&mut hasher);
        hasher.finish()
    }

    /// Follows an effect; gives its value, `None` where the program hangs on the outside from here on.
    pub fn effect(&mut self, effect: &Effect) -> Option<i32> {
        let mut value = 0;
        match *effect {
            Effect::SetFeed(_) | Effect::SetSpindle(_) | Effect::Slow(_) => {
                return self.follow(effect).map(|()| 0);
            }
            Effect::Linear { .. } | Effect::Arc { .. } => return self.block(effect).map(|()| 0),
            Effect::Read(Read::Pos(axis)) if self.known[axis.index()] => {
                let axes = self.track.axes();
                value = axes.work_at(axis, axes.steps(axis)).ok()?;
            }
            Effect::Read(Read::PosSteps(axis)) if self.known[axis.index()] => {
                value = self.track.axes().steps(axis);
            }
            Effect::Read(_) => return None,
            _ => self.at_rest(effect)?,
        }
        self.stops.push(Stop::Rest);
        Some(value)
    }

    /// G0 to G3: a block whose shape is known, or a rest.
    fn block(&mut self, effect: &Effect) -> Option<()> {
        let (Effect::Linear { to, exact, .. } | Effect::Arc { to, exact, .. }) = *effect else {
            return None;
        };
        let rapid = matches!(effect, Effect::Linear { rapid: true, .. });
        let (before, was) = (self.track.places(), self.known);
        let feed = self.speed();
        self.follow(effect)?;
        for (axis, word) in to.iter().enumerate() {
            let absolute = word.is_some_and(|word| word.frame != Frame::Relative);
            self.known[axis] |= absolute && !self.lost[axis];
        }
        let after = self.track.places();
        let sure = (0..3).all(|axis| to[axis].is_none() || was[axis] && self.known[axis]);
        let feed = feed.filter(|_| !rapid && sure && self.is_inside(&after));
        let shape = match *effect {
            Effect::Arc { clockwise, plane, ref center, .. } => {
                let axes = self.track.axes();
                let arc = arc_between(axes, (clockwise, plane), [&before, &after], center).ok();
                let arc = arc.filter(|_| was == [true; 3]);
                feed.zip(arc).map(|(feed, arc)| Geometry::arc(&self.record.axes, &arc, feed))
            }
            _ => match distance(&before, &after, |place| place.steps) {
                [0, 0, 0] if !rapid => return Some(()),
                steps => feed.map(|feed| {
                    let um = distance(&before, &after, |place| place.um);
                    Geometry::line(&self.record.axes, &Block { steps, um, feed, exact })
                }),
            },
        };
        let rests = exact || shape.is_none();
        self.stops.extend(shape.map(|(geometry, unit)| Stop::Block(geometry, unit)));
        self.stops.extend(rests.then_some(Stop::Rest));
        Some(())
    }

    /// An effect that waits for the path's end.
    fn at_rest(&mut self, effect: &Effect) -> Option<()> {
        self.follow(effect)?;
        match *effect {
            Effect::Home { axis, query } => {
                self.known[axis.index()] = !query;
                self.lost[axis.index()] = query;
            }
            Effect::SetPos { axis, .. } if !self.known[axis.index()] => {
                self.lost[axis.index()] = true;
            }
            Effect::MoveAxe { axis, to, .. } => {
                let absolute = to.frame != Frame::Relative;
                self.known[axis.index()] |= absolute && !self.lost[axis.index()];
            }
            Effect::Probe { axis, .. } | Effect::MoveSpeed { axis, .. } | Effect::StopAxe(axis) => {
                self.known[axis.index()] = false
            }
            Effect::StopAll => self.known = [false; 3],
            _ => {}
        }
        Some(())
    }

    /// A statement that the machine will refuse ends the run there: what was followed is all.
    fn follow(&mut self, effect: &Effect) -> Option<()> {
        self.track.follow(effect).ok()
    }

    fn speed(&self) -> Option<Speed> {
        Some(match self.track.feed()? {
            Rate::Um(um) => Speed::Um(um.unsigned_abs()),
            Rate::Steps(steps) => Speed::Steps(steps.unsigned_abs()),
        })
    }

    /// Whether places lie within the travel: an axis may have been homed before the run.
    fn is_inside(&self, places: &[Place; 3]) -> bool {
        (0..3).all(|axis| {
            let record = &self.record.axes[axis];
            let absent = record.flags & lang::record::AxisRecord::PRESENT == 0;
            absent || (record.min..=record.max).contains(&places[axis].um)
        })
    }
}

fn distance(before: &[Place; 3], after: &[Place; 3], of: fn(&Place) -> i32) -> [i32; 3] {
    [0, 1, 2].map(|axis: usize| of(&after[axis]).wrapping_sub(of(&before[axis])))
}
