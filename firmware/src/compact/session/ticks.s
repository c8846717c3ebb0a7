/* The milliseconds: pins, filters, buttons, lamp, and what counts in time. */

    .section .text.ticks,"axR",@progbits

/* Serves one millisecond that has passed, if any. Destroys all registers. */
    .global ticks
ticks:
    mov.b &MILLIS, r12
    sub.b &TICKS_DONE, r12
    jeq ticks_end
    cmp #3, r12
    jlo 1f
    decd r12
    add r12, &MISSED
1:  inc.b &TICKS_DONE
    call #io_exchange
    call #limits
    mov &BOARD, r10

    /* four samples within the filter's time */
    inc.b &FILTER
    mov.b &FILTER, r12
    rla r12
    rla r12
    cmp.b B_FILTER(r10), r12
    jlo 2f
    clr.b &FILTER
    mov.b &RAW, r12
    mov #INPUT, r13
    call #filter
    mov.b &RAW+1, r12
    inc r13
    call #filter
    mov.b &P1IN, r12
    inv r12
    and #P1_STOP+P1_START, r12
    mov #BUTTON, r13
    call #filter
    mov r12, r9
    bit #P1_STOP, r9
    jeq 1f
    call #run_pause
1:  bit #P1_START, r9
    jeq 2f
    call #run_start

2:  mov.b B_EMERGENCY(r10), r12
    call #input
    tst r12
    jeq 1f
    /* one that is latched has been dealt with */
    cmp.b #RUN_FAULT, &RUN
    jne 3f
    cmp.b #F_EMERGENCY_STOP, &VM_FAULT
    jeq 1f
3:  mov.b B_EMERGENCY(r10), r12
    call #emergency

    /* Stop held for 2 s ends the run */
1:  inc &HELD
    bit.b #P1_STOP, &BUTTON
    jne 1f
    clr &HELD
1:  cmp #2000, &HELD
    jne 1f
    call #run_stop

1:  inc &SILENT
    jne 1f
    dec &SILENT
1:  tst &SPIN
    jeq 1f
    dec &SPIN
    jne 1f
    call #motion_resume

    /* The lamp: off without a program, lit when ready, slow blink in a run, fast in a pause, a
       fault's number in blinks. */
1:  mov &MILLIS, r13
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
    /* the run's clock stands still, so it counts the blinks, of 256 ms each */
2:  inc &TIMER_MS
    mov &TIMER_MS, r13
    mov r13, r15
    swpb r15
    mov.b r15, r15
    mov.b &VM_FAULT, r14
    cmp r14, r15
    jlo 3f
    clr r13
    add #4, r14
    cmp r14, r15
    jlo 4f
    clr &TIMER_MS
    jmp 4f
3:  and #128, r13
4:  mov.b B_LAMP(r10), r12
    call #set_output

    /* auto-run half a second after power-up, unless a host has spoken or Stop is held */
    bit.b #R_BOOTED, &RUN_FLAGS
    jne 1f
    cmp #500, &MILLIS
    jlo 1f
    bis.b #R_BOOTED, &RUN_FLAGS
    bit.b #BOARD_AUTORUN, B_FLAGS(r10)
    jeq 1f
    bit.b #R_HOST, &RUN_FLAGS
    jne 1f
    call #run_start

    /* waits stand still in a pause, a pulse does not */
1:  mov.b &EFFECT, r12
    cmp.b #OP_PULSE, r12
    jeq 1f
    sub #OP_HOME, r12
    cmp #OP_WAIT_CHAR-OP_HOME+1, r12
    jhs 4f
    cmp #OP_PROBE-OP_HOME, r12
    jeq 4f
    cmp.b #RUN_RUNNING, &RUN
    jeq 2f
    bit.b #RUN_ACTIVE, &RUN
    jne 4f
    jmp 2f
1:  cmp #1, &TIME
    jne 2f
    tst &TIME+2
    jne 2f
    mov.b &N, r12
    call #mask_of
    bic r14, &OUTPUT
    bic r14, &RESUME_OUTPUT
2:  sub #1, &TIME
    sbc &TIME+2
    jge 4f
    add #1, &TIME
    adc &TIME+2

4:  cmp.b #RUN_RUNNING, &RUN
    jne ticks_end
    add #1, &TIMER_MS
    adc &TIMER_MS+2
    bit #1023, &TIMER_MS
    jne ticks_end
    call #motion_rests
    jne ticks_end
    br #keep_save
ticks_end:
    ret
