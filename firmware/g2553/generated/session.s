/* Made by `cargo run -p lower` of firmware/src/rules/session.rs: change that. */

    .section .text.session,"axR",@progbits
module.rules.session:
    .balign 2, 0
    .global emergency_input
emergency_input:
    MICRO
    IF_IS WATCH, TRIPPED&255, run_emergency
    DO emergency_now
    IF_NOT_EQUAL run_emergency
.Lsession_m6:
    RETURN
.Lsession_9:
    BITS_ON RUN_FLAGS, R_RESTART
    RETURN
    .balign 2, 0
    .global control
control:
    MICRO
    DO micro_switch
    .byte 0
    TO .Lsession_run_start
    TO .Lsession_run_stop
    TO .Lsession_run_pause
    TO .Lsession_6
    TO run_emergency
    TO .Lsession_8
    TO .Lsession_9
    PLACES_END
.Lsession_6:
    IF_IS_NOT RUN, RUN_PAUSED, .Lsession_10
.Lsession_m5:
    DO run_start
    RETURN
.Lsession_8:
    IF_IS RUN, RUN_FAULT, .Lsession_m5
.Lsession_10:
    RETURN
    .balign 2, 0
    .global run_pause
run_pause:
    MICRO
.Lsession_run_pause:
    IF_IS_NOT RUN, RUN_RUNNING, run_end_commands
    LET RUN, 6
    F clear SPIN
    BITS_ON MOTION, M_PAUSE
.Lsession_m0:
    RETURN
    .balign 2, 0
    .global run_stop
run_stop:
    MICRO
.Lsession_run_stop:
    IF_NONE RUN, RUN_ACTIVE, run_end_commands
    LIT 2
    .global run_finish
    ROUTINE_ODD run_finish, module.rules.session
    PUT ENDING
    LET RUN, 6
    DO motion_stop
    RETURN
run_end_commands:
    IF_ANY RUN, RUN_ACTIVE, .Lsession_m0
    DO abandon
    DO motion_stop
    RETURN
fx_end:
    LIT 1
    CALL run_finish
    NOT_YET_
run_emergency:
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
    IF_IS_NOT RUN, RUN_FAULT, .Lsession_m6
    F clear EFFECT
    RETURN
    .balign 2, 0
    .global fail
fail:
    MICRO
.Lsession_fail:
    PUT VM_FAULT
    F word EFFECT_PC
    F put VM_FAULT_PC
    .if HAS_COURSES
    IF_NONE MOTION, M_NEXT, .Lsession_19
    LIT 0
    F store LEFT
    .endif
.Lsession_19:
    LIT 3
    IF_ANY RUN, RUN_ACTIVE, run_finish
    LET RUN, 4
.Lsession_21:
.Lsession_m1:
    RETURN
    .balign 2, 0
    .global run_start
run_start:
    MICRO
.Lsession_run_start:
    IF_ANY BUTTON, P1_STOP, .Lsession_21
    DO blocking
    IF_NOT_EQUAL .Lsession_m1
    IF_IS RUN, RUN_PAUSED, run_resume
    IF_IS_NOT RUN, RUN_FAULT, .Lsession_23
    LET RUN, 0
    F word STORED
    IF_EQUAL .Lsession_24
    UP RUN
.Lsession_24:
.Lsession_25:
.Lsession_m2:
    RETURN
.Lsession_23:
    BITS_OFF RUN_FLAGS, R_WAITING
    IF_IS_NOT RUN, RUN_READY, .Lsession_25
    IF_SET MOVING, .Lsession_m2
run_begin:
    CALL program_attach
    F word VM_CODE
    IF_NOT_EQUAL .Lsession_26
    LIT F_IMAGE_REFUSED
    GOTO .Lsession_fail
run_resume:
    LET RUN, 2
    PROFILE B_SPINDLE
    DO output
    PUT TEMP
    F word RESUME_OUTPUT
    F put OUTPUT
    LIT 1
    F put SPIN
    IF_SET TEMP, .Lsession_m7
    PROFILE B_SPINDLE
    DO output
    IF_EQUAL .Lsession_m7
    F base BOARD
    FR word B_SPIN_UP, SHORT
    F add SPIN
    F put SPIN
.Lsession_m7:
.Lsession_m8:
    RETURN
    .balign 2, 0
    .global run_stopping
run_stopping:
    MICRO
    DO motion_rests
    IF_EQUAL .Lsession_30
    .if HAS_COURSES
    IF_ANY MOTION, M_THROUGH, .Lsession_32
    .endif
    GET EFFECT
    ADDI -OP_PROBE
    CMPI OP_HOME_QUERY-OP_PROBE+1
    IF_CARRY .Lsession_m8
.Lsession_32:
    END
    jmp run_goes
.Lsession_30:
    IF_ZERO ENDING, .Lsession_33
    LIT B_AT_END
    IF_IS_NOT ENDING, END_FAULT, .Lsession_34
    LIT B_AT_FAULT
.Lsession_34:
    DO output_states
    IF_ANY TRACING, T_FULL, .Lsession_m8
.Lsession_33:
    IF_SET LINE_STATE, .Lsession_m8
    CALL keep_save
    IF_SET ENDING, .Lsession_m3
    F word OUTPUT
    F put RESUME_OUTPUT
    LIT B_AT_PAUSE
    DO output_states
    LET RUN, 3
    RETURN
.Lsession_m3:
    GOTO run_ended
.Lsession_26:
    CALL clear_run
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
    IF_EQUAL .Lsession_27
    BITS_ON RUN_FLAGS, R_COURSES
    LIT16 COURSE
    F put VM_SP
    F put VM_BASE
    .endif
.Lsession_27:
    CALL keep_load
    LIT16 RUNS_MARK
    F put RUNNING
    LET RUN, 2
    .if HAS_EVENTS
    CALL stack_end
    F put VM_SP
    F put VM_BASE
    .endif
    BITS_OFF TRACING, ~(T_ON|T_HEARD|T_LOCKED)&0xff
    .if HAS_HALTS
    IF_NONE TRACING, T_ON, .Lsession_28
    BITS_ON TRACING, T_FULL
    .endif
.Lsession_28:
    END
    /* for an observer of the chip */
    .global run_begun
    run_begun:
    inc &RUNS
    br #motion_reset
run_ended:
    LET RUN, 1
    GET ENDING
    PUT LAST_END
    PUT N
    LET ENDING, 0
    .if HAS_COURSES
    BITS_OFF RUN_FLAGS, R_COURSES
    F clear JOINS
    .endif
    F clear OPEN
    F clear RUNNING
    CASE_NOT 3, .Lsession_38
    LET RUN, 4
    CALL fault_log
    GOTO .Lsession_39
.Lsession_38:
    LET VM_FAULT, 0
.Lsession_39:
    GET VM_FAULT
    EVENT TRACE_END
    F clear EFFECT
    F clear TIME+2
    RETURN
    .balign 2, 0
