//! The hook for an observer of the chip: a routine that does nothing, called at the instant of each effect
//! with the effect's code and arguments. The emulator stops in front of it and reads the arguments. The firmware never
//! waits for it, so an observed run takes exactly as long as an unobserved one.

use core::arch::global_asm;

use lang::wire::Seen;

global_asm!(
    r#"
    .section .text.observe,"ax",@progbits
    .global pasapas_observe
pasapas_observe:
    ret
    "#
);

unsafe extern "C" {
    /// `code`: kind of the event and its argument; kind 0 is no event, its value a [`Seen`].
    fn pasapas_observe(code: u16, value: i32, commanded: *const [i32; 3], pc: u16);
}

/// An event of the trace ([`TraceKind`]), with the commanded places, steps, and its address in the code.
pub fn event(kind: u8, argument: u8, value: i32, commanded: &[i32; 3], pc: u16) {
    let code = u16::from_le_bytes([kind, argument]);
    // SAFETY: the routine returns at once.
    unsafe { pasapas_observe(code, value, commanded, pc) }
}

/// Something beside the events; `byte` belongs to [`Seen::Byte`].
pub fn beside(what: Seen, byte: u8, pc: u16) {
    let code = u16::from_le_bytes([0, byte]);
    // SAFETY: the routine returns at once and does not look at the null pointer.
    unsafe { pasapas_observe(code, what as i32, core::ptr::null(), pc) }
}
