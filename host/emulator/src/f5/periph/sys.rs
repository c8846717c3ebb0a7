//! System control: special function registers, reset causes, vectors in RAM (SLAU208, chapter 1).

use crate::reset::Reset;

/// WDTIE, WDTIFG.
pub const WDT: u16 = 0x0001;
/// OFIE, OFIFG.
pub const OF: u16 = 0x0002;
/// VMAIE, VMAIFG.
pub const VMA: u16 = 0x0008;
/// NMIIE, NMIIFG.
pub const NMI: u16 = 0x0010;
/// ACCVIE.
pub const ACCV: u16 = 0x0020;

/// Registers of SFR and SYS.
#[derive(Debug, Clone)]
pub struct Sys {
    /// SFRIE1
    pub ie: u16,
    /// SFRIFG1
    pub ifg: u16,
    rpcr: u16,
    ctl: u16,
    bsl: u16,
    /// Causes of resets not read yet: bit n for the value 2 n of SYSRSTIV.
    causes: u32,
}

impl Default for Sys {
    fn default() -> Self {
        Sys { ie: 0, ifg: OF, rpcr: 0x000C, ctl: 0, bsl: 0, causes: 0 }
    }
}

/// Value of SYSRSTIV for a cause.
fn cause(reset: Reset) -> u32 {
    match reset {
        Reset::Power => 0x02,
        Reset::Pin => 0x04,
        Reset::SoftwareBrownOut => 0x06,
        Reset::Supervisor => 0x0E,
        Reset::SoftwarePowerOn => 0x14,
        Reset::Watchdog => 0x16,
        Reset::WatchdogKey => 0x18,
        Reset::FlashKey => 0x1A,
        Reset::Fetch => 0x1E,
        Reset::PowerKey => 0x20,
    }
}

impl Sys {
    /// A reset of any class.
    pub fn reset(&mut self, reset: Reset) {
        let causes = if reset == Reset::Power { 0 } else { self.causes };
        *self = Sys { causes: causes | 1 << (cause(reset) / 2), ..Sys::default() };
        if matches!(reset, Reset::Watchdog | Reset::WatchdogKey) {
            self.ifg |= WDT;
        }
    }

    /// Whether the interrupt vectors stand at the top of RAM.
    pub fn vectors_in_ram(&self) -> bool {
        self.ctl & 1 != 0
    }

    /// Reads SYSRSTIV: gives and clears the highest cause.
    pub fn take_cause(&mut self) -> u16 {
        if self.causes == 0 {
            return 0;
        }
        let n = self.causes.trailing_zeros();
        self.causes &= self.causes - 1;
        2 * n as u16
    }

    /// Reads a register by address, `None` where there is none. The vector registers are the bus's.
    pub fn read(&self, addr: u16) -> Option<u16> {
        Some(match addr {
            0x100 => self.ie,
            0x102 => self.ifg,
            0x104 => self.rpcr,
            0x180 => self.ctl,
            0x182 => self.bsl,
            0x186..=0x18E => 0,
            _ => return None,
        })
    }

    /// Writes the bytes that `mask` covers. False where there is no register.
    pub fn write(&mut self, addr: u16, value: u16, mask: u16) -> bool {
        let register = match addr {
            0x100 => &mut self.ie,
            0x102 => &mut self.ifg,
            0x104 => &mut self.rpcr,
            0x180 => &mut self.ctl,
            0x182 => &mut self.bsl,
            0x186..=0x18E => return true,
            _ => return false,
        };
        *register = *register & !mask | value & mask;
        true
    }
}
