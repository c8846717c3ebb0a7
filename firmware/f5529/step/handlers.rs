//! The step interrupts, path and single.
//!
//! Pulses longer than the interrupt's latency (a board profile with `pulse` above 3 us) take a
//! second interrupt: the first one lets the hardware drop the pins `width` ticks after the edge.
//!
//! Cycles from entry to RETI, measured in the emulator: path, three axes stepping, 184, at a
//! segment change 212, when a line or chord begins 267; single 115, at a segment change 181. At
//! 40 000 events/s the path takes 46 % of the CPU, at 60 000 events/s 69 %. Of the 184: entry and
//! exit 21, schedule 24, ramp 12, pins down 13, inputs 11, count and sub-events 18, three axes with
//! their step counts 75, lateness 10.

use super::{PathSlot, PathState, Shared, SingleState};
use crate::chip::ports::{self, DIR};
use crate::chip::pwm::{self, DARK};
use crate::chip::timer::{FIRST, STEP_CCR, STEP_CCTL, STEP_IV, STEP_PER_US, STEP_R};
use core::arch::global_asm;
use core::mem::offset_of;
use firmware::motion::Segment;
use firmware::motion::queue::SLOTS;
use lang::part::SHORT_PULSE_US;

global_asm!(
    r#"
    /* channel 0, which has a path's events, and those of the axes: X shares it or has one of its own */
    .set EVENT_CCTL, {cctl}
    .set EVENT_CCR, {ccr}
    .set APART, {first}
    .set X_CCTL, {cctl}+2*APART
    .set Y_CCTL, X_CCTL+2
    .set Z_CCTL, X_CCTL+4
    .set X_CCR, {ccr}+2*APART
    .set Y_CCR, X_CCR+2
    .set Z_CCR, X_CCR+4
    .if APART
    .set X_RISES, 0x0020
    .set EVENT_FALLS, 0x0010
    .else
    .set X_RISES, 0x0030
    .set EVENT_FALLS, 0x00b0
    .endif
    .set COUNTER, {counter}
    .set STEP_IV, {vector_register}
    .set PINS_IN, {pins_in}
    .set DIR_OUT, {dir_out}

    /* fields of Shared */
    .set VECTOR, PASAPAS_STEP+{vector}
    .set CURRENT, PASAPAS_STEP+{current}
    .set FRAC, PASAPAS_STEP+{frac}
    .set COUNT, PASAPAS_STEP+{count}
    .set SENSE, PASAPAS_STEP+{sense}
    .set LATE, PASAPAS_STEP+{late}
    .set WIDTH, PASAPAS_STEP+{width}
    .set WATCH, PASAPAS_STEP+{watch}
    .set IDLE, PASAPAS_STEP+{idle}
    .set HIT, PASAPAS_STEP+{hit}
    .set HALT, PASAPAS_STEP+{halt}
    .set CAUGHT, PASAPAS_STEP+{caught}
    .set SHINES, PASAPAS_STEP+{shines}

    /* offsets in a segment, in a slot of a path, in the state of a single axis, whose first is what plays */
    .set INTERVAL, {interval}
    .set DIF, {dif}
    .set EVENTS, {events}
    .set MASK, {mask}
    .set INC, {inc}
    .set BLOCK_ACC, {block_acc}
    .set DIRS, {dirs}
    .set FLAGS, {flags}
    .set POWER, {power}
    .set NEXT, {next}
    .set AXIS_FRAC, {axis_frac}
    .set SINGLE, {single}

    /* slots and accumulators of a path */
    .set SLOT, {slot}
    .set SLOTS, PASAPAS_PLAY
    .set ACC, PASAPAS_PLAY+{acc}
    .set SLOTS_END, PASAPAS_PLAY+{slots}*SLOT

    /* A short pulse ends where the interrupt drops it. What stands before that takes `taken` cycles from the
       edge at least: the loop, 3 cycles a round, r14, is for the rest. */
    .macro lasts taken
    .if {pulse} > \taken+1
    mov #({pulse}-\taken-1+2)/3, r14
8:  dec r14
    jne 8b
    .endif
    .endm
    .set PATH_PULSE, 76
    .set SINGLE_PULSE, 64
    .set STOP_PULSE, 30
    .set PATH_STOP_PULSE, 55

    .section .text.step,"ax",@progbits
module.motion.step:
    .global pasapas_event
pasapas_event:
    br &VECTOR

    /* long pulse, first half: the pins have just risen, let them fall in WIDTH ticks */
    .global pasapas_path_long
pasapas_path_long:
    add &WIDTH, &EVENT_CCR
    .if APART
    mov &EVENT_CCR, &X_CCR
    mov #0x00a0, &X_CCTL
    .endif
    mov &EVENT_CCR, &Y_CCR
    mov &EVENT_CCR, &Z_CCR
    mov #EVENT_FALLS, &EVENT_CCTL
    mov #0x00a0, &Y_CCTL
    mov #0x00a0, &Z_CCTL
    mov #pasapas_path_fallen, &VECTOR
    /* past already, as behind another interrupt: the compare would not come before 4 ms */
    cmp &COUNTER, &EVENT_CCR
    jn pasapas_path_fallen
    reti
pasapas_path_fallen:
    mov #pasapas_path_long, &VECTOR
    sub &WIDTH, &EVENT_CCR

    /* an event of a path: the pins have just risen (or fallen again) */
    .global pasapas_path_event
pasapas_path_event:
    push r15
    push r14
    mov &CURRENT, r15
    dec EVENTS(r15)
    jnc path_switch
path_schedule:
    add @r15, &FRAC
    addc INTERVAL+2(r15), &EVENT_CCR
    .if APART
    mov &EVENT_CCR, &X_CCR
    .endif
    mov &EVENT_CCR, &Y_CCR
    mov &EVENT_CCR, &Z_CCR
    add DIF(r15), INTERVAL(r15)
    addc DIF+2(r15), INTERVAL+2(r15)
    mov.b &PINS_IN, r14
    xor.b &IDLE, r14
    and.b &WATCH, r14
    jne path_hit
path_arm:
    lasts PATH_PULSE
    /* a move keeps the flags */
    bit MASK(r15), EVENTS(r15)
    mov #0x0010, &EVENT_CCTL
    .if APART
    clr &X_CCTL
    .endif
    clr &Y_CCTL
    clr &Z_CCTL
    jne path_armed
    add INC(r15), &ACC
    addc INC+2(r15), &ACC+2
    jnc 1f
    mov #X_RISES, &X_CCTL
    add &SENSE, &COUNT
1:  add INC+4(r15), &ACC+4
    addc INC+6(r15), &ACC+6
    jnc 2f
    mov #0x0020, &Y_CCTL
    add &SENSE+2, &COUNT+2
2:  add INC+8(r15), &ACC+8
    addc INC+10(r15), &ACC+10
    jnc path_armed
    mov #0x0020, &Z_CCTL
    add &SENSE+4, &COUNT+4
path_armed:
    mov &EVENT_CCR, r14
    sub &COUNTER, r14
    cmp #4, r14
    jl path_late
    pop r14
    pop r15
    reti

    /* the next event is due already: 4 us from now */
path_late:
    inc &LATE
    mov &COUNTER, r14
    add #{late_ticks}, r14
    mov r14, &EVENT_CCR
    .if APART
    mov r14, &X_CCR
    .endif
    mov r14, &Y_CCR
    mov r14, &Z_CCR
    pop r14
    pop r15
    reti

    /* an input answered at the step just made */
path_hit:
    mov.b r14, &HIT
    clr.b &WATCH
    mov &COUNT, &CAUGHT
    mov &COUNT+2, &CAUGHT+2
    mov &COUNT+4, &CAUGHT+4
    tst.b &HALT
    jeq path_arm
    mov #SLOTS, r15
1:  clr EVENTS(r15)
    add #SLOT, r15
    cmp #SLOTS_END, r15
    jne 1b
    jmp path_stop

    /* the slot is played: the next one, or rest */
path_switch:
    clr EVENTS(r15)
    add #SLOT, r15
    cmp #SLOTS_END, r15
    jne 1f
    mov #SLOTS, r15
1:  mov r15, &CURRENT
    dec EVENTS(r15)
    jnc path_empty
    tst &SHINES
    jeq 9f
    mov POWER(r15), &PASAPAS_POWER
    bis #{ask_power}, &{pwm_cctl}
9:
    tst.b FLAGS(r15)
    jge path_schedule
    mov.b &DIR_OUT, r14
    and.b #{dirs_off}, r14
    bis.b DIRS(r15), r14
    mov.b r14, &DIR_OUT
    clr &ACC
    mov BLOCK_ACC(r15), &ACC+2
    clr &ACC+4
    mov BLOCK_ACC+2(r15), &ACC+6
    clr &ACC+8
    mov BLOCK_ACC+4(r15), &ACC+10
    mov.b FLAGS(r15), r14
    mov #1, &SENSE
    mov #1, &SENSE+2
    mov #1, &SENSE+4
    rra r14
    jnc 2f
    mov #-1, &SENSE
2:  rra r14
    jnc 3f
    mov #-1, &SENSE+2
3:  rra r14
    jnc path_schedule
    mov #-1, &SENSE+4
    jmp path_schedule
path_empty:
    clr EVENTS(r15)
path_stop:
    lasts PATH_STOP_PULSE
    clr &EVENT_CCTL
    .if APART
    clr &X_CCTL
    .endif
    clr &Y_CCTL
    clr &Z_CCTL
    tst &SHINES
    jeq 9f
    mov #{dark}, &PASAPAS_POWER
    mov #{dark}, &{pwm_ccr}
9:
    pop r14
    pop r15
    reti

    /* an event of one axis; r13 is twice the number of its channel, as the vector register has it */
    .global pasapas_channels
pasapas_channels:
    push r15
    push r13
    mov &STEP_IV, r13
    jmp single_event
    .global pasapas_single_event
pasapas_single_event:
    push r15
    push r13
    clr r13
single_event:
    push r14
    mov single_states-2*APART(r13), r15
    tst &WIDTH
    jne single_long
single_fallen:
    dec EVENTS(r15)
    jnc single_switch
single_schedule:
    add @r15, AXIS_FRAC(r15)
    addc INTERVAL+2(r15), EVENT_CCR(r13)
    add DIF(r15), INTERVAL(r15)
    addc DIF+2(r15), INTERVAL+2(r15)
    mov.b &PINS_IN, r14
    xor.b &IDLE, r14
    and.b &WATCH, r14
    jne single_hit
single_arm:
    lasts SINGLE_PULSE
    bit MASK(r15), EVENTS(r15)
    mov #0x0010, EVENT_CCTL(r13)
    jne single_armed
    mov #0x0030, EVENT_CCTL(r13)
    add SENSE-2*APART(r13), COUNT-2*APART(r13)
single_armed:
    mov EVENT_CCR(r13), r14
    sub &COUNTER, r14
    cmp #4, r14
    jl single_late
single_exit:
    pop r14
    pop r13
    pop r15
    reti

single_late:
    inc &LATE
    mov &COUNTER, r14
    add #{late_ticks}, r14
    mov r14, EVENT_CCR(r13)
    jmp single_exit

    /* output mode 5 is on: the long pulse is over; else it has just begun */
single_long:
    bit #0x0080, EVENT_CCTL(r13)
    jne 1f
    add &WIDTH, EVENT_CCR(r13)
    mov #0x00b0, EVENT_CCTL(r13)
    /* past already: by the difference's sign, as the timer goes round */
    cmp &COUNTER, EVENT_CCR(r13)
    jn 1f
    jmp single_exit
1:  sub &WIDTH, EVENT_CCR(r13)
    jmp single_fallen

single_hit:
    mov.b r14, &HIT
    clr.b &WATCH
    mov &COUNT, &CAUGHT
    mov &COUNT+2, &CAUGHT+2
    mov &COUNT+4, &CAUGHT+4
    tst.b &HALT
    jeq single_arm
    .irp axis, 0, 1, 2
    clr &PASAPAS_PLAY+\axis*SINGLE+EVENTS
    clr &PASAPAS_PLAY+\axis*SINGLE+NEXT+EVENTS
    .endr
    jmp single_stop

    /* the segment is played: take the next one, or rest */
single_switch:
    clr EVENTS(r15)
    tst NEXT+EVENTS(r15)
    jeq single_stop
    mov NEXT(r15), INTERVAL(r15)
    mov NEXT+2(r15), INTERVAL+2(r15)
    mov NEXT+4(r15), DIF(r15)
    mov NEXT+6(r15), DIF+2(r15)
    mov NEXT+EVENTS(r15), EVENTS(r15)
    mov NEXT+MASK(r15), MASK(r15)
    clr NEXT+EVENTS(r15)
    mov MASK(r15), r14
    xor SENSE-2*APART(r13), r14
    tst r14
    jge 1f
    xor.b single_dir-2*APART(r13), &DIR_OUT
    inv SENSE-2*APART(r13)
    inc SENSE-2*APART(r13)
1:  dec EVENTS(r15)
    jmp single_schedule
single_stop:
    lasts STOP_PULSE
    clr EVENT_CCTL(r13)
    /* dark when no other moves */
    mov &X_CCTL, r14
    bis &Y_CCTL, r14
    bis &Z_CCTL, r14
    bit #0x0010, r14
    jne single_exit
    tst &SHINES
    jeq single_exit
    mov #{dark}, &PASAPAS_POWER
    mov #{dark}, &{pwm_ccr}
    jmp single_exit

    /* below the vectors, where there is room */
    .section .tail.step,"a",@progbits
single_states:
    .short PASAPAS_PLAY, PASAPAS_PLAY+SINGLE, PASAPAS_PLAY+2*SINGLE
single_dir:
    .short {dir_x}, {dir_y}, {dir_z}
    "#,
    pulse = const STEP_PER_US * SHORT_PULSE_US as u16,
    late_ticks = const 4 * STEP_PER_US,
    cctl = const STEP_CCTL,
    ccr = const STEP_CCR,
    first = const FIRST,
    counter = const STEP_R,
    vector_register = const STEP_IV,
    pins_in = const ports::IN,
    dir_out = const ports::DIR_OUT,
    dirs_off = const !(DIR[0] | DIR[1] | DIR[2]),
    dir_x = const DIR[0],
    dir_y = const DIR[1],
    dir_z = const DIR[2],
    vector = const offset_of!(Shared, vector),
    current = const offset_of!(Shared, current),
    frac = const offset_of!(Shared, frac),
    count = const offset_of!(Shared, count),
    sense = const offset_of!(Shared, sense),
    late = const offset_of!(Shared, late),
    width = const offset_of!(Shared, width),
    watch = const offset_of!(Shared, watch),
    idle = const offset_of!(Shared, idle),
    hit = const offset_of!(Shared, hit),
    halt = const offset_of!(Shared, halt),
    caught = const offset_of!(Shared, caught),
    shines = const offset_of!(Shared, shines),
    ask_power = const pwm::ASK,
    pwm_cctl = const pwm::CCTL,
    pwm_ccr = const pwm::CCR,
    dark = const DARK,
    interval = const offset_of!(Segment, interval),
    dif = const offset_of!(Segment, dif),
    events = const offset_of!(Segment, events),
    mask = const offset_of!(Segment, mask),
    inc = const offset_of!(PathSlot, inc),
    block_acc = const offset_of!(PathSlot, acc),
    dirs = const offset_of!(PathSlot, dirs),
    flags = const offset_of!(PathSlot, flags),
    power = const offset_of!(PathSlot, power),
    next = const offset_of!(SingleState, next),
    axis_frac = const offset_of!(SingleState, frac),
    single = const size_of::<SingleState>(),
    slot = const size_of::<PathSlot>(),
    slots = const SLOTS,
    acc = const offset_of!(PathState, acc),
);

// What plays begins where the state does; a segment begins with its interval.
const _: () = assert!(
    offset_of!(PathState, slots) == 0
        && offset_of!(PathSlot, ramp) == 0
        && offset_of!(SingleState, playing) == 0
        && offset_of!(Segment, interval) == 0
);
