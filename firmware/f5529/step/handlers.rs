//! The step interrupts, path and single.
//!
//! Pulses longer than the interrupt's latency (a board profile with `pulse` above 3 us) take a
//! second interrupt: the first one lets the hardware drop the pins `width` ticks after the edge.
//!
//! Cycles from entry to RETI, measured in the emulator: path, three axes stepping, 184, at a segment change 212, when a
//! line or chord begins 267; single 115, at a segment change 181. At 40 000 events/s the path takes 46 % of the CPU, at
//! 60 000 events/s 69 %. Of the 184: entry and exit 21, schedule 24, ramp 12, pins down 13, inputs 11, count and sub-events
//! 18, three axes with their step counts 75, lateness 10.

use super::{MODES, PathSlot, PathState, Shared, SingleState};
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
    /* channel 0, which has a path's events, and those of the axes */
    .set EVENT_CCTL, {cctl}
    .set EVENT_CCR, {ccr}
    .set X_CCTL, {cctl}+2*{first}
    .set Y_CCTL, X_CCTL+2
    .set Z_CCTL, X_CCTL+4
    .set X_CCR, {ccr}+2*{first}
    .set Y_CCR, X_CCR+2
    .set Z_CCR, X_CCR+4
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
    .set STEP_DUE, PASAPAS_STEP+{due}
    .set STEP_SETUP, PASAPAS_STEP+{setup}
    .set STEP_REST, PASAPAS_STEP+{rest}
    .set STEP_RISE, PASAPAS_STEP+{rise}
    .set STEP_FALL, PASAPAS_STEP+{fall}
    .set ONE_REST, PASAPAS_STEP+{one_rest}
    .set ONE_RISE, PASAPAS_STEP+{one_rise}
    .set ONE_FALL, PASAPAS_STEP+{one_fall}

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

    /* waits so many cycles at least, r14 */
    .macro waits cycles
    mov #(\cycles+2)/3, r14
8:  dec r14
    jne 8b
    .endm

    .set PATH_PULSE, 77
    .set PATH_STOP_PULSE, 50
    .set SINGLE_PULSE, 57
    .set ONE_TURN_PULSE, 62
    .set STOP_PULSE, 30

    /* STEP of all axes at rest */
    .macro all_rest
    mov &STEP_REST, r14
    mov r14, &X_CCTL
    mov r14, &Y_CCTL
    mov r14, &Z_CCTL
    .endm

    /* From the look at the counter to the last write of a compare register pass fewer cycles than `MARGIN`. An event
       that is nearer comes `DELAY` later than now. */
    .set MARGIN, 32
    .set DELAY, 50
    /* The same for an axis on its own, of which STEP has just ended: DM542 wants 2.5 us low. */
    .set ONE_MARGIN, 57
    .set ONE_DELAY, 68

    /* Schedules the next event of the slot at r15, ends the pulses, looks at the inputs and arms the axes that step next;
       with `turns` DIR follows the slot, too: when STEP has ended for {hold} cycles, and STEP_SETUP ticks before the
       event. STEP_DUE:FRAC += interval, interval += dif; an axis steps on the carry of ACC += INC. An event whose count
       has a bit of MASK set is a sub-event: time passes, no axis steps. */
    .macro plays turns
    add @r15, &FRAC
    addc INTERVAL+2(r15), &STEP_DUE
    add DIF(r15), INTERVAL(r15)
    addc DIF+2(r15), INTERVAL+2(r15)
    mov.b &PINS_IN, r14
    xor.b &IDLE, r14
    and.b &WATCH, r14
    jeq 4f
    call #path_hit
4:  mov #0x0010, &EVENT_CCTL
    lasts PATH_PULSE
    /* a move keeps the flags */
    bit MASK(r15), EVENTS(r15)
    all_rest
    jne 7f
    mov &STEP_RISE, r14
    add INC(r15), &ACC
    addc INC+2(r15), &ACC+2
    jnc 5f
    mov r14, &X_CCTL
    add &SENSE, &COUNT
5:  add INC+4(r15), &ACC+4
    addc INC+6(r15), &ACC+6
    jnc 6f
    mov r14, &Y_CCTL
    add &SENSE+2, &COUNT+2
6:  add INC+8(r15), &ACC+8
    addc INC+10(r15), &ACC+10
    jnc 7f
    mov r14, &Z_CCTL
    add &SENSE+4, &COUNT+4
7:
    .if \turns
    mov.b &DIR_OUT, r14
    xor.b DIRS(r15), r14
    and.b #{all_dirs}, r14
    jeq path_armed
    push r14
    waits {hold}-18
    pop r14
    xor.b r14, &DIR_OUT
    mov &COUNTER, r14
    add &STEP_SETUP, r14
    cmp r14, &STEP_DUE
    jn 5f
    jmp path_armed
5:  mov r14, &STEP_DUE
    jmp path_armed
    .endif
    .endm

    .section .text.step,"ax",@progbits
module.motion.step:
    .global pasapas_event
pasapas_event:
    br &VECTOR

    /* long pulse, first half: the pins have just become active, let them end in WIDTH ticks */
    .global pasapas_path_long
pasapas_path_long:
    push r14
    mov &STEP_DUE, r14
    add &WIDTH, r14
    mov r14, &X_CCR
    mov r14, &Y_CCR
    mov r14, &Z_CCR
    mov r14, &EVENT_CCR
    mov &STEP_FALL, r14
    mov r14, &X_CCTL
    mov r14, &Y_CCTL
    mov r14, &Z_CCTL
    mov #0x0010, &EVENT_CCTL
    mov #pasapas_path_fallen, &VECTOR
    /* past already, as behind another interrupt: the compare would not come before 2.6 ms */
    mov &EVENT_CCR, r14
    sub &COUNTER, r14
    pop r14
    jn pasapas_path_fallen
    reti
pasapas_path_fallen:
    mov #pasapas_path_long, &VECTOR

    /* an event of a path: the pins have just become active (or have ended again) */
    .global pasapas_path_event
pasapas_path_event:
    push r15
    push r14
    mov &CURRENT, r15
    dec EVENTS(r15)
    jnc path_switch
path_schedule:
    plays 0
    /* All are armed, and every compare register still holds a time that has passed. They get the next one together,
       unless it is too near: then all axes have their event somewhat later. No event can come between two of them. */
path_armed:
    mov &STEP_DUE, r14
    sub &COUNTER, r14
    cmp #MARGIN, r14
    jl path_late
    mov &STEP_DUE, r14
path_go:
    mov r14, &X_CCR
    mov r14, &Y_CCR
    mov r14, &Z_CCR
    mov r14, &EVENT_CCR
    pop r14
    pop r15
    reti

path_late:
    inc &LATE
    mov &COUNTER, r14
    add #DELAY, r14
    mov r14, &STEP_DUE
    jmp path_go

    /* An input answered at the step just made. The slot goes on, or all of them are given up. */
path_hit:
    mov.b r14, &HIT
    clr.b &WATCH
    mov &COUNT, &CAUGHT
    mov &COUNT+2, &CAUGHT+2
    mov &COUNT+4, &CAUGHT+4
    tst.b &HALT
    jne 1f
    ret
1:  incd r1
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
    jnc 4f
    mov #-1, &SENSE+4
4:  plays 1

path_empty:
    clr EVENTS(r15)
path_stop:
    lasts PATH_STOP_PULSE
    all_rest
    clr &EVENT_CCTL
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
    push r14
    mov single_states-2*{first}(r13), r15
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
    mov &ONE_REST, EVENT_CCTL(r13)
    /* an event that is near, or has passed meanwhile, comes later: STEP is low long enough */
    mov EVENT_CCR(r13), r14
    sub &COUNTER, r14
    cmp #ONE_MARGIN, r14
    jl single_late
single_ready:
    bit MASK(r15), EVENTS(r15)
    jne single_exit
    mov &ONE_RISE, EVENT_CCTL(r13)
    add SENSE-2*{first}(r13), COUNT-2*{first}(r13)
single_exit:
    pop r14
    pop r13
    pop r15
    reti

single_late:
    inc &LATE
    mov &COUNTER, r14
    add #ONE_DELAY, r14
    mov r14, EVENT_CCR(r13)
    /* its old time may have passed */
    mov &ONE_REST, EVENT_CCTL(r13)
    jmp single_ready

    /* the output mode that ends a pulse is on: the long pulse is over; else it has just begun */
single_long:
    mov EVENT_CCTL(r13), r14
    and #{modes}, r14
    cmp &STEP_FALL, r14
    jeq 1f
    add &WIDTH, EVENT_CCR(r13)
    mov &ONE_FALL, EVENT_CCTL(r13)
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
    xor SENSE-2*{first}(r13), r14
    tst r14
    jge 1f
    /* another direction: when STEP has ended for {hold} cycles, and STEP_SETUP ticks before the next event, which is
       `interval` behind the compare register */
    lasts ONE_TURN_PULSE
    mov &ONE_REST, EVENT_CCTL(r13)
    waits {hold}
    xor.b single_dir-2*{first}(r13), &DIR_OUT
    mov &COUNTER, r14
    add &STEP_SETUP, r14
    inv SENSE-2*{first}(r13)
    inc SENSE-2*{first}(r13)
    sub INTERVAL+2(r15), r14
    cmp r14, EVENT_CCR(r13)
    jn 2f
    jmp 1f
2:  mov r14, EVENT_CCR(r13)
1:  dec EVENTS(r15)
    jmp single_schedule
single_stop:
    lasts STOP_PULSE
    mov &STEP_REST, EVENT_CCTL(r13)
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
    hold = const STEP_PER_US,
    modes = const MODES,
    cctl = const STEP_CCTL,
    ccr = const STEP_CCR,
    first = const FIRST,
    counter = const STEP_R,
    vector_register = const STEP_IV,
    pins_in = const ports::IN,
    dir_out = const ports::DIR_OUT,
    all_dirs = const DIR[0] | DIR[1] | DIR[2],
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
    due = const offset_of!(Shared, due),
    setup = const offset_of!(Shared, setup),
    rest = const offset_of!(Shared, rest),
    rise = const offset_of!(Shared, rise),
    fall = const offset_of!(Shared, fall),
    one_rest = const offset_of!(Shared, one_rest),
    one_rise = const offset_of!(Shared, one_rise),
    one_fall = const offset_of!(Shared, one_fall),
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
