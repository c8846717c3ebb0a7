//! The step engine of the shipped F5529 image in the emulator, fed from outside as the firmware feeds it.
#![allow(dead_code, reason = "each test file uses a part of it")]

use emulator::{Board, Image, Part, Signal};
use firmware::motion::scaled::Scaled;
use firmware::motion::{PathSegment, queue};
use lang::part::SHORT_PULSE_US;
use lang::record::{AxisRecord, BoardRecord};

/// The shipped image, symbols and all.
pub fn board() -> Board {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../firmware/image/pasapas-f5529.elf");
    let bytes = std::fs::read(path).expect("the shipped image");
    let mut board = Board::new(Part::F5529, &Image::parse(&bytes).expect("an ELF file"));
    // Without a profile it drives no pin.
    let record = BoardRecord::DEFAULT.sealed().to_bytes();
    (lang::part::F5529.profiles[0]..).zip(record).for_each(|(at, byte)| board.poke8(at, byte));
    board
}

/// Rate of the step timer.
pub const HZ: u32 = lang::part::F5529.clock;
/// For the planner.
pub const CLOCK: Scaled = Scaled::constant(HZ);
/// Emulated ticks in a tick of the step timer.
pub const TICK: u64 = Part::F5529.ticks_per_second / HZ as u64;

/// Lets the firmware start, so that clocks and pins are its own; then the watchdog is held, the millisecond is
/// off, interrupts are off, and the CPU stands in an endless loop at the top of RAM.
pub fn quiet(board: &mut Board) {
    board.run_us(200_000);
    for (register, value) in [(WDTCTL, 0x5A80), (TA1CCTL0, 0), (TA1CCTL1, 0)] {
        board.bus_write16(register, value);
    }
    board.poke16(HOME, 0x3FFF);
    for (register, value) in [(0, HOME), (1, STACK), (2, 0)] {
        board.set_reg(register, value);
    }
}

/// Registers (SLAS590, peripheral file map).
pub const WDTCTL: u16 = 0x015C;
pub const TA1CCTL0: u16 = 0x0382;
pub const TA1CCTL1: u16 = 0x0384;

/// Top of RAM: an endless loop, the return address of a call, and below it the stack.
pub const HOME: u16 = 0x43FC;
pub const STACK: u16 = 0x43F0;

/// Segments that the path's engine holds, bytes of each, and bytes of all with the accumulators.
pub const SLOTS: u16 = queue::SLOTS as u16;
pub const SLOT: u16 = 36;
pub const PLAY: u16 = SLOTS * SLOT + 12;

/// The engine's memory, fed from outside as the firmware feeds it.
pub struct Engine {
    pub board: Board,
    pub play: u16,
    pub step: u16,
    fill: u16,
}

/// TA0CCTL0, TA0CCR0, TA0R, and the vector of the first; channels 1 to 3 are the axes'.
pub const CONTROL: u16 = 0x0342;
pub const COMPARE: u16 = 0x0352;
pub const COUNTER: u16 = 0x0350;
pub const VECTOR: u16 = 0xFFEA;
/// Place of the next event's time in the memory that both kinds of handlers share.
pub const DUE: u16 = 40;
/// Of ticks from DIR to STEP; the controls of channels are behind it.
pub const SETUP: u16 = 42;
/// P6OUT, whose lowest pins are DIR.
pub const DIR_OUT: u16 = 0x0243;

impl Engine {
    pub fn new(width_ticks: u16) -> Engine {
        let mut board = board();
        quiet(&mut board);
        let play = board.symbol("PASAPAS_PLAY").expect("play");
        let step = board.symbol("PASAPAS_STEP").expect("step");
        for at in (play..play + PLAY).chain(step..step + 34) {
            board.poke8(at, 0);
        }
        let handler = if width_ticks == 0 { "pasapas_path_event" } else { "pasapas_path_long" };
        let handler = board.symbol(handler).expect("handler");
        board.poke16(step, handler);
        board.poke16(step + 2, play);
        board.poke16(step + 20, width_ticks);
        board.bus_write8(DIR_OUT, 0);
        board.set_reg(2, 8);
        board.record(true);
        Engine { board, play, step, fill: 0 }
    }

    /// With another time from DIR to STEP, ticks, and STEP active low.
    pub fn with_signals(width_ticks: u16, setup_ticks: u16, low: bool) -> Engine {
        let mut engine = Engine::new(width_ticks);
        engine.board.poke16(engine.step + SETUP, setup_ticks);
        if low {
            let (rest, rise, fall) = (0x04, 0xA4, 0x20);
            for (n, value) in
                [rest, rise, fall, rest | 0x10, rise | 0x10, fall | 0x10].into_iter().enumerate()
            {
                engine.board.poke16(engine.step + SETUP + 2 + 2 * n as u16, value);
            }
            for axis in 1..4 {
                engine.board.bus_write16(CONTROL + 2 * axis, rest);
            }
            engine.board.take_edges();
        }
        engine
    }

    pub fn room(&mut self) -> bool {
        let slot = self.play + SLOT * self.fill;
        let free = self.board.peek16(slot + 8) == 0;
        free && (!self.running() || self.board.peek16(self.step + 2) != slot)
    }

    pub fn running(&mut self) -> bool {
        self.board.bus_read16(CONTROL) & 0x10 != 0
    }

    pub fn put(&mut self, s: &PathSegment) {
        let slot = self.play + SLOT * self.fill;
        let long = |board: &mut Board, at: u16, v: u32| {
            board.poke16(at, v as u16);
            board.poke16(at + 2, (v >> 16) as u16);
        };
        long(&mut self.board, slot, s.ramp.interval);
        long(&mut self.board, slot + 4, s.ramp.dif as u32);
        self.board.poke16(slot + 10, s.ramp.mask);
        for (n, inc) in s.inc.iter().enumerate() {
            long(&mut self.board, slot + 12 + 4 * n as u16, *inc);
        }
        let dirs = !s.negative & 0b111;
        for (n, acc) in s.acc.iter().enumerate() {
            self.board.poke16(slot + 24 + 2 * n as u16, *acc);
        }
        self.board.poke8(slot + 30, dirs);
        self.board.poke8(slot + 31, s.negative | u8::from(s.begin) << 7);
        self.board.poke16(slot + 8, s.ramp.events);
        let before = (self.fill + SLOTS - 1) % SLOTS;
        self.fill = (self.fill + 1) % SLOTS;
        if !self.running() {
            // The empty one before: the first interrupt then begins this one.
            self.board.poke16(self.step + 2, self.play + SLOT * before);
            let at = self.board.bus_read16(COUNTER).wrapping_add(160);
            self.board.poke16(self.step + DUE, at);
            self.board.bus_write16(COMPARE, at);
            self.board.bus_write16(CONTROL, 0x10);
        }
    }

    pub fn count(&self, axis: u16) -> i16 {
        self.board.peek16(self.step + 6 + 2 * axis) as i16
    }

    pub fn late(&self) -> u16 {
        self.board.peek16(self.step + 18)
    }
}

pub fn axes(top: u32) -> [AxisRecord; 3] {
    let axis = AxisRecord {
        steps: 400,
        um: 4000,
        start_rate: 400,
        top_rate: top,
        accel: 50_000,
        decel: 50_000,
        ..AxisRecord::default()
    };
    [axis, axis, axis]
}

/// Rising edges of each STEP pin, ticks, and their direction.
pub fn steps(engine: &mut Engine) -> [Vec<(u64, bool)>; 3] {
    let mut dirs = [false; 3];
    let mut out = [const { Vec::new() }; 3];
    let mut rose = [0; 3];
    for edge in engine.board.take_edges() {
        match edge.signal {
            Signal::Dir(a) => dirs[usize::from(a)] = edge.level,
            Signal::Step(a) if edge.level => {
                rose[usize::from(a)] = edge.cycle;
                out[usize::from(a)].push((edge.cycle / TICK, dirs[usize::from(a)]))
            }
            Signal::Step(a) => {
                let pulse = (edge.cycle - rose[usize::from(a)]) / TICK;
                let least = u64::from(SHORT_PULSE_US) * u64::from(HZ) / 1_000_000;
                assert!(pulse >= least, "a pulse of {pulse} ticks");
            }
            _ => {}
        }
    }
    out
}

/// Playing and next segment and fraction of each axis: 26 bytes.
pub const SINGLE: u16 = 26;

/// Hands a segment of one axis to the engine, as the firmware does.
pub fn put_axis(engine: &mut Engine, axis: u16, s: &firmware::motion::Segment, negative: bool) {
    let next = engine.play + SINGLE * axis + 12;
    for (at, value) in [(0, s.interval), (4, s.dif as u32)] {
        engine.board.poke16(next + at, value as u16);
        engine.board.poke16(next + at + 2, (value >> 16) as u16);
    }
    engine.board.poke16(next + 10, s.mask | u16::from(negative) << 15);
    engine.board.poke16(next + 8, s.events);
    let control = CONTROL + 2 + 2 * axis;
    if engine.board.bus_read16(control) & 0x10 == 0 {
        let at = engine.board.bus_read16(COUNTER).wrapping_add(160);
        engine.board.bus_write16(COMPARE + 2 + 2 * axis, at);
        engine.board.bus_write16(control, 0x10);
    }
}

/// A STEP pulse: axis, when it became active and when it ended, ticks of the timer.
#[derive(Clone, Copy, Debug)]
pub struct Pulse {
    pub axis: usize,
    pub from: u64,
    pub to: u64,
}

/// All whole pulses since the last call, in the order of their ends. `active` is the level of an active STEP.
pub fn pulses(engine: &mut Engine, active: bool) -> Vec<Pulse> {
    let mut begun = [None; 3];
    let mut out = Vec::new();
    for edge in engine.board.take_edges() {
        let Signal::Step(axis) = edge.signal else { continue };
        let (axis, at) = (usize::from(axis), edge.cycle / TICK);
        if edge.level == active {
            begun[axis] = Some(at);
        } else if let Some(from) = begun[axis].take() {
            out.push(Pulse { axis, from, to: at });
        }
    }
    out
}
