//! Peripheral registers by address (SLAS735, "Peripheral file map").

use super::{Bus, VACANT};
use crate::periph::usci::Register;
use crate::reset::Reset;
use crate::warn::Kind;

/// First registers of the USCI modules.
const UCA0CTL0: i16 = 0x60;
const UCB0CTL0: i16 = 0x68;

/// Byte registers of a port.
#[derive(Clone, Copy)]
enum PortRegister {
    In,
    Out,
    Dir,
    Ifg,
    Ies,
    Ie,
    Sel,
    Ren,
    Sel2,
}

fn port_register(addr: u16) -> Option<(usize, PortRegister)> {
    use PortRegister::{Dir, Ie, Ies, Ifg, In, Out, Ren, Sel, Sel2};
    const FULL: [PortRegister; 8] = [In, Out, Dir, Ifg, Ies, Ie, Sel, Ren];
    const PLAIN: [PortRegister; 4] = [In, Out, Dir, Sel];
    Some(match addr {
        0x10 | 0x11 => (usize::from(addr - 0x10) + 2, Ren),
        0x18..=0x1F => (usize::from(addr - 0x18) / 4 + 2, PLAIN[usize::from(addr - 0x18) % 4]),
        0x20..=0x2F => (usize::from(addr - 0x20) / 8, FULL[usize::from(addr - 0x20) % 8]),
        0x41..=0x44 => (usize::from(addr - 0x41), Sel2),
        _ => return None,
    })
}

impl Bus {
    #[cold]
    fn unmapped(&mut self, addr: u16) {
        self.warn(Kind::Unmapped, addr);
    }

    /// Brings the peripherals up to date before a register is touched.
    #[inline]
    fn catch_up(&mut self) {
        if self.next_event <= self.now {
            self.service();
        }
    }

    pub(super) fn slow_read8(&mut self, addr: u16) -> u8 {
        self.catch_up();
        match addr {
            0..0x100 => self.read_byte_register(addr).unwrap_or_else(|| {
                self.unmapped(addr);
                0
            }),
            0x100..0x200 => {
                let word = self.read_word_register(addr & !1).unwrap_or_else(|| {
                    self.unmapped(addr);
                    0
                });
                (word >> (8 * (addr & 1))) as u8
            }
            _ => {
                self.unmapped(addr);
                (VACANT >> (8 * (addr & 1))) as u8
            }
        }
    }

    pub(super) fn slow_read16(&mut self, addr: u16) -> u16 {
        self.catch_up();
        match addr {
            0..0x100 => {
                self.warn(Kind::RegisterWidth, addr);
                u16::from(self.slow_read8(addr))
            }
            0x100..0x200 => self.read_word_register(addr).unwrap_or_else(|| {
                self.unmapped(addr);
                0
            }),
            _ => {
                self.unmapped(addr);
                VACANT
            }
        }
    }

    pub(super) fn slow_write8(&mut self, addr: u16, value: u8) {
        if self.is_flash(addr) {
            let word = u16::from(value) << (8 * (addr & 1));
            return self.write_flash(addr, word, 0xFF << (8 * (addr & 1)));
        }
        self.catch_up();
        match addr {
            0..0x100 => self.write_byte_register(addr, value),
            0x100..0x200 if addr & 1 == 0 => {
                // Byte writes to word modules clear the high byte (SLAU144, section 1.4.3).
                self.warn(Kind::RegisterWidth, addr);
                self.write_word_register(addr, u16::from(value));
            }
            0x100..0x200 => self.warn(Kind::RegisterWidth, addr),
            _ => self.unmapped(addr),
        }
    }

    pub(super) fn slow_write16(&mut self, addr: u16, value: u16) {
        if self.is_flash(addr) {
            return self.write_flash(addr, value, 0xFFFF);
        }
        self.catch_up();
        match addr {
            0..0x100 => {
                self.warn(Kind::RegisterWidth, addr);
                self.write_byte_register(addr, value as u8);
            }
            0x100..0x200 => self.write_word_register(addr, value),
            _ => self.unmapped(addr),
        }
    }

    fn read_byte_register(&mut self, addr: u16) -> Option<u8> {
        let value = match addr {
            0x00 | 0x01 => self.ie[usize::from(addr)],
            0x02 | 0x03 => self.ifg[usize::from(addr - 2)],
            0x48..=0x4A => self.adc.bytes[usize::from(addr - 0x48)],
            0x53 | 0x56..=0x58 => self.clock.read(addr),
            0x59..=0x5B => self.comparator[usize::from(addr - 0x59)],
            0x5D..=0x67 => {
                let register = Register::of_2xx(addr.cast_signed() - UCA0CTL0);
                let value = self.uart.read(register, &mut self.ifg[1]);
                if addr == 0x66 {
                    self.update();
                }
                value
            }
            0x68..=0x6F => {
                let register = Register::of_2xx(addr.cast_signed() - UCB0CTL0);
                let value = self.with_spi_flags(|spi, ifg, _| spi.read(register, ifg));
                if addr == 0x6E {
                    self.update();
                }
                value
            }
            _ => {
                let (n, register) = port_register(addr)?;
                if matches!(register, PortRegister::In) && n < 2 {
                    return Some(self.read_input(n));
                }
                let port = &self.ports[n];
                match register {
                    PortRegister::In => port.level,
                    PortRegister::Out => port.out,
                    PortRegister::Dir => port.dir,
                    PortRegister::Ifg => port.ifg,
                    PortRegister::Ies => port.ies,
                    PortRegister::Ie => port.ie,
                    PortRegister::Sel => port.sel,
                    PortRegister::Ren => port.ren,
                    PortRegister::Sel2 => port.sel2,
                }
            }
        };
        Some(value)
    }

    fn write_byte_register(&mut self, addr: u16, value: u8) {
        let now = self.now;
        match addr {
            0x00 | 0x01 => self.ie[usize::from(addr)] = value,
            0x02 | 0x03 => self.ifg[usize::from(addr - 2)] = value,
            0x48..=0x4A => self.adc.bytes[usize::from(addr - 0x48)] = value,
            0x53 | 0x56..=0x58 => {
                self.clock.write(addr, value);
                self.reclock();
                self.check_supply();
                if self.clock.rounded {
                    self.warn(Kind::Clock, addr);
                }
            }
            0x59..=0x5B => self.comparator[usize::from(addr - 0x59)] = value,
            0x5D..=0x67 => {
                let register = Register::of_2xx(addr.cast_signed() - UCA0CTL0);
                self.uart.write(register, value, now, &mut self.ifg[1], &self.clock.rates);
                if addr == 0x61 && value & 1 == 0 && self.uart_floats() {
                    self.warn(Kind::FloatingInput, 0x20);
                }
                self.update_pins(now);
            }
            0x68..=0x6F => {
                let register = Register::of_2xx(addr.cast_signed() - UCB0CTL0);
                self.with_spi_flags(|spi, ifg, rates| spi.write(register, value, now, ifg, rates));
                self.update_pins(now);
            }
            _ => {
                let Some((n, register)) = port_register(addr) else {
                    self.unmapped(addr);
                    return;
                };
                let port = &mut self.ports[n];
                match register {
                    PortRegister::In => {}
                    PortRegister::Out => port.out = value,
                    PortRegister::Dir => port.dir = value,
                    PortRegister::Ifg => port.ifg = value,
                    PortRegister::Ies => port.write_ies(value),
                    PortRegister::Ie => port.ie = value,
                    PortRegister::Sel => port.sel = value,
                    PortRegister::Ren => port.ren = value,
                    PortRegister::Sel2 => port.sel2 = value,
                }
                if n < 2 {
                    self.update_pins(now);
                }
            }
        }
        self.update();
    }

    fn read_word_register(&mut self, addr: u16) -> Option<u16> {
        let now = self.now;
        let value = match addr {
            0x118 | 0x11A => self.i2c[usize::from(addr - 0x118) / 2],
            0x11E | 0x12E => {
                let vector = self.timers[usize::from(addr == 0x11E)].take_vector();
                self.update();
                vector
            }
            0x120 => self.wdt.read(),
            0x128 | 0x12A | 0x12C => self.flash.read(addr, now),
            0x160..=0x166 | 0x170..=0x176 => self.timers[0].read(addr - 0x160, now),
            0x180..=0x186 | 0x190..=0x196 => self.timers[1].read(addr - 0x180, now),
            0x1B0..=0x1B4 | 0x1BC => {
                let value = self.adc.read(addr);
                self.update();
                value
            }
            _ => return None,
        };
        Some(value)
    }

    fn write_word_register(&mut self, addr: u16, value: u16) {
        let now = self.now;
        match addr {
            0x118 | 0x11A => self.i2c[usize::from(addr - 0x118) / 2] = value,
            0x11E | 0x12E => {
                self.timers[usize::from(addr == 0x11E)].take_vector();
            }
            0x120 => {
                if !self.wdt.write(value, now, &self.clock.rates) {
                    self.warn(Kind::Key, addr);
                    self.ask_reset(Reset::WatchdogKey);
                }
            }
            0x128 | 0x12A | 0x12C => {
                if !self.flash.write(addr, value, now) {
                    self.warn(Kind::Key, addr);
                    self.ask_reset(Reset::FlashKey);
                }
            }
            0x160..=0x166 | 0x170..=0x176 => self.write_timer(0, addr - 0x160, value),
            0x180..=0x186 | 0x190..=0x196 => self.write_timer(1, addr - 0x180, value),
            0x1B0..=0x1B4 | 0x1BC => self.adc.write(addr, value, now, &self.clock.rates),
            _ => self.unmapped(addr),
        }
        self.update();
    }

    fn write_timer(&mut self, n: usize, offset: u16, value: u16) {
        if self.timers[n].write(offset, value, self.now, &self.clock.rates) {
            self.update_pins(self.now);
        }
        if matches!(offset, 2 | 4 | 6) {
            self.reselect_captures();
        }
    }
}
