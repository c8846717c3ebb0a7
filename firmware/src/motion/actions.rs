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
//! A lag, and the length of a pulse, are counted in milliseconds, in a pause too; but a pulse that the pause keeps off
//! goes on after it. Each output has one pulse at most that lasts: the newest command on it counts. A list that is full
//! lets the program wait, and with it the path slows down on its ramps; actions at one place are carried out in the order of their
//! statements, each at the pins before the next.

/// Actions that are known.
pub const ROOM: usize = 6;
/// Longest lead that is a time, ms: the engine holds no more.
pub const MOST_LEAD: i32 = lang::part::SYNC_LEAD_MS;
/// Longest lag and longest pulse, ms.
pub const MOST_MS: i32 = lang::part::SYNC_MS;
/// Longest lead or lag along the path, um.
pub const MOST_WAY: i32 = lang::part::SYNC_WAY;
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

/// [`Action::what`]: the output goes on; an analog one gets another value than its safe one.
const ON: u8 = 1 << 7;
/// [`Action::what`]: an analog output.
const ANALOG: u8 = 1 << 6;

impl Action {
    /// Output `n`, from 1, goes on or off.
    pub fn new(n: u8, on: bool) -> Action {
        Action { what: n | if on { ON } else { 0 }, ..Action::default() }
    }

    /// Analog output `n`, from 1, gets a value, `on` unless that is the safe one.
    pub fn analog(n: u8, value: u16, on: bool) -> Action {
        Action { pulse: value, ..Action::new(n | ANALOG, on) }
    }

    /// It is one of an analog output, [`Action::pulse`] its value.
    pub fn is_analog(&self) -> bool {
        self.what & ANALOG != 0
    }

    /// Number of the output, from 1.
    pub fn output(&self) -> u8 {
        self.what & !(ON | ANALOG)
    }

    /// The same as a bit: number n is bit n - 1.
    pub fn bit(&self) -> u16 {
        1 << (self.output().wrapping_sub(1) & 15)
    }

    /// It goes on, [`Action::analog`] says what that is of an analog one.
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

    /// Outputs, number n in bit n - 1, are switched by something else from now on: the ends of pulses that last there are
    /// forgotten.
    #[inline(never)]
    pub fn take_over(&mut self, outputs: u16) {
        let mut n = self.count;
        while n != 0 {
            n -= 1;
            let action = &self.list[usize::from(n)];
            if action.waits == Waits::Pulse && outputs & action.bit() != 0 {
                self.remove(n.into());
            }
        }
    }

    /// The newest command on an output counts: a pulse that lasts there is forgotten.
    #[inline(never)]
    fn carry_out(&mut self, n: usize) -> Action {
        let action = self.list[n];
        self.remove(n);
        if action.is_analog() {
            return action;
        }
        self.take_over(action.bit());
        if action.pulse != 0
            && action.is_on()
            && let Some(free) = self.list.get_mut(usize::from(self.count))
        {
            *free = Action {
                what: action.output(),
                at: action.pulse.into(),
                waits: Waits::Pulse,
                ..action
            };
            self.count += 1;
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

    /// A millisecond of lags and pulses. Pulses of the outputs `held`, number n in bit n - 1, wait: a pause keeps them off.
    pub fn tick(&mut self, held: u16) {
        for action in self.known() {
            let counts = match action.waits {
                Waits::Lag => true,
                Waits::Pulse => held & action.bit() == 0,
                _ => false,
            };
            if counts && action.at != 0 {
                action.at -= 1;
            }
        }
    }

    /// Drops all; gives the outputs, number n in bit n - 1, that pulses keep on.
    pub fn drop_all(&mut self) -> u16 {
        let mut on = 0;
        for action in self.known() {
            if action.waits == Waits::Pulse {
                on |= action.bit();
            }
        }
        self.count = 0;
        on
    }
}

#[cfg(test)]
mod tests;
