//! The step engine and its planner.

use crate::consts::constants;

constants! {
    // Ticks from now to the event that starts a motion.
    LEAD = 160;
    // Output modes of Timer_A (SLAU144, 12.3.3): set, reset; without one of them a pin is as OUT says, low.
    ARMED = 1 << 5;
    FALLS = 5 << 5;
}

// The ramps first: they reach the scaled numbers by near jumps.
core::arch::global_asm!(include_str!("motion/ramp.s"), options(raw));
// Made of firmware/src/rules/segments.rs.
core::arch::global_asm!(include_str!("generated/segments.s"), options(raw));
core::arch::global_asm!(include_str!("motion/step.s"), options(raw));
core::arch::global_asm!(include_str!("motion/line.s"), options(raw));
// Made of firmware/src/rules/stops.rs: the main loop's look at a motion falls into it.
core::arch::global_asm!(include_str!("generated/stops.s"), options(raw));
// Made of firmware/src/rules/planner.rs.
core::arch::global_asm!(include_str!("generated/planner.s"), options(raw));
