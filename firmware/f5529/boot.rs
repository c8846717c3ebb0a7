//! From reset to `main`: stack, watchdog, RAM; profile; what is remembered over resets.

use crate::chip::{LOG, PART, clock};
use crate::flash::{self, Image, Key};
use core::arch::global_asm;
use firmware::verify::Bytes;
use lang::fault::Fault;
use lang::record::{BoardRecord, MoreRecord, RECORD_VERSION};
use lang::wire::CRC_START;

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

/// The profile at an address of the information memory, if it is whole with what belongs to it.
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
    // SAFETY: a whole record at an even address of flash; it is only erased when it is not in use. What lies behind it is
    // integers.
    let record = unsafe { &*(address as *const BoardRecord) };
    if record.more_crc != 0 {
        crc = CRC_START;
        while at < (BoardRecord::SIZE + MoreRecord::SIZE) as u16 {
            crc = Image::crc(crc, bytes.byte(at));
            at += 1;
        }
        if crc != 0 || record.more.crc != record.more_crc {
            return None;
        }
    }
    Some(record)
}

/// The profile in use: the later of two whole copies, else that of a board never given one.
pub fn newest_profile() -> &'static BoardRecord {
    match (profile(PART.profiles[0]), profile(PART.profiles[1])) {
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

/// What is known of the last reset and since.
pub struct Reset {
    /// IFG1 then.
    pub cause: u8,
    /// Half a second has passed since.
    pub booted: bool,
    /// The chip is to be reset once the reply is out.
    pub wanted: bool,
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

/// The fault that a reset in the middle of a run is: F17 by the watchdog, F14 by the RST pin.
pub fn interrupted(cause: u8) -> Option<Fault> {
    // SAFETY: one word that only this module touches.
    let runs = unsafe { core::ptr::addr_of!(RUNNING).read_volatile() } == RUNS;
    mark(false);
    if !runs || cause & 1 << 2 != 0 {
        return None;
    }
    Some(if cause & 1 != 0 { Fault::Watchdog } else { Fault::EmergencyStop })
}

/// End of the faults in their segment. Behind them stand the numbers of the programs that were selected.
const FAULTS_END: u16 = LOG + 64;
const SELECTED_END: u16 = LOG + 128;
/// Marks a number of a program.
const SELECTION: u16 = 0x5000;

/// Appends a fault to the log, records of three words and their exclusive or: number and input, place in the
/// code, line.
pub fn log(words: [u16; 3]) {
    let mut at = LOG;
    while at < FAULTS_END && flash::read(at) != 0xFFFF {
        at += 8;
    }
    if at == FAULTS_END {
        let number = selected();
        flash::erase(Key::new(), LOG);
        at = LOG;
        if number != 0 {
            select(number);
        }
    }
    write_fault(at, words);
}

fn write_fault(mut at: u16, words: [u16; 3]) {
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
    while at < FAULTS_END {
        let words = [flash::read(at), flash::read(at + 2), flash::read(at + 4)];
        if words[0] != 0xFFFF && flash::read(at + 6) == words[0] ^ words[1] ^ words[2] {
            found = Some(words);
        }
        at += 8;
    }
    found
}

/// Where the next number of a selected program goes, and the newest one with its place; 0 before the first.
fn selections() -> (u16, u8, u16) {
    let (mut at, mut newest, mut place) = (FAULTS_END, 0, 0);
    while at < SELECTED_END && flash::read(at) != 0xFFFF {
        let word = flash::read(at);
        if word == selection(word as u8) {
            newest = word as u8;
            place = at;
        }
        at += 4;
    }
    (at, newest, place)
}

/// A number as its word: with the number of its zeros, so that one of which some bits were not written is none.
const fn selection(number: u8) -> u16 {
    SELECTION | (number.count_zeros() as u16) << 8 | number as u16
}

/// Number of the program that was selected last, 0 for none. A cut in the moment when their segment is full leaves none:
/// then nothing starts before one is selected again.
pub fn selected() -> u8 {
    selections().1
}

/// As at a reset: a word that was cut short and reads well now does so from now on, which the word behind it tells.
pub fn settle_selected() -> u8 {
    let (_, number, at) = selections();
    if number != 0 && flash::read(at + 2) != 0 {
        flash::write(Key::new(), at, selection(number));
        flash::write(Key::new(), at + 2, 0);
    }
    number
}

/// Remembers it over any reset.
pub fn select(number: u8) {
    let (mut at, ..) = selections();
    if at == SELECTED_END {
        let last = logged();
        flash::erase(Key::new(), LOG);
        at = FAULTS_END;
        if let Some(words) = last {
            write_fault(LOG, words);
        }
    }
    flash::write(Key::new(), at, selection(number));
}

/// Resets the chip.
pub fn restart() -> ! {
    msp430::interrupt::disable();
    clock::reset()
}
