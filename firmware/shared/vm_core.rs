//! The VM's core in assembly: token threading, 32-bit operations with overflow checks.
//!
//! `lang::vm` is the reference model; the opcode table is `lang::isa`. The core runs the pure instructions
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

use crate::vm::{CALLS, CALLS_END_AT, FRAME_AT, PART, SAVES, State, VM, VM_AT};
use core::arch::global_asm;
use core::mem::offset_of;
use firmware::machine::vm::{HANDLER_END, YIELD};
use lang::isa::Op;
use lang::record::feature;

#[cfg(feature = "f5529")]
unsafe extern "C" {
    fn pasapas_vm_run(vm: *mut core::ffi::c_void) -> u16;
}

/// Runs until an instruction that the core leaves to its caller (its code is returned), a fault,
/// whose number is returned plus 100
/// hexadecimal, or the poll flag at a backward jump or a call.
#[cfg(feature = "f5529")]
pub fn run(vm: &mut State) -> u16 {
    // SAFETY: the registers, which the core finds by their address, were made for a verified program, so every
    // address that the core forms lies in the pool or in the program.
    unsafe { pasapas_vm_run(core::ptr::from_mut(vm).cast()) }
}

/// Codes of the table of instructions: what only parts with error handlers or events have ends it.
const TABLE_END: u8 = if PART.features & feature::ACTIONS != 0 {
    Op::SetAout as u8 + 1
} else if PART.features & feature::EVENTS != 0 {
    Op::More as u8 + 1
} else if PART.features & feature::LINES != 0 {
    Op::ResumeNext as u8 + 1
} else {
    Op::Leave as u8
};

/// The addresses of the routines `vm_MNEMONIC`, in the order of the codes.
macro_rules! handlers {
    ($($code:literal x $count:literal $name:ident $text:literal $operands:ident $pops:literal
       $pushes:literal $class:ident $doc:literal;)*) => {
        concat!($(
            ".if ", $code, " < CORE_TABLE_END\n",
            ".rept ", $count, "\n.short vm_", $text, "\n.endr\n.endif\n",
        )*)
    };
}

/// Four short forms from the n-th on, each its effect and in the high byte the number of its values
/// less one.
const fn short_forms(n: u8) -> u64 {
    let (mut words, mut at) = (0, n + 4);
    while at > n {
        at -= 1;
        let Some(inline) = lang::isa::inline(Op::MoveToMm as u8 + at) else {
            panic!("16 codes are short forms")
        };
        words = words << 16 | (inline.code as u64 | (inline.values as u64 - 1) << 8);
    }
    words
}

// In this order the hot middle is within reach of a jump, 1 KB, from everywhere.
global_asm!(
    r#"
    .set CORE_VM, {vm}+{vm_at}
    .set CORE_CALLS_START, {calls_start}
    .set CORE_TABLE_END, {table_end}
    .set CORE_PC, {pc}
    .set CORE_SP, {sp}
    .set CORE_TOP, {top}
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
    .set CORE_MATHS, {has_maths}
    .set CORE_MORE, {more}
    .set CORE_YIELD, {yield_code}
    .set CORE_HANDLER_END, {handler_end}
    .set CORE_IMAGE_CELLS, {image_cells}-{code}
    .set CORE_IMAGE_FRAME, {image_frame}-{code}
    .set CORE_CALL_BYTES, {call_bytes}
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
    lang::opcode_rows!(handlers),
    "vm_inlines: .quad {}, {}, {}, {}",
    const short_forms(0),
    const short_forms(4),
    const short_forms(8),
    const short_forms(12),
    vm = sym VM,
    vm_at = const VM_AT,
    calls_start = sym CALLS,
    table_end = const TABLE_END,
    pc = const offset_of!(State, pc),
    sp = const offset_of!(State, sp),
    top = const offset_of!(State, top),
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
    has_maths = const PART.features & feature::MATHS,
    more = const lang::vm::flag::MORE,
    yield_code = const YIELD,
    handler_end = const HANDLER_END,
    image_cells = const lang::image::at::CELLS,
    image_frame = const lang::image::at::FRAME,
    code = const firmware::verify::CODE,
    call_bytes = const PART.call_bytes,
    kind_sub = const (lang::vm::entry::SUB as u16) << 12,
    kind_event = const (lang::vm::entry::EVENT as u16) << 12,
);

// The core loads the first fields in this order.
const _: () = assert!(
    offset_of!(State, pc) == 0
        && offset_of!(State, sp) == 2
        && offset_of!(State, top) == 4
        && offset_of!(State, code) == 8
        && offset_of!(State, cells) == 10
);

// The table of instructions has no gap.
const _: () = {
    let (mut n, mut next) = (0, 0);
    while next < TABLE_END {
        assert!(lang::isa::ROWS[n].code == next);
        next += lang::isa::ROWS[n].count;
        n += 1;
    }
    assert!(next == TABLE_END);
};

// Bits of some codes tell what they do.
const _: () = assert!(
    Op::Shl as u8 == 0x0E
        && Op::Lt as u8 == 0x19
        && Op::JumpZero as u8 == 0x24
        && Op::JumpLt as u8 == 0x29
        && Op::NextShort as u8 == 0x34
        && Op::Zero as u8 == 0x3C
        && Op::Small as u8 == 0x60
        && Op::MoveToMm as u8 == 0xA0
        && lang::vm::entry::GOSUB == 0
);
