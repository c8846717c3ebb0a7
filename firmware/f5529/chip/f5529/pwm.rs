//! TB0: the PWM, whose channel 5 is P3.5. Each period begins low; the pin is high from the compare value to the
//! period's end.
//!
//! The compare latches are not used. Erratum TB25 of this timer's family lets a new value through at once in up mode,
//! whatever the latches are set to, and the errata do not say which devices have it. Without latches one case goes wrong: a
//! new value that the counter has passed, while it has not reached the old one, would leave a period dark. So only
//! [`pasapas_power`] writes the compare register. It is an interrupt of the channel; setting its flag requests it, and a word
//! of RAM holds the value. In that case it sets the pin high at once: later than the new value says, but before the old one
//! did. When the pin is high the interrupt comes again and writes the value itself. The same holds for a value that the
//! counter may pass between the read and the write: within [`SOON`] counts before it, and at the beginning of the next period
//! when this one is about to end. In all other cases the value is written at once.
//! Each period has one pulse, of a width from the older value's to the newer one's: `firmware/tests/pwm.rs` changes it at each
//! count of a period.

use super::clock::RATE;
use super::ports;
use super::reg::{TB0CCR0, TB0CCR5, TB0CCTL5, TB0CTL, TB0R};
use core::arch::global_asm;

/// Control of the channel: 0 puts the pin low at once.
pub const CCTL: u16 = TB0CCTL5.0;
/// Its compare register.
pub const CCR: u16 = TB0CCR5.0;
/// The compare value that no period reaches: the pin stays low.
pub const DARK: u16 = u16::MAX;

/// Output mode set/reset.
const RUNS: u16 = 3 << 5;
/// Asks for [`pasapas_power`]: CCIE and CCIFG.
pub const ASK: u16 = 1 << 4 | 1;
/// Counts from reading the counter to a compare value that is written for sure before they are over: it takes up to 50 cycles.
/// A period has never more than 65 445 counts (382 and 191 Hz), so that no sum with them goes round.
const SOON: u16 = 64;

/// The compare value that is wanted.
#[unsafe(no_mangle)]
static mut PASAPAS_POWER: u16 = DARK;

global_asm!(
    r#"
    .section .text.power,"ax",@progbits
module.chip.pwm:
    .global pasapas_power
pasapas_power:
    push r15
    bic #{ask}, &{cctl}
    mov &{counter}, r15
    add #{soon}, r15
    cmp &PASAPAS_POWER, r15
    jlo 1f
    /* passed, or as good as: it holds in this period only if the pin is high, or is to stay low in all of it */
    cmp #{dark}, &{ccr}
    jeq 1f
    sub #{soon}, r15
    cmp &{ccr}, r15
    jhs 3f
    add #{soon}, r15
    cmp &{ccr}, r15
    jhs 2f
    mov r15, &{ccr}
2:  bis #{enable}, &{cctl}
    pop r15
    reti
    /* the pin is high: what is written holds from the next period on, but when that may have begun by then, and the value
       lies at its very beginning */
3:  add #{soon}, r15
    cmp r15, &{top}
    jhs 1f
    cmp #{soon}+1, &PASAPAS_POWER
    jhs 1f
    cmp #{soon}+1, &{ccr}
    jlo 2b
    mov #{soon}, &{ccr}
    jmp 2b
1:  mov &PASAPAS_POWER, &{ccr}
    pop r15
    reti
    "#,
    ask = const ASK,
    enable = const ASK & !1,
    cctl = const CCTL,
    ccr = const CCR,
    counter = const TB0R.0,
    top = const TB0CCR0.0,
    dark = const DARK,
    soon = const SOON,
);

/// Lets it count `hz` periods in a second, its pin driven low. Returns how far it counts, and its ticks in a
/// millisecond.
pub fn open(hz: u16) -> (u16, u16) {
    TB0CCTL5.set(0);
    TB0CCR5.set(DARK);
    let counts = count(hz);
    ports::open_pwm();
    counts
}

/// Starts the timer of both PWMs. Returns how far it counts, and its ticks in a millisecond.
pub(super) fn count(hz: u16) -> (u16, u16) {
    let mut divider = 0;
    let mut top = RATE / u32::from(hz);
    while top > u32::from(u16::MAX) {
        divider += 1;
        top >>= 1;
    }
    let top = top as u16 - 1;
    // A watchdog reset leaves the timer as it was.
    TB0CTL.set(0);
    TB0CCR0.set(top);
    // SMCLK, up, cleared.
    TB0CTL.set(0b10 << 8 | divider << 6 | 0b01 << 4 | 1 << 2);
    (top, ((RATE / 1000) >> divider) as u16)
}

/// From which count on the pin is high, from now on.
#[inline(always)]
pub fn set(compare: u16) {
    // SAFETY: a word that the step engine's handlers write, too, while a path plays, and then the main loop does not.
    unsafe {
        if (&raw const PASAPAS_POWER).read_volatile() == compare {
            return;
        }
        (&raw mut PASAPAS_POWER).write_volatile(compare);
    }
    TB0CCTL5.raise(ASK);
}

/// Lets the pin follow, or puts it low at once.
#[inline(always)]
pub fn gate(on: bool) {
    if on {
        // Not as a whole: the interrupt may be asked for. It is asked for anyway, as what darkens the pin takes that back.
        TB0CCTL5.raise(RUNS | ASK);
    } else {
        TB0CCTL5.set(0);
    }
}
