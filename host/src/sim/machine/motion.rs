//! The motors: plays the planner's segments in simulated time.
//!
//! The planner is the firmware's own, so ramps, corners and times are the board's. So is the order
//! in which segments are taken: the step engine holds the one that plays and the next, of a path
//! several ([`queue`]), which the board's main loop fetches one after the other. A stop, a pause or
//! a new target takes effect after them.

mod play;

use std::collections::VecDeque;

use firmware::motion::path::{Block, Path, PathSegment};
use firmware::motion::queue;
use firmware::motion::scaled::Scaled;
use firmware::motion::single::{Pace, Single};
use lang::axis::Axis;
use lang::part::Part;
use lang::record::AxisRecord;

use self::play::{Clock, FETCH_US, Play, Solo, is_fetched};

/// From a statement to the event of a path that begins at rest, us, and more for each axis that moves (`pasapas bench
/// paths`).
const PATH_BEGINS_US: [u64; 2] = [1_350, 500];

/// What began or ended while motion went on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Milestone {
    /// A block of the path begins, with this power of a laser.
    BlockBegins(u16),
    /// The path's speed at the end of a segment: events/s of its fastest axis, um/s along it.
    PathRate(f64, f64),
    /// The path has come to its end.
    PathEnds,
    /// An axis of its own runs at so many steps/s.
    AxisRate(Axis, f64),
    /// An axis of its own has come to rest.
    AxisRests(Axis),
}

/// See the module.
#[derive(Debug)]
pub struct Motion {
    records: [AxisRecord; 3],
    clock: Clock,
    path: Path,
    path_play: Option<(Play, PathSegment)>,
    /// Speed at the end of the segment that plays, um/s.
    path_exit: u32,
    /// Each with the speed at its end, um/s.
    path_queue: VecDeque<(PathSegment, u32)>,
    /// When the path may be asked for another segment though its next block is not known, us.
    fetch_us: u64,
    /// The path's last segment: the planner writes increments and directions only when a block
    /// begins.
    segment: PathSegment,
    acc: [u32; 3],
    solo: [Solo; 3],
    /// Positions at the beginning of the segments that play, steps.
    base: [i32; 3],
    /// Steps made by each axis.
    pub travelled: [u64; 3],
    /// What happened since the caller looked, with its time.
    pub milestones: Vec<(u64, Milestone)>,
}

/// A number that may be above 32 bits: the square of 108 mm/s in um/s is.
fn scaled(number: f64) -> Scaled {
    let above = (number.max(1.0).log2() as i8 - 31).max(0);
    Scaled::new((number / 2f64.powi(above.into())) as u32).shifted(above)
}

impl Motion {
    /// All axes at 0 and at rest.
    pub fn new(records: [AxisRecord; 3], corner_um: u16, part: Part) -> Motion {
        let clock = Clock { hz: part.clock };
        let single = || Single::new(0, clock.rate());
        let solo = || Solo { single: single(), play: None, negative: false, next: None };
        Motion {
            records,
            clock,
            path: Path::new(corner_um, clock.rate()),
            path_play: None,
            path_exit: 0,
            path_queue: VecDeque::new(),
            fetch_us: 0,
            segment: PathSegment::default(),
            acc: [0; 3],
            solo: [solo(), solo(), solo()],
            base: [0; 3],
            travelled: [0; 3],
            milestones: Vec::new(),
        }
    }

    /// Limits of an axis.
    pub fn record(&self, axis: Axis) -> &AxisRecord {
        &self.records[axis.index()]
    }

    /// Positions at `us`, steps.
    pub fn positions(&self, us: u64) -> [i32; 3] {
        let mut at = self.base;
        if let Some((play, segment)) = &self.path_play {
            segment.played(play.steps_at(us), &mut self.acc.clone(), &mut at);
        }
        for (at, solo) in at.iter_mut().zip(&self.solo) {
            if let Some(play) = &solo.play {
                *at = at.wrapping_add(solo.signed(play.steps_at(us)));
            }
        }
        at
    }

    /// Whether the axis moves or is about to, on its own or on a path; also while it is paused.
    pub fn is_moving(&self, axis: Axis) -> bool {
        !self.is_path_idle() || !self.is_solo_idle(axis)
    }

    /// Whether the axis is not moving on its own.
    pub fn is_solo_idle(&self, axis: Axis) -> bool {
        let solo = &self.solo[axis.index()];
        solo.is_empty() && solo.single.is_idle()
    }

    /// Whether no path is under way.
    pub fn is_path_idle(&self) -> bool {
        self.path_play.is_none() && self.path_queue.is_empty() && self.path.is_idle()
    }

    /// Whether everything rests, which in a pause includes what has come to a stand.
    pub fn stands(&self) -> bool {
        self.path_play.is_none() && self.solo.iter().all(|solo| solo.play.is_none())
    }

    /// Whether the axis turns at this moment.
    pub fn turns(&self, axis: Axis) -> bool {
        self.solo[axis.index()].play.is_some()
            || self.path_play.is_some_and(|(_, segment)| segment.inc[axis.index()] != 0)
    }

    /// Direction in which the axis turns: -1, 0 or 1.
    pub fn direction(&self, axis: Axis) -> i32 {
        let solo = &self.solo[axis.index()];
        if solo.play.is_some() {
            return if solo.negative { -1 } else { 1 };
        }
        match &self.path_play {
            Some((_, segment)) if segment.inc[axis.index()] != 0 => {
                if segment.negative >> axis.index() & 1 != 0 { -1 } else { 1 }
            }
            _ => 0,
        }
    }

    /// When the next segment ends, us.
    pub fn next_us(&self) -> Option<u64> {
        let path = self.path_play.as_ref().map(|(play, _)| play.end_us());
        let solos = self.solo.iter().filter_map(|solo| solo.play.as_ref().map(Play::end_us));
        solos.chain(path).min()
    }

    /// When the axis comes to `place` within the segment that plays, us; `None` when it does not
    /// or was there at `us` already.
    pub fn reaches(&self, axis: Axis, place: i32, us: u64) -> Option<u64> {
        let index = axis.index();
        let forward = self.direction(axis);
        if forward == 0 {
            return None;
        }
        let solo = &self.solo[index];
        let want = (i64::from(place) - i64::from(self.base[index])) * i64::from(forward);
        if want <= 0 {
            return None;
        }
        let (play, step) = if let Some(play) = &solo.play {
            (play, u16::try_from(want).ok().filter(|step| *step <= play.segment.steps())?)
        } else {
            let (play, segment) = self.path_play.as_ref()?;
            let made = |events: u16| {
                let mut at = [0; 3];
                segment.played(events, &mut self.acc.clone(), &mut at);
                i64::from(at[index]) * i64::from(forward)
            };
            let (mut low, mut high) = (1_u16, play.segment.steps());
            if made(high) < want {
                return None;
            }
            while low < high {
                let middle = low + (high - low) / 2;
                if made(middle) >= want {
                    high = middle;
                } else {
                    low = middle + 1;
                }
            }
            (play, low)
        };
        Some(play.step_us(step)).filter(|at| *at > us)
    }

    /// Ends the segments that are over at `us` and takes the next ones.
    pub fn advance(&mut self, us: u64) {
        while let Some((play, segment)) = self.path_play.filter(|(play, _)| play.end_us() <= us) {
            let before = self.base;
            segment.played(play.segment.steps(), &mut self.acc, &mut self.base);
            self.count(&before);
            self.path_play = None;
            self.milestones
                .push((play.end_us(), Milestone::PathRate(play.rate(), self.path_exit.into())));
            self.begin_path(play.begin + play.segment.duration(), false);
        }
        for axis in Axis::ALL {
            let index = axis.index();
            while let Some(play) = self.solo[index].play.filter(|play| play.end_us() <= us) {
                let made = self.solo[index].signed(play.segment.steps());
                self.base[index] = self.base[index].wrapping_add(made);
                self.travelled[index] += u64::from(made.unsigned_abs());
                self.solo[index].play = None;
                self.milestones.push((play.end_us(), Milestone::AxisRate(axis, play.rate())));
                self.begin_solo(axis, play.begin + play.segment.duration());
            }
        }
    }

    fn count(&mut self, before: &[i32; 3]) {
        for (sum, (now, before)) in self.travelled.iter_mut().zip(self.base.iter().zip(before)) {
            *sum += u64::from(now.abs_diff(*before));
        }
    }

    /// The engine begins the path's next segment; at rest in the pass in which the block came.
    fn begin_path(&mut self, begin: u64, rests: bool) {
        let at = self.clock.us(begin);
        self.fetch_path(at, !rests);
        if self.path_queue.is_empty() && self.path.next_segment(&self.records, &mut self.segment) {
            self.path_queue.push_back((self.segment, self.path.velocity()));
            self.fetch_us = at + FETCH_US;
        }
        if let Some((segment, exit)) = self.path_queue.pop_front() {
            if segment.begin && !segment.within {
                self.milestones.push((at, Milestone::BlockBegins(segment.power)));
            }
            self.path_play =
                Some((Play { begin, segment: segment.ramp, clock: self.clock }, segment));
            self.path_exit = exit;
        } else if self.path.is_idle() {
            self.milestones.push((at, Milestone::PathEnds));
        }
    }

    /// Fills the engine as far as the board has come by `us`: in many passes of its main loop, or in the one behind a
    /// block.
    fn fetch_path(&mut self, us: u64, passes: bool) {
        let mut fetches = 0;
        while self.path_queue.len() + 1 < queue::SLOTS {
            let ahead: u16 = self.path_queue.iter().map(|(own, _)| queue::time(&own.ramp)).sum();
            let unknown = !self.path.knows_next();
            if ahead >= queue::wanted(&self.path, self.clock.hz)
                || unknown && us < self.fetch_us && ahead >= queue::low(self.clock.hz)
                || !self.path.next_segment(&self.records, &mut self.segment)
            {
                return;
            }
            self.path_queue.push_back((self.segment, self.path.velocity()));
            fetches += 1;
            let ahead = ahead + queue::time(&self.segment.ramp);
            if !passes && (ahead >= queue::low(self.clock.hz) || fetches == queue::FETCHES) {
                return;
            }
            if unknown {
                self.fetch_us += FETCH_US;
            } else if !self.path.knows_next() {
                self.fetch_us = self.fetch_us.max(us) + FETCH_US;
            }
        }
    }

    /// The engine begins an axis's next segment.
    fn begin_solo(&mut self, axis: Axis, begin: u64) {
        let solo = &mut self.solo[axis.index()];
        solo.fetch();
        if let Some((segment, negative)) = solo.next.take() {
            solo.negative = negative;
            solo.play = Some(Play { begin, segment, clock: self.clock });
        } else if solo.single.is_idle() {
            let at = self.clock.us(begin);
            self.milestones.push((at, Milestone::AxisRests(axis)));
        }
    }

    /// What the board has fetched by `us`; before every order that changes what comes.
    fn fetch(&mut self, us: u64) {
        if self.path_play.is_some() {
            self.fetch_path(us, true);
        }
        for solo in &mut self.solo {
            if solo.play.is_some_and(|play| is_fetched(&play, us)) {
                solo.fetch();
            }
        }
    }

    /// Whether a further block would be taken.
    pub fn has_room(&self) -> bool {
        !self.path.knows_next()
    }

    /// Gives the path a block; see [`Motion::has_room`]. Its end may have a speed of this square, (um/s)^2, as slow points
    /// say.
    pub fn push(&mut self, block: &Block, end2: f64, us: u64) {
        let moving = block.steps.iter().filter(|steps| **steps != 0).count();
        let [base, axis] = PATH_BEGINS_US;
        let begin = us + if self.is_path_idle() { base + axis * moving as u64 } else { 0 };
        self.path.push_ending(&self.records, block, scaled(end2));
        // The main loop looks for segments before it takes the next block.
        if self.path_play.is_some() {
            self.fetch_path(us, false);
        }
        self.kick_path(begin);
    }

    /// Moves an axis on its own to `target` steps.
    pub fn go(&mut self, axis: Axis, target: i32, pace: Pace, us: u64) {
        self.fetch(us);
        self.settle(axis);
        let index = axis.index();
        self.solo[index].single.go(&self.records[index], target, pace);
        self.kick(us);
    }

    /// Runs an axis until stopped, or to `limit` steps at most.
    pub fn run(&mut self, axis: Axis, negative: bool, limit: Option<i32>, pace: Pace, us: u64) {
        self.fetch(us);
        self.settle(axis);
        let index = axis.index();
        self.solo[index].single.run(&self.records[index], negative, limit, pace);
        self.kick(us);
    }

    /// A path may have moved the axis since it last went on its own.
    fn settle(&mut self, axis: Axis) {
        let solo = &mut self.solo[axis.index()];
        if solo.single.is_idle() && solo.is_empty() {
            solo.single.halt(self.base[axis.index()]);
        }
    }

    /// Ramps an axis of its own down to rest.
    pub fn stop(&mut self, axis: Axis, us: u64) {
        self.fetch(us);
        self.solo[axis.index()].single.stop();
    }

    /// A sensor answered at `us`: the axis stands still there or stops on its ramp.
    pub fn hit(&mut self, axis: Axis, us: u64) {
        let index = axis.index();
        self.fetch(us);
        let caught = self.positions(us)[index];
        if self.solo[index].single.hit(&self.records[index], caught) {
            self.travelled[index] += u64::from(caught.abs_diff(self.base[index]));
            self.base[index] = caught;
            self.solo[index].play = None;
            self.solo[index].next = None;
            self.milestones.push((us, Milestone::AxisRests(axis)));
        }
    }

    /// Everything stands still at `us` at once.
    pub fn halt(&mut self, us: u64) {
        let before = self.base;
        self.base = self.positions(us);
        self.count(&before);
        if !self.is_path_idle() {
            self.path.clear();
            self.path_play = None;
            self.path_queue.clear();
            self.milestones.push((us, Milestone::PathEnds));
        }
        for axis in Axis::ALL {
            let index = axis.index();
            if !self.is_solo_idle(axis) {
                self.milestones.push((us, Milestone::AxisRests(axis)));
            }
            self.solo[index].play = None;
            self.solo[index].next = None;
            self.solo[index].single.halt(self.base[index]);
        }
    }

    /// The resting axis is at `steps` from now on.
    pub fn set_position(&mut self, axis: Axis, steps: i32) {
        self.base[axis.index()] = steps;
        self.solo[axis.index()].single.halt(steps);
    }

    /// Ramps everything down, or goes on with the rest.
    pub fn pause(&mut self, on: bool, us: u64) {
        self.fetch(us);
        self.path.pause(on);
        for solo in &mut self.solo {
            solo.single.pause(on);
        }
        if !on {
            self.kick(us);
        }
    }

    /// Gives up what a pause has left of every move.
    pub fn forget(&mut self, us: u64) {
        self.halt(us);
        self.path.pause(false);
        for solo in &mut self.solo {
            solo.single.pause(false);
        }
    }

    /// Begins the path that waits if none plays.
    fn kick_path(&mut self, us: u64) {
        if self.path_play.is_none() && !self.is_path_idle() {
            self.begin_path(us * self.clock.fine_per_us(), true);
        }
    }

    /// Begins what waits where nothing plays.
    fn kick(&mut self, us: u64) {
        let begin = us * self.clock.fine_per_us();
        self.kick_path(us);
        for axis in Axis::ALL {
            if self.solo[axis.index()].play.is_none() && !self.is_solo_idle(axis) {
                self.begin_solo(axis, begin);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::scaled;
    use firmware::motion::scaled::Scaled;

    #[test]
    fn squares_above_32_bits_are_no_less() {
        assert_eq!(scaled(0.0), Scaled::ZERO);
        assert_eq!(scaled(1e9), Scaled::new(1_000_000_000));
        assert_eq!(scaled(4e10), Scaled::new(200_000).times(Scaled::new(200_000)));
    }
}
