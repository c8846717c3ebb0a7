//! A streamed job's path, followed some way ahead of what goes to the board.
//!
//! The program runs a second time, in front of the writer of pieces, until it asks the board for something.
//! What is not seen yet counts as a rest, so every bound only rises as more is seen. What has not arrived
//! on the board does not count there (the pieces' own first slow points), whatever is promised here.

use std::collections::VecDeque;

use firmware::motion::path::{FED, Geometry};
use firmware::motion::scaled::Scaled;
use lang::effect::Effect;
use lang::profile::Profile;

use super::points::{self, Leg, Rule, bound, real};
use super::tour::{Stop, Tour};
use crate::stream::feed::{Feed, Step};
use crate::stream::piece::answers;

/// Blocks that are seen ahead at most.
const BLOCKS: usize = 256;
/// Effects that are followed ahead at most: between two blocks there may be many that are none.
const EFFECTS: usize = 4 * BLOCKS;

/// An effect that the writer has not come to yet.
#[derive(Debug)]
struct Entry {
    block: Option<(Geometry, [i16; 3])>,
    rests: bool,
}

/// See the module.
#[derive(Debug)]
pub struct Ahead<'a> {
    feed: Feed<'a>,
    tour: Tour,
    entries: VecDeque<Entry>,
    /// Blocks among them.
    blocks: usize,
    /// The program cannot be followed before the board has answered, or at all.
    stuck: bool,
    /// The legs of the path that the next block begins or goes on with.
    legs: VecDeque<Leg>,
    /// They reach to the path's end.
    whole: bool,
    /// What the board's planner may have at this place by what was said.
    rest: Scaled,
}

impl<'a> Ahead<'a> {
    /// From the beginning of a job.
    pub fn new(feed: Feed<'a>, profile: &Profile) -> Ahead<'a> {
        Ahead {
            feed,
            tour: Tour::new(profile),
            entries: VecDeque::new(),
            blocks: 0,
            stuck: false,
            legs: VecDeque::new(),
            whole: false,
            rest: Scaled::ZERO,
        }
    }

    /// The board has answered: the program goes on here.
    pub fn resume(&mut self, feed: Feed<'a>) {
        self.feed = feed;
        self.stuck = false;
    }

    /// What belongs before this effect, which the writer has come to.
    pub fn slow(&mut self, effect: &Effect) -> Option<[u8; 3]> {
        self.fill();
        self.entries.front()?.block.as_ref()?;
        if !matches!(effect, Effect::Linear { .. } | Effect::Arc { .. }) {
            return None;
        }
        if self.legs.is_empty() || !self.whole && self.legs.len() < BLOCKS / 2 {
            self.plan();
        }
        points::before(&self.legs, self.rest)
    }

    /// It was written.
    pub fn said(&mut self, operand: [u8; 3]) {
        self.rest = self.rest.most(bound(operand));
    }

    /// The effect was written; gives what its block brakes by, (um/s)^2.
    pub fn passed(&mut self) -> f64 {
        self.fill();
        let Some(entry) = self.entries.pop_front() else { return 0.0 };
        let mut energy = 0.0;
        if entry.block.is_some() {
            self.blocks -= 1;
            if let Some(leg) = self.legs.pop_front() {
                energy = real(leg.energy);
                self.rest = self.rest.minus(leg.energy);
            }
        }
        if entry.rests {
            self.rest = Scaled::ZERO;
            self.legs.clear();
        }
        energy
    }

    /// Follows the program as far as it is to be seen, at least to its next effect.
    fn fill(&mut self) {
        while !self.stuck
            && (self.entries.is_empty() || self.blocks < BLOCKS && self.entries.len() < EFFECTS)
        {
            match self.feed.step() {
                Step::Effect(effect, _) => {
                    let value = self.tour.effect(&effect);
                    self.stuck = value.is_none() || answers(&effect);
                    let mut entry = Entry { block: None, rests: self.stuck };
                    for stop in self.tour.take_stops() {
                        match stop {
                            Stop::Block(geometry, unit) => entry.block = Some((geometry, unit)),
                            Stop::Rest => entry.rests = true,
                            Stop::Statement(_) => {}
                        }
                    }
                    self.blocks += usize::from(entry.block.is_some());
                    self.entries.push_back(entry);
                    self.feed.complete(value.unwrap_or(0));
                }
                // The writer thinks as long when it comes there.
                Step::Thinks if self.entries.is_empty() => {}
                Step::Thinks => break,
                _ => self.stuck = true,
            }
        }
    }

    /// Plans the legs anew, with all that is seen.
    fn plan(&mut self) {
        let mut path = Vec::new();
        self.whole = false;
        for entry in &self.entries {
            path.extend(entry.block.map(|(geometry, unit)| (geometry, unit, Vec::new())));
            if entry.rests {
                self.whole = true;
                break;
            }
        }
        let mut legs = Vec::new();
        let rule = Rule { corner: self.tour.corner(), planning: FED };
        points::plan(&mut path, rule, &mut legs);
        self.legs = legs.into();
    }
}
