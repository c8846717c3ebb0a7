/* Information memory: two copies of the board's profile, the log of faults. */

    .section .text.store,"axR",@progbits
module.store.profile:
    .global profile_newest
/* BOARD = the profile in use: the latest of two whole copies and that of a board never given one,
   whose sequence number is 0. Uses r11 to r15. */
profile_newest:
    mov #BOARD_DEFAULT, &BOARD
    mov #PROFILE_FIRST, r12
    call #1f
    mov #PROFILE_SECOND, r12
1:  push r12
    call #profile_whole
    pop r12
    jne 3f
    mov &BOARD, r13
    mov @r12, r14
    sub @r13, r14
    dec r14
    jl 3f
    mov r12, &BOARD
3:  ret

/* r12 = address of a copy; leaves Z set when it is whole; uses r11 to r15. */
    .section .tail.whole,"axR",@progbits
module.store.profile$whole:
profile_whole:
    cmp #RECORD_VERSION, 2(r12)
    jne 1f
    mov r12, r15
    mov #BOARD_SIZE, r11
    call #crc_of
    tst r12
1:  ret

    .section .text.store,"axR",@progbits
    .global profile_word
/* r12 = index in the record, r13 = word, for the copy that is not in use; leaves r12 = 0 or an
   Exception: the last word makes the copy valid. Uses r11 to r15. */
profile_word:
    call #only_idle
    tst.b &TRACING
    jn unlock
    mov #PROFILE_FIRST, r15
    cmp r15, &BOARD
    jne 1f
    mov #PROFILE_SECOND, r15
1:  rla r12
    add r15, r12
    cmp r15, r12
    jne 2f
    call #flash_erase
2:  mov r12, r11
    call #word_write
    sub r15, r11
    cmp #BOARD_SIZE-2, r11
    jne 3f
    mov r15, r12
    call #profile_whole         ; leaves r12 = 0 when it is
    jne refused
3:  ret

/* A word of the lock's code, from profile_word. The high one opens the lock when both were right and
   none before was wrong. */
unlock:
    rla r12
    mov &BOARD, r15
    add r12, r15
    sub #B_LOCK, r12
    cmp #4, r12
    jhs refused
    cmp @r15, r13
    MICRO
    IF_EQUAL 1f
    BITS_ON RUN_FLAGS, R_WRONG
1:  CASE_NOT 0, 2f
    BITS_ON RUN_FLAGS, R_HALF
    RETURN
2:  GET RUN_FLAGS
    ANDI R_HALF|R_WRONG
    CASE_NOT R_HALF, 3f
    BITS_OFF TRACING, T_LOCKED
    DONE_
3:  LIT EX_DEVICE_FAILURE
    RETURN
    .balign 2, 0

    .global fault_log
/* Appends the last fault to the log: number and input, place in the code, line, and their exclusive
   or. Uses r11 to r15. */
fault_log:
    .if HAS_LINES
    mov &VM_FAULT_PC, r12
    call #line_of
    push r12
    .endif
    mov #LOG, r12
1:  cmp #-1, 0(r12)
    jeq 2f
    add #8, r12
    cmp #LOG+64, r12
    jne 1b
    mov #LOG, r12
    call #flash_erase
2:  clr r11
    /* FAULT_IN lies in the high half */
    mov &VM_FAULT, r13
    call #3f
    mov &VM_FAULT_PC, r13
    sub &VM_CODE, r13
    call #3f
    .if HAS_LINES
    pop r13
    .else
    clr r13
    .endif
    call #3f
    mov r11, r13
3:  xor r13, r11
    call #flash_write
    incd r12
    ret
