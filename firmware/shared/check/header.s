/* The way in and the header. */

    /* where there is memory for them, 255 stands for 256 */
    .macro cells_of count
    .if CHECK_CALL_BYTES == 4
    cmp.b #-1, \count
    jne 9f
    inc \count
9:
    .endif
    .endm

    .section .text.verify,"ax",@progbits
module.check:
    .global pasapas_verify
pasapas_verify:
    .if CHECK_SAVES
    push r4
    push r5
    push r6
    push r7
    push r8
    push r9
    push r10
    .endif
    mov r14, r10
    mov r1, CHECK_FRAME(r10)
    mov r12, r4

    /* header */
    mov #CHECK_VERSION, r15
    cmp.b #CHECK_FORMAT, 0(r4)
    jne verify_leave
    cmp #CHECK_FINGERPRINT, 2(r4)
    jne verify_leave
    mov #CHECK_FEATURE, r15
    .if CHECK_COMPACT
    bit.b #~CHECK_FEATURES, 1(r4)
    .else
    mov.b 1(r4), r11
    bic.b r13, r11
    tst.b r11
    .endif
    jne verify_leave
    mov #CHECK_MEMORY, r15
    mov.b CHECK_CELLS(r4), r11
    cells_of r11
    mov.b CHECK_STACK(r4), r12
    cmp.b CHECK_FRAME_DEPTH(r4), r12
    jlo verify_leave
    /* 4 (cells + stack) + 2 calls = 2 (2 (cells + stack) + calls), or 4 (cells + stack + calls) */
    add r11, r12
    .if CHECK_CALL_BYTES == 2
    rla r12
    .endif
    mov.b CHECK_CALLS(r4), r13
    add r13, r12
    .if CHECK_CALL_BYTES == 4
    rla r12
    .endif
    rla r12
    .if CHECK_EVENT_POOL | (CHECK_POOL_MANY-CHECK_POOL_ONE)
    mov #CHECK_POOL_MANY, r14
    .if CHECK_POOL_MANY-CHECK_POOL_ONE
    bit.b #CHECK_MANY, 1(r4)
    jne 1f
    mov #CHECK_POOL_ONE, r14
1:
    .endif
    sub r12, r14
    jlo verify_leave
    .if CHECK_EVENT_POOL
    mov r14, CHECK_FREE(r10)
    .endif
    .else
    cmp #CHECK_POOL_ONE+1, r12
    jhs verify_leave
    .endif
    mov.b CHECK_KEEPS(r4), r13
    cmp #CHECK_MAX_KEEPS+1, r13
    jhs verify_leave
    mov.b CHECK_KEEP_BASE(r4), r12
    add r13, r12
    cmp r12, r11
    jlo verify_leave
    mov CHECK_LEN(r4), r12
    add r4, r12
    mov r12, CHECK_IMAGE_END(r10)
    mov CHECK_CODE_LEN(r4), r13
    /* axes that are there have a scale; the code follows the last one, and the first pass finds no
       room for an instruction in none */
    add #CHECK_AXES, r4
    mov #3, r11
2:  bit #CHECK_PRESENT, 0(r4)
    jeq 3f
    tst 2(r4)
    jeq verify_fail
    tst 4(r4)
    jeq verify_fail
3:  add #CHECK_AXIS_SIZE, r4
    dec r11
    jne 2b
    .if CHECK_AXES + 3 * CHECK_AXIS_SIZE - CHECK_CODE
    .error "the axes' records end where the code begins"
    .endif
    mov r4, CHECK_CODE_START(r10)
    add r13, r4
    mov r4, CHECK_CODE_END(r10)
    cmp r4, CHECK_IMAGE_END(r10)
    jlo verify_fail
