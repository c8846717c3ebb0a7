//! Micro-code: the notation and its machine. It stands before everything that is written in it.

// Numbers, notation and tables, from the instruction set in `firmware/micro/src/isa`.
core::arch::global_asm!(include_str!(concat!(env!("OUT_DIR"), "/micro.s")), options(raw));
core::arch::global_asm!(include_str!("micro/notation.s"), options(raw));
core::arch::global_asm!(include_str!("micro/machine.s"), options(raw));
