/* Statements that move axes: what firmware/src/rules/pace.rs, axes.rs and lines.rs build on. A motion blocks: no other
   begins before MOVING is 0, but the next line of a course. */
    .section .text.micro,"axR",@progbits
module.moves:

    /* r13:r12, or 0 when it is negative. */
not_negative:
    tst r13
    jge 1f
    clr r12
    clr r13
1:  ret

    /* r5 = steps of Z, Y, X from bit 7 down, r7 = their frames, too: LinearMixed's, whose flags are
       r12 */
linear_mixed:
    mov r12, r5
    call #operand_byte
    mov r12, r7
    rla r7
    rla r7
    ret
    /* r12 = FRAME_OF of the next axis */
linear_frame:
    clr r12
    rla.b r7
    rlc r12
    rla.b r7
    rlc r12
    rla.b r5
    rlc r12
    rla r12
    rla r12
    ret

    /* r12 = flags of the short G0, G1 (X, Y, XY, Z, XYZ) or move r12. */
short_flags:
    mov.b short_moves-OP_RAPID(r12), r12
    ret
short_moves:
    .byte FL_RAPID+1, FL_RAPID+2, FL_RAPID+3, FL_RAPID+4, FL_RAPID+7, 1, 2, 3, 4, 7
    .byte 0, 1, 2, FL_RELATIVE, FL_RELATIVE+1, FL_RELATIVE+2
