/* Effects that move axes to places: micro-code, entered with
   r12 = the effect's code, Z set in phase 0. They leave r12 = DONE, NOT_YET, or FAULTED plus the fault. A motion blocks:
   no other begins before MOVING is 0. */
    .section .text.micro,"axR",@progbits
module.moves:

    /* r13:r12, or 0 when it is negative. */
not_negative:
    tst r13
    jge 1f
    clr r12
    clr r13
1:  ret

    /* The axis r8 goes from ACTUAL to STEPS at the pace in TEMP: r12 = NOT_YET. */
    ROUTINE_ODD begin_axis
    DO axis_bit
    CALL axis_begin
    NOT_YET_

    /* The targets of the axes of FLAGS are commanded; RAMPS = those that have steps to make. */
    ROUTINE_ODD command_axes
    LET RAMPS, 0
    DO micro_first_axis
1:  IF_NOT_AXIS FLAGS, 2f
    DO command
    IF_EQUAL 2f
    DO axis_bit
    AXIS_ON RAMPS
2:  NEXT_AXIS 1b
    RETURN

    /* G0 and G1. A rapid move with Z apart is two lines; N holds the axes of the second. */
    EFFECT OP_LINEAR, fx_linear
    ROUTINE_ODD fx_linear
    IF_EQUAL 1f
    IF_SET MOVING, linear_moves
    IF_ZERO N, linear_done
    GET N
    LET N, 0
    DO line_rapid
    NOT_YET_
1:  PUT UNIT
    CMPI OP_RAPID
    IF_CARRY 0f
    DO operand_byte
    GOTO 2f
0:  DO short_flags
2:  PUT FLAGS
    IF_IS_NOT UNIT, OP_LINEAR_MIXED, 3f
    CALL linear_mixed
3:
    .if HAS_COURSES
    IF_ZERO MOVING, 1f
    /* in a course: from where the line before ends */
    BITS_ON MOTION, M_NEXT
    LIT 0
    F store NEXT_DIRS
    F store NEXT_COUNT+2
    DO micro_first_axis
2:  F load STEPS, AXIS
    F store ACTUAL, AXIS
    NEXT_AXIS 2b
1:
    .endif
    /* steps and frame of all axes */
    GET FLAGS
    DO half
    DO half
    DO half
    ANDI F_STEPS+F_MACHINE+F_RELATIVE
    PUT FRAME_OF
    /* all targets before any is commanded */
    DO micro_first_axis
4:  IF_IS_NOT UNIT, OP_LINEAR_MIXED, 3f
    CALL linear_frame
    PUT FRAME_OF
3:  IF_NOT_AXIS FLAGS, 5f
    DO axis_at
    DO pop_value
    DO aim
    DO or_return
5:  NEXT_AXIS 4b
    DO command_axes
    LIT 0
    .if HAS_COURSES
    /* targets lie there until here: of a line without a step nothing is left */
    F store LEFT
    .endif
    IF_ZERO RAMPS, linear_done
    IF_ANY FLAGS, FL_RAPID, 8f
    EVENT TRACE_LINE
    GET RAMPS
    DO line_begin
    .if HAS_COURSES
    DO motion_poll
linear_moves:
    /* done when the next line may be planned: all segments are made, and the first one plays */
    GET MOTION
    ANDI M_THROUGH|M_NEXT
    CASE_NOT M_THROUGH, linear_wait
    F load LEFT
    DO test_long
    IF_EQUAL linear_done
    .else
linear_moves:
    .endif
linear_wait:
    NOT_YET_
linear_done:
    DONE_
8:  EVENT TRACE_RAPID
    F base STORED
    FR word PROGRAM_MACHINE+MC_FLAGS, SHORT
    TESTI MC_RAPID_Z_APART
    IF_EQUAL 3f
    /* Z and another */
    GET RAMPS
    ADDI -5
    IF_NEGATIVE 3f
    /* toward its switch is up: Z goes first, else last */
    LIT 2
    DO axis_select
    FR load A_FLAGS, SHORT
    PUT UNIT
    F load STEPS, AXIS
    F sub ACTUAL, AXIS
    IF_NONE UNIT, AXIS_HOME_POSITIVE, 1f
    DO negate
1:  IF_NEGATIVE 4f
    LET N, 4
    BITS_OFF RAMPS, 4
3:  GET RAMPS
    DO line_rapid
    NOT_YET_
4:  GET RAMPS
    ANDI 3
    PUT N
    LIT 4
    DO line_rapid
    NOT_YET_
    .balign 2, 0

    /* r5 = steps of Z, Y, X from bit 7 down, r7 = their frames likewise: LinearMixed's, whose flags are
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
