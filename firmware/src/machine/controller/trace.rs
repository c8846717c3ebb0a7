//! Trace mode: events for the host.

use super::Controller;
use crate::machine::chip::Chip;
use crate::machine::motor::tag;
use crate::machine::pool;
use lang::wire::{Exception, TRACE_OK, TRACE_QUEUE_LENGTH, TRACE_QUEUED, TraceKind};

/// Events that a queue holds, a power of two.
pub const ROOM: u8 = 32;
/// Words of an event in the queue: all registers of [`TRACE_QUEUE_LENGTH`] but its number.
const WORDS: u16 = TRACE_QUEUE_LENGTH - 1;
const _: () = assert!(ROOM as usize * WORDS as usize <= pool::QUEUE_WORDS);

/// Address of event `number` in the queue: the last of the memory after the pool. While the queue is in use nobody
/// else has this memory.
fn slot_of<C: Chip>(chip: &C, number: u16) -> u16 {
    chip.pool() + 2 * (pool::QUEUE as u16 + (number & (u16::from(ROOM) - 1)) * WORDS)
}

/// What happened.
#[derive(Clone, Copy)]
pub struct Told {
    /// [`TraceKind`] and argument.
    pub kind: u8,
    /// See `kind`.
    pub argument: u8,
    /// Where the effect stands in the code.
    pub pc: u16,
    /// Its value.
    pub value: i32,
    /// Commanded places then, steps.
    pub commanded: [i32; 3],
}

/// The events that a host in trace mode has not received yet: one, or a queue of [`ROOM`].
pub struct Trace {
    /// Trace mode.
    pub on: bool,
    /// The program need not wait for each event.
    queued: bool,
    /// There is no room for another event.
    pub full: bool,
    /// Number of the last event.
    pub number: u16,
    /// The newest event.
    pub newest: Told,
    /// How many of them were not received, of a queue.
    waiting: u8,
    /// Milliseconds until trace mode ends, as its reader has gone.
    left: u16,
}

/// Trace mode ends so long after its reader, ms.
const PATIENCE: u16 = 2000;

impl Trace {
    /// A millisecond without a reader.
    pub(super) fn tick(&mut self) {
        self.left = self.left.saturating_sub(1);
        if self.left == 0 {
            self.on = false;
            self.full = false;
            self.waiting = 0;
        }
    }

    /// Whether the queue's memory is in use.
    pub fn has_queue(&self) -> bool {
        self.on && self.queued
    }

    /// What a host writes to TRACE_MODE. A queue is for nobody whose pieces may be in its memory.
    pub fn set(&mut self, mode: u16) {
        self.on = mode != 0;
        self.queued = mode == TRACE_QUEUED;
        self.full = false;
        self.waiting = 0;
        self.left = PATIENCE;
    }

    /// A run begins. A host may halt the program before its first effect, but from a queue.
    pub(super) fn begin(&mut self) {
        self.number = 0;
        self.waiting = 0;
        self.full = self.on && !self.queued;
    }

    /// Whether events of the last run were not received.
    pub(super) fn is_unread(&self) -> bool {
        self.full || self.waiting != 0
    }

    fn put<C: Chip>(&mut self, chip: &C, told: Told) {
        self.number = self.number.wrapping_add(1);
        self.newest = told;
        self.full = true;
        if self.queued {
            let slot = slot_of(chip, self.number);
            chip.set_word(slot, u16::from_le_bytes([told.kind, told.argument]));
            chip.set_word(slot + 2, told.pc);
            chip.set_long(slot + 4, told.value);
            let mut at = slot + 8;
            for place in told.commanded {
                chip.set_long(at, place);
                at += 4;
            }
            if self.waiting != ROOM {
                self.waiting += 1;
            }
            self.full = self.waiting == ROOM;
        }
    }

    /// A register of the queue: of its events, oldest first, [`TRACE_QUEUE_LENGTH`] each; 0 behind the newest.
    pub fn queue<C: Chip>(&mut self, chip: &C, at: u16) -> u16 {
        self.left = PATIENCE;
        let mut n = 0;
        let mut field = at;
        while field >= TRACE_QUEUE_LENGTH {
            field -= TRACE_QUEUE_LENGTH;
            n += 1;
        }
        if n >= u16::from(self.waiting) {
            return 0;
        }
        let number = self.number.wrapping_sub(u16::from(self.waiting)).wrapping_add(n + 1);
        match field {
            0 => number,
            _ => chip.word(slot_of(chip, number) + 2 * (field - 1)),
        }
    }

    /// The host has received the events up to number `number`; `false` when they are not there.
    pub fn take(&mut self, number: u16) -> bool {
        let later = self.number.wrapping_sub(number);
        if later > u16::from(self.waiting) {
            return false;
        }
        self.waiting = later as u8;
        if self.queued {
            self.full = false;
        }
        true
    }
}

impl<C: Chip> Controller<C> {
    /// A host begins or ends trace mode.
    ///
    /// # Errors
    /// A streamed job runs: nobody who feeds it takes the events, and the axes would stand. One has the memory of the
    /// queue.
    pub fn set_trace(&mut self, mode: u16) -> Result<(), Exception> {
        let active = self.session.is_active();
        if mode != 0 && active && self.vm.is_piece {
            return Err(Exception::Busy);
        }
        if mode == TRACE_QUEUED && !self.stream.gives_queue() {
            if active {
                return Err(Exception::Busy);
            }
            self.forget_pieces();
        }
        self.trace.set(mode);
        Ok(())
    }

    /// One event for the host; there is room when this is called.
    pub fn emit(&mut self, kind: TraceKind, argument: u8, value: i32) {
        let pc = self.pc_of_effect();
        self.chip.event(kind as u8, argument, value, &self.motor.steps, pc);
        if !self.trace.on {
            return;
        }
        let commanded = self.motor.steps;
        self.trace.put(&self.chip, Told { kind: kind as u8, argument, pc, value, commanded });
    }

    /// A block of the path is about to be appended: its tag. Its beginning is an event, but of a rapid move, which
    /// begins at once. A host in trace mode is told here, and so is who observes a streamed job, whose pieces
    /// have no lasting place.
    pub fn tell_block(&mut self, kind: TraceKind) -> u32 {
        let pc = self.pc_of_effect();
        let at_once = kind as u8 == TraceKind::Rapid as u8;
        if at_once || self.trace.on || self.vm.is_piece {
            self.emit(kind, 0, 0);
            return tag(None, pc);
        }
        tag(Some(kind), pc)
    }

    /// Whether the path would take another block: in trace mode one ahead of the playing one.
    pub fn path_has_room(&self) -> bool {
        self.motor.path_has_room(self.trace.on)
    }

    /// Where what runs stands in memory: the statement of the path's block that plays, else the effect's.
    pub fn place(&self) -> u16 {
        match self.motor.block_pc() {
            Some(pc) if !self.vm.is_piece => pc.wrapping_add(self.vm.code),
            _ => self.program.pc,
        }
    }

    /// Address of the effect's instruction in the program's code.
    pub fn pc_of_effect(&self) -> u16 {
        self.program.pc.wrapping_sub(self.vm.code)
    }

    /// An event with an outcome.
    pub fn emit_outcome(&mut self, kind: TraceKind, argument: u8, ok: bool, value: i32) {
        self.emit(kind, argument | if ok { TRACE_OK } else { 0 }, value);
    }

    /// The program waits with its next effect for the host that traces.
    pub fn waits(&self) -> bool {
        self.trace.full && self.program.effect.code != 0 && self.program.effect.phase == 0
    }

    /// The host has received every event before number `number`.
    pub fn received(&mut self, odd: bool) {
        self.trace.left = PATIENCE;
        // Reading the slot of the other parity says that the event in this one was received.
        if self.trace.full && (self.trace.number & 1 != 0) != odd {
            self.trace.full = false;
        }
    }
}
