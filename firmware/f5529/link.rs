//! The serial line under the Modbus slave: UART, frame gaps, the millisecond, all their interrupts.
//!
//! A character's interrupt sets a compare register to the end of the 3.5 character silence that closes a frame.
//! One that comes after more than 1.5 characters of silence spoils the frame (Modbus over Serial
//! Line V1.02, 2.5.1.1). Above 19200 bit/s the standard's fixed 750 us and 1750 us hold.

use crate::chip::{clock, line, rs485, timer};
use crate::vm::{State, VM, VM_AT};
use core::arch::global_asm;
use core::mem::offset_of;
use core::ptr::addr_of;
use firmware::machine::Port;
use firmware::modbus::{FRAME, Line};

/// What the interrupts share with the main loop.
#[repr(C)]
pub struct Shared {
    buffer: [u8; FRAME],
    /// Receiving: bytes so far, [`SPOILED`] after an error. Sending: where the next byte goes.
    pub head: u8,
    /// Sending: the next byte to go out.
    pub tail: u8,
    /// [`LISTEN`], [`FRAME_READY`] or [`SENDING`].
    pub state: u8,
    /// Timer ticks from a character's end to the frame's end.
    pub silence: u16,
    /// `silence` less the ticks from a character's end to the latest end of the next.
    pub slack: u16,
    /// Timer ticks of a character of 11 bits.
    pub character: u16,
    /// Code of the rate, and whether the clock came from REFO when that was chosen.
    code: u8,
    refo: bool,
}

const SPOILED: u8 = 0xFF;
/// [`Shared::state`]: a request may come.
pub const LISTEN: u8 = 0;
/// [`Shared::state`]: a request is there.
pub const FRAME_READY: u8 = 1;
const SENDING: u8 = 2;
/// The reply is complete in the ring.
pub const LAST: u8 = 3;

impl Shared {
    const IDLE: Shared = Shared {
        buffer: [0; FRAME],
        head: 0,
        tail: 0,
        state: LISTEN,
        silence: 0,
        slack: 0,
        character: 0,
        code: 0,
        refo: false,
    };
}

static mut SHARED: Shared = Shared::IDLE;
/// The same of the RS-485 line (`bus.rs`).
pub static mut BUS: Shared = Shared::IDLE;

/// Milliseconds, counted by their interrupt.
#[unsafe(export_name = "PASAPAS_MILLIS")]
pub static mut MILLIS: u16 = 0;

// Receive 57 cycles, of which steps wait for 20, transmit 40, silence 19, millisecond 33 (`guard.rs`
// goes on where the chain may stop the machine). The status is read before the data
// because reading the data clears its error flags.
global_asm!(
    crate::chip::handlers!("link"),
    r#"
module.link.uart:
    .global pasapas_receive
pasapas_receive:
    push r12
    push r13
    mov.b &{stat}, r13
    mov.b &{rxbuf}, r12
    /* steps may come between, but not while flash is busy: then whoever stands in for the interrupt has none */
    bit #{gie}, 4(r1)
    jeq 7f
    eint
    nop
7:  tst.b &{shared}+{state}
    jne 5f
6:  bit.b #0x70, r13
    jne 2f
    mov.b &{shared}+{head}, r13
    cmp.b #{frame}, r13
    jhs 2f
    mov.b r12, {shared}(r13)
    tst.b r13
    jeq 1f
    mov &{now}, r12
    sub &{due}, r12
    add &{shared}+{slack}, r12
    jge 2f
1:  inc.b &{shared}+{head}
    jmp 3f
2:  mov.b #0xff, &{shared}+{head}
3:  mov &{now}, r12
    add &{shared}+{silence}, r12
    mov r12, &{due}
    mov #0x0010, &{due_control}
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
    bic.b #2, &{enable}
    jmp 6b

    .global pasapas_silence
pasapas_silence:
    clr &{due_control}
    mov.b #{ready}, &{shared}+{state}
    reti

    .global pasapas_transmit
pasapas_transmit:
    push r12
    mov.b &{shared}+{tail}, r12
    cmp.b &{shared}+{head}, r12
    jeq 2f
    mov.b {shared}(r12), &{txbuf}
    inc.b r12
    cmp.b #{frame}, r12
    jlo 1f
    clr.b r12
1:  mov.b r12, &{shared}+{tail}
    pop r12
    reti
2:  bic.b #2, &{enable}
    pop r12
    reti

    .global pasapas_millisecond
pasapas_millisecond:
    /* its flag is gone already: steps may come between */
    eint
    nop
    add #{per_ms}, &{tick}
    inc &{millis}
    mov.b #1, &{vm}+{vm_at}+{poll}
    tst &PASAPAS_GUARD
    jeq 1f
    br #pasapas_guard_chain
1:  reti
    "#,
    stat = const line::STAT,
    rxbuf = const line::RXBUF,
    txbuf = const line::TXBUF,
    enable = const line::IE,
    now = const timer::R,
    due = const timer::SILENCE_CCR,
    due_control = const timer::SILENCE_CCTL,
    tick = const timer::MS_CCR,
    per_ms = const timer::PER_MS,
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
    vm_at = const VM_AT,
    poll = const offset_of!(State, poll),
    gie = const 1 << 3,
);

/// Milliseconds since reset, modulo 65536.
#[inline(always)]
pub fn millis() -> u16 {
    // SAFETY: one word, read by one instruction.
    unsafe { addr_of!(MILLIS).read_volatile() }
}

/// Catches up with milliseconds that passed while interrupts were off for longer than one.
pub fn catch_up() {
    loop {
        let due = timer::due();
        if (timer::now().wrapping_sub(due) as i16) < timer::PER_MS as i16 {
            return;
        }
        timer::set_due(due.wrapping_add(timer::PER_MS));
        // SAFETY: called with interrupts off.
        unsafe { MILLIS = MILLIS.wrapping_add(1) };
    }
}

/// A line: the back channel, or the RS-485 line.
#[derive(Clone, Copy)]
pub struct Uart {
    shared: *mut Shared,
    bus: bool,
}

// SAFETY (all): they are single-byte or single-word volatile accesses, which one instruction does; who may write which
// field depends on `state` alone.
macro_rules! get {
    ($line:ident.$field:ident) => {
        unsafe { (&raw const (*$line.shared).$field).read_volatile() }
    };
}
macro_rules! put {
    ($line:ident.$field:ident, $value:expr) => {
        unsafe { (&raw mut (*$line.shared).$field).write_volatile($value) }
    };
}

/// Divider and modulation of the UART's clock, silence and slack in ticks of the timer.
struct Rate {
    divider: u16,
    modulation: u8,
    silence: u16,
    slack: u16,
    character: u16,
}

const fn rate(clock: u32, bits_per_second: u32) -> Rate {
    let divider = clock / bits_per_second;
    let modulation = ((clock % bits_per_second) * 8 + bits_per_second / 2) / bits_per_second;
    // A character is 11 bits; from end to end there is one more than the silence between.
    let per_ms = clock / 8000;
    let character = 11 * 1000 * per_ms / bits_per_second;
    let (gap, silence) = if bits_per_second > 19_200 {
        (per_ms * 3 / 4 + character, per_ms * 7 / 4)
    } else {
        (character * 5 / 2, character * 7 / 2)
    };
    Rate {
        divider: divider as u16,
        modulation: (modulation << 1) as u8,
        silence: silence as u16,
        slack: (silence as i32 - gap as i32) as u16,
        character: character as u16,
    }
}

const fn rates(clock: u32) -> [Rate; 4] {
    [rate(clock, 9600), rate(clock, 19_200), rate(clock, 57_600), rate(clock, 115_200)]
}

/// By the source of the clock and the profile's rate code.
static RATES: [[Rate; 4]; 2] = [rates(line::CLOCKS[0]), rates(line::CLOCKS[1])];

impl Uart {
    /// The back channel.
    pub fn back() -> Uart {
        Uart { shared: &raw mut SHARED, bus: false }
    }

    /// The RS-485 line.
    pub fn rs485() -> Uart {
        Uart { shared: &raw mut BUS, bus: true }
    }

    /// Starts the UART: `code` as in the board record, rate in the low nibble and parity in the
    /// high one.
    pub fn open(&self, code: u8) {
        let refo = clock::is_refo();
        put!(self.code, code);
        put!(self.refo, refo);
        let rate = &RATES[usize::from(refo)][usize::from(code & 3)];
        put!(self.silence, rate.silence);
        put!(self.slack, rate.slack);
        let parity = match code >> 4 {
            0 => 0,
            1 => 0b11 << 6,
            _ => 0b10 << 6,
        };
        put!(self.character, rate.character);
        if self.bus {
            rs485::open(rate.divider, rate.modulation, parity);
        } else {
            line::open(rate.divider, rate.modulation, parity);
        }
    }

    fn is_busy(&self) -> bool {
        if self.bus { rs485::is_busy() } else { line::is_busy() }
    }

    /// The request has been read: its buffer becomes the reply's ring.
    #[inline(always)]
    fn begin_reply(&self) {
        if get!(self.state) == FRAME_READY {
            put!(self.head, 0);
            put!(self.tail, 0);
            put!(self.state, SENDING);
        }
    }

    /// Puts a byte at place `head` of the ring, which is below [`FRAME`].
    #[inline(always)]
    fn lay(&self, head: u8, byte: u8) {
        // SAFETY: `head` stays below FRAME.
        unsafe {
            (&raw mut (*self.shared).buffer)
                .cast::<u8>()
                .add(usize::from(head))
                .write_volatile(byte)
        };
    }

    fn transmit(&self) {
        if self.bus {
            rs485::transmit();
        } else {
            line::transmit();
        }
    }
}

impl Port for Uart {
    fn follow_clock(&self) {
        if clock::is_refo() != get!(self.refo) && !self.is_busy() {
            self.open(get!(self.code));
        }
    }

    fn frame(&mut self) -> Option<u8> {
        let state = get!(self.state);
        if state != FRAME_READY {
            return None;
        }
        let length = get!(self.head);
        if length == SPOILED {
            put!(self.head, 0);
            put!(self.state, LISTEN);
            return None;
        }
        Some(length)
    }

    fn rests(&self) -> bool {
        let sent = get!(self.state) == LAST && get!(self.tail) == get!(self.head);
        get!(self.state) == LISTEN || !self.bus && sent && !self.is_busy()
    }
}

impl Line for Uart {
    #[inline(always)]
    fn byte(&self, index: u8) -> u8 {
        // SAFETY: `index` is below 256 and the request's length was bounded by the interrupt; a
        // read past the buffer meets the fields behind it or other RAM, never a fault.
        unsafe { (&raw const (*self.shared).buffer).cast::<u8>().add(usize::from(index)).read() }
    }

    fn room(&self) -> u8 {
        let used = get!(self.head).wrapping_sub(get!(self.tail));
        let used = if used as i8 >= 0 { used } else { used.wrapping_add(FRAME as u8) };
        FRAME as u8 - 1 - used
    }

    fn put(&mut self, byte: u8) {
        self.begin_reply();
        let head = get!(self.head);
        self.lay(head, byte);
        put!(self.head, if head + 1 == FRAME as u8 { 0 } else { head + 1 });
        self.transmit();
    }

    /// Both bytes are laid before the interrupt learns of the first: half the work of two of [`Line::put`].
    fn put_word(&mut self, word: u16) {
        self.begin_reply();
        let head = get!(self.head);
        if head + 2 >= FRAME as u8 {
            self.put((word >> 8) as u8);
            self.put(word as u8);
            return;
        }
        self.lay(head, (word >> 8) as u8);
        self.lay(head + 1, word as u8);
        put!(self.head, head + 2);
        self.transmit();
    }

    fn finish(&mut self) {
        if get!(self.state) == SENDING {
            put!(self.state, LAST);
            // Its interrupt sees to the end, also when it was faster.
            if self.bus {
                self.transmit();
            }
        } else {
            put!(self.head, 0);
            put!(self.state, LISTEN);
        }
    }

    #[inline(always)]
    fn crc(crc: u16, byte: u8) -> u16 {
        crate::math::crc16(crc, byte)
    }

    #[inline(always)]
    fn crc_word(crc: u16, word: u16) -> u16 {
        crate::math::crc16_word(crc, word)
    }
}
