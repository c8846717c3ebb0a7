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
    bit #P1_STOP, r12
    jeq 1f
    call #run_pause
1:  and #P1_START, r12
    add r12, r9
    jeq 1f
    call #run_start
    /* hold, door and a second Stop */
1:  call #blocking
    jeq 2f
    call #run_pause

    /* Stop held for 2 s ends the run */
2:  inc &HELD
    bit.b #P1_STOP, &BUTTON
    jne 1f
    clr &HELD
1:  cmp #2000, &HELD
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

    /* The lamp: off without a program, lit when ready, slow blink in a run, fast in a pause, a
       fault's number in blinks. */
1:  mov &MILLIS, r13
    mov.b &MILLIS+1, r15
    mov.b &RUN, r14
    cmp #RUN_FAULT, r14
    jeq 2f
    cmp #RUN_RUNNING, r14
    jeq 1f
    jhs 3f
    mov r14, r13
    jmp 4f
1:  and #512, r13
    jmp 4f
    /* a blink each quarter of a second, anew every 8 s */
2:  and #31, r15
    cmp.b &VM_FAULT, r15
    jlo 3f
    clr r13
3:  and #128, r13
4:  mov &BOARD, r10             ; the start of a run keeps no register
    mov.b B_LAMP(r10), r12
    call #set_output

    /* auto-run half a second after power-up, unless a host has spoken or Stop is held */
    bit.b #R_BOOTED, &RUN_FLAGS
    jne 1f
    cmp #500, &MILLIS
    jlo 1f
    bis.b #R_BOOTED, &RUN_FLAGS
    bit.b #R_HOST, &RUN_FLAGS
    jne 1f
    bit.b #BOARD_AUTORUN, B_FLAGS(r10)
    jeq 1f
    /* the first start acknowledges what a watchdog reset has latched */
    bit.b #1, &CAUSE
    jeq 2f
    call #run_start
2:  call #run_start

    /* a pulse ends in a pause too, where waits stand still; what a probe keeps in TIME stays */
1:  mov.b &EFFECT, r12
    sub #OP_HOME, r12
    cmp #OP_WAIT_CHAR-OP_HOME+1, r12
    jhs 3f
    cmp #OP_PROBE-OP_HOME, r12
    jeq 3f
    cmp #OP_PULSE-OP_HOME, r12
    jeq 1f
    cmp.b #RUN_PAUSED, &RUN
    jeq 3f
    jmp 2f
1:  call #time_left
    jne 2f
    mov.b &N, r12
    call #mask_of
    bic r14, &OUTPUT
    bic r14, &RESUME_OUTPUT
2:  sub #1, &TIME
    sbc &TIME+2
    jge 3f
    add #1, &TIME
    adc &TIME+2

3:  cmp.b #RUN_RUNNING, &RUN
    jne 1f
    add #1, &TIMER_MS
    adc &TIMER_MS+2
    .if HAS_KEEP
    bit #1023, &TIMER_MS
    jne 1f
    call #motion_rests
    jne 1f
    call #keep_save
    .endif

1:
    .if HAS_EVENTS
    call #event_tick
    .endif
    /* as long as it is pressed: nothing else begins to move */
    mov &BOARD, r10
    mov.b B_EMERGENCY(r10), r10
    mov r10, r12
    call #input
    jeq ticks_end
    mov r10, r12
    jmp emergency
ticks_end:
    ret
