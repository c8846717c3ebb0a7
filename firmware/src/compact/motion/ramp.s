/* The ramp generator: from what is left of a motion to segments of linearly changing intervals. The
   twin, with the why of each number, is `motion::ramp`.

   One segment lasts 2 to 8 ms and ends at
       v1^2 = min(v0^2 + 2 a n, nominal^2, start^2 + 2 d left)
   Its n events are a power of two, or all that is left. */

    .section .text.ramp,"axR",@progbits
module.motion.ramp:
    /* Takes r6 = an empty slot. Leaves carry set and the slot filled, or carry clear when nothing is
       left, or while braking at a speed no higher than the start rate. All registers but r6 lost.
       7 000 cycles at the most. */
    .global segment
segment:
    tst &LEFT
    jne 1f
    tst &LEFT+2
    jeq segment_none
    /* r8 = 0 to go for NOMINAL2, 4 to brake for START2, which follows it */
1:  clr r8
    bit.b #M_PAUSE|M_STOP, &MOTION
    jeq 2f
    mov #START2-NOMINAL2, r8
    MICRO
    F load START2
    F sub V2
    END
    tst r13
    jge segment_none

    /* r5 = events: 4 to 8 ms of them at a constant speed, half of that on a ramp, and there no more
       than change the speed by about 1/32, or 8 */
2:  MICRO
    F load TICK
    F sub V
    END
    /* the exponent of a quotient is the top byte of the difference */
    swpb r13
    sxt r13
    mov #15, r7
    sub r13, r7
    /* r4 = sign of what the speed is too high by */
    MICRO
    F load V2
    F sub NOMINAL2, AXIS
    END
    mov r13, r4
    tst r13
    jne 3f
    tst r12
    jne 3f
    inc r7
    jmp 5f
3:  MICRO
    F load ACCEL2
    F most DECEL2
    F store TEMP+4
    F load V2
    F sub TEMP+4
    END
    swpb r13
    sxt r13
    sub #4, r13
    cmp #3, r13
    jge 4f
    mov #3, r13
4:  cmp r7, r13
    jge 5f
    mov r13, r7
5:  mov #1, r5
6:  dec r7
    jn 7f
    rla r5
    bit #1<<14, r5
    jeq 6b
    /* a remainder below one and a half of it is taken at once */
7:  mov r5, r12
    rra r12
    add r5, r12
    tst &LEFT+2
    jne 8f
    cmp &LEFT, r12
    jlo 8f
    mov &LEFT, r5
8:  sub r5, &LEFT
    sbc &LEFT+2

    /* TEMP+4 = square of the speed at the end, TEMP = the speed */
    tst r4
    mov r5, r12
    mov #0, r13
    jge 1f
    MICRO
    DO new
    F times ACCEL2
    F plus V2
    F least NOMINAL2, AXIS
    END
    jmp 2f
1:  MICRO
    DO new
    F times DECEL2
    F store TEMP+4
    F load V2
    F minus TEMP+4
    F most NOMINAL2, AXIS
    END
2:  MICRO
    F store TEMP+4
    F load LEFT, NEW
    F times DECEL2
    F plus START2
    F least TEMP+4
    F store TEMP+4
    DO root
    F store TEMP
    /* sub-events: as many powers of two as the longest interval exceeds 2^14 ticks by */
    F least V
    F sub TICK
    END
    call #negate
    swpb r13
    sxt r13
    sub #14, r13
    clr r4
    mov #16<<8, r7
3:  dec r13
    jn 4f
    rla r5
    setc
    rlc r4
    sub #1<<8, r7
    cmp #1<<8, r7
    jne 3b
4:  mov r4, MASK(r6)

    /* the interval at the faster end, 1/65536 ticks */
    mov r6, r8
    sub #SLOT0, r8
    MICRO
    LIT 0
    F store SLOT0+CHANGE, AXIS
    F load V
    F most TEMP
    F store SLOT0, AXIS
    F load TICK
    F over SLOT0, AXIS
    END
    add r7, r13
    MICRO
    DO floor
    F store SLOT0, AXIS
    F load TEMP+4
    F sub V2
    END
    mov r13, r4
    bis r12, r13
    tst r13
    jeq 7f
    /* the speed changes: r9:r10 = twice what the mean interval is longer by */
    MICRO
    F load V
    F plus TEMP
    F store TEMP+8
    F load TICK
    F over TEMP+8
    END
    add r7, r13
    add #1<<8, r13
    MICRO
    DO floor
    F sub SLOT0, AXIS
    END
    tst r13
    jge 5f
    clr r12
    clr r13
5:  rla r12
    rlc r13
    mov r12, r10
    mov r13, r9
    mov r5, r14
    clr r15
    call #__mspabi_divul
    /* faster: from the longest interval down, else from the shortest up */
    tst r4
    jge 6f
    clr r9
    clr r10
    jmp 8f
6:  call #negate
8:  MICRO
    F store SLOT0+CHANGE, AXIS
    END
    /* half of it, toward 0, before the first event */
    mov r13, r15
    rla r15
    adc r12
    adc r13
    rra r13
    rrc r12
    add r10, r12
    addc r9, r13
    MICRO
    F add SLOT0, AXIS
    F store SLOT0, AXIS
    END
7:  MICRO
    F load TEMP
    F store V
    F load TEMP+4
    F store V2
    END
    mov r5, EVENTS(r6)
    setc
    ret
segment_none:
    clrc
    ret
