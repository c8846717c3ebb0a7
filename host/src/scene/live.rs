//! A cell in the plant around a board's pins: called at the step, edge or time at which something changes.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use cell::kernel::{Action, Cell, Frame};
use cell::law::{Rest, Steps};
use cell::log::What;
use emulator::plant::around::{Around, Change, Reply};
use lang::profile::{InputRole, Profile};

use super::Scene;
use crate::sim::world::{Found, Things};

/// Calls of a cell within one microsecond before time goes on: no cell settles so slowly.
const MOST_CALLS: usize = 1_000;

/// What only a host on the link can do for a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HostDeed {
    /// The emergency stop: no input has that role.
    EmergencyStop,
    /// Give the AT variable at a register a value.
    Register(u16, i32),
    /// A motor loses steps.
    Stall(usize, i32),
    /// Pause the run, or resume it.
    Pause(bool),
    /// End the client: nothing comes over the link any more, from the world neither.
    Gone,
}

/// A cell that runs.
pub struct Live {
    cell: Cell,
    /// Tick of the cell's time 0; `None` until the run begins.
    zero: Option<u64>,
    per_us: u64,
    /// Outputs whose level is low when they are on, output `n` in bit `n - 1`.
    inverted: u32,
    /// The host's client has ended.
    client_gone: bool,
    /// Outputs that are on.
    on: u32,
    /// The input of the emergency stop.
    emergency: Option<u32>,
    /// The input of the safety door.
    door: Option<u32>,
    reply: Reply,
    /// What people and faults do at time 0: it waits until the run begins.
    first: Vec<Action>,
    /// Inputs that the cell gives, input `n` in bit `n - 1`; the reply has those that a world lets through.
    inputs: u32,
    /// Inputs that hang: which, and those that are on.
    forced: [u32; 2],
    /// Events of the log that were looked at for things that were taken.
    told: usize,
    /// Edges of inputs since they were taken: tick, number, state.
    edges: Vec<(u64, i32, bool)>,
    deeds: Vec<HostDeed>,
}

/// A [`Live`] that a plant and a rig share.
#[derive(Clone)]
pub struct Shared(Arc<Mutex<Live>>);

impl Shared {
    /// A cell around a machine; `per_us` are the plant's ticks in a microsecond.
    #[must_use]
    pub fn new(scene: &Scene, frame: Frame, profile: &Profile, per_us: u64) -> Self {
        let mut inverted = 0;
        for output in profile.outputs.iter().filter(|output| output.invert) {
            inverted |= bit(u32::try_from(output.n).unwrap_or(0));
        }
        let input = |role| u32::try_from(profile.input_with(role)?.n).ok();
        let emergency = input(InputRole::EmergencyStop);
        let door = input(InputRole::Door);
        let mut cell = Cell::new(scene.cell.clone(), frame);
        cell.strike(&scene.deviations);
        Self(Arc::new(Mutex::new(Live {
            cell,
            zero: None,
            per_us: per_us.max(1),
            inverted,
            client_gone: false,
            on: 0,
            emergency,
            door,
            reply: Reply::default(),
            first: Vec::new(),
            inputs: 0,
            forced: [0; 2],
            told: 0,
            edges: Vec::new(),
            deeds: Vec::new(),
        })))
    }

    /// The same for a plant.
    #[must_use]
    pub fn around(&self) -> Arc<Mutex<dyn Around>> {
        self.0.clone()
    }

    /// The cell.
    pub fn get(&self) -> MutexGuard<'_, Live> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Things for Shared {
    fn where_is(&self, name: &str, motors: [i64; 3]) -> Option<Found> {
        let live = self.get();
        let thing = live.cell.things().iter().find(|thing| thing.name == name)?;
        Some(Found::of(live.cell.scene(), &thing.place, live.cell.tip(&steps(motors))))
    }

    fn hands(&self, name: &str, puts: bool, us: u64, motors: [i64; 3]) {
        self.get().cell.hands(name, puts, &steps(motors), us);
    }

    fn force(&self, n: i32, on: Option<bool>) {
        self.get().force(n, on);
    }
}

fn bit(n: u32) -> u32 {
    if (1..=32).contains(&n) { 1 << (n - 1) } else { 0 }
}

/// Motors as the cell counts them; it has a fourth axis, which no machine has yet.
fn steps(motors: [i64; 3]) -> Steps {
    let [x, y, z] = motors.map(|at| at.clamp(i32::MIN.into(), i32::MAX.into()) as i32);
    [x, y, z, 0]
}

impl Live {
    /// The cell's time begins at a tick. The plant must ask again.
    pub fn begin(&mut self, tick: u64, motors: [i64; 3]) {
        self.zero = Some(tick);
        for n in 1..=16 {
            if self.on & bit(n) != 0 {
                self.cell.output(n, true, &Rest(steps(motors)), 0);
            }
        }
        for action in std::mem::take(&mut self.first) {
            self.act(tick, action);
        }
    }

    /// The cell, to be judged.
    #[must_use]
    pub fn cell(&self) -> &Cell {
        &self.cell
    }

    /// See [`Live::cell`].
    pub fn cell_mut(&mut self) -> &mut Cell {
        &mut self.cell
    }

    /// Whether the run is to end at once: something has collided.
    #[must_use]
    pub fn must_end(&self) -> bool {
        self.cell.must_end()
    }

    /// Outputs that are on.
    #[must_use]
    pub fn outputs_on(&self) -> Vec<u32> {
        (1..=16).filter(|&n| self.on & bit(n) != 0).collect()
    }

    /// Edges of inputs since the last call: tick, number, state.
    pub fn take_edges(&mut self) -> Vec<(u64, i32, bool)> {
        std::mem::take(&mut self.edges)
    }

    /// Voltages as they are now.
    fn look_at_voltages(&mut self, at: &Steps, us: u64) {
        for (n, mv) in self.cell.voltages(at, us) {
            if let Some(input) =
                n.checked_sub(1).and_then(|n| self.reply.analog.get_mut(n as usize))
            {
                *input = Some(mv);
            }
        }
    }

    /// What the host has to do since the last call.
    pub fn take_deeds(&mut self) -> Vec<HostDeed> {
        std::mem::take(&mut self.deeds)
    }

    /// Whether the host has something to do.
    #[must_use]
    pub fn has_deeds(&self) -> bool {
        !self.deeds.is_empty()
    }

    fn us(&self, tick: u64) -> u64 {
        self.zero.map_or(0, |zero| tick.saturating_sub(zero) / self.per_us)
    }

    fn act(&mut self, tick: u64, action: Action) {
        // Inputs come through their filters before the run begins. A button that is pressed before then keeps the
        // program from its start.
        if self.zero.is_none() && !matches!(action, Action::Input(..)) {
            self.first.push(action);
            return;
        }
        match action {
            Action::Input(n, on) => self.input(tick, n, on),
            Action::Start(down) => self.reply.start = down,
            Action::Stop(down) => self.reply.stop = down,
            Action::Emergency(down) => match self.emergency {
                Some(n) => self.input(tick, n, down),
                None if down && !self.client_gone => self.deeds.push(HostDeed::EmergencyStop),
                None => {}
            },
            Action::Register(register, value) => {
                if let Ok(register) = u16::try_from(register)
                    && !self.client_gone
                {
                    self.deeds.push(HostDeed::Register(register, value));
                }
            }
            Action::Pause(pauses) => self.deeds.push(HostDeed::Pause(pauses)),
            Action::Door(open) => {
                if let Some(n) = self.door {
                    self.input(tick, n, open);
                }
            }
            // Without a door nothing has stopped that would go on.
            Action::Resume(down) => self.reply.start = down && self.door.is_some(),
            Action::Gone => {
                self.client_gone = true;
                self.deeds.push(HostDeed::Gone);
            }
            Action::Stall(axis, count) => self.deeds.push(HostDeed::Stall(axis, count)),
        }
    }

    fn input(&mut self, tick: u64, n: u32, on: bool) {
        self.inputs = if on { self.inputs | bit(n) } else { self.inputs & !bit(n) };
        let own = self.inputs & bit(n) & !self.forced[0];
        if own != self.reply.inputs & bit(n) & !self.forced[0] {
            self.reply.inputs ^= bit(n);
            self.edges.push((tick, i32::try_from(n).unwrap_or(0), on));
        }
    }

    /// An input hangs in a state whatever the cell gives, or no more.
    fn force(&mut self, n: i32, on: Option<bool>) {
        let own = u32::try_from(n).map_or(0, bit);
        let [which, states] = &mut self.forced;
        *which = if on.is_some() { *which | own } else { *which & !own };
        *states = if on == Some(true) { *states | own } else { *states & !own };
        self.reply.inputs = self.inputs & !*which | *states;
    }

    /// Things that were taken since the last call.
    pub fn take_taken(&mut self) -> Vec<String> {
        let log = self.cell.log();
        let new = log.get(self.told..).unwrap_or_default();
        self.told = log.len();
        let taken = new.iter().filter_map(|event| match &event.what {
            What::Take { thing, .. } => Some(thing.clone()),
            _ => None,
        });
        taken.collect()
    }
}

impl Around for Live {
    fn change(&mut self, tick: u64, what: Change, motors: [i64; 3]) -> Reply {
        let at = steps(motors);
        let us = self.us(tick);
        if let Change::Output(n, level) = what {
            let own = bit(n.into());
            let on = level != (self.inverted & own != 0);
            self.on = if on { self.on | own } else { self.on & !own };
            if self.zero.is_some() {
                self.cell.output(n.into(), on, &Rest(at), us);
            }
        }
        for _ in 0..MOST_CALLS {
            for action in self.cell.advance(&Rest(at), us) {
                self.act(tick, action);
            }
            if self.cell.due(&at, us) != Some(us) {
                break;
            }
        }
        self.look_at_voltages(&at, us);
        // Until the run begins nothing moves, and no time passes.
        let Some(zero) = self.zero else {
            return Reply { due: None, quiet: Reply::default().quiet, ..self.reply };
        };
        let quiet = self.cell.quiet_box(&at);
        let bounds = |axis: usize| {
            let low = if quiet.low[axis] == i32::MIN { i64::MIN } else { quiet.low[axis].into() };
            let high =
                if quiet.high[axis] == i32::MAX { i64::MAX } else { quiet.high[axis].into() };
            [low, high]
        };
        self.reply.quiet = [0, 1, 2].map(bounds);
        let due = self.cell.due(&at, us + 1);
        self.reply.due = due.map(|us| zero.saturating_add(us.saturating_mul(self.per_us)));
        self.reply
    }
}
