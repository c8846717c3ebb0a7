/* The two passes over the code, and where jumps lead. */

    /* the number of the block that offset \r lies in */
    .macro BLOCK_OF r
    .if CHECK_BLOCK == 64
    rla \r
    rla \r
    .endif
    swpb \r
    mov.b \r, \r
    .endm

    /* first pass: instructions, operands, depths; leaves the anchors */
verify_code:
    mov #CHECK_ANCHORS, r12
    .if CHECK_COMPACT
    /* the scratch memory is the pool */
1:  mov.b #-1, CHECK_SCRATCH+CHECK_ANCHOR-1(r12)
    .else
    mov r10, r11
1:  mov.b #-1, CHECK_ANCHOR(r11)
    inc r11
    .endif
    dec r12
    jne 1b
    mov @r10, r4
    clr r9
2:  tst r9
    jne 3f
    mov r4, r12
    sub @r10, r12
    mov r12, r11
    BLOCK_OF r11
    and #CHECK_BLOCK-1, r12
    add r10, r11
    cmp.b #-1, CHECK_ANCHOR(r11)
    jne 3f
    mov.b r12, CHECK_ANCHOR(r11)
3:  call #verify_insn
    cmp r7, CHECK_CODE_END(r10)
    jlo verify_fail
    tst r6
    jge 4f
    cmp r8, r9
    jne verify_fail
4:  cmp #CHECK_FUNC, r5
    jne 5f
    cmp #8, r9
    jhs verify_fail
5:  call #verify_operands
    call #verify_after
    cmp CHECK_CODE_END(r10), r4
    jlo 2b
    bit #CHECK_ENDS, r6
    jeq verify_fail

    /* second pass: jumps */
    mov @r10, r4
    clr r9
1:  call #verify_insn
    /* r13 = target, r14 = depth there; r4, r9 behind the instruction */
    mov r9, r14
    sub r8, r14
    call #verify_after
    cmp.b #CHECK_SUB_NEAR, r6
    jlo 6f
    mov.b -1(r4), r13
    cmp.b #CHECK_DISTANCE, r6
    jhs 4f
    cmp.b #CHECK_ADDRESS, r6
    jhs 2f
    clr r14
    cmp.b #CHECK_SUB_FAR, r6
    jlo 3f
2:  swpb r13
    mov.b -2(r4), r15
    bis r15, r13
3:  add @r10, r13
    jmp 5f
4:  sxt r13
    add r4, r13
5:  push r4
    push r9
    call #verify_lands
    pop r9
    pop r4
6:  cmp CHECK_CODE_END(r10), r4
    jlo 1b

    /* targets that stand elsewhere: main program, ON lines, statement table */
    mov @r10, r6
    mov CHECK_ENTRY-CHECK_CODE(r6), r13
    call #verify_start
    .if CHECK_HAS_EVENTS | CHECK_HAS_LINES
    mov CHECK_CODE_END(r10), r5
    mov @r10, r6
    mov.b 1-CHECK_CODE(r6), r6
    .endif
    .if CHECK_HAS_EVENTS
    bit #CHECK_EVENTS, r6
    jeq 2f
    cmp CHECK_IMAGE_END(r10), r5
    jhs verify_fail
    mov.b @r5+, r4
    tst r4
    jeq 2f
    cmp #CHECK_MAX_EVENTS+1, r4
    jhs verify_fail
    .if CHECK_EVENT_POOL
    mov #CHECK_EVENT_POOL, r13
    mov r4, r12
3:  add #CHECK_EVENT_BYTES, r13
    dec r12
    jne 3b
    cmp r13, CHECK_FREE(r10)
    jlo verify_fail
    .endif
1:  push r4
    push r6
    call #verify_word
    push r5
    call #verify_start
    pop r5
    pop r6
    pop r4
    dec r4
    jne 1b
2:
    .endif
    .ifdef CHECK_AT_LIMITS
    /* limits of AT variables: a column of whole entries; its place stands behind the statement table's */
    mov @r10, r4
    bit.b #CHECK_AT_LIMITS, CHECK_MACHINE-CHECK_CODE(r4)
    jeq 2f
    push r5
    bit #CHECK_LINES, r6
    jeq 1f
    incd r5
1:  call #verify_word
    mov r13, r12
    call #verify_column
    bit #3, r15
    jne verify_fail
    pop r5
2:
    .endif
    .if CHECK_HAS_LINES
    bit #CHECK_LINES, r6
    jeq verify_good
    call #verify_word
    mov r13, r5
    add CHECK_CODE_END(r10), r5
    jc verify_fail
    cmp r5, CHECK_IMAGE_END(r10)
    jlo verify_fail
    mov @r10, r14
    /* r5 = entry, r14 = address of its statement */
3:  cmp CHECK_IMAGE_END(r10), r5
    jhs verify_table_end
    mov.b @r5+, r11
    mov r11, r12
    and #31, r12
    cmp #31, r12
    jne 4f
    mov.b @r5+, r13
    add r13, r12
4:  bit #0x80, r11
    jeq 5f
    inc r5
    bit #0x40, r11
    jeq 5f
    inc r5
5:  cmp r5, CHECK_IMAGE_END(r10)
    jlo verify_fail
    push r5
    push r11
    push r12
    push r14
    mov r14, r13
    call #verify_place
    pop r14
    pop r12
    pop r11
    pop r5
    add r12, r14
    bit #32, r11
    jeq 7f
    call #verify_word
    push r5
    push r14
    call #verify_start
    pop r14
    pop r5
    jmp 8f
7:  /* RESUME NEXT goes on behind the entry, inside the code */
    push r5
    push r14
    mov r14, r13
    call #verify_place
    pop r14
    pop r5
8:  cmp CHECK_CODE_END(r10), r14
    jlo 3b
    jmp verify_good
    /* a fault finds its statement; the last instruction, an END, needs none */
verify_table_end:
    inc r14
    cmp CHECK_CODE_END(r10), r14
    jlo verify_fail
    .endif
verify_good:
    clr r15
    jmp verify_leave

    /* every way out */
verify_fail:
    mov #CHECK_CODE_REFUSAL, r15
verify_leave:
    mov CHECK_FRAME(r10), r1
    mov r15, r12
    .if CHECK_SAVES
    pop r10
    pop r9
    pop r8
    pop r7
    pop r6
    pop r5
    pop r4
    .endif
    ret

    .if CHECK_HAS_EVENTS | CHECK_HAS_LINES
    /* r13 = number at r5, which lies in the image; r5 behind it */
verify_word:
    mov r5, r13
    incd r13
    cmp r13, CHECK_IMAGE_END(r10)
    jlo verify_fail
    mov.b @r5+, r13
    mov.b @r5+, r15
    swpb r15
    bis r15, r13
    ret
    .endif

    /* A statement begins at address r13 of the code. Reads on from instruction r4 with depth r9 before
       it, or from an anchor when the address lies far from there; r4 and r9 end at it. Uses r5 to r8. */
verify_start:
    add @r10, r13
verify_place:
    clr r14
    /* an instruction begins at r13 with depth r14 before it */
verify_lands:
    cmp CHECK_CODE_END(r10), r13
    jhs verify_fail
    mov r13, r11
    sub @r10, r11
    jlo verify_fail
    mov r13, r12
    sub r4, r12
    cmp #CHECK_BLOCK, r12
    jlo 4f
    BLOCK_OF r11
1:  mov r10, r12
    add r11, r12
    mov.b CHECK_ANCHOR(r12), r4
    cmp.b #-1, r4
    jeq 2f
    mov r11, r15
    swpb r15
    .if CHECK_BLOCK == 64
    rra r15
    rra r15
    .endif
    add r15, r4
    add @r10, r4
    cmp r4, r13
    jhs 3f
2:  dec r11
    jge 1b
    mov @r10, r4
3:  clr r9
4:  cmp r13, r4
    jhs 5f
    call #verify_insn
    call #verify_after
    jmp 4b
5:  jne verify_fail
    cmp r14, r9
    jne verify_fail
    ret
