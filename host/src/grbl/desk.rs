//! State shared by a session and the thread that owns the board: work to do, and the state of the
//! machine.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use lang::fault::Fault;
use lang::wire::RunState;

use super::order::Order;

/// How the machine stands. A session reads nothing else of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct View {
    /// Machine places, motor steps.
    pub steps: [i32; 3],
    /// What the board does; none before the first look.
    pub state: Option<RunState>,
    /// The run is one of this server's.
    pub ours: bool,
    /// An axis moves.
    pub moving: bool,
    /// Axes that know their place.
    pub homed: [bool; 3],
    /// The newest line of the client that has begun, by its number.
    pub begun: u32,
    /// The newest line that is done, with every axis at rest behind it.
    pub done: u32,
    /// Stops that have come to rest.
    pub stops: u32,
    /// Faults so far.
    pub faults: u32,
    /// The newest fault.
    pub fault: Option<Fault>,
    /// Counts stops and faults: lines of an earlier epoch are dropped.
    pub epoch: u32,
    /// Speed along the path, mm/min.
    pub speed: f64,
    /// Inputs that are on, bit n - 1.
    pub inputs: u32,
    /// Limit switches that are on, bit per axis.
    pub limits: u8,
    /// The last probe: places in steps, and the axes that met nothing.
    pub probed: [i32; 3],
    /// Whether it met something.
    pub met: bool,
    /// An input keeps the board from starting; lines wait.
    pub blocked: bool,
    /// Why there is no board, or why it does not take the lines.
    pub trouble: Option<String>,
}

/// Something for the thread that owns the board.
#[derive(Clone, Debug, PartialEq)]
pub enum Deed {
    /// Lines in their order.
    Line {
        /// The number of the client's line.
        number: u32,
        /// The epoch of the view that it was made by.
        epoch: u32,
        /// What it does.
        orders: Vec<Order>,
    },
    /// Pause on a ramp, also what has not begun.
    Hold,
    /// Forget a hold: what it held is over.
    Unhold,
    /// Go on.
    Resume,
    /// End the run on a ramp and forget all lines, and the outputs that wait to be switched.
    Stop,
    /// Per cent of the feed.
    Feed(u16),
    /// Per cent of rapid moves.
    Rapid(u16),
    /// Acknowledge a fault.
    Acknowledge,
    /// An output at once, from 1.
    Coil(u16, bool),
    /// Whether the run stays open without lines: something is switched on that is to stay so.
    Stay(bool),
}

/// What is to be done that is no line.
#[derive(Clone, Debug, Default)]
pub struct Wants {
    /// The machine is to hold.
    pub hold: bool,
    /// A resume has not been carried out.
    pub resume: bool,
    /// Stops that were asked for.
    pub stops: u32,
    /// A fault is to be acknowledged.
    pub acknowledge: bool,
    /// New overrides: feed, rapid.
    pub overrides: [Option<u16>; 2],
    /// Outputs to switch.
    pub coils: VecDeque<(u16, bool)>,
    /// See [`Deed::Stay`].
    pub stay: bool,
    /// The server ends.
    pub closing: bool,
}

impl Wants {
    /// Whether something is to be done at once.
    pub fn is_urgent(&self, stops: u32) -> bool {
        self.resume
            || self.acknowledge
            || self.closing
            || self.stops != stops
            || !self.coils.is_empty()
            || self.overrides.iter().any(Option::is_some)
    }
}

#[derive(Default)]
struct State {
    wants: Wants,
    lines: VecDeque<(u32, u32, Vec<Order>)>,
    view: View,
}

/// See the module.
#[derive(Default)]
pub struct Desk {
    state: Mutex<State>,
    called: Condvar,
}

impl Desk {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes what a session wants.
    pub fn take(&self, deeds: Vec<Deed>) {
        if deeds.is_empty() {
            return;
        }
        let mut state = self.state();
        for deed in deeds {
            let State { wants, lines, .. } = &mut *state;
            match deed {
                Deed::Line { number, epoch, orders } => lines.push_back((number, epoch, orders)),
                Deed::Hold => wants.hold = true,
                Deed::Unhold => wants.hold = false,
                Deed::Resume => (wants.hold, wants.resume) = (false, true),
                Deed::Stop => {
                    lines.clear();
                    wants.coils.clear();
                    (wants.hold, wants.resume) = (false, false);
                    wants.stops += 1;
                }
                Deed::Feed(percent) => wants.overrides[0] = Some(percent),
                Deed::Rapid(percent) => wants.overrides[1] = Some(percent),
                Deed::Acknowledge => wants.acknowledge = true,
                // Only the last state of an output counts: a stop must not wait for a long row of writes.
                Deed::Coil(n, on) => {
                    wants.coils.retain(|(own, _)| *own != n);
                    wants.coils.push_back((n, on));
                }
                Deed::Stay(stay) => wants.stay = stay,
            }
        }
        self.called.notify_all();
    }

    /// The server ends: nothing more comes.
    pub fn close(&self) {
        self.state().wants.closing = true;
        self.called.notify_all();
    }

    /// How the machine stands.
    pub fn view(&self) -> View {
        self.state().view.clone()
    }

    /// Changes how the machine stands, all at once.
    pub fn show(&self, change: impl FnOnce(&mut View)) {
        change(&mut self.state().view);
    }

    /// What is wanted beside lines.
    pub fn wants(&self) -> Wants {
        self.state().wants.clone()
    }

    /// Marks what is wanted as done.
    pub fn settle(&self, change: impl FnOnce(&mut Wants)) {
        change(&mut self.state().wants);
    }

    /// The next lines, at most `most` of them. Waits for the first one, or for something else that is
    /// wanted, at most as long as `wait`. Lines of another epoch are dropped.
    pub fn lines(&self, most: usize, stops: u32, wait: Duration) -> Vec<(u32, Vec<Order>)> {
        let mut state = self.state();
        if state.lines.is_empty() && !state.wants.is_urgent(stops) && !wait.is_zero() {
            state = self.called.wait_timeout(state, wait).unwrap_or_else(PoisonError::into_inner).0;
        }
        let epoch = state.view.epoch;
        let mut list = Vec::new();
        while list.len() < most
            && let Some((number, own, orders)) = state.lines.pop_front()
        {
            if own == epoch {
                list.push((number, orders));
            }
        }
        list
    }

    /// Waits for a line or for something that is wanted at once, at most so long.
    pub fn lines_wait(&self, stops: u32, wait: Duration) {
        let state = self.state();
        if state.lines.is_empty() && !state.wants.is_urgent(stops) {
            drop(self.called.wait_timeout(state, wait));
        }
    }

    /// Whether lines wait.
    pub fn has_lines(&self) -> bool {
        !self.state().lines.is_empty()
    }

    /// Forgets all lines that wait.
    pub fn forget(&self) {
        self.state().lines.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::{Deed, Desk};

    #[test]
    fn a_stop_forgets_outputs_that_were_to_be_switched_before_it() {
        let desk = Desk::default();
        desk.take(vec![Deed::Coil(3, true), Deed::Stop, Deed::Coil(2, false)]);
        assert_eq!(desk.wants().coils, [(2, false)]);
        for on in [true, false, true] {
            desk.take(vec![Deed::Coil(3, on)]);
        }
        assert_eq!(desk.wants().coils, [(2, false), (3, true)], "the last state of each");
    }
}
