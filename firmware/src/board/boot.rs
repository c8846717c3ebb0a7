//! From reset to `main`: stack, watchdog, RAM, clock, ports.

use crate::pins::*;
use crate::reg::{self, set};
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
    mov #0x5a80, &0x0120
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
    "#
);

/// The boot loader's key word: its entry by pins stays possible, a wrong password erases nothing.
#[unsafe(link_section = ".bslkey")]
#[used]
static BSL_KEY: u16 = 0x0000;

/// WDTCTL: password, counter clear, from ACLK (VLO), over 512: 43 ms typical, 25 to 128 ms.
const WATCHDOG_KICK: u16 = 0x5A00 | 1 << 3 | 1 << 2 | 0b10;

/// Restarts the watchdog's interval.
#[inline(always)]
pub fn kick() {
    set!(reg::watchdog().wdtctl, WATCHDOG_KICK);
}

/// 16 MHz from the factory calibration, ACLK from the VLO, pins to their safe states, timer and
/// UART running; interrupts are still off.
pub fn hardware() {
    let clock = reg::clock();
    let calibration = reg::calibration();
    // Erased calibration bytes (FF) would run the DCO beyond the chip's limit: then the reset
    // value of 1.1 MHz stays, the link is dead and nothing moves.
    let bc1 = calibration.calbc1_16mhz.read().bits();
    if bc1 != 0xFF {
        set!(clock.dcoctl, 0);
        set!(clock.bcsctl1, bc1);
        set!(clock.dcoctl, calibration.caldco_16mhz.read().bits());
    }
    // LFXT1S = 10: ACLK is the VLO, and the crystal pins P2.6, P2.7 are free.
    set!(clock.bcsctl3, 0b10 << 4);
    kick();

    let ports = reg::ports();
    set!(ports.p2out, 0);
    set!(ports.p2sel, 0);
    set!(ports.p2dir, 0xFF);
    let pull_up = P1_STOP | P1_START;
    set!(ports.p1out, pull_up);
    set!(ports.p1ren, pull_up);
    set!(ports.p1sel, P1_UART);
    set!(ports.p1sel2, P1_UART);

    // Timer0_A: SMCLK / 8 = 2 MHz, continuous; CCR0 is the millisecond, CCR1 the link's silence.
    let timer = reg::timer0();
    set!(timer.taccr0, 2000);
    set!(timer.tacctl0, 1 << 4);
    set!(timer.tactl, 0b10 << 8 | 0b11 << 6 | 0b10 << 4 | 1 << 2);
}
