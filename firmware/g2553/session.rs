//! Runs: Start, Stop, pauses, milliseconds, and the VM between its effects.

use crate::consts::constants;
use lang::image::at;
use lang::isa::{Op, flags};
use lang::record::feature;
use lang::vm::{entry, flag};
use lang::wire::RunState;

constants! {
    OP_FIRST_EFFECT = lang::isa::EFFECTS;
    OP_ERR = Op::Err;
    VM_ERROR = flag::ERROR;
    VM_EVENT = flag::EVENT;
    VM_MORE = flag::MORE;
    VM_WITHIN = flag::WITHIN;
    EVENT_KIND = flags::EVENT_KIND;
    ON_RISE = flags::ON_RISE;
    ON_FALL = flags::ON_FALL;
    ON_EVERY = flags::ON_EVERY;
    OFF_INPUT = flags::OFF_INPUT;
    EVENT_ASIDE_SIZE = crate::vm::PART.event_pool[0];
    EVENT_SIZE = crate::vm::PART.event_pool[1];
    // Byte 0 of an ON line: what it is for has come.
    EVENT_PENDING = 0x80;
    FEATURE_EVENTS = feature::EVENTS;
    CALL_EVENT = (entry::EVENT as u16) << 12;
    CALL_ERROR = (entry::ERROR as u16) << 12;
    FEATURE_LINES = feature::LINES;
    // Where an image's header says what the pool is made of (`lang::image`).
    IMAGE_ENTRY = at::ENTRY;
    IMAGE_CELLS = at::CELLS;
    IMAGE_CALLS = at::CALLS;
}

core::arch::global_asm!(include_str!("session/soft.s"), options(raw));
core::arch::global_asm!(include_str!("session/events.s"), options(raw));
core::arch::global_asm!(include_str!("session/run.s"), options(raw));
core::arch::global_asm!(include_str!("generated/handlers.s"), options(raw));
core::arch::global_asm!(include_str!("session/ticks.s"), options(raw));
core::arch::global_asm!(include_str!("generated/ticks.s"), options(raw));
core::arch::global_asm!(include_str!("session/session.s"), options(raw));
core::arch::global_asm!(include_str!("generated/session.s"), options(raw));

// The jump table of `soft` is in the order of the opcodes.
const _: () = assert!(
    Op::Erl as u8 == Op::Err as u8 + 1
        && Op::Leave as u8 == Op::Err as u8 + 2
        && Op::OnError as u8 == Op::Err as u8 + 3
        && Op::OnErrorStop as u8 == Op::Err as u8 + 4
        && Op::ResumeNext as u8 == Op::Err as u8 + 5
        && Op::Course as u8 == Op::Err as u8 - 3
        && Op::ToSteps as u8 == Op::Err as u8 - 2
        && Op::ToLength as u8 == Op::Err as u8 - 1
);

// RUN_ACTIVE tells active states from the others, and the lamp shows the first two as they are.
const _: () = assert!(
    RunState::Empty as u8 == 0
        && RunState::Ready as u8 == 1
        && RunState::Running as u8 == 2
        && RunState::Paused as u8 & 2 != 0
        && RunState::Stopping as u8 & 2 != 0
        && (RunState::Empty as u8 | RunState::Ready as u8 | RunState::Fault as u8) & 2 == 0
        && RunState::Paused as u8 & 1 != 0
        && RunState::Stopping as u8 & 1 == 0
);
