/* The trace slot: one event for the host, which reads the slot of the next number when it has it. */

    .section .text.trace,"axR",@progbits
module.effects.trace:

/* Operations of micro-code. They trace the event with the byte that follows as its kind, N as its
   argument, r13:r12 as its value: r12 = DONE. micro_event_ok: with TRACE_OK. */
micro_event_ok:
    mov.b #TRACE_OK, r15
    jmp 1f
micro_event:
    clr r15
1:  bis.b &N, r15
    mov.b @r10+, r14
/* An observer of the chip reads its registers here, whether a host traces or not.
   Traces the event of kind r14 with argument r15 and value r13:r12 when the host wants it; the slot is
   free. Leaves r12 = DONE. */
    .global emit
emit:
    .if HAS_COURSES
    /* the lines of a course do not wait for a host */
    bit.b #M_COURSE, &MOTION
    jne 1f
    .endif
    bit.b #T_ON, &TRACING
    jeq 1f
    bis.b #T_FULL, &TRACING
    inc &TRACE_NUMBER
    mov.b r14, &TRACE_KIND
    mov.b r15, &TRACE_ARGUMENT
    mov &EFFECT_PC, r14
    sub &VM_CODE, r14
    mov r14, &TRACE_PC
    mov r12, &TRACE_VALUE
    mov r13, &TRACE_VALUE+2
1:  clr r12
    ret
