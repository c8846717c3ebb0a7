/* Probing: a move that ends where inputs answer. */
    .section .text.moves,"axR",@progbits
module.moves.probe:

    /* Inputs 1 to 16 that count, and those of them that must be off. BITS holds QUERY and: */
    .set PROBE_AND, TIME
    .set PROBE_XOR, TIME+2
    .set PROBE_AND_17, 1        /* input 17 counts */
    .set PROBE_XOR_17, 2        /* it must be off */
    .set PROBE_ALWAYS, 4        /* an input that does not exist must be off */
    /* PHASE */
    .set PROBE_MOVES, 1
    .set PROBE_CAUGHT, 2
    .set PROBE_MISSED, 3

    /* Probe, ProbeMask, command 107. */
    .global fx_probe
fx_probe:
    jne probe_goes
    inc.b &PHASE
    call #operand_byte
    call #axis_flags
    call #operand_byte
    mov r12, r5
    bit #FL_MASK, r5
    jeq 1f
    call #pop_value
    mov r12, &PROBE_XOR
    mov r13, r5
    call #pop_value
    mov r12, &PROBE_AND
    call #probe_high
    jmp 3f
1:  mov &BOARD, r11
    mov #1, r10
    mov.b B_PROBE(r11), r12
    bit #FL_SENSOR, r5
    jeq 2f
    call #pop_value
    bis r13, r12
    mov r12, r10
    mov #17, r12
    call #pop_small
2:  call #probe_input
    jhs 6f
3:  bit #FL_SPEED, r6
    jne 4f
    call #feed_least
    jmp 5f
4:  call #speed_flags
5:  jc 7f
    call #pop_value
    /* frame to bits 0 and 1, steps to bit 2 */
    mov r6, r10
    rra r10
    rra r10
    rra r10
    and #3, r10
    and #FL_STEPS, r6
    bis r6, r10
    call #aim
    tst r12
    jne 8f
    call #probe_begin
    jeq probe_wait
    mov #TRACE_PROBE, r7
    call #event_here
    mov #FAULTED+F_INPUT_ACTIVE, r12
8:  ret
6:  br #aim_lacks
7:  br #speed_range

probe_goes:
    call #axis_n
    cmp.b #PROBE_MOVES, &PHASE
    jne 3f
    tst.b &HIT
    jeq 1f
    /* a pin answered: its place is the count of that step */
    call #motion_caught
    jmp 2f
1:  call #probe_answers
    jne 0f
    tst.b &MOVING
    jne probe_wait
    mov.b #PROBE_MISSED, &PHASE
    jmp 3f
0:  call #formula
    F load ACTUAL, AXIS, LAST
2:  call #formula
    F store PROBED, AXIS, LAST
    inc.b &PHASE
    mov r12, r14
    call #axis_bit
    bis.b r12, &PROBE_OK
    mov r14, r12
    call #hit_at
probe_wait:
    br #not_yet
3:  tst.b &MOVING
    jne probe_wait
    clr.b &WATCH
    mov #TRACE_PROBE, r7
    cmp.b #PROBE_CAUGHT, &PHASE
    jne 4f
    mov #TRACE_OK<<8|TRACE_PROBE, r7
    call #formula
    F load PROBED, AXIS, LAST
    br #event
4:  call #event_here
    bit.b #FL_QUERY, &BITS
    jne 5f
    mov #FAULTED+F_PROBE_MISSED, r12
5:  ret

    /* An input answered when the axis N was at r13:r12. Uses r11 to r15. */
hit_at:
    mov r12, r14
    mov r13, r15
    mov.b &N, r12
    br #motion_hit

    /* The feed lowers the speed of the pace; carry when there is none. Uses r7, r11 to r15. */
feed_least:
    clr r7
    call #formula
    F load FEED, , LAST
    tst r13
    jge 1f
    mov #2, r7
    call #negate
1:  call #rate_of
    jc 2f
    br #speed_least

    /* Waits for input r12 to be on (r10 not 0) or off. Carry when there is no such input.
       Uses r5, r11 to r15. */
probe_input:
    dec r12
    cmp #17, r12
    jhs 2f
    inc r12
    call #mask_of
    mov r14, &PROBE_AND
    clr &PROBE_XOR
    clr r5
    clr r13
    tst r14
    jne 1f
    inc r13
1:  tst r10
    jne probe_high
    mov r13, r5
    mov r14, &PROBE_XOR
    /* BITS = those of the masks' high halves r13 and r5, and QUERY of r6; carry clear. Uses r5, r12. */
probe_high:
    and #PROBE_AND_17, r13
    rra r5
    jnc 1f
    bis #PROBE_XOR_17, r13
1:  tst r5
    jeq 3f
    bis #PROBE_ALWAYS, r13
3:  mov r6, r12
    and #FL_QUERY, r12
    bis r12, r13
    mov.b r13, &BITS
    clrc
2:  ret

    /* Z clear when (inputs AND and) XOR xor is not 0. Uses r11 to r15. */
probe_answers:
    mov #17, r12
    call #unfiltered
    mov.b &BITS, r13
    and r13, r12
    rra r13
    and #(PROBE_XOR_17+PROBE_ALWAYS)/2, r13
    xor r13, r12
    mov &RAW, r13
    and &PROBE_AND, r13
    xor &PROBE_XOR, r13
    bis r13, r12
    tst r12
    ret

    /* The axis sets off to NEW_STEPS at the pace in TEMP; Z clear when the inputs answer already.
       Uses all but r4 to r6. */
probe_begin:
    call #axis_bit
    bic.b r12, &PROBE_OK
    call #probe_answers
    jne 2b
    /* a probe at pins of port 1 is caught at its very step: they are at rest now */
    clr.b &WATCH
    clr.b &HIT
    mov.b &P1IN, &IDLE
    mov &PROBE_AND, r12
    mov &BOARD, r11
    bit #BOARD_CHAIN, B_FLAGS(r11)
    jne 1f
    rla r12
    rla r12
    rla r12
    rla r12
    and #0xf0, r12
    jmp 3f
1:  tst r12
    jne 4f
    bit.b #PROBE_AND_17, &BITS
    jeq 4f
    mov #P1_REF_X_OR_PROBE, r12
3:  mov.b r12, &WATCH
4:  call #command
    call #begin_axis
    cmp r12, r12
    ret
