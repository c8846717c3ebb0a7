//! The flash controller. A word takes 64 to 85 us, an erase 23 to 32 ms. Code in RAM starts either and waits for it, so no
//! character of the back channel and no millisecond is lost, and an emergency stop switches outputs at once. A word started
//! from flash would hold the processor, with interrupts off, for as long as a character lasts at 115200 bit/s (86.8 us): with
//! flash as slow as the data sheet allows, the link would lose a character now and then.

use super::reg::{FCTL1, FCTL3, P3SEL, SFRIE1, UCA1IE, UCA1IFG};
use super::{clock, ports, timer};
use crate::flash::Key;
use crate::guard;
use core::arch::global_asm;

unsafe extern "C" {
    /// Starts an operation by a write of `word`, and comes back when it is done. `mode` and `key` make FCTL1.
    fn pasapas_flash(address: u16, key: u16, mode: u16, word: u16);
}

/// One operation: unlocked, triggered by a write of `word`, locked again. Interrupts are off, and those of the
/// link are served meanwhile as if they were not.
#[inline(always)]
pub fn operate(key: Key, mode: u16, address: u16, word: u16) {
    // No interrupt finds its vector while flash is busy, neither the crystal's nor the supply's.
    let enabled = SFRIE1.get();
    SFRIE1.set(0);
    clock::watch_supply(false);
    // SAFETY: the caller has tested that the address lies in flash that no code runs from.
    unsafe { pasapas_flash(address, key.0, mode, word) };
    clock::watch_supply(true);
    SFRIE1.set(enabled);
}

/// Levels of the outputs behind an emergency stop.
#[unsafe(no_mangle)]
static mut PASAPAS_STOP: u16 = 0;

/// Levels that the outputs get while flash is busy if an emergency stop comes.
#[inline(always)]
pub fn remember_stop(levels: u16) {
    // SAFETY: a word, which is read with interrupts off.
    unsafe { (&raw mut PASAPAS_STOP).write_volatile(levels) };
}

// r12 address, r13 key, r14 mode, r15 word. A handler is entered as by its interrupt, with the address behind and the status register
// on the stack. What the guard's have found the main loop sees to afterwards, but the outputs, once (r15).
global_asm!(
    r#"
    .section .data.flash,"awx",@progbits
module.chip.flash:
    .global pasapas_flash
pasapas_flash:
    mov r13, &{fctl3}
    bis r13, r14
    mov r14, &{fctl1}
    mov r15, 0(r12)
    clr r15
1:  mov #{kick}, &{watchdog}
    bit.b #1, &{uart_flags}
    jeq 2f
    push #2f
    push r2
    br #pasapas_receive
2:  mov.b &{uart_enables}, r14
    and.b &{uart_flags}, r14
    bit.b #2, r14
    jeq 3f
    push #3f
    push r2
    br #pasapas_transmit
3:  mov &{silence}, r14
    and #0x0011, r14
    cmp #0x0011, r14
    jne 4f
    push #4f
    push r2
    br #pasapas_silence
4:  mov.b &{pins_enables}, r14
    bit.b &{pins_flags}, r14
    jeq 5f
    push #5f
    push r2
    br #pasapas_pins
5:  bit #1, &{ms}
    jeq 6f
    bic #1, &{ms}
    add #{per_ms}, &{ms_due}
    inc &{millis}
    tst &PASAPAS_GUARD+{inputs}
    jeq 6f
    push #6f
    push r2
    br #pasapas_guard_alone
6:  tst.b &PASAPAS_GUARD+{tripped}
    jeq 9f
    tst r15
    jne 9f
    inc r15
    bit.b #{chain}, &{chain_select}
    jne 7f
    /* outputs 1 and 2 at the pins */
    bit #1, &PASAPAS_STOP
    jne 8f
    bic.b #{latch}, &{latch_out}
    jmp 5f
8:  bis.b #{latch}, &{latch_out}
5:  bit #2, &PASAPAS_STOP
    jne 8f
    bic.b #{enable}, &{enable_out}
    jmp 9f
8:  bis.b #{enable}, &{enable_out}
    jmp 9f
7:  mov.b &PASAPAS_STOP+1, &{spi}
8:  bit.b #1, &{spi_stat}
    jne 8b
    mov.b &PASAPAS_STOP, &{spi}
8:  bit.b #1, &{spi_stat}
    jne 8b
    bic.b #{latch}, &{latch_out}
    bis.b #{latch}, &{latch_out}
9:  bit #1, &{fctl3}
    jne 1b
    mov r13, &{fctl1}
    bis #0x10, r13
    mov r13, &{fctl3}
    ret
    "#,
    fctl1 = const FCTL1.0,
    fctl3 = const FCTL3.0,
    kick = const clock::WATCHDOG_KICK,
    watchdog = const clock::WATCHDOG,
    uart_flags = const UCA1IFG.0,
    uart_enables = const UCA1IE.0,
    silence = const timer::SILENCE_CCTL,
    pins_enables = const ports::IE,
    pins_flags = const ports::IFG,
    ms = const timer::MS_CCTL,
    ms_due = const timer::MS_CCR,
    per_ms = const timer::PER_MS,
    millis = sym crate::link::MILLIS,
    inputs = const guard::INPUTS_AT,
    tripped = const guard::TRIPPED_AT,
    chain = const ports::P3_CHAIN,
    chain_select = const P3SEL.0,
    spi = const ports::SPI_TXBUF,
    spi_stat = const ports::SPI_STAT,
    latch = const ports::LATCH,
    latch_out = const ports::LATCH_OUT,
    enable = const ports::ENABLE,
    enable_out = const ports::ENABLE_OUT,
);
