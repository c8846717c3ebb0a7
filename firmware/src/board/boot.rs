//! From reset to `main`: stack, watchdog, RAM, clock, ports.

use crate::flash::{self, Image, Key};
use crate::pins::{P1_UART, P2_OUT1_OR_LATCH, P2_OUT2_OR_ENABLE};
use crate::reg::{self, set};
use ::core::arch::global_asm;
use firmware::PROFILES;
use firmware::verify::Bytes;
use lang::fault::Fault;
use lang::record::{BoardRecord, RECORD_VERSION};
use lang::wire::CRC_START;

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
pub const WATCHDOG_KICK: u16 = 0x5A00 | 1 << 3 | 1 << 2 | 0b10;

/// Restarts the watchdog's interval.
#[inline(always)]
pub fn kick() {
    set!(reg::watchdog().wdtctl, WATCHDOG_KICK);
}

/// The chip is the emulator's: its supply is there. 16 MHz from the factory calibration, ACLK from the VLO, pins to their safe states, timer and
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
    // Outputs stay as their resistors have them until the first exchange.
    set!(ports.p2dir, !(P2_OUT1_OR_LATCH | P2_OUT2_OR_ENABLE));
    // All of port 1 is pulled up, the receive pin of a cable that is off too.
    set!(ports.p1out, 0xFF);
    set!(ports.p1ren, 0xFF);
    set!(ports.p1sel, P1_UART);
    set!(ports.p1sel2, P1_UART);

    // Timer0_A: SMCLK / 8 = 2 MHz, continuous; CCR0 is the millisecond, CCR1 the link's silence.
    let timer = reg::timer0();
    set!(timer.taccr0, 2000);
    set!(timer.tacctl0, 1 << 4);
    // A watchdog reset leaves it as it was.
    set!(timer.tacctl1, 0);
    set!(timer.tactl, 0b10 << 8 | 0b11 << 6 | 0b10 << 4 | 1 << 2);
}

unsafe extern "C" {
    static _edata: u8;
}

/// Bytes between the statics and the deepest that the stack has reached since reset.
pub fn stack_free() -> u16 {
    // SAFETY: only the address of the linker's symbol is taken.
    let first = core::ptr::addr_of!(_edata) as u16;
    let memory = Image(first);
    let mut free = 0;
    while memory.byte(free) == 0xA5 {
        free += 1;
    }
    free
}

/// The profile at an address of the information memory, if it is whole.
pub fn profile(address: u16) -> Option<&'static BoardRecord> {
    let bytes = Image(address);
    let mut crc = CRC_START;
    let mut at = 0;
    while at < BoardRecord::SIZE as u16 {
        crc = Image::crc(crc, bytes.byte(at));
        at += 1;
    }
    if crc != 0 || bytes.word(2) != RECORD_VERSION {
        return None;
    }
    // SAFETY: a whole record at an even address of flash; it is only erased when it is not in use.
    Some(unsafe { &*(address as *const BoardRecord) })
}

/// The profile in use: the later of two whole copies, else that of a board never given one.
pub fn newest_profile() -> &'static BoardRecord {
    match (profile(PROFILES[0]), profile(PROFILES[1])) {
        (Some(a), Some(b)) => {
            if b.sequence.wrapping_sub(a.sequence) as i16 > 0 {
                b
            } else {
                a
            }
        }
        (Some(one), None) | (None, Some(one)) => one,
        _ => &BoardRecord::DEFAULT,
    }
}

/// Says that a program runs, over any reset but power-up.
#[unsafe(link_section = ".noinit")]
static mut RUNNING: u16 = 0;

const RUNS: u16 = 0x52A1;

/// Marks that a program runs.
pub fn mark(runs: bool) {
    // SAFETY: one word that only this module touches.
    unsafe { ::core::ptr::addr_of_mut!(RUNNING).write_volatile(if runs { RUNS } else { 0 }) };
}

/// Why the chip was reset, from IFG1, which is cleared: bit 0 watchdog, 2 power on, 3 RST pin.
pub fn cause() -> u8 {
    let cause = reg::special().ifg1.read().bits() & 0b1_1101;
    set!(reg::special().ifg1, 0);
    cause
}

/// The fault that a reset in the middle of a run is: F17 by the watchdog, F14 by the RST pin.
pub fn interrupted(cause: u8) -> Option<Fault> {
    // SAFETY: one word that only this module touches.
    let runs = unsafe { ::core::ptr::addr_of!(RUNNING).read_volatile() } == RUNS;
    mark(false);
    if !runs || cause & 1 << 2 != 0 {
        return None;
    }
    Some(if cause & 1 != 0 { Fault::Watchdog } else { Fault::EmergencyStop })
}

/// Segment D: the last faults, records of three words and their exclusive or.
const LOG: u16 = 0x1000;

/// Watchdog resets in a row, over any reset but power-up.
#[unsafe(link_section = ".noinit")]
static mut BITES: u16 = 0;

/// Counts this reset if the watchdog made it, and tells how many there were in a row.
pub fn bites(cause: u8) -> u16 {
    // SAFETY: one word that only this function and `restart` touch.
    unsafe {
        let place = ::core::ptr::addr_of_mut!(BITES);
        let before = if cause & 1 << 2 != 0 { 0 } else { place.read_volatile() };
        let bites = if cause & 1 != 0 { before.wrapping_add(1) } else { 0 };
        place.write_volatile(bites);
        bites
    }
}

/// Appends a fault: number and input, place in the code, line.
pub fn log(words: [u16; 3]) {
    let mut at = LOG;
    while at < LOG + 64 && flash::read(at) != 0xFFFF {
        at += 8;
    }
    if at == LOG + 64 {
        at = LOG;
        flash::erase(Key::new(), LOG);
    }
    for word in words {
        flash::write(Key::new(), at, word);
        at += 2;
    }
    flash::write(Key::new(), at, words[0] ^ words[1] ^ words[2]);
}

/// The last fault, if one was ever logged.
pub fn logged() -> Option<[u16; 3]> {
    let mut found = None;
    let mut at = LOG;
    while at < LOG + 64 {
        let words = [flash::read(at), flash::read(at + 2), flash::read(at + 4)];
        if words[0] != 0xFFFF && flash::read(at + 6) == words[0] ^ words[1] ^ words[2] {
            found = Some(words);
        }
        at += 8;
    }
    found
}

/// Resets the chip: a write to the watchdog without its password. It counts as a bite, but this one
/// was asked for.
pub fn restart() -> ! {
    msp430::interrupt::disable();
    // SAFETY: interrupts are off, and only `bites` touches the word otherwise.
    unsafe {
        let place = ::core::ptr::addr_of_mut!(BITES);
        place.write_volatile(place.read_volatile().wrapping_sub(1));
    }
    loop {
        set!(reg::watchdog().wdtctl, 0);
    }
}
