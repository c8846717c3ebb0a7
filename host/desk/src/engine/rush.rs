//! Skips many events of the step engine at once: in a segment the interval changes linearly and each axis has a constant
//! increment, so counts and times after any number of events have a closed form.

use firmware::motion::Segment;

use super::{Engine, Single, Slot};

/// Time from an event of a segment to the one `count` events later, 1/65536 ticks.
fn span(segment: &Segment, count: u32) -> u64 {
    let count = i64::from(count);
    let sum =
        count * i64::from(segment.interval) + count * (count - 1) / 2 * i64::from(segment.dif);
    sum.unsigned_abs()
}

/// Whether all intervals of a segment have a length, the shortest time between two of its steps no less than `least`.
fn is_plain(segment: &Segment, least: u64) -> bool {
    let last =
        i64::from(segment.interval) + i64::from(segment.dif) * (i64::from(segment.events) - 1);
    let shortest = i64::from(segment.interval).min(last);
    let wide = u32::try_from(last).is_ok() && shortest > 0;
    wide && shortest.unsigned_abs() * (u64::from(segment.mask) + 1) >= least
}

/// Events of a segment that come by `until`, the first one at `due`.
fn events_until(segment: &Segment, due: u64, until: u64) -> u32 {
    let Some(time) = until.checked_sub(due) else { return 0 };
    let events = u32::from(segment.events);
    if events == 0 || span(segment, events - 1) <= time {
        return events;
    }
    // The event `low` comes in time, the event `high` does not.
    let (mut low, mut high) = (0, events - 1);
    while high - low > 1 {
        let middle = low.midpoint(high);
        if span(segment, middle) <= time {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

/// Steps among the next `count` events of a segment.
fn steps_in(segment: &Segment, count: u32) -> u32 {
    let (events, each) = (u32::from(segment.events), u32::from(segment.mask) + 1);
    if count == 0 {
        return 0;
    }
    (events - 1) / each + 1 - (events - count).div_ceil(each)
}

/// The most events of a segment among which there are no more than so many steps.
fn events_with(segment: &Segment, steps: u64) -> u32 {
    let (events, each) = (u32::from(segment.events), u32::from(segment.mask) + 1);
    let all = steps_in(segment, events);
    match u32::try_from(steps) {
        // Ahead of the step after these.
        Ok(steps) if steps < all => events - (all - steps - 1) * each - 1,
        _ => events,
    }
}

/// The last one of the next `count` events is a step.
fn ends_with_step(segment: &Segment, count: u32) -> bool {
    (u32::from(segment.events) - count) & u32::from(segment.mask) == 0
}

/// The segment after so many of its events.
fn advance(segment: &mut Segment, count: u32) {
    let interval = i64::from(segment.interval) + i64::from(segment.dif) * i64::from(count);
    segment.interval = interval as u32;
    segment.events -= count as u16;
}

impl Single {
    /// The events by `until` of the segment that plays, but none after which more than `room` steps have come to the pin.
    fn events(&self, until: u64, room: u64) -> u32 {
        let Some(due) = self.due else { return 0 };
        match room.checked_sub(self.armed.into()) {
            // What the last one arms comes later.
            Some(room) => events_with(&self.playing, room).saturating_add(1).min(events_until(
                &self.playing,
                due,
                until,
            )),
            None => 0,
        }
    }

    /// Plays so many events; the steps that come to the pin, and those that are counted.
    fn rush(&mut self, count: u32) -> [u32; 2] {
        let counted = steps_in(&self.playing, count);
        let armed = std::mem::replace(&mut self.armed, ends_with_step(&self.playing, count));
        self.due = self.due.map(|due| due + span(&self.playing, count));
        advance(&mut self.playing, count);
        [u32::from(armed) + counted - u32::from(self.armed), counted]
    }
}

impl Engine {
    /// Whether [`Engine::rush`] may find events by `until`: not where the next one begins or ends a segment.
    pub fn may_rush(&self, until: u64) -> bool {
        let plays = |single: &Single| single.playing.events != 0;
        let single = |single: &Single| single.due.is_some_and(|due| due <= until) && plays(single);
        match self.due {
            Some(due) => {
                let playing = self.path.front();
                due <= until && playing.is_some_and(|slot| slot.segment.ramp.events != 0)
            }
            None => self.singles.iter().any(single),
        }
    }

    /// Plays the events by `until`, 1/65536 ticks, of the segments that play, as far as no axis brings more than `room`
    /// steps to its pin. Watched pins do not answer meanwhile, and steps are at least `least` apart. Gives the steps that
    /// come to the pins, or nothing where not even one event can be played.
    pub fn rush(&mut self, until: u64, room: [u64; 3], least: u64) -> Option<[u32; 3]> {
        if self.next_event().is_none_or(|due| due > until) {
            return None;
        }
        match self.due {
            Some(due) if self.singles.iter().all(|single| single.due.is_none()) => {
                self.rush_path(due, until, room, least)
            }
            Some(_) => None,
            None => self.rush_singles(until, room, least),
        }
    }

    fn rush_path(&mut self, due: u64, until: u64, room: [u64; 3], least: u64) -> Option<[u32; 3]> {
        let Slot { segment, .. } = self.path.front_mut()?;
        let ramp = &mut segment.ramp;
        if ramp.events == 0 || !is_plain(ramp, least) {
            return None;
        }
        let mut count = events_until(ramp, due, until);
        for axis in 0..3 {
            let armed = u64::from(self.armed >> axis & 1);
            let room = room[axis].checked_sub(armed)?;
            let inc = u64::from(segment.inc[axis]);
            if inc != 0 && room < u64::from(u32::MAX) {
                // Additions that carry no more often than that.
                let most = (((room + 1) << 32) - 1 - u64::from(self.accumulators[axis])) / inc;
                count = count.min(events_with(ramp, most).saturating_add(1));
            }
        }
        if count == 0 {
            return None;
        }
        let (additions, ends) = (steps_in(ramp, count), ends_with_step(ramp, count));
        let mut steps = [0; 3];
        let mut armed = 0;
        for (axis, made) in steps.iter_mut().enumerate() {
            let inc = segment.inc[axis];
            let sum = u64::from(self.accumulators[axis]) + u64::from(inc) * u64::from(additions);
            let counted = (sum >> 32) as u32;
            self.accumulators[axis] = sum as u32;
            // The last addition carried when it left less than it added.
            let carried = ends && (sum as u32) < inc;
            armed |= u8::from(carried) << axis;
            *made = u32::from(self.armed >> axis & 1) + counted - u32::from(carried);
            let way = counted.cast_signed();
            let way = if self.negative >> axis & 1 != 0 { -way } else { way };
            self.count[axis] = self.count[axis].wrapping_add(way);
        }
        self.armed = armed;
        self.due = Some(due + span(ramp, count));
        let each = u64::from(ramp.mask) + 1;
        let first = u64::from(ramp.interval);
        advance(ramp, count - 1);
        let last = u64::from(ramp.interval);
        advance(ramp, 1);
        self.note_interval(first.min(last).saturating_mul(each));
        Some(steps)
    }

    fn rush_singles(&mut self, mut until: u64, room: [u64; 3], least: u64) -> Option<[u32; 3]> {
        for (single, room) in self.singles.iter().zip(room) {
            let Some(due) = single.due.filter(|due| *due <= until) else { continue };
            if single.playing.events == 0 || !is_plain(&single.playing, least) {
                until = until.min(due - 1);
                continue;
            }
            // An event that is not of these comes first by itself.
            let next = due + span(&single.playing, single.events(until, room));
            if next <= until {
                until = next - 1;
            }
        }
        let (mut steps, mut played) = ([0; 3], 0);
        for axis in 0..3 {
            let single = &mut self.singles[axis];
            let count = single.events(until, room[axis]);
            if count == 0 {
                continue;
            }
            played += count;
            let [pulses, counted] = single.rush(count);
            steps[axis] = pulses;
            let way = counted.cast_signed();
            let way = if self.negative >> axis & 1 != 0 { -way } else { way };
            self.count[axis] = self.count[axis].wrapping_add(way);
        }
        (played != 0).then_some(steps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use firmware::motion::PathSegment;

    /// Plays event by event up to `until`; the steps that come to the pins.
    fn step_by_step(engine: &mut Engine, until: u64) -> [u32; 3] {
        let mut steps = [0; 3];
        while let Some(due) = engine.next_event().filter(|due| *due <= until) {
            let pulse = engine.pulse(due);
            (0..3).for_each(|axis| steps[axis] += u32::from(pulse.steps >> axis & 1));
            engine.play(due, 0);
        }
        steps
    }

    /// The same at once, where that goes.
    fn rushing(engine: &mut Engine, until: u64, room: u64) -> [u32; 3] {
        let mut steps = [0; 3];
        let mut add = |more: [u32; 3]| {
            for (all, more) in steps.iter_mut().zip(more) {
                *all += more;
            }
        };
        while let Some(due) = engine.next_event().filter(|due| *due <= until) {
            match engine.rush(until, [room; 3], 1) {
                Some(more) => {
                    assert!(more.iter().all(|steps| u64::from(*steps) <= room));
                    add(more);
                }
                None => add(step_by_step(engine, due)),
            }
        }
        steps
    }

    fn state(engine: &Engine) -> String {
        format!("{engine:?}")
    }

    fn segment(n: u32) -> Segment {
        let each = 1 << (n % 4);
        let events = (each * (1 + n * 37 % 50)) as u16;
        let dif = [0, 900, -900][n as usize % 3];
        Segment { interval: (400 + n * 13) << 16, dif, events, mask: each as u16 - 1 }
    }

    fn path(n: u32) -> PathSegment {
        PathSegment {
            ramp: segment(n),
            inc: [u32::MAX, 0x8000_0000 >> (n % 3), 12_345_678 * n],
            acc: [1 << 15, 0, 77],
            negative: n as u8 & 0b101,
            begin: n.is_multiple_of(2),
            ..PathSegment::default()
        }
    }

    #[test]
    fn a_path_at_once_is_what_it_is_step_by_step() {
        for room in [1, 2, 7, u64::MAX] {
            let mut slow = Engine::default();
            for n in 0..12 {
                slow.put_path(&path(n), n as u16, 0, 25);
            }
            let mut fast = slow.clone();
            for until in (0..400).map(|n| n * n * 97_000_000 / 2) {
                let (wanted, steps) =
                    (step_by_step(&mut slow, until), rushing(&mut fast, until, room));
                assert_eq!(steps, wanted, "by {until}, room {room}");
                assert_eq!(state(&fast), state(&slow), "by {until}, room {room}");
            }
            assert!(!fast.moves());
        }
    }

    #[test]
    fn axes_on_their_own_at_once_are_what_they_are_step_by_step() {
        for room in [1, 2, 7, u64::MAX] {
            let mut slow = Engine::default();
            for axis in 0..3 {
                slow.put_axis(axis, &segment(axis as u32 + 5), axis == 1, axis as u64 * 999, 25);
            }
            let mut fast = slow.clone();
            for (n, until) in (0..400).map(|n| (n, n * n * 9_700_000)) {
                let (wanted, steps) =
                    (step_by_step(&mut slow, until), rushing(&mut fast, until, room));
                assert_eq!(steps, wanted, "by {until}, room {room}");
                assert_eq!(state(&fast), state(&slow), "by {until}, room {room}");
                for axis in 0..3 {
                    if !slow.axis_has_room(axis) || n >= 50 {
                        continue;
                    }
                    for engine in [&mut slow, &mut fast] {
                        engine.put_axis(axis, &segment(n as u32), n % 2 == 0, until, 25);
                    }
                }
            }
            assert!(!fast.moves());
        }
    }

    #[test]
    fn what_is_no_segment_of_a_ramp_is_played_step_by_step() {
        let wild = Segment { interval: 10 << 16, dif: -(1 << 16), events: 40, mask: 0 };
        assert!(!is_plain(&wild, 1));
        assert!(!is_plain(&segment(0), 500 << 16), "steps closer than that");
        assert!(is_plain(&segment(0), 400 << 16));
    }
}
