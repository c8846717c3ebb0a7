//! Memory map and resets of the MSP430x5xx: everything of the chip except its CPU.

mod events;
mod flash;
mod memory;
mod modules;
mod pins;
mod registers;

use super::periph::adc12::Adc12;
use super::periph::crc16::Crc16;
use super::periph::flash::Flash;
use super::periph::mpy32::Mpy32;
use super::periph::pmap::Pmap;
use super::periph::pmm::Pmm;
use super::periph::sys::Sys;
use super::periph::ucs::Ucs;
use super::silicon::Silicon;
use crate::line::HostLine;
use crate::part::Part;
use crate::periph::flash as flash_memory;
use crate::periph::port::Port;
use crate::periph::timer::{Timer, Variant as TimerVariant};
use crate::periph::usci;
use crate::periph::usci_spi::Spi;
use crate::periph::usci_uart::Uart;
use crate::periph::watchdog::{Variant, Watchdog};
use crate::plant::Plant;
use crate::reset::Reset;
use crate::rng::Rng;
use crate::warn::{Kind, Warning, Warnings};

/// First address of the interrupt vector table; vector n of 64 stands at `VECTORS + 2 n`.
const VECTORS: u16 = 0xFF80;

/// How a block of 128 bytes answers.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Block {
    /// Peripherals, protected memory or nothing: the slow way.
    Slow,
    Flash,
    Ram,
}

const BLOCK_BITS: u32 = 7;
/// Blocks of the 20-bit address space.
const BLOCKS: usize = 0x10_0000 >> BLOCK_BITS;
/// Bytes kept of the address space: a power of two, so that no access needs a check.
const BYTES: usize = 0x4_0000;

/// An array on the heap that never was on the stack.
fn boxed<T: Copy, const N: usize>(value: T) -> Box<[T; N]> {
    match vec![value; N].into_boxed_slice().try_into() {
        Ok(array) => array,
        Err(_) => unreachable!("the vector has that length"),
    }
}

/// A USCI_A module with its own flags.
#[derive(Clone, Default)]
struct UsciA {
    uart: Uart,
    /// Level at its receive pin.
    rx: bool,
    ie: u8,
    ifg: u8,
}

/// A USCI_B module with its own flags.
#[derive(Clone, Default)]
struct UsciB {
    spi: Spi,
    ie: u8,
    ifg: u8,
}

/// SYSNMI and UNMI, as bits of [`Bus::irq`].
const NMI: u64 = 3 << 61;

/// Everything at the other end of the CPU's buses.
#[derive(Clone)]
pub struct Bus {
    /// Time in ticks since power-up.
    pub now: u64,
    /// Address of the instruction being executed.
    pub pc: u32,
    /// Ticks of one CPU cycle.
    pub cycle: u64,
    /// The CPU must come back to its caller.
    pub attention: bool,
    /// When the next event is due.
    pub next_event: u64,
    /// Pending and enabled interrupts: bit n for the vector at 0xFF80 + 2 n.
    pub irq: u64,
    irq_since: [u64; 64],
    /// Those of [`NMI`] whose handlers run.
    served: u64,
    /// A reset that was asked for.
    pub reset: Option<Reset>,
    /// Power failed during a flash operation.
    pub power_lost: bool,
    /// A flash operation was done.
    pub flash_written: bool,
    /// Code in this range changed.
    pub code_changed: Option<(u32, u32)>,
    /// Lowest address that the stack may reach.
    pub stack_limit: u32,
    /// The status register, as the CPU wrote it last: GIE and low-power bits count.
    pub status: u16,
    /// An interrupt handler is being executed.
    pub in_handler: bool,
    /// Since power-up the multiplier was used with interrupts on outside of handlers, and in one.
    multiplied: [bool; 2],
    /// Broken rules.
    pub warnings: Warnings,
    /// World around the pins.
    pub plant: Plant,
    /// Host's end of the line at USCI_A1, the back channel.
    pub line: HostLine,
    /// The other end of the line at USCI_A0.
    pub rs485: HostLine,
    /// Flash controller.
    pub flash: Flash,
    vcc: u32,
    vlo_hz: u64,
    part: Part,
    silicon: Silicon,
    mem: Box<[u8; BYTES]>,
    map: Box<[Block; BLOCKS]>,
    sys: Sys,
    pmm: Pmm,
    ucs: Ucs,
    ports: [Port; 8],
    pj: Port,
    pmap: Pmap,
    /// TA0, TA1, TA2, TB0.
    timers: [Timer<7>; 4],
    usci_a: [UsciA; 2],
    usci_b: [UsciB; 2],
    pub(crate) wdt: Watchdog,
    mpy: Mpy32,
    crc: Crc16,
    adc: Adc12,
    /// RCCTL0
    ram_control: u16,
    /// Levels of all pins, as the plant numbers them.
    levels: u64,
    /// Pins that erratum PORT16 drives low.
    held_low: u64,
}

fn timers(silicon: &Silicon) -> [Timer<7>; 4] {
    let a = |channels| Timer::new(TimerVariant::A5, channels);
    let b = TimerVariant { tb25: silicon.tb25, ..TimerVariant::B5 };
    [a(5), a(3), a(3), Timer::new(b, 7)]
}

impl Bus {
    /// A chip with erased flash and the identity bytes of its device descriptor.
    pub fn new(part: Part, plant: Plant, vlo_hz: u64, vcc: u32, silicon: Silicon) -> Bus {
        let mut map = boxed(Block::Slow);
        for (n, block) in map.iter_mut().enumerate() {
            let addr = (n as u32) << BLOCK_BITS;
            let usb = part.usb_ram.as_ref().is_some_and(|range| range.contains(&addr));
            if part.ram.contains(&addr) || usb {
                *block = Block::Ram;
            } else if part.info.contains(&addr) || part.flash.contains(&addr) {
                *block = Block::Flash;
            }
        }
        let ucs = Ucs::new(&silicon, vlo_hz, part.ticks_per_second);
        let delay = silicon.supervisor_us * (part.ticks_per_second / 1_000_000);
        let mut mem = boxed(0xFF);
        // Device identity 2955h and a hardware revision (SLAS590, "Device Descriptors").
        mem[0x1A04..0x1A07].copy_from_slice(&[0x55, 0x29, 0x18]);
        Bus {
            now: 0,
            pc: 0,
            cycle: ucs.rates.mclk,
            attention: false,
            next_event: 0,
            irq: 0,
            irq_since: [0; 64],
            served: 0,
            reset: None,
            power_lost: false,
            flash_written: false,
            code_changed: None,
            stack_limit: 0,
            status: 0,
            in_handler: false,
            multiplied: [false; 2],
            warnings: Warnings::default(),
            plant,
            line: HostLine::new(part.ticks_per_second),
            rs485: HostLine::new(part.ticks_per_second),
            flash: Flash::new(silicon.flash),
            vcc,
            vlo_hz,
            wdt: Watchdog::new(Variant::A, 0, &ucs.rates),
            part,
            mem,
            map,
            sys: Sys::default(),
            pmm: Pmm::new(delay),
            ucs,
            ports: Default::default(),
            pj: Port::default(),
            pmap: Pmap::default(),
            timers: timers(&silicon),
            usci_a: Default::default(),
            usci_b: Default::default(),
            mpy: Mpy32::default(),
            crc: Crc16::default(),
            adc: Adc12::default(),
            ram_control: 0,
            levels: 0,
            held_low: 0,
            silicon,
        }
    }

    /// The part.
    pub fn part(&self) -> &Part {
        &self.part
    }

    /// Ticks of a period of SMCLK, 0 while it stands still.
    pub fn smclk(&self) -> u64 {
        self.ucs.rates.smclk
    }

    /// Characters that USCI_A1 overwrote.
    pub fn overruns(&self) -> u64 {
        self.usci_a[1].uart.overruns
    }

    /// Ticks of a number of microseconds.
    fn ticks(&self, us: u64) -> u64 {
        us * (self.part.ticks_per_second / 1_000_000)
    }

    /// Remembers a broken rule.
    #[cold]
    pub fn warn(&mut self, kind: Kind, addr: u32) {
        self.warnings.add(Warning { cycle: self.now, pc: self.pc, addr, kind });
    }

    /// The same, for the loader.
    pub fn warn_far(&mut self, kind: Kind, addr: u32) {
        self.warn(kind, addr);
    }

    /// Asks for a reset at the end of the instruction.
    fn ask_reset(&mut self, reset: Reset) {
        self.reset = Some(reset);
        self.attention = true;
    }

    /// The low-power bits of the status register changed.
    pub fn set_clock_gates(&mut self, sr: u16) {
        self.ucs.gates = sr;
        self.reclock();
    }

    /// The supply has another voltage: a supervisor may reset.
    pub fn set_supply(&mut self, vcc: u32) {
        self.vcc = vcc;
        if self.pmm.watch(vcc) {
            self.ask_reset(Reset::Supervisor);
        }
        self.update();
    }

    /// Resets the peripherals: a PUC, and a POR or BOR when the reset is one.
    pub fn apply_reset(&mut self, reset: Reset) {
        use Reset::{Pin, Power, SoftwareBrownOut, SoftwarePowerOn, Supervisor};
        self.plant.cut_short();
        let brown_out = matches!(reset, Power | Pin | SoftwareBrownOut);
        let por = brown_out || matches!(reset, SoftwarePowerOn | Supervisor);
        if brown_out {
            self.pmm.brown_out();
            if reset == Pin && self.silicon.port16 {
                self.port16();
            }
            self.now += self.ticks(self.silicon.boot_us);
            self.held_low = 0;
        }
        self.pmm.close();
        self.sys.reset(reset);
        self.status = 0;
        self.in_handler = false;
        if por {
            for timer in &mut self.timers {
                timer.reset();
            }
            self.mpy = Mpy32::default();
        }
        for port in self.ports.iter_mut().chain([&mut self.pj]) {
            port.reset(0);
        }
        self.pmap = Pmap::default();
        self.usci_a = Default::default();
        self.usci_b = Default::default();
        for module in &mut self.usci_a {
            module.uart.software_reset(&mut module.ifg);
        }
        for module in &mut self.usci_b {
            module.spi.software_reset(&mut module.ifg);
        }
        self.flash.reset(reset == Power);
        self.crc = Crc16::default();
        self.ram_control = 0;
        self.ucs.reset(self.now);
        self.wdt = Watchdog::new(Variant::A, self.now, &self.ucs.rates);
        self.irq = 0;
        self.served = 0;
        self.reclock();
        self.update_pins(self.now);
        self.update();
    }

    /// The boot code has been cut by RST: pins that the smallest package lacks are low from now on.
    fn port16(&mut self) {
        for port in self.ports.iter_mut().chain([&mut self.pj]) {
            port.reset(0);
        }
        for timer in &mut self.timers {
            timer.reset();
        }
        self.held_low = pins::NOT_IN_EVERY_PACKAGE;
        self.update_pins(self.now);
    }

    /// The supply is gone: the chip drives no pin any more.
    pub fn power_off(&mut self) {
        self.plant.cut_short();
        for port in &mut self.ports {
            port.reset(0);
        }
        for timer in &mut self.timers {
            timer.reset();
        }
        self.interrupted_erase();
        self.update_pins(self.now);
        self.irq = 0;
        self.served = 0;
    }

    /// Power comes up after `power_off`; flash bits settle when they are `unstable`.
    pub fn power_up(&mut self, noise: &mut Rng, unstable: bool) {
        self.power_lost = false;
        self.reset = None;
        // The oscillators begin anew.
        self.ucs = Ucs::new(&self.silicon, self.vlo_hz, self.part.ticks_per_second);
        self.line.skip(self.now);
        self.rs485.skip(self.now);
        self.plant.power_up(noise);
        if unstable {
            flash_memory::settle(&self.flash.wear, &mut self.mem[..], noise);
            self.code_changed = Some((0, BYTES as u32 - 1));
        }
    }

    /// Vector address of the highest pending interrupt that may be served.
    #[inline]
    pub fn pending(&self, maskable: bool) -> Option<(u16, u64)> {
        let mut irq = if maskable { self.irq } else { self.irq & NMI };
        // A handler is not interrupted by another of its level before its RETI (SLAU208, 1.3.2).
        if self.served != 0 {
            irq &= !(NMI & (self.served | self.served >> 1));
        }
        if self.flash_is_busy() && !self.silicon.interrupts_while_busy {
            irq = 0;
        }
        if irq == 0 {
            return None;
        }
        let n = 63 - irq.leading_zeros();
        Some((VECTORS + 2 * n as u16, self.irq_since[n as usize]))
    }

    /// Where the vector stands that the table gives for `vector`: in flash, or at the top of RAM.
    pub fn vector_address(&self, vector: u16) -> u32 {
        if self.sys.vectors_in_ram() {
            self.part.ram.end() + 1 - 0x80 + u32::from(vector - VECTORS)
        } else {
            u32::from(vector)
        }
    }

    /// The interrupt at `vector` was accepted: single-source flags reset themselves.
    pub fn accepted(&mut self, vector: u16) {
        match vector {
            0xFFF6 => self.timers[3].accepted0(),
            0xFFF2 => self.sys.ifg &= !super::periph::sys::WDT,
            0xFFEA => self.timers[0].accepted0(),
            0xFFE2 => self.timers[1].accepted0(),
            0xFFD8 => self.timers[2].accepted0(),
            0xFFFA | 0xFFFC => self.served |= 1 << ((vector - VECTORS) / 2),
            _ => {}
        }
        self.update();
    }

    /// A handler has come back: the highest of those that are not masked, as the others wait for them.
    pub fn returned(&mut self) {
        if self.served != 0 {
            self.served &= !(1 << (63 - self.served.leading_zeros()));
        }
    }
}

/// Pending and enabled flags of a USCI module, as its vector register reads.
fn usci_vector(ie: u8, ifg: u8) -> u16 {
    match ie & ifg {
        pending if pending & usci::RX != 0 => 2,
        pending if pending & usci::TX != 0 => 4,
        _ => 0,
    }
}
