//! What stands around the machine and acts on its inputs by where the motors are: a cell with things in it.
//!
//! The plant calls it at the very step, output edge or time at which something can change there, and at no other: until
//! a motor leaves the quiet box of the last [`Reply`], a step costs two comparisons.

use std::sync::{Arc, Mutex, PoisonError};

use super::Plant;

/// Why the plant calls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// A motor has left the quiet box.
    Moved,
    /// Output `n` (from 1) has changed its level.
    Output(u8, bool),
    /// The time of [`Reply::due`] has come.
    Time,
}

/// What holds until the next call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reply {
    /// Least and greatest position of each motor, steps, between which nothing changes.
    pub quiet: [[i64; 2]; 3],
    /// When it must be called at the latest, ticks.
    pub due: Option<u64>,
    /// Inputs that are on, input `n` in bit `n - 1`.
    pub inputs: u32,
    /// Whether Start is pressed.
    pub start: bool,
    /// Whether Stop is pressed.
    pub stop: bool,
    /// Voltages that it gives to analog inputs, mV; `None` leaves an input to others.
    pub analog: [Option<u16>; 4],
}

impl Default for Reply {
    /// Nothing ever changes.
    fn default() -> Self {
        Self {
            quiet: [[i64::MIN, i64::MAX]; 3],
            due: None,
            inputs: 0,
            start: false,
            stop: false,
            analog: [None; 4],
        }
    }
}

/// Who is called.
pub trait Around: Send {
    /// Something has changed at a time in ticks; the motors stand at these steps from power-up.
    fn change(&mut self, tick: u64, what: Change, motors: [i64; 3]) -> Reply;
}

/// Who listens, and what was answered.
#[derive(Clone, Default)]
pub(super) struct Listener {
    who: Option<Arc<Mutex<dyn Around>>>,
    reply: Reply,
    calls: u32,
}

impl Listener {
    pub(super) fn inputs(&self) -> u32 {
        self.reply.inputs
    }

    pub(super) fn analog(&self) -> [Option<u16>; 4] {
        self.reply.analog
    }

    pub(super) fn buttons(&self) -> [bool; 2] {
        [self.reply.start, self.reply.stop]
    }

    /// The quiet box of the last reply.
    pub(super) fn quiet(&self) -> [[i64; 2]; 3] {
        self.reply.quiet
    }

    /// Whether a motor has left the quiet box.
    pub(super) fn leaves(&self, axis: usize, position: i64) -> bool {
        let [least, greatest] = self.reply.quiet[axis];
        position < least || position > greatest
    }
}

impl Plant {
    /// From now on `who` is around the machine; it is asked at once. `None`: nobody, all that it did is undone.
    pub fn surround(&mut self, now: u64, who: Option<Arc<Mutex<dyn Around>>>) {
        let calls = self.around.calls;
        self.around = Listener { who, reply: Reply::default(), calls };
        self.tell(now, Change::Time);
    }

    /// Whoever is around the machine has changed by itself, or was changed from outside: it is asked again.
    pub fn ask_around(&mut self, now: u64) {
        self.tell(now, Change::Time);
    }

    /// Voltages at the analog inputs, mV: those of whoever is around the machine, else those of [`Plant::analog`].
    #[must_use]
    #[inline]
    pub fn volts(&self) -> [u16; 4] {
        let around = self.around.analog();
        std::array::from_fn(|n| around[n].unwrap_or(self.analog[n]))
    }

    /// How often whoever is around the machine was called: as long as it stays, nothing has changed there.
    #[must_use]
    #[inline]
    pub fn calls_around(&self) -> u32 {
        self.around.calls
    }

    /// When something changes around the machine by itself, ticks.
    #[must_use]
    #[inline]
    pub fn due(&self) -> Option<u64> {
        self.around.reply.due
    }

    /// Time has come so far: what is due around the machine by then happens, each at its tick.
    #[inline]
    pub fn pass(&mut self, now: u64) {
        while let Some(due) = self.around.reply.due.filter(|&due| due <= now) {
            self.tell(due, Change::Time);
            if self.around.reply.due == Some(due) {
                // Whoever is due twice at one tick would never let time go on.
                self.around.reply.due = Some(due + 1);
            }
        }
    }

    pub(super) fn tell(&mut self, now: u64, what: Change) {
        let Some(who) = &self.around.who else { return };
        let motors = [0, 1, 2].map(|axis| self.motors[axis].position);
        let mut who = who.lock().unwrap_or_else(PoisonError::into_inner);
        self.around.calls = self.around.calls.wrapping_add(1);
        self.around.reply = who.change(now, what, motors);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::Wiring;

    /// An input that is on from step 3 of X, for 10 ticks.
    #[derive(Default)]
    struct Wall {
        calls: Vec<(u64, Change)>,
        off: Option<u64>,
    }

    impl Around for Wall {
        fn change(&mut self, tick: u64, what: Change, [x, ..]: [i64; 3]) -> Reply {
            self.calls.push((tick, what));
            if what == Change::Moved && x == 3 {
                self.off = Some(tick + 10);
            }
            let on = self.off.is_some_and(|off| tick < off);
            let quiet = [if x < 3 { [i64::MIN, 2] } else { [3, i64::MAX] }, [0, 0], [0, 0]];
            Reply {
                quiet,
                due: self.off.filter(|_| on),
                inputs: u32::from(on) << 4,
                ..Reply::default()
            }
        }
    }

    #[test]
    fn it_is_called_where_something_changes_and_nowhere_else() {
        let mut plant = Plant::new(Wiring::Chain);
        let wall = Arc::new(Mutex::new(Wall::default()));
        plant.surround(0, Some(wall.clone()));
        let (step, dir) = (plant.board().step[0], plant.board().dir[0]);
        for n in 1..=5u64 {
            plant.pins(n * 100, 1 << dir | 1 << step);
            assert_eq!(plant.input(5), n == 3, "step {n}");
            plant.pins(n * 100 + 50, 1 << dir);
            assert!(!plant.input(5));
        }
        let calls = wall.lock().unwrap().calls.clone();
        assert_eq!(calls, [(0, Change::Time), (300, Change::Moved), (310, Change::Time)]);
        plant.surround(600, None);
        assert_eq!(plant.due(), None);
    }
}
