/* The program between its effects: VM slices, effects, the end of a run.

   The VM's registers lie in RAM between slices, so an effect takes arguments by the routines below.
   Motion statements are done when the machine rests: nothing else of a program runs while it moves. */

    .section .text.vm_glue,"axR",@progbits

/* r13:r12 = the top of the expression stack, taken from it. Clobbers r14. */
    .global pop_value
pop_value:
    mov &VM_TOP, r12
    mov &VM_TOP+2, r13
    mov &VM_SP, r14
    mov @r14, &VM_TOP
    mov 2(r14), &VM_TOP+2
    add #4, &VM_SP
    ret

/* Puts r13:r12 on the expression stack. Clobbers r14. */
    .global push_value
push_value:
    sub #4, &VM_SP
    mov &VM_SP, r14
    mov &VM_TOP, 0(r14)
    mov &VM_TOP+2, 2(r14)
    mov r12, &VM_TOP
    mov r13, &VM_TOP+2
    ret

/* r12 = the most that is wanted of the top, which is taken; leaves it in r12, or the most plus 1
   when it lies outside 0 to the most. Clobbers r13 to r15. */
    .global pop_small
pop_small:
    mov r12, r15
    call #pop_value
    tst r13
    jne 1f
    cmp r12, r15
    jhs 2f
1:  mov r15, r12
    inc r12
2:  ret

/* r12 = the next operand byte. Clobbers r14. */
    .global operand_byte
operand_byte:
    mov &VM_PC, r14
    mov.b @r14, r12
    inc &VM_PC
    ret

/* Gives the last operand byte back. */
    .global operand_back
operand_back:
    dec &VM_PC
    ret

    .section .text.run,"axR",@progbits

/* One pass of the program. Destroys all registers. */
    .global run
run:
    mov.b &RUN, r12
    cmp.b #RUN_RUNNING, r12
    jeq 1f
    cmp.b #RUN_STOPPING, r12
    jeq stopping
    cmp.b #RUN_PAUSED, r12
    jeq 9f
    /* homing or probing by command */
    tst.b &EFFECT
    jeq 9f
    call #effect_poll
    cmp #NOT_YET, r12
    jeq 9f
    call #command_done
    jmp effect_over
1:  tst.b &EFFECT
    jne run_perform
    /* a ramp that a command or a fault began */
    tst.b &MOVING
    jne 9f
    clr.b &VM_POLL
    call #pasapas_vm_run
    mov &VM_PC, &EFFECT_PC
    cmp #0x200, r12
    jhs 9f
    dec &EFFECT_PC
    tst r12
    jne 2f
    mov #EFFECT_END, r12
2:  cmp #OP_FIRST_EFFECT, r12
    jlo 3f
    cmp #0x100, r12
    jhs raise_here
    /* PHASE and what belongs to an effect begin at 0 */
    mov r12, &EFFECT
    clr &N
    clr &TIME
    clr &TIME+2
    jmp run_perform
3:  call #soft
    tst r12
    jne raise_here
9:  ret

run_perform:
    bit.b #T_FULL, &TRACING
    jeq 1f
    /* only a line goes on whose event fills the slot: the host takes it before the next one */
    bit.b #T_ANNOUNCED, &TRACING
    jeq 9b
    mov.b &EFFECT, r12
    sub #OP_PRINT_TEXT, r12
    cmp #OP_PRINT_END-OP_PRINT_TEXT+1, r12
    jhs 9b
1:  call #effect_poll
    cmp #NOT_YET, r12
    jeq 9b
    jlo effect_over
    mov &EFFECT_PC, r13
    jmp raise
effect_over:
    clr &EFFECT
    ret

raise_here:
    mov &VM_PC, r13
    dec r13

/* A fault of the program: its handler begins, or the run ends. Takes r12 = fault (the high byte is
   ignored), r13 = address in the failing statement. Clobbers r12 to r15. */
    .global raise
raise:
    mov.b r12, &VM_FAULT
    mov r13, &VM_FAULT_PC
    clr &EFFECT
    clr.b &PRINT_OPEN
    bic.b #T_DROPPED, &TRACING
    bit.b #VM_ERROR, &VM_FLAGS
    jne 2f
    tst &VM_HANDLER
    jeq 2f
    mov.b r12, r12
    cmp #F_LIMIT_SWITCH, r12
    jeq 2f
    mov r12, r14
    sub #F_FIRST_UNHANDLED, r14
    cmp #F_UNHANDLED, r14
    jlo 2f
    mov &VM_CALLS, r14
    cmp &VM_CELLS, r14
    jeq 2f
    sub &VM_CODE, r13
    bis #CALL_ERROR, r13
    mov r13, 0(r14)
    incd &VM_CALLS
    bis.b #VM_ERROR, &VM_FLAGS
    mov &VM_HANDLER, &VM_PC
    /* a handler has no F */
    mov &FEED, &FEED_ASIDE
    mov &FEED+2, &FEED_ASIDE+2
    clr &FEED
    clr &FEED+2
    call #unwind
    jmp motion_stop_far
2:  jmp fail_far

/* The expression stack is that of the open routine's beginning. Clobbers r14. */
unwind:
    mov &VM_BASE, r14
    cmp &VM_SP, r14
    jeq 1f
    mov r14, &VM_SP
    mov -4(r14), &VM_TOP
    mov -2(r14), &VM_TOP+2
1:  ret
motion_stop_far:
    br #motion_stop
fail_far:
    br #fail

/* On the ramp into a pause or to the end. */
stopping:
    call #motion_rests
    jne 9b
    bit.b #T_FULL, &TRACING
    jne 9b
    call #keep_save
    mov &OUTPUT, &RESUME_OUTPUT
    mov #B_AT_PAUSE, r12
    mov.b &ENDING, r11
    mov #RUN_PAUSED, r13
    tst r11
    jeq 1f
    mov #B_AT_END, r12
    mov #RUN_READY, r13
    cmp #END_FAULT, r11
    jne 1f
    mov #B_AT_FAULT, r12
    mov #RUN_FAULT, r13
1:  mov.b r13, &RUN
    call #output_states
    tst r11
    jeq 9b
    mov.b r11, &LAST_END
    clr.b &ENDING
    clr &OPEN
    bic.b #R_WAITING, &RUN_FLAGS
    clr &RUNNING
    clr r14
    cmp.b #END_FAULT, &LAST_END
    jne 1f
    call #fault_log
    mov.b &VM_FAULT, r14
    mov &VM_FAULT_PC, &EFFECT_PC
    jmp 2f
1:  clr.b &VM_FAULT
    cmp.b #END_STOPPED, &LAST_END
    jne 2f
    tst.b &EFFECT
    jne 2f
    mov &VM_PC, &EFFECT_PC
2:  clr r15
    mov.b &LAST_END, r12
    swpb r12
    bis #TRACE_END, r12
    call #emit
    jmp effect_over
