//! What the host is told in trace mode, event by event.

use super::Controller;
use crate::motor::tag;
use crate::observe;
use crate::vm::vm;
use lang::wire::{TRACE_OK, TraceKind};

/// The event that a host in trace mode has not received yet.
pub struct Trace {
    /// Trace mode.
    pub on: bool,
    /// The slot holds an event that was not received.
    pub full: bool,
    /// Number of the last event.
    pub number: u16,
    /// [`TraceKind`] and argument.
    pub kind: u8,
    /// See `kind`.
    pub argument: u8,
    /// Where the effect stands in the code.
    pub pc: u16,
    /// Its value.
    pub value: i32,
    /// Milliseconds until trace mode ends, as its reader has gone.
    pub left: u16,
}

/// Trace mode ends so long after its reader, ms.
pub const PATIENCE: u16 = 2000;

impl Trace {
    /// A millisecond without a reader.
    pub(super) fn tick(&mut self) {
        self.left = self.left.saturating_sub(1);
        if self.left == 0 {
            self.on = false;
            self.full = false;
        }
    }
}

impl Controller {
    /// One event for the host; the slot is free when this is called.
    pub fn emit(&mut self, kind: TraceKind, argument: u8, value: i32) {
        let pc = self.pc_of_effect();
        observe::event(kind as u8, argument, value, &self.motor.steps, pc);
        if !self.trace.on {
            return;
        }
        self.trace.number = self.trace.number.wrapping_add(1);
        self.trace.full = true;
        self.trace.kind = kind as u8;
        self.trace.argument = argument;
        self.trace.pc = pc;
        self.trace.value = value;
    }

    /// A block of the path is about to be appended: its tag. Its beginning is an event, but of a rapid move, which
    /// begins at once. A host in trace mode is told here, and so is who observes a streamed job, whose pieces
    /// have no lasting place.
    pub fn tell_block(&mut self, kind: TraceKind) -> u32 {
        let pc = self.pc_of_effect();
        let at_once = kind as u8 == TraceKind::Rapid as u8;
        if at_once || self.trace.on || crate::streams() {
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
            Some(pc) if !crate::streams() => pc.wrapping_add(vm().code),
            _ => self.effect_pc,
        }
    }

    /// Address of the effect's instruction in the program's code.
    pub fn pc_of_effect(&self) -> u16 {
        self.effect_pc.wrapping_sub(vm().code)
    }

    /// An event with an outcome.
    pub fn emit_outcome(&mut self, kind: TraceKind, argument: u8, ok: bool, value: i32) {
        self.emit(kind, argument | if ok { TRACE_OK } else { 0 }, value);
    }

    /// The program waits with its next effect for the host that traces.
    pub fn waits(&self) -> bool {
        self.trace.full && self.effect.code != 0 && self.effect.phase == 0
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
