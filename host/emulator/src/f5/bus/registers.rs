//! Peripheral registers by address (SLAS590, "Peripheral File Map"). An access names the word at an
//! even address; a byte access covers half of it.

use super::{Bus, usci_vector};
use crate::f5::periph::mpy32::{self, Mpy32};
use crate::f5::periph::pmm::{LEVELS, Outcome};
use crate::periph::timer;
use crate::reset::Reset;
use crate::warn::Kind;

/// First addresses of the timers: TA0, TA1, TA2, TB0.
const TIMERS: [u16; 4] = [0x0340, 0x0380, 0x0400, 0x03C0];
/// Offset of a timer's interrupt vector register.
const TIMER_IV: u16 = 0x2E;
const MPY: std::ops::Range<u16> = 0x04C0..0x04EE;
const UCS: std::ops::Range<u16> = 0x0160..0x0172;
const PMM: std::ops::Range<u16> = 0x0120..0x0132;
const FCTL: std::ops::Range<u16> = 0x0140..0x0148;
const ADC: std::ops::Range<u16> = 0x0700..0x0740;
const WDTCTL: u16 = 0x015C;
/// Key of a write to WDTCTL.
const WDT_KEY: u16 = 0x5A00;
const RCCTL0: u16 = 0x0158;
/// Modules that the firmware leaves alone: writes of their off state are accepted, nothing else is
/// modelled. REF, RTC, DMA, COMP_B, USB.
const ABSENT: [std::ops::Range<u16>; 5] =
    [0x01B0..0x01B2, 0x04A0..0x04BC, 0x0500..0x0530, 0x08C0..0x08D0, 0x0900..0x0980];

/// The timer and the offset of a register in it.
fn timer_at(addr: u16) -> Option<(usize, u16)> {
    let n = TIMERS.iter().position(|base| (*base..base + 0x30).contains(&addr))?;
    Some((n, addr - TIMERS[n]))
}

impl Bus {
    /// Reads the word at the even address below `addr`.
    pub(super) fn read_register(&mut self, addr: u16, byte: bool) -> Option<u16> {
        let now = self.now;
        let even = addr & !1;
        if let Some((n, offset)) = timer_at(even) {
            if byte {
                self.warn(Kind::RegisterWidth, addr.into());
            }
            if offset == TIMER_IV {
                let vector = self.timers[n].take_vector();
                self.update();
                return Some(vector);
            }
            return Some(self.timers[n].read(offset, now));
        }
        match even {
            0x019A..=0x019E => return Some(self.read_system_vector(even)),
            WDTCTL => return Some(self.wdt.read()),
            RCCTL0 => return Some(0x6900 | self.ram_control),
            0x0150..=0x0156 => return Some(self.crc.read(even - 0x0150)),
            0x01C0 | 0x01C2 => return Some(self.pmap.read(even)),
            0x01E0..=0x01E6 => {
                let n = usize::from(even - 0x01E0);
                return Some(u16::from_le_bytes([self.pmap.map(n), self.pmap.map(n + 1)]));
            }
            _ => {}
        }
        if PMM.contains(&even) {
            return self.pmm.read(even - PMM.start);
        }
        if FCTL.contains(&even) {
            return self.flash.read(even - FCTL.start, now);
        }
        if ADC.contains(&even) {
            return Some(self.adc.read(even - ADC.start));
        }
        if UCS.contains(&even) {
            return Some(self.ucs.read(even - UCS.start));
        }
        if MPY.contains(&even) {
            return self.read_multiplier(even, byte);
        }
        if (0x0100..0x0106).contains(&even) || (0x0180..0x0190).contains(&even) {
            return self.sys.read(even);
        }
        if let Some(value) = self.read_port(even) {
            return Some(value);
        }
        if let Some(value) = self.read_usci(even, addr, byte) {
            return Some(value);
        }
        ABSENT.iter().any(|range| range.contains(&even)).then_some(0)
    }

    /// Writes the bytes that `mask` covers of the word at the even address below `addr`.
    pub(super) fn write_register(&mut self, addr: u16, value: u16, mask: u16) {
        let even = addr & !1;
        let now = self.now;
        let known = if let Some((n, offset)) = timer_at(even) {
            self.write_timer(n, offset, value, mask, addr);
            true
        } else if PMM.contains(&even) {
            let outcome = self.pmm.write(even - PMM.start, value, mask, now, self.vcc);
            self.pmm_outcome(outcome, addr);
            true
        } else if FCTL.contains(&even) {
            self.write_flash_control(even - FCTL.start, value, mask, addr);
            true
        } else if UCS.contains(&even) {
            let old = self.ucs.read(even - UCS.start);
            self.ucs.write(even - UCS.start, old & !mask | value & mask, now);
            self.reclock();
            true
        } else if ADC.contains(&even) {
            let second = self.part.ticks_per_second;
            if !self.adc.write(even - ADC.start, value, mask, now, second) {
                self.warn(Kind::Unsupported, addr.into());
            }
            true
        } else if MPY.contains(&even) {
            self.write_multiplier(even, value, mask)
        } else {
            self.write_other(even, value, mask, addr)
        };
        if !known {
            self.warn(Kind::Unmapped, addr.into());
        }
        self.update();
    }

    fn write_other(&mut self, even: u16, value: u16, mask: u16, addr: u16) -> bool {
        match even {
            WDTCTL => {
                let whole = mask == 0xFFFF && value & 0xFF00 == WDT_KEY;
                if !whole || !self.wdt.write(value, self.now, &self.ucs.rates) {
                    self.warn(Kind::Key, addr.into());
                    self.ask_reset(Reset::WatchdogKey);
                }
                true
            }
            RCCTL0 => {
                // Sectors that are off lose their content: nobody needs that here.
                self.ram_control = value & 0x8F;
                if self.ram_control != 0 {
                    self.warn(Kind::Unsupported, addr.into());
                }
                true
            }
            0x0150..=0x0156 => {
                self.crc.write(even - 0x0150, value, mask);
                true
            }
            0x01C0 | 0x01C2 => {
                self.pmap.write(even, value);
                true
            }
            0x01E0..=0x01E6 => {
                self.write_map(usize::from(even - 0x01E0), value, mask);
                true
            }
            0x019A..=0x019E => {
                self.read_system_vector(even);
                true
            }
            _ => {
                self.sys.write(even, value, mask)
                    || self.write_port(even, value, mask)
                    || self.write_usci(even, value, mask)
                    || self.write_absent(even, value & mask, addr)
            }
        }
    }

    fn write_absent(&mut self, even: u16, value: u16, addr: u16) -> bool {
        let known = ABSENT.iter().any(|range| range.contains(&even));
        // USBKEYID and everything that is 0 is written by start-up code that errata ask for.
        if known && value != 0 && even != 0x0900 {
            self.warn(Kind::Unsupported, addr.into());
        }
        known
    }

    fn pmm_outcome(&mut self, outcome: Outcome, addr: u16) {
        match outcome {
            Outcome::Done => {}
            Outcome::Closed => self.warn(Kind::Closed, addr.into()),
            Outcome::LevelSkipped => self.warn(Kind::CoreLevel, addr.into()),
            Outcome::Reset(reset) => {
                if reset == Reset::PowerKey {
                    self.warn(Kind::Key, addr.into());
                }
                self.ask_reset(reset);
            }
        }
        self.check_speed();
    }

    /// MCLK against the core level and the supply. The data sheet's limits have a percent of room
    /// for what the modulator does.
    pub(super) fn check_speed(&mut self) {
        let hz = self.part.ticks_per_second / self.cycle.max(1);
        let (most, least_mv) = LEVELS[usize::from(self.pmm.level())];
        if hz > most + most / 100 || self.vcc < least_mv {
            self.warn(Kind::Clock, self.pc);
        }
    }

    fn write_flash_control(&mut self, offset: u16, value: u16, mask: u16, addr: u16) {
        let tail = self.ticks(self.flash.block_tail_us().into());
        // A byte write leaves the key out.
        let value = if mask == 0xFFFF { value } else { value & 0x00FF };
        if !self.flash.write(offset, value, self.now, tail) {
            self.warn(Kind::Key, addr.into());
            self.ask_reset(Reset::FlashKey);
        }
    }

    fn write_timer(&mut self, n: usize, offset: u16, value: u16, mask: u16, addr: u16) {
        if mask != 0xFFFF {
            self.warn(Kind::RegisterWidth, addr.into());
        }
        if offset == TIMER_IV {
            self.timers[n].take_vector();
            return;
        }
        if self.timers[n].write(offset, value, self.now, &self.ucs.rates) {
            self.update_pins(self.now);
        }
        if self.timers[n].unsupported() {
            self.warn(Kind::Unsupported, addr.into());
        }
        if (timer::CCTL..timer::COUNT).contains(&offset) {
            self.capture_inputs(self.now);
        }
    }

    fn read_multiplier(&mut self, even: u16, byte: bool) -> Option<u16> {
        if byte {
            self.warn(Kind::RegisterWidth, even.into());
        }
        let (value, early) = self.mpy.read(even - MPY.start, self.now, self.cycle)?;
        if early {
            self.warn(Kind::MultiplierEarly, even.into());
        }
        Some(value)
    }

    fn write_multiplier(&mut self, even: u16, value: u16, mask: u16) -> bool {
        let offset = even - MPY.start;
        if mask != 0xFFFF {
            self.warn(Kind::RegisterWidth, even.into());
        }
        if Mpy32::is_operand(offset) {
            let interruptible = self.status & crate::cpu::flags::GIE != 0;
            self.multiplied[0] |= interruptible && !self.in_handler;
            self.multiplied[1] |= self.in_handler;
            if self.multiplied == [true; 2] {
                self.warn(Kind::MultiplierShared, even.into());
            }
        }
        match self.mpy.write(offset, value & mask, self.now) {
            Some(mpy32::Outcome::Unsupported) => {
                self.warn(Kind::Unsupported, even.into());
                true
            }
            outcome => outcome.is_some(),
        }
    }

    /// SYSUNIV, SYSSNIV, SYSRSTIV: gives and clears the highest pending source.
    fn read_system_vector(&mut self, even: u16) -> u16 {
        use crate::f5::periph::sys::{ACCV, NMI, OF, VMA};
        let (ie, ifg) = (self.sys.ie, self.sys.ifg);
        let vector = match even {
            0x019E => self.sys.take_cause(),
            0x019A => {
                if ie & ifg & NMI != 0 {
                    self.sys.ifg &= !NMI;
                    2
                } else if ie & ifg & OF != 0 {
                    self.sys.ifg &= !OF;
                    4
                } else if ie & ACCV != 0 && self.flash.violation() {
                    6
                } else {
                    0
                }
            }
            _ => match self.pmm.system_interrupt() {
                Some(number) => number,
                None if ie & ifg & VMA != 0 => {
                    self.sys.ifg &= !VMA;
                    0x0A
                }
                None => 0,
            },
        };
        self.update();
        vector
    }

    /// The byte registers of USCI modules are side by side: flags, enables and vector here, the rest
    /// in the modules.
    fn read_usci(&mut self, even: u16, addr: u16, byte: bool) -> Option<u16> {
        let (module, offset) = usci_at(even)?;
        let (ie, ifg) = match module {
            Module::A(n) => (self.usci_a[n].ie, self.usci_a[n].ifg),
            Module::B(n) => (self.usci_b[n].ie, self.usci_b[n].ifg),
        };
        let value = match offset {
            0x1C => u16::from_le_bytes([ie, ifg]),
            0x1E => {
                let vector = usci_vector(ie, ifg);
                let clear = !((vector / 2) as u8);
                match module {
                    Module::A(n) => self.usci_a[n].ifg &= clear,
                    Module::B(n) => self.usci_b[n].ifg &= clear,
                }
                vector
            }
            _ => {
                let wanted = |at: u16| !byte || at == addr & 1;
                let low = wanted(0).then(|| self.usci_byte(module, offset)).flatten();
                let high = wanted(1).then(|| self.usci_byte(module, offset + 1)).flatten();
                low.or(high)?;
                u16::from_le_bytes([low.unwrap_or(0), high.unwrap_or(0)])
            }
        };
        self.update();
        Some(value)
    }

    fn write_map(&mut self, n: usize, value: u16, mask: u16) {
        let [low, high] = value.to_le_bytes();
        let open = (mask & 0x00FF == 0 || self.pmap.set(n, low))
            && (mask & 0xFF00 == 0 || self.pmap.set(n + 1, high));
        if !open {
            self.warn(Kind::Closed, 0x01E0 + n as u32);
        }
        self.update_pins(self.now);
    }
}

/// A USCI module.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Module {
    /// UART.
    A(usize),
    /// SPI.
    B(usize),
}

/// The module at an address and the offset in it.
pub(super) fn usci_at(addr: u16) -> Option<(Module, u16)> {
    const BASES: [(u16, Module); 4] = [
        (0x05C0, Module::A(0)),
        (0x05E0, Module::B(0)),
        (0x0600, Module::A(1)),
        (0x0620, Module::B(1)),
    ];
    let (base, module) = BASES.iter().find(|(base, _)| (*base..base + 0x20).contains(&addr))?;
    Some((*module, addr - base))
}
