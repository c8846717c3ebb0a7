//! The MSP430G2553 image: 16 KB of flash, 512 bytes of RAM, all in assembly.
//!
//! One file is one thing; `main.s` calls the others round and round. Each routine's header names
//! what it takes and leaves; r11 to r15 are free to use and r4 to r10 are kept unless it says
//! otherwise. The twin of each stands in `firmware`'s library or in `lang`.
#![no_std]
#![no_main]
// All of it talks to registers, flash and fixed RAM addresses.
#![allow(unsafe_code)]
#![feature(asm_experimental_arch)]

use msp430_rt as _;
// Brings the interrupt vectors' names into the link.
use msp430g2553 as _;

mod pins;
mod vm;
// Symbols come first, so that the assembler knows constants when it meets them.
mod consts;

mod chip;
mod ram;

mod micro;

#[path = "../shared/check.rs"]
mod check;
#[path = "../shared/memory.rs"]
mod memory;
#[path = "../shared/vm_core.rs"]
mod vm_core;

mod boot;
mod effects;

// Beside the ramps, which reach them by near jumps.
#[path = "../shared/math.rs"]
mod math;

mod scaled;

mod motion;
mod moves;

// In this order, so that the session reaches the outputs and inputs by near jumps.
mod session;

mod io;
// Beside the store, whose refusals its writers jump to.
mod link;
mod store;

core::arch::global_asm!(include_str!("main.s"), options(raw));

/// Nothing panics: no Rust runs. The linker wants it all the same.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {}
}
