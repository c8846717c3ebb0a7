//! Registers of ports and USCI modules.

use super::Bus;
use super::registers::{Module, usci_at};
use crate::periph::port::Port;
use crate::periph::usci::{RX, Register, TX};
use crate::warn::Kind;

/// UCSYNC in UCxCTL0.
const SYNC: u8 = 0x01;
/// UCMODE and UCMST in UCxCTL0.
const MODE: u8 = 0x06;
const MASTER: u8 = 0x08;

/// Registers of a port by their offset from PxIN.
#[derive(Clone, Copy, PartialEq, Eq)]
enum PortRegister {
    In,
    Out,
    Dir,
    Ren,
    Drive,
    Sel,
    Ies,
    Ie,
    Ifg,
}

impl PortRegister {
    fn of(offset: u16, interrupts: bool) -> Option<PortRegister> {
        Some(match offset {
            0x00 => PortRegister::In,
            0x02 => PortRegister::Out,
            0x04 => PortRegister::Dir,
            0x06 => PortRegister::Ren,
            0x08 => PortRegister::Drive,
            0x0A => PortRegister::Sel,
            0x18 if interrupts => PortRegister::Ies,
            0x1A if interrupts => PortRegister::Ie,
            0x1C if interrupts => PortRegister::Ifg,
            _ => return None,
        })
    }
}

/// The pair of ports at an address, its lower port's place in the array and the offset.
fn port_at(addr: u16) -> Option<(usize, u16)> {
    (0x0200..0x0280).contains(&addr).then(|| (usize::from((addr - 0x0200) >> 5) * 2, addr & 0x1F))
}

/// PJ has no partner.
const PJ: std::ops::Range<u16> = 0x0320..0x0330;

fn get(port: &Port, register: PortRegister) -> u8 {
    match register {
        PortRegister::In => port.level,
        PortRegister::Out => port.out,
        PortRegister::Dir => port.dir,
        PortRegister::Ren => port.ren,
        PortRegister::Drive => port.drive,
        PortRegister::Sel => port.sel,
        PortRegister::Ies => port.ies,
        PortRegister::Ie => port.ie,
        PortRegister::Ifg => port.ifg,
    }
}

fn put(port: &mut Port, register: PortRegister, value: u8) {
    match register {
        PortRegister::In => {}
        PortRegister::Out => port.out = value,
        PortRegister::Dir => port.dir = value,
        PortRegister::Ren => port.ren = value,
        PortRegister::Drive => port.drive = value,
        PortRegister::Sel => port.sel = value,
        PortRegister::Ies => port.write_ies(value),
        PortRegister::Ie => port.ie = value,
        PortRegister::Ifg => port.ifg = value,
    }
}

impl Bus {
    /// P1IV, P2IV: gives and clears the lowest pin's pending flag.
    fn take_port_vector(&mut self, n: usize) -> u16 {
        let port = &mut self.ports[n];
        let pending = port.ifg & port.ie;
        if pending == 0 {
            return 0;
        }
        let bit = pending.trailing_zeros();
        port.ifg &= !(1 << bit);
        self.update();
        2 * (bit as u16 + 1)
    }

    pub(super) fn read_port(&mut self, even: u16) -> Option<u16> {
        if PJ.contains(&even) {
            let register = PortRegister::of(even - PJ.start, false)?;
            return Some(get(&self.pj, register).into());
        }
        let (n, offset) = port_at(even)?;
        match (n, offset) {
            (0, 0x0E) => return Some(self.take_port_vector(0)),
            (0, 0x1E) => return Some(self.take_port_vector(1)),
            _ => {}
        }
        let register = PortRegister::of(offset, n == 0)?;
        if register == PortRegister::In {
            for port in n..n + 2 {
                if self.ports[port].floating & !self.ports[port].sel != 0 {
                    self.warn(Kind::FloatingInput, u32::from(even) + (port - n) as u32);
                }
            }
        }
        let [low, high] = [&self.ports[n], &self.ports[n + 1]].map(|port| get(port, register));
        Some(u16::from_le_bytes([low, high]))
    }

    pub(super) fn write_port(&mut self, even: u16, value: u16, mask: u16) -> bool {
        let [low, high] = value.to_le_bytes();
        if PJ.contains(&even) {
            let register = PortRegister::of(even - PJ.start, false);
            if let Some(register) = register {
                put(&mut self.pj, register, low);
            }
            return register.is_some();
        }
        let Some((n, offset)) = port_at(even) else { return false };
        if n == 0 && matches!(offset, 0x0E | 0x1E) {
            self.take_port_vector(usize::from(offset == 0x1E));
            return true;
        }
        let Some(register) = PortRegister::of(offset, n == 0) else { return false };
        if mask & 0x00FF != 0 {
            put(&mut self.ports[n], register, low);
        }
        if mask & 0xFF00 != 0 {
            put(&mut self.ports[n + 1], register, high);
        }
        if matches!(register, PortRegister::Sel | PortRegister::Dir) {
            self.check_functions();
            let crystals = self.ports[4].sel;
            let now = self.now;
            // P5.4 and P5.5 are XT1's pins, P5.2 and P5.3 XT2's; selecting one is enough for each.
            self.ucs.select_pins(crystals & 0x30 != 0, crystals & 0x0C != 0, now);
            self.reclock();
        }
        self.update_pins(self.now);
        if register == PortRegister::Sel || register == PortRegister::Dir {
            // A pin that comes to a timer, or leaves it, changes what that timer sees at once.
            self.capture_inputs(self.now);
        }
        true
    }

    /// A byte register of a module.
    pub(super) fn usci_byte(&mut self, module: Module, offset: u16) -> Option<u8> {
        let register = Register::of_5xx(offset)?;
        Some(match module {
            Module::A(n) => {
                let module = &mut self.usci_a[n];
                module.uart.read(register, &mut module.ifg)
            }
            Module::B(n) => {
                let module = &mut self.usci_b[n];
                module.spi.read(register, &mut module.ifg)
            }
        })
    }

    pub(super) fn write_usci(&mut self, even: u16, value: u16, mask: u16) -> bool {
        let Some((module, offset)) = usci_at(even) else { return false };
        let bytes = value.to_le_bytes();
        if offset == 0x1C {
            let flags = RX | TX;
            let (ie, ifg) = match module {
                Module::A(n) => (&mut self.usci_a[n].ie, &mut self.usci_a[n].ifg),
                Module::B(n) => (&mut self.usci_b[n].ie, &mut self.usci_b[n].ifg),
            };
            if mask & 0x00FF != 0 {
                *ie = bytes[0] & flags;
            }
            if mask & 0xFF00 != 0 {
                *ifg = bytes[1] & flags;
            }
            return true;
        }
        if offset == 0x1E {
            return true;
        }
        let mut known = false;
        for (byte, at) in bytes.into_iter().zip([offset, offset + 1]) {
            if mask >> (8 * (at & 1)) & 0xFF == 0 {
                continue;
            }
            let Some(register) = Register::of_5xx(at) else { continue };
            known = true;
            if register == Register::Ctl0 {
                self.check_mode(module, byte, even);
            }
            let now = self.now;
            let rates = &self.ucs.rates;
            match module {
                Module::A(n) => {
                    let module = &mut self.usci_a[n];
                    module.uart.write(register, byte, now, &mut module.ifg, rates);
                }
                Module::B(n) => {
                    let module = &mut self.usci_b[n];
                    module.spi.write(register, byte, now, &mut module.ifg, rates);
                }
            }
        }
        self.update_pins(self.now);
        known
    }

    /// USCI_A is a UART here and USCI_B an SPI master with three wires.
    fn check_mode(&mut self, module: Module, ctl0: u8, addr: u16) {
        let fits = match module {
            Module::A(_) => ctl0 & (SYNC | MODE) == 0,
            // The value after a reset is no mode that anybody asked for.
            Module::B(_) => ctl0 & (SYNC | MODE | MASTER) == SYNC | MASTER || ctl0 == SYNC,
        };
        if !fits {
            self.warn(Kind::Unsupported, addr.into());
        }
    }
}
