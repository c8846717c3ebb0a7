//! The MSP430G2553 image: registers, interrupts, main loop. All `unsafe` of the project is here.
#![no_std]
#![no_main]
// The board half talks to registers, flash and assembly; each use gives its reason.
#![allow(unsafe_code)]
#![feature(asm_experimental_arch)]

use msp430_rt as _;

mod boot;
mod math;
mod pins;
mod reg;

/// Nothing panics on purpose: an unexpected one hangs with interrupts off until the watchdog
/// resets the chip (25 to 128 ms), which reports F17.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {
        msp430::interrupt::disable();
    }
}

/// Called by `Reset` once RAM is ready.
#[unsafe(no_mangle)]
extern "C" fn main() -> ! {
    boot::hardware();
    loop {
        boot::kick();
    }
}
