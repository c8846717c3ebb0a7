//! The check of an image in assembly, a quarter of the size of compiled code. Tests compare it with [`firmware::verify`]'s
//! model.
//!
//! | register | holds |
//! |---|---|
//! | r4 | instruction |
//! | r5 | its code |
//! | r6 | its entry of [`SHAPES`] |
//! | r7 | the instruction after it |
//! | r8 | values that it takes |
//! | r9 | depth of the expression stack |
//! | r10 | scratch memory: [`SCRATCH`] bytes |
//! | r11 to r15 | free |
//!
//! Addresses are absolute. 1 KB of code takes 60 ms at most in programs as people write them.

use core::arch::global_asm;
use firmware::keep::KEEPS;
use firmware::verify::{self, CODE, MACHINE};
use lang::image::{FORMAT, MAX_EVENTS, at};
use lang::isa::{FINGERPRINT, LOW_CELLS, Op, SHORT_CELLS, flags};
use lang::record::{AxisRecord, feature};
use lang::wire::Refusal;

use crate::vm::PART;
use shapes::{ENDS, FIRST_EFFECT, GROUPS, Kind, LOW, MASKS, MASKS_LEN, SHAPES};

#[path = "check_shapes.rs"]
mod shapes;

/// Offset in the scratch memory of the code's address.
pub const CODE_START: u8 = 0;
/// Of the address behind the code, where the data begins.
pub const CODE_END: u8 = 2;
/// Of the address behind the image.
const IMAGE_END: u8 = 4;
/// Of the machine stack on entry, for the way out of any depth.
const FRAME: u8 = 6;
/// Of what the header leaves of the pool, where ON lines take of it.
const FREE: u8 = 8;
/// Bytes of the pool that ON lines take.
const EVENT_POOL: [u16; 2] =
    if PART.features & feature::EVENTS != 0 { PART.event_pool } else { [0, 0] };
/// Longest image.
const ROOM: usize = PART.room_for(false);
const ANCHORS: usize = verify::anchors(ROOM);
/// Scratch memory of the check, bytes; the anchors are its end.
pub const SCRATCH: usize = FREE as usize + if EVENT_POOL[0] != 0 { 2 } else { 0 } + ANCHORS;

#[cfg(feature = "f5529")]
unsafe extern "C" {
    fn pasapas_verify(image: u16, features: u16, scratch: *mut u8) -> u16;
}

/// Checks the image at an address, of which [`firmware::verify::sound`] has found length and CRC
/// good. `features` are those of this firmware.
///
/// # Errors
/// A [`Refusal`] as its number.
#[cfg(feature = "f5529")]
pub fn verify(image: u16, features: u8, scratch: &mut [u8; SCRATCH]) -> Result<(), u8> {
    // SAFETY: the routine reads the image and writes nothing but the scratch memory.
    match unsafe { pasapas_verify(image, features.into(), scratch.as_mut_ptr()) } {
        0 => Ok(()),
        refusal => Err(refusal as u8),
    }
}

#[cfg(feature = "f5529")]
global_asm!(
    ".set CHECK_AT_LIMITS, {}",
    ".set CHECK_MACHINE, {}",
    const lang::record::MachineRecord::AT_LIMITS,
    const MACHINE,
);
const _: () = assert!(PART.at_limits == cfg!(feature = "f5529"));

global_asm!(
    r#"
    .set CHECK_KICK, {kick}
    .set CHECK_WATCHDOG, {watchdog}
    .set CHECK_FRAME, {frame}
    .set CHECK_CODE_START, {code_start}
    .set CHECK_CODE_END, {code_end}
    .set CHECK_IMAGE_END, {image_end}
    .set CHECK_FREE, {free}
    .set CHECK_EVENT_POOL, {event_pool}
    .set CHECK_EVENT_BYTES, {event_bytes}
    .set CHECK_MAX_EVENTS, {max_events}
    .set CHECK_ANCHOR, {anchor}
    .set CHECK_ANCHORS, {anchors}
    .set CHECK_VERSION, {version}
    .set CHECK_FEATURE, {feature}
    .set CHECK_MEMORY, {memory}
    .set CHECK_CODE_REFUSAL, {code_refusal}
    .set CHECK_FORMAT, {format}
    .set CHECK_FINGERPRINT, {fingerprint}
    .set CHECK_MANY, {many}
    .set CHECK_EVENTS, {events}
    .set CHECK_LINES, {lines}
    .set CHECK_POOL_ONE, {pool_one}
    .set CHECK_POOL_MANY, {pool_many}
    .set CHECK_CODE, {code}
    .set CHECK_LEN, {len}
    .set CHECK_CODE_LEN, {code_len}
    .set CHECK_STACK, {stack}
    .set CHECK_KEEPS, {keeps}
    .set CHECK_MAX_KEEPS, {max_keeps}
    .set CHECK_ENTRY, {entry}
    .set CHECK_CELLS, {cells}
    .set CHECK_FRAME_DEPTH, {frame_depth}
    .set CHECK_CALLS, {calls}
    .set CHECK_KEEP_BASE, {keep_base}
    .set CHECK_BLOCK, {block}
    .set CHECK_CALL_BYTES, {call_bytes}
    .set CHECK_AXES, {axes}
    .set CHECK_AXIS_SIZE, {axis_size}
    .set CHECK_PRESENT, {present}
    .set CHECK_FUNC, {func}
    .set CHECK_ENDS, {ends}
    .set CHECK_SUB_NEAR, {sub_near}
    .set CHECK_SUB_FAR, {sub_far}
    .set CHECK_ADDRESS, {address}
    .set CHECK_DISTANCE, {distance}
    .set CHECK_LOW_CELLS, {low_cells}
    .set CHECK_LINEAR_MM_LESS_ONE, {linear_mm_less_one}
    .set CHECK_SPEED, {speed}
    .set CHECK_SENSOR, {sensor}
    .set CHECK_SHORT_CELLS, {short_cells}
    .set CHECK_FIRST_EFFECT, {first_effect}
    .set CHECK_EFFECT_SHIFT, {effect_shift}
    .set CHECK_LOW, {low}
    .set CHECK_COMPACT, {compact}
    .set CHECK_FEATURES, {features}
    .set CHECK_SHAPES, {shapes}
    .set CHECK_MASKS, {masks}
    .set CHECK_MASKS_LEN, {masks_len}
    .set CHECK_SAVES, {saves}
    .set CHECK_HAS_EVENTS, {has_events}
    .set CHECK_HAS_LINES, {has_lines}
    .set CHECK_EVENT, {event}
    .set CHECK_EVENT_KIND, {event_kind}
    .set CHECK_ON_RISE, {on_rise}
    .set CHECK_ON_FALL, {on_fall}
    .set CHECK_ON_EVERY, {on_every}
    .set CHECK_PLAIN, {plain}
    "#,
    include_str!("check/header.s"),
    include_str!("check/passes.s"),
    include_str!("check/instruction.s"),
    include_str!("check/operands.s"),
    kick = const crate::boot::WATCHDOG_KICK,
    watchdog = const crate::boot::WATCHDOG,
    frame = const FRAME,
    code_start = const CODE_START,
    code_end = const CODE_END,
    image_end = const IMAGE_END,
    free = const FREE,
    event_pool = const EVENT_POOL[0],
    event_bytes = const EVENT_POOL[1],
    max_events = const MAX_EVENTS,
    anchor = const SCRATCH - ANCHORS,
    anchors = const ANCHORS,
    version = const Refusal::Version as u8,
    feature = const Refusal::Feature as u8,
    memory = const Refusal::Memory as u8,
    code_refusal = const Refusal::Code as u8,
    format = const FORMAT,
    fingerprint = const FINGERPRINT,
    many = const feature::INTERPOLATE | feature::START,
    events = const feature::EVENTS,
    lines = const feature::LINES,
    pool_one = const PART.pool[0],
    pool_many = const PART.pool[1],
    code = const CODE,
    len = const at::LEN,
    code_len = const at::CODE_LEN,
    stack = const at::STACK,
    keeps = const at::KEEPS,
    max_keeps = const KEEPS,
    entry = const at::ENTRY,
    cells = const at::CELLS,
    frame_depth = const at::FRAME,
    calls = const at::CALLS,
    keep_base = const at::KEEP_BASE,
    block = const verify::block(ROOM),
    call_bytes = const PART.call_bytes,
    axes = const MACHINE + 8,
    axis_size = const AxisRecord::SIZE,
    present = const AxisRecord::PRESENT,
    func = const Op::Func as u8,
    ends = const ENDS,
    sub_near = const (Kind::SubNear as u8) << 3,
    sub_far = const (Kind::SubFar as u8) << 3,
    address = const (Kind::Address as u8) << 3,
    distance = const (Kind::Distance as u8) << 3,
    low_cells = const LOW_CELLS,
    linear_mm_less_one = const Op::LinearMm as u8 - 1,
    speed = const flags::SPEED,
    sensor = const flags::SENSOR,
    short_cells = const SHORT_CELLS,
    first_effect = const FIRST_EFFECT,
    effect_shift = const FIRST_EFFECT - LOW - GROUPS,
    low = const LOW,
    features = const PART.features as u8,
    compact = const cfg!(feature = "g2553") as u8,
    shapes = sym SHAPES,
    masks = sym MASKS,
    masks_len = const MASKS_LEN,
    saves = const crate::vm::SAVES,
    has_events = const PART.features & feature::EVENTS,
    has_lines = const PART.features & feature::LINES,
    event = const Op::Event as u8,
    event_kind = const flags::EVENT_KIND,
    on_rise = const flags::ON_RISE,
    on_fall = const flags::ON_FALL,
    on_every = const flags::ON_EVERY,
    plain = const (Kind::Plain as u8) << 3,
);

#[cfg(feature = "g2553")]
global_asm!(".set CHECK_LENGTHS, {}", sym shapes::LENGTHS);
#[cfg(feature = "f5529")]
global_asm!(".set CHECK_INDEX, {}", sym shapes::INDEX);

// Codes that hold a cell's number are aligned to it; the moves along lines are in their order.
const _: () = assert!(
    (Op::IncShort as u8 | Op::Zero as u8).is_multiple_of(LOW_CELLS)
        && (Op::Load as u8 | Op::Store as u8).is_multiple_of(SHORT_CELLS)
        && Op::LinearMm3 as u8 == Op::LinearMm as u8 + 2
);
