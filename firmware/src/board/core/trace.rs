//! What the host is told in trace mode, event by event.

use super::Core;
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

impl Core {
    /// One event for the host; the slot is free when this is called.
    pub fn emit(&mut self, kind: TraceKind, argument: u8, value: i32) {
        let pc = self.pc_of_effect();
        observe::event(kind, argument, value, &self.motor.steps, pc);
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

    /// Address of the effect's instruction in the program's code.
    pub fn pc_of_effect(&self) -> u16 {
        self.effect_pc.wrapping_sub(vm().code)
    }

    /// An event with an outcome.
    pub fn emit_outcome(&mut self, kind: TraceKind, argument: u8, ok: bool, value: i32) {
        self.emit(kind, argument | if ok { TRACE_OK } else { 0 }, value);
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
