//! The step engine of the desktop's chip: plays segments event by event, as the interrupts of the F5529 do
//! (`firmware/f5529/step/handlers.rs`).
//!
//! Times are in 1/65536 ticks of the step timer since power-up. A step is armed at one event and made at the next one
//! by the timer's output. A position counts the step from when it is armed.

mod rush;

use std::collections::VecDeque;

use firmware::motion::queue::{self, SLOTS};
use firmware::motion::{PathSegment, Segment};

/// A segment of a path on its way.
#[derive(Clone, Copy, Debug, Default)]
struct Slot {
    segment: PathSegment,
    power: u16,
}

/// An axis that moves on its own.
#[derive(Clone, Copy, Debug, Default)]
struct Single {
    playing: Segment,
    next: Segment,
    next_is_negative: bool,
    /// When its next event comes; `None` at rest.
    due: Option<u64>,
    armed: bool,
}

/// What an event does at the pins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pulse {
    /// When, in ticks of the step timer.
    pub tick: u64,
    /// Bit per axis that steps.
    pub steps: u8,
}

/// The engine.
#[derive(Clone, Debug, Default)]
pub struct Engine {
    /// The playing segment and those after it; the first one is empty when a motion begins.
    path: VecDeque<Slot>,
    /// When the path's next event comes; `None` at rest.
    due: Option<u64>,
    /// Bit per axis that steps at the path's next event.
    armed: u8,
    accumulators: [u32; 3],
    singles: [Single; 3],
    /// Positions, steps.
    pub count: [i32; 3],
    /// Bit per axis: it counts down.
    pub negative: u8,
    power: u16,
    /// Pins that are watched, their levels at rest, and whether an answer halts.
    watched: u8,
    idle: u8,
    halts: bool,
    /// The pins that answered, and the positions then.
    pub hit: u8,
    /// See `hit`.
    pub caught: [i32; 3],
    /// Segments that were taken or have ended, by themselves or cut: whoever feeds the engine has something to do.
    pub changes: u32,
    /// The shortest interval between two steps of the path since it was last set to 0, 1/65536 ticks; 0 without one.
    pub shortest: u32,
}

/// Time between a start and its first event, us.
const LEAD_US: u64 = 10;

impl Engine {
    /// When the next event comes, in 1/65536 ticks.
    pub fn next_event(&self) -> Option<u64> {
        self.singles.iter().filter_map(|single| single.due).chain(self.due).min()
    }

    /// Whether any axis has an event ahead.
    pub fn moves(&self) -> bool {
        self.next_event().is_some()
    }

    /// The same of one axis; the path is the first one's.
    pub fn axis_moves(&self, axis: usize) -> bool {
        self.singles[axis].due.is_some() || axis == 0 && self.due.is_some()
    }

    /// Empties it. Nothing runs.
    pub fn clear(&mut self) {
        self.path.clear();
        self.due = None;
        self.armed = 0;
        self.accumulators = [0; 3];
        self.singles = Default::default();
    }

    /// Drops what is planned: the step that is armed comes, none after it.
    pub fn cut(&mut self) {
        self.changes = self.changes.wrapping_add(1);
        self.path.iter_mut().for_each(|slot| slot.segment.ramp.events = 0);
        for axis in 0..3 {
            self.cut_axis(axis);
        }
    }

    /// The same of an axis that moves on its own.
    pub fn cut_axis(&mut self, axis: usize) {
        self.singles[axis].playing.events = 0;
        self.singles[axis].next.events = 0;
    }

    /// Whether a segment of a path would be taken.
    pub fn path_has_room(&self) -> bool {
        self.path.len() < SLOTS
    }

    /// Time of the segments after the playing one ([`queue::time`]).
    pub fn ahead(&self) -> u16 {
        if !self.moves() {
            return 0;
        }
        let times = self.path.iter().skip(1).map(|slot| queue::time(&slot.segment.ramp));
        times.fold(0, u16::wrapping_add)
    }

    /// Takes a segment of a path at a time, in 1/65536 of `per_us` ticks.
    pub fn put_path(&mut self, segment: &PathSegment, power: u16, now: u64, per_us: u64) {
        if self.due.is_none() {
            self.path.clear();
            self.path.push_back(Slot::default());
            self.due = Some(now + ((LEAD_US * per_us) << 16));
            self.armed = 0;
        }
        self.path.push_back(Slot { segment: *segment, power });
        self.changes = self.changes.wrapping_add(1);
    }

    /// Power of the segment that plays.
    pub fn power(&self) -> u16 {
        self.power
    }

    /// Whether a segment of an axis of its own would be taken.
    pub fn axis_has_room(&self, axis: usize) -> bool {
        self.singles[axis].next.events == 0
    }

    /// Takes a segment of one axis at a time, in 1/65536 of `per_us` ticks.
    pub fn put_axis(
        &mut self,
        axis: usize,
        segment: &Segment,
        negative: bool,
        now: u64,
        per_us: u64,
    ) {
        let single = &mut self.singles[axis];
        self.changes = self.changes.wrapping_add(1);
        single.next = *segment;
        single.next_is_negative = negative;
        if single.due.is_none() {
            single.due = Some(now + ((LEAD_US * per_us) << 16));
            single.armed = false;
        }
    }

    /// Watches pins at every event: `pins` answer when they differ from `idle`.
    pub fn watch(&mut self, pins: u8, idle: u8, halts: bool) {
        (self.watched, self.idle, self.halts, self.hit) = (pins, idle, halts, 0);
    }

    /// Whether any pin is watched.
    pub fn watches(&self) -> bool {
        self.watched != 0
    }

    /// Whether a watched pin would answer at an event with these levels of the port of inputs.
    pub fn would_answer(&self, inputs: u8) -> bool {
        (inputs ^ self.idle) & self.watched != 0
    }

    /// The step that the event at `due` brings to the pins.
    pub fn pulse(&self, due: u64) -> Pulse {
        let path = if self.due == Some(due) { self.armed } else { 0 };
        let singles = self.singles.iter().enumerate();
        let own = singles.filter(|(_, single)| single.due == Some(due) && single.armed);
        Pulse { tick: due >> 16, steps: own.fold(path, |steps, (axis, _)| steps | 1 << axis) }
    }

    /// The events at `due`, after their steps have come to the pins; `inputs` are the levels of the port of inputs
    /// then.
    pub fn play(&mut self, due: u64, inputs: u8) {
        if self.due == Some(due) {
            self.path_event(due, inputs);
        }
        for axis in 0..3 {
            if self.singles[axis].due == Some(due) {
                self.single_event(axis, due, inputs);
            }
        }
    }

    /// DIR has changed of some axes, bit per axis: their next event comes no earlier than `least`.
    pub fn put_off(&mut self, axes: u8, least: u64) {
        self.due = self.due.map(|due| due.max(least));
        for (axis, single) in self.singles.iter_mut().enumerate() {
            if axes >> axis & 1 != 0 {
                single.due = single.due.map(|due| due.max(least));
            }
        }
    }

    fn path_event(&mut self, due: u64, inputs: u8) {
        self.armed = 0;
        let playing = self.path.front_mut().filter(|slot| slot.segment.ramp.events != 0);
        if playing.is_none() {
            self.changes = self.changes.wrapping_add(1);
            self.path.pop_front();
            let Some(next) = self.path.front().filter(|slot| slot.segment.ramp.events != 0) else {
                self.path.clear();
                self.due = None;
                return;
            };
            self.power = next.power;
            if next.segment.begin {
                self.negative = next.segment.negative;
                self.accumulators = next.segment.acc.map(|acc| u32::from(acc) << 16);
            }
        }
        let Some(Slot { segment, .. }) = self.path.front_mut() else { return };
        segment.ramp.events -= 1;
        let interval = segment.ramp.interval;
        segment.ramp.interval = interval.wrapping_add_signed(segment.ramp.dif);
        let (is_step, inc) = (segment.ramp.events & segment.ramp.mask == 0, segment.inc);
        let whole = u64::from(interval) * (u64::from(segment.ramp.mask) + 1);
        self.note_interval(whole);
        self.due = Some(due + u64::from(interval));
        if self.answers(inputs) {
            self.path.clear();
            self.due = None;
            return;
        }
        if !is_step {
            return;
        }
        for (axis, inc) in inc.into_iter().enumerate() {
            let (sum, carry) = self.accumulators[axis].overflowing_add(inc);
            self.accumulators[axis] = sum;
            if carry {
                self.armed |= 1 << axis;
                self.count_step(axis);
            }
        }
    }

    /// Steps of the path come so far apart, 1/65536 ticks.
    fn note_interval(&mut self, interval: u64) {
        let interval = u32::try_from(interval).unwrap_or(u32::MAX);
        if self.shortest == 0 || interval < self.shortest {
            self.shortest = interval;
        }
    }

    fn single_event(&mut self, axis: usize, due: u64, inputs: u8) {
        let single = &mut self.singles[axis];
        single.armed = false;
        if single.playing.events == 0 {
            self.changes = self.changes.wrapping_add(1);
            if single.next.events == 0 {
                single.due = None;
                return;
            }
            single.playing = std::mem::take(&mut single.next);
            self.negative &= !(1 << axis);
            self.negative |= u8::from(single.next_is_negative) << axis;
        }
        let playing = &mut single.playing;
        playing.events -= 1;
        let interval = playing.interval;
        playing.interval = interval.wrapping_add_signed(playing.dif);
        let is_step = playing.events & playing.mask == 0;
        single.due = Some(due + u64::from(interval));
        if self.answers(inputs) {
            self.cut();
            self.singles[axis].due = None;
        } else if is_step {
            self.singles[axis].armed = true;
            self.count_step(axis);
        }
    }

    fn count_step(&mut self, axis: usize) {
        let step = if self.negative >> axis & 1 != 0 { -1 } else { 1 };
        self.count[axis] = self.count[axis].wrapping_add(step);
    }

    /// Whether a watched pin answers that halts the engine; the answer is noted.
    fn answers(&mut self, inputs: u8) -> bool {
        let hit = (inputs ^ self.idle) & self.watched;
        if hit == 0 {
            return false;
        }
        self.hit = hit;
        self.changes = self.changes.wrapping_add(1);
        self.watched = 0;
        self.caught = self.count;
        self.halts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Plays everything; the steps of each axis that came to the pins.
    fn play(engine: &mut Engine) -> [u32; 3] {
        let mut steps = [0; 3];
        while let Some(due) = engine.next_event() {
            let pulse = engine.pulse(due);
            (0..3).for_each(|axis| steps[axis] += u32::from(pulse.steps >> axis & 1));
            engine.play(due, 0);
        }
        steps
    }

    #[test]
    fn a_path_makes_the_steps_that_were_planned() {
        let ramp = Segment { interval: 400 << 16, dif: -1000, events: 240, mask: 3 };
        let first = PathSegment {
            ramp,
            inc: [u32::MAX, 1 << 31, 12_345_678],
            acc: [1 << 15; 3],
            negative: 0b010,
            begin: true,
            ..PathSegment::default()
        };
        let second = PathSegment { begin: false, ..first };
        let (mut accumulators, mut wanted) = ([0; 3], [0; 3]);
        let mut engine = Engine::default();
        for segment in [first, second] {
            assert!(engine.path_has_room());
            engine.put_path(&segment, 0, 0, 25);
            segment.played(segment.ramp.steps(), &mut accumulators, &mut wanted);
        }
        assert!(engine.moves());
        let steps = play(&mut engine);
        assert_eq!(engine.count, wanted);
        assert_eq!(
            steps,
            wanted.map(i32::unsigned_abs),
            "each step that is counted comes to a pin"
        );
        assert!(!engine.moves());
    }

    #[test]
    fn an_axis_plays_one_segment_and_has_the_next() {
        let segment = Segment { interval: 400 << 16, dif: 0, events: 10, mask: 0 };
        let mut engine = Engine::default();
        engine.put_axis(1, &segment, true, 0, 25);
        assert!(!engine.axis_has_room(1) && engine.axis_has_room(0));
        let due = engine.next_event().unwrap();
        engine.play(due, 0);
        assert!(engine.axis_has_room(1));
        engine.put_axis(1, &segment, false, due, 25);
        assert_eq!(play(&mut engine), [0, 20, 0]);
        assert_eq!(engine.count, [0, 0, 0], "ten down and ten up");
    }

    #[test]
    fn what_is_cut_makes_the_step_that_is_armed_and_no_other() {
        let segment = Segment { interval: 400 << 16, dif: 0, events: 10, mask: 0 };
        let mut engine = Engine::default();
        engine.put_axis(0, &segment, false, 0, 25);
        for _ in 0..3 {
            let due = engine.next_event().unwrap();
            engine.play(due, 0);
        }
        let counted = engine.count[0];
        engine.cut();
        assert_eq!(play(&mut engine), [1, 0, 0]);
        assert_eq!(engine.count[0], counted);
    }
}
