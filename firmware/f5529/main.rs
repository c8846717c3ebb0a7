//! The image of the MSP430F5529: the machine of `firmware::machine` on its chip.
#![no_std]
#![no_main]
// The board half talks to registers, flash and assembly; each use gives its reason.
#![allow(unsafe_code)]
#![feature(asm_experimental_arch)]

use msp430_rt as _;

mod boot;
mod bus;
mod chain;
#[path = "../shared/check.rs"]
mod check;
mod chip;
mod flash;
mod guard;
mod link;
#[path = "../shared/math.rs"]
mod math;
mod measure;
#[path = "../shared/memory.rs"]
mod memory;
mod observe;
mod port;
mod ram;
mod scaled;
mod step;
mod vm;
#[path = "../shared/vm_core.rs"]
mod vm_core;

use crate::link::Uart;
use crate::port::F5529;
use core::mem::MaybeUninit;
use core::ptr::addr_of_mut;
use firmware::machine::Controller;
use firmware::modbus::Slave;

/// Nothing panics on purpose: an unexpected one hangs with interrupts off until the watchdog
/// resets the chip (25 to 128 ms), which reports F17.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {
        msp430::interrupt::disable();
    }
}

/// What a panic comes to where the image is built without messages (`panic=immediate-abort`): the
/// same.
#[unsafe(no_mangle)]
extern "C" fn abort() -> ! {
    loop {
        msp430::interrupt::disable();
    }
}

/// The machine.
pub static mut CONTROLLER: MaybeUninit<Controller<F5529>> = MaybeUninit::zeroed();
static mut SLAVES: [Slave; 2] = [Slave::new(), Slave::new()];

/// Called by `Reset` once RAM is ready.
#[unsafe(no_mangle)]
extern "C" fn main() -> ! {
    chip::clock::hardware();
    // SAFETY: `main` is the only code that knows these statics, and never returns; they are zero.
    let (controller, slaves) = unsafe {
        (Controller::init(addr_of_mut!(CONTROLLER).cast(), F5529), &mut *addr_of_mut!(SLAVES))
    };
    step::init(controller.record);
    if controller.chained() && controller.wired() {
        chain::open();
    }
    controller.motor.pwm.open(&F5529, controller.record.more());
    controller.open_aout();
    controller.open_analog();
    controller.motor.power = controller.full_power();
    guard::open(controller.record.falling(), controller.record.input_invert);
    controller.reset.cause = chip::clock::cause();
    // Stop held at reset: 9600 8N1, address 1, whatever the profile says.
    let mut lines = [Uart::back(), Uart::rs485()];
    let more = controller.record.more();
    let mut addresses = [controller.record.address, more.rs485_address];
    if chain::buttons() & 1 != 0 {
        addresses[0] = 1;
        lines[0].open(0);
    } else {
        lines[0].open(controller.record.rate);
    }
    let mut open = 1;
    if addresses[1] != 0 {
        lines[1].open(more.rs485_rate);
        open = lines.len();
    }
    // SAFETY: the set-up shares nothing with an interrupt any more.
    unsafe { msp430::interrupt::enable() };
    controller.mount();
    loop {
        boot::kick();
        controller.begin_pass();
        let mut n = 0;
        while n != open {
            controller.serve_line(n as u8, &mut lines[n], &mut slaves[n], addresses[n]);
            n += 1;
        }
        controller.pass();
        measure::poll();
        if controller.wants_reset() {
            boot::restart();
        }
    }
}
