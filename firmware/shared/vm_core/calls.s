/* Calls: an entry of the call stack is 12 bits of return address and 4 of kind, or a word of address and one with
   the kind in the same 4 bits. */

    .if CORE_EVENTS
vm_more:
    bis.b #CORE_MORE, &CORE_VM+CORE_FLAGS
    jmp vm_next
    .endif

vm_call:
    mov.b @r5+, r12
    jmp 1f
vm_callfar:
    WORD
1:  mov #CORE_KIND_SUB, r14
    jmp vm_enter
vm_gosub:
    WORD
    /* kind 0 */
    clr r14
    jmp vm_enter
vm_func:
    /* a routine's deepest expression has room above the cells: nothing else bounds a FUNCTION that calls
       itself, which the compiler refuses but an image may hold */
    mov.b CORE_IMAGE_FRAME(r4), r13
    mov.b CORE_IMAGE_CELLS(r4), r15
    .if CORE_CALL_BYTES == 4
    /* 255 stands for 256 */
    cmp.b #-1, r15
    jne 1f
    inc r15
1:
    .endif
    add r15, r13
    rla r13
    rla r13
    add r7, r13
    cmp r13, r6
    jlo vm_no_call
    WORD
    mov &CORE_VM+CORE_BASE, r14
    mov r6, &CORE_VM+CORE_BASE
    sub r6, r14
    /* depth times 4 into the bits above 12, with the FUNCTION bit */
    swpb r14
    rla r14
    rla r14
    bis #0x8000, r14
vm_enter:
    mov &CORE_VM+CORE_CALLS, r15
    cmp &CORE_VM+CORE_CALLS_END, r15
    jhs vm_no_call
    sub r4, r5
    .if CORE_CALL_BYTES == 4
    mov r14, 2(r15)
    mov r5, 0(r15)
    add #4, &CORE_VM+CORE_CALLS
    .else
    bis r14, r5
    mov r5, 0(r15)
    incd &CORE_VM+CORE_CALLS
    .endif
    /* on at address r12 of the code */
vm_goto:
    mov r12, r5
    add r4, r5
    jmp vm_poll
vm_jumpfar:
    WORD
    jmp vm_goto

    /* r12 = the newest entry, dropped, r13 its kind in the top bits */
vm_entry:
    mov &CORE_VM+CORE_CALLS, r15
    cmp #CORE_CALLS_START, r15
    jeq vm_no_call
    .if CORE_CALL_BYTES == 4
    sub #4, r15
    mov r15, &CORE_VM+CORE_CALLS
    mov @r15, r12
    mov 2(r15), r13
    .else
    decd r15
    mov r15, &CORE_VM+CORE_CALLS
    mov @r15, r12
    mov r12, r13
    and #0xf000, r13
    bic r13, r12
    .endif
    ret
vm_exitsub:
    call #vm_entry
    tst r13
    jeq vm_exitsub
    jmp 1f
vm_return:
    call #vm_entry
1:  cmp #CORE_KIND_EVENT, r13
    jlo vm_goto
    .if CORE_EVENTS
    jne vm_no_call
    mov r12, r5
    add r4, r5
    mov #CORE_HANDLER_END, r12
    br #vm_exit
    .endif
vm_no_call:
    jmp vm_f16
vm_give:
    call #vm_entry
    tst r13
    jeq vm_give
    /* the FUNCTION bit, then the depth times 4 */
    rla r13
    jnc vm_no_call
    swpb r13
    rra r13
    rra r13
    rra r13
    add r13, &CORE_VM+CORE_BASE
    jmp vm_goto
