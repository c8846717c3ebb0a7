//! Inputs, outputs and buttons at the pins.

use crate::consts::constants;
use crate::pins;

constants! {
    P1_SPI = pins::P1_REF_Y_OR_CLOCK | pins::P1_REF_Z_OR_MISO | pins::P1_PROBE_OR_MOSI;
}

core::arch::global_asm!(include_str!("io/io.s"), options(raw));
