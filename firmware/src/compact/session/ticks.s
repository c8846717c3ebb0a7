/* The milliseconds: pins, filters, buttons, lamp, and what counts in time. */

    .section .text.ticks,"axR",@progbits
module.session.ticks:

/* Serves one millisecond that has passed, if any. Destroys all registers. */
    .global ticks
ticks:
    mov.b &MILLIS, r12
    sub.b &TICKS_DONE, r12
    jeq ticks_end
    inc.b &TICKS_DONE
    decd r12
    jl 1f
    add r12, &MISSED
1:  call #io_exchange
    call #limits
    mov &BOARD, r10

    /* four samples within the filter's time */
    add.b #4, &FILTER
    cmp.b B_FILTER(r10), &FILTER
    jlo 2f
    clr.b &FILTER
    mov #INPUT, r13
    call #filter_raw
    mov r12, r9
    inc r13
    call #filter_raw
    swpb r12
    bis r12, r9
    /* r9 = not 0 when a Start button went on: that of the role or its own */
    mov.b B_START(r10), r12
    call #mask_of
    and r14, r9
    mov.b &P1IN, r12
    inv r12
    mov #BUTTON, r13
    call #filter
    and #P1_START, r12
    add r12, r9
    jeq 1f
    call #run_start
    /* Stop, a second one, hold and door */
1:  bit.b #P1_STOP, &BUTTON
    jne 1f
    mov #1+2000, &HELD
    call #blocking
    jeq 2f
1:  call #run_pause
    /* Stop held for 2 s ends the run */
2:  dec &HELD
    jne 1f
    call #run_stop

1:  inc &UNHEARD
    jne 1f
    dec &UNHEARD
1:  tst &SPIN
    jeq 1f
    dec &SPIN
    jne 1f
    bic.b #M_PAUSE, &MOTION

    /* A run's time, and the lamp: off without a program, lit when ready, slow blink in a run, fast in a
       pause, a fault's number in blinks. */
1:  mov.b &RUN, r13
    cmp #RUN_RUNNING, r13
    jlo 4f                      ; empty or ready, 0 or 1: the lamp's level
    jeq 1f
    cmp #RUN_FAULT, r13
    jne 3f
    /* a blink each quarter of a second, anew every 8 s */
    mov.b &MILLIS+1, r15
    and #31, r15
    cmp.b &VM_FAULT, r15
    jlo 3f
    clr r13
    jmp 4f
    /* once a second, when nothing moves, KEEP values go to flash */
1:  add #1, &TIMER_MS
    adc &TIMER_MS+2
    bit #1023, &TIMER_MS
    jne 1f
    call #motion_rests
    jne 1f
    call #keep_save
1:  mov #512, r13
    jmp 2f
3:  mov #128, r13
2:  and &MILLIS, r13
4:  MICRO
    PROFILE B_LAMP
    CALL set_output

    /* trace mode ends 2 s after its reader, counted down in quarters */
    IF_SET TICKS_DONE, 1f
    IF_NONE TRACING, T_HEARD, 2f
    GET TRACING
    ADDI -T_QUARTER
    PUT TRACING
    GOTO 1f
2:  BITS_OFF TRACING, T_ON|T_FULL

    /* auto-run half a second after power-up, unless a host has spoken or Stop is held */
1:  IF_ANY RUN_FLAGS, R_BOOTED, 1f
    LIT16 499
    F cmp MILLIS
    IF_CARRY 1f
    BITS_ON RUN_FLAGS, R_BOOTED
    IF_ANY RUN_FLAGS, R_HOST, 1f
    PROFILE B_FLAGS
    TESTI BOARD_AUTORUN
    IF_EQUAL 1f
    /* the first start acknowledges what a watchdog reset has latched */
    IF_NONE CAUSE, 1, 2f
    DO run_start
2:  DO run_start

1:
    /* a jog goes on for 2 s after the last request */
    IF_ANY MOTION, M_JOG, 1f
    IF_ZERO EFFECT, 3f
    /* a pulse ends in a pause too, where waits stand still; what a probe keeps in TIME stays */
    GET EFFECT
    ADDI -OP_HOME
    CMPI OP_WAIT-OP_HOME+1
    IF_CARRY 3f
    CASE OP_PULSE-OP_HOME, 1f
    IF_IS RUN, RUN_PAUSED, 3f
1:  LIT 1
    DO negate
    F add TIME
    IF_NEGATIVE 2f
    F store TIME
    GOTO 3f
2:  IF_NONE MOTION, M_JOG, 1f
    DO motion_stop
1:  IF_IS_NOT EFFECT, OP_PULSE, 3f
    GET N
    CALL output_off

3:
    .if HAS_EVENTS
    END
    call #event_tick
    MICRO
    .endif
    RETURN
    .balign 2, 0

/* Output r12 is off, in a pause and behind it. */
output_off:
    call #mask_of
    bic r14, &OUTPUT
    bic r14, &RESUME_OUTPUT
ticks_end:
    ret
