//! From reset to a board that knows its profile: clock, ports, timers.

use crate::consts::constants;
use lang::fault::Fault;

/// WDTCTL: password, counter clear, from ACLK (VLO), over 512: 43 ms typical, 25 to 128 ms.
pub const WATCHDOG_KICK: u16 = 0x5A00 | 1 << 3 | 1 << 2 | 0b10;

/// Address of the watchdog's control register (SLAU144, 10.3.1).
pub const WATCHDOG: u16 = 0x0120;

constants! {
    WATCHDOG = WATCHDOG;
    KICK = WATCHDOG_KICK;
    // Says that a program runs, over any reset but power-up.
    RUNS_MARK = 0x52A1;
    NO_WATCHDOGS = 0x3C50;
    F_WATCHDOG = Fault::Watchdog.number();
}

/// The boot loader's key word: its entry by pins stays possible, a wrong password erases nothing.
#[unsafe(link_section = ".bslkey")]
#[used]
static BSL_KEY: u16 = 0x0000;

core::arch::global_asm!(include_str!("boot/boot.s"), options(raw));
