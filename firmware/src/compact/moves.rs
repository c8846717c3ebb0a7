//! Statements and commands that move axes.

use crate::consts::constants;

constants! {}

core::arch::global_asm!(include_str!("moves/coords.s"), options(raw));
core::arch::global_asm!(include_str!("moves/moves.s"), options(raw));
core::arch::global_asm!(include_str!("moves/home.s"), options(raw));
core::arch::global_asm!(include_str!("moves/probe.s"), options(raw));
core::arch::global_asm!(include_str!("moves/commands.s"), options(raw));
