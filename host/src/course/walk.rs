//! The lines of a program's run, in their order.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt;
use std::hash::{DefaultHasher, Hash, Hasher};

use lang::axis::Axis;
use lang::back::{Compiled, Sidecar};
use lang::effect::{Coord, Dist, Effect, Frame, Rate};
use lang::hir::Program;
use lang::image::{Header, Image};
use lang::place::Place;
use lang::profile::Profile;
use lang::record::MachineRecord;
use lang::vm::{Exit, State, Vm};

use super::costs;
use crate::interrupt;
use crate::track::Track;

/// Instructions between two effects: a program that computes longer than that is not followed.
const MOST_INSTRUCTIONS: u32 = 2_000_000;
/// Lines of a course without an end that are looked at.
const FIRST_LINES: usize = 500;
/// Effects of a run: the courses of a longer one are not all known.
const MOST_EFFECTS: u32 = 500_000;

/// A line that has steps to make; behind [`join`](super::join) what the chip makes of several.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Line {
    /// Address of its instruction, or of that of the first.
    pub pc: usize,
    /// Bits of the axes that it names, all in um: 0 where one is named in steps.
    pub named: u8,
    /// Lines that are joined to it: the targets in front of its own.
    pub joined: u8,
    /// Distance of each axis, steps.
    pub steps: [i32; 3],
    /// The same as it was commanded, um.
    pub um: [i32; 3],
    /// Its speed, um/s.
    pub feed: u32,
    /// What the program takes from the line before to this one, beside what every line takes, us.
    pub thought_us: u32,
}

/// The lines of a run that may be passed at speed, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Walked {
    /// Each different course once.
    pub courses: Vec<Vec<Line>>,
    /// What was executed.
    pub order: Vec<Piece>,
    /// From here on that repeats itself without end.
    pub repeats: Option<usize>,
    /// Addresses of lines that are made alone, too, or without a step: slow points in front of them would be those of
    /// the lines that follow.
    pub barred: BTreeSet<usize>,
    /// The first reason for which another run may be another one.
    pub obstacle: Option<Obstacle>,
}

/// What keeps the lines of a run from being known before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Obstacle {
    /// KEEP values are those of the run before.
    Keep,
    /// An operator may give AT variables any value.
    At,
    /// The statement of this line asks the machine.
    Asks(u32),
    /// It neither ends nor repeats itself as long as it is looked at.
    Long,
    /// The path that begins with this line is not the same each time, or the line is also made alone or without a step.
    Differs(u32),
}

impl fmt::Display for Obstacle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Obstacle::Keep => write!(f, "KEEP values are those of the run before"),
            Obstacle::At => write!(f, "a panel may give its AT variables any value"),
            Obstacle::Asks(line) => write!(f, "line {line} asks the machine"),
            Obstacle::Differs(line) => {
                write!(f, "the path that begins in line {line} is not the same each time")
            }
            Obstacle::Long => {
                write!(
                    f,
                    "the program neither ends nor repeats itself, as with a variable that counts on"
                )
            }
        }
    }
}

/// G1 that have steps to make.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Piece {
    /// One that rests at its end.
    Alone,
    /// A course, by its index.
    Course(usize),
}

/// Follows a run to its end, or to where it begins to repeat itself; what the machine would answer is taken for 0.
/// `None` for a damaged image.
pub fn walk(program: &Program, compiled: &Compiled) -> Option<Walked> {
    let image = Image::new(&compiled.image).ok()?;
    let obstacle = match image.header {
        Header { keeps: 1.., .. } => Some(Obstacle::Keep),
        Header { keep_base: 1.., .. } => Some(Obstacle::At),
        _ => None,
    };
    let mut profile = program.profile.clone();
    // Whether axes are homed before the run is not known here, so no statement fails for it.
    profile.require_homing = false;
    let mut walk = Walk {
        image,
        track: Track::new(&profile, [0; 3], 0),
        machine: MachineRecord::of(&profile),
        profile,
        state: State::new(&image.header),
        pool: vec![0; image.header.pool_bytes()],
        known: [false; 3],
        zero_known: [true; 3],
        unbound: [false; 3],
        lines: Vec::new(),
        thought_us: 0,
        found: BTreeMap::new(),
        walked: Walked { obstacle, ..Walked::default() },
        seen: HashMap::new(),
    };
    if let Err(obstacle) = walk.run(&compiled.sidecar) {
        // Enough to see whether it would have slow points.
        walk.lines.truncate(FIRST_LINES);
        walk.close();
        walk.walked.obstacle.get_or_insert(obstacle);
    }
    Some(walk.walked)
}

struct Walk<'a> {
    image: Image<'a>,
    profile: Profile,
    machine: MachineRecord,
    track: Track,
    state: State,
    pool: Vec<u8>,
    /// Where the axis is commanded to is known: at a start it may stand anywhere.
    known: [bool; 3],
    /// So is its work zero.
    zero_known: [bool; 3],
    /// It has gone beyond its travel, so it is not homed.
    unbound: [bool; 3],
    /// Those of the course that is open.
    lines: Vec<Line>,
    /// See [`Line::thought_us`].
    thought_us: u32,
    /// Courses by their lines.
    found: BTreeMap<Vec<Line>, usize>,
    walked: Walked,
    /// States between courses, and what was executed before them.
    seen: HashMap<u64, usize>,
}

impl Walk<'_> {
    /// # Errors
    /// The run is too long to be followed.
    fn run(&mut self, places: &Sidecar) -> Result<(), Obstacle> {
        let (mut instructions, mut effects) = (0, 0);
        loop {
            let code = self.image.code.get(self.state.pc).copied().unwrap_or_default();
            self.thought_us = self.thought_us.saturating_add(costs::code_us(code));
            instructions += 1;
            // A user who wants an end gets no run that would need it.
            if instructions > MOST_INSTRUCTIONS || effects > MOST_EFFECTS || interrupt::asked() {
                return Err(Obstacle::Long);
            }
            let mut vm = Vm::new(self.image, &mut self.state, &mut self.pool);
            match vm.step() {
                None | Some(Exit::Budget | Exit::Course(_)) => {}
                Some(Exit::Effect) => {
                    (instructions, effects) = (0, effects + 1);
                    let Some(effect) = vm.effect() else { return Ok(()) };
                    if matches!(effect, Effect::Read(_) | Effect::MoveSpeed { .. }) {
                        let line = places.at(self.state.pc).map_or(1, |mark| mark.line);
                        self.walked.obstacle.get_or_insert(Obstacle::Asks(line));
                    }
                    match self.effect(&effect) {
                        Next::On => {
                            Vm::new(self.image, &mut self.state, &mut self.pool).complete(0)
                        }
                        Next::Ends => return Ok(()),
                    }
                }
                // Handlers are not of a part that takes slow points.
                Some(Exit::HandlerEnd | Exit::Fault(_) | Exit::End) => {
                    self.close();
                    return Ok(());
                }
            }
        }
    }

    fn effect(&mut self, effect: &Effect) -> Next {
        let before = Axis::ALL.map(|axis| self.track.place(axis));
        if self.track.follow(effect).is_err() {
            self.close();
            return Next::Ends;
        }
        let leaves = self.leaves_travel(&before);
        match effect {
            Effect::Linear { rapid: false, to, exact: false } => {
                let joins = self.learn(to);
                let after = Axis::ALL.map(|axis| self.track.place(axis));
                let steps = [0, 1, 2].map(|n: usize| after[n].steps.wrapping_sub(before[n].steps));
                if steps == [0; 3] {
                    // It takes its time all the same: the line before must rest.
                    self.walked.barred.insert(self.state.pc);
                    self.close();
                    return Next::On;
                }
                let um = [0, 1, 2].map(|n: usize| after[n].um.wrapping_sub(before[n].um));
                match self.feed() {
                    Some(Rate::Um(feed)) if joins && !leaves => {
                        let thought_us = std::mem::take(&mut self.thought_us);
                        let (pc, feed) = (self.state.pc, feed.unsigned_abs());
                        let named = named_in_um(to);
                        self.lines.push(Line { pc, named, joined: 0, steps, um, feed, thought_us });
                        return Next::On;
                    }
                    _ => {}
                }
                self.close();
                self.alone(self.state.pc);
                self.end_of_course()
            }
            // It neither looks at the machine nor moves it.
            Effect::SetFeed(_) => {
                self.thought_us = self.thought_us.saturating_add(costs::FEED_US);
                Next::On
            }
            Effect::Linear { to, .. } | Effect::Arc { to, .. } => {
                self.learn(to);
                self.end_of_course()
            }
            Effect::MoveAxe { axis, to, .. } => {
                let mut words = [None; 3];
                words[axis.index()] = Some(*to);
                self.learn(&words);
                self.end_of_course()
            }
            // A switch that was not found leaves the axis anywhere.
            Effect::Home { axis, query: true } => {
                self.unbound[axis.index()] = false;
                self.known[axis.index()] = false;
                self.zero_known[axis.index()] = false;
                self.end_of_course()
            }
            Effect::Home { axis, query: false } => {
                self.unbound[axis.index()] = false;
                self.known[axis.index()] = true;
                self.zero_known[axis.index()] = true;
                self.end_of_course()
            }
            Effect::Probe { axis, .. } => {
                self.known[axis.index()] = false;
                self.end_of_course()
            }
            // A machine that wants its axes homed would refuse the next place of one.
            Effect::Motors { on: false, axis } => {
                for n in Axis::ALL.into_iter().filter(|own| axis.is_none_or(|axis| axis == *own)) {
                    self.known[n.index()] = false;
                }
                self.end_of_course()
            }
            Effect::SetPos { axis, .. } => {
                self.zero_known[axis.index()] = self.known[axis.index()];
                self.end_of_course()
            }
            _ => self.end_of_course(),
        }
    }

    /// Whether an axis goes beyond its travel for the first time: were it homed, the run would stop there, and so the
    /// line before rests.
    fn leaves_travel(&mut self, before: &[Place; 3]) -> bool {
        let mut leaves = false;
        for axis in Axis::ALL {
            let own = &self.machine.axes[axis.index()];
            let place = self.track.place(axis);
            let goes = place.steps != before[axis.index()].steps;
            if goes && !(own.min..=own.max).contains(&place.um) {
                leaves |= !std::mem::replace(&mut self.unbound[axis.index()], true);
            }
        }
        leaves
    }

    /// What the words of a move say of where the axes are; whether they were known before, so that their way is.
    fn learn(&mut self, words: &[Option<Coord>; 3]) -> bool {
        let mut all = true;
        for (n, word) in words.iter().enumerate() {
            let Some(word) = word else { continue };
            all &= self.known[n];
            match word.frame {
                Frame::Machine => self.known[n] = true,
                Frame::Work => self.known[n] = self.zero_known[n],
                Frame::Relative => {}
            }
        }
        all
    }

    /// F, or what the profile has in its place.
    fn feed(&self) -> Option<Rate> {
        self.track.feed().or_else(|| self.profile.default_feed_um_s.map(Rate::Um))
    }

    /// A course ends, if one was open; the run does when it has been in this state before.
    fn end_of_course(&mut self) -> Next {
        self.close();
        let mut hasher = DefaultHasher::new();
        (self.state.pc, self.state.sp, self.state.calls, &self.pool).hash(&mut hasher);
        (self.known, self.zero_known, self.unbound, format!("{:?}", self.feed())).hash(&mut hasher);
        for axis in Axis::ALL {
            let place = self.track.place(axis);
            (place.um, place.steps, self.track.zero(axis).ok()).hash(&mut hasher);
        }
        let here = self.walked.order.len();
        match self.seen.insert(hasher.finish(), here) {
            None => Next::On,
            Some(before) => {
                self.walked.repeats = (before < here).then_some(before);
                Next::Ends
            }
        }
    }

    fn close(&mut self) {
        let lines = std::mem::take(&mut self.lines);
        match &lines[..] {
            [] => {}
            [line] => self.alone(line.pc),
            _ => {
                let Walked { courses, .. } = &mut self.walked;
                let index = *self.found.entry(lines).or_insert_with_key(|lines| {
                    courses.push(lines.clone());
                    courses.len() - 1
                });
                self.walked.order.push(Piece::Course(index));
            }
        }
    }

    fn alone(&mut self, pc: usize) {
        self.walked.barred.insert(pc);
        self.walked.order.push(Piece::Alone);
    }
}

/// Bits of the axes that a line names in um; 0 where it names one in steps.
fn named_in_um(words: &[Option<Coord>; 3]) -> u8 {
    let mut named = 0;
    for (n, word) in words.iter().enumerate() {
        match word.map(|word| word.value) {
            Some(Dist::Um(_)) => named |= 1 << n,
            Some(Dist::Steps(_)) => return 0,
            None => {}
        }
    }
    named
}

/// What comes behind an effect.
enum Next {
    On,
    Ends,
}
