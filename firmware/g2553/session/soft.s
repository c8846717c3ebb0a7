/* Instructions that the VM's core leaves: error handlers, lines, lengths and steps. */

    .section .text.soft,"axR",@progbits
module.session.soft:

/* Executes the pure instruction r12. Leaves r12 = 0 or a fault, F01 as FAULTED + 1. Destroys r8 to r15. */
    .global soft
soft:
    sub #OP_ERR, r12
    cmp #6, r12
    jhs soft_convert
    .if HAS_LINES
    rla r12
    add r12, r0
    jmp soft_err
    jmp soft_erl
    jmp soft_leave
    jmp soft_on_error
    jmp soft_on_error_stop
    jmp soft_resume_next
soft_erl:
    mov.b &VM_FAULT, r12
    tst r12
    jeq soft_push
    mov &VM_FAULT_PC, r12
    call #line_of
    jmp soft_push
soft_err:
    mov.b &VM_FAULT, r12
    .else
    /* without handlers a program sees no fault: ERR and ERL are 0 */
    clr r12
    .endif
soft_push:
    call #push_small
    jmp soft_done

/* ToSteps, ToLength: the lower bit of the code tells them apart. */
soft_convert:
    rla r12
    rla r12
    MICRO
    PUT FRAME_OF
    DO operand_byte
    .if HAS_COURSES
    /* Course, by its code */
    IF_NONE FRAME_OF, 8, 2f
    .endif
    DO axis_select
    F load VM_TOP
    CALL to_other
    IF_CARRY 1f
    F store VM_TOP
    DONE_
1:  FAULT F_OVERFLOW
    .if HAS_COURSES
    /* slow points, behind a length byte; not while others are left, nor where each line waits for a host, nor
       behind that: in a loop they would be those of its first pass */
2:  PUT TEMP
    DO operand_byte
    PUT TEMP+1
    IF_ANY MOTION, M_COURSE, 1f
    IF_NONE TRACING, T_ON, 2f
    BITS_OFF RUN_FLAGS, R_COURSES
2:  IF_NONE RUN_FLAGS, R_COURSES, 1f
    BITS_ON MOTION, M_COURSE
    LIT 1
    F add TEMP
    F add VM_DATA
    F put COURSE_AT
    F clear COURSE_LINES
1:  DONE_
    .endif
    .balign 2, 0

    .if HAS_LINES
soft_on_error:
    mov &VM_PC, r14
    call #word_at
    mov r14, &VM_PC
    add &VM_CODE, r11
    jmp 1f
soft_on_error_stop:
    clr r11
1:  mov r11, &VM_HANDLER
    jmp soft_done

/* A GOTO out of the error handler itself leaves everything that is open; where nothing is, that changes
   nothing. */
soft_leave:
    mov &VM_CALLS, r14
    mov.b -1(r14), r12
    and #0xf0, r12
    cmp #CALL_ERROR/256, r12
    jne soft_done
    mov #POOL, &VM_CALLS
    .if HAS_EVENTS
    bic.b #VM_EVENT, &VM_FLAGS
    call #stack_end
    mov r12, &VM_BASE
    .else
    mov #POOL_END, &VM_BASE
    .endif
    jmp 3f

soft_resume_next:
    mov #F_STACK, r12
    bit.b #VM_ERROR, &VM_FLAGS
    jeq 9f
    /* what the handler left open goes with it */
1:  decd &VM_CALLS
    mov &VM_CALLS, r14
    mov @r14, r12
    mov r12, r13
    and #0xf000, r13
    jge 2f
    /* depth of the FUNCTION's caller times 4 */
    swpb r13
    and #0x70, r13
    rra r13
    rra r13
    add r13, &VM_BASE
    jmp 1b
2:  cmp #CALL_ERROR, r13
    jne 1b
    bic r13, r12
    add &VM_CODE, r12
    call #line_of
    mov r13, &VM_PC
    MICRO
    F load FEED_ASIDE
    F store FEED
    END
3:  bic.b #VM_ERROR, &VM_FLAGS
    call #run_unwind
    .endif
soft_done:
    clr r12
9:  ret

    .if HAS_LINES

/* r12 = the line of the statement whose code holds address r12, 0 when the program tells none;
   r13 = where RESUME NEXT goes on. Clobbers r11, r14, r15. The statement table:
   `lang::image::statements`. */
    .global line_of
line_of:
    push r10
    push r9
    clr r15
    mov &VM_CODE, r9
    tst r9
    jeq 6f
    cmp &VM_DATA, r12
    jhs 6f
    bit.b #FEATURE_LINES, 1-IMAGE_CODE(r9)
    jeq 6f
    mov &VM_DATA, r14
    .if HAS_EVENTS
    /* behind the ON lines */
    bit.b #FEATURE_EVENTS, 1-IMAGE_CODE(r9)
    jeq 1f
    mov.b @r14+, r11
    add r11, r14
    add r11, r14
1:
    .endif
    call #word_at
    mov &VM_DATA, r14
    add r11, r14
    /* r9 = the next entry's code */
1:  cmp r9, r12
    jlo 6f
    /* head: bytes of code, bit 5 resume address, line */
    mov.b @r14+, r10
    mov r10, r11
    and #31, r11
    add r11, r9
    cmp #31, r11
    jne 2f
    mov.b @r14+, r11
    add r11, r9
2:  rla.b r10
    jn 3f
    jnc 5f
    mov.b @r14+, r11
    add r11, r15
    jmp 5f
3:  jc 4f
    inc r15
    jmp 5f
4:  call #word_at
    mov r11, r15
5:  mov r9, r13
    bit #64, r10
    jeq 1b
    call #word_at
    mov r11, r13
    add &VM_CODE, r13
    jmp 1b
6:  mov r15, r12
    pop r9
    pop r10
    ret

/* r11 = the word at r14, which need not be even; r14 moves behind it. Clobbers r13. */
    .global word_at
word_at:
    mov.b @r14+, r11
    mov.b @r14+, r13
    swpb r13
    bis r13, r11
    ret
    .endif
