//! From reset to a board that knows its profile: clock, ports, timers.

use crate::consts::constants;
use lang::fault::Fault;

pub use crate::chip::{WATCHDOG, WATCHDOG_KICK};

constants! {
    // Says that a program runs, over any reset but power-up.
    RUNS_MARK = 0x52A1;
    F_WATCHDOG = Fault::Watchdog.number();
}

/// The boot loader's key word: its entry by pins stays possible, a wrong password erases nothing.
#[unsafe(link_section = ".bslkey")]
#[used]
static BSL_KEY: u16 = 0x0000;

core::arch::global_asm!(include_str!("boot/boot.s"), options(raw));
