/* Places of the axes: um and steps, targets, soft limits.

   What works on one axis takes it as two registers: r8 = 4 * axis, which indexes UM, STEPS, OFFSET,
   ACTUAL, PROBED, and r9 = address of its AxisRecord. */
    .section .text.moves,"axR",@progbits
module.moves.coords:

    /* A target while a statement looks at all of its axes; the engine rests and leaves its memory. */
    .set NEW_UM, INC
    .set NEW_STEPS, ACC
    /* planner's numbers that are free at rest */
    .set SPARE, V2
    .set SPARE_TOO, LEFT

    /* Where the axis r12 stands, or is to stand, for the link: r13:r12 = work position in steps.
       Uses r11, r14, r15. */
    .global work_steps
    .if HAS_STATE
    .global target_steps
target_steps:
    mov #STEPS-ACTUAL, r13
    jmp 1f
work_steps:
    clr r13
1:  push r8
    push r9
    push r13
    call #axis_select
    call #offset_steps
    add @r1+, r8
    .else
work_steps:
    push r8
    push r9
    call #axis_select
    call #offset_steps
    .endif
    call #formula
    F sub ACTUAL, AXIS, LAST
    call #negate
restore_axis:
    pop r9
    pop r8
    ret

    /* r12 = address of the AxisRecord of axis r12. Uses r11. */
    .global axis_record
axis_record:
    push r8
    push r9
    call #axis_select
    mov r9, r12
    jmp restore_axis

    /* r13:r12 = work offset of the axis in steps, 0 when it does not fit. Uses r11, r14, r15. */
offset_steps:
    call #formula
    F load OFFSET, AXIS, LAST
    call #to_steps
zero_if_carry:
    jnc 1f
    clr r12
    clr r13
1:  ret

    /* r13:r12 um as steps of the axis, half away from zero; carry when they do not fit.
       Uses r11, r14, r15. */
    .global to_other
to_steps:
    mov A_UM(r9), r11
    mov A_STEPS(r9), r14
    jmp 1f
    /* The same in the unit that r10 does not say, bit 2 for steps. */
to_other:
    bit #4, r10
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
    call #formula_abs
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

    /* Where a target lies: r13:r12 um or steps, r10 = frame (0 work, 1 machine, 2 relative), plus 4
       for steps. NEW_UM, NEW_STEPS of the axis hold it and r12 is 0, or FAULTED with F01, F05,
       F07, or F20 for an axis that the machine lacks. Uses r11, r14, r15. */
    .global aim
aim:
    cmp #12, r8
    jhs aim_lacks
    bit #AXIS_PRESENT, A_FLAGS(r9)
    jeq aim_lacks
    /* relative: to the commanded place in its unit; work um: to the offset */
    mov r8, r11
    bit #4, r10
    jeq 1f
    add #STEPS-UM, r11
1:  bit #2, r10
    jne 2f
    bit #5, r10
    jne 3f
    add #OFFSET-UM, r11
2:  add UM(r11), r12
    addc UM+2(r11), r13
    bit #0x100, r2
    jne aim_overflow
    /* The same for a machine position; 2 in r10 allows it to an axis not homed. */
aim_place:
3:  bit #4, r10
    jne 4f
    call #formula
    F store NEW_UM, AXIS, LAST
    call #to_steps
    jc aim_overflow
    call #formula
    F store NEW_STEPS, AXIS, LAST
    jmp 7f
4:  call #formula
    F store NEW_STEPS, AXIS, LAST
    call #to_um
    jc aim_overflow
    call #formula
    F store NEW_UM, AXIS, LAST
7:  call #axis_bit
    bit.b r12, &HOMED
    jeq 5f
    /* both differences may wrap: all is well as long as the travel is below 2^31 um */
    call #formula
    FR load A_MAX, LONG
    F sub NEW_UM, AXIS, LAST
    tst r13
    jl aim_limit
    call #formula
    F load NEW_UM, AXIS
    FR sub A_MIN, LONG, LAST
    tst r13
    jl aim_limit
6:  clr r12
    ret
5:  bit #2, r10
    jne 6b
    mov &VM_CODE, r11
    bit #MC_REQUIRE_HOMING, MC_FLAGS-MACHINE_SIZE(r11)
    jeq 6b
    mov #FAULTED+F_NOT_HOMED, r12
    ret
aim_limit:
    mov #FAULTED+F_SOFT_LIMIT, r12
    ret
aim_lacks:
    mov #FAULTED+F_VALUE_RANGE, r12
    ret
aim_overflow:
    mov #FAULTED+F_OVERFLOW, r12
    ret

    /* Makes NEW_UM, NEW_STEPS of the resting axis the commanded place; Z when it stands there in
       steps. Uses r11 to r15. */
command:
    call #formula
    F load NEW_UM, AXIS
    F store UM, AXIS
    F load NEW_STEPS, AXIS
    F store STEPS, AXIS
    F sub ACTUAL, AXIS, LAST
    bis r12, r13
    tst r13
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
    mov #8, r8
1:  call #axis_at
    call #settle_here
    sub #4, r8
    jge 1b
    ret

    .global settle, settle_here
    /* The commanded place is where the axis stands. Uses r11 to r15. */
settle_here:
    call #formula
    F load ACTUAL, AXIS, LAST
    /* The commanded place is that of r13:r12 steps; um are 0 when they do not fit.
       Uses r11 to r15. */
settle:
    call #formula
    F store STEPS, AXIS, LAST
    call #to_um
    call #zero_if_carry
    call #formula
    F store UM, AXIS, LAST
    ret
