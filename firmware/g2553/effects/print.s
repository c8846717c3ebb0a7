/* PRINT: lines for the host in a ring. A line waits for room while a host traces, or takes what there
   is at least every half second; else it is dropped whole. */

    .section .text.print,"axR",@progbits
module.effects.print:

/* Appends byte r12 to the line and counts it in N. When there is no room yet the caller's caller goes
   on with NOT_YET. Clobbers r12, r14, r15. */
print_put:
    mov.b &PRINT_READY, r14
    add.b &PRINT_OPEN, r14
    cmp #PRINT_SIZE, r14
    jhs 1f
    add &PRINT_TAIL, r14
    and #PRINT_SIZE-1, r14
    mov.b r12, PRINT(r14)
    inc.b &PRINT_OPEN
    jmp 3f
1:  bit.b #T_ON, &TRACING
    jne 2f
    cmp.b #LISTENS/256, &UNHEARD+1
    jlo 2f
    bis.b #T_DROPPED, &TRACING
    /* an observer of the chip reads the byte in r12 */
    .global print_taken
print_taken:
3:  inc.b &N
    ret
    /* the line goes on when the host has taken some */
2:  incd r1
    call #print_flush
    mov #NOT_YET, r12
    ret

/* What was put so far becomes visible, and the host is told of the line. Leaves r12 = DONE. */
print_flush:
    add.b &PRINT_OPEN, &PRINT_READY
    clr.b &PRINT_OPEN
    bit.b #T_ANNOUNCED, &TRACING
    jne print_done
    bis.b #T_ANNOUNCED, &TRACING
    mov #TRACE_PRINT, r14
    clr r15
    clr r12
    clr r13
    jmp emit

/* A text: its length, then its bytes. */
    EFFECT OP_PRINT_TEXT, fx_print_text
fx_print_text:
    IF_NOT_EQUAL 1f
    DO operand_byte
    PUT TIME
    LIT 0
    IF_IS EFFECT, OP_PRINT_TEXT, 2f
    /* PrintTextFar */
    DO operand_byte
2:  PUT TIME+1
    F word TIME
    F add VM_DATA
    F put TIME
1:  END
    mov &TIME, r8
    mov.b @r8+, r9
    add r8, r9
/* The bytes from r8 to r9, of which N were put. */
print_rest:
    mov.b &N, r13
    add r8, r13
    cmp r9, r13
    jhs print_done
    mov.b @r13, r12
    call #print_put
    jmp print_rest
print_done:
    clr r12
    ret

/* A number. The digits are made anew at each call. */
    EFFECT OP_PRINT_NUMBER, fx_print_number
fx_print_number:
    IF_NOT_EQUAL 1f
    DO pop_value
    F store TIME
1:  F load TIME
    DO abs
    END
    mov #TEMP+12, r8
3:  mov #10, r14
    clr r15
    call #pasapas_udivmod
    add #'0', r10
    dec r8
    mov.b r10, 0(r8)
    mov r12, r10
    bis r13, r10
    tst r10
    jne 3b
    mov #TEMP+12, r9
    tst &TIME+2
    jge print_rest
    dec r8
    mov.b #'-', 0(r8)
    jmp print_rest

    EFFECT OP_PRINT_END, fx_print_end
fx_print_end:
    END
    mov #'\n', r12
    call #print_put
    bit.b #T_DROPPED, &TRACING
    jeq 1f
    clr.b &PRINT_OPEN
1:  call #print_flush
    bic.b #T_ANNOUNCED+T_DROPPED, &TRACING
    ret
