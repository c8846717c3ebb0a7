/* Motions: from commanded places to what the ramp generator and the step engine need. Each motion
   starts from rest and comes to rest. Twins: `motion::path` for one lone block, `motion::single`.

   The unit of an interpolated motion is the um along its path, an event is a step of the axis with
   most steps; that of a single axis is its step. */

    .section .text.line,"axR",@progbits
module.motion.line:
    /* Takes r12 = axis, TEMP = speed, ramp up, ramp down (scaled, steps/s and steps/s2), none above
       the axis's. From ACTUAL to STEPS. MOVING stays 0 when there is no step to make. The machine
       rests. No register is kept. */
    .global axis_begin
axis_begin:
    mov #-1, r13
    rla r12
    jne line_begin
    inc r12

    /* Takes r12 = a bit for each axis to move, r13 = 1 for a rapid move. From ACTUAL to STEPS in a
       line, at FEED (0: as fast as the axes can). MOVING stays 0 when there is no step to make. The
       machine rests. No register is kept. */
    .global line_begin
line_begin:
    mov r12, r10
    mov r13, r4
    /* INC = distances, LEFT = the longest, TICK = length^2, NOMINAL2 = the same in steps */
    clr r12
    clr r13
    call #formula
    F store LEFT
    F store TICK
    F store NOMINAL2, LAST
    clr r8
    mov #1, r7
1:  call #axis_at
    clr INC(r8)
    clr INC+2(r8)
    bit r7, r10
    jeq 4f
    call #formula
    F load STEPS, AXIS
    F sub ACTUAL, AXIS
    F store ACC, AXIS
    FA abs
    F store INC, AXIS, LAST
    bis r12, r13
    tst r13
    jeq 4f
    bis.b r7, &MOVING
    bic.b r7, &NEGATIVE
    mov A_FLAGS(r9), r6
    tst ACC+2(r8)
    jge 2f
    bis.b r7, &NEGATIVE
    xor #AXIS_INVERT, r6
2:  mov.b line_dirs-1(r7), r15
    bis.b r15, &P2OUT
    bit #AXIS_INVERT, r6
    jeq 3f
    bic.b r15, &P2OUT
3:  call #formula
    F load INC, AXIS
    F most LEFT
    F store LEFT
    F load INC, AXIS, NEW
    F store V2
    F times V2
    F plus NOMINAL2
    F store NOMINAL2
    F load V2
    FR times A_UM, SHORT, NEW
    FR over A_STEPS, SHORT, NEW
    F store V2
    F times V2
    F plus TICK
    F store TICK, LAST
4:  clr ACC(r8)
    mov #1<<15, ACC+2(r8)
    mov r8, r15
    rra r15
    mov ACTUAL(r8), COUNT(r15)
    bit.b r7, &NEGATIVE
    jeq 5f
    inv COUNT(r15)
    inc COUNT(r15)
5:  add #4, r8
    rla r7
    cmp #8, r7
    jne 1b
    tst.b &MOVING
    jeq line_end

    /* TICK = length; the lowest limits along the path: speed, ramps in TEMP, start rate. A single
       axis has the length of its steps and limits already. */
    mov #-1, r12
    mov #-1, r13
    call #formula
    F store START2, LAST
    tst r4
    jn 1f
    call #formula
    F store TEMP
    F store TEMP+4
    F store TEMP+8
    F load TICK
    FA root, LAST
    jmp 2f
1:  call #formula
    F load LEFT, NEW, LAST
2:  call #formula
    F store TICK, LAST
    clr r8
3:  call #axis_bit
    bit.b r12, &MOVING
    jeq 4f
    call #axis_at
    call #formula
    /* V2 = path for each step of the axis */
    F load INC, AXIS, NEW
    F store V2
    F load TICK
    F over V2
    F store V2
    FR times A_TOP_RATE, LONG, NEW
    F least TEMP
    F store TEMP
    F load V2
    FR times A_ACCEL, LONG, NEW
    F least TEMP+4
    F store TEMP+4
    F load V2
    FR times A_DECEL, LONG, NEW
    F least TEMP+8
    F store TEMP+8
    FN int 1
    FA new
    FR most A_START_RATE, SHORT, NEW
    F times V2
    F least START2
    F store START2
    F load INC, AXIS, LAST
    mov &LEFT, r14
    mov &LEFT+2, r15
    call #pasapas_fraction
    call #formula
    F store INC, AXIS, LAST
4:  add #4, r8
    cmp #12, r8
    jne 3b

    tst r4
    jne 6f
    call #formula
    F load NOMINAL2
    FA root
    F store NOMINAL2
    F load FEED
    FA abs
    FA new, LAST
    tst r13
    jeq 6f
    tst &FEED+2
    jge 5f
    /* steps/s along the path */
    call #formula
    F times TICK
    F over NOMINAL2, LAST
5:  call #formula
    F least TEMP
    F store TEMP, LAST

    /* TICK = pitch, units for each event; the planner's memory */
6:  call #formula
    F load LEFT, NEW
    F store V2
    F load TICK
    F over V2
    F store TICK
    /* twice the ramps, less 1/32 */
    FN int 31
    FA new
    F times TICK
    FN shift, -4
    F store ACCEL2
    F times TEMP+8
    F store DECEL2
    F load ACCEL2
    F times TEMP+4
    F store ACCEL2
    F load TEMP
    F times TEMP
    F store NOMINAL2
    F load START2
    F times START2
    F store START2
    F least NOMINAL2
    F store V2
    FA root
    F store V
    /* 16 MHz = 125 * 125 * 1024 */
    FN int 125
    FA new
    F store TEMP
    F times TEMP
    FN shift 10
    F times TICK
    F store TICK, LAST
line_end:
    ret
line_dirs:
    .byte P2_DIR_X, P2_DIR_Y, 0, P2_DIR_Z

    /* Folds the engine's counts into ACTUAL, fills a free slot, ends the motion. At least every
       30 000 steps. No register is kept. */
    .global motion_poll
motion_poll:
    tst.b &MOVING
    jeq line_end
    mov &STEP_SLOT, r6
    xor #OTHER_SLOT, r6
    tst EVENTS(r6)
    jne 1f
    call #segment
    jnc 1f
    bit #CCIE, &TA1CCTL0
    jne 1f
    /* it rests: the first interrupt leaves the slot before and begins this one */
    xor #OTHER_SLOT, r6
    mov r6, &STEP_SLOT
    mov &TA1R, r12
    add #LEAD, r12
    mov r12, &TA1CCR0
    mov #CCIE, &TA1CCTL0
    /* what it has counted is all when it rests already */
1:  mov &TA1CCTL0, r5
    mov #8, r8
2:  mov r8, r13
    rra r13
    mov COUNT(r13), r13
    call #counted
    sub #4, r8
    jge 2b
    bit #CCIE, r5
    jne line_end
    bit.b #M_STOP, &MOTION
    jne 3f
    tst &LEFT
    jne line_end
    tst &LEFT+2
    jne line_end
3:  clr.b &MOVING
    /* M_STOP or M_SETTLE */
    cmp.b #M_STOP, &MOTION
    jlo line_end
    and.b #M_PAUSE, &MOTION
motion_settle:
    br #settle_all

    /* r13:r12 and ACTUAL = where axis r8 was when the watched input answered; the next poll brings
       ACTUAL up to date. Uses r11, r14, r15. */
    .global motion_caught
motion_caught:
    mov &CAUGHT, r13
    /* Takes r13 = what the engine counted for axis r8: r13:r12 and ACTUAL = the position. It counts
       upward from the low half of the position, or of its negative. */
counted:
    call #axis_bit
    bit.b r12, &NEGATIVE
    mov r13, r12
    jeq 1f
    inv r12
    inc r12
1:  mov #-1, r13
    sub ACTUAL(r8), r12
    jn 2f
    clr r13
2:  call #formula
    F add ACTUAL, AXIS
    F store ACTUAL, AXIS, LAST
    ret

    /* Ramps down and forgets the rest, also of a pause. */
    .global motion_stop
motion_stop:
    mov.b #M_STOP, &MOTION
    tst.b &MOVING
    jne 1f
    clr.b &MOTION
1:  ret

    /* Z when no step comes any more: the motion has ended, or rests in a pause. Uses r12. */
    .global motion_rests
motion_rests:
    bit #CCIE, &TA1CCTL0
    jne 1f
    tst.b &MOVING
    jeq 1f
    bit.b #M_PAUSE|M_STOP, &MOTION
    subc r12, r12
1:  ret

    /* The probe or switch answered when axis r12 was at r15:r14: an axis no faster than its start
       rate stands still at once, a faster one ramps down to a place that depends on that position
       and the speed alone. Then the commanded place is where it stands. No register is kept. */
    .global motion_hit
motion_hit:
    rla r12
    rla r12
    mov r12, r8
    mov r14, r12
    mov r15, r13
    call #formula
    F sub STEPS, AXIS
    FA abs
    F store TEMP+8
    F load START2
    F sub NOMINAL2, LAST
    tst r13
    jge motion_halt
    /* half v^2 / d, and 24 ms for the main loop's round and what the engine holds, and one */
    call #formula
    FN int 31
    FA new
    FN shift, -4
    F store TEMP
    F load DECEL2
    F over TEMP
    F store TEMP
    F load NOMINAL2
    F over TEMP
    FN shift, -1
    F store TEMP
    F load NOMINAL2
    FA root
    F store TEMP+4
    FN int 24
    FA new
    F times TEMP+4
    FN shift, -10
    F plus TEMP
    FA floor
    F sub TEMP+8, LAST
    add #1, r12
    adc r13
    bis.b #M_SETTLE, &MOTION
    tst r13
    jge 1f
    /* what is left less what is not to be made of it */
    call #formula
    F add LEFT, LAST
    tst r13
    jn motion_stop
    call #formula
    F store LEFT, LAST
1:  ret

    /* Steps cease at once: none after the next event, which is armed already and at most 2 ms away.
       The rest is forgotten, the commanded places are where the axes stand. No register is kept. */
    .global motion_halt
motion_halt:
    tst.b &MOVING
    jeq motion_settle
    clr &SLOT0+EVENTS
    clr &SLOT1+EVENTS
    clr &LEFT
    clr &LEFT+2
    mov.b #M_STOP, &MOTION
1:  bit #CCIE, &TA1CCTL0
    jne 1b
    br #motion_poll

    /* Speed of axis r12: 0. */
    .global motion_speed
motion_speed:
    clr r12
    clr r13
    ret
