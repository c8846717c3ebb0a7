//! Memory maps of the parts that the emulator knows.

use std::ops::RangeInclusive;

/// Memory map and identity of one MSP430 part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// Name as on the package.
    pub name: &'static str,
    /// Main RAM.
    pub ram: RangeInclusive<u16>,
    /// Second window onto the first bytes of `ram`, as some parts have it.
    pub ram_mirror: Option<RangeInclusive<u16>>,
    /// Information memory, four 64-byte segments D, C, B, A upwards.
    pub info: RangeInclusive<u16>,
    /// Main flash in 512-byte segments, vectors at its end.
    pub flash: RangeInclusive<u16>,
}

/// Bytes of a main flash segment.
pub const MAIN_SEGMENT: u16 = 512;
/// Bytes of an information memory segment.
pub const INFO_SEGMENT: u16 = 64;
/// First address of the interrupt vector table.
pub const VECTORS: u16 = 0xFFE0;

impl Part {
    /// MSP430G2553 (SLAS735): 16 KB flash, 512 bytes RAM.
    pub const G2553: Part = Part {
        name: "MSP430G2553",
        ram: 0x0200..=0x03FF,
        ram_mirror: None,
        info: 0x1000..=0x10FF,
        flash: 0xC000..=0xFFFF,
    };

    /// A chip that nobody makes: the G2553 with 56 KB of flash and 4 KB of RAM, of which 2 KB are
    /// mirrored at 0x0200, to run the firmware with every feature.
    pub const VIRTUAL: Part = Part {
        name: "virtual chip",
        ram: 0x1100..=0x20FF,
        ram_mirror: Some(0x0200..=0x09FF),
        info: 0x1000..=0x10FF,
        flash: 0x2100..=0xFFFF,
    };

    /// First address and length of the flash segment that holds `addr`, `None` outside flash.
    #[must_use]
    pub fn segment(&self, addr: u16) -> Option<(u16, u16)> {
        if self.info.contains(&addr) {
            Some((addr & !(INFO_SEGMENT - 1), INFO_SEGMENT))
        } else if self.flash.contains(&addr) {
            // 0x2100 is not a multiple of 512: the lowest segment of such a part is a short one.
            let start = (addr & !(MAIN_SEGMENT - 1)).max(*self.flash.start());
            let end = addr | (MAIN_SEGMENT - 1);
            Some((start, end - start + 1))
        } else {
            None
        }
    }
}
