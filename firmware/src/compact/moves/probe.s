/* Probing: a move that ends where inputs answer. */
    .section .text.micro,"axR",@progbits
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
    EFFECT OP_PROBE, fx_probe
    ROUTINE_ODD fx_probe
    IF_NOT_EQUAL probe_goes
    DO operand_byte
    DO axis_flags
    DO operand_byte
    PUT RAMPS
    IF_NONE RAMPS, FL_MASK, 1f
    DO pop_value
    DO probe_xor
    DO pop_value
    DO probe_and
    GOTO 3f
1:  LET UNIT, 1
    PROFILE B_PROBE
    IF_NONE RAMPS, FL_SENSOR, 2f
    DO pop_level
    POP_NUMBER 1, 17
2:  CMPI 0
    IF_EQUAL probe_lacks
    DO probe_input
3:  IF_NONE FLAGS, FL_SPEED, 4f
    DO speed_flags
    GOTO 5f
    /* the feed */
4:  LET UNIT, 0
    F load FEED
    IF_NOT_NEGATIVE 1f
    LET UNIT, 2
    DO negate
1:  DO rate_of
    DO speed_least
5:  IF_EQUAL probe_range
    GET FLAGS
    ANDI F_STEPS+F_MACHINE+F_RELATIVE
    PUT FRAME_OF
    DO pop_value
    DO aim
    DO or_return
    DO probe_begin
    IF_EQUAL probe_wait
    DO here
    EVENT TRACE_PROBE
    FAULT F_INPUT_ACTIVE
probe_lacks:
    FAULT F_VALUE_RANGE
probe_range:
    FAULT F_SPEED_RANGE

probe_goes:
    DO axis_n
    IF_IS_NOT PHASE, PROBE_MOVES, 3f
    IF_ZERO HIT, 1f
    /* a pin answered: its place is the count of that step */
    CALL motion_caught
    GOTO 2f
1:  DO probe_answers
    IF_NOT_EQUAL 0f
    IF_SET MOVING, probe_wait
    LET PHASE, PROBE_MISSED
    GOTO 3f
0:  DO here
2:  F store PROBED, AXIS
    UP PHASE
    DO axis_bit
    AXIS_ON PROBE_OK
    F load PROBED, AXIS
    DO motion_hit
probe_wait:
    NOT_YET_
3:  IF_SET MOVING, probe_wait
    IF_IS_NOT PHASE, PROBE_CAUGHT, 4f
    F load PROBED, AXIS
    EVENT_OK TRACE_PROBE
    RETURN
4:  DO here
    EVENT TRACE_PROBE
    IF_ANY BITS, FL_QUERY, 5f
    FAULT F_PROBE_MISSED
5:  RETURN
    .balign 2, 0

    /* r13:r12 = the inputs that must be off, then those that count. Use r7, r12, r13. */
probe_xor:
    mov r12, &PROBE_XOR
    mov r13, r7
    ret
probe_and:
    mov r12, &PROBE_AND
    jmp probe_high
    /* Waits for input r12, from 1, to be on (UNIT not 0) or off; those above 16 are 17. Uses r7, r11
       to r15. */
probe_input:
    call #mask_of
    mov r14, &PROBE_AND
    clr &PROBE_XOR
    clr r7
    clr r13
    tst r14
    jne 1f
    inc r13
1:  tst.b &UNIT
    jne probe_high
    mov r13, r7
    mov r14, &PROBE_XOR
    /* BITS = those of the masks' high halves r13 and r7, and QUERY of FLAGS. Uses r7, r12. */
probe_high:
    and #PROBE_AND_17, r13
    rra r7
    jnc 1f
    bis #PROBE_XOR_17, r13
1:  tst r7
    jeq 3f
    bis #PROBE_ALWAYS, r13
3:  mov.b &FLAGS, r12
    and #FL_QUERY, r12
    bis r12, r13
    mov.b r13, &BITS
    ret

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

    /* The axis sets off to NEW_STEPS at the pace in TEMP; Z clear when the inputs answer already. */
    ROUTINE_ODD probe_begin
    DO axis_bit
    AXIS_OFF PROBE_OK
    DO probe_answers
    IF_NOT_EQUAL 1f
    DO command
    DO begin_axis
    /* a probe at pins of port 1 is caught at its very step: they are at rest now */
    LET HIT, 0
    CALL probe_pins
    PUT WATCH
    PROFILE B_FLAGS
    TESTI BOARD_CHAIN
    IF_EQUAL 2f
    LET WATCH, 0
    F word PROBE_AND
    IF_NOT_EQUAL 2f
    IF_NONE BITS, PROBE_AND_17, 2f
    LET WATCH, P1_REF_X_OR_PROBE
    /* an axis no faster than its start rate stands still at once */
2:  BITS_OFF IDLE, WATCH_ENDS
    F load START2
    F sub NOMINAL2
    IF_NEGATIVE 3f
    BITS_ON IDLE, WATCH_ENDS
3:  LIT 0
    DO test_long
1:  RETURN
    .balign 2, 0

    /* The pins at rest, and in r12 those of inputs 1 to 4 of the direct wiring that count. */
probe_pins:
    mov.b &P1IN, &IDLE
    mov.b &PROBE_AND, r12
    rla.b r12
    rla.b r12
    rla.b r12
    rla.b r12
    ret
