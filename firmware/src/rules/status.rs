//! Status words of the link in InterpCNC's layout (`lang::wire`, status).
#![cfg_attr(any(), micro(module = "link.status", prefix = "map_"))]

use super::{Axis, Machine};
use lang::isa::Op;
use lang::wire::{BLOCKS, COMMAND};

/// See [`Op::Home`]; the axes follow, then [`HOME_QUERY`].
#[cfg_attr(any(), micro("OP_HOME"))]
const HOME: u8 = Op::Home as u8;
/// See [`Op::HomeQuery`].
#[cfg_attr(any(), micro("OP_HOME_QUERY"))]
const HOME_QUERY: u8 = Op::HomeQuery as u8;
/// See [`Op::Probe`].
#[cfg_attr(any(), micro("OP_PROBE"))]
const PROBE: u8 = Op::Probe as u8;
/// Registers of the command buffer.
#[cfg_attr(any(), micro("COMMAND_WORDS"))]
pub const COMMAND_WORDS: u16 = {
    let mut n = 0;
    while BLOCKS[n].first != COMMAND {
        n += 1;
    }
    BLOCKS[n].count
};

/// Whether an axis homes.
#[cfg_attr(any(), micro(holds = "NO_CARRY"))]
pub fn homes(m: &impl Machine) -> bool {
    matches!(m.effect(), HOME..=HOME_QUERY)
}

/// The input that keeps Start or a move from working, from 1, or 0.
pub fn blocking(m: &impl Machine) -> u16 {
    u16::from(m.blocking())
}

/// Offset in the code of the statement that runs.
pub fn program_counter(m: &impl Machine) -> u16 {
    m.effect_pc().wrapping_sub(m.code())
}

/// Offset in the code of the failing instruction.
pub fn fault_pc(m: &impl Machine) -> u16 {
    m.fault_pc().wrapping_sub(m.code())
}

/// 1 in trace mode.
pub fn trace_mode(m: &impl Machine) -> u16 {
    u16::from(m.traces())
}

/// Input 17, the probe of the chain wiring.
pub fn probe_input(m: &impl Machine) -> u16 {
    u16::from(m.input_17())
}

/// Free words of the command buffer: all of them, or none while the machine works.
pub fn command_room(m: &impl Machine) -> u16 {
    if m.is_idle() { COMMAND_WORDS } else { 0 }
}

/// The PLC's status: bit 10, a program runs.
pub fn plc_status(m: &impl Machine) -> u16 {
    if m.is_active() { 1 << 10 } else { 0 }
}

/// InterpCNC's state word.
pub fn cnc_state(m: &impl Machine) -> u16 {
    let mut word = 0;
    if m.jogs() {
        word |= 1 << 5;
    }
    if m.is_fault() {
        word |= 1 << 0;
    }
    if m.is_active() {
        word |= 1 << 3;
    }
    if m.is_paused() {
        word |= 1 << 4;
    }
    if homes(m) {
        word |= 1 << 2;
    }
    if m.door() {
        word |= 1 << 6;
    }
    if m.emergency() {
        word |= 1 << 8;
    }
    word
}

/// Reference switches that are closed, at the negative end, in the high byte at the positive one.
pub fn limit_switches(m: &impl Machine) -> u16 {
    let mut word = 0;
    for axis in Axis::DOWN {
        if m.reference_closed(axis) {
            if m.home_positive(axis) {
                word |= u16::from(axis.bit()) << 8;
            } else {
                word |= u16::from(axis.bit());
            }
        }
    }
    word
}

/// High byte: the axis that probes.
pub fn probing(m: &impl Machine) -> u16 {
    let mut word = 0;
    if m.effect() == PROBE {
        let axis = m.axis();
        word |= u16::from(axis.bit()) << 8;
    }
    word
}

/// The axis that homes; high byte: those whose homing by command failed.
pub fn homing(m: &impl Machine) -> u16 {
    let mut word = u16::from(m.homing_failed()) << 8;
    if homes(m) {
        let axis = m.axis();
        word |= u16::from(axis.bit());
    }
    word
}
