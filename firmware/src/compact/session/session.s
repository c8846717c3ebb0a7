/* The run state machine: what Start, Stop, the link and the program make of each other. Micro-code,
   which instructions enter by the routines' names. */

    .section .text.session,"axR",@progbits
module.session:

/* The emergency stop as long as its input is pressed, or when its pin has tripped: nothing else begins to
   move meanwhile. No register is kept. */
    .global emergency_input
emergency_input:
    MICRO
    IF_IS WATCH, TRIPPED&255, emergency
    DO emergency_now
    IF_NOT_EQUAL emergency
    RETURN

    .balign 2, 0
/* Obeys r12 = a Control code; one that is not for this state does nothing. Restart is for a machine
   that rests without a run. No register is kept. */
    .global control
control:
    MICRO
    DO micro_switch
    DO micro_nothing            /* no code is 0 */
    TO start_
    TO stop_
    TO pause_
    TO go_on
    TO emergency
    TO acknowledge
    TO restart
    PLACES_END

    .balign 2, 0
/* Stop or hold: ramp down and pause. A spindle's time to come up begins anew. */
run_pause:
    MICRO
pause_:
    IF_IS_NOT RUN, RUN_RUNNING, 9f
    LET RUN, RUN_STOPPING
    F clear SPIN
    BITS_ON MOTION, M_PAUSE
9:  RETURN
restart:
    BITS_ON RUN_FLAGS, R_RESTART
    RETURN

    .balign 2, 0
/* Ends the run on a ramp. */
run_stop:
    MICRO
stop_:
    IF_NONE RUN, RUN_ACTIVE, 9b
    LIT END_STOPPED
/* Ends the active run as r12 = End says. */
    ROUTINE_ODD run_finish, module.session
    PUT ENDING
    LET RUN, RUN_STOPPING
    DO motion_stop
    RETURN

    .balign 2, 0
/* Steps cease at once, outputs go to their safe states whatever trace and KEEP values have to do, F14 is
   latched, with the input that is on now. */
emergency:
    DO motion_halt
    LET WATCH, 0
    LET HOMED, 0
    LIT B_AT_FAULT
    DO output_states
    CALL io_exchange
    DO emergency_now
    PUT FAULT_IN
    LIT F_EMERGENCY_STOP
    DO fail
    IF_IS_NOT RUN, RUN_FAULT, 9b
    F clear EFFECT
    RETURN

    .balign 2, 0
/* A fault at EFFECT_PC that ends the run: r12 = its number. Destroys r11 to r15. */
    .global fail
fail:
    MICRO
fail_:
    PUT VM_FAULT
    .if HAS_COURSES
    /* a line that was to go on, and none of whose targets may be reached: it has no events */
    IF_NONE MOTION, M_NEXT, 1f
    LIT 0
    F store LEFT
1:
    .endif
    F word EFFECT_PC
    F put VM_FAULT_PC
    LIT END_FAULT
    IF_ANY RUN, RUN_ACTIVE, run_finish
    LET RUN, RUN_FAULT
8:  RETURN

go_on:
    IF_IS RUN, RUN_PAUSED, start_
    RETURN
acknowledge:
    IF_IS_NOT RUN, RUN_FAULT, 8b
    GOTO start_

    .balign 2, 0
/* Start: the button, the link, autorun. Keeps r4 to r7 and r10. */
run_start:
    MICRO
    /* nothing while Stop is held or an input keeps the machine from working */
start_:
    IF_ANY BUTTON, P1_STOP, 8b
    DO blocking
    IF_NOT_EQUAL 8b
    IF_IS RUN, RUN_PAUSED, resume
    IF_IS_NOT RUN, RUN_FAULT, 2f
    LET RUN, RUN_EMPTY
    F word STORED
    IF_EQUAL 8b
    LET RUN, RUN_READY
    RETURN
2:  BITS_OFF RUN_FLAGS, R_WAITING
    IF_IS_NOT RUN, RUN_READY, 8b
    /* not before what a command began rests */
    IF_SET MOVING, 8b

/* The stored program is checked and begins. */
    CALL program_attach
    F word VM_CODE
    IF_NOT_EQUAL 1f
    LIT F_IMAGE_REFUSED
    GOTO fail_
1:  CALL clear_run
    F put VM_SP
    F put VM_BASE
    LIT16 POOL
    F put VM_CALLS
    F base STORED
    FR word SLOT_HEAD+IMAGE_CELLS, SHORT
    PUT VM_CELL_COUNT
    FR load SLOT_HEAD+IMAGE_CODE-MACHINE_SIZE+MC_FEED, LONG
    F store FEED
    FR word SLOT_HEAD+IMAGE_ENTRY, SHORT
    F add VM_CODE
    F put VM_PC
    BITS_OFF RUN_FLAGS, R_WAITING|R_TIMED_OUT|R_COURSES
    .if HAS_COURSES
    FR word SLOT_HEAD+IMAGE_CODE-MACHINE_SIZE+MC_FLAGS, SHORT
    TESTI MC_COURSES
    IF_EQUAL 1f
    BITS_ON RUN_FLAGS, R_COURSES
    LIT16 COURSE
    F put VM_SP
    F put VM_BASE
1:
    .endif
    CALL keep_load
    LIT16 RUNS_MARK
    F put RUNNING
    LET RUN, RUN_RUNNING
    .if HAS_EVENTS
    CALL stack_end
    F put VM_SP
    F put VM_BASE
    .endif
    BITS_OFF TRACING, ~(T_ON|T_HEARD|T_LOCKED)&0xff
    .if HAS_HALTS
    /* a host in trace mode may halt the program before its first effect */
    IF_NONE TRACING, T_ON, 1f
    BITS_ON TRACING, T_FULL
1:
    .endif
    END
    /* for an observer of the chip */
    .global run_begun
run_begun:
    inc &RUNS
    br #motion_reset

resume:
    LET RUN, RUN_RUNNING
    PROFILE B_SPINDLE
    DO output
    PUT TEMP
    F word RESUME_OUTPUT
    F put OUTPUT
    LIT 1
    F put SPIN
    IF_SET TEMP, 9f
    /* the spindle goes on: nothing moves before it has come up */
    PROFILE B_SPINDLE
    DO output
    IF_EQUAL 9f
    F base BOARD
    FR word B_SPIN_UP, SHORT
    F add SPIN
    F put SPIN
9:  RETURN

/* The stored program has changed: r12 = 1 for one that may run, 0 for none. */
    .balign 2, 0
    .global program_stored
program_stored:
    /* the cells follow the call stack, whose entries have two bytes */
    mov &VM_CODE, r14
    mov.b IMAGE_CALLS-IMAGE_CODE(r14), r14
    rla r14
    add #POOL, r14
    mov r14, &VM_CELLS
    bit.b #RUN_ACTIVE+RUN_FAULT, &RUN
    jne 1f
    mov.b r12, &RUN
1:  ret

/* The program that the check has just taken is a new one: all its cells are 0. */
    .if AT_ROOM
    .global attach_new
attach_new:
    mov #POOL, r12
    call #clear_ram
    br #attach_checked
    .else
    .set attach_new, attach_checked
    .global attach_new
    .endif

/* Clears what a run begins with as 0, but not the cells that live between runs. Leaves r12 = POOL_END,
   clobbers r13 to r15. */
clear_run:
    .if AT_ROOM
    call #kept_bytes
    mov r14, r13
    mov #RUN_CLEARED, r12
    jmp 1f
    .else
    mov #RUN_CLEARED, r12
    .endif
/* Clears RAM from r12 on to the pool's end, which r12 is then; clobbers r13. */
    .global clear_ram
clear_ram:
    .if AT_ROOM
    clr r13
1:  cmp &VM_CELLS, r12
    jne 2f
    add r13, r12
2:  clr 0(r12)
    incd r12
    cmp #POOL_END, r12
    jne 1b
    ret

/* r14 = bytes of the cells that live between runs, those of AT variables: none where they reach into the
   command buffer. Needs a program; clobbers r15. */
    .global kept_bytes
kept_bytes:
    mov &VM_CODE, r15
    mov.b IMAGE_KEEP_BASE-IMAGE_CODE(r15), r14
    rla r14
    rla r14
    mov &VM_CELLS, r15
    add r14, r15
    cmp #HOME_RECORD+1, r15
    jlo 1f
    clr r14
1:
    .else
1:  clr 0(r12)
    incd r12
    cmp #POOL_END, r12
    jne 1b
    .endif
    ret
