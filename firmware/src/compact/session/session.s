/* The run state machine: what Start, Stop, the link and the program make of each other. */

    .section .text.session,"axR",@progbits
module.session:

/* Obeys r12 = a Control code; one that is not for this state does nothing. Restart is for a machine
   that rests without a run. No register is kept. */
    .global control
control:
    rla r12
    add r12, r0
9:  ret
    jmp run_start
    jmp run_stop
    jmp run_pause
    jmp run_go_on
    jmp emergency_by_link
    jmp run_acknowledge
    /* restart */
    bis.b #R_RESTART, &RUN_FLAGS
    ret

/* Stop or hold: ramp down and pause. A spindle's time to come up begins anew. */
run_pause:
    cmp.b #RUN_RUNNING, &RUN
    jne 9b
    add.b #RUN_STOPPING-RUN_RUNNING, &RUN
    clr &SPIN
    bis.b #M_PAUSE, &MOTION
    ret

/* Ends the run on a ramp. */
run_stop:
    bit.b #RUN_ACTIVE, &RUN
    jeq 9b
    mov.b #END_STOPPED, r12
/* Ends the active run as r12 = End says. */
run_finish:
    mov.b #RUN_STOPPING, &RUN
    mov.b r12, &ENDING
    br #motion_stop

/* Steps cease at once, outputs go to their safe states, F14 is latched. Takes r12 = input that
   caused it, 0 for none. No register is kept. */
emergency_by_link:
    clr r12
    .global emergency
emergency:
    mov.b r12, &FAULT_IN
    call #motion_halt
    clr.b &HOMED
    mov #F_EMERGENCY_STOP, r12
    call #fail
    cmp.b #RUN_FAULT, &RUN
    jne 9b
    clr &EFFECT
    mov #B_AT_FAULT, r12
    jmp output_states

/* A fault at EFFECT_PC that ends the run: r12 = its number. Destroys r11 to r15. */
    .global fail
fail:
    mov.b r12, &VM_FAULT
    mov &EFFECT_PC, &VM_FAULT_PC
    mov.b #END_FAULT, r12
    bit.b #RUN_ACTIVE, &RUN
    jne run_finish
    mov.b #RUN_FAULT, &RUN
    ret

/* The stored program has changed: r12 = 1 for one that may run, 0 for none. */
    .global program_stored
program_stored:
    bit.b #RUN_ACTIVE+RUN_FAULT, &RUN
    jne 1f
    mov.b r12, &RUN
1:  ret

/* Z set unless Stop is held or an input keeps the machine from working. Clobbers r11 to r15. */
run_blocked:
    bit.b #P1_STOP, &BUTTON
    jne 1b
    jmp blocking
run_go_on:
    call #run_blocked
    jne 1b
run_resume:
    cmp.b #RUN_PAUSED, &RUN
    jne 1b
    mov.b #RUN_RUNNING, &RUN
    mov &OUTPUT, r13
    mov &RESUME_OUTPUT, &OUTPUT
    mov #1, &SPIN
    mov &BOARD, r15
    mov.b B_SPINDLE(r15), r12
    call #mask_of
    bic r13, r14
    bit &OUTPUT, r14
    jeq 1b
    add B_SPIN_UP(r15), &SPIN
    ret

run_acknowledge:
    cmp.b #RUN_FAULT, &RUN
    jne 1b
/* Start: the button, the link, autorun. Keeps r4 to r7 and r10. */
run_start:
    call #run_blocked
    jne 1b
    mov.b &RUN, r12
    cmp #RUN_PAUSED, r12
    jeq run_resume
    cmp #RUN_FAULT, r12
    jne 2f
    mov.b #RUN_EMPTY, &RUN
    tst &STORED
    jeq 1b
    mov.b #RUN_READY, &RUN
    ret
2:  bic.b #R_WAITING, &RUN_FLAGS
    cmp #RUN_READY, r12
    jne 1b
    /* not before what a command began rests */
    tst.b &MOVING
    jne 1b

/* The stored program is checked and begins. */
run_begin:
    call #program_attach
    mov #F_IMAGE_REFUSED, r12
    mov &VM_CODE, r13
    tst r13
    jeq fail
    mov #RUN_CLEARED, r14
1:  clr 0(r14)
    incd r14
    cmp #POOL_END, r14
    jne 1b
    mov r14, &VM_SP
    mov r14, &VM_BASE
    mov #POOL, r12
    mov r12, &VM_CALLS
    /* entries in the high half; an entry has two bytes */
    mov.b IMAGE_CALLS-IMAGE_CODE(r13), r14
    rra r14
    rra r14
    rra r14
    bic #1, r14
    add r14, r12
    mov r12, &VM_CELLS
    mov.b IMAGE_CELLS-IMAGE_CODE(r13), &VM_CELL_COUNT
    mov MC_FEED-MACHINE_SIZE(r13), &FEED
    mov MC_FEED-MACHINE_SIZE+2(r13), &FEED+2
    add IMAGE_ENTRY-IMAGE_CODE(r13), r13
    mov r13, &VM_PC
    .if HAS_KEEP
    call #keep_load
    .endif
    mov #RUNS_MARK, &RUNNING
    mov.b #RUN_RUNNING, &RUN
    bic.b #R_WAITING+R_TIMED_OUT, &RUN_FLAGS
    and.b #T_ON|T_LOCKED, &TRACING
    inc &RUNS
    br #motion_reset
