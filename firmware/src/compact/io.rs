//! Inputs, outputs, buttons and the lamp.

use crate::consts::constants;

constants! {}

core::arch::global_asm!(include_str!("io/io.s"), options(raw));
