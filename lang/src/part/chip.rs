//! A chip as data: what tools, build and emulator must know of it.

/// Core and modules, which a room of the firmware and one of the emulator know, with the pins of the board that such a
/// chip sits on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// MSP430 CPU with 16-bit registers, basic clock module: MSP430x2xx (SLAU144).
    Msp430,
    /// MSP430X CPU, version 2, with 20-bit registers, unified clock system: MSP430x5xx (SLAU208).
    Msp430X,
}

impl Family {
    /// Each of them.
    pub const ALL: [Family; 2] = [Family::Msp430, Family::Msp430X];

    /// Where its chips have the two bytes of their identity (SLAU144, "Device ID"; SLAU208, "Device Descriptor
    /// Table").
    pub const fn id_address(self) -> u32 {
        match self {
            Family::Msp430 => 0x0FF0,
            Family::Msp430X => 0x1A04,
        }
    }

    /// Bytes of its information memory: four segments D, C, B, A upwards.
    pub const fn info_bytes(self) -> u32 {
        match self {
            Family::Msp430 => 256,
            Family::Msp430X => 512,
        }
    }
}

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chip {
    /// As on the package.
    pub name: &'static str,
    /// Core, modules and pins.
    pub family: Family,
    /// Its bytes at [`Family::id_address`].
    pub id: [u8; 2],
    /// Names that mspdebug and TI's library have for it.
    pub aliases: &'static [&'static str],
    /// First address and bytes of its RAM.
    pub ram: [u16; 2],
    /// Bytes of it, its first, that belong to the USB module unless that is off.
    pub usb_ram: u16,
    /// First address of its information memory.
    pub info: u16,
    /// First address and bytes of its main flash, in segments of [`super::SEGMENT`] bytes.
    pub flash: [u32; 2],
    /// First addresses of the banks of main flash that are erased as a whole, lowest first.
    pub banks: &'static [u32],
}
