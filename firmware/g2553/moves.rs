//! Statements and commands that move axes.

use core::mem::offset_of;

use crate::consts::constants;
use lang::isa::{Op, SHORT_AXES, flags};
use lang::record::AxisRecord;

/// What stands for an [`AxisRecord`] without a program, where a command's own parameters decide:
/// its fields but the last ones, which belong to reference runs by the profile.
#[repr(C)]
struct FreeAxis {
    flags: u16,
    steps: u16,
    um: u16,
    start_rate: u16,
    home: [u16; 3],
    top_rate: [u16; 2],
    accel: [u16; 2],
    decel: [u16; 2],
    min: [u16; 2],
    max: [u16; 2],
}

const _: () = assert!(core::mem::size_of::<FreeAxis>() == offset_of!(AxisRecord, home_stroke));

const fn words(n: u32) -> [u16; 2] {
    [n as u16, (n >> 16) as u16]
}

#[unsafe(no_mangle)]
static FREE_AXIS: FreeAxis = FreeAxis {
    flags: AxisRecord::FREE.flags,
    steps: AxisRecord::FREE.steps,
    um: AxisRecord::FREE.um,
    start_rate: AxisRecord::FREE.start_rate,
    home: [AxisRecord::FREE.home_fast, AxisRecord::FREE.home_slow, AxisRecord::FREE.home_pause],
    top_rate: words(AxisRecord::FREE.top_rate),
    accel: words(AxisRecord::FREE.accel),
    decel: words(AxisRecord::FREE.decel),
    // The travel of an axis is below 2^31 um here.
    min: words(-(1i32 << 30) as u32),
    max: words(1 << 30),
};

constants! {
    FL_AXIS = flags::AXIS;
    FL_STEPS = flags::STEPS;
    FL_RELATIVE = flags::RELATIVE;
    FL_ACCEL = flags::ACCEL;
    FL_ACCEL_STEPS = flags::ACCEL_STEPS;
    FL_DECEL = flags::DECEL;
    FL_DECEL_STEPS = flags::DECEL_STEPS;
    FL_RAPID = flags::RAPID;
    FL_SPEED = flags::SPEED;
    FL_SPEED_STEPS = flags::SPEED_STEPS;
    FL_QUERY = flags::QUERY;
    FL_SENSOR = flags::SENSOR;
    FL_MASK = flags::MASK;
    // FRAME_OF: in steps, else um; of the machine, relative, else of the work.
    F_STEPS = flags::STEPS;
    F_MACHINE = flags::STEPS << 1;
    F_RELATIVE = flags::STEPS << 2;
    // BITS of a reference run: input number of the switch, that it is off when closed, and that HOME_RECORD holds the
    // rest, which command 106 has brought.
    HOME_INVERT = 0x40;
    HOME_COMMAND = 0x80;
    // BITS of a probe: QUERY, that input 17 counts, that it must be off, and that one that does not exist must.
    PROBE_AND_17 = 1;
    PROBE_XOR_17 = 2;
    PROBE_ALWAYS = 4;
    JOG_RELATIVE = firmware::rules::commands::RELATIVE;
}

// What the assembly does by shifts: pairs of a flag and its unit, frames and units of axes, the order of short forms.
const _: () = assert!(
    flags::STEPS == 4
        && flags::SPEED == 1 << 6
        && flags::SPEED_STEPS == 1 << 7
        && flags::ACCEL == 1
        && flags::ACCEL_STEPS == 2
        && flags::DECEL == 4
        && flags::DECEL_STEPS == 8
        && flags::AXES == 7
        && flags::COMMON_STEPS == flags::STEPS << 3
        && flags::COMMON_FRAME == 6
        && flags::PROBE_FRAME == 3
        && Op::MoveBy as u8 == Op::MoveTo as u8 + 3
        && Op::MoveRamp as u8 == Op::Move as u8 + 1
        && Op::Move as u8 == Op::MoveTo as u8 + 6
        && Op::Line as u8 == Op::Rapid as u8 + 5
        && Op::MoveTo as u8 == Op::Line as u8 + 5
        && Op::LinearMixed as u8 == Op::Linear as u8 + 1
        && Op::Linear as u8 + 2 == Op::Rapid as u8
        && SHORT_AXES[2].0 == 3
        && SHORT_AXES[3].0 == 4
        && SHORT_AXES[4].0 == 7
);

core::arch::global_asm!(include_str!("moves/coords.s"), options(raw));
// Made of firmware/src/rules/coords.rs.
core::arch::global_asm!(include_str!("generated/coords.s"), options(raw));
// Made of firmware/src/rules/moves.rs.
core::arch::global_asm!(include_str!("generated/moves.s"), options(raw));
core::arch::global_asm!(include_str!("moves/moves.s"), options(raw));
// Made of firmware/src/rules/pace.rs.
core::arch::global_asm!(include_str!("generated/pace.s"), options(raw));
// Made of firmware/src/rules/axes.rs.
core::arch::global_asm!(include_str!("generated/axes.s"), options(raw));
// Made of firmware/src/rules/lines.rs.
core::arch::global_asm!(include_str!("generated/lines.s"), options(raw));
core::arch::global_asm!(include_str!("moves/home.s"), options(raw));
// Made of firmware/src/rules/home.rs.
core::arch::global_asm!(include_str!("generated/home.s"), options(raw));
core::arch::global_asm!(include_str!("moves/probe.s"), options(raw));
// Made of firmware/src/rules/probe.rs.
core::arch::global_asm!(include_str!("generated/probe.s"), options(raw));
core::arch::global_asm!(include_str!("moves/commands.s"), options(raw));
// Made of firmware/src/rules/commands.rs.
core::arch::global_asm!(include_str!("generated/commands.s"), options(raw));
