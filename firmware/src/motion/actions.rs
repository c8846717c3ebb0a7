//! Actions on the way: outputs that change where a block of the path begins, without stopping it.
//!
//! A statement `SYNC` puts an [`Action`] into a list of [`ROOM`]. What it costs does not grow with the blocks: an action
//! knows its place by its distance along the path ([`super::Path::end`] when the statement runs, less a lead that is a
//! length), not by a block. When the segment is handed to the step engine in which that place lies, the place becomes a
//! *mark*: the time, as [`super::queue::time`] counts it, of all segments before it and of the part of this one. A place
//! at the end of a block is not in that block's last segment but in the first one of the next, so that an action without a
//! next block waits for one: for the next motion, as M62 of LinuxCNC does, or for a statement that waits for the path's
//! end anyway, before which all that still wait are carried out ([`Actions::flush`]).
//!
//! Each pass of the main loop asks the engine how much time the segments last that it has not begun: what was handed out
//! less that is the time at which the playing one ends. Between two of these instants the clock tells how far it is. An
//! action is due when the engine has come to its mark, less a lead that is a time; [`EARLY`] makes half of the passes
//! come before and half after. Nothing has to be known of the speed, so overrides, ramps and pauses keep place and action
//! together. So that a mark is there in time, the engine is to hold as much more as the longest lead ([`Actions::ahead`]).
//!
//! A lag, and the length of a pulse, are counted in milliseconds, in a pause too. A list that is full lets the program
//! wait, and with it the path slows down on its ramps; actions at one place are carried out in the order of their
//! statements, each at the pins before the next.

/// Actions that are known.
pub const ROOM: usize = 6;
/// Longest lead that is a time, ms: the engine holds no more.
pub const MOST_LEAD: i32 = lang::part::SYNC_LEAD_MS;
/// Longest lag and longest pulse, ms.
pub const MOST_MS: i32 = lang::part::SYNC_MS;
/// Ticks of the step timer in a unit of [`super::queue::time`].
pub const UNIT: u16 = 256;
/// So many units before its mark an action is due: half a pass of the main loop.
const EARLY: u16 = 20;

/// What an action waits for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Waits {
    /// Its place, [`Action::at`] in um along the path.
    #[default]
    Place,
    /// Its mark, [`Action::at`] in units of time.
    Mark,
    /// The end of its lag, [`Action::at`] in ms.
    Lag,
    /// The end of its pulse, [`Action::at`] in ms.
    Pulse,
}

/// An output that acts on the way.
#[derive(Clone, Copy, Debug, Default)]
pub struct Action {
    /// See [`Waits`].
    at: u32,
    /// ms before the place, behind it where it is negative.
    pub lead: i16,
    /// ms of a pulse, 0 for none; of an analog output its value.
    pub pulse: u16,
    /// Where its statement stands in the program's code.
    pub pc: u16,
    /// Output from 1, [`ON`] and [`ANALOG`].
    what: u8,
    waits: Waits,
}

/// [`Action::what`]: the output goes on; an analog one gets a value that is not 0.
const ON: u8 = 1 << 7;
/// [`Action::what`]: an analog output.
const ANALOG: u8 = 1 << 6;

impl Action {
    /// Output `n`, from 1, goes on or off.
    pub fn new(n: u8, on: bool) -> Action {
        Action { what: n | if on { ON } else { 0 }, ..Action::default() }
    }

    /// Analog output `n`, from 1, gets a value.
    pub fn analog(n: u8, value: u16) -> Action {
        Action { pulse: value, ..Action::new(n | ANALOG, value != 0) }
    }

    /// It is one of an analog output, [`Action::pulse`] its value.
    pub fn is_analog(&self) -> bool {
        self.what & ANALOG != 0
    }

    /// Number of the output, from 1.
    pub fn output(&self) -> u8 {
        self.what & !(ON | ANALOG)
    }

    /// It goes on.
    pub fn is_on(&self) -> bool {
        self.what & ON != 0
    }
}

/// See the module.
#[derive(Clone, Copy, Debug, Default)]
pub struct Actions {
    list: [Action; ROOM],
    count: u8,
    /// Time of all segments handed out, units, modulo 65536.
    put: u16,
    /// When the playing segment ends, as the engine said last.
    end: u16,
    /// How far the engine is, no further than that.
    now: u16,
    /// The clock then.
    seen: u16,
}

impl Actions {
    /// Whether none waits and no pulse lasts.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Whether another one would be taken.
    pub fn has_room(&self) -> bool {
        usize::from(self.count) < ROOM
    }

    /// All are forgotten.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    fn known(&mut self) -> &mut [Action] {
        &mut self.list[..usize::from(self.count)]
    }

    /// Takes one, if there is room, to act at `place`, um along the path. Where the path was handed out to beyond it
    /// already, `gone` says how long ago that was, units.
    pub fn add(&mut self, mut action: Action, place: u32, gone: Option<u16>) {
        action.at = place;
        action.waits = Waits::Place;
        if let Some(gone) = gone {
            action.at = self.put.wrapping_sub(gone).into();
            action.waits = Waits::Mark;
        }
        if let Some(free) = self.list.get_mut(usize::from(self.count)) {
            *free = action;
            self.count += 1;
        }
    }

    /// A segment was handed out that goes from one place to another and lasts `time` units.
    pub fn hand_out(&mut self, from: u32, to: u32, time: u16, mul_div: fn(u32, u32, u32) -> u32) {
        let put = self.put;
        for action in self.known() {
            if action.waits != Waits::Place || action.at.wrapping_sub(to).cast_signed() >= 0 {
                continue;
            }
            let way = action.at.wrapping_sub(from);
            let length = to.wrapping_sub(from);
            let part = if way < length { mul_div(way, time.into(), length) as u16 } else { 0 };
            action.at = put.wrapping_add(part).into();
            action.waits = Waits::Mark;
        }
        self.put = put.wrapping_add(time);
    }

    /// The longest lead of those that wait for a place, ms.
    pub fn longest_lead(&self) -> u16 {
        let list = self.list.iter().take(self.count.into());
        let waits = list.filter(|action| action.waits == Waits::Place);
        waits.fold(0, |most, action| action.lead.max(most)).unsigned_abs()
    }

    /// The engine holds `ahead` units behind the playing segment, and is at rest unless it `runs`; `clock` counts ticks
    /// of which `per_unit` are a unit.
    pub fn follow(&mut self, ahead: u16, runs: bool, clock: u16, per_unit: u16) {
        let end = self.put.wrapping_sub(ahead);
        let mut since = clock.wrapping_sub(self.seen);
        let mut units = 0;
        while since >= per_unit {
            since -= per_unit;
            units += 1;
        }
        self.seen = clock.wrapping_sub(since);
        if end != self.end {
            // The one before is over.
            self.now = self.end;
            self.end = end;
        } else if end.wrapping_sub(self.now) > units {
            self.now = self.now.wrapping_add(units);
        } else {
            self.now = end;
        }
        if !runs {
            self.now = end;
        }
    }

    /// The first one begins to wait: how far the engine is in its segment is not known.
    pub fn begin(&mut self, ahead: u16, clock: u16) {
        self.end = self.put.wrapping_sub(ahead);
        self.now = self.end.wrapping_sub(1000);
        self.seen = clock;
    }

    /// Takes the next one that is to be carried out, if any is due. A pulse, which is on from now, comes again as one that
    /// goes off.
    pub fn take_due(&mut self, per_ms: u16) -> Option<Action> {
        let mut n = 0;
        while n < usize::from(self.count) {
            let now = self.now;
            let action = &mut self.list[n];
            let due = match action.waits {
                Waits::Place => false,
                Waits::Mark => {
                    let lead = action.lead.max(0).unsigned_abs().saturating_mul(per_ms);
                    let to_go = (action.at as u16).wrapping_sub(now).cast_signed();
                    let due = i32::from(to_go) <= i32::from(lead) + i32::from(EARLY);
                    if due && action.lead < 0 {
                        action.at = action.lead.unsigned_abs().into();
                        action.waits = Waits::Lag;
                        continue;
                    }
                    due
                }
                Waits::Lag | Waits::Pulse => action.at == 0,
            };
            if due {
                return Some(self.carry_out(n));
            }
            n += 1;
        }
        None
    }

    /// The same of one that waits for a place or a mark, as the path is at its end: of those up to the place `most`, um along
    /// the path, or of all.
    pub fn flush(&mut self, most: Option<u32>) -> Option<Action> {
        let mut n = 0;
        while n < usize::from(self.count) {
            let action = &mut self.list[n];
            let beyond = |end: u32| {
                action.waits == Waits::Place && action.at.wrapping_sub(end).cast_signed() > 0
            };
            if matches!(action.waits, Waits::Place | Waits::Mark) && !most.is_some_and(beyond) {
                if action.lead < 0 {
                    action.at = action.lead.unsigned_abs().into();
                    action.waits = Waits::Lag;
                } else {
                    return Some(self.carry_out(n));
                }
            }
            n += 1;
        }
        None
    }

    /// Takes one that switches its output off, pulses that last among them, wherever it is to come.
    pub fn take_off(&mut self) -> Option<Action> {
        let n = self.known().iter().position(|action| !action.is_on())?;
        Some(self.carry_out(n))
    }

    /// Whether all that is known waits for places after `end`, um along the path: none makes room before the path is longer.
    pub fn all_lie_beyond(&self, end: u32) -> bool {
        let mut list = self.list.iter().take(self.count.into());
        list.all(|action| {
            action.waits == Waits::Place && action.at.wrapping_sub(end).cast_signed() > 0
        })
    }

    #[inline(never)]
    fn carry_out(&mut self, n: usize) -> Action {
        let action = self.list[n];
        if action.pulse != 0 && action.is_on() && !action.is_analog() {
            self.list[n].what &= !ON;
            self.list[n].at = action.pulse.into();
            self.list[n].waits = Waits::Pulse;
        } else {
            self.remove(n);
        }
        action
    }

    fn remove(&mut self, mut n: usize) {
        self.count -= 1;
        while n < usize::from(self.count) {
            self.list[n] = self.list[n + 1];
            n += 1;
        }
    }

    /// A millisecond of lags and pulses.
    pub fn tick(&mut self) {
        for action in self.known() {
            if matches!(action.waits, Waits::Lag | Waits::Pulse) && action.at != 0 {
                action.at -= 1;
            }
        }
    }

    /// Drops all; gives the outputs, number n in bit n - 1, that pulses keep on.
    pub fn drop_all(&mut self) -> u16 {
        let mut on = 0;
        for action in self.known() {
            if action.waits == Waits::Pulse {
                on |= 1 << (action.output().wrapping_sub(1) & 15);
            }
        }
        self.count = 0;
        on
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn mul_div(a: u32, b: u32, c: u32) -> u32 {
        (u64::from(a) * u64::from(b)).checked_div(c.into()).map_or(u32::MAX, |n| n as u32)
    }

    /// An engine that plays segments of `(um, units)`, `held` of them ahead, looked at every `pass` units; the times at
    /// which outputs are carried out, after the start of the first segment.
    fn played(
        actions: &mut Actions,
        segments: &[(u32, u16)],
        held: u16,
        pass: u16,
    ) -> Vec<(u8, i32)> {
        let (mut place, mut next, mut ends, mut now) = (0, 0, Vec::new(), 0_i32);
        let mut done = Vec::new();
        actions.begin(0, 0);
        let total: i32 = segments.iter().map(|own| i32::from(own.1)).sum();
        while now <= total + i32::from(pass) {
            let mut end = ends.last().copied().unwrap_or(0);
            while next < segments.len() && end - now < i32::from(held) {
                let (way, time) = segments[next];
                actions.hand_out(place, place + way, time, mul_div);
                place += way;
                end += i32::from(time);
                ends.push(end);
                next += 1;
            }
            let playing = ends.iter().copied().find(|end| *end > now).unwrap_or(end);
            actions.follow((end - playing) as u16, now < total, now as u16, 1);
            while let Some(action) = actions.take_due(100) {
                done.push((action.output(), now));
            }
            now += i32::from(pass);
        }
        done
    }

    #[test]
    fn one_at_a_boundary_comes_when_the_next_segment_begins() {
        let mut actions = Actions::default();
        actions.begin(0, 0);
        actions.add(Action::new(1, true), 2000, None);
        actions.add(Action::new(2, true), 2500, None);
        actions.add(Action { lead: 5, ..Action::new(3, true) }, 3000, None);
        // The end of all, behind which nothing comes.
        actions.add(Action::new(4, true), 4000, None);
        let done = played(&mut actions, &[(1000, 800); 4], 2400, 10);
        let at = |n: u8| done.iter().find(|own| own.0 == n).map(|own| own.1).expect("carried out");
        assert!((1580..=1610).contains(&at(1)), "{done:?}");
        assert!((1980..=2010).contains(&at(2)), "{done:?}");
        assert!((1880..=1910).contains(&at(3)), "{done:?}");
        assert_eq!(done.len(), 3);
        assert_eq!(actions.flush(None).map(|own| own.output()), Some(4));
        assert!(actions.is_empty());
    }

    #[test]
    fn a_lag_and_a_pulse_are_counted_in_milliseconds() {
        let mut actions = Actions::default();
        actions.begin(0, 0);
        actions.add(Action { lead: -3, pulse: 2, ..Action::new(1, true) }, 0, None);
        assert!(actions.flush(None).is_none());
        let mut seen = Vec::new();
        for ms in 1..=8 {
            actions.tick();
            while let Some(action) = actions.take_due(100) {
                seen.push((ms, action.is_on()));
            }
        }
        assert_eq!(seen, [(3, true), (5, false)]);
        assert!(actions.is_empty());
    }

    #[test]
    fn what_is_dropped_tells_which_pulses_last() {
        let mut actions = Actions::default();
        actions.add(Action { pulse: 9, ..Action::new(5, true) }, 0, None);
        actions.add(Action::new(3, true), 7, None);
        assert!(actions.flush(None).is_some_and(|own| own.is_on() && own.output() == 5));
        assert_eq!(actions.drop_all(), 1 << 4);
        assert!(actions.is_empty() && actions.flush(None).is_none());
    }

    #[test]
    fn those_after_the_end_keep_their_places() {
        let mut actions = Actions::default();
        for at in [900, 1000, 1001] {
            actions.add(Action::new(1, at != 1001), at, None);
            assert!(actions.all_lie_beyond(899));
            assert!(!actions.all_lie_beyond(1000));
        }
        assert!(actions.flush(Some(1000)).is_some() && actions.flush(Some(1000)).is_some());
        assert!(actions.flush(Some(1000)).is_none() && actions.all_lie_beyond(1000));
        assert!(actions.take_off().is_some() && actions.take_off().is_none());
    }

    #[test]
    fn what_switches_off_is_taken_alone() {
        let mut actions = Actions::default();
        actions.add(Action { pulse: 9, ..Action::new(5, true) }, 0, None);
        assert!(actions.flush(None).is_some());
        actions.add(Action::new(3, true), 7, None);
        actions.add(Action { lead: -4, ..Action::new(2, false) }, 7, None);
        let off: Vec<u8> =
            std::iter::from_fn(|| actions.take_off()).map(|own| own.output()).collect();
        assert_eq!(off, [5, 2]);
        assert_eq!(actions.drop_all(), 0);
    }

    #[test]
    fn no_more_than_there_is_room_for_are_taken() {
        let mut actions = Actions::default();
        for n in 0..ROOM {
            assert!(actions.has_room(), "{n}");
            actions.add(Action::new(1, n % 2 == 0), n as u32, None);
        }
        assert!(!actions.has_room());
        let mut count = 0;
        while actions.flush(None).is_some() {
            count += 1;
        }
        assert_eq!(count, ROOM);
    }

    proptest! {
        /// Each comes once, in order at its place, no earlier than half a pass before it and no later than a pass behind it.
        #[test]
        fn all_come_at_their_places(
            segments in prop::collection::vec((1..3000_u32, 100..1500_u16), 1..40),
            places in prop::collection::vec(0..1000_u32, 1..ROOM),
            pass in 1..90_u16,
        ) {
            let all: u32 = segments.iter().map(|own| own.0).sum();
            let places: Vec<u32> = places.iter().map(|part| all * part / 1000).filter(|own| *own < all).collect();
            let mut actions = Actions::default();
            actions.begin(0, 0);
            for (n, place) in places.iter().enumerate() {
                actions.add(Action::new(n as u8 + 1, true), *place, None);
            }
            let done = played(&mut actions, &segments, 2400, pass);
            prop_assert_eq!(done.len(), places.len());
            for (n, at) in done {
                let place = places[usize::from(n) - 1];
                let (mut way, mut time) = (0, 0.0);
                for (um, units) in &segments {
                    let part = (f64::from(place - way) / f64::from(*um)).min(1.0);
                    time += part * f64::from(*units);
                    if part < 1.0 {
                        break;
                    }
                    way += um;
                }
                let off = f64::from(at) - time;
                let late = 2.0 * f64::from(pass) + 2.0;
                prop_assert!((-f64::from(EARLY) - 2.0..=late).contains(&off), "{} off", off);
            }
        }
    }
}
