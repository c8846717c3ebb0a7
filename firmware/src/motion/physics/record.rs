//! Checks a whole record of steps: single axes, lines and arcs, one after the other.
//!
//! It does not know what was commanded. Steps of several axes at the same instants are an
//! interpolated motion, which has one event stream; all others are streams of their own. Where an
//! axis steps at every event, its rate follows the path's speed and the path's direction; the steps
//! of the other axes give bounds of the change of direction.

use lang::record::AxisRecord;

use super::{HALF_WINDOW, HZ, Limits, Violation, What, bound, check};

/// Steps that fall on one instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// Timer ticks.
    pub at: u64,
    /// What they add to each axis: -1, 0 or 1.
    pub by: [i8; 3],
}

/// What a machine can follow.
#[derive(Clone, Copy, Debug)]
pub struct Machine {
    /// Limits of each axis.
    pub axes: [Limits; 3],
    /// Micrometres of a step of each axis.
    pub um: [f64; 3],
    /// Deviation that a corner may have, um.
    pub corner_um: f64,
}

/// What was judged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// Motions from rest to rest.
    pub moves: usize,
    /// Steps of all axes.
    pub steps: usize,
}

impl std::ops::AddAssign for Count {
    fn add_assign(&mut self, other: Count) {
        self.moves += other.moves;
        self.steps += other.steps;
    }
}

/// Half windows over which a path is judged, events, and how much steeper than the limit a ramp may be
/// there: 5 % where each rate is that of 20 steps or more (firmware/README.md, Motion). Below that it is the
/// engine's straight lines between the intervals of a segment's ends that show: 7.1 % in the slowest
/// segments of the mill's ramps.
const SCALES: [(usize, f64); 4] = [
    (HALF_WINDOW, 1.08),
    (2 * HALF_WINDOW, 1.05),
    (4 * HALF_WINDOW, 1.05),
    (16 * HALF_WINDOW, 1.05),
];
/// Of the steps of the second busiest axis so many fall on another's in an interpolated motion: one
/// in so many.
const SHARED: usize = 8;
/// An axis that steps so many times slower from one step to the next has stopped between them.
const STOPS: u64 = 3;

/// Steps over which an axis is no faster than its top; where they fall on events, one of so few is much.
const TOPS: [usize; 3] = [HALF_WINDOW, 5 * HALF_WINDOW, 20 * HALF_WINDOW];

/// Half windows over which an axis may change its speed, whatever the path's direction does, no more than
/// its ramps do and a corner allows: ticks...
const BENDS: [u64; 4] = [320_000, 640_000, 1_280_000, 2_560_000];
/// ... and events at least.
const BEND_EVENTS: usize = 20;

impl Machine {
    /// What the records of a profile say.
    pub fn of(axes: &[AxisRecord; 3], corner: u16) -> Machine {
        let limits = |axis: &AxisRecord| Limits {
            start: axis.start_rate.into(),
            top: axis.top_rate.into(),
            accel: axis.accel.into(),
            decel: axis.decel.into(),
        };
        Machine {
            axes: axes.each_ref().map(limits),
            um: axes.each_ref().map(|axis| f64::from(axis.um) / f64::from(axis.steps)),
            corner_um: corner.into(),
        }
    }

    /// Checks a record; `abrupt`: it ends in a stop at once, as a limit switch or an emergency does.
    ///
    /// # Errors
    /// The first violation; its step is an index of `steps`.
    pub fn check(&self, steps: &[Step], abrupt: bool) -> Result<Count, Violation> {
        let mut count = Count::default();
        let starts = self.axes.iter().map(|axis| axis.start).filter(|start| *start > 0.0);
        let slowest = starts.fold(f64::INFINITY, f64::min);
        // Below the start rate an axis may do as it likes.
        let rest = (1.05 * HZ / slowest) as u64;
        let mut first = 0;
        while first < steps.len() {
            let gap = |w: &[Step]| w[1].at - w[0].at > rest;
            let more = steps[first..].windows(2).position(gap);
            let end = more.map_or(steps.len(), |more| first + more + 1);
            let motion = &steps[first..end];
            let found = if is_interpolated(motion) {
                self.path(motion, abrupt && end == steps.len())
            } else {
                self.own(motion, abrupt && end == steps.len())
            };
            found.map_err(|violation| Violation { step: violation.step + first, ..violation })?;
            count.moves += usize::from(motion.len() > 1);
            count.steps += motion.iter().flat_map(|step| step.by).filter(|by| *by != 0).count();
            first = end;
        }
        Ok(count)
    }

    /// Axes on their own.
    fn own(&self, motion: &[Step], abrupt: bool) -> Result<(), Violation> {
        for (axis, limits) in self.axes.iter().enumerate() {
            let own: Vec<usize> = (0..motion.len()).filter(|n| motion[*n].by[axis] != 0).collect();
            let rest = (1.05 * HZ / limits.start) as u64;
            let goes_on = |a: &usize, b: &usize| {
                let (a, b) = (motion[*a], motion[*b]);
                b.at - a.at <= rest && a.by[axis] == b.by[axis]
            };
            let corner = self.corner(axis, limits.accel.max(limits.decel));
            for part in own.chunk_by(goes_on) {
                let mut times: Vec<u64> = part.iter().map(|n| motion[*n].at).collect();
                if abrupt {
                    // Its last window has no stop.
                    times.truncate(times.len().saturating_sub(2));
                }
                let limits = Limits {
                    decel: if abrupt { limits.top.powi(2) } else { limits.decel },
                    ..*limits
                };
                // Another axis may go on at a corner where this one stops, or have gone before where it begins.
                let start = limits.start.max(corner);
                let ends =
                    if own.len() < motion.len() { Limits { start, ..limits } } else { limits };
                for motion in split(&times, &limits) {
                    let from = part.len() - times.len();
                    check(motion, &ends).map_err(|v| Violation {
                        step: part[(v.step + from).min(part.len() - 1)],
                        ..v
                    })?;
                }
            }
        }
        Ok(())
    }

    /// Axes together.
    fn path(&self, motion: &[Step], abrupt: bool) -> Result<(), Violation> {
        for (axis, limits) in self.axes.iter().enumerate() {
            self.tops(motion, axis, limits)?;
            self.stops(motion, axis, limits, abrupt)?;
            self.bends(motion, axis, limits)?;
            let leads = |step: &Step| step.by[axis];
            // Below its own start rate it may do as it likes, too.
            let rest = (1.05 * HZ / limits.start) as u64;
            let mut first = 0;
            let goes_on = |a: &Step, b: &Step| leads(a) == leads(b) && b.at - a.at <= rest;
            for run in motion.chunk_by(goes_on) {
                if leads(&run[0]) != 0 {
                    self.leading(run, axis).map_err(|v| Violation { step: v.step + first, ..v })?;
                }
                first += run.len();
            }
        }
        Ok(())
    }

    /// No axis is faster than its top over some steps, which fall on events as soon as another axis moves.
    fn tops(&self, motion: &[Step], axis: usize, limits: &Limits) -> Result<(), Violation> {
        let own: Vec<usize> = (0..motion.len()).filter(|n| motion[*n].by[axis] != 0).collect();
        for count in TOPS {
            for window in own.windows(count + 1) {
                let (a, b) = (window[0], window[count]);
                let moves = |n: usize| motion[a + 1..=b].iter().any(|step| step.by[n] != 0);
                let alone = (0..3).all(|n| n == axis || !moves(n));
                let event = if alone { 0 } else { motion[b].at - motion[b - 1].at };
                let ticks = motion[b].at - motion[a].at + event + 1;
                bound(What::Top, a, count as f64 * HZ / ticks as f64, limits.top * 1.02)?;
            }
        }
        Ok(())
    }

    /// What a corner may change the speed of an axis by at once, steps/s: its start rate to and fro or what
    /// junction deviation allows at any angle.
    ///
    /// v^2 = a d c / (1 - c) and the change is 2 v sin, so at most the root of 8 a d. A diagonal path's a is
    /// root 3 times that of its axes at most.
    fn corner(&self, axis: usize, ramp: f64) -> f64 {
        (8.0 * 3_f64.sqrt() * self.corner_um / self.um[axis] * ramp).sqrt() * 1.05
    }

    /// The speed of an axis changes by no more than its ramps allow and one corner: what each of many
    /// corners may do, all of them together may not.
    pub(super) fn bends(
        &self,
        motion: &[Step],
        axis: usize,
        limits: &Limits,
    ) -> Result<(), Violation> {
        let ramp = limits.accel.max(limits.decel);
        let once = self.corner(axis, ramp).max(2.0 * limits.jump(ramp));
        let mut place = 0;
        let places: Vec<i32> = motion
            .iter()
            .map(|step| {
                place += i32::from(step.by[axis]);
                place
            })
            .collect();
        for ticks in BENDS {
            let behind = |first: usize| {
                let at = motion[first].at + ticks;
                let end = first + motion[first..].partition_point(|step| step.at < at);
                let end = end.max(first + BEND_EVENTS);
                (end < motion.len()).then_some(end)
            };
            let mut first = 0;
            while let Some((mid, end)) = behind(first).and_then(|mid| Some((mid, behind(mid)?))) {
                let [before, after] = [(first, mid), (mid, end)].map(|(a, b)| {
                    let time = (motion[b].at - motion[a].at) as f64 / HZ;
                    (f64::from(places[b] - places[a]) / time, time)
                });
                let change = (after.0 - before.0).abs();
                // Either end of a half window may lie a step off.
                let slack = 2.0 / before.1 + 2.0 / after.1;
                let time = (before.1 + after.1) / 2.0;
                bound(What::Bend, mid, change, 1.05 * ramp * time + slack + once)?;
                let next = motion[first].at + ticks / 4;
                first += motion[first..].partition_point(|step| step.at < next).max(1);
            }
        }
        Ok(())
    }

    /// An axis that stops or turns round, or begins, does so at no more than a corner allows.
    fn stops(
        &self,
        motion: &[Step],
        axis: usize,
        limits: &Limits,
        abrupt: bool,
    ) -> Result<(), Violation> {
        let own: Vec<usize> = (0..motion.len()).filter(|n| motion[*n].by[axis] != 0).collect();
        let at = |n: usize| motion[own[n]].at;
        // The time between two steps is known to an event, where there are any between them.
        let gap = |n: usize, event: usize| {
            let between = own[n + 1] - own[n] > 1;
            at(n + 1) - at(n) - if between { motion[event].at - motion[event - 1].at } else { 0 }
        };
        let most = |ramp: f64| limits.jump(ramp).max(self.corner(axis, ramp));
        // The lowest of the rates over one to four steps: steps fall on events, and those on ticks.
        let before = |n: usize| {
            let rates = (1..=4.min(n)).map(|k| k as f64 * HZ / ((at(n) - at(n - k)) as f64 + 1.0));
            rates.fold(f64::INFINITY, f64::min)
        };
        let behind = |n: usize| {
            let rates = (1..=4.min(own.len() - 1 - n))
                .map(|k| k as f64 * HZ / ((at(n + k) - at(n)) as f64 + 1.0));
            rates.fold(f64::INFINITY, f64::min)
        };
        for n in 0..own.len() {
            let turns = n + 1 < own.len() && motion[own[n]].by[axis] != motion[own[n + 1]].by[axis];
            let ends = n + 1 == own.len();
            if n >= 4
                && (turns
                    || ends && !abrupt
                    || !ends && gap(n, own[n + 1]) > STOPS * (at(n) - at(n - 1)))
            {
                bound(What::Start, own[n], before(n), most(limits.decel))?;
            }
            let comes = n > 0 && motion[own[n]].by[axis] != motion[own[n - 1]].by[axis];
            let begins = n == 0;
            if own.len() - n > 4
                && (comes || begins || gap(n - 1, own[n - 1] + 1) > STOPS * (at(n + 1) - at(n)))
            {
                bound(What::Start, own[n], behind(n), most(limits.accel))?;
            }
        }
        Ok(())
    }

    /// A run of events at each of which an axis steps in one direction.
    fn leading(&self, run: &[Step], axis: usize) -> Result<(), Violation> {
        let limits = &self.axes[axis];
        let others = [0, 1, 2].map(|n| n != axis && run.iter().any(|step| step.by[n] != 0));
        // Whether some events may be those of another axis, which is at all of them but not everywhere.
        let goes = |steps: &[Step], n: usize| steps.iter().all(|step| step.by[n] != 0);
        let is_led = |half: &[Step]| (0..3).any(|n| n != axis && goes(half, n) && !goes(run, n));
        for (half, most) in SCALES {
            let stride = half / HALF_WINDOW;
            let mut i = 0;
            while i + 2 * half < run.len() {
                let (mid, end) = (i + half, i + 2 * half);
                let ticks = |a: usize, b: usize| (run[b].at - run[a].at) as f64;
                let (v0, v1) =
                    (half as f64 * HZ / ticks(i, mid), half as f64 * HZ / ticks(mid, end));
                // An axis takes any rate up to its start rate at once, and needs no ramp to change between two of them:
                // the path may then change its speed at a corner by more than its ramp.
                if v0.max(v1) <= 1.05 * limits.start {
                    i += stride;
                    continue;
                }
                let time = ticks(i, end) / HZ / 2.0;
                let mut slack = v0 * 2.0 / ticks(i, mid) + v1 * 2.0 / ticks(mid, end);
                let around = &run[i.saturating_sub(2 * half)..run.len().min(end + 2 * half)];
                let halves = [&run[i + 1..=mid], &run[mid + 1..=end]];
                if !is_straight(around, others) || halves.iter().any(|half| is_led(half)) {
                    // The chords of an arc end on whole steps, and so do lines between which the lead changes:
                    // each of the three instants may be half an event off.
                    slack += 2.0 * v0.max(v1) / half as f64;
                }
                let [slow, fast] = self.turn(halves, axis, others);
                // In the first half it was the axis's rate of then that changed by its ramp, before the turn.
                let turned =
                    |by: f64| (ticks(i, mid) * by.max(1.0) + ticks(mid, end)) / ticks(i, end);
                let up = (v1 - v0 * fast - slack) / time;
                bound(What::Accel, mid, up, limits.accel * most * turned(fast))?;
                let down = (v0 * slow - v1 - slack) / time;
                bound(What::Decel, mid, down, limits.decel * most * turned(slow))?;
                i += stride;
            }
        }
        Ok(())
    }

    /// By how much the rate of the leading axis can have changed, lowest and highest factor, because
    /// the path's direction did: the steps of another axis in a half window are one off.
    fn turn(&self, halves: [&[Step]; 2], axis: usize, others: [bool; 3]) -> [f64; 2] {
        // Squares of what the other axes go for each step of the leading one, at least and most, of
        // either half.
        let mut squares = [[0.0; 2]; 2];
        let mut bend = 0.0;
        for other in (0..3).filter(|other| others[*other]) {
            let scale = self.um[other] / self.um[axis] / halves[0].len() as f64;
            let made =
                halves.map(|half| half.iter().map(|step| f64::from(step.by[other])).sum::<f64>());
            for (squares, made) in squares.iter_mut().zip(made) {
                squares[0] += ((made.abs() - 1.0).max(0.0) * scale).powi(2);
                squares[1] += ((made.abs() + 1.0) * scale).powi(2);
            }
            let change = (made[0] - made[1]).abs();
            if change > 1.0 {
                // The direction changes within the halves, too: a mean of cosines is no cosine of
                // a mean, by a twelfth of the square of the change.
                bend += ((change + 2.0) * scale).powi(2) / 12.0;
            }
        }
        let [first, second] =
            squares.map(|squares| squares.map(|own: f64| 1.0 / (1.0 + own).sqrt()));
        [second[1] / first[0] - bend, second[0] / first[1] + bend]
    }
}

/// Whether steps of several axes belong to one event stream.
fn is_interpolated(motion: &[Step]) -> bool {
    let of = |axis: usize| motion.iter().filter(|step| step.by[axis] != 0).count();
    let mut counts = [of(0), of(1), of(2)];
    counts.sort_unstable();
    let shared = motion.iter().filter(|step| step.by.iter().filter(|by| **by != 0).count() > 1);
    let shared = shared.count();
    shared > 0 && shared * SHARED >= counts[1]
}

/// Whether a leading axis goes straight: another axis steps once in so many events or in one more, and
/// at the ends it has not left out a step.
fn is_straight(run: &[Step], others: [bool; 3]) -> bool {
    (0..3).filter(|other| others[*other]).all(|other| {
        let steps: Vec<usize> = (0..run.len()).filter(|n| run[*n].by[other] != 0).collect();
        let gaps = || steps.windows(2).map(|w| w[1] - w[0]);
        let (Some(least), Some(most)) = (gaps().min(), gaps().max()) else {
            return true;
        };
        let ends = steps[0].max(run.len() - 1 - steps[steps.len() - 1]);
        most - least <= 1 && ends <= least + 1
    })
}

/// Motions that follow one another at once: the second begins with a step between two intervals at
/// the start rate.
fn split<'a>(times: &'a [u64], limits: &Limits) -> Vec<&'a [u64]> {
    let slow = (HZ / limits.jump(limits.accel.min(limits.decel))) as u64;
    let mut out = Vec::new();
    let mut first = 0;
    for n in 1..times.len() {
        let interval = |k: usize| times.get(k).map_or(u64::MAX, |at| at - times[k - 1]);
        let alone = n - first < 2 || interval(n - 1) >= slow;
        if interval(n) < slow && alone && interval(n + 1) >= slow {
            out.push(&times[first..n]);
            first = n;
        }
    }
    out.push(&times[first..]);
    out
}
