/* Places of the axes: um and steps, targets, soft limits.

   What works on one axis takes it as two registers: r8 = 4 * axis, which indexes UM, STEPS, OFFSET,
   ACTUAL, PROBED, and r9 = address of its AxisRecord. */
    .section .text.micro,"axR",@progbits
module.moves.coords:

    /* A target while a statement looks at all of its axes; the engine rests and leaves its memory. */
    .set NEW_UM, INC
    .set NEW_STEPS, ACC
    /* planner's numbers that are free at rest */
    .set SPARE, V2
    .set SPARE_TOO, LEFT

    /* the MachineRecord of a program, from STORED */
    .set PROGRAM_MACHINE, SLOT_HEAD+IMAGE_CODE-MACHINE_SIZE

    /* FRAME_OF */
    .set F_STEPS, 4
    .set F_MACHINE, 8
    .set F_RELATIVE, 16

    /* Where the axis r12 stands, or is to stand, for the link: r13:r12 = work position in steps.
       Uses r8, r9. */
    .global work_steps, target_steps
    ROUTINE_ODD work_steps
    DO axis_select
    DO offset_steps
    F sub ACTUAL, AXIS
    DO negate
    RETURN
    ROUTINE_ODD target_steps
    DO axis_select
    DO offset_steps
    F sub STEPS, AXIS
    DO negate
    RETURN

    /* r13:r12 = work offset of the axis in steps, 0 when it does not fit. */
    ROUTINE_ODD offset_steps
    F load OFFSET, AXIS
    DO to_steps
    DO zero_if_carry
    RETURN
    .balign 2, 0

    /* r13:r12 um as steps of the axis, half away from zero; carry when they do not fit.
       Uses r11, r14, r15. */
    .global to_other
to_steps:
    mov A_UM(r9), r11
    mov A_STEPS(r9), r14
    jmp 1f
    /* The same in the unit that FRAME_OF does not say. */
to_other:
    bit.b #F_STEPS, &FRAME_OF
    jeq to_steps
    /* r13:r12 steps as um. */
to_um:
    mov A_STEPS(r9), r11
    mov A_UM(r9), r14
    /* twice the product over r11, then half of that rounded up */
1:  push r13
    push #0
    push r11
    clr r15
    rla r14
    rlc r15
    call #pasapas_abs
    call #pasapas_mul_div
    add #4, r1
    pop r14
    add #1, r12
    adc r13
    jc 3f
    rrc r13
    rrc r12
    tst r14
    jge 2f
    call #negate
2:  clrc
3:  ret

    /* The axis N, or r12: r8 = 4 * axis, r9 = its record. Uses r11. */
axis_n:
    mov.b &N, r12
    .global axis_select, axis_at
axis_select:
    mov r12, r8
    rla r8
    rla r8
    /* Axis r8: r9 = its record, that of the stored program. Uses r11. */
axis_at:
    mov &VM_CODE, r9
    sub #MACHINE_SIZE-MC_AXES, r9
    jnc 2f
    mov r8, r11
1:  sub #4, r11
    jnc 3f
    add #AXIS_SIZE, r9
    jmp 1b
2:  mov #FREE_AXIS, r9
3:  ret

    /* r12 = bit of the axis r8. */
    .global axis_bit
axis_bit:
    mov r8, r12
    rra r12
    jne 1f
    inc r12
1:  ret

    /* Z set when the machine lacks the axis. */
axis_there:
    cmp #12, r8
    jhs 1f
    bit #AXIS_PRESENT, A_FLAGS(r9)
    ret
1:  cmp r8, r8
    ret

    /* Where a target lies: r13:r12 um or steps as FRAME_OF says. NEW_UM, NEW_STEPS of the axis hold it
       and r12 is 0, or FAULTED with F01, F05, F07, or F20 for an axis that the machine lacks. */
    ROUTINE_ODD aim
    DO axis_there
    IF_EQUAL aim_lacks
    /* relative: to the commanded place in its unit; work um: to the offset */
    IF_NONE FRAME_OF, F_RELATIVE, 1f
    IF_ANY FRAME_OF, F_STEPS, 0f
    F add UM, AXIS
    GOTO 2f
0:  F add STEPS, AXIS
    GOTO 2f
1:  IF_ANY FRAME_OF, F_STEPS|F_MACHINE, aim_place
    F add OFFSET, AXIS
2:  IF_OVERFLOW aim_overflow
    /* The same for a machine position; F_RELATIVE allows it to an axis not homed. */
    ROUTINE_ODD aim_place
    IF_ANY FRAME_OF, F_STEPS, 4f
    F store NEW_UM, AXIS
    DO to_steps
    IF_CARRY aim_overflow
    F store NEW_STEPS, AXIS
    GOTO 7f
4:  F store NEW_STEPS, AXIS
    DO to_um
    IF_CARRY aim_overflow
    F store NEW_UM, AXIS
    /* a way of 2^31 steps or more would wrap */
7:  F load NEW_STEPS, AXIS
    F sub ACTUAL, AXIS
    IF_OVERFLOW aim_overflow
    IF_NOT_AXIS HOMED, 5f
    /* both differences may wrap: all is well as long as the travel is below 2^31 um */
    FR load A_MAX, LONG
    F sub NEW_UM, AXIS
    IF_NEGATIVE aim_limit
    F load NEW_UM, AXIS
    FR sub A_MIN, LONG
    IF_NEGATIVE aim_limit
6:  DONE_
5:  IF_NOT_AXIS PLACED, 8f
    DONE_
8:  IF_ANY FRAME_OF, F_RELATIVE, 6b
    F base STORED
    FR word PROGRAM_MACHINE+MC_FLAGS, SHORT
    TESTI MC_REQUIRE_HOMING
    IF_EQUAL 6b
    FAULT F_NOT_HOMED
aim_limit:
    FAULT F_SOFT_LIMIT
aim_lacks:
    FAULT F_VALUE_RANGE
aim_overflow:
    FAULT F_OVERFLOW

    /* Makes NEW_UM, NEW_STEPS of the resting axis the commanded place; Z when it stands there in
       steps. */
    ROUTINE_ODD command
    F load NEW_UM, AXIS
    F store UM, AXIS
    F load NEW_STEPS, AXIS
    F store STEPS, AXIS
    F sub ACTUAL, AXIS
    DO test_long
    RETURN
    .balign 2, 0

    /* A new run: no work offsets, and the commanded places are those where the axes stand. Keeps r4
       to r7 and r10. */
    .global motion_reset, settle_all
motion_reset:
    mov #12, r11
1:  decd r11
    clr OFFSET(r11)
    jne 1b
    /* The commanded places become those where the axes stand. Keeps r4 to r7 and r10. */
settle_all:
    MICRO
    DO micro_first_axis
1:  DO axis_at
    DO settle_here
    NEXT_AXIS 1b
    RETURN

    /* r13:r12 = where the axis stands. */
    ROUTINE_ODD here
    F load ACTUAL, AXIS
    RETURN

    /* The commanded place is where the axis stands. */
    ROUTINE_ODD settle_here
    DO here
    /* The commanded place is that of r13:r12 steps; um are 0 when they do not fit. */
    ROUTINE_ODD settle
    F store STEPS, AXIS
    DO to_um
    DO zero_if_carry
    F store UM, AXIS
    RETURN
    .balign 2, 0
