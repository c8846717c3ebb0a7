/* The trace slot: one event for the host, which reads the slot of the next number when it has it. */

    .section .text.trace,"axR",@progbits
module.effects.trace:

/* Traces r12 = TraceKind | argument << 8 with value r15:r14 (emit_small: r14) when the host wants it;
   the slot is free. Leaves r12 = DONE. */
    .global emit, emit_small
emit_small:
    clr r15
emit:
    bit.b #T_ON, &TRACING
    jeq 1f
    bis.b #T_FULL, &TRACING
    inc &TRACE_NUMBER
    mov r12, &TRACE_KIND
    mov &EFFECT_PC, r12
    sub &VM_CODE, r12
    mov r12, &TRACE_PC
    mov r14, &TRACE_VALUE
    mov r15, &TRACE_VALUE+2
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
