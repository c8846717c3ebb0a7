//! The MSP430F5529, as it sits on its LaunchPad.
//!
//! Compiled functions lie above 64 KB, but for those that near.txt names (see `firmware/far`).

pub mod adc;
pub mod aout;
pub mod capture;
pub mod clock;
pub mod flash;
mod gates;
pub mod line;
pub mod ports;
pub mod pwm;
mod reg;
pub mod rs485;
pub mod timer;
mod vectors;

/// What it runs.
pub const PART: lang::part::Part =
    lang::part::Part::named(env!("PASAPAS_PART")).expect("build.rs knows it");

/// Start of the program area.
pub const AREA: u16 = 0xFE00 - (lang::part::SEGMENT * PART.segments as usize) as u16;
/// Segment D of the information memory: the last faults. Segment A is free.
pub const LOG: u16 = 0x1800;
/// Segments of the information memory that the firmware writes.
pub const INFORMATION: core::ops::Range<u16> = 0x1800..0x1980;

/// The section of handlers that run while flash is busy: RAM.
macro_rules! handlers {
    ($name:literal) => {
        concat!(".section .data.", $name, ",\"awx\",@progbits")
    };
}
pub(crate) use handlers;
