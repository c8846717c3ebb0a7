//! The MSP430G2553 image: registers, interrupts, main loop. All `unsafe` of the project is here.
#![no_std]
#![no_main]
// The board half talks to registers, flash and assembly; each use gives its reason.
#![allow(unsafe_code)]
#![feature(asm_experimental_arch)]

use msp430_rt as _;

mod boot;
mod link;
mod math;
mod pins;
mod reg;
mod scaled;
mod vm;
mod vm_core;

/// Nothing panics on purpose: an unexpected one hangs with interrupts off until the watchdog
/// resets the chip (25 to 128 ms), which reports F17.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {
        msp430::interrupt::disable();
    }
}

use firmware::modbus::{Map, Slave};
use lang::wire::{Exception, Table};
static mut CELLS: [u16; 16] = [0; 16];
struct M;
impl Map for M {
    fn begin(&mut self) {}
    fn read(&mut self, _: Table, address: u16) -> u16 {
        unsafe { CELLS[usize::from(address & 15)] }
    }
    fn read_bit(&mut self, _: Table, address: u16) -> bool {
        address & 1 != 0
    }
    fn write(&mut self, address: u16, value: u16) -> Result<(), Exception> {
        unsafe { CELLS[usize::from(address & 15)] = value };
        Ok(())
    }
    fn write_long(&mut self, _: u16, _: i32) -> Result<(), Exception> {
        Ok(())
    }
    fn write_bit(&mut self, _: u16, _: bool) -> Result<(), Exception> {
        Ok(())
    }
    fn written(&mut self, _: u16) -> Result<(), Exception> {
        Ok(())
    }
}

/// Called by `Reset` once RAM is ready.
#[unsafe(no_mangle)]
extern "C" fn main() -> ! {
    boot::hardware();
    let mut line = link::Uart;
    link::Uart::open(3);
    let mut slave = Slave::new();
    // SAFETY: nothing of the set-up is shared with an interrupt any more.
    unsafe { msp430::interrupt::enable() };
    loop {
        boot::kick();
        if let Some(length) = line.frame() {
            slave.request(&mut line, &mut M, 1, length);
        }
        let x = vm_core::run();
        unsafe {
            CELLS[0] = x;
        }
        slave.poll(&mut line, &mut M);
    }
}
