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
    mov #TRACE_PRINT, r12
    clr r14
    jmp emit_small

fx_print_text:
    END
    jne 1f
    call #operand_byte
    mov r12, r13
    /* PrintTextFar */
    bit.b #1, &EFFECT
    jeq 2f
    call #operand_byte
    swpb r12
    add r12, r13
2:  add &VM_DATA, r13
    mov r13, &TIME
1:  mov &TIME, r13
    mov.b &N, r12
    cmp.b @r13, r12
    jhs print_done
    add r12, r13
    mov.b 1(r13), r12
    call #print_put
    jmp 1b
print_done:
    clr r12
    ret

/* A number and its unit. The digits are made anew at each call and N counts what was put. */
fx_print_value:
    END
    jne 2f
    /* PrintValue */
    bit.b #1, &EFFECT
    jeq 1f
    call #operand_byte
    mov.b r12, &BITS
1:  call #pop_to_time
2:  mov #TEMP+12, r8
    mov &TIME, r12
    mov &TIME+2, r13
    call #pasapas_abs2
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
    tst &TIME+2
    jge 4f
    dec r8
    mov.b #'-', 0(r8)
    /* r9 = the unit's text, behind as many others as its number says */
4:  mov #print_units, r9
    mov.b &BITS, r13
5:  dec r13
    jl 6f
7:  mov.b @r9+, r12
    tst r12
    jne 7b
    jmp 5b
6:  mov.b &N, r13
    add r8, r13
    sub #TEMP+12, r13
    jhs 1f
    mov.b TEMP+12(r13), r12
    jmp 2f
1:  add r9, r13
    mov.b @r13, r12
    tst r12
    jeq print_done
2:  call #print_put
    jmp 6b

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

/* Suffixes by `lang::effect::Unit`. */
print_units:
    .asciz "", "um", "st", "ms", "um/s", "st/s", "um/s2", "st/s2"
    .balign 2, 0
