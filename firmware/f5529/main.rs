//! The images in Rust: main loop, and what it serves; what differs from chip to chip is in [`chip`].
#![no_std]
#![no_main]
// The board half talks to registers, flash and assembly; each use gives its reason.
#![allow(unsafe_code)]
#![feature(asm_experimental_arch)]

use msp430_rt as _;

mod arcs;
mod boot;
mod bus;
mod chain;
#[path = "../shared/check.rs"]
mod check;
mod chip;
mod commands;
mod controller;
mod effects;
mod flash;
mod guard;
mod home;
mod limits;
mod lines;
mod link;
mod lock;
mod map;
#[path = "../shared/math.rs"]
mod math;
#[path = "../shared/memory.rs"]
mod memory;
mod motor;
mod moves;
mod observe;
mod pool;
mod probe;
mod profile;
mod pwm;
mod scaled;
mod step;
mod stream;
mod vm;
#[path = "../shared/vm_core.rs"]
mod vm_core;

use crate::controller::Controller;
use crate::link::Uart;
use core::mem::MaybeUninit;
use core::ptr::addr_of_mut;
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

/// Whether the VM stands in a streamed piece.
fn streams() -> bool {
    stream::owns()
}

static mut CONTROLLER: MaybeUninit<Controller> = MaybeUninit::zeroed();
static mut SLAVES: [Slave; 2] = [Slave::new(), Slave::new()];

/// Called by `Reset` once RAM is ready.
#[unsafe(no_mangle)]
extern "C" fn main() -> ! {
    chip::clock::hardware();
    // SAFETY: `main` is the only code that knows these statics, and never returns; they are zero.
    let (controller, slaves) =
        unsafe { (Controller::init(addr_of_mut!(CONTROLLER).cast()), &mut *addr_of_mut!(SLAVES)) };
    step::init(controller.record);
    if controller.chained() {
        chain::open();
    }
    controller.motor.pwm.open(controller.record.more());
    controller.motor.power = controller.full_power();
    guard::open(controller.record.falling(), controller.record.input_invert);
    controller.reset.cause = chip::clock::cause();
    controller.reset.bites = boot::bites(controller.reset.cause);
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
        controller.lines.rests = true;
        let mut n = 0;
        while n != open {
            let (line, slave) = (&mut lines[n], &mut slaves[n]);
            controller.lines.line = n as u8;
            if let Some(length) = line.frame()
                && slave.request(line, controller, addresses[n], length)
            {
                controller.lines.heard();
                slave.poll(line, controller);
                // A request of many registers takes as long as a short segment lasts.
                controller.motor.poll(controller.trace.full);
            }
            slave.poll(line, controller);
            if line.rests() {
                line.follow_clock();
            } else {
                controller.lines.rests = false;
            }
            n += 1;
        }
        controller.incoming.write(&mut controller.store);
        controller.ticks();
        controller.motor.poll(controller.trace.full);
        controller.tripped();
        controller.run();
        if controller.reset.wanted && controller.lines.rests {
            boot::restart();
        }
    }
}
