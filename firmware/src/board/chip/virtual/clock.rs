//! Clocks, watchdog and causes of resets.

use super::pins::{P1_UART, P2_OUT1_OR_LATCH, P2_OUT2_OR_ENABLE};
use super::reg::{self, set};

/// Address of the watchdog's control register (SLAU144, 10.3.1).
pub const WATCHDOG: u16 = 0x0120;

/// WDTCTL: password, counter clear, from ACLK (VLO), over 512: 43 ms typical, 25 to 128 ms.
pub const WATCHDOG_KICK: u16 = 0x5A00 | 1 << 3 | 1 << 2 | 0b10;

/// Restarts the watchdog's interval.
#[inline(always)]
pub fn kick() {
    set!(reg::watchdog().wdtctl, WATCHDOG_KICK);
}

/// Resets the chip: a write to the watchdog without its password.
pub fn reset() -> ! {
    loop {
        set!(reg::watchdog().wdtctl, 0);
    }
}

/// The chip is the emulator's: its supply is there. 16 MHz from the factory calibration, ACLK from
/// the VLO, pins to their safe states, the timer of the millisecond running; interrupts are still off.
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

    super::timer::open();
}

/// What is wrong with the clock, a bit of the register of [`cause`]: nothing that this chip could tell.
#[inline(always)]
pub fn fault() -> u8 {
    0
}

/// Why the chip was reset, from IFG1, which is cleared: bit 0 watchdog, 2 power on, 3 RST pin.
pub fn cause() -> u8 {
    let cause = reg::special().ifg1.read().bits() & 0b1_1101;
    set!(reg::special().ifg1, 0);
    cause
}
