/* Motions: from commanded places to what the ramp generator and the step engine need. Each motion
   starts from rest and comes to rest. Twins: `motion::path` for one lone block, `motion::single`.

   The unit of an interpolated motion is the um along its path, with a feed in steps/s the step along
   it; an event is a step of the axis with most steps. The unit of a single axis is its step. */

    .section .text.line,"axR",@progbits
module.motion.line:
    /* steps of each axis while a line is planned, in numbers that come last */
    .set DISTANCE, NEW_STEPS
    /* line_begin, rapid. */
line_rapid:
    mov #1, r13
    jmp line_begin

    /* Takes r12 = bit of the axis, TEMP = speed, ramp up, ramp down (scaled, steps/s and steps/s2),
       none above the axis's. From ACTUAL to STEPS. MOVING stays 0 when there is no step to make. The
       machine rests. No register is kept. */
    .global axis_begin
axis_begin:
    mov #LONE, r13

    /* Takes r12 = a bit for each axis to move, r13 = 1 for a rapid move. From ACTUAL to STEPS in a
       line, at FEED (0: as fast as the axes can). MOVING stays 0 when there is no step to make. The
       machine rests. No register is kept. */
    .global line_begin
line_begin:
    mov.b r13, &HIT
    mov.b r12, &MOVING
    /* nothing is watched yet, unless the emergency stop has answered; INC = distances, LEFT = the
       longest, TICK = length^2 */
    MICRO
    IF_IS WATCH, TRIPPED&255, 1f
    LET WATCH, 0
1:  LIT 0
    F store LEFT
    F store TICK
    DO axis_select
1:  DO axis_at
    LIT 0
    F store DISTANCE, AXIS
    IF_NOT_AXIS MOVING, 4f
    F load STEPS, AXIS
    F sub ACTUAL, AXIS
    DO test_long
    IF_EQUAL 3f
    CALL line_direction
    DO abs
    F store DISTANCE, AXIS
    F most LEFT
    F store LEFT
    F load DISTANCE, AXIS, NEW
    IF_ANY FEED+3, 0x80, 2f
    FR times A_UM, SHORT, NEW
    FR over A_STEPS, SHORT, NEW
2:  F store CAUGHT
    F times CAUGHT
    F plus TICK
    F store TICK
    GOTO 4f
3:  DO axis_bit
    AXIS_OFF MOVING
4:  UP_AXIS 1b
    IF_SET MOVING, 1f
    RETURN

    /* TICK = length; the lowest limits along the path: speed, ramps in TEMP, start rate. A single
       axis has the length of its steps and limits already. */
1:  IF_IS HIT, LONE&255, 1f
    DO scaled_most
    F store TEMP
    F store TEMP+4
    F store TEMP+8
    F load TICK
    DO root
    GOTO 2f
1:  F load LEFT, NEW
2:  F store TICK
    DO scaled_most
    F store V
    LIT 0
    DO axis_select
3:  IF_NOT_AXIS MOVING, 4f
    DO axis_at
    /* CAUGHT = path for each step of the axis */
    F load TICK
    F over DISTANCE, AXIS, NEW
    F store CAUGHT
    FR times A_TOP_RATE, LONG, NEW
    F bound TEMP
    F load CAUGHT
    FR times A_ACCEL, LONG, NEW
    F bound TEMP+4
    F load CAUGHT
    FR times A_DECEL, LONG, NEW
    F bound TEMP+8
    LIT 1
    DO new
    FR most A_START_RATE, SHORT, NEW
    F times CAUGHT
    F bound V
4:  F load DISTANCE, AXIS
    CALL line_fraction
    .if HAS_COURSES
    IF_NONE MOTION, M_NEXT, 5f
    CALL line_change
    F store NEXT_INC, AXIS
    GOTO 6f
5:
    .endif
    F store INC, AXIS
    CALL line_origin
6:  UP_AXIS 3b

    F load TEMP
    F store CAUGHT
    DO motion_nominal

    /* TICK = pitch, units for each event; the planner's memory */
    F load TICK
    F over LEFT, NEW
    F store TICK
    /* twice the ramps, less 1/32 */
    LIT 31
    DO new
    F times TICK
    SHIFT -4
    F store ACCEL2
    F times TEMP+8
    F store DECEL2
    F load ACCEL2
    F times TEMP+4
    F store ACCEL2
    F load V
    F times V
    .if HAS_COURSES
    /* at the speed of the line before, and to rest as slowly as either wants it */
    IF_NONE MOTION, M_NEXT, 5f
    F bound START2
    F load V2
    GOTO 6f
5:
    .endif
    F store START2
    F least NOMINAL2
    F store V2
6:  DO root
    F store V
    DO ticks_a_second
    F times TICK
    F store TICK
    .if HAS_COURSES
    BITS_OFF MOTION, M_THROUGH
    IF_NONE MOTION, M_COURSE, 9f
    F load LEFT, NEW
    F times DECEL2
    F store TEMP
    F load EXIT2
    F minus TEMP
    CALL course_line
    F load START2
    F sub EXIT2
    IF_CARRY 9f
    BITS_ON MOTION, M_THROUGH
9:
    .endif
    RETURN
    .balign 2, 0

    /* NOMINAL2 from CAUGHT, the speed that the axes can or that a single one is to have, the feed and
       the override; homing and probing have none. Uses r8, r9, TEMP. */
    ROUTINE_ODD motion_nominal, module.motion.line
    GET EFFECT
    ADDI -OP_PROBE
    CMPI OP_HOME_QUERY-OP_PROBE+1
    IF_CARRY 1f
    LIT 100
    GOTO 2f
1:  GET OVERRIDE
    IF_IS_NOT HIT, 1, 2f
    GET OVERRIDE+1
2:  DO new
    F store TEMP
    LIT 100
    DO new
    F store NOMINAL2
    F load TEMP
    F over NOMINAL2
    F store TEMP
    IF_SET HIT, 3f
    F load FEED
    DO abs
    DO new
    DO test_long
    IF_EQUAL 3f
    F least CAUGHT
    GOTO 4f
3:  F load CAUGHT
4:  F times TEMP
    IF_IS HIT, LONE&255, 5f
    F least CAUGHT
    GOTO 6f
5:  F store TEMP
    DO axis_n
    FR load A_TOP_RATE, LONG, NEW
    F least TEMP
6:  F store TEMP
    F times TEMP
    F store NOMINAL2
    RETURN
    .balign 2, 0

    /* 16 MHz, scaled */
ticks_a_second:
    mov #0x2400, r12
    mov #0x80f4, r13
line_end:
    ret

    .if HAS_COURSES
    /* A line of a course is planned: EXIT2, which becomes r13:r12 where its entry falls. Uses r11 to r15. */
course_line:
    mov &COURSE_LINES, r14
    cmp #2, r14
    jhs 1f
    /* an entry begins: twice its lines, the upper half of a bound */
    mov &COURSE_AT, r15
    mov.b @r15+, r14
    clr r12
    mov.b @r15+, r13
    mov.b @r15+, r11
    swpb r11
    bis r11, r13
    mov r15, &COURSE_AT
    tst r14
    jne 2f
    bic.b #M_COURSE, &MOTION
    clr r13
    /* bit 0: it does not fall */
1:  bit #1, r14
    jne 3f
2:  mov r12, &EXIT2
    mov r13, &EXIT2+2
3:  decd r14
    mov r14, &COURSE_LINES
    ret

    /* r13:r12 = how it differs from what an event adds to the accumulator of the axis r8 */
line_change:
    xor INC(r8), r12
    xor INC+2(r8), r13
    ret

    /* The next line's part of line_direction. */
line_next:
    bit.b r12, &NEGATIVE
    subc r14, r14
    xor r13, r14
    jn 3f
    bis.b r12, &NEXT_DIRS
    bis.b line_dirs-1(r12), &NEXT_DIRS+1
    mov r8, r14
    rra r14
    mov #-1, NEXT_COUNT(r14)
    jmp 3f
    .endif

    /* The axis r8 goes the way of r13:r12: NEGATIVE, its DIR pin. Uses r11, r14. */
line_direction:
    push r12
    call #axis_bit
    .if HAS_COURSES
    bit.b #M_NEXT, &MOTION
    jne line_next
    .endif
    bic.b r12, &NEGATIVE
    mov A_FLAGS(r9), r14
    tst r13
    jge 2f
    bis.b r12, &NEGATIVE
    xor #AXIS_INVERT, r14
2:  mov.b line_dirs-1(r12), r11
    bis.b r11, &P2OUT
    bit #AXIS_INVERT, r14
    jeq 3f
    bic.b r11, &P2OUT
3:  pop r12
    ret

    /* Accumulator and count of the axis r8 as a motion begins. Uses r12, r13. */
line_origin:
    clr ACC(r8)
    mov #1<<15, ACC+2(r8)
    call #axis_bit
    mov r8, r13
    rra r13
    mov ACTUAL(r8), COUNT(r13)
    bit.b r12, &NEGATIVE
    jeq line_end
    inv COUNT(r13)
    ret

    /* r13:r12 times 2^32 over LEFT */
line_fraction:
    mov &LEFT, r14
    mov &LEFT+2, r15
    br #pasapas_fraction
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
    tst SLOT0+EVENTS(r6)
    jne 1f
    call #segment
    jnc 1f
    call #motion_rests
    jne 1f
    /* it rests: the first interrupt begins the slot, leaving the one before if it stands there */
    mov &TA1R, r12
    add #LEAD, r12
    mov r12, &TA1CCR0
    mov #CCIE, &TA1CCTL0
    /* what it has counted is all when it rests already */
1:  mov &TA1CCTL0, r5
    mov #8, r8
2:  mov r8, r13
    .if HAS_COURSES
    /* the interrupt changes count and direction at once */
    dint
    .endif
    rra r13
    mov COUNT(r13), r13
    call #counted
    sub #4, r8
    jge 2b
    bit #CCIE, r5
    jne line_end
    MICRO
    IF_ANY MOTION, M_STOP, 3f
    F load LEFT
    DO test_long
    IF_NOT_EQUAL 4f
3:  LET MOVING, 0
    IF_NONE MOTION, M_STOP|M_SETTLE|M_JOG, 4f
    BITS_OFF MOTION, ~M_PAUSE&0xff
motion_settle:
    CALL settle_all
4:  RETURN

    /* Ramps down and forgets the rest, also of a pause. */
    ROUTINE_ODD motion_stop, module.motion.line
    .if HAS_COURSES
    /* the lines of a course come all the same, while it brakes */
    BITS_OFF MOTION, M_PAUSE|M_SETTLE|M_JOG
    BITS_ON MOTION, M_STOP
    .else
    LET MOTION, M_STOP
    .endif
    IF_SET MOVING, 1f
    LET MOTION, 0
1:  RETURN

    /* The probe or switch answered when axis r8 was at r13:r12: an axis no faster than its start
       rate stands still at once, a faster one ramps down to a place that depends on that position
       and the speed alone. Then the commanded place is where it stands. No register is kept. */
    ROUTINE_ODD motion_hit, module.motion.line
    F sub STEPS, AXIS
    DO abs
    F store TEMP+8
    F load START2
    F sub NOMINAL2
    IF_NOT_NEGATIVE motion_halt
    /* half v^2 / d, and 24 ms for the main loop's round and what the engine holds, and one */
    LIT 31
    DO new
    F times NOMINAL2
    F over DECEL2
    SHIFT -5
    F store TEMP
    LIT 9
    DO new
    F times NOMINAL2
    DO root
    SHIFT 3-10
    F plus TEMP
    DO floor
    F sub TEMP+8
    F store TEMP
    BITS_ON MOTION, M_SETTLE
    LIT 1
    F add TEMP
    IF_NOT_NEGATIVE 1f
    /* what is left less what is not to be made of it */
    F add LEFT
    IF_NEGATIVE motion_stop
    F store LEFT
1:  RETURN

    /* Steps cease at once: none after the next event, which is armed already and at most 2 ms away.
       The rest is forgotten, the commanded places are where the axes stand. No register is kept. */
    ROUTINE_ODD motion_halt, module.motion.line
    LIT 0
    .if HAS_COURSES
    /* the step engine takes no offence */
    F store V2
    .endif
    /* at rest, too: the interrupt may have left them */
    F clear SLOT0+EVENTS
    F clear SLOT1+EVENTS
    IF_ZERO MOVING, motion_settle
    F store LEFT
    LET MOTION, M_STOP
1:  DO motion_rests
    IF_NOT_EQUAL 1b
    DO motion_poll
    RETURN
    .balign 2, 0

    /* r13:r12 and ACTUAL = where axis r8 was when the watched input answered; the next poll brings
       ACTUAL up to date. Uses r11, r14, r15. */
    .global motion_caught
motion_caught:
    mov &CAUGHT, r13
    /* Takes r13 = what the engine counted for axis r8: r13:r12 and ACTUAL = the position. It counts
       upward from the low half of the position, or from that half's complement. */
counted:
    call #axis_bit
    bit.b r12, &NEGATIVE
    .if HAS_COURSES
    eint
    .endif
    mov r13, r12
    jeq 1f
    inv r12
1:  mov #-1, r13
    sub ACTUAL(r8), r12
    jn 2f
    clr r13
2:  MICRO
    F add ACTUAL, AXIS
    F store ACTUAL, AXIS
    RETURN
    .balign 2, 0

    /* Z when no step comes any more: the motion has ended, or rests in a pause. */
    .global motion_rests
motion_rests:
    bit #CCIE, &TA1CCTL0
    ret

    /* r13:r12 = speed of axis r12 in steps/s at the end of the segment planned last, negative in
       negative direction, 0 at rest. Keeps r4 to r7. */
    .global motion_speed
    ROUTINE_ODD motion_speed, module.motion.line
    DO axis_select
    DO motion_rests
    IF_NOT_EQUAL 2f
    LIT 0
    RETURN
    /* events/s times the axis's share of them, rounded */
2:  DO ticks_a_second
    F times V
    F over TICK
    F times INC, AXIS, NEW
    SHIFT -32+13
    DO rounded
    IF_NOT_AXIS NEGATIVE, 3f
    DO negate
3:  RETURN

    /* acc = the integer next to scaled acc over 2^13 */
    ROUTINE_ODD rounded, module.motion.line
    F store TEMP
    LIT 1
    DO new
    SHIFT 12
    F plus TEMP
    SHIFT -13
    DO floor
    RETURN
    .balign 2, 0
