//! The step engine: a timer raises the STEP edges, its interrupts play segments.
//!
//! The timer runs freely at the processor's rate and three of its outputs are the STEP pins. When an event is due
//! the hardware makes the pins active that were armed for it and the interrupt begins: it computes the time of the
//! next event, ends the pulses, looks at the inputs, arms the axes that step next and, last of all, writes the time
//! into the compare registers. Interrupt latency is therefore no jitter as long as that is early enough. When it is
//! not, the event is postponed by 2 us and counted ([`late`]): no step is lost, and neither a pulse nor the pause
//! after it gets shorter than promised.
//!
//! The time of an event is a compare register with a fraction below it, 1/65536 ticks. Each event adds the interval to it
//! and the segment's change to the interval, so nothing is rounded away and a segment lasts what was planned.
//!
//! Two kinds of handlers:
//! - *path*: all axes on one event stream, channel 0's; each axis adds its increment to an accumulator
//!   and steps on the carry: Bresenham's line, as in grbl's stepper interrupt, with 2^32 in place of the number of events,
//!   so that a step takes two additions and no comparison;
//! - *single*: each axis has an event stream of its own on its own compare register.
//!
//! DIR changes 1 us after STEP has ended, and the next step of that axis comes `dir_setup_us` later at the earliest.
//!
//! `tests/tests/motion_chip.rs` holds every edge to what `firmware::motion` planned.

mod handlers;

use core::mem::{MaybeUninit, offset_of};
use firmware::motion::queue::{self, SLOTS};
use firmware::motion::{PathSegment, Segment};

use crate::chip::ports::{self, DIR};
use crate::chip::timer::{FIRST, STEP_CCR, STEP_CCTL, STEP_CTL, STEP_PER_US, STEP_R};
use crate::guard;
use lang::part::SHORT_PULSE_US;
use lang::record::BoardRecord;

/// A segment of all axes in the engine's memory.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct PathSlot {
    ramp: Segment,
    inc: [u32; 3],
    /// Upper halves of the accumulators at the beginning of a block.
    acc: [u16; 3],
    /// Levels of the DIR pins.
    dirs: u8,
    /// Bit n: axis n counts down; bit 7: a new block begins.
    flags: u8,
    /// Time that it takes ([`queue::time`]).
    time: u16,
    /// Power of a laser, 0 to 1000; with a PWM its compare value.
    power: u16,
}

/// The path handler's memory: a ring of slots.
#[derive(Clone, Copy)]
#[repr(C)]
struct PathState {
    slots: [PathSlot; SLOTS],
    acc: [u32; 3],
}

/// One axis of the single handler: the segment that plays, the next one, and the fraction of the
/// compare register. Bit 15 of a mask says negative direction.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct SingleState {
    playing: Segment,
    /// The next one.
    pub next: Segment,
    frac: u16,
}

/// Only one handler works at a time.
#[repr(C)]
union State {
    path: PathState,
    single: [SingleState; 3],
}

/// What both handlers share; the assembly knows its layout.
#[repr(C)]
struct Shared {
    /// Handler of channel 0.
    vector: u16,
    /// Path: the slot being played.
    current: u16,
    /// Path: fraction of the compare registers.
    frac: u16,
    /// Steps made, modulo 65536; the main loop folds them into positions.
    count: [u16; 3],
    /// 1 or -1 for each axis: what a step adds to its count.
    sense: [i16; 3],
    /// Events that could not be armed in time.
    late: u16,
    /// Ticks of a long pulse, 0 for a short one.
    width: u16,
    /// Inputs at pins that stop or catch, and their levels when at rest.
    watch: u8,
    /// See `watch`.
    idle: u8,
    /// What answered, 0 for nothing yet.
    hit: u8,
    /// Whether an answer stops all axes at once.
    halt: u8,
    /// Counts at the moment of the answer.
    caught: [u16; 3],
    /// Path: the slot to fill next.
    fill: u8,
    /// Exclusive-or of the DIR pins: axes whose positive direction is low.
    invert: u8,
    /// Not 0: the power of a path's segment is the PWM's from its beginning on.
    shines: u16,
    /// Path: the slot that played when the main loop looked last, and the time of those behind it.
    seen: u16,
    ahead: u16,
    /// Path: when the event is due that is armed, or being armed.
    due: u16,
    /// Ticks from a change of DIR to the next event, at least.
    setup: u16,
    /// Control of a channel whose STEP is at rest, becomes active at the compare, and ends at the compare; of a path.
    rest: u16,
    rise: u16,
    fall: u16,
    /// The same with the channel's own interrupt, for an axis on its own.
    one_rest: u16,
    one_rise: u16,
    one_fall: u16,
}

#[unsafe(no_mangle)]
static mut PASAPAS_STEP: MaybeUninit<Shared> = MaybeUninit::zeroed();

#[unsafe(no_mangle)]
static mut PASAPAS_PLAY: MaybeUninit<State> = MaybeUninit::zeroed();

unsafe extern "C" {
    fn pasapas_path_event();
    fn pasapas_path_long();
}

/// CCIE of a capture/compare control register.
const CCIE: u16 = 1 << 4;
/// OUTMOD of it; 0 puts the pin at the level of [`OUT`].
const MODES: u16 = 7 << 5;
/// Output mode: high from the compare on.
const SET: u16 = 1 << 5;
/// Output mode: low from the compare on.
const RESET: u16 = 5 << 5;
/// Level of a pin in output mode 0.
const OUT: u16 = 1 << 2;

/// Channels of the timer: that of a path's events, and those of the axes from [`FIRST`] on.
const CHANNELS: usize = FIRST + 3;
/// Control of the channels.
const CCTL: *mut [u16; CHANNELS] = STEP_CCTL as *mut _;
/// Their compare registers.
const CCR: *mut [u16; CHANNELS] = STEP_CCR as *mut _;
/// The counter.
const R: *mut u16 = STEP_R as *mut u16;

/// Whether an axis has an event ahead; the path's run on channel 0. Also as long as nobody has looked
/// into why a pin stopped it.
pub fn axis_is_running(axis: usize) -> bool {
    enabled(axis) || guard::tripped() != 0
}

/// Empties the memory of both handlers, for the next motion of either kind. Nothing runs.
pub fn clear() {
    // SAFETY: no channel is enabled, so no interrupt looks at it.
    unsafe {
        state().write(core::mem::zeroed());
        (*shared()).fill = 0;
        (*shared()).current = 0;
        (*shared()).seen = 0;
        (*shared()).ahead = 0;
    }
}

/// Sets the DIR pins that are low for the positive direction. Nothing runs where they change; the pieces of a streamed
/// job, which have the same ones, come while axes move.
pub fn set_invert(invert: u8) {
    // SAFETY: only the main loop changes it; where it changes no channel is enabled, so no interrupt looks at it.
    unsafe {
        if (*shared()).invert == invert {
            return;
        }
        (*shared()).invert = invert;
        // The handlers turn a pin over when the sense changes: both say positive here.
        (*shared()).sense = [1; 3];
    }
    set_dirs(0);
}

/// The interrupt enable bit of an axis's channel, with the first axis's that of the path's.
fn enabled(axis: usize) -> bool {
    FIRST != 0 && axis == 0 && answers(0) || answers(FIRST + axis)
}

/// The interrupt enable bit of a channel.
fn answers(channel: usize) -> bool {
    // SAFETY: a peripheral register.
    unsafe { (&raw const (*CCTL)[channel]).read_volatile() & CCIE != 0 }
}

/// Ticks from now to the event that starts a motion: 10 us.
const LEAD: u16 = 10 * STEP_PER_US;

// SAFETY of both: the chip has one core; what an interrupt also touches is read and written through
// these pointers in single words.
fn shared() -> *mut Shared {
    (&raw mut PASAPAS_STEP).cast()
}

fn state() -> *mut State {
    (&raw mut PASAPAS_PLAY).cast()
}

/// Starts the timer and gives it the STEP pins, at rest. `record` says how wide a pulse is, which level is active and
/// how long DIR stands before a step; a board that knows no wiring drives neither STEP nor DIR.
pub fn init(record: &BoardRecord) {
    let width_us = record.pulse;
    let width = if width_us <= SHORT_PULSE_US { 0 } else { u16::from(width_us) * STEP_PER_US };
    let low = record.flags & BoardRecord::STEP_LOW != 0;
    let (rest, rise, fall) = if low { (OUT, RESET | OUT, SET) } else { (0, SET, RESET) };
    // SAFETY: interrupts of the timer are still off.
    unsafe {
        // A watchdog reset leaves Timer_A as it was (SLAU208, 17.3: these bits are reset by POR), and
        // the vector of its handlers is gone.
        for channel in 0..CHANNELS {
            (&raw mut (*CCTL)[channel]).write_volatile(rest);
        }
        // SMCLK, continuous, cleared.
        (STEP_CTL as *mut u16).write_volatile(0b10 << 8 | 0b10 << 4 | 1 << 2);
        let shared = shared();
        (*shared).shines = 0;
        (*shared).width = width;
        (*shared).setup = u16::from(record.setup) * STEP_PER_US;
        (*shared).rest = rest;
        (*shared).rise = rise;
        (*shared).fall = fall;
        (*shared).one_rest = rest | CCIE;
        (*shared).one_rise = rise | CCIE;
        (*shared).one_fall = fall | CCIE;
        (*shared).sense = [1; 3];
    }
    if record.flags & BoardRecord::UNWIRED != 0 {
        return ports::leave_axes();
    }
    set_dirs(0);
    ports::give_steps(low);
}

/// Whether any axis has an event ahead; see [`axis_is_running`].
pub fn is_running() -> bool {
    moves() || guard::tripped() != 0
}

fn moves() -> bool {
    enabled(0) || enabled(1) || enabled(2)
}

/// Whether a segment of a path would be taken.
pub fn path_has_room() -> bool {
    // SAFETY: a byte of the main loop's own.
    !is_held(slot(usize::from(unsafe { (*shared()).fill })))
}

/// Time that the segments behind the playing one last ([`queue::time`]): of those that have begun since the last time
/// it is taken off. 0 at rest, where the place behind the last one plays, which has an old time.
pub fn ahead() -> u16 {
    if !is_running() {
        return 0;
    }
    // SAFETY: words of the main loop's own, a single one that the interrupt writes; the places are inside the path's
    // state.
    unsafe {
        let shared = shared();
        let current = (&raw const (*shared).current).read_volatile();
        while (*shared).seen != current {
            let mut next = ((*shared).seen as *mut PathSlot).add(1);
            if next == slot(0).add(SLOTS) {
                next = slot(0);
            }
            (*shared).seen = next as u16;
            (*shared).ahead -= (*next).time;
        }
        (*shared).ahead
    }
}

/// A slot of the path.
fn slot(n: usize) -> *mut PathSlot {
    // SAFETY: the place is inside the path's state.
    unsafe { &raw mut (*state()).path.slots[n] }
}

/// Whether a slot plays or waits.
fn is_held(slot: *mut PathSlot) -> bool {
    // SAFETY: single words.
    unsafe {
        (&raw const (*slot).ramp.events).read_volatile() != 0
            || (&raw const (*shared()).current).read_volatile() == slot as u16 && is_running()
    }
}

/// Power of the segment that plays.
pub fn power() -> u16 {
    // SAFETY: `current` is a slot of the path while one moves; only the main loop writes powers.
    unsafe {
        let current = (&raw const (*shared()).current).read_volatile();
        (*(usize::from(current) as *const PathSlot)).power
    }
}

/// The PWM gets the power of each segment of a path, and is dark when nothing moves.
pub fn shine() {
    // SAFETY: no channel is enabled, so no interrupt looks at it.
    unsafe { (*shared()).shines = 1 };
}

/// Hands a segment of a path to the engine, with the power that [`PathSlot`] wants; there must be room. A resting
/// engine starts.
pub fn put_path(segment: &PathSegment, power: u16) {
    // What began meanwhile may be the slot's last segment.
    ahead();
    // SAFETY: only the main loop reads and writes it.
    let n = usize::from(unsafe { (*shared()).fill });
    let slot = slot(n);
    let time = queue::time(&segment.ramp);
    let mut dirs = 0;
    for (axis, pin) in DIR.iter().enumerate() {
        if segment.negative >> axis & 1 == 0 {
            dirs |= pin;
        }
    }
    // SAFETY: the slot is free, the interrupt looks at it once its `events` are not 0.
    unsafe {
        (*slot).inc = segment.inc;
        (*slot).acc = segment.acc;
        (*slot).dirs = dirs ^ (*shared()).invert;
        (*slot).flags = segment.negative | u8::from(segment.begin) << 7;
        (*slot).ramp.interval = segment.ramp.interval;
        (*slot).ramp.dif = segment.ramp.dif;
        (*slot).ramp.mask = segment.ramp.mask;
        (*slot).time = time;
        (*slot).power = power;
        guard::arm(&raw mut (*slot).ramp.events, segment.ramp.events);
        (*shared()).fill = ((n + 1) % SLOTS) as u8;
        (*shared()).ahead += time;
        if !is_running() {
            // The slot before, an empty one: the first interrupt leaves it and begins this one.
            (*shared()).current = self::slot((n + SLOTS - 1) % SLOTS) as u16;
            (*shared()).seen = (*shared()).current;
            (*shared()).ahead = time;
            let long = (*shared()).width != 0;
            let handler = if long { pasapas_path_long } else { pasapas_path_event };
            (*shared()).vector = handler as *const () as usize as u16;
            start(0);
        }
    }
}

/// Whether a segment of an axis of its own would be taken.
pub fn axis_has_room(axis: usize) -> bool {
    // SAFETY: a single word.
    unsafe { (&raw const (*state()).single[axis].next.events).read_volatile() == 0 }
}

/// Hands a segment of one axis to the engine; there must be room. A resting axis starts.
pub fn put_axis(axis: usize, segment: &Segment, negative: bool) {
    // SAFETY: `next` is free, the interrupt looks at it once its `events` are not 0.
    unsafe {
        let next = &raw mut (*state()).single[axis].next;
        (*next).interval = segment.interval;
        (*next).dif = segment.dif;
        (*next).mask = segment.mask | if negative { 1 << 15 } else { 0 };
        guard::arm(&raw mut (*next).events, segment.events);
        if !enabled(axis) {
            start(FIRST + axis);
        }
    }
}

/// Lets a channel's first event come in [`LEAD`] ticks. Interrupts of other axes and of the lines wait: they may take longer
/// than that, and the event would come a whole round of the timer later, 2.6 ms.
fn start(channel: usize) {
    msp430::interrupt::disable();
    // SAFETY: the channel is off, so its handler does not run.
    unsafe {
        let at = R.read_volatile().wrapping_add(LEAD);
        (*shared()).due = at;
        (&raw mut (*CCR)[channel]).write_volatile(at);
        (&raw mut (*CCTL)[channel]).write_volatile((*shared()).one_rest);
    }
    // SAFETY: only the main loop calls this, with interrupts on.
    unsafe { msp430::interrupt::enable() };
}

/// Drops everything that is planned and waits for rest: no step after the next event, which is
/// armed already and at most 2 ms away.
pub fn halt() {
    // SAFETY: single words of the handlers' slots; an engine that finds no events rests. The two
    // handlers share the memory, and what the other one keeps at these places is lost with it.
    unsafe {
        for n in 0..SLOTS {
            (&raw mut (*slot(n)).ramp.events).write_volatile(0);
        }
        for axis in 0..3 {
            (&raw mut (*state()).single[axis].next.events).write_volatile(0);
            (&raw mut (*state()).single[axis].playing.events).write_volatile(0);
        }
    }
    while moves() {}
    guard::release();
}

/// As [`halt`] for one axis that moves on its own; the others go on.
pub fn halt_axis(axis: usize) {
    // SAFETY: as in `halt`; no path uses the memory while an axis moves on its own.
    unsafe {
        (&raw mut (*state()).single[axis].next.events).write_volatile(0);
        (&raw mut (*state()).single[axis].playing.events).write_volatile(0);
    }
    while enabled(axis) {}
}

/// Adds the steps made since the last call to a position; at least every 32 767 steps.
pub fn fold(axis: usize, position: &mut i32) {
    // SAFETY: a single word.
    let count = unsafe { (&raw const (*shared()).count[axis]).read_volatile() };
    let moved = count.wrapping_sub(*position as u16) as i16;
    *position = position.wrapping_add(i32::from(moved));
}

/// Makes an axis's position known to the engine, which counts its low half.
pub fn set_count(axis: usize, position: i32) {
    // SAFETY: a single word of a resting axis.
    unsafe { (&raw mut (*shared()).count[axis]).write_volatile(position as u16) };
}

/// Watches pins of inputs at every event: `pins` answer when they differ from `idle`. With `halt`
/// the engine drops everything at that step, else it only notes the counts. No pins: not at all.
pub fn watch(pins: u8, idle: u8, halt: bool) {
    // SAFETY: bytes that the interrupt reads only after `watch` is set.
    unsafe {
        (&raw mut (*shared()).watch).write_volatile(0);
        (*shared()).hit = 0;
        (*shared()).idle = idle;
        (*shared()).halt = u8::from(halt);
        (&raw mut (*shared()).watch).write_volatile(pins);
    }
}

/// The pins that answered, 0 for none.
pub fn hit() -> u8 {
    // SAFETY: a byte.
    unsafe { (&raw const (*shared()).hit).read_volatile() }
}

/// Where an axis was when the pins answered, given its present position.
pub fn caught(axis: usize, position: i32) -> i32 {
    // SAFETY: written before `hit`, and not again before `watch`.
    let count = unsafe { (*shared()).caught[axis] };
    position.wrapping_add(i32::from(count.wrapping_sub(position as u16) as i16))
}

/// Events that came late since reset, as they could not be armed in time. None of them lost a step or shortened a pulse.
pub fn late() -> u16 {
    // SAFETY: a single word.
    unsafe { (&raw const (*shared()).late).read_volatile() }
}

/// Sets the DIR pins of resting axes; bit n: axis n moves in negative direction.
fn set_dirs(negative: u8) {
    let mut dirs = 0;
    for (axis, pin) in DIR.iter().enumerate() {
        if negative >> axis & 1 == 0 {
            dirs |= pin;
        }
    }
    // SAFETY: resting axes.
    let dirs = unsafe { dirs ^ (*shared()).invert };
    ports::set_dirs(dirs);
}

// What plays begins where the state does; a segment begins with its interval.
const _: () = assert!(
    offset_of!(PathState, slots) == 0
        && offset_of!(PathSlot, ramp) == 0
        && offset_of!(SingleState, playing) == 0
        && offset_of!(Segment, interval) == 0
);
