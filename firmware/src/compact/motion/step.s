/* The step engine: Timer1_A raises the STEP edges, its interrupt plays segments.

   Timer1_A runs freely at 16 MHz and its three outputs are the STEP pins. When an event is due the
   hardware raises the pins that were armed for it and the interrupt begins: it schedules the next
   event, drops the pins, looks at the watched inputs and arms the axes that step next. Latency is
   therefore no jitter as long as the next event is armed in time; a late one is counted and
   postponed, never lost. Each axis adds its increment to an accumulator and steps on the carry.

   A pulse longer than the interrupt takes (WIDTH, profiles above 3 us) needs a second interrupt: the
   first one lets the hardware drop the pins WIDTH ticks after the edge.

   Cycles from entry to RETI: three axes stepping 169, two 158, one 147; at a segment change 16
   more, while an input is watched 18 more. 8 bytes of stack. */
    .set P1IN,     0x0020
    .set P2OUT,    0x0029
    .set P2SEL,    0x002e
    .set TA1CTL,   0x0180
    .set TA1CCTL0, 0x0182
    .set TA1CCTL1, 0x0184
    .set TA1CCTL2, 0x0186
    .set TA1R,     0x0190
    .set TA1CCR0,  0x0192
    .set TA1CCR1,  0x0194
    .set TA1CCR2,  0x0196
    .set CCIE,     0x0010
    /* output modes 0 (low), 1 (set), 5 (reset) */
    .set ARMED,    0x0020
    .set FALLS,    0x00a0
    /* offsets in a slot; the engine looks at the others once EVENTS is not 0 */
    .set INTERVAL, 0
    .set CHANGE,   4
    .set EVENTS,   8
    .set MASK,     10
    .set OTHER_SLOT, SLOT0^SLOT1

    .section .text.step,"axR",@progbits
module.motion.step:
    .global TIMER1_A0
TIMER1_A0:
    br &STEP_VECTOR

    /* long pulse, first half: the pins have just risen, let them fall in WIDTH ticks */
step_long:
    add &WIDTH, &TA1CCR0
    mov &TA1CCR0, &TA1CCR1
    mov &TA1CCR0, &TA1CCR2
    mov #CCIE|FALLS, &TA1CCTL0
    mov #FALLS, &TA1CCTL1
    mov #FALLS, &TA1CCTL2
    mov #step_fallen, &STEP_VECTOR
    /* past already, as behind another interrupt: the compare would not come before 4 ms */
    cmp &TA1R, &TA1CCR0
    jn step_fallen
    reti
step_fallen:
    mov #step_long, &STEP_VECTOR
    sub &WIDTH, &TA1CCR0

    /* an event: the pins have just risen (or fallen again) */
step_event:
    push r15
    push r14
    mov &STEP_SLOT, r15
    dec EVENTS(r15)
    jnc step_switch
step_schedule:
    add @r15, &STEP_FRAC
    addc INTERVAL+2(r15), &TA1CCR0
    mov &TA1CCR0, r14
    mov r14, &TA1CCR1
    mov r14, &TA1CCR2
    add CHANGE(r15), INTERVAL(r15)
    addc CHANGE+2(r15), INTERVAL+2(r15)
    mov #CCIE, &TA1CCTL0
    clr &TA1CCTL1
    clr &TA1CCTL2
    tst.b &WATCH
    jne step_watch
step_arm:
    bit MASK(r15), EVENTS(r15)
    jne step_armed
    add &INC, &ACC
    addc &INC+2, &ACC+2
    jnc 1f
    mov #CCIE|ARMED, &TA1CCTL0
    inc &COUNT
1:  add &INC+4, &ACC+4
    addc &INC+6, &ACC+6
    jnc 2f
    mov #ARMED, &TA1CCTL1
    inc &COUNT+2
2:  add &INC+8, &ACC+8
    addc &INC+10, &ACC+10
    jnc step_armed
    mov #ARMED, &TA1CCTL2
    inc &COUNT+4
step_armed:
    sub &TA1R, r14
    cmp #4, r14
    jge step_exit

    /* the next event is due already: 64 ticks from now */
    inc &LATE
    mov &TA1R, r14
    add #64, r14
    mov r14, &TA1CCR0
    mov r14, &TA1CCR1
    mov r14, &TA1CCR2
step_exit:
    pop r14
    pop r15
    reti

    /* an input may answer at the step just made */
step_watch:
    push r14
    mov.b &P1IN, r14
    xor.b &IDLE, r14
    and.b &WATCH, r14
    jeq 1f
    mov.b r14, &HIT
    clr.b &WATCH
    mov.b &N, r14
    rla r14
    mov COUNT(r14), &CAUGHT
1:  pop r14
    jmp step_arm

    /* the slot is played: the other one, or rest */
step_switch:
    clr EVENTS(r15)
    xor #OTHER_SLOT, r15
    mov r15, &STEP_SLOT
    dec EVENTS(r15)
    jc step_schedule
    clr EVENTS(r15)
    clr &TA1CCTL0
    clr &TA1CCTL1
    clr &TA1CCTL2
    jmp step_exit

    /* Starts the timer, gives it the STEP pins and takes the pulse from the board's profile.
       Uses r12, r13. */
    .global step_init
step_init:
    /* a reset by the watchdog leaves the timer's registers as they were */
    clr &TA1CCTL0
    clr &TA1CCTL1
    clr &TA1CCTL2
    bis.b #P2_STEP, &P2SEL
    /* SMCLK, continuous, cleared */
    mov #0x0224, &TA1CTL
    mov #SLOT0, &STEP_SLOT
    mov #step_event, &STEP_VECTOR
    mov &BOARD, r12
    mov.b B_PULSE(r12), r12
    /* a short pulse lasts until the interrupt drops it, 53 cycles (3.3 us) at least */
    cmp #4, r12
    jlo 1f
    mov #step_long, &STEP_VECTOR
    /* us in ticks */
    rla r12
    rla r12
    rla r12
    rla r12
    mov r12, &WIDTH
1:  ret
