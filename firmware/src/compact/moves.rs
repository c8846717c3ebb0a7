//! Statements and commands that move axes.

use crate::consts::constants;
use lang::isa::{Op, flags};
use lang::record::AxisRecord;

/// Without a program a command's own parameters decide.
#[unsafe(no_mangle)]
static FREE_AXIS: AxisRecord = AxisRecord {
    flags: AxisRecord::PRESENT,
    steps: 1,
    um: 1,
    start_rate: 400,
    home_fast: 1,
    home_slow: 1,
    home_pause: 0,
    top_rate: 100_000,
    accel: 10_000_000,
    decel: 10_000_000,
    min: i32::MIN,
    max: i32::MAX,
    home_stroke: 0,
    home_position: 0,
    home_clearance: 0,
};

constants! {
    OP_SPINDLE = Op::Spindle;
    FL_AXIS = flags::AXIS;
}

core::arch::global_asm!(include_str!("moves/coords.s"), options(raw));
core::arch::global_asm!(include_str!("moves/moves.s"), options(raw));
core::arch::global_asm!(include_str!("moves/home.s"), options(raw));
core::arch::global_asm!(include_str!("moves/probe.s"), options(raw));
core::arch::global_asm!(include_str!("moves/commands.s"), options(raw));
