/* Places of the axes: what firmware/src/rules/coords.rs builds on.

   What works on one axis takes it as two registers: r8 = 4 * axis, which indexes UM, STEPS, OFFSET,
   ACTUAL, PROBED, and r9 = address of its AxisRecord. */
    .section .text.micro,"axR",@progbits
module.moves.coords:

    /* A target while a statement looks at all of its axes, in planner's numbers that are free until the line
       is planned, at rest and in a course. */
    .set NEW_UM, V
    .set NEW_STEPS, ACCEL2
    .global NEW_UM, NEW_STEPS
    /* planner's numbers that are free at rest */
    .set SPARE, V2
    .set SPARE_TOO, LEFT

    /* the MachineRecord of a program, from STORED */
    .set PROGRAM_MACHINE, SLOT_HEAD+IMAGE_CODE-MACHINE_SIZE

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

    .balign 2, 0
