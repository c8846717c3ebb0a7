//! The serial line under the Modbus slave: USCI_A0, frame gaps on Timer0_A CCR1, all interrupts.
//!
//! A character's interrupt sets CCR1 to the end of the 3.5 character silence that closes a frame.
//! One that comes after more than 1.5 characters of silence spoils the frame (Modbus over Serial
//! Line V1.02, 2.5.1.1). Above 19200 bit/s the standard's fixed 750 us and 1750 us hold.

use crate::reg::{self, bis, set};
use crate::vm::{State, VM};
use ::core::arch::global_asm;
use ::core::mem::offset_of;
use ::core::ptr::{addr_of, addr_of_mut};
use firmware::modbus::{FRAME, Line};

/// What the interrupts share with the main loop.
#[repr(C)]
struct Shared {
    buffer: [u8; FRAME],
    /// Receiving: bytes so far, [`SPOILED`] after an error. Sending: where the next byte goes.
    head: u8,
    /// Sending: the next byte to go out.
    tail: u8,
    /// [`LISTEN`], [`FRAME_READY`] or [`SENDING`].
    state: u8,
    /// Timer ticks (0.5 us) from a character's end to the frame's end.
    silence: u16,
    /// `silence` less the ticks from a character's end to the latest end of the next.
    slack: u16,
}

const SPOILED: u8 = 0xFF;
const LISTEN: u8 = 0;
const FRAME_READY: u8 = 1;
const SENDING: u8 = 2;
/// The reply is complete in the ring.
const LAST: u8 = 3;

static mut SHARED: Shared =
    Shared { buffer: [0; FRAME], head: 0, tail: 0, state: LISTEN, silence: 0, slack: 0 };

/// Milliseconds, counted by Timer0_A CCR0.
static mut MILLIS: u16 = 0;

// Receive 46 cycles, transmit 40, silence 19, millisecond 31 (`guard.rs`
// goes on where the chain may stop the machine). UCA0STAT is read before the data
// because reading UCA0RXBUF clears its error flags.
global_asm!(
    r#"
    .section .text.link,"ax",@progbits
module.link.uart:
    .global USCIAB0RX
USCIAB0RX:
    push r12
    push r13
    mov.b &0x0065, r13
    mov.b &0x0066, r12
    tst.b &{shared}+{state}
    jne 5f
6:  bit.b #0x70, r13
    jne 2f
    mov.b &{shared}+{head}, r13
    cmp.b #{frame}, r13
    jhs 2f
    mov.b r12, {shared}(r13)
    tst.b r13
    jeq 1f
    mov &0x0170, r12
    sub &0x0174, r12
    add &{shared}+{slack}, r12
    jge 2f
1:  inc.b &{shared}+{head}
    jmp 3f
2:  mov.b #0xff, &{shared}+{head}
3:  mov &0x0170, r12
    add &{shared}+{silence}, r12
    mov r12, &0x0174
    mov #0x0010, &0x0164
4:  pop r13
    pop r12
    reti
    /* the last byte of the reply has left the ring: the next request begins */
5:  cmp.b #{last}, &{shared}+{state}
    jne 4b
    cmp.b &{shared}+{tail}, &{shared}+{head}
    jne 4b
    clr.b &{shared}+{head}
    clr.b &{shared}+{state}
    /* its interrupt, due when that byte is out, would take the request for more of the reply */
    bic.b #2, &0x0001
    jmp 6b

    .global TIMER0_A1
TIMER0_A1:
    clr &0x0164
    mov.b #{ready}, &{shared}+{state}
    reti

    .global USCIAB0TX
USCIAB0TX:
    push r12
    mov.b &{shared}+{tail}, r12
    cmp.b &{shared}+{head}, r12
    jeq 2f
    mov.b {shared}(r12), &0x0067
    inc.b r12
    cmp.b #{frame}, r12
    jlo 1f
    clr.b r12
1:  mov.b r12, &{shared}+{tail}
    pop r12
    reti
2:  bic.b #2, &0x0001
    pop r12
    reti

    .global TIMER0_A0
TIMER0_A0:
    add #2000, &0x0172
    inc &{millis}
    mov.b #1, &{vm}+{poll}
    tst &PASAPAS_GUARD
    jne pasapas_guard_chain
    reti
    "#,
    shared = sym SHARED,
    millis = sym MILLIS,
    frame = const FRAME,
    head = const offset_of!(Shared, head),
    tail = const offset_of!(Shared, tail),
    state = const offset_of!(Shared, state),
    silence = const offset_of!(Shared, silence),
    slack = const offset_of!(Shared, slack),
    ready = const FRAME_READY,
    last = const LAST,
    vm = sym VM,
    poll = const offset_of!(State, poll),
);

// SAFETY (all accesses to the statics below): they are single-byte or single-word volatile
// accesses, which one instruction does; who may write which field depends on `state` alone.
macro_rules! get {
    ($field:ident) => {
        unsafe { addr_of!(SHARED.$field).read_volatile() }
    };
}
macro_rules! put {
    ($field:ident, $value:expr) => {
        unsafe { addr_of_mut!(SHARED.$field).write_volatile($value) }
    };
}

/// Milliseconds since reset, modulo 65536.
#[inline(always)]
pub fn millis() -> u16 {
    // SAFETY: one word, read by one instruction.
    unsafe { addr_of!(MILLIS).read_volatile() }
}

/// Catches up with milliseconds that passed while interrupts were off for longer than one.
pub fn catch_up() {
    let timer = reg::timer0();
    loop {
        let due = timer.taccr0.read().bits();
        if (timer.tar.read().bits().wrapping_sub(due) as i16) < 2000 {
            return;
        }
        set!(timer.taccr0, due.wrapping_add(2000));
        // SAFETY: called with interrupts off.
        unsafe { MILLIS = MILLIS.wrapping_add(1) };
    }
}

/// The line.
pub struct Uart;

/// Divider and modulation (SLAU144, table 15-4) for 16 MHz, silence and slack in 0.5 us.
struct Rate {
    divider: u16,
    modulation: u8,
    silence: u16,
    slack: u16,
}

const fn rate(bits_per_second: u32) -> Rate {
    let clock = 16_000_000;
    let divider = clock / bits_per_second;
    let modulation = ((clock % bits_per_second) * 8 + bits_per_second / 2) / bits_per_second;
    // A character is 11 bits; from end to end there is one more than the silence between.
    let character = 11 * 2_000_000 / bits_per_second;
    let (gap, silence) = if bits_per_second > 19_200 {
        (1500 + character, 3500)
    } else {
        (character * 5 / 2, character * 7 / 2)
    };
    Rate {
        divider: divider as u16,
        modulation: (modulation << 1) as u8,
        silence: silence as u16,
        slack: (silence as i32 - gap as i32) as u16,
    }
}

/// By the profile's rate code.
static RATES: [Rate; 4] = [rate(9600), rate(19_200), rate(57_600), rate(115_200)];

impl Uart {
    /// Starts the UART: `code` as in the board record, rate in the low nibble and parity in the
    /// high one.
    pub fn open(code: u8) {
        let rate = &RATES[usize::from(code & 3)];
        put!(silence, rate.silence);
        put!(slack, rate.slack);
        let uart = reg::uart();
        set!(uart.uca0ctl1, 0b10 << 6 | 1);
        let parity = match code >> 4 {
            0 => 0,
            1 => 0b11 << 6,
            _ => 0b10 << 6,
        };
        set!(uart.uca0ctl0, parity);
        set!(uart.uca0br0, rate.divider as u8);
        set!(uart.uca0br1, (rate.divider >> 8) as u8);
        set!(uart.uca0mctl, rate.modulation);
        set!(uart.uca0ctl1, 0b10 << 6);
        bis!(reg::special().ie2, 1);
    }

    /// A frame's length once its silence has passed. After a reply the next character listens.
    pub fn frame(&mut self) -> Option<u8> {
        let state = get!(state);
        if state != FRAME_READY {
            return None;
        }
        let length = get!(head);
        if length == SPOILED {
            put!(head, 0);
            put!(state, LISTEN);
            return None;
        }
        Some(length)
    }
}

impl Uart {
    /// Whether no reply is being sent.
    pub fn rests(&self) -> bool {
        let sent = get!(state) == LAST && get!(tail) == get!(head);
        get!(state) == LISTEN || sent && reg::uart().uca0stat.read().bits() & 1 == 0
    }
}

impl Line for Uart {
    #[inline(always)]
    fn byte(&self, index: u8) -> u8 {
        // SAFETY: `index` is below 256 and the request's length was bounded by the interrupt; a
        // read past the buffer meets the fields behind it or other RAM, never a fault.
        unsafe { addr_of!(SHARED.buffer).cast::<u8>().add(usize::from(index)).read() }
    }

    fn room(&self) -> u8 {
        let used = get!(head).wrapping_sub(get!(tail));
        let used = if used as i8 >= 0 { used } else { used.wrapping_add(FRAME as u8) };
        FRAME as u8 - 1 - used
    }

    fn put(&mut self, byte: u8) {
        if get!(state) == FRAME_READY {
            put!(head, 0);
            put!(tail, 0);
            put!(state, SENDING);
        }
        let head = get!(head);
        // SAFETY: `head` stays below FRAME.
        unsafe {
            addr_of_mut!(SHARED.buffer).cast::<u8>().add(usize::from(head)).write_volatile(byte)
        };
        put!(head, if head + 1 == FRAME as u8 { 0 } else { head + 1 });
        bis!(reg::special().ie2, 2);
    }

    fn finish(&mut self) {
        if get!(state) == SENDING {
            put!(state, LAST);
        } else {
            put!(head, 0);
            put!(state, LISTEN);
        }
    }

    #[inline(always)]
    fn crc(crc: u16, byte: u8) -> u16 {
        crate::math::crc16(crc, byte)
    }
}
