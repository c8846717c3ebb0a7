//! A simulated MSP430F5529 for the desktop: the hardware under the firmware's machine (`firmware::machine`) when there is no
//! board.
//!
//! A [`Desk`] is a handle to one simulated chip: its memory, its pins with the plant around them, its step engine,
//! and its clock. Time passes only by [`Desk::spend`]: the machine's own computing takes no simulated time, and [`cost`]
//! states what the chip would need for it.

pub mod board;
pub mod cost;
pub mod driven;
mod engine;
mod memory;
mod pins;
mod port;
mod power;
mod steps;

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::Rc;

use emulator::Plant;
use emulator::plant::pins::Pins;
use firmware::machine::chip::{Chip, Clock, Observed};
use lang::part::{F5529, Part};
use lang::wire::{Seen, TraceKind};

use self::engine::Engine;
use self::memory::Memory;

/// Ticks of the step timer in a microsecond.
pub const PER_US: u64 = F5529.clock as u64 / 1_000_000;
/// Ticks of the step timer in a millisecond.
pub const PER_MS: u64 = 1_000 * PER_US;

/// What an observer sees.
#[derive(Clone, Copy, Debug)]
pub enum Sight {
    /// An event of the trace: kind, argument, value, and commanded places in steps.
    Event(TraceKind, u8, i32, [i32; 3]),
    /// Something that is no event; the byte is that of [`Seen::Byte`].
    Beside(Seen, u8),
}

/// Something that was seen.
#[derive(Clone, Copy, Debug)]
pub struct Noticed {
    /// When, in ticks of the step timer since power-up.
    pub tick: u64,
    /// Address of its statement in the code.
    pub pc: u16,
    /// What.
    pub sight: Sight,
}

/// Pins that stop the engine by themselves.
#[derive(Clone, Copy, Debug, Default)]
struct Guarded {
    /// Pins of the port of inputs that answer, and inputs of the chain.
    pins: u8,
    inputs: u16,
    /// Pins that answer when they go low, and inputs of the chain that are on when low.
    falling: u8,
    invert: u16,
    /// What has answered: pins, 1 for inputs of the chain.
    tripped: u8,
    answered: u16,
}

/// A simulated chip.
struct State {
    memory: RefCell<Memory>,
    engine: RefCell<Engine>,
    plant: RefCell<Plant>,
    /// Where the pins are, and ticks of the plant in one of the step timer.
    pins: Pins,
    /// See `pins`.
    unit: u64,
    guard: Cell<Guarded>,
    /// Levels of the chip's pins, as [`emulator::plant::Pins`] counts them.
    levels: Cell<u64>,
    /// When the STEP pins fall again, in ticks of the step timer.
    falls: Cell<[Option<u64>; 3]>,
    /// Width of a step pulse, and the time from a change of DIR to the next one, ticks.
    pulse: Cell<u64>,
    /// See `pulse`.
    setup: Cell<u64>,
    /// When the DIR pins take new levels, ticks, and which: bit per axis that moves in negative direction.
    turn: Cell<Option<(u64, u8)>>,
    /// Pins whose level is the other one than here: STEP pins that are low while they step.
    turned: Cell<u64>,
    /// Axes whose positive direction is low, as bits of their DIR pins.
    invert: Cell<u8>,
    /// Time since power-up, ticks of the step timer.
    now: Cell<u64>,
    /// Time at the last reset.
    reset: Cell<u64>,
    /// A program runs, over any reset but power-up.
    marked: Cell<bool>,
    power: power::Power,
    seen: RefCell<VecDeque<Noticed>>,
    /// The program whose flow is an engine's, if there is one.
    driven: RefCell<Option<driven::Driven>>,
}

/// See the module.
#[derive(Clone)]
pub struct Desk(Rc<State>);

impl Desk {
    /// A chip whose flash is erased, with a plant around it.
    pub fn new(plant: Plant) -> Desk {
        Desk(Rc::new(State {
            memory: RefCell::new(Memory::new()),
            engine: RefCell::default(),
            pins: *plant.board(),
            unit: plant.ticks_per_second() / u64::from(F5529.clock),
            plant: RefCell::new(plant),
            guard: Cell::default(),
            levels: Cell::new(0),
            falls: Cell::default(),
            pulse: Cell::new(3 * PER_US),
            setup: Cell::new(0),
            turn: Cell::new(None),
            turned: Cell::new(0),
            invert: Cell::new(0),
            now: Cell::new(0),
            reset: Cell::new(0),
            marked: Cell::new(false),
            power: power::Power::default(),
            seen: RefCell::default(),
            driven: RefCell::default(),
        }))
    }

    /// Time since power-up, ticks of the step timer.
    pub fn ticks(&self) -> u64 {
        self.0.now.get()
    }

    /// What was seen since the last call.
    pub fn take_seen(&self) -> VecDeque<Noticed> {
        self.0.seen.take()
    }

    /// Lets ticks of the step timer pass: steps are made, pins that stop them are looked at.
    pub fn spend(&self, ticks: u64) {
        self.play(self.0.now.get() + ticks, false);
    }

    fn play(&self, end: u64, to_change: bool) {
        let end = self.play_until(end, to_change);
        let from = self.0.now.replace(end);
        if from / PER_MS != end / PER_MS {
            self.look_at_chain();
        }
    }

    /// Segments that the step engine has taken or ended: see [`Engine::changes`].
    fn changes(&self) -> u32 {
        self.0.engine.borrow().changes
    }

    /// Highest rate of steps of the path since [`Desk::forget_rate`], steps/s.
    pub fn top_rate(&self) -> f64 {
        match self.0.engine.borrow().shortest {
            0 => 0.0,
            shortest => f64::from(F5529.clock) * 65_536.0 / f64::from(shortest),
        }
    }

    /// See [`Desk::top_rate`].
    pub fn forget_rate(&self) {
        self.0.engine.borrow_mut().shortest = 0;
    }

    /// Lets time pass to a time, ticks, or to where a segment of the step engine ends or is cut.
    pub fn spend_to_change(&self, end: u64) {
        if self.ticks() < end {
            self.play(end, true);
        }
    }

    fn notice(&self, pc: u16, sight: Sight) {
        self.0.seen.borrow_mut().push_back(Noticed { tick: self.0.now.get(), pc, sight });
    }
}

impl Clock for Desk {
    const PER_MS: u16 = (F5529.clock / 8_000) as u16;
    const RATE: u32 = F5529.clock;

    fn millis(&self) -> u16 {
        ((self.0.now.get() - self.0.reset.get()) / PER_MS) as u16
    }
    fn look_after_clock(&self) {}
    fn now(&self) -> u16 {
        (self.0.now.get() / 8) as u16
    }
    fn clock_fault(&self) -> u8 {
        0
    }
    fn mark(&self, runs: bool) {
        self.0.marked.set(runs);
    }
    fn is_marked(&self) -> bool {
        self.0.marked.get()
    }
    /// There is no stack to measure: that of the F5529 is told of an emulated board only.
    fn stack_free(&self) -> u16 {
        0
    }
}

impl Observed for Desk {
    fn event(&self, kind: u8, argument: u8, value: i32, commanded: &[i32; 3], pc: u16) {
        if let Some(kind) = TraceKind::from_number(kind.into()) {
            self.notice(pc, Sight::Event(kind, argument, value, *commanded));
        }
    }
    fn beside(&self, what: Seen, byte: u8, pc: u16) {
        self.notice(pc, Sight::Beside(what, byte));
    }
}

impl Chip for Desk {
    const PART: Part = F5529;
    const AREA: u16 = memory::AREA;
    const LOG: u16 = memory::LOG;
}
