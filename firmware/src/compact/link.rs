//! The Modbus slave: serial line, frames, registers.

use crate::consts::constants;

constants! {}

core::arch::global_asm!(include_str!("link/uart.s"), options(raw));
core::arch::global_asm!(include_str!("link/modbus.s"), options(raw));
core::arch::global_asm!(include_str!("link/map.s"), options(raw));
