//! The step engine at the pins: time, STEP and DIR, and what stops steps between two passes.

use firmware::machine::chip::{Guard, Steps};
use firmware::motion::{PathSegment, Segment};

use super::{Desk, PER_US, cost};

/// [`Guard::tripped`]: inputs of the chain have answered.
const CHAIN: u8 = 1;
/// Ticks between the end of a step and a change of its direction.
const HOLD: u64 = PER_US;

impl Desk {
    /// Makes the steps that come until a time, ticks.
    pub(super) fn play_until(&self, end: u64) {
        loop {
            let event = self.0.engine.borrow().next_event();
            let fall = self.0.falls.get().into_iter().flatten().min();
            let turn = self.0.turn.get();
            // What is due at the pins comes before the next event.
            let pins = fall.into_iter().chain(turn.map(|(tick, _)| tick)).min();
            let next = pins.into_iter().chain(event.map(|due| due >> 16)).min();
            self.pass_around(next.unwrap_or(end).min(end));
            match (event, pins) {
                (due, Some(tick)) if tick <= end && due.is_none_or(|due| tick <= due >> 16) => {
                    match turn {
                        Some((at, negative)) if at == tick => {
                            self.0.turn.set(None);
                            self.set_dirs(tick, negative);
                        }
                        _ => self.fall(tick),
                    }
                }
                (Some(due), _) if due >> 16 <= end => self.event(due),
                _ => return,
            }
        }
    }

    /// What happens around the machine by itself until a time, ticks.
    fn pass_around(&self, tick: u64) {
        let mut plant = self.0.plant.borrow_mut();
        let unit = Desk::plant_ticks(&plant);
        // Whoever acts between two ticks is seen at the next one.
        plant.pass(tick * unit);
    }

    /// STEP pins whose pulse is over.
    fn fall(&self, tick: u64) {
        let mut falls = self.0.falls.get();
        let step = self.0.plant.borrow().board().step;
        let mut levels = self.0.levels.get();
        for (fall, pin) in falls.iter_mut().zip(step) {
            if *fall == Some(tick) {
                *fall = None;
                levels &= !(1 << pin);
            }
        }
        self.0.falls.set(falls);
        self.set_levels(tick, levels);
    }

    /// An event of the engine: the pins that were armed rise, the inputs are looked at, the next steps are armed.
    fn event(&self, due: u64) {
        let pulse = self.0.engine.borrow().pulse(due);
        if pulse.steps != 0 {
            let step = self.0.plant.borrow().board().step;
            let (mut levels, mut falls) = (self.0.levels.get(), self.0.falls.get());
            for (axis, pin) in step.into_iter().enumerate() {
                if pulse.steps >> axis & 1 != 0 {
                    levels |= 1 << pin;
                    falls[axis] = Some(pulse.tick + self.0.pulse.get());
                }
            }
            self.0.falls.set(falls);
            self.set_levels(pulse.tick, levels);
            self.look_at_pins();
        }
        let watches = self.0.engine.borrow().watches();
        let inputs = if watches { self.port() } else { 0 };
        let mut engine = self.0.engine.borrow_mut();
        let before = engine.negative;
        engine.play(due, inputs);
        let negative = engine.negative;
        if negative != before {
            // STEP ends first, and DIR has its set-up time before the next step.
            let turn = (due >> 16) + self.0.pulse.get() + HOLD;
            engine.put_off(negative ^ before, (turn + self.0.setup.get()) << 16);
            drop(engine);
            self.0.turn.set(Some((turn, negative)));
        }
    }

    /// The DIR pins say in which direction the axes move; bit n: axis n in negative direction.
    pub(super) fn set_dirs(&self, tick: u64, negative: u8) {
        let dir = self.0.plant.borrow().board().dir;
        let mut levels = self.0.levels.get();
        for (axis, pin) in dir.into_iter().enumerate() {
            let inverted = self.0.invert.get() & <Desk as Steps>::DIR[axis] != 0;
            let positive = negative >> axis & 1 == 0;
            levels &= !(1 << pin);
            levels |= u64::from(positive != inverted) << pin;
        }
        self.set_levels(tick, levels);
    }

    /// The pins of the port of inputs that are guarded: one that answers stops the engine.
    fn look_at_pins(&self) {
        let mut guard = self.0.guard.get();
        let answers = if guard.pins == 0 { 0 } else { (self.port() ^ guard.falling) & guard.pins };
        if answers != 0 {
            guard.tripped = answers;
            self.trip(guard);
        }
    }

    /// Each millisecond: the inputs of the chain that are guarded, and the pins again.
    pub(super) fn look_at_chain(&self) {
        self.look_at_pins();
        let mut guard = self.0.guard.get();
        if guard.inputs == 0 {
            return;
        }
        let answers = (self.chain_inputs() ^ guard.invert) & guard.inputs;
        if answers != 0 {
            guard.answered = answers;
            guard.tripped = CHAIN;
            self.trip(guard);
        }
    }

    fn trip(&self, mut guard: super::Guarded) {
        (guard.pins, guard.inputs) = (0, 0);
        self.0.guard.set(guard);
        self.0.engine.borrow_mut().cut();
    }

    /// Time of the engine, 1/65536 ticks.
    fn fine(&self) -> u64 {
        self.ticks() << 16
    }

    /// Lets time pass until no step is armed any more.
    fn rest(&self, moves: impl Fn(&super::Engine) -> bool) {
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
        self.0.engine.borrow_mut().clear();
    }
    fn set_invert(&self, invert: u8) {
        if self.0.invert.replace(invert) == invert {
            return;
        }
        self.0.engine.borrow_mut().negative = 0;
        self.0.turn.set(None);
        self.set_dirs(self.ticks(), 0);
    }
    fn path_has_room(&self) -> bool {
        self.0.engine.borrow().path_has_room()
    }
    fn ahead(&self) -> u16 {
        if self.tripped() != 0 { 0 } else { self.0.engine.borrow().ahead() }
    }
    fn put_path(&self, segment: &PathSegment, power: u16) {
        self.spend(cost::SEGMENT);
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
        self.rest(super::Engine::moves);
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
