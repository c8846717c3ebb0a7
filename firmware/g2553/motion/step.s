/* The step engine: Timer1_A raises the STEP edges, its interrupt plays segments.

   Timer1_A runs freely at 16 MHz and its three outputs are the STEP pins. When an event is due the
   hardware raises the pins that were armed for it and the interrupt begins: it schedules the next
   event, drops the pins, looks at the watched inputs and arms the axes that step next. Latency is
   therefore no jitter as long as the next event is armed in time; a late one is postponed, never
   lost, and not counted: no word of RAM is left for it. Each axis adds its increment to an accumulator and steps on the
   carry: Bresenham's line, as in grbl's stepper interrupt, with 2^32 for the number of events, so that nothing is divided
   or compared.

   The time of an event is the compare register with STEP_FRAC below it, 1/65536 ticks: adding the interval there loses
   nothing, and the sum of all intervals of a segment is its duration to the last bit. The interval itself changes by
   CHANGE after each event. MASK makes sub-events: an event steps only when the events left are a multiple of MASK + 1.

   A pulse longer than the interrupt takes (WIDTH, profiles above 3 us) needs a second interrupt: the
   first one lets the hardware drop the pins WIDTH ticks after the edge.

   Cycles from entry to RETI: three axes stepping 164, two 153, one 142; at a segment change 16
   more, while an input is watched 16 more. 6 bytes of stack, 8 as it comes to rest.

   Where a line of a course begins, whose segment MASK's top bit marks, the pins fall, and then increments, counts and
   directions change at once, by what the planner has left in NEXT_: 130 cycles more. */
    /* the engine looks at a slot's other fields once EVENTS is not 0 */
    .set OTHER_SLOT, SLOT1-SLOT0

    .section .text.step,"axR",@progbits
module.motion.step:
    .global TIMER1_A0
TIMER1_A0:
    tst &WIDTH
    jeq step_event
    bit #FALLS^ARMED, &TA1CCTL0
    jne step_fallen
    /* long pulse, first half: the pins have just risen, let them fall in WIDTH ticks */
    add &WIDTH, &TA1CCR0
    mov &TA1CCR0, &TA1CCR1
    mov &TA1CCR0, &TA1CCR2
    mov #CCIE|FALLS, &TA1CCTL0
    mov #FALLS, &TA1CCTL1
    mov #FALLS, &TA1CCTL2
    /* past already, as behind another interrupt: the compare would not come before 4 ms */
    cmp &TA1R, &TA1CCR0
    jn step_fallen
    reti
step_fallen:
    sub &WIDTH, &TA1CCR0

    /* an event: the pins have just risen (or fallen again) */
step_event:
    push r15
    mov &STEP_SLOT, r15
    dec SLOT0+EVENTS(r15)
    jnc step_switch
step_schedule:
    add SLOT0(r15), &STEP_FRAC
    addc SLOT0+INTERVAL+2(r15), &TA1CCR0
    add SLOT0+CHANGE(r15), SLOT0+INTERVAL(r15)
    addc SLOT0+CHANGE+2(r15), SLOT0+INTERVAL+2(r15)
    /* X's pin first: it is armed again 42 cycles later, and may rise at once when that is due by then */
    mov #CCIE, &TA1CCTL0
    tst.b &WATCH
    jne step_watch
step_arm:
    clr &TA1CCTL1
    clr &TA1CCTL2
    bit SLOT0+MASK(r15), SLOT0+EVENTS(r15)
    jne step_armed
    mov #INC, r15
    add @r15+, &ACC
    addc @r15+, &ACC+2
    jnc 1f
    mov #CCIE|ARMED, &TA1CCTL0
    inc &COUNT
1:  add @r15+, &ACC+4
    addc @r15+, &ACC+6
    jnc 2f
    mov #ARMED, &TA1CCTL1
    inc &COUNT+2
2:  add @r15+, &ACC+8
    addc @r15+, &ACC+10
    jnc step_armed
    mov #ARMED, &TA1CCTL2
    inc &COUNT+4
    /* the other axes step at the time of the first */
step_armed:
    mov &TA1CCR0, r15
    mov r15, &TA1CCR1
    mov r15, &TA1CCR2
    sub &TA1R, r15
    cmp #4, r15
    jge step_exit

    /* The event is due already: 32 ticks from now. Its compare may have come between two of the axes: the flag that it has
       left would bring the next interrupt at once, which would take back the pins that are armed but not yet up, while
       COUNT has their steps. */
    mov &TA1R, r15
    add #32, r15
    mov r15, &TA1CCR0
    bic #1, &TA1CCTL0
    jmp step_armed

    /* an input may answer at the step just made */
step_watch:
    bit.b #WATCH_ENDS, &WATCH
    jne step_ends
    mov.b &P1IN, r15
    xor.b &IDLE, r15
    and.b &WATCH, r15
    jeq 1f
    mov.b r15, &HIT
    mov.b &IDLE, &WATCH
    and.b #WATCH_ENDS, &WATCH
    mov.b &N, r15
    rla r15
    mov COUNT(r15), &CAUGHT
    jmp step_watch
1:  mov &STEP_SLOT, r15
    jmp step_arm

    /* the slot is played: the other one, or rest */
step_switch:
    clr SLOT0+EVENTS(r15)
    xor #OTHER_SLOT, r15
    mov r15, &STEP_SLOT
    dec SLOT0+EVENTS(r15)
    .if HAS_COURSES
    jnc 2f
    tst SLOT0+MASK(r15)
    jge step_schedule
    /* the next line of a course begins, at speed: the pins fall before directions change */
    call #step_rest
    mov #16, r15
1:  xor NEXT_COUNT(r15), COUNT(r15)
    decd r15
    jge 1b
    mov &STEP_SLOT, r15
    xor.b &NEXT_DIRS, &NEGATIVE
    xor.b &NEXT_DIRS+1, &P2OUT
    bic.b #M_NEXT, &MOTION
    jmp step_schedule
2:  clr SLOT0+EVENTS(r15)
    /* Out of a speed from which no axis may stop: the next line of the course came too late. Where the axes
       are nobody knows then. */
    bit.b #M_THROUGH|M_NEXT, &MOTION
    jeq step_ends
    cmp &V2+2, &START2+2
    jhs step_ends
    mov.b #TRIPPED, &WATCH
    /* F14 is an emergency stop's, too: the run in which it was this */
    mov.b &RUNS, &MISSED+1
    .else
    jc step_schedule
    clr SLOT0+EVENTS(r15)
    .endif
step_ends:
    call #step_rest
step_exit:
    pop r15
    reti

    /* An emergency stop at a pin has opened: the step that is armed is the last one. A pin that does not
       answer any more is a disturbance. */
    .global PORT1
PORT1:
    push r15
    clr.b &P1IFG
    mov.b &P1IN, r15
    xor.b &P1IES, r15
    and.b &P1IE, r15
    jeq step_exit
    mov.b #TRIPPED, &WATCH
    jmp step_exit

    /* Starts the timer, gives it the STEP pins and takes the pulse from the board's profile. Uses
       r12. */
    .global step_init
step_init:
    mov &BOARD, r12
    mov.b B_PULSE(r12), r12
    /* a short pulse lasts until the interrupt drops it, 48 cycles (3 us) at least */
    cmp #4, r12
    jlo 1f
    /* us in ticks */
    rla r12
    rla r12
    rla r12
    rla r12
    mov r12, &WIDTH
    /* SMCLK, continuous, cleared */
1:  mov #0x0224, &TA1CTL
    /* The pins are low before the timer has them: a reset by the watchdog leaves its registers as they
       were. */
step_rest:
    clr &TA1CCTL0
    clr &TA1CCTL1
    clr &TA1CCTL2
    bis.b #P2_STEP, &P2SEL
    ret
