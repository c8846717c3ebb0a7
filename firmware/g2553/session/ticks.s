/* The milliseconds: pins, filters, buttons, lamp, and what counts in time. */

    .section .text.ticks,"axR",@progbits
module.session.ticks:

/* Output r12 is off, in a pause and behind it. */
output_off:
    call #mask_of
    bic r14, &OUTPUT
    bic r14, &RESUME_OUTPUT
ticks_end:
    ret

/* Serves one millisecond that has passed, if any. Destroys all registers. */
    .global ticks
ticks:
    mov.b &MILLIS, r12
    sub.b &TICKS_DONE, r12
    jeq ticks_end
    inc.b &TICKS_DONE
    /* as many behind that it is served more than 2 ms late */
    cmp #3, r12
    jl 1f
    inc.b &MISSED
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
    /* behind it stands ticks_rest (firmware/src/rules/ticks.rs) */
4:
