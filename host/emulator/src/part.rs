//! The parts that the emulator knows, as data: memory map, time base, core.

use std::ops::RangeInclusive;

/// Which core and which modules a part has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// MSP430 CPU with 16-bit registers, basic clock module: MSP430x2xx.
    Msp430,
    /// MSP430X CPU, version 2, with 20-bit registers, unified clock system: MSP430x5xx.
    Msp430X,
}

/// Memory map and identity of one MSP430 part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// Name as on the package.
    pub name: &'static str,
    /// Core and modules.
    pub family: Family,
    /// Ticks in a second: a period of every clock that the part is used with is a whole number of
    /// them.
    pub ticks_per_second: u64,
    /// Main RAM.
    pub ram: RangeInclusive<u32>,
    /// RAM of the USB module, plain memory while that is off.
    pub usb_ram: Option<RangeInclusive<u32>>,
    /// Information memory, four segments D, C, B, A upwards.
    pub info: RangeInclusive<u32>,
    /// Main flash in 512-byte segments.
    pub flash: RangeInclusive<u32>,
    /// First addresses of the banks of main flash that are erased as a whole, lowest first.
    pub banks: &'static [u32],
}

/// Bytes of a main flash segment.
pub const MAIN_SEGMENT: u32 = 512;
/// First address of the interrupt vector table of the MSP430 parts.
pub const VECTORS: u16 = 0xFFE0;

impl Part {
    /// MSP430G2553 (SLAS735): 16 KB flash, 512 bytes RAM.
    pub const G2553: Part = Part {
        name: "MSP430G2553",
        family: Family::Msp430,
        ticks_per_second: crate::TICKS_PER_SECOND,
        ram: 0x0200..=0x03FF,
        usb_ram: None,
        info: 0x1000..=0x10FF,
        flash: 0xC000..=0xFFFF,
        banks: &[0xC000],
    };

    /// MSP430F5529 (SLAS590): 128 KB flash of which 80 KB are above 64 KB, 8 KB RAM, 25 MHz. A tick
    /// is 100 ps: 400 of them are a cycle of 25 MHz, 625 one of 16 MHz.
    pub const F5529: Part = Part {
        name: "MSP430F5529",
        family: Family::Msp430X,
        ticks_per_second: 10_000_000_000,
        ram: 0x2400..=0x43FF,
        usb_ram: Some(0x1C00..=0x23FF),
        info: 0x1800..=0x19FF,
        flash: 0x4400..=0x2_43FF,
        banks: &[0x4400, 0xC400, 0x1_4400, 0x1_C400],
    };

    /// First address behind the memory of the part: 64 KB, or what its flash reaches to.
    #[must_use]
    pub fn end(&self) -> usize {
        (*self.flash.end() as usize + 1).max(0x1_0000)
    }

    /// Bytes of an information memory segment: there are always four.
    #[must_use]
    pub fn info_segment(&self) -> u32 {
        (self.info.end() - self.info.start()).div_ceil(4)
    }

    /// First address and length of the flash segment that holds `addr`, `None` outside flash.
    #[must_use]
    pub fn segment(&self, addr: u32) -> Option<(u32, u32)> {
        if self.info.contains(&addr) {
            let bytes = self.info_segment();
            Some((addr & !(bytes - 1), bytes))
        } else if self.flash.contains(&addr) {
            let start = addr & !(MAIN_SEGMENT - 1);
            Some((start, MAIN_SEGMENT))
        } else {
            None
        }
    }

    /// First and last address of the bank of main flash that holds `addr`.
    #[must_use]
    pub fn bank(&self, addr: u32) -> Option<(u32, u32)> {
        if !self.flash.contains(&addr) {
            return None;
        }
        let n = self.banks.partition_point(|start| *start <= addr);
        let start = n.checked_sub(1).and_then(|i| self.banks.get(i))?;
        Some((*start, self.banks.get(n).map_or(*self.flash.end(), |next| next - 1)))
    }
}
