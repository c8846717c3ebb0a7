//! Runs: Start, Stop, pauses, milliseconds, and the VM between its effects.

use crate::consts::constants;

constants! {}

core::arch::global_asm!(include_str!("session/session.s"), options(raw));
core::arch::global_asm!(include_str!("session/ticks.s"), options(raw));
core::arch::global_asm!(include_str!("session/run.s"), options(raw));
core::arch::global_asm!(include_str!("session/soft.s"), options(raw));
