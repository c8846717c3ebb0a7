//! Core voltage, clocks, watchdog and causes of resets.
//!
//! The processor runs from the DCO, which the frequency locked loop holds to the 4 MHz crystal at XT2. Without
//! it, from the start or at any later time, the loop is given REFO, which is good for 3.5 %, until the crystal has run for
//! [`SOUND_MS`] without a fault.

use super::reg::{
    PMMCTL0, PMMCTL0_H, PMMCTL0_L, PMMIFG, PMMRIE, SFRIE1, SFRIFG1, SVSMHCTL, SVSMLCTL, SYSRSTIV,
    UCSCTL0, UCSCTL1, UCSCTL2, UCSCTL3, UCSCTL4, UCSCTL6, UCSCTL7, WDTCTL, Word,
};
use super::{ports, timer};
use core::arch::{asm, global_asm};

/// Rate of MCLK and SMCLK.
pub const RATE: u32 = super::PART.clock;
/// DCORSEL: the range of the DCO whose lowest tap is never above that rate and whose highest never below
/// it (SLAS590, "DCO Frequency").
const RANGE: u16 = 6 << 4;
/// The loop's reference XT2 / 16 = 250 kHz, and by how much it is multiplied, less one.
const XT2: [u16; 2] = [0x0055, (RATE / 250_000 - 1) as u16];
/// REFO, 32 768 Hz, good for 3.5 %, of which the fastest may not exceed what the core voltage is for.
const REFO: [u16; 2] = [0x0020, (RATE / 1035 * 1000 / 32_768 - 1) as u16];
/// [`RATE`] from REFO: everything but the link, which is told, takes 3.5 % longer.
pub const RATE_OF_REFO: u32 = (REFO[1] as u32 + 1) * 32_768;

/// XT2OFFG.
const NO_XT2: u16 = 1 << 3;
/// OFIE and OFIFG.
const OSCILLATOR: u16 = 1 << 1;

/// Address of the watchdog's control register.
pub const WATCHDOG: u16 = WDTCTL.0;

/// WDTCTL: password, from the VLO, counter clear, over 512: 54 ms typical, 37 to 85 ms.
pub const WATCHDOG_KICK: u16 = 0x5A00 | 0b10 << 5 | 1 << 3 | 6;

/// Restarts the watchdog's interval.
#[inline(always)]
pub fn kick() {
    WDTCTL.set(WATCHDOG_KICK);
}

/// Resets the chip: a write to the watchdog without its password.
pub fn reset() -> ! {
    loop {
        WDTCTL.set(0);
    }
}

/// [`FAILED`], [`RECOVERED`], or 0 as long as the crystal has always run.
#[unsafe(no_mangle)]
static mut PASAPAS_REFO: u8 = 0;
const FAILED: u8 = 1;
const RECOVERED: u8 = 2;

/// Milliseconds without a fault of the crystal after which it is used again.
const SOUND_MS: u8 = 100;
/// Those that have passed.
static mut SOUND: u8 = 0;

// Any oscillator's fault once the loop is locked is the crystal's: there is no other.
global_asm!(
    r#"
    .section .text.clock,"ax",@progbits
module.chip.clock:
    .global pasapas_oscillator
pasapas_oscillator:
    mov #{reference}, &{reference_register}
    mov #{factor}, &{factor_register}
    mov.b #{failed}, &PASAPAS_REFO
    bic #{oscillator}, &{enable}
    reti

    /* The supply has fallen below what 25 MHz need: as at power-up from here, pins at rest first, then the wait for the
       supply. A brown-out reset by software, at the core level that holds: SYSRSTIV tells it from other resets. */
    .global pasapas_supply
pasapas_supply:
    mov #0xa507, &{power}
    jmp pasapas_supply
    "#,
    reference = const REFO[0],
    factor = const REFO[1],
    reference_register = const UCSCTL3.0,
    factor_register = const UCSCTL2.0,
    oscillator = const OSCILLATOR,
    enable = const SFRIE1.0,
    failed = const FAILED,
    power = const PMMCTL0.0,
);

/// Whether the crystal does not run, since the start or since it failed.
#[inline(always)]
pub fn is_refo() -> bool {
    state() == FAILED
}

fn state() -> u8 {
    // SAFETY: a byte.
    unsafe { (&raw const PASAPAS_REFO).read_volatile() }
}

/// What is wrong with the clock, bits of the register of [`cause`]: 5, the crystal does not run; 6, it did not for some
/// time since the reset.
#[inline(always)]
pub fn fault() -> u8 {
    state() << 5
}

/// To be called once in a millisecond: a crystal that has failed is taken back when it has run for [`SOUND_MS`] without a
/// fault. A spark sets the fault's flag once; a crystal that stands still sets it again as soon as it is cleared.
pub fn recover() {
    if !is_refo() {
        return;
    }
    let stands = UCSCTL7.get() & NO_XT2 != 0;
    UCSCTL7.set(0);
    // SAFETY: a byte that only this function touches.
    let sound = unsafe { &mut *core::ptr::addr_of_mut!(SOUND) };
    *sound = if stands { 0 } else { *sound + 1 };
    if *sound < SOUND_MS {
        return;
    }
    *sound = 0;
    // The factor first: the loop moves the DCO by one step a period of its reference, downward here, and there is no time
    // for a second one.
    UCSCTL2.set(XT2[1]);
    UCSCTL3.set(XT2[0]);
    SFRIFG1.set(SFRIFG1.get() & !OSCILLATOR);
    // SAFETY: a byte; the interrupt that writes it, too, is not enabled.
    unsafe { (&raw mut PASAPAS_REFO).write_volatile(RECOVERED) };
    SFRIE1.set(OSCILLATOR);
}

/// Core voltage for 25 MHz once the supply is there, clocks, pins to their safe states, the timer of the
/// millisecond running; interrupts are still off.
pub fn hardware() {
    ports::open();
    // A watchdog reset leaves the level as it was.
    let mut level = u16::from(PMMCTL0_L.get() & 3);
    while level != 3 {
        kick();
        // The level after is tried again until the supply is high enough for it.
        if raise_core(level + 1) {
            level += 1;
        }
    }
    while !supply_suffices() {
        kick();
    }
    oscillate();
    kick();
    timer::open();
}

/// A level more for the core (SLAU208, 2.2.4), in the order that erratum FLASH37 asks for; `false`: the supply is
/// too low for it.
fn raise_core(level: u16) -> bool {
    PMMCTL0_H.set(0xA5);
    let enabled = PMMRIE.get();
    PMMRIE.set(enabled & !0x3377);
    let before = SVSMHCTL.get();
    let settled = |register: Word, value: u16, flag: u16| {
        PMMIFG.set(PMMIFG.get() & !flag);
        register.set(value);
        while PMMIFG.get() & flag == 0 {}
        PMMIFG.set(PMMIFG.get() & !flag);
    };
    PMMIFG.set(0);
    // The monitor of the supply first: its flag says that there is not enough.
    settled(SVSMHCTL, 0x4400 | before & 0x0300 | level, DELAY_HIGH);
    let enough = PMMIFG.get() & 1 << 5 == 0;
    if enough {
        settled(SVSMHCTL, 0x4400 | level << 8 | level, DELAY_HIGH);
        PMMCTL0_L.set(level as u8);
        settled(SVSMLCTL, 0x4400 | level << 8 | level, DELAY_LOW);
    } else {
        settled(SVSMHCTL, before, DELAY_HIGH);
    }
    PMMIFG.set(0);
    PMMRIE.set(enabled);
    PMMCTL0_H.set(0);
    enough
}

const DELAY_HIGH: u16 = 1 << 4;
const DELAY_LOW: u16 = 1;
/// The supply is below the monitor's level.
const SUPPLY_LOW: u16 = 1 << 5;

/// The monitor's level: 2.7 V (SVSMHRRL 5). 25 MHz are specified from 2.4 V on, and the highest level of the supervisor,
/// which resets by itself, is 2.1 V.
const MONITOR: u16 = 5;

/// Whether the supply is above the [`MONITOR`]'s level; if so, its fall below that resets the chip from now on.
fn supply_suffices() -> bool {
    PMMCTL0_H.set(0xA5);
    PMMIFG.set(0);
    SVSMHCTL.set(0x4400 | 3 << 8 | MONITOR);
    while PMMIFG.get() & DELAY_HIGH == 0 {}
    let suffices = PMMIFG.get() & SUPPLY_LOW == 0;
    PMMIFG.set(0);
    PMMCTL0_H.set(0);
    watch_supply(suffices);
    suffices
}

/// Whether a fall of the supply resets the chip. It does so by an interrupt that nothing else masks.
pub fn watch_supply(on: bool) {
    PMMCTL0_H.set(0xA5);
    let others = PMMRIE.get() & !SUPPLY_LOW;
    PMMRIE.set(others | if on { SUPPLY_LOW } else { 0 });
    PMMCTL0_H.set(0);
}

/// The DCO at [`RATE`], MCLK and SMCLK from it, ACLK from REFO.
fn oscillate() {
    UCSCTL6.set(0x00CD);
    // It starts within some milliseconds; 2000 rounds at 1 MHz are 50 ms.
    let mut left = 2000;
    UCSCTL3.set(XT2[0]);
    while left != 0 {
        kick();
        UCSCTL7.set(0);
        if UCSCTL7.get() & NO_XT2 == 0 {
            break;
        }
        left -= 1;
    }
    let [reference, factor] = if left == 0 { REFO } else { XT2 };
    // SAFETY: SCG0, which stops the loop; nothing else of the status register changes.
    unsafe { asm!("bis #0x40, r2", "nop") };
    UCSCTL0.set(0);
    UCSCTL1.set(RANGE);
    UCSCTL2.set(factor);
    UCSCTL3.set(reference);
    // SAFETY: as above.
    unsafe { asm!("bic #0x40, r2", "nop") };
    // 32 times 32 periods of the reference, at any rate on the way no less than that (SLAU208, 5.2.8).
    let mut settles = factor + 1;
    while settles != 0 {
        settles -= 1;
        kick();
        let mut cycles = 1024u16 / 4;
        while cycles != 0 {
            cycles -= 1;
            // SAFETY: no effect but its time.
            unsafe { asm!("nop") };
        }
    }
    UCSCTL4.set(0x0233);
    UCSCTL7.set(0);
    SFRIFG1.set(SFRIFG1.get() & !OSCILLATOR);
    if left == 0 {
        // SAFETY: a byte of this module; its interrupt is not enabled.
        unsafe { (&raw mut PASAPAS_REFO).write_volatile(FAILED) };
    } else {
        SFRIE1.set(OSCILLATOR);
    }
}

/// Why the chip was reset, from SYSRSTIV, as the G2553's IFG1 has it: bit 0 watchdog, and what the program counter
/// did where it should not be, 2 power on, 3 RST pin.
pub fn cause() -> u8 {
    let mut causes = 0;
    loop {
        causes |= match SYSRSTIV.get() {
            0 => return causes,
            // Brown-out, the supply's monitor (`pasapas_supply`), supervisors.
            0x02 | 0x06 | 0x0C..=0x12 => 1 << 2,
            0x04 => 1 << 3,
            // Watchdog, keys, fetch from peripherals.
            0x16.. => 1,
            _ => 0,
        }
    }
}
