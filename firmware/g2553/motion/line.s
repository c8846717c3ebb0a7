/* What the planner leaves to instructions: directions, the engine's accumulators, lines of a course, and the main loop's look at
   a motion. The planner itself is rules/planner.rs, how a motion ends rules/stops.rs. */

    .section .text.line,"axR",@progbits
module.motion.line:
    /* 16 MHz, scaled */
ticks_a_second:
    mov #0x2400, r12
    mov #0x80f4, r13
line_end:
    ret

    .if HAS_COURSES
    /* A line of a course is planned: EXIT2, which becomes r13:r12 where its entry falls. Uses r11 to r15. */
course_line:
    mov &COURSE_AT, r15
    mov &COURSE_LINES, r14
    cmp #2, r14
    jhs 1f
    /* an entry begins: twice its lines, the upper half of a bound */
    mov.b @r15+, r14
    cmp #1, r14
    jne 4f
    .short 0x4ff2, JOINED       /* mov.b @r15+, &JOINED: LLVM's assembler has none */
    mov.b @r15+, r14
4:  clr r12
    mov.b @r15+, r13
    mov.b @r15+, r11
    swpb r11
    bis r11, r13
    mov r15, &COURSE_AT
    jmp 2f
    /* bit 0: it does not fall */
1:  bit #1, r14
    jne 3f
2:  mov r12, &EXIT2
    mov r13, &EXIT2+2
3:  decd r14
    mov r14, &COURSE_LINES
    /* no line of the entry is left, and no entry: the course is over, so that the next one may begin */
    mov.b @r15, r11
    rra r14
    add r14, r11
    jne 5f
    bic.b #M_COURSE, &MOTION
5:  ret

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

    /* The axis r8 goes the way of r13:r12: NEGATIVE, or what changes of it as the next line begins. Uses r11, r14. */
line_direction:
    push r12
    call #axis_bit
    .if HAS_COURSES
    bit.b #M_NEXT, &MOTION
    jne line_next
    .endif
    bic.b r12, &NEGATIVE
    tst r13
    jge 3f
    bis.b r12, &NEGATIVE
3:  pop r12
    ret

    /* Accumulator, count and DIR pin of the axis r8 as a motion begins from rest: also of one that makes no step, as a later
       line of a course changes what the pin is. Takes r9, its record; uses r11 to r14. */
line_origin:
    clr ACC(r8)
    mov #1<<15, ACC+2(r8)
    call #axis_bit
    mov r8, r13
    rra r13
    mov ACTUAL(r8), COUNT(r13)
    .if A_FLAGS
    .error "flags are an axis's first word"
    .endif
    mov @r9, r14
    bit.b r12, &NEGATIVE
    jeq 1f
    inv COUNT(r13)
    xor #AXIS_INVERT, r14
1:  mov.b line_dirs-1(r12), r11
    bis.b r11, &P2OUT
    bit #AXIS_INVERT, r14
    jeq line_end
    bic.b r11, &P2OUT
    ret

    /* r13:r12 times 2^32 over LEFT */
line_fraction:
    mov &LEFT, r14
    mov &LEFT+2, r15
    br #pasapas_fraction
line_dirs:
    .byte P2_DIR_X, P2_DIR_Y, 0, P2_DIR_Z

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
    /* goes on in generated/stops.s */
