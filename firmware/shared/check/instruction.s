/* An instruction: its shape, and the depth behind it. */

    /* reads the instruction at r4; uses r11, r12, r15 */
verify_insn:
    /* the whole check takes longer than the watchdog's 43 ms */
    mov #CHECK_KICK, &CHECK_WATCHDOG
    mov.b @r4, r5
    .if CHECK_COMPACT
    mov r5, r12
    sub.b #CHECK_LOW, r12
    mov #CHECK_SHAPES, r11
1:  mov @r11+, r6
    mov r6, r15
    and #3, r15
    mov.b CHECK_LENGTHS(r15), r15
    sub r15, r12
    jc 1b
    .else
    mov r5, r6
    sub #CHECK_EFFECT_SHIFT, r6
    cmp #CHECK_FIRST_EFFECT, r5
    jhs 1f
    mov r5, r6
    cmp #CHECK_LOW, r5
    jlo 1f
    sub #CHECK_LOW, r6
    rra r6
    rra r6
    rra r6
    rra r6
    add #CHECK_LOW, r6
1:  mov.b CHECK_INDEX(r6), r6
    mov CHECK_SHAPES(r6), r6
    .endif
    mov r6, r8
    swpb r8
    mov r8, r7
    and #3, r8
    rra r7
    rra r7
    rra r7
    rra r7
    and #7, r7
    inc r7
    add r4, r7
    cmp #CHECK_FIRST_EFFECT, r5
    jlo 4f
    mov #CHECK_MASKS, r11
2:  cmp.b @r11+, r5
    jeq 3f
    incd r11
    cmp #CHECK_MASKS+CHECK_MASKS_LEN, r11
    jlo 2b
    ret
3:  mov.b 1(r4), r12
    and.b @r11+, r12
    call #verify_count
    mov.b 2(r4), r12
    and.b @r11, r12
    /* adds the bits of r12 to r8 */
verify_count:
    clrc
    rrc r12
    adc r8
    tst r12
    jne verify_count
4:  ret

    /* on behind the instruction, with the depth there; uses r11, r15 */
verify_after:
    mov r7, r4
    sub r8, r9
    jn verify_fail
    mov r6, r11
    swpb r11
    rra r11
    rra r11
    and #3, r11
    add r11, r9
    mov @r10, r15
    mov.b CHECK_FRAME_DEPTH-CHECK_CODE(r15), r15
    cmp r9, r15
    jlo verify_fail
    /* values in the code come on the stack for their effect only */
    cmp.b #CHECK_PLAIN, r6
    jhs 1f
    sub r11, r9
1:  bit #CHECK_ENDS, r6
    jeq 1f
    clr r9
1:  ret
