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
/* Traces the event of kind r14 with argument r15 and value r13:r12 when the host wants it; the slot is
   free. Leaves r12 = DONE. */
    .global emit
emit:
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

/* r12 = the register r12 behind TRACE_EVEN. The slot of the other parity reads 0, and to read it
   says that the event was received. Clobbers r13. */
    .global trace_slot
trace_slot:
    clr r13
    cmp #TRACE_ODD_AT, r12
    rlc r13
    xor &TRACE_NUMBER, r13
    and #7, r12
    bit #1, r13
    jne 1f
    rla r12
    cmp #2*TRACE_LENGTH, r12
    jhs 2f
    mov TRACE_NUMBER(r12), r12
    ret
1:  bic.b #T_FULL, &TRACING
2:  clr r12
    ret
