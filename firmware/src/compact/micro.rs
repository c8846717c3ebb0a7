//! Micro-code: the notation and its machine. It stands before everything that is written in it.

core::arch::global_asm!(include_str!("micro/notation.s"), options(raw));
core::arch::global_asm!(include_str!("micro/machine.s"), options(raw));
