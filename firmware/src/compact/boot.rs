//! From reset to a board that knows its profile: clock, ports, timers.

use crate::consts::constants;

/// WDTCTL: password, counter clear, from ACLK (VLO), over 512: 43 ms typical, 25 to 128 ms.
pub const WATCHDOG_KICK: u16 = 0x5A00 | 1 << 3 | 1 << 2 | 0b10;

constants! {
    WATCHDOG = 0x0120;
    KICK = WATCHDOG_KICK;
}

core::arch::global_asm!(include_str!("boot/boot.s"), options(raw));
