//! The step engine at the pins: time, STEP and DIR, and the inputs that stop steps between two passes.

use std::cell::RefMut;

use emulator::Plant;
use firmware::machine::chip::{Guard, Steps};
use firmware::motion::{PathSegment, Segment};

use super::engine::Engine;
use super::{Desk, Guarded, PER_US, State, cost};

/// [`Guard::tripped`]: inputs of the chain have answered.
const CHAIN: u8 = 1;
/// Ticks between the end of a step and a change of its direction.
const HOLD: u64 = PER_US;

/// The step engine and the plant at its pins, while time passes.
struct Play<'a> {
    state: &'a State,
    engine: RefMut<'a, Engine>,
    plant: RefMut<'a, Plant>,
}

impl Play<'_> {
    /// Makes the steps that come until a time, ticks; where `to_change` says so, only until a segment is taken or ends.
    /// Gives the time to which it came.
    fn until(&mut self, mut end: u64, mut to_change: bool) -> u64 {
        let (state, begun) = (self.state, self.state.now.get());
        let before = self.engine.changes;
        loop {
            let event = self.engine.next_event();
            let fall = state.falls.get().into_iter().flatten().min();
            let turn = state.turn.get();
            // What is due at the pins comes before the next event.
            let pins = fall.into_iter().chain(turn.map(|(tick, _)| tick)).min();
            let tick = event.map(|due| due >> 16);
            if pins.is_none() && tick.is_some_and(|tick| tick < end) && self.rush(end) {
                continue;
            }
            // Whoever acts between two ticks is seen at the next one.
            let next = pins.into_iter().chain(tick).min().unwrap_or(end).min(end);
            self.plant.pass(next * state.unit);
            match (event, pins) {
                (due, Some(tick)) if tick <= end && due.is_none_or(|due| tick <= due >> 16) => {
                    match turn {
                        Some((at, negative)) if at == tick => {
                            state.turn.set(None);
                            state.set_dirs(&mut self.plant, tick, negative);
                        }
                        _ => self.fall(tick),
                    }
                }
                (Some(due), _) if due >> 16 <= end => {
                    self.event(due);
                    if to_change && self.engine.changes != before {
                        to_change = false;
                        end = (due >> 16).clamp(begun + 1, end);
                    }
                }
                _ => return end,
            }
        }
    }

    /// Many events at once, as far as their pulses have ended by a time, ticks, and nothing comes of them but steps.
    fn rush(&mut self, end: u64) -> bool {
        let (state, pulse) = (self.state, self.state.pulse.get());
        let Plant { limits, .. } = *self.plant;
        let end = self.plant.due().map_or(end, |due| end.min(due / state.unit));
        let Some(last) = end.checked_sub(pulse) else { return false };
        let until = last << 16 | 0xFFFF;
        if !self.engine.may_rush(until)
            || self.plant.is_observed()
            || pulse * state.unit < limits.pulse
        {
            return false;
        }
        let guard = state.guard.get();
        if guard.pins != 0 || self.engine.watches() {
            let port = state.port(&self.plant);
            if (port ^ guard.falling) & guard.pins != 0 || self.engine.would_answer(port) {
                return false;
            }
        }
        let least = (pulse + 1 + limits.low.div_ceil(state.unit)) << 16;
        let room = self.plant.free_steps();
        match self.engine.rush(until, room, least) {
            Some(steps) => self.plant.travel(steps),
            None => return false,
        }
        true
    }

    /// STEP pins whose pulse is over.
    fn fall(&mut self, tick: u64) {
        let state = self.state;
        let mut falls = state.falls.get();
        let mut levels = state.levels.get();
        for (fall, pin) in falls.iter_mut().zip(state.pins.step) {
            if *fall == Some(tick) {
                *fall = None;
                levels &= !(1 << pin);
            }
        }
        state.falls.set(falls);
        state.set_levels(&mut self.plant, tick, levels);
    }

    /// An event of the engine: the pins that were armed rise, the inputs are looked at, the next steps are armed.
    fn event(&mut self, due: u64) {
        let state = self.state;
        let pulse = self.engine.pulse(due);
        if pulse.steps != 0 {
            let (mut levels, mut falls) = (state.levels.get(), state.falls.get());
            for (axis, pin) in state.pins.step.into_iter().enumerate() {
                if pulse.steps >> axis & 1 != 0 {
                    levels |= 1 << pin;
                    falls[axis] = Some(pulse.tick + state.pulse.get());
                }
            }
            state.falls.set(falls);
            state.set_levels(&mut self.plant, pulse.tick, levels);
            state.look_at_pins(&self.plant, &mut self.engine);
        }
        let inputs = if self.engine.watches() { state.port(&self.plant) } else { 0 };
        let before = self.engine.negative;
        self.engine.play(due, inputs);
        let negative = self.engine.negative;
        if negative != before {
            // STEP ends first, and DIR has its set-up time before the next step.
            let turn = (due >> 16) + state.pulse.get() + HOLD;
            self.engine.put_off(negative ^ before, (turn + state.setup.get()) << 16);
            state.turn.set(Some((turn, negative)));
        }
    }
}

impl State {
    /// The DIR pins say in which direction the axes move; bit n: axis n in negative direction.
    pub(super) fn set_dirs(&self, plant: &mut Plant, tick: u64, negative: u8) {
        let mut levels = self.levels.get();
        for (axis, pin) in self.pins.dir.into_iter().enumerate() {
            let inverted = self.invert.get() & <Desk as Steps>::DIR[axis] != 0;
            let positive = negative >> axis & 1 == 0;
            levels &= !(1 << pin);
            levels |= u64::from(positive != inverted) << pin;
        }
        self.set_levels(plant, tick, levels);
    }

    /// The pins of the port of inputs that are guarded: one that answers stops the engine.
    fn look_at_pins(&self, plant: &Plant, engine: &mut Engine) {
        let mut guard = self.guard.get();
        if guard.pins == 0 {
            return;
        }
        let answers = (self.port(plant) ^ guard.falling) & guard.pins;
        if answers != 0 {
            guard.tripped = answers;
            self.trip(guard, engine);
        }
    }

    fn trip(&self, mut guard: Guarded, engine: &mut Engine) {
        (guard.pins, guard.inputs) = (0, 0);
        self.guard.set(guard);
        engine.cut();
    }
}

impl Desk {
    /// Makes the steps that come until a time, ticks: see [`Play::until`].
    pub(super) fn play_until(&self, end: u64, to_change: bool) -> u64 {
        let state = &*self.0;
        let (engine, plant) = (state.engine.borrow_mut(), state.plant.borrow_mut());
        Play { state, engine, plant }.until(end, to_change)
    }

    /// Where an axis is, steps: what the step engine has counted, before the machine's next pass takes it over.
    pub fn counted(&self, axis: usize) -> i32 {
        self.0.engine.borrow().count[axis]
    }

    /// Each millisecond: the inputs of the chain that are guarded, and the pins again.
    pub(super) fn look_at_chain(&self) {
        let state = &*self.0;
        state.look_at_pins(&state.plant.borrow(), &mut state.engine.borrow_mut());
        let mut guard = state.guard.get();
        if guard.inputs == 0 {
            return;
        }
        let answers = (self.chain_inputs() ^ guard.invert) & guard.inputs;
        if answers != 0 {
            guard.answered = answers;
            guard.tripped = CHAIN;
            state.trip(guard, &mut state.engine.borrow_mut());
        }
    }

    /// Time of the engine, 1/65536 ticks.
    fn fine(&self) -> u64 {
        self.ticks() << 16
    }

    /// Lets time pass until no step is armed any more.
    fn rest(&self, moves: impl Fn(&Engine) -> bool) {
        while moves(&self.0.engine.borrow()) {
            self.spend(PER_US);
        }
    }
}

impl Steps for Desk {
    const DIR: [u8; 3] = [1, 2, 4];

    fn is_running(&self) -> bool {
        self.0.engine.borrow().moves() || self.tripped() != 0
    }
    fn axis_is_running(&self, axis: usize) -> bool {
        self.0.engine.borrow().axis_moves(axis) || self.tripped() != 0
    }
    fn clear(&self) {
        self.spend(cost::PATH);
        self.0.engine.borrow_mut().clear();
    }
    fn set_invert(&self, invert: u8) {
        if self.0.invert.replace(invert) == invert {
            return;
        }
        self.0.engine.borrow_mut().negative = 0;
        self.0.turn.set(None);
        self.0.set_dirs(&mut self.0.plant.borrow_mut(), self.ticks(), 0);
    }
    fn path_has_room(&self) -> bool {
        self.0.engine.borrow().path_has_room()
    }
    fn ahead(&self) -> u16 {
        if self.tripped() != 0 { 0 } else { self.0.engine.borrow().ahead() }
    }
    fn put_path(&self, segment: &PathSegment, power: u16) {
        let begins = segment.begin && !segment.within;
        self.spend(cost::SEGMENT + if begins { cost::BLOCK } else { 0 });
        if self.tripped() == 0 {
            let now = self.fine();
            self.0.engine.borrow_mut().put_path(segment, power, now, PER_US);
        }
    }
    fn power(&self) -> u16 {
        self.0.engine.borrow().power()
    }
    // No jumper, and no timer to measure with.
    fn measure(&self, mode: u16) -> bool {
        mode == 0
    }
    fn measures(&self) -> u16 {
        0
    }
    fn measured(&self, _: u16) -> u16 {
        0
    }
    fn revision(&self) -> u16 {
        0
    }
    // The plant has nothing at the PWM's pin.
    fn shine_at_pwm(&self) {}
    fn axis_has_room(&self, axis: usize) -> bool {
        self.0.engine.borrow().axis_has_room(axis)
    }
    fn put_axis(&self, axis: usize, segment: &Segment, negative: bool) {
        self.spend(cost::AXIS_SEGMENT);
        if self.tripped() == 0 {
            let now = self.fine();
            self.0.engine.borrow_mut().put_axis(axis, segment, negative, now, PER_US);
        }
    }
    fn halt(&self) {
        self.0.engine.borrow_mut().cut();
        self.rest(Engine::moves);
        let mut guard = self.0.guard.get();
        guard.tripped = 0;
        self.0.guard.set(guard);
    }
    fn halt_axis(&self, axis: usize) {
        self.0.engine.borrow_mut().cut_axis(axis);
        self.rest(|engine| engine.axis_moves(axis));
    }
    fn fold(&self, axis: usize, position: &mut i32) {
        *position = self.0.engine.borrow().count[axis];
    }
    fn set_count(&self, axis: usize, position: i32) {
        self.0.engine.borrow_mut().count[axis] = position;
    }
    fn watch(&self, pins: u8, idle: u8, halt: bool) {
        self.0.engine.borrow_mut().watch(pins, idle, halt);
    }
    fn hit(&self) -> u8 {
        self.0.engine.borrow().hit
    }
    fn caught(&self, axis: usize, _: i32) -> i32 {
        self.0.engine.borrow().caught[axis]
    }
    // The desktop is never late.
    fn late(&self) -> u16 {
        0
    }
}

impl Guard for Desk {
    fn guard(&self, pins: u8, inputs: u16) {
        let mut guard = self.0.guard.get();
        (guard.pins, guard.inputs) = (pins, inputs);
        self.0.guard.set(guard);
    }
    fn tripped(&self) -> u8 {
        self.0.guard.get().tripped
    }
    fn answered(&self) -> u16 {
        let guard = self.0.guard.get();
        if guard.tripped == CHAIN { guard.answered } else { 0 }
    }
}
