//! From reset to `main`: stack, watchdog, RAM; what RAM remembers over resets.

use crate::chip::clock;
use crate::flash;
use core::arch::global_asm;

// `msp430-rt`'s own start-up object uses a relocation that LLD does not know, so `Reset` is
// defined here: stack pointer, STEP and DIR driven, .bss cleared, .data copied, the watchdog restarted with each word.
// RAM above .data is filled with A5A5 so that the stack's high-water mark can be read later.
global_asm!(
    r#"
    .section .Reset,"ax",@progbits
    .global Reset
Reset:
    mov #_stack_start, r1
    call #pasapas_hold_steps
    mov #{kick}, r11
    mov #0xa5a5, r10
    mov #_ebss, r9
    mov #_sbss, r12
    jmp 2f
1:  mov r11, &{watchdog}
    clr 0(r12)
    incd r12
2:  cmp r9, r12
    jlo 1b
    mov #_sidata, r13
    mov #_edata, r9
    mov #_sdata, r12
    jmp 4f
3:  mov r11, &{watchdog}
    mov 0(r13), 0(r12)
    incd r13
    incd r12
4:  cmp r9, r12
    jlo 3b
    jmp 6f
5:  mov r11, &{watchdog}
    mov r10, 0(r12)
    incd r12
6:  cmp r1, r12
    jlo 5b
    br #main
    "#,
    watchdog = const clock::WATCHDOG,
    kick = const clock::WATCHDOG_KICK,
);

pub use clock::{WATCHDOG, WATCHDOG_KICK, kick};

unsafe extern "C" {
    static _edata: u8;
}

/// Bytes between the statics and the deepest that the stack has reached since reset, even.
pub fn stack_free() -> u16 {
    // SAFETY: only the address of the linker's symbol is taken.
    let first = core::ptr::addr_of!(_edata) as u16;
    let mut at = first;
    // By words: some KB of them must not hold up the reply.
    while flash::read(at) == 0xA5A5 {
        at += 2;
    }
    at - first
}

/// Says that a program runs, over any reset but power-up.
#[unsafe(link_section = ".noinit")]
static mut RUNNING: u16 = 0;

const RUNS: u16 = 0x52A1;

/// Marks that a program runs.
pub fn mark(runs: bool) {
    // SAFETY: one word that only this module touches.
    unsafe { core::ptr::addr_of_mut!(RUNNING).write_volatile(if runs { RUNS } else { 0 }) };
}

/// Whether one ran before the reset.
pub fn is_marked() -> bool {
    // SAFETY: one word that only this module touches.
    unsafe { core::ptr::addr_of!(RUNNING).read_volatile() == RUNS }
}

/// Resets the chip.
pub fn restart() -> ! {
    msp430::interrupt::disable();
    clock::reset()
}
