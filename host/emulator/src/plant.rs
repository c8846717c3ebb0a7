//! The plant: everything around the chip's pins that the pin table of the board names.
//!
//! Electrical conventions: contacts at pins (Start, Stop, probe, and all inputs of the `direct`
//! wiring) close to ground, so "on" is a low level; the 74HC165 inputs of the `chain` wiring are
//! high when on. `set_active_low` changes that for single inputs. STEP, DIR and outputs at
//! pins have pull-down resistors; latch and output enable of the shift registers are pulled up.

pub mod around;
pub mod chain;
mod jumper;
pub mod motor;
mod outside;
pub mod pins;
mod quiet;

pub use around::{Around, Reply};
pub use jumper::Jumper;

use std::collections::VecDeque;

use crate::part::Part;
use crate::record::{Recorder, Signal};
use crate::rng::Rng;
use chain::Chain;
use motor::{DriverLimits, Motor, Violation};
use pins::{Pins, high};

/// What hangs on the pins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wiring {
    /// Switches and outputs at the pins themselves.
    Direct,
    /// Shift registers on the SPI.
    #[default]
    Chain,
}

/// A contact that closes at a place of an axis and beyond it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Contact {
    /// Axis number, 0 for X.
    pub axis: usize,
    /// Position in steps where it closes, in the motor's own count from power-up.
    pub position: i64,
    /// Closed at larger positions; else at smaller ones.
    pub above: bool,
}

impl Contact {
    fn closed(&self, motors: &[Motor; 3]) -> bool {
        motors.get(self.axis).is_some_and(|m| {
            if self.above { m.position >= self.position } else { m.position <= self.position }
        })
    }
}

/// A change of an output as the world sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OutputChange {
    /// When, in ticks.
    pub cycle: u64,
    /// Output number, from 1.
    pub output: u8,
    /// Its new state.
    pub on: bool,
}

/// External conditions at the pins, pin by pin as `pins` numbers them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Drives {
    /// Pins that are driven from outside.
    pub driven: u64,
    /// Their levels.
    pub level: u64,
    /// Levels at pins that nobody drives and that have no pull resistor of the chip.
    pub rest: u64,
    /// Open contacts: undefined without the chip's pull resistor.
    pub open: u64,
}

/// Violations and output changes that are kept.
const KEPT: usize = 10_000;

/// The world around the pins.
#[derive(Clone)]
pub struct Plant {
    wiring: Wiring,
    board: Pins,
    ticks_per_second: u64,
    /// Axes X, Y, Z.
    pub motors: [Motor; 3],
    /// Reference switches X, Y, Z.
    pub switches: [Option<Contact>; 3],
    /// What the probe meets, moved by X, Y and Z.
    pub probes: [Option<Contact>; 3],
    /// Limits of the drivers that pulses are checked against.
    pub limits: DriverLimits,
    /// The registers of the `chain` wiring.
    pub chain: Chain,
    inputs: u32,
    active_low: u32,
    start: bool,
    stop: bool,
    unplugged: bool,
    /// Pins of outputs whose resistors pull up instead of down.
    pulled_up: u64,
    /// STEP is active when low: levels in `pins` are turned over there.
    step_low: bool,
    outputs: u16,
    pins: u64,
    changes: VecDeque<OutputChange>,
    violations: Vec<Violation>,
    /// Number of violations, also of those not kept.
    pub violation_count: u64,
    /// Ask `run_until` to return when an output changes.
    pub stop_at_output: bool,
    pub(crate) output_changed: bool,
    pub(crate) recorder: Recorder,
    recorded_in: u16,
    jumpers: Vec<Jumper>,
    /// Voltages at the analog inputs, mV, where nobody [around](Plant::volts) the machine gives another.
    pub analog: [u16; 4],
    /// Levels of all pins as they are.
    raw: u64,
    around: around::Listener,
}

impl Plant {
    /// A plant around a G2553 at rest: all axes at 0, all contacts open.
    #[must_use]
    pub fn new(wiring: Wiring) -> Plant {
        Plant::around(&Part::G2553, wiring)
    }

    /// A plant around a part, at rest: all axes at 0, all contacts open.
    #[must_use]
    pub fn around(part: &Part, wiring: Wiring) -> Plant {
        let mut plant = Plant {
            wiring,
            board: Pins::of(part.family),
            ticks_per_second: part.ticks_per_second,
            motors: Default::default(),
            switches: [None; 3],
            probes: [None; 3],
            limits: DriverLimits::usual(part.ticks_per_second),
            chain: Chain::default(),
            inputs: 0,
            active_low: 0,
            start: false,
            stop: false,
            unplugged: false,
            pulled_up: 0,
            step_low: false,
            outputs: 0,
            pins: 0,
            changes: VecDeque::new(),
            violations: Vec::new(),
            violation_count: 0,
            stop_at_output: false,
            output_changed: false,
            recorder: Recorder::default(),
            recorded_in: 0,
            jumpers: Vec::new(),
            analog: [0; 4],
            raw: 0,
            around: around::Listener::default(),
        };
        plant.active_low = match wiring {
            Wiring::Direct => 0b1111,
            Wiring::Chain => 1 << 16,
        };
        plant.chain.inputs = plant.register_levels();
        plant
    }

    /// The pins of the board.
    #[must_use]
    pub fn board(&self) -> &Pins {
        &self.board
    }

    /// Ticks in a second of the board's chip, in which all times are.
    #[must_use]
    pub fn ticks_per_second(&self) -> u64 {
        self.ticks_per_second
    }

    /// The wiring.
    #[must_use]
    pub fn wiring(&self) -> Wiring {
        self.wiring
    }

    /// Number of the input that is the reference of `axis`.
    #[must_use]
    pub fn reference_input(&self, axis: usize) -> u8 {
        match self.wiring {
            Wiring::Direct => 1 + axis as u8,
            Wiring::Chain => 9 + axis as u8,
        }
    }

    /// Number of the input that is the probe.
    #[must_use]
    pub fn probe_input(&self) -> u8 {
        match self.wiring {
            Wiring::Direct => 4,
            Wiring::Chain => 17,
        }
    }

    /// Switches input `n` (from 1) on or off. References and probe are also on when their contact
    /// is. Unknown numbers do nothing.
    pub fn set_input(&mut self, n: u8, on: bool) {
        if (1..=17).contains(&n) {
            let bit = 1 << (n - 1);
            self.inputs = if on { self.inputs | bit } else { self.inputs & !bit };
        }
    }

    /// Makes input `n` low when on (contact to ground) or high when on.
    pub fn set_active_low(&mut self, n: u8, low: bool) {
        if (1..=17).contains(&n) {
            let bit = 1 << (n - 1);
            self.active_low = if low { self.active_low | bit } else { self.active_low & !bit };
        }
    }

    /// Presses or releases Start.
    pub fn press_start(&mut self, pressed: bool) {
        self.start = pressed;
    }

    /// Presses or releases Stop.
    pub fn press_stop(&mut self, pressed: bool) {
        self.stop = pressed;
    }

    /// Whether the data of the shift registers are not there for certain at a time.
    pub(crate) fn unsettled(&self, now: u64, ticks_per_second: u64) -> bool {
        self.wiring == Wiring::Chain && self.chain.unsettled(now, ticks_per_second)
    }

    /// Gives the outputs at pins (`direct` wiring) resistors that pull up, as those want that are on
    /// when low.
    pub fn pull_outputs_up(&mut self) {
        self.pulled_up |= 1 << self.board.latch | 1 << self.board.enable;
    }

    /// The chip is reset: see [`Motor::cut_short`].
    pub fn cut_short(&mut self) {
        self.motors.iter_mut().for_each(Motor::cut_short);
    }

    /// Drivers that take a low level for an active STEP, and whose resistors pull it up. Recorded is whether STEP is
    /// active, as without it.
    pub fn steps_are_low(&mut self) {
        self.step_low = true;
        self.pulled_up |= self.board.step.iter().fold(0, |pins, pin| pins | 1 << pin);
    }

    /// Takes the serial cable off: nobody drives the receive pin.
    pub fn unplug(&mut self, off: bool) {
        self.unplugged = off;
    }

    /// Whether input `n` is on.
    #[must_use]
    pub fn input(&self, n: u8) -> bool {
        (1..=17).contains(&n) && self.on() >> (n - 1) & 1 != 0
    }

    /// Whether output `n` (from 1) is on, behind the output enable.
    #[must_use]
    pub fn output(&self, n: u8) -> bool {
        (1..=16).contains(&n) && self.outputs >> (n - 1) & 1 != 0
    }

    /// All outputs, output `n` in bit `n - 1`.
    #[must_use]
    pub fn outputs(&self) -> u16 {
        self.outputs
    }

    /// Output changes since the last call.
    pub fn take_output_changes(&mut self) -> Vec<OutputChange> {
        self.changes.drain(..).collect()
    }

    /// The first broken limits of the drivers.
    #[must_use]
    pub fn violations(&self) -> &[Violation] {
        &self.violations
    }

    /// Axis `axis` will lose its next `steps` steps.
    pub fn stall(&mut self, axis: usize, steps: u64) {
        if let Some(motor) = self.motors.get_mut(axis) {
            motor.stalled += steps;
        }
    }

    /// All inputs that are on, input `n` in bit `n - 1`.
    fn on(&self) -> u32 {
        let mut on = self.inputs | self.around.inputs();
        for (axis, switch) in self.switches.iter().enumerate() {
            if switch.is_some_and(|s| s.closed(&self.motors)) {
                on |= 1 << (self.reference_input(axis) - 1);
            }
        }
        if self.probes.iter().flatten().any(|p| p.closed(&self.motors)) {
            on |= 1 << (self.probe_input() - 1);
        }
        on
    }

    fn register_levels(&self) -> u16 {
        (self.on() ^ self.active_low) as u16
    }

    /// Signal at a pin, if it has a name of its own.
    fn signal(&self, pin: u8) -> Option<Signal> {
        let board = &self.board;
        let place = |list: &[u8]| list.iter().position(|p| *p == pin).map(|n| n as u8);
        if let Some(n) = place(&board.step) {
            return Some(Signal::Step(n));
        }
        if let Some(n) = place(&board.dir) {
            return Some(Signal::Dir(n));
        }
        let named = [
            (board.stop, Signal::Stop),
            (board.rx, Signal::Rx),
            (board.tx, Signal::Tx),
            (board.start, Signal::Start),
        ];
        if let Some((_, signal)) = named.iter().find(|(p, _)| *p == pin) {
            return Some(*signal);
        }
        let timed = [(board.pwm, Signal::Pwm), (board.aout, Signal::Aout)];
        if let Some((_, signal)) = timed.into_iter().find(|(own, _)| *own == Some(pin)) {
            return Some(signal);
        }
        if let Some([data, drive]) = board.rs485 {
            if pin == data {
                return Some(Signal::Rs485);
            }
            if pin == drive {
                return Some(Signal::Drive);
            }
        }
        if board.input(self.wiring, self.probe_input()) == Some(pin) {
            return Some(Signal::Probe);
        }
        match self.wiring {
            Wiring::Direct => place(&board.inputs).map(|n| Signal::In(n + 1)),
            Wiring::Chain => None,
        }
    }

    /// All signals with their present levels: the head of a recording.
    #[must_use]
    pub fn signals(&self) -> Vec<(Signal, bool)> {
        let mut all = Vec::new();
        for pin in 0..64 {
            if let Some(signal) = self.signal(pin) {
                all.push((signal, high(self.pins, pin)));
            }
        }
        let outputs = if self.wiring == Wiring::Direct { 2 } else { 16 };
        all.extend((1..=outputs).map(|n| (Signal::Out(n), self.output(n))));
        if self.wiring == Wiring::Chain {
            all.extend((1..=16).map(|n| (Signal::In(n), self.chain.inputs >> (n - 1) & 1 != 0)));
            all.push((Signal::In(17), high(self.pins, self.board.probe)));
        } else {
            all.push((Signal::In(4), high(self.pins, self.board.inputs[3])));
        }
        all.sort_unstable();
        all
    }

    /// The chip gives all its pins these levels, numbered as [`Pins`] has them, at a time in ticks.
    pub fn pins(&mut self, now: u64, levels: u64) {
        self.pass(now);
        let steps = self.board.step.iter().fold(0, |pins, pin| pins | 1 << pin);
        for wire in &mut self.jumpers {
            let (is, was) = (high(levels, wire.from), high(self.raw, wire.from));
            if is && !was {
                wire.edges += 1;
                wire.level = wire.loses == 0 || wire.edges % wire.loses != 0;
            } else if !is {
                wire.level = false;
            }
        }
        self.raw = levels;
        let levels = if self.step_low { levels ^ steps } else { levels };
        let changed = levels ^ self.pins;
        self.pins = levels;
        if self.recorder.active() {
            let probe = self.board.input(self.wiring, self.probe_input());
            let mut rest = changed;
            while rest != 0 {
                let pin = rest.trailing_zeros() as u8;
                rest &= rest - 1;
                let level = high(levels, pin);
                if let Some(signal) = self.signal(pin) {
                    self.recorder.add(now, signal, level);
                }
                if probe == Some(pin) {
                    self.recorder.add(now, Signal::In(self.probe_input()), level);
                }
            }
        }
        if changed != 0 {
            self.axes(now, levels, changed);
        }
        self.registers(now);
    }

    fn axes(&mut self, now: u64, levels: u64, changed: u64) {
        let mut left = false;
        for axis in 0..3 {
            let (violations, count) = (&mut self.violations, &mut self.violation_count);
            let mut report = |kind, ticks| {
                *count += 1;
                if violations.len() < KEPT {
                    violations.push(Violation { cycle: now, axis, kind, ticks });
                }
            };
            let motor = &mut self.motors[axis];
            if high(changed, self.board.dir[axis]) {
                motor.dir(high(levels, self.board.dir[axis]), now, self.limits, &mut report);
            }
            if !high(changed, self.board.step[axis]) {
                continue;
            }
            let level = high(levels, self.board.step[axis]);
            let moved = motor.step(level, now, self.limits, report);
            left |= moved && self.around.leaves(axis, motor.position);
        }
        if left {
            self.tell(now, around::Change::Moved);
        }
    }

    /// Shift registers and outputs follow the pins and the contacts.
    fn registers(&mut self, now: u64) {
        let level = |pin: u8| high(self.pins, pin);
        let Pins { latch, enable, clk, simo, .. } = self.board;
        let outputs = match self.wiring {
            Wiring::Direct => u16::from(level(latch)) | u16::from(level(enable)) << 1,
            Wiring::Chain => {
                let (clk, simo, latch) = (level(clk), level(simo), level(latch));
                let off = level(enable);
                let inputs = self.register_levels();
                self.record_inputs(now, inputs);
                self.chain.inputs = inputs;
                self.chain.signals(now, clk, simo, latch);
                if off { 0 } else { self.chain.latched }
            }
        };
        let changed = outputs ^ self.outputs;
        if changed == 0 {
            return;
        }
        self.outputs = outputs;
        self.output_changed = true;
        for n in (0..16).filter(|n| changed >> n & 1 != 0) {
            let on = outputs >> n & 1 != 0;
            let output = n as u8 + 1;
            if self.changes.len() >= KEPT {
                self.changes.pop_front();
            }
            self.changes.push_back(OutputChange { cycle: now, output, on });
            if self.recorder.active() {
                self.recorder.add(now, Signal::Out(output), on);
            }
            self.tell(now, around::Change::Output(output, on));
        }
    }

    fn record_inputs(&mut self, now: u64, inputs: u16) {
        let changed = inputs ^ self.recorded_in;
        if changed == 0 {
            return;
        }
        self.recorded_in = inputs;
        if self.recorder.active() {
            for n in (0..16).filter(|n| changed >> n & 1 != 0) {
                self.recorder.add(now, Signal::In(n as u8 + 1), inputs >> n & 1 != 0);
            }
        }
    }

    /// Power came up; mechanical things stay where they are.
    pub(crate) fn power_up(&mut self, noise: &mut Rng) {
        self.chain.power_up(noise);
    }
}
