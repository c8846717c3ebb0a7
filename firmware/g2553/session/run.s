/* The program between its effects: VM slices, effects, the end of a run.

   The VM's registers lie in RAM between slices, so an effect takes arguments by the routines below.
   Motion statements are done when the machine rests: nothing else of a program runs while it moves. */

    .section .text.vm_glue,"axR",@progbits
module.session.run$glue:

/* r13:r12 = the top of the expression stack, taken from it. Clobbers r14. */
    .global pop_value
pop_value:
    mov &VM_TOP, r12
    mov &VM_TOP+2, r13
    mov &VM_SP, r14
    /* mov @r14+, &address, which LLVM's assembler refuses */
    .short 0x4eb2, VM_TOP, 0x4eb2, VM_TOP+2
    mov r14, &VM_SP
    ret

/* Puts r13:r12 (push_small: r12) on the expression stack. Clobbers r14, r15. */
    .global push_value
push_small:
    clr r13
push_value:
    mov #VM_SP, r15
    sub #4, 0(r15)
    mov @r15+, r14
    .short 0x4fbe, 0            /* mov @r15+, 0(r14), which LLVM's assembler refuses */
    mov @r15, 2(r14)
    mov r13, 0(r15)
    mov r12, -2(r15)
    ret

/* r12 = the next operand byte. Clobbers r14. */
    .global operand_byte
operand_byte:
    mov &VM_PC, r14
    mov.b @r14, r12
    inc &VM_PC
    ret

    .section .text.run,"axR",@progbits
module.session.run:

    /* lines that are joined are one: what else the main loop does waits until the last of them is planned */
    .macro GO_ON_JOINED
    .if HAS_COURSES
    tst.b &JOINS
    jne run_goes
    .endif
    .endm

/* One pass of the program. Destroys all registers. */
    .global run
run:
    mov.b &RUN, r12
    cmp #RUN_RUNNING, r12
    jeq 1f
    bit #RUN_ACTIVE, r12
    jeq 2f
    /* RUN_PAUSED, not RUN_STOPPING */
    bit #1, r12
    jeq run_stopping
    ret
    /* homing or probing by command */
2:  tst.b &EFFECT
    jeq 9f
    call #effect_poll
    cmp #NOT_YET, r12
    jeq 9f
    call #command_done
    jmp run_no_effect

1:
run_goes:
    tst.b &EFFECT
    jne run_perform
    .if HAS_LINES
    /* a ramp that a fault began, for its handler; what moves else is a line that goes on through its end */
    .if HAS_COURSES
    bit.b #M_THROUGH, &MOTION
    jne 1f
    .endif
    tst.b &MOVING
    jne 9f
1:
    .endif
    clr.b &VM_POLL
    call #pasapas_vm_run
    mov &VM_PC, &EFFECT_PC
    cmp #0x200, r12
    .if HAS_EVENTS
    jeq event_serve
    .endif
    jhs run_left
    dec &EFFECT_PC
    cmp #0x100, r12
    jhs raise
    cmp #OP_FIRST_EFFECT, r12
    jhs 3f
    tst r12
    jne 2f
    mov.b #EFFECT_END-0x100, r12
    /* PHASE is 0 then */
3:  mov r12, &EFFECT
    clr &N
    .if HAS_EVENTS
    /* what ends its statement, and what does not */
    mov.b &VM_FLAGS, r14
    and #VM_MORE, r14
    rla r14
    bic.b #VM_MORE|VM_WITHIN, &VM_FLAGS
    bis.b r14, &VM_FLAGS
    .endif
run_perform:
    bit.b #T_FULL, &TRACING
    jeq 1f
    /* a line goes on whose event fills the slot: the host takes it before the next one */
    bit.b #T_ANNOUNCED, &TRACING
    .if HAS_HALTS
    jne 1f
    /* so does what told its only event at its beginning: a wait, and a motion */
    tst.b &PHASE
    jeq 9f
    cmp.b #OP_WAIT, &EFFECT
    jeq 1f
    cmp.b #OP_PROBE, &EFFECT
    jhs 9f
    .else
    jeq 9f
    .endif
1:  call #effect_poll
    /* no fault is number 1 */
run_done:
    cmp #NOT_YET, r12
    .if HAS_EVENTS
    jeq event_serve
    .else
    jeq 9f
    .endif
    jhs raise
    mov &VM_PC, &EFFECT_PC
    .if HAS_EVENTS
    call #run_no_effect
    GO_ON_JOINED
    jmp event_serve
    /* the handler of an ON line is left; a wait that it interrupted may be over, which comes first */
run_left:
    dec &EFFECT_PC
    call #event_left
    tst.b &EFFECT
    jeq event_serve
    ret
    .else
    .set run_left, run_idle
    .endif
run_no_effect:
    clr &EFFECT
    clr &TIME+2
    .if !HAS_EVENTS
    GO_ON_JOINED
    .endif
run_idle:
9:  ret

2:  call #soft
    jmp run_done

/* A fault of the instruction at EFFECT_PC is raise of firmware/src/rules/handlers.rs, without handlers fail. Takes
   r12 = fault (the high byte is ignored). The other faults that no handler takes never come here. Destroys r11 to
   r15. */
    .if HAS_LINES
/* The expression stack is that of the open routine's beginning. Clobbers r14. */
run_unwind:
    mov &VM_BASE, r14
    cmp &VM_SP, r14
    jeq 1f
    mov r14, &VM_SP
    mov -4(r14), &VM_TOP
    mov -2(r14), &VM_TOP+2
1:  ret

/* An entry of the call stack for the handler of the fault at EFFECT_PC: Z set when there is no room, or no table of
   statements, without which nothing says where RESUME NEXT goes on. Clobbers r11, r12, r14. */
    .global handler_open
handler_open:
    mov &VM_CODE, r14
    bit.b #FEATURE_LINES, 1-IMAGE_CODE(r14)
    jeq 1f
    mov &EFFECT_PC, r12
    mov #CALL_ERROR, r11
/* An entry of the call stack: kind r11, place in the code of the address r12, which is destroyed. Z set
   when there is no room. Clobbers r14. */
    .global call_entry
call_entry:
    mov &VM_CALLS, r14
    cmp &VM_CELLS, r14
    jeq 1f
    sub &VM_CODE, r12
    bis r11, r12
    mov r12, 0(r14)
    incd &VM_CALLS
1:  ret
    .else
    .set raise, fail
    .endif
