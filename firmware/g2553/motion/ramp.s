/* The ramp generator's instructions: what rules/segments.rs counts in powers of two and divides. They hand one another r4, the sign
   of what the speed is too high by, r5, the events, r6, the empty slot, and r7, a power of two. */

    .section .text.ramp,"axR",@progbits
module.motion.ramp:
    /* r7 = power of two of the events by time: the exponent of a quotient is the top byte of the
       difference of both, r13. */
segment_by_time:
    swpb r13
    sxt r13
    mov #16, r7
    sub r13, r7
    ret
    /* Carry when the brake is twice as many events away: r13:r12, what the square of the speed may
       still rise by, over DECEL2. */
segment_cruises:
    cmp &DECEL2, r12
    subc &DECEL2+2, r13
    jnc 1f
    swpb r13
    mov.b r13, r13
    clrc
    subc r7, r13
1:  ret
    /* r7 = half as many, and the power at most by speed, of which r13 is the difference negated; but
       half of them */
segment_by_speed:
    dec r7
    swpb r13
    sxt r13
    inv r13
    sub #4, r13
    cmp r7, r13
    jge 5f
    dec r7
5:  ret

    /* r4 = r13, whose sign is what the speed is too high by; Z set for 0 in r13:r12. In a hurry: test_long would do, but
       for its cycles. */
segment_sign:
    mov r13, r4
    bis r12, r13
    tst r13
    ret

    /* r5 = 2^r7 events of LEFT; a remainder below one and a quarter of it is taken at once. Leaves them in
       r13:r12, scaled, and the sign of r4. */
segment_take:
    mov #1, r5
6:  dec r7
    jn 7f
    rla r5
    bit #1<<14, r5
    jeq 6b
7:  mov r5, r12
    rra r12
    rra r12
    add r5, r12
    tst &LEFT+2
    jne 8f
    cmp &LEFT, r12
    jlo 8f
    mov &LEFT, r5
8:  sub r5, &LEFT
    sbc &LEFT+2
    mov r5, r12
    clr r13
    call #pasapas_scaled_new
    tst r4
    ret

    /* Sub-events: as many powers of two as the longest interval may exceed 2^15 ticks by; r13 has the
       exponent of both speeds' sum over TICK. Leaves the mask in the slot, r5 = sub-events, r7 = exponent of an interval,
       r8 = offset of the slot. */
segment_divide:
    swpb r13
    sxt r13
    add #12, r13
    clr r4
    mov #16, r7
3:  inc r13
    jge 4f
    rla r5
    setc
    rlc r4
    dec r7
    cmp #1, r7
    jne 3b
    /* where a scaled number has its exponent */
4:  swpb r7
    .if HAS_COURSES
    /* the mark of a line that begins at speed */
    bit.b #M_NEXT, &MOTION
    jeq 5f
    bis #1<<15, r4
5:
    .endif
    mov r4, SLOT0+MASK(r6)
    mov r6, r8
    ret

    /* scaled r13:r12 times 2^r7, as an integer */
segment_scale:
    add r7, r13
    jmp pasapas_scaled_floor

    /* Change of the interval from an event to the next: r13:r12 twice over r5, positive when slower.
       r9:r7 = 0, or when faster, from the longest interval down, the whole. */
segment_change:
    rla r12
    rlc r13
    mov r12, r7
    mov r13, r9
    mov r5, r14
    clr r15
    push r9
    push r10
    call #pasapas_udivmod
    pop r10
    pop r9
    tst r4
    jge negate
    clr r9
    clr r7
    ret

    /* half of r13:r12, toward 0, before the first event, and r9:r7 */
segment_half:
    mov r13, r15
    rla r15
    adc r12
    adc r13
    rra r13
    rrc r12
    add r7, r12
    addc r9, r13
    ret
