//! What may come between two statements: ON IN, ON EVERY, a fault that comes by itself.

use lang::fault::Fault;

use crate::sim::step::Step;

/// ON IN or ON EVERY.
#[derive(Clone, Copy, Debug)]
pub struct Slot {
    /// Input and edge; `None` for ON EVERY.
    pub input: Option<(i32, bool)>,
    /// Next tick, us of the run clock.
    pub tick: Option<u64>,
    /// From tick to tick, us.
    pub period_us: u64,
    /// It has happened and waits to be served.
    pub pending: bool,
}

/// See the module.
#[derive(Debug, Default)]
pub struct Events {
    slots: [Option<Slot>; 4],
    /// A fault that came by itself.
    pub late: Option<Fault>,
    /// A handler is open: no other comes between.
    in_handler: bool,
    /// A larger statement is under way: no handler comes between.
    held: bool,
    /// Something but the clock must be looked at before the next statement.
    pub attention: bool,
}

impl Events {
    /// Whether a handler may come now.
    pub fn may_interrupt(&self) -> bool {
        !self.in_handler && !self.held
    }

    /// Whether handlers must wait for the end of a larger statement.
    pub fn hold(&mut self, hold: bool) {
        self.held = hold;
        self.attention = true;
    }

    /// Whether a handler is open now.
    pub fn set_in_handler(&mut self, open: bool) {
        self.in_handler = open;
        self.attention = true;
    }

    /// A fault comes by itself: an axis that ran by MoveSpeed stands at its soft limit.
    pub fn fail_late(&mut self) {
        self.late = Some(Fault::SoftLimit);
        self.attention = true;
    }

    /// What asks for a handler.
    pub fn interruption(&self) -> Option<Step> {
        self.late.map(Step::Late).or_else(|| self.pending_slot().map(Step::Event))
    }

    /// What asked for a handler gets it.
    pub fn take(&mut self, step: Step) {
        match step {
            Step::Event(slot) => {
                if let Some(slot) = self.slots.get_mut(usize::from(slot)).and_then(Option::as_mut) {
                    slot.pending = false;
                }
            }
            Step::Late(_) => self.late = None,
            _ => {}
        }
    }

    /// The first slot whose event waits to be served.
    pub fn pending_slot(&self) -> Option<u8> {
        let pending = |slot: &Option<Slot>| slot.is_some_and(|slot| slot.pending);
        self.slots.iter().position(pending).map(|slot| slot as u8)
    }

    /// When ON EVERY ticks next, us of the run clock.
    pub fn next_tick(&self) -> Option<u64> {
        self.slots.iter().flatten().filter_map(|slot| slot.tick).min()
    }

    /// An input changed: its events are remembered once.
    pub fn input(&mut self, n: i32, on: bool) {
        for slot in self.slots.iter_mut().flatten() {
            if slot.input == Some((n, on)) {
                slot.pending = true;
                self.attention = true;
            }
        }
    }

    /// Ticks that are due at `run` of the run clock are remembered once each.
    pub fn tick(&mut self, run: u64) {
        for slot in self.slots.iter_mut().flatten() {
            while let Some(tick) = slot.tick.filter(|tick| *tick <= run) {
                slot.tick = Some(tick + slot.period_us);
                slot.pending = true;
                self.attention = true;
            }
        }
    }

    /// ON IN n OFF.
    pub fn off_input(&mut self, n: i32) {
        for slot in &mut self.slots {
            if slot.is_some_and(|slot| slot.input.is_some_and(|(input, _)| input == n)) {
                *slot = None;
            }
        }
    }

    /// ON EVERY OFF.
    pub fn off_every(&mut self) {
        for slot in &mut self.slots {
            if slot.is_some_and(|slot| slot.tick.is_some()) {
                *slot = None;
            }
        }
    }

    /// ON IN, ON EVERY: `slot` waits for this from now on.
    pub fn set(&mut self, slot: u8, to: Slot) {
        if let Some(place) = self.slots.get_mut(usize::from(slot)) {
            *place = Some(to);
        }
    }
}
