//! The step engine and its planner.

use crate::consts::constants;

constants! {}

core::arch::global_asm!(include_str!("motion/formula.s"), options(raw));
core::arch::global_asm!(include_str!("motion/step.s"), options(raw));
core::arch::global_asm!(include_str!("motion/ramp.s"), options(raw));
core::arch::global_asm!(include_str!("motion/line.s"), options(raw));
