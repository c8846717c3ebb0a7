//! The part of the firmware that needs no hardware. Host tests run all of it.
#![cfg_attr(not(any(test, feature = "physics")), no_std)]
#![deny(unsafe_code)]

pub mod analog;
pub mod inputs;
pub mod keep;
pub mod machine;
pub mod modbus;
pub mod motion;
pub mod print;
pub mod rules;
pub mod session;
pub mod store;
pub mod verify;

use lang::part::chip::Chip;
use lang::part::{G2553, Part};
use lang::record::feature;

/// Version of the firmware, major in the high byte (`lang::wire::FIRMWARE_VERSION`).
pub const RELEASE: u16 = 0x0001;

/// The G2553's assembly with all that it can do, on a chip that exists in tests alone: 32 KB of
/// flash, the G2553's RAM. What does not fit into 16 KB is tested there.
pub const WHOLE: Part = Part {
    name: "whole",
    chip: &Chip { name: "MSP430G2553 with 32 KB", flash: [0x8000, 0x8000], ..*G2553.chip },
    features: G2553.features | feature::LINES | feature::EVENTS | feature::COURSE,
    course_pool: 28,
    halts: true,
    segments: 6,
    at_room: 0,
    ..G2553
};
