//! Memory map, peripheral dispatch and events: everything of the chip except its CPU.

mod events;
mod flash;
mod pins;
mod registers;
mod supply;
mod wires;

use crate::line::HostLine;
use crate::part::{Part, VECTORS};
use crate::periph::NEVER;
use crate::periph::adc10::Adc10;
use crate::periph::clock::{CALIBRATION, Clock};
use crate::periph::flash::{self as flash_memory, Flash};
use crate::periph::port::Port;
use crate::periph::sfr;
use crate::periph::timer::Timer;
use crate::periph::usci_spi::Spi;
use crate::periph::usci_uart::Uart;
use crate::periph::watchdog::{Variant, Watchdog};
use crate::plant::Plant;
use crate::reset::Reset;
use crate::rng::Rng;
use crate::warn::{Kind, Warning, Warnings};
pub use supply::Supply;
use wires::Wires;

/// How a block of 64 bytes answers.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Block {
    /// Peripherals, mirrors or nothing: the slow way.
    Slow,
    Flash,
    Ram,
}

/// What reads of vacant addresses give: the code of `JMP $`.
const VACANT: u16 = 0x3FFF;

/// Everything at the other end of the CPU's buses.
#[derive(Clone)]
pub struct Bus {
    /// Time in ticks of 62.5 ns since power-up.
    pub now: u64,
    /// Address of the instruction being executed.
    pub pc: u16,
    /// Ticks of one CPU cycle.
    pub cycle: u64,
    /// The CPU must come back to its caller.
    pub attention: bool,
    /// When the next event is due.
    pub next_event: u64,
    /// Pending and enabled interrupts: bit n for the vector at 0xFFE0 + 2 n.
    pub irq: u16,
    /// Since when each of them has been pending.
    pub irq_since: [u64; 16],
    /// A reset that was asked for.
    pub reset: Option<Reset>,
    /// Power failed during a flash operation.
    pub power_lost: bool,
    /// A flash operation was done.
    pub flash_written: bool,
    /// Code in this range changed.
    pub code_changed: Option<(u16, u16)>,
    /// Lowest address that the stack may reach.
    pub stack_limit: u16,
    /// The supply.
    pub(crate) supply: Supply,
    /// Until when a wire whose pull-up was switched on is still low.
    pub(crate) wires: Wires,
    /// Broken rules.
    pub warnings: Warnings,
    /// World around the pins.
    pub plant: Plant,
    /// Host's end of the serial line.
    pub line: HostLine,
    /// Flash controller.
    pub flash: Flash,
    part: Part,
    mem: Box<[u8; 0x1_0000]>,
    map: [Block; 1024],
    ie: [u8; 2],
    ifg: [u8; 2],
    clock: Clock,
    ports: [Port; 4],
    timers: [Timer<3>; 2],
    uart: Uart,
    spi: Spi,
    pub(crate) wdt: Watchdog,
    adc: Adc10,
    comparator: [u8; 3],
    i2c: [u16; 2],
    /// When a wire of port 1 comes up.
    next_wire: u64,
}

impl Bus {
    /// Characters that the UART overwrote.
    pub fn overruns(&self) -> u64 {
        self.uart.overruns
    }

    /// A chip with erased flash and TI's calibration values in segment A.
    pub fn new(part: Part, plant: Plant, vlo_hz: u64, supply: Supply) -> Bus {
        let mut map = [Block::Slow; 1024];
        for (n, block) in map.iter_mut().enumerate() {
            let addr = n as u32 * 64;
            if part.ram.contains(&addr) {
                *block = Block::Ram;
            } else if part.info.contains(&addr) || part.flash.contains(&addr) {
                *block = Block::Flash;
            }
        }
        let clock = Clock::new(vlo_hz, 0);
        let mut bus = Bus {
            now: 0,
            pc: 0,
            cycle: 1,
            attention: false,
            next_event: 0,
            irq: 0,
            irq_since: [0; 16],
            reset: None,
            power_lost: false,
            flash_written: false,
            code_changed: None,
            stack_limit: 0,
            supply,
            wires: Wires::default(),
            warnings: Warnings::default(),
            plant,
            line: HostLine::new(part.ticks_per_second),
            flash: Flash::default(),
            mem: vec![0xFF; 0x1_0000]
                .into_boxed_slice()
                .try_into()
                .unwrap_or_else(|_| Box::new([0xFF; 0x1_0000])),
            map,
            ie: [0; 2],
            ifg: [0, 0],
            wdt: Watchdog::new(Variant::Plus, 0, &clock.rates),
            clock,
            ports: Default::default(),
            timers: Default::default(),
            uart: Uart::default(),
            spi: Spi::default(),
            adc: Adc10::default(),
            comparator: [0; 3],
            i2c: [0; 2],
            next_wire: NEVER,
            part,
        };
        bus.calibrate();
        bus
    }

    /// Writes the TLV structure of segment A (SLAU144, chapter 24).
    fn calibrate(&mut self) {
        let base = *self.part.info.end() as usize - 63;
        // TAG_ADC10_1 at 0xDA and TAG_DCO_30 at 0xF6, each followed by its length.
        self.mem[base + 0x1A..base + 0x1C].copy_from_slice(&[0x08, 0x10]);
        self.mem[base + 0x36..base + 0x38].copy_from_slice(&[0x01, 0x08]);
        for (dco_at, bc1_at, _, dco, bc1) in CALIBRATION {
            self.mem[usize::from(dco_at)] = dco;
            self.mem[usize::from(bc1_at)] = bc1;
        }
        let sum = self.mem[base + 2..base + 64]
            .chunks(2)
            .fold(0, |sum, pair| sum ^ u16::from_le_bytes([pair[0], pair[1]]));
        self.mem[base..base + 2].copy_from_slice(&sum.wrapping_neg().to_le_bytes());
    }

    /// Ticks of a period of SMCLK, 0 while it stands still.
    pub fn smclk(&self) -> u64 {
        self.clock.rates.smclk
    }

    /// The part.
    pub fn part(&self) -> &Part {
        &self.part
    }

    /// Whether `addr` is in flash or information memory.
    #[inline]
    pub fn is_flash(&self, addr: u16) -> bool {
        self.map[usize::from(addr >> 6)] == Block::Flash
    }

    /// Remembers a broken rule.
    #[cold]
    pub fn warn(&mut self, kind: Kind, addr: u16) {
        let (pc, addr) = (self.pc.into(), addr.into());
        self.warnings.add(Warning { cycle: self.now, pc, addr, kind });
    }

    /// Remembers a broken rule at an address that the CPU can't reach.
    pub fn warn_far(&mut self, kind: Kind, addr: u32) {
        let pc = self.pc.into();
        self.warnings.add(Warning { cycle: self.now, pc, addr, kind });
    }

    /// Reads a code word.
    pub fn fetch(&mut self, addr: u16) -> u16 {
        if self.map[usize::from(addr >> 6)] == Block::Slow {
            return VACANT;
        }
        self.word(addr)
    }

    /// An instruction at `pc`: true when the part resets instead of executing it.
    #[inline]
    pub fn fetch_fault(&mut self, pc: u16) -> bool {
        if self.map[usize::from(pc >> 6)] != Block::Slow {
            return false;
        }
        self.pc = pc;
        if pc < 0x200 {
            self.warn(Kind::FetchFault, pc);
            self.now += self.cycle;
            self.ask_reset(Reset::Fetch);
            return true;
        }
        self.warn(Kind::Unmapped, pc);
        false
    }

    /// Asks for a reset at the end of the instruction.
    pub fn ask_reset(&mut self, reset: Reset) {
        self.reset = Some(reset);
        self.attention = true;
    }

    /// A word of RAM or flash as it is.
    pub fn word(&self, addr: u16) -> u16 {
        let at = usize::from(addr & !1);
        u16::from_le_bytes([self.mem[at], self.mem[at | 1]])
    }

    /// All of memory as it is; peripherals are not in it.
    pub fn memory(&self) -> &[u8] {
        &self.mem[..]
    }

    /// Memory for loaders and tests. Code may have changed afterwards.
    pub fn memory_mut(&mut self) -> &mut [u8] {
        self.code_changed = Some((0, 0xFFFF));
        self.attention = true;
        &mut self.mem[..]
    }

    /// Reads a byte as an instruction does.
    #[inline(always)]
    pub fn read8(&mut self, addr: u16) -> u8 {
        if self.map[usize::from(addr >> 6)] == Block::Slow {
            return self.slow_read8(addr);
        }
        self.mem[usize::from(addr)]
    }

    /// Reads a word as an instruction does.
    #[inline(always)]
    pub fn read16(&mut self, addr: u16) -> u16 {
        if addr & 1 != 0 {
            self.warn(Kind::Unaligned, addr);
        }
        if self.map[usize::from(addr >> 6)] == Block::Slow {
            return self.slow_read16(addr & !1);
        }
        self.word(addr)
    }

    /// Writes a byte as an instruction does.
    #[inline(always)]
    pub fn write8(&mut self, addr: u16, value: u8) {
        if self.map[usize::from(addr >> 6)] == Block::Ram {
            self.mem[usize::from(addr)] = value;
        } else {
            self.slow_write8(addr, value);
        }
    }

    /// Writes a word as an instruction does.
    #[inline(always)]
    pub fn write16(&mut self, addr: u16, value: u16) {
        if addr & 1 != 0 {
            self.warn(Kind::Unaligned, addr);
        }
        let addr = addr & !1;
        if self.map[usize::from(addr >> 6)] == Block::Ram {
            let at = usize::from(addr);
            self.mem[at] = value as u8;
            self.mem[at | 1] = (value >> 8) as u8;
        } else {
            self.slow_write16(addr, value);
        }
    }

    /// The stack pointer went down to `sp`.
    #[inline(always)]
    pub fn check_stack(&mut self, sp: u16) {
        if sp < self.stack_limit {
            self.warn(Kind::Stack, sp);
        }
    }

    /// The low-power bits of the status register changed.
    pub fn set_clock_gates(&mut self, sr: u16) {
        self.clock.gates = sr;
        self.reclock();
    }

    /// The supply has another voltage.
    pub fn set_supply(&mut self, vcc: u32) {
        self.supply = Supply::new(vcc, 0);
        self.check_supply();
    }

    /// Resets the peripherals: a PUC, and a POR when the reset is one.
    pub fn apply_reset(&mut self, reset: Reset) {
        use Reset::{Pin, Power, Watchdog as Dog, WatchdogKey};
        self.plant.cut_short();
        let por = matches!(reset, Power | Pin);
        match reset {
            Power => self.ifg[0] = sfr::POR | sfr::OF,
            Pin => self.ifg[0] |= sfr::RST,
            Dog | WatchdogKey => self.ifg[0] |= sfr::WDT,
            _ => {}
        }
        self.ie = [0; 2];
        self.ifg[1] = sfr::UCA0TX | sfr::UCB0TX;
        let Clock { vlo_hz, dco_ppm, .. } = self.clock;
        self.clock = Clock::new(vlo_hz, dco_ppm);
        self.wires.discharge();
        self.cycle = self.clock.rates.mclk;
        for (n, port) in self.ports.iter_mut().enumerate() {
            port.reset(if n == 1 { 0xC0 } else { 0 });
        }
        if por {
            self.timers = Default::default();
            self.adc = Adc10::default();
        }
        self.uart = Uart::default();
        self.spi = Spi::default();
        if reset == Power {
            self.flash.power_up();
        } else {
            self.flash.reset();
        }
        self.wdt = Watchdog::new(Variant::Plus, self.now, &self.clock.rates);
        self.comparator = [0; 3];
        self.i2c = [0; 2];
        self.reclock();
        self.irq = 0;
        self.update_pins(self.now);
        self.update();
    }

    /// The supply is gone: the chip drives no pin any more.
    pub fn power_off(&mut self) {
        self.plant.cut_short();
        for port in &mut self.ports {
            port.reset(0);
        }
        self.update_pins(self.now);
        self.irq = 0;
    }

    /// Power comes up after `power_off`; flash bits settle when they are `unstable`.
    pub fn power_up(&mut self, noise: &mut Rng, unstable: bool) {
        self.power_lost = false;
        self.reset = None;
        self.line.skip(self.now);
        self.supply.up(self.now);
        self.plant.power_up(noise);
        if unstable {
            flash_memory::settle(&self.flash.wear, &mut self.mem[..], noise);
            self.code_changed = Some((0, 0xFFFF));
        }
    }

    /// Vector address of the highest pending interrupt that may be served.
    #[inline]
    pub fn pending(&self, maskable: bool) -> Option<(u16, u64)> {
        const NMI: u16 = 1 << 14;
        let irq = if maskable { self.irq } else { self.irq & NMI };
        if irq == 0 {
            return None;
        }
        let n = 15 - irq.leading_zeros();
        Some((VECTORS + 2 * n as u16, self.irq_since[n as usize]))
    }

    /// The interrupt at `vector` was accepted: single-source flags reset themselves.
    pub fn accepted(&mut self, vector: u16) {
        match vector {
            0xFFFC => self.ie[0] &= !(sfr::OF | sfr::ACCV | 0x10),
            0xFFFA => self.timers[1].accepted0(),
            0xFFF4 => self.ifg[0] &= !sfr::WDT,
            0xFFF2 => self.timers[0].accepted0(),
            _ => {}
        }
        self.update();
    }
}
