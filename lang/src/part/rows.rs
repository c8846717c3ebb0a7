//! The chips that the firmware is built for, and the builds: a row each. What a build may take of its chip stands
//! in `firmware/budget.toml`.
//!
//! `firmware/build.sh` reads `name` and `chip` of each build here.

use super::Part;
use super::chip::{Chip, Family};
use crate::record::feature;

/// 16 KB of flash, 512 bytes of RAM (SLAS735 and SLAS800, "Memory Organization").
const MSP430G2553: Chip = Chip {
    name: "MSP430G2553",
    family: Family::Msp430,
    id: [0x25, 0x53],
    aliases: &["MSP430G2553", "MSP430G2xx3"],
    ram: [0x0200, 0x0200],
    usb_ram: 0,
    info: 0x1000,
    flash: [0xC000, 0x4000],
    banks: &[0xC000],
};

/// 128 KB of flash of which 80 KB are above 64 KB, 8 KB of RAM behind 2 KB of the USB module, which are plain RAM while
/// that is off (SLAS590, "Memory Organization").
const MSP430F5529: Chip = Chip {
    name: "MSP430F5529",
    family: Family::Msp430X,
    id: [0x55, 0x29],
    aliases: &["MSP430F5529"],
    ram: [0x1C00, 0x2800],
    usb_ram: 0x0800,
    info: 0x1800,
    flash: [0x4400, 0x2_0000],
    banks: &[0x4400, 0xC400, 0x1_4400, 0x1_C400],
};

/// 16 KB of flash, 512 bytes of RAM.
pub const G2553: Part = Part {
    name: "g2553",
    about: "16 KB of flash, 512 bytes of RAM",
    chip: &MSP430G2553,
    clock: 16_000_000,
    event_cycles: 266,
    features: feature::INTERPOLATE | feature::KEEP | feature::COURSE,
    pool: [64, 64],
    event_pool: [12, 10],
    course_pool: 28,
    // With a busy link 2.65, 3.05 and 3.6 ms, between step interrupts.
    course_us: [2_700, 3_150, 3_700],
    join_us: [700, 950, 1_300],
    call_bytes: 2,
    segments: 5,
    programs: 1,
    // Segments C and B (SLAU144, 7.2).
    profiles: [0x1080, 0x1040],
    look_ahead: false,
    at_room: 18,
    at_limits: false,
    halts: false,
    shapes_steps: false,
};

/// The same chip with handlers: ON ERROR, ON IN, ON EVERY.
pub const G2553_HANDLERS: Part = Part {
    name: "g2553-handlers",
    about: "the same chip with ON ERROR and events",
    chip: &MSP430G2553,
    features: feature::INTERPOLATE | feature::KEEP | feature::LINES | feature::EVENTS,
    course_pool: 0,
    segments: 3,
    at_room: 0,
    halts: false,
    ..G2553
};

/// 128 KB of flash, 10 KB of RAM: everything. Its pool holds 256 cells, as many as an instruction can name, with
/// depth 16 and 16 calls (firmware/README.md, Parts).
pub const F5529: Part = Part {
    name: "f5529",
    about: "the MSP430F5529, with everything",
    chip: &MSP430F5529,
    clock: 25_000_000,
    // The single handler's 181 at a segment's change, behind one of the link's of 55.
    event_cycles: 250,
    features: feature::INTERPOLATE
        | feature::START
        | feature::ARC
        | feature::EVENTS
        | feature::KEEP
        | feature::LINES
        | feature::POWER
        | feature::STREAM
        | feature::LIBRARY
        | feature::RETRY
        | feature::MATHS
        | feature::ACTIONS
        | feature::ANALOG
        | feature::AOUT,
    pool: [1152, 1152],
    event_pool: [0, 0],
    course_pool: 0,
    course_us: [0; 3],
    join_us: [0; 3],
    call_bytes: 4,
    // 39 KB: what assembly, tables and vectors leave of the flash below 64 KB.
    segments: 78,
    programs: 64,
    // Segments C and B (SLAS590, "Memory Organization").
    profiles: [0x1880, 0x1900],
    look_ahead: true,
    at_room: u16::MAX,
    at_limits: true,
    halts: true,
    shapes_steps: true,
};

/// Every part, the smallest first.
pub const PARTS: &[Part] = &[G2553, G2553_HANDLERS, F5529];
