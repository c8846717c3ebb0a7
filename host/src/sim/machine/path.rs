//! Interpolated moves: G0 and G1.

use firmware::motion::path::{Block, Feed, Manner};
use lang::axis::Axis;
use lang::effect::{Coord, Rate};
use lang::fault::Fault;
use lang::place::Place;

use super::Machine;
use super::pieces::Joined;
use crate::course::LineEnds;
use crate::sim::record::{Segment, SegmentKind};
use crate::sim::trace::{MoveKind, What};

impl Machine {
    /// Waits for the path's end.
    pub(super) fn sync_path(&mut self) {
        if self.motion.is_path_idle() {
            return;
        }
        self.clock.look_anew();
        while !self.is_halted() && !self.motion.is_path_idle() && self.tick(None) {}
    }

    /// The commanded places with the words applied, and within the travel. Z is the first to fail, as
    /// on the boards, which take their operands from a stack.
    fn goal(&self, words: &[Option<Coord>; 3]) -> Result<[Place; 3], Fault> {
        let mut goal = Axis::ALL.map(|axis| self.axes.place(axis));
        for axis in Axis::ALL.into_iter().rev() {
            if let Some(word) = words[axis.index()] {
                goal[axis.index()] = self.axes.aim(axis, word, goal[axis.index()])?;
            }
        }
        Ok(goal)
    }

    /// A move that joins no path waits until all axes rest.
    fn before_path(&mut self, joins: bool) -> Result<(), Fault> {
        if joins && !self.motion.is_path_idle() {
            return Ok(());
        }
        self.sync_path();
        if Axis::ALL.into_iter().any(|axis| self.axes.is_running(axis)) {
            return Err(Fault::ValueRange);
        }
        self.rest_all();
        Ok(())
    }

    /// Speed of G1: F, or what the profile has in its place.
    ///
    /// # Errors
    /// F08 without either.
    pub(super) fn programmed_feed(&self) -> Result<Feed, Fault> {
        match self.modal.feed {
            Some(Rate::Um(um)) => Ok(Feed::Um(um.unsigned_abs())),
            Some(Rate::Steps(steps)) => Ok(Feed::Steps(steps.unsigned_abs())),
            None => match self.profile.default_feed_um_s {
                Some(um) => Ok(Feed::Um(um.unsigned_abs())),
                None => Err(Fault::SpeedRange),
            },
        }
    }

    /// Power of the laser in what moves next, if the machine has one.
    pub(super) fn light(&self) -> Option<i32> {
        let laser = self.profile.laser()?;
        Some(if self.outputs.read(laser) == Ok(true) { self.modal.power } else { 0 })
    }

    /// G0 and G1.
    pub(super) fn linear(
        &mut self,
        rapid: bool,
        words: &[Option<Coord>; 3],
        exact: bool,
    ) -> Result<(), Fault> {
        self.before_path(!rapid)?;
        // As on the board, a block begins when the path has room for it.
        self.await_room();
        if self.is_halted() {
            return Ok(());
        }
        let goal = self.goal(words)?;
        let feed = if rapid { Feed::Rapid } else { self.programmed_feed()? };
        let kind = if rapid { MoveKind::Rapid } else { MoveKind::Line };
        let before = Axis::ALL.map(|axis| self.axes.place(axis));
        self.command(&goal);
        if before.map(|place| place.steps) == goal.map(|place| place.steps) {
            return Ok(());
        }
        let targets = self.targets();
        let joined = Joined { from: before, what: Vec::new() };
        let mut joined = self.pieces.joined.take().unwrap_or(joined);
        joined.what.push(What::Move { line: self.line, kind, to: targets });
        let end2 = if exact || rapid { Some(0.0) } else { self.next_end() };
        let Some(end2) = end2 else {
            self.pieces.joined = Some(joined);
            return Ok(());
        };
        let Joined { from: before, mut what } = joined;
        let [from, to] = [before, goal].map(|places| places.map(|place| place.steps));
        let exact = exact || rapid || end2 == 0.0;
        let mut legs = vec![to];
        let (up, down) = (self.z_leg(from, to, rapid), self.z_leg(to, from, rapid));
        if up {
            legs.insert(0, [from[0], from[1], to[2]]);
        } else if down {
            legs.insert(0, [to[0], to[1], from[2]]);
        }
        let mut at = from;
        for leg in legs {
            self.push_block(std::mem::take(&mut what), kind, [at, leg], (feed, exact, end2));
            at = leg;
        }
        if exact {
            self.sync_path();
        }
        Ok(())
    }

    /// Whether a rapid lifts Z first on its way between the two (profile's `rapid_z_apart`).
    fn z_leg(&self, from: [i32; 3], to: [i32; 3], rapid: bool) -> bool {
        let Some(z) = self.profile.z.as_ref() else { return false };
        let up = i64::from(z.home.direction.sign());
        rapid
            && self.profile.rapid_z_apart
            && (from[0], from[1]) != (to[0], to[1])
            && (i64::from(to[2]) - i64::from(from[2])) * up > 0
    }

    /// Lines end as slow points say, one after the other.
    pub fn set_ends(&mut self, ends: Option<LineEnds>) {
        self.pieces.ends = ends;
    }

    /// The square of the speed at which the next line may end by slow points, 0 where it rests; nothing of one that is
    /// joined to the next.
    fn next_end(&mut self) -> Option<f64> {
        self.pieces.ends.as_mut().map_or(Some(0.0), LineEnds::take_next)
    }

    fn command(&mut self, goal: &[Place; 3]) {
        for axis in Axis::ALL {
            if self.axes.is_present(axis) {
                self.axes.command(axis, goal[axis.index()]);
            }
        }
    }

    /// Gives the path a line as soon as it takes one; `what` is written when it begins.
    fn push_block(
        &mut self,
        what: Vec<What>,
        kind: MoveKind,
        [from, to]: [[i32; 3]; 2],
        (feed, exact, end2): (Feed, bool, f64),
    ) {
        self.await_room();
        if self.is_halted() || from == to {
            return;
        }
        let steps = [0, 1, 2].map(|index: usize| to[index].wrapping_sub(from[index]));
        // A rapid move is dark.
        let dark = feed == Feed::Rapid;
        let light = self.light().map(|power| if dark { 0 } else { power });
        let segment = Segment {
            kind: SegmentKind::Move(kind),
            line: self.line,
            from,
            to,
            axes: steps.map(|steps| steps != 0),
            arc: None,
            start_us: self.clock.now(),
            end_us: self.clock.now(),
            peak_rate: 0.0,
            exit_speed: None,
            power: light,
        };
        self.pieces.blocks.push_back((what, segment));
        let power = if dark { 0 } else { self.modal.beam() };
        let manner = Manner { power, ..Manner::new(feed, exact) };
        // The chip knows whole steps alone.
        self.motion.push(&Block { steps, um: [0; 3], manner }, end2, self.clock.now());
        self.log_milestones();
        self.clock.look_anew();
    }

    fn await_room(&mut self) {
        self.clock.look_anew();
        while !self.is_halted() && !self.motion.has_room() && self.tick(None) {}
    }
}
