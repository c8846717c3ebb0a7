/* Places of the axes: um and steps, targets, soft limits.

   What works on one axis takes it as two registers: r8 = 4 * axis, which indexes UM, STEPS, OFFSET,
   ACTUAL, PROBED, and r9 = address of its AxisRecord in flash. */
    .section .text.coords,"axR",@progbits

    /* A target while a statement looks at all of its axes; the engine rests and leaves its memory. */
    .set NEW_UM, SLOT0
    .set NEW_STEPS, SLOT1

    /* Where the axis r12 stands, or is to stand, for the link: r13:r12 = work position in steps.
       Uses r11, r14, r15. */
    .global target_steps, work_steps
target_steps:
    mov #STEPS, r13
    jmp 1f
work_steps:
    mov #ACTUAL, r13
1:  push r8
    push r9
    call #axis_select
    add r8, r13
    push r13
    call #offset_steps
    pop r15
    mov @r15+, r14
    mov @r15, r15
    sub r12, r14
    subc r13, r15
    mov r14, r12
    mov r15, r13
    jmp restore_axis

    /* r13:r12 = work offset of the axis in steps, 0 when it does not fit. Uses r11, r14, r15. */
offset_steps:
    mov OFFSET(r8), r12
    mov OFFSET+2(r8), r13
    call #to_steps
zero_if_carry:
    jnc 1f
    clr r12
    clr r13
1:  ret

    /* r15:r14 of the axis r12 in the other unit, to steps when r13 is not 0: r13:r12, carry when
       it does not fit (F01). Uses r11, r14, r15. */
    .global convert
convert:
    push r8
    push r9
    call #axis_select
    mov r14, r12
    tst r13
    mov r15, r13
    jeq 1f
    call #to_steps
    jmp restore_axis
1:  call #to_um
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

    /* Axis r12: r8 = 4 * axis, r9 = its record. Uses r11. */
    .global axis_select, axis_at
axis_select:
    mov r12, r8
    rla r8
    rla r8
    /* Axis r8: r9 = its record, that of the stored program. Uses r11. */
axis_at:
    mov #FREE_AXIS, r9
    mov &VM_CODE, r11
    tst r11
    jeq 2f
    mov r11, r9
    sub #MACHINE_SIZE-MC_AXES, r9
    mov r8, r11
1:  sub #4, r11
    jnc 2f
    add #AXIS_SIZE, r9
    jmp 1b
2:  ret

    /* r12 = bit of the axis r8. */
    .global axis_bit
axis_bit:
    mov r8, r12
    rra r12
    jne 1f
    inc r12
1:  ret

    /* r13:r12 um as steps of the axis, half away from zero; carry when they do not fit.
       Uses r11, r14, r15. */
to_steps:
    mov A_UM(r9), r11
    mov A_STEPS(r9), r14
    jmp 1f
    /* The other way. */
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
    tst r13
    jge 2f
    call #pasapas_neg
2:  call #pasapas_mul_div
    add #4, r1
    pop r14
    add #1, r12
    adc r13
    jc 3f
    rrc r13
    rrc r12
    tst r14
    jge 4f
    call #pasapas_neg
4:  clrc
3:  ret

    /* Where a target lies: r13:r12 um or steps, r10 = frame (0 work, 1 machine, 2 relative), plus 4
       for steps. NEW_UM, NEW_STEPS of the axis hold it and r12 is 0, or FAULTED with F01, F05,
       F07, or F20 for an axis that the machine lacks. Uses r11, r14, r15. */
    .global aim
aim:
    cmp #12, r8
    jhs aim_lacks
    bit #AXIS_PRESENT, A_FLAGS(r9)
    jeq aim_lacks
    mov r8, r11
    bit #2, r10
    jeq 1f
    /* relative: to the commanded place, of um or of steps */
    bit #4, r10
    jeq 2f
    add #STEPS-UM, r11
    jmp 2f
1:  /* machine positions and steps stand for themselves */
    bit #5, r10
    jne 3f
    add #OFFSET-UM, r11
2:  add UM(r11), r12
    addc UM+2(r11), r13
    bit #0x100, r2
    jne aim_overflow
3:  bit #4, r10
    jne 4f
    call #new_um
    call #to_steps
    jc aim_overflow
    call #new_steps
    jmp 5f
4:  call #new_steps
    call #to_um
    jc aim_overflow
    call #new_um
5:  call #axis_bit
    bit.b r12, &HOMED
    jeq 6f
    mov NEW_UM(r8), r12
    mov NEW_UM+2(r8), r13
    cmp A_MIN(r9), r12
    mov r13, r11
    subc A_MIN+2(r9), r11
    jl aim_limit
    mov A_MAX(r9), r14
    mov A_MAX+2(r9), r15
    cmp r12, r14
    subc r13, r15
    jl aim_limit
8:  clr r12
    ret
6:  bit #2, r10
    jne 8b
    tst &VM_CODE
    jeq 8b
    mov &VM_CODE, r11
    bit #MC_REQUIRE_HOMING, MC_FLAGS-MACHINE_SIZE(r11)
    jeq 8b
    mov #FAULTED+F_NOT_HOMED, r12
    ret
aim_limit:
    mov #FAULTED+F_SOFT_LIMIT, r12
    ret
aim_lacks:
    mov #FAULTED+F_VALUE_RANGE, r12
    ret
    .global aim_overflow
aim_overflow:
    mov #FAULTED+F_OVERFLOW, r12
    ret

new_um:
    mov r12, NEW_UM(r8)
    mov r13, NEW_UM+2(r8)
    ret
new_steps:
    mov r12, NEW_STEPS(r8)
    mov r13, NEW_STEPS+2(r8)
    ret

    /* Makes NEW_UM, NEW_STEPS of the axis the commanded place; Z when it was the one in steps before.
       Uses r12 to r15. */
command:
    mov NEW_UM(r8), UM(r8)
    mov NEW_UM+2(r8), UM+2(r8)
    mov NEW_STEPS(r8), r12
    mov NEW_STEPS+2(r8), r13
    mov STEPS(r8), r14
    mov STEPS+2(r8), r15
    mov r12, STEPS(r8)
    mov r13, STEPS+2(r8)
    xor r12, r14
    xor r13, r15
    bis r14, r15
    tst r15
    ret

    /* A new run: no work offsets, the commanded places are those where the axes stand, and the feed
       is the profile's. Keeps nothing but r4 to r7 and r10. */
    .global motion_reset, settle_all
motion_reset:
    mov #12, r11
1:  decd r11
    clr OFFSET(r11)
    jne 1b
    mov &VM_CODE, r11
    mov MC_FEED-MACHINE_SIZE(r11), &FEED
    mov MC_FEED+2-MACHINE_SIZE(r11), &FEED+2
    /* The commanded places become those where the axes stand. Keeps r4 to r10. */
settle_all:
    push r8
    push r9
    mov #12, r8
1:  sub #4, r8
    jnc restore_axis
    call #axis_at
    call #settle_here
    jmp 1b

    /* The resting axis stands at r13:r12 steps, which is its commanded place too.
       Uses r11 to r15. */
    .global place, settle, settle_here
place:
    mov r12, ACTUAL(r8)
    mov r13, ACTUAL+2(r8)
    mov r8, r11
    rra r11
    mov r12, COUNT(r11)
    /* The commanded place is where the axis stands. Uses r11 to r15. */
settle_here:
    mov ACTUAL(r8), r12
    mov ACTUAL+2(r8), r13
    /* The commanded place is that of r13:r12 steps; um stay when the record has none, and are 0
       when they do not fit. Uses r11 to r15. */
settle:
    mov r12, STEPS(r8)
    mov r13, STEPS+2(r8)
    tst A_STEPS(r9)
    jeq 1f
    call #to_um
    call #zero_if_carry
    mov r12, UM(r8)
    mov r13, UM+2(r8)
1:  ret
