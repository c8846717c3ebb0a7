//! Bits of the flag bytes of effects.
//!
//! | instruction | first byte | second | third |
//! |---|---|---|---|
//! | `move` | axis, STEPS, RELATIVE, START, SPEED, SPEED_STEPS | | |
//! | `moveramp` | as `move` | ACCEL, ACCEL_STEPS, DECEL, DECEL_STEPS | |
//! | `linear` | AXES, RAPID, EXACT, COMMON_STEPS, frame at COMMON_FRAME | | |
//! | `linearmixed` | AXES, RAPID, EXACT, bits 5..7 steps of X, Y, Z | frames, two bits each | |
//! | `arc` | AXES, CLOCKWISE, EXACT, OFFSETS, plane at PLANE | | |
//! | `arcby` | as `arc` | | |
//! | `arcmixed` | as `arc` | frames, two bits each | bits 0..2 steps of X, Y, Z; 3..5 of I, J, K, 3 of R |
//! | `probe` | axis, STEPS, frame at PROBE_FRAME, QUERY, SPEED, SPEED_STEPS | SENSOR 0 default, 3 input; MASK | |
//! | `movespeed` | axis, STEPS | | |
//! | `waitin` | want, LEVEL, TIMEOUT, WAIT_QUERY, INPUT_ON_STACK or the input at INPUT | | |
//! | `waitchar` | TIMEOUT, WAIT_QUERY | | |
//! | `event` | slot, EVENT_KIND | | |
//! | `sync` | LEAD_TIME, SYNC_PULSE or SYNC_ANALOG | | |
//! | `read` | axis, the rest [`super::Look`] | | |

/// Axis index.
pub const AXIS: u8 = 0b11;
/// The target, limit or speed is in steps.
pub const STEPS: u8 = 1 << 2;
/// MoveRel.
pub const RELATIVE: u8 = 1 << 3;
/// START.
pub const START: u8 = 1 << 4;
/// A speed is on the stack. The same bit in all instructions that have one.
pub const SPEED: u8 = 1 << 6;
/// The speed is in steps/s.
pub const SPEED_STEPS: u8 = 1 << 7;
/// An acceleration is on the stack.
pub const ACCEL: u8 = 1;
/// It is in steps/s2.
pub const ACCEL_STEPS: u8 = 1 << 1;
/// A deceleration is on the stack.
pub const DECEL: u8 = 1 << 2;
/// It is in steps/s2.
pub const DECEL_STEPS: u8 = 1 << 3;
/// Bit n: a word for axis n.
pub const AXES: u8 = 0b111;
/// G0.
pub const RAPID: u8 = 1 << 3;
/// G2.
pub const CLOCKWISE: u8 = 1 << 3;
/// G61.
pub const EXACT: u8 = 1 << 4;
/// All words in steps.
pub const COMMON_STEPS: u8 = 1 << 5;
/// The two offsets of the plane, in axis order, instead of R.
pub const OFFSETS: u8 = 1 << 5;
/// Shift of the frame that all words share: 0 work, 1 machine, 2 relative.
pub const COMMON_FRAME: u8 = 6;
/// Shift of the plane.
pub const PLANE: u8 = 6;
/// Shift of the frame of a probe's limit.
pub const PROBE_FRAME: u8 = 3;
/// `Probe?`
pub const QUERY: u8 = 1 << 5;
/// Both bits: input and state, or the two masks, are on the stack.
pub const SENSOR: u8 = 0b11;
/// ProbeMask.
pub const MASK: u8 = 1 << 2;
/// The level is on the stack.
pub const LEVEL: u8 = 1 << 2;
/// A timeout is on the stack.
pub const TIMEOUT: u8 = 1 << 3;
/// `WaitIn?`, `WaitChar?`
pub const WAIT_QUERY: u8 = 1 << 4;
/// WaitIn's input number is on the stack.
pub const INPUT_ON_STACK: u8 = 1 << 5;
/// Shift of WaitIn's input number less one when it is not.
pub const INPUT: u8 = 6;
/// The event's input or time is on the stack.
pub const EVENT_ARGUMENT: u8 = 1 << 4;
/// Mask of what an event instruction does.
pub const EVENT_KIND: u8 = 0b1_1100;
/// ON IN RISE
pub const ON_RISE: u8 = EVENT_ARGUMENT;
/// ON IN FALL
pub const ON_FALL: u8 = EVENT_ARGUMENT | 1 << 2;
/// ON EVERY
pub const ON_EVERY: u8 = EVENT_ARGUMENT | 2 << 2;
/// ON IN OFF
pub const OFF_INPUT: u8 = EVENT_ARGUMENT | 3 << 2;
/// ON EVERY OFF
pub const OFF_EVERY: u8 = 0;
/// `sync`: the lead, behind the place where it is negative, is in ms; otherwise in um.
pub const LEAD_TIME: u8 = 1;
/// `sync`: the second value is the time of a pulse, ms, not a level.
pub const SYNC_PULSE: u8 = 1 << 1;
/// `sync`: the output is an analog one, the second value what it gets.
pub const SYNC_ANALOG: u8 = 1 << 2;
/// Axis value that means all axes.
pub const ALL_AXES: u8 = 3;
