//! From reset to `main`: stack, watchdog, RAM; what RAM remembers over resets.

use crate::chip::clock;
use crate::flash;
use core::arch::global_asm;

// `msp430-rt`'s own start-up object uses a relocation that LLD does not know, so `Reset` is
// defined here: stack pointer, watchdog held until RAM is ready, .bss cleared, .data copied.
// RAM above .data is filled with A5A5 so that the stack's high-water mark can be read later.
global_asm!(
    r#"
    .section .Reset,"ax",@progbits
    .global Reset
Reset:
    mov #_stack_start, r1
    call #pasapas_hold_steps
    mov #0x5a80, &{watchdog}
    mov #_sbss, r12
1:  cmp #_ebss, r12
    jhs 2f
    clr 0(r12)
    incd r12
    jmp 1b
2:  mov #_sidata, r13
    mov #_sdata, r12
3:  cmp #_edata, r12
    jhs 4f
    mov 0(r13), 0(r12)
    incd r13
    incd r12
    jmp 3b
4:  cmp #_stack_start, r12
    jhs 5f
    mov #0xa5a5, 0(r12)
    incd r12
    jmp 4b
5:  br #main
    "#,
    watchdog = const clock::WATCHDOG,
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

/// Watchdog resets in a row, over any reset but power-up.
#[unsafe(link_section = ".noinit")]
static mut BITES: u16 = 0;

/// Counts this reset if the watchdog made it, and tells how many there were in a row.
pub fn bites(cause: u8) -> u16 {
    // SAFETY: one word that only this function and `restart` touch.
    unsafe {
        let place = core::ptr::addr_of_mut!(BITES);
        let before = if cause & 1 << 2 != 0 { 0 } else { place.read_volatile() };
        let bites = if cause & 1 != 0 { before.wrapping_add(1) } else { 0 };
        place.write_volatile(bites);
        bites
    }
}

/// Resets the chip. It counts as a bite, but this one was asked for.
pub fn restart() -> ! {
    msp430::interrupt::disable();
    // SAFETY: interrupts are off, and only `bites` touches the word otherwise.
    unsafe {
        let place = core::ptr::addr_of_mut!(BITES);
        place.write_volatile(place.read_volatile().wrapping_sub(1));
    }
    clock::reset()
}
