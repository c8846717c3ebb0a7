//! Effects that move nothing, the trace slot and the print ring.

use crate::consts::constants;

constants! {}

core::arch::global_asm!(include_str!("effects/effects.s"), options(raw));
core::arch::global_asm!(include_str!("effects/trace.s"), options(raw));
core::arch::global_asm!(include_str!("effects/print.s"), options(raw));
