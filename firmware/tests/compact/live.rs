//! The whole board, running by itself: a program in flash, a plant at the pins, and a host that
//! takes the trace events out of RAM.

use emulator::plant::Contact;
use emulator::{Board, Wiring};
use lang::profile::Profile;
use lang::record::BoardRecord;
use lang::wire::{RunState, TraceKind};

use crate::chip::{BOOT_US, Chip};
use crate::rig::{COMMITTED, Event, IMAGE, PROFILE, SLOT, T_FULL, T_HEARD, T_ON, image_of};

/// Time between two looks of the host, us.
const SLICE: u64 = 200;

/// See the module.
pub struct Live {
    /// The board.
    pub board: Board,
    /// Trace events so far.
    pub events: Vec<Event>,
    /// Commanded places at each of them, steps.
    pub targets: Vec<[i32; 3]>,
}

impl Live {
    /// A board that has come up with this profile and this program.
    pub fn new(profile: &Profile, script: &str) -> Live {
        let direct = profile.wiring == lang::profile::Wiring::Direct;
        let wiring = if direct { Wiring::Direct } else { Wiring::Chain };
        let mut board = Chip::wired(wiring).board;
        let mut put = |first: u16, bytes: &[u8]| {
            for (address, &byte) in (first..).zip(bytes) {
                board.poke8(address, byte);
            }
        };
        put(SLOT, &COMMITTED.to_le_bytes());
        put(IMAGE, &image_of(profile, script));
        put(PROFILE, &BoardRecord::of(profile, 1).to_bytes());
        board.reset_pin();
        let mut live = Live { board, events: Vec::new(), targets: Vec::new() };
        // RAM is anything until the chip has cleared it.
        live.board.run_us(BOOT_US + 100_000);
        assert_eq!(live.state(), RunState::Ready);
        let tracing = live.at("TRACING");
        live.board.poke8(tracing, *T_ON | *T_HEARD);
        live
    }

    /// With a contact of an axis as its reference switch.
    pub fn with_switch(mut self, axis: usize, position: i64, above: bool) -> Live {
        let contact = Contact { axis, position, above };
        self.board.plant_mut().switches[axis] = Some(contact);
        self
    }

    /// Address of a symbol.
    pub fn at(&self, symbol: &str) -> u16 {
        self.board.symbol(symbol).unwrap_or_else(|| panic!("the image has no {symbol}"))
    }

    /// The byte at a symbol.
    pub fn byte(&self, symbol: &str) -> u8 {
        self.board.peek8(self.at(symbol))
    }

    /// The three 32-bit values at a symbol.
    pub fn longs(&self, symbol: &str) -> [i32; 3] {
        let at = self.at(symbol);
        [0, 4, 8].map(|offset| {
            let (low, high) = (self.board.peek16(at + offset), self.board.peek16(at + offset + 2));
            (u32::from(high) << 16 | u32::from(low)).cast_signed()
        })
    }

    /// The run state, without WaitStart.
    pub fn state(&self) -> RunState {
        RunState::from_number(self.byte("RUN").into()).expect("a run state")
    }

    /// Where the motors stand, steps.
    pub fn motors(&self) -> [i64; 3] {
        [0, 1, 2].map(|n| self.board.plant().motors[n].position)
    }

    /// Lets time pass; the host takes what comes.
    pub fn run_ms(&mut self, ms: u64) {
        for _ in 0..ms * 1000 / SLICE {
            self.board.run_us(SLICE);
            self.take();
        }
    }

    fn take(&mut self) {
        let at = self.at("TRACING");
        let flags = self.board.peek8(at) | *T_HEARD;
        self.board.poke8(at, flags);
        if flags & *T_FULL == 0 {
            return;
        }
        // The board may be just about to fill the slot; it waits with a full one.
        self.board.run_us(50);
        let kind = self.byte("TRACE_KIND");
        let argument = self.byte("TRACE_ARGUMENT");
        let value = self.longs("TRACE_VALUE")[0];
        // A run begins as if there had been an event 0.
        if self.board.peek16(self.at("TRACE_NUMBER")) != 0 {
            self.events.push(Event { kind, argument, value });
            self.targets.push(self.longs("STEPS"));
        }
        self.board.poke8(at, flags & !*T_FULL);
    }

    /// Presses Start.
    pub fn start(&mut self) {
        self.board.plant_mut().press_start(true);
        self.run_ms(30);
        self.board.plant_mut().press_start(false);
    }

    /// Starts the program and waits for its end.
    ///
    /// # Panics
    /// It has not ended after this time.
    pub fn finish(&mut self, ms: u64) {
        self.start();
        let end = |event: &Event| event.kind == TraceKind::End as u8;
        for _ in 0..ms / 10 {
            if self.events.iter().any(end) {
                return;
            }
            self.run_ms(10);
        }
        panic!("no end after {ms} ms: {:?} {:?}", self.events, self.longs("ACTUAL"));
    }
}
