//! The plant: everything around the chip's pins that the pin table of the board names.
//!
//! Electrical conventions: contacts at pins (Start, Stop, probe, and all inputs of the `direct`
//! wiring) close to ground, so "on" is a low level; the 74HC165 inputs of the `chain` wiring are
//! high when on. `set_active_low` changes that for single inputs. STEP, DIR and outputs at
//! pins have pull-down resistors; latch and output enable of the shift registers are pulled up.

pub mod chain;
pub mod motor;

use std::collections::VecDeque;

use crate::record::{Recorder, Signal};
use chain::Chain;
use motor::{DriverLimits, Motor, Violation};

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

/// External conditions at the pins of ports 1 and 2.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Drives {
    /// Pins that are driven from outside.
    pub driven: [u8; 2],
    /// Their levels.
    pub level: [u8; 2],
    /// Levels at pins that nobody drives and that have no pull resistor of the chip.
    pub rest: [u8; 2],
    /// Open contacts: undefined without the chip's pull resistor.
    pub open: [u8; 2],
}

/// Pins of port 2 that step, X to Z.
pub const STEP_BITS: [u8; 3] = [0, 1, 4];
/// Pins of port 2 that give the direction, X to Z.
pub const DIR_BITS: [u8; 3] = [3, 6, 7];
const STOP_BIT: u8 = 0;
const RX_BIT: u8 = 1;
const TX_BIT: u8 = 2;
const START_BIT: u8 = 3;
const PROBE_BIT: u8 = 4;
const CLK_BIT: u8 = 5;
const SOMI_BIT: u8 = 6;
const SIMO_BIT: u8 = 7;
const LATCH_BIT: u8 = 2;
const ENABLE_BIT: u8 = 5;
/// Violations and output changes that are kept.
const KEPT: usize = 10_000;

/// The world around the pins.
#[derive(Clone)]
pub struct Plant {
    wiring: Wiring,
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
    outputs: u16,
    pins: [u8; 2],
    changes: VecDeque<OutputChange>,
    violations: Vec<Violation>,
    /// Number of violations, also of those not kept.
    pub violation_count: u64,
    /// Ask `run_until` to return when an output changes.
    pub stop_at_output: bool,
    pub(crate) output_changed: bool,
    pub(crate) recorder: Recorder,
    recorded_in: u16,
}

impl Plant {
    /// A plant at rest: all axes at 0, all contacts open.
    #[must_use]
    pub fn new(wiring: Wiring) -> Plant {
        let mut plant = Plant {
            wiring,
            motors: Default::default(),
            switches: [None; 3],
            probes: [None; 3],
            limits: DriverLimits::default(),
            chain: Chain::default(),
            inputs: 0,
            active_low: 0,
            start: false,
            stop: false,
            outputs: 0,
            pins: [0; 2],
            changes: VecDeque::new(),
            violations: Vec::new(),
            violation_count: 0,
            stop_at_output: false,
            output_changed: false,
            recorder: Recorder::default(),
            recorded_in: 0,
        };
        plant.active_low = match wiring {
            Wiring::Direct => 0b1111,
            Wiring::Chain => 1 << 16,
        };
        plant.chain.inputs = plant.register_levels();
        plant
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
        let mut on = self.inputs;
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
    fn signal(&self, port: usize, bit: u8) -> Option<Signal> {
        let axis = |bits: [u8; 3]| bits.iter().position(|b| *b == bit).map(|n| n as u8);
        if port == 1 {
            if let Some(n) = axis(STEP_BITS) {
                return Some(Signal::Step(n));
            }
            return axis(DIR_BITS).map(Signal::Dir);
        }
        match (bit, self.wiring) {
            (STOP_BIT, _) => Some(Signal::Stop),
            (RX_BIT, _) => Some(Signal::Rx),
            (TX_BIT, _) => Some(Signal::Tx),
            (START_BIT, _) => Some(Signal::Start),
            (PROBE_BIT, Wiring::Chain) | (SIMO_BIT, Wiring::Direct) => Some(Signal::Probe),
            (PROBE_BIT..=SOMI_BIT, Wiring::Direct) => Some(Signal::In(bit - PROBE_BIT + 1)),
            _ => None,
        }
    }

    /// All signals with their present levels: the head of a recording.
    #[must_use]
    pub fn signals(&self) -> Vec<(Signal, bool)> {
        let mut all = Vec::new();
        for port in 0..2 {
            for bit in 0..8 {
                if let Some(signal) = self.signal(port, bit) {
                    all.push((signal, self.pins[port] >> bit & 1 != 0));
                }
            }
        }
        let outputs = if self.wiring == Wiring::Direct { 2 } else { 16 };
        all.extend((1..=outputs).map(|n| (Signal::Out(n), self.output(n))));
        if self.wiring == Wiring::Chain {
            all.extend((1..=16).map(|n| (Signal::In(n), self.chain.inputs >> (n - 1) & 1 != 0)));
            all.push((Signal::In(17), self.pins[0] >> PROBE_BIT & 1 != 0));
        } else {
            all.push((Signal::In(4), self.pins[0] >> SIMO_BIT & 1 != 0));
        }
        all.sort_unstable();
        all
    }

    /// Levels of all pins of ports 1 and 2.
    pub(crate) fn pins(&mut self, now: u64, levels: [u8; 2]) {
        let changed = [levels[0] ^ self.pins[0], levels[1] ^ self.pins[1]];
        self.pins = levels;
        if self.recorder.active() {
            for (port, changed) in changed.iter().enumerate() {
                for bit in (0..8).filter(|bit| changed >> bit & 1 != 0) {
                    let level = levels[port] >> bit & 1 != 0;
                    if let Some(signal) = self.signal(port, bit) {
                        self.recorder.add(now, signal, level);
                    }
                    match (self.wiring, port, bit) {
                        (Wiring::Chain, 0, PROBE_BIT) => {
                            self.recorder.add(now, Signal::In(17), level);
                        }
                        (Wiring::Direct, 0, SIMO_BIT) => {
                            self.recorder.add(now, Signal::In(4), level);
                        }
                        _ => {}
                    }
                }
            }
        }
        if changed[1] != 0 {
            self.axes(now, levels[1], changed[1]);
        }
        self.registers(now);
    }

    fn axes(&mut self, now: u64, port2: u8, changed: u8) {
        for axis in 0..3 {
            let motor = &mut self.motors[axis];
            if changed >> DIR_BITS[axis] & 1 != 0 {
                motor.dir(port2 >> DIR_BITS[axis] & 1 != 0, now);
            }
            if changed >> STEP_BITS[axis] & 1 == 0 {
                continue;
            }
            let (violations, count) = (&mut self.violations, &mut self.violation_count);
            motor.step(port2 >> STEP_BITS[axis] & 1 != 0, now, self.limits, |kind, ticks| {
                *count += 1;
                if violations.len() < KEPT {
                    violations.push(Violation { cycle: now, axis, kind, ticks });
                }
            });
        }
    }

    /// Shift registers and outputs follow the pins and the contacts.
    fn registers(&mut self, now: u64) {
        let [p1, p2] = self.pins;
        let bit = |port: u8, n: u8| port >> n & 1 != 0;
        let outputs = match self.wiring {
            Wiring::Direct => u16::from(bit(p2, LATCH_BIT)) | u16::from(bit(p2, ENABLE_BIT)) << 1,
            Wiring::Chain => {
                let inputs = self.register_levels();
                self.record_inputs(now, inputs);
                self.chain.inputs = inputs;
                self.chain.signals(bit(p1, CLK_BIT), bit(p1, SIMO_BIT), bit(p2, LATCH_BIT));
                if bit(p2, ENABLE_BIT) { 0 } else { self.chain.latched }
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

    /// What the world does to the pins; `rx` is the level of the serial line.
    pub(crate) fn drives(&self, rx: bool) -> Drives {
        let mut d = Drives::default();
        let on = self.on();
        let mut contact = |bit: u8, closed: bool| {
            if closed {
                d.driven[0] |= 1 << bit;
            } else {
                d.open[0] |= 1 << bit;
                d.rest[0] |= 1 << bit;
            }
        };
        contact(STOP_BIT, self.stop);
        contact(START_BIT, self.start);
        let closed = |n: u8| (on ^ !self.active_low) >> (n - 1) & 1 != 0;
        match self.wiring {
            Wiring::Direct => (1..=4).for_each(|n| contact(PROBE_BIT + n - 1, closed(n))),
            Wiring::Chain => contact(PROBE_BIT, closed(17)),
        }
        d.driven[0] |= 1 << RX_BIT;
        d.level[0] |= u8::from(rx) << RX_BIT;
        d.rest[0] |= 1 << TX_BIT;
        if self.wiring == Wiring::Chain {
            d.driven[0] |= 1 << SOMI_BIT;
            d.level[0] |= u8::from(self.chain.data_out()) << SOMI_BIT;
            d.rest[1] |= 1 << LATCH_BIT | 1 << ENABLE_BIT;
        }
        d
    }

    /// Power came up; mechanical things stay where they are.
    pub(crate) fn power_up(&mut self) {
        self.chain.power_up();
    }
}
