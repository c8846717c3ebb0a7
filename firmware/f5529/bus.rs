//! Interrupts of the RS-485 line; those of the back channel are in `link.rs`.
//!
//! The transceiver drives from the first character of a reply until one character's time after the interrupt that finds
//! nothing more to send, and as long as the UART is busy. Characters received meanwhile are the line's own echo or belong
//! to no frame. A frame ends, and a reply begins, 3.5 characters after the last character, above
//! 19200 bit/s 1.75 ms (Modbus over Serial Line V1.02, 2.5.1.1).

use crate::chip::{ports, rs485, timer};
use crate::link::{BUS, FRAME_READY, LAST, LISTEN, Shared};
use core::arch::global_asm;
use core::mem::offset_of;
use firmware::modbus::FRAME;

// In flash: while that is written the line waits, and a frame that was cut is nobody's.
global_asm!(
    r#"
    .section .text.bus,"ax",@progbits
module.link.bus:
    .set BUS, {bus}
    .global pasapas_bus
pasapas_bus:
    push r12
    bit.b #1, &{flags}
    jeq bus_transmit
    push r13
    mov.b &{stat}, r13
    mov.b &{rxbuf}, r12
    cmp.b #{listen}, &BUS+{state}
    jne 4f
    bit.b #0x70, r13
    jne 2f
    mov.b &BUS+{head}, r13
    cmp.b #{frame}, r13
    jhs 2f
    mov.b r12, BUS(r13)
    tst.b r13
    jeq 1f
    mov &{now}, r12
    sub &{due}, r12
    add &BUS+{slack}, r12
    jge 2f
1:  inc.b &BUS+{head}
    jmp 3f
2:  mov.b #0xff, &BUS+{head}
3:  mov &{now}, r12
    add &BUS+{silence}, r12
    mov r12, &{due}
    mov #0x0010, &{due_control}
4:  pop r13
    pop r12
    reti

bus_transmit:
    mov.b &BUS+{tail}, r12
    cmp.b &BUS+{head}, r12
    jeq 2f
    mov.b BUS(r12), &{txbuf}
    inc.b r12
    cmp.b #{frame}, r12
    jlo 1f
    clr.b r12
1:  mov.b r12, &BUS+{tail}
    pop r12
    reti
2:  bic.b #2, &{enable}
    cmp.b #{last}, &BUS+{state}
    jne 3f
    /* the last character has just begun */
    mov &{now}, r12
    add &BUS+{character}, r12
    mov r12, &{due}
    mov #0x0010, &{due_control}
3:  pop r12
    reti

    /* the timer's channels share a vector */
    .global pasapas_silences
pasapas_silences:
    bit #0x0010, &{first_control}
    jeq 1f
    bit #0x0001, &{first_control}
    jeq 1f
    br #pasapas_silence
1:  cmp.b #{last}, &BUS+{state}
    jeq 2f
    clr &{due_control}
    mov.b #{ready}, &BUS+{state}
    reti
2:  bit.b #1, &{stat}
    jeq 3f
    /* a parity bit: some us more */
    add #{more}, &{due}
    bic #1, &{due_control}
    reti
3:  clr &{due_control}
    bic.b #{drive}, &{drive_out}
    clr.b &BUS+{head}
    mov.b #{listen}, &BUS+{state}
    reti
    "#,
    bus = sym BUS,
    flags = const rs485::IE + 1,
    stat = const rs485::STAT,
    rxbuf = const rs485::RXBUF,
    txbuf = const rs485::TXBUF,
    enable = const rs485::IE,
    now = const timer::R,
    due = const timer::BUS_CCR,
    due_control = const timer::BUS_CCTL,
    first_control = const timer::SILENCE_CCTL,
    frame = const FRAME,
    head = const offset_of!(Shared, head),
    tail = const offset_of!(Shared, tail),
    state = const offset_of!(Shared, state),
    silence = const offset_of!(Shared, silence),
    slack = const offset_of!(Shared, slack),
    character = const offset_of!(Shared, character),
    listen = const LISTEN,
    ready = const FRAME_READY,
    last = const LAST,
    more = const timer::PER_MS / 100,
    drive = const ports::P4_DRIVE,
    drive_out = const ports::DRIVE_OUT,
);
