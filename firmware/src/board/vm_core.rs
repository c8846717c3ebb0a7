//! The VM's core in assembly: token threading, 32-bit operations with overflow checks.
//!
//! Its twin is `lang::vm`; the opcode table is `lang::isa`. The core runs the pure instructions
//! that are worth their bytes here and leaves with the code of everything else: effects, and the
//! few pure instructions that the main loop does in Rust (`vm.rs`).
//!
//! | register | holds |
//! |---|---|
//! | r4 | address of the code in flash |
//! | r5 | next instruction |
//! | r6 | expression stack, growing down; the value below the top |
//! | r7 | cells |
//! | r11:r10 | top of the expression stack |
//! | r8, r9, r12 to r15 | scratch |
//!
//! With n values on the stack r6 is `4 n` below its end: the lowest slot holds what was in r11:r10
//! when the stack was empty. So a stack of depth d needs d slots.
//!
//! Cycles (with the dispatch of 10): add 18, load 24, store 27, small constant 27, `nextword` 54.

use crate::vm::{CALLS, CALLS_END_AT, FRAME_AT, PART, SAVES, State, VM};
use ::core::arch::global_asm;
use ::core::mem::offset_of;
use lang::isa::Op;
use lang::record::feature;

/// What [`run`] returns when the slice is used up.
pub const YIELD: u16 = 0x200;
/// What [`run`] returns when an event handler was left.
pub const HANDLER_END: u16 = 0x300;

#[cfg(feature = "virtual")]
unsafe extern "C" {
    fn pasapas_vm_run() -> u16;
}

/// Runs until an instruction that the core leaves to its caller (its code is returned), a fault,
/// whose number is returned plus 100
/// hexadecimal, or the poll flag at a backward jump or a call.
#[cfg(feature = "virtual")]
pub fn run() -> u16 {
    // SAFETY: the state in `VM` was made by `vm.rs` for a verified program, so every address that
    // the core forms lies in the pool or in the program.
    unsafe { pasapas_vm_run() }
}

// In this order the hot middle is within reach of a jump, 1 KB, from everywhere.
global_asm!(
    r#"
    .set CORE_VM, {vm}
    .set CORE_CALLS_START, {calls_start}
    .set CORE_POLL, {poll}
    .set CORE_FLAGS, {flags}
    .set CORE_BASE, {base}
    .set CORE_CALLS, {calls}
    .set CORE_CALLS_END, {calls_end}
    .set CORE_DATA, {data}
    .set CORE_FRAME, {frame}
    .set CORE_SAVES, {saves}
    .set CORE_EVENTS, {has_events}
    .set CORE_LINES, {has_lines}
    .set CORE_MORE, {more}
    .set CORE_MOVE_TO, {move_to}
    .set CORE_RAPID, {rapid}
    .set CORE_LINE, {line}
    .set CORE_LINEAR, {linear}
    .set CORE_MOVE, {move_flags}
    .set CORE_PROBE, {probe}
    .set CORE_FEED, {feed}
    .set CORE_WAIT, {wait}
    .set CORE_YIELD, {yield_code}
    .set CORE_HANDLER_END, {handler_end}
    .set CORE_IMAGE_CELLS, {image_cells}-{code}
    .set CORE_IMAGE_FRAME, {image_frame}-{code}
    .set CORE_KIND_SUB, {kind_sub}
    .set CORE_KIND_EVENT, {kind_event}
    "#,
    include_str!("vm_core/notation.s"),
    include_str!("vm_core/arithmetic.s"),
    include_str!("vm_core/constants.s"),
    include_str!("vm_core/tables.s"),
    include_str!("vm_core/core.s"),
    include_str!("vm_core/flow.s"),
    include_str!("vm_core/calls.s"),
    include_str!("vm_core/opcodes.s"),
    vm = sym VM,
    calls_start = sym CALLS,
    poll = const offset_of!(State, poll),
    flags = const offset_of!(State, flags),
    base = const offset_of!(State, base),
    calls = const offset_of!(State, calls),
    calls_end = const CALLS_END_AT,
    data = const offset_of!(State, data),
    frame = const FRAME_AT,
    saves = const SAVES,
    has_events = const PART.features & feature::EVENTS,
    has_lines = const PART.features & feature::LINES,
    more = const lang::vm::flag::MORE,
    move_to = const Op::MoveTo as u8,
    rapid = const Op::Rapid as u8,
    line = const Op::Line as u8,
    linear = const Op::Linear as u8,
    move_flags = const Op::Move as u8,
    probe = const Op::Probe as u8,
    feed = const Op::Feed as u8,
    wait = const Op::Wait as u8,
    yield_code = const YIELD,
    handler_end = const HANDLER_END,
    image_cells = const lang::image::at::CELLS,
    image_frame = const lang::image::at::FRAME,
    code = const firmware::verify::CODE,
    kind_sub = const (lang::vm::entry::SUB as u16) << 12,
    kind_event = const (lang::vm::entry::EVENT as u16) << 12,
);

// The table of instructions is in the order of the codes; bits of some codes tell what they do.
const _: () = assert!(
    Op::Byte as u8 == 0x01
        && Op::Shl as u8 == 0x0E
        && Op::Lt as u8 == 0x19
        && Op::Xor as u8 == 0x1F
        && Op::JumpZero as u8 == 0x24
        && Op::JumpLt as u8 == 0x29
        && Op::ForStep as u8 == 0x30
        && Op::NextShort as u8 == 0x34
        && Op::Zero as u8 == 0x3C
        && Op::TableFar as u8 == 0x47
        && Op::Leave as u8 == 0x4D
        && Op::More as u8 == 0x51
        && Op::Small as u8 == 0x60
        && lang::vm::entry::GOSUB == 0
        && Op::MoveToMm as u8 == 0xA0
        && Op::ProbeMm as u8 == 0xAF
);
