/* Effects that move axes to places, set work zeros, or look at the machine. Each is entered with
   r12 = its code and Z set in phase 0, may use all registers, and leaves r12 = DONE, NOT_YET, or
   FAULTED plus the fault. A motion blocks: no other begins before MOVING is 0. */
    .section .text.moves,"axR",@progbits
module.moves:

    /* Whether r13:r12 is above 0: carry when it is not. */
positive:
    tst r13
    jl 1f
    jne 2f
    tst r12
    jeq 1f
2:  clrc
1:  ret

    /* F and S. */
    .global fx_feed
fx_feed:
    mov r12, r10
    call #pop_value
    bit #OP_FEED&OP_FEED_STEPS&2, r10
    jeq done
    call #positive
    jc speed_range
    bit #OP_FEED_STEPS&1, r10
    jeq 1f
    call #negate
1:  call #formula
    F store FEED, , LAST
    jmp done

    /* Work zeros: the commanded place becomes 0, or the value on the stack. */
    .global fx_set_pos, fx_set_pos_zero
fx_set_pos_zero:
    mov r12, r8
    sub #OP_SET_POS_ZERO, r8
    clr r12
    clr r13
    jmp 1f
fx_set_pos:
    call #operand_byte
    mov r12, r8
    call #pop_value
1:  rla r8
    rla r8
    mov UM(r8), r14
    mov UM+2(r8), r15
    sub r12, r14
    subc r13, r15
    bit #0x100, r2
    jne aim_overflow
    mov r14, OFFSET(r8)
    mov r15, OFFSET+2(r8)
    jmp done

    /* StopAxe, StopAll, WaitMove: nothing moves when a statement begins. */
    .global fx_stop, fx_wait_move
fx_stop:
    cmp #OP_STOP_AXE, r12
    jne done
    call #operand_byte
    mov.b r12, &N
    mov #TRACE_STOP, r7
    /* An event of the axis N without a value: r7 = kind. Leaves r12 = DONE. Uses r13 to r15. */
event_plain:
    clr r12
    clr r13
    /* The same with the value r13:r12. */
event:
    mov r12, r14
    mov r13, r15
    mov.b &N, r12
    swpb r12
    bis r7, r12
    br #emit
fx_wait_move:
    call #operand_byte
done:
    clr r12
    ret

    /* What a program may look at: flags are look << 2 | axis. */
    .global fx_read
fx_read:
    call #operand_byte
    mov r12, r10
    and #FL_AXIS, r12
    call #axis_select
    call #axis_bit
    sub #LOOK_PROBE_OK<<2, r10
    jnc 2f
    clr r13
    rra r10
    bic #1, r10
    cmp #2*(LOOK_CHAR_IN-LOOK_PROBE_OK), r10
    jhs 1f
    add r10, r0
    jmp read_probe_ok
    jmp read_moving
    jmp read_homed
    jmp read_port
    call #formula
    F load TIMER_MS, , LAST
    jmp read_done
1:  mov.b &CHAR_IN, r12
    clr.b &CHAR_IN
    jmp read_done
read_port:
    mov #17, r12
    call #input
    mov r12, r13
    mov &INPUT, r12
    jmp read_done
read_probe_ok:
    and.b &PROBE_OK, r12
    jmp 4f
read_moving:
    and.b &MOVING, r12
    jmp 4f
read_homed:
    and.b &HOMED, r12
4:  jeq read_done
    mov #1, r12
    jmp read_done
    /* Pos, PosSteps, Probed, ProbedSteps */
2:  call #formula
    F load PROBED, AXIS, LAST
    bit #2<<2, r10
    jne 3f
    call #formula
    F load ACTUAL, AXIS, LAST
3:  bit #1<<2, r10
    jne read_done
    call #to_um
    call #zero_if_carry
    call #formula
    F sub OFFSET, AXIS, LAST
read_done:
    call #push_value
    jmp done

    /* A speed or ramp from the stack when bit 0 of r7 is set, in steps when bit 1 is, else in um:
       r13:r12 = scaled steps, above every number without one. Carry when it is not above 0.
       Uses r11, r14, r15. */
rate:
    mov #-1, r12
    mov #-1, r13
    bit #1, r7
    jeq 2f
    call #pop_value
rate_of:
    call #positive
    jc 2f
    call #pasapas_scaled_new
    bit #2, r7
    jne 1f
    call #formula
    FR times A_STEPS, SHORT, NEW
    FR over A_UM, SHORT, NEW, LAST
1:  clrc
2:  ret

    /* r12 = flags: r6 keeps them, N, r8 and r9 are their axis, and TEMP is the pace of its record:
       speed, ramp up, ramp down. Uses r11 to r15. */
axis_flags:
    mov r12, r6
    and #FL_AXIS, r12
    mov.b r12, &N
    call #axis_select
axis_pace:
    call #formula
    FR load A_TOP_RATE, LONG, NEW
    F store TEMP
    FR load A_ACCEL, LONG, NEW
    F store TEMP+4
    FR load A_DECEL, LONG, NEW
    F store TEMP+8, , LAST
    ret

    /* The flags SPEED and SPEED_STEPS in r6 bring a speed for the pace; carry as for rate. */
speed_flags:
    mov r6, r7
    rla r7
    rla r7
    swpb r7
    call #rate
    jc 2b
speed_least:
    call #formula
    F least TEMP
    F store TEMP, , LAST
    clrc
    ret

speed_range:
    mov #FAULTED+F_SPEED_RANGE, r12
    ret

    /* MoveAxe, MoveRel. */
    .global fx_move
fx_move:
    jne moved
    inc.b &PHASE
    clr r5
    cmp #OP_MOVE, r12
    jhs 1f
    mov.b move_flags-OP_MOVE_TO(r12), r12
    jmp 2f
1:  mov r12, r7
    call #operand_byte
    rra r7
    jnc 2f
    mov r12, r6
    call #operand_byte
    mov r12, r5
    mov r6, r12
2:  call #axis_flags
    /* DECEL and DECEL_STEPS, ACCEL and ACCEL_STEPS come to bits 0 and 1 */
    mov r5, r7
    rra r7
    rra r7
    call #rate
    jc speed_range
    call #formula
    F store SPARE, , LAST
    mov r5, r7
    call #rate
    jc speed_range
    call #formula
    F store SPARE_TOO
    F least TEMP+4
    F store TEMP+4
    F load SPARE_TOO, , LAST
    bit #FL_DECEL, r5
    jeq 3f
    call #formula
    F load SPARE, , LAST
3:  call #formula
    F least TEMP+8
    F store TEMP+8, , LAST
    call #speed_flags
    jc speed_range
    call #pop_value
    mov r6, r10
    and #FL_STEPS, r10
    bit #FL_RELATIVE, r6
    jeq 4f
    bis #2, r10
4:  call #aim
    tst r12
    jne 5f
    call #command
    jeq done
    mov #TRACE_AXE, r7
    call #event_plain
begin_axis:
    mov.b &N, r12
    call #axis_begin
not_yet:
    mov #NOT_YET, r12
5:  ret

    /* DONE when nothing moves any more. */
moved:
    tst.b &MOVING
    jne not_yet
    jmp done

    /* Flags of the short moves, and those of the short G0 and G1: X, Y, XY, Z, XYZ. */
move_flags:
    .byte 0, 1, 2, FL_RELATIVE, FL_RELATIVE+1, FL_RELATIVE+2
line_flags:
    .byte FL_RAPID+1, FL_RAPID+2, FL_RAPID+3, FL_RAPID+4, FL_RAPID+7, 1, 2, 3, 4, 7

    /* G0 and G1. A rapid move with Z apart is two lines; N holds the axes of the second. */
    .global fx_linear
fx_linear:
    jeq 1f
    tst.b &MOVING
    jne not_yet
    mov.b &N, r12
    clr.b &N
    mov #1, r13
    tst r12
    jne begin_line
    ret
1:  inc.b &PHASE
    /* r6 = axes and RAPID, r5 = steps of Z, Y, X from bit 7 down, r7 = their frames likewise */
    mov r12, r4
    mov.b line_flags-OP_RAPID(r12), r6
    cmp #OP_LINEAR, r12
    jlo 2f
    call #operand_byte
    mov r12, r6
    cmp #OP_LINEAR, r4
    jeq 2f
    mov r12, r5
    call #operand_byte
    mov r12, r7
    rla r7
    rla r7
    jmp 3f
2:  bit #FL_COMMON_STEPS, r6
    subc r5, r5
    inv r5
    mov r6, r7
    and #3<<FL_COMMON_FRAME, r7
    mov r7, r12
    rra r12
    rra r12
    bis r12, r7
    rra r12
    rra r12
    bis r12, r7
    /* all targets before any is commanded */
3:  mov #8, r8
    mov #4, r4
4:  clr r10
    rla.b r5
    rlc r10
    rla.b r7
    rlc r10
    rla.b r7
    rlc r10
    bit r4, r6
    jeq 5f
    call #axis_at
    call #pop_value
    call #aim
    tst r12
    jne line_ret
5:  sub #4, r8
    rra r4
    jnc 4b
    /* r5 = axes that have steps to make */
    clr r5
    mov #8, r8
    mov #4, r4
6:  bit r4, r6
    jeq 7f
    call #command
    jeq 7f
    bis r4, r5
7:  sub #4, r8
    rra r4
    jnc 6b
    tst r5
    jeq done
    mov #TRACE_LINE, r7
    and #FL_RAPID, r6
    jeq 9f
    mov #TRACE_RAPID, r7
9:  call #event_plain
    call #formula
    F load STEPS+8
    F sub ACTUAL+8, , LAST
    mov r13, r15
    mov r5, r12
    mov r6, r13
    tst r13
    jeq begin_line
    mov &VM_CODE, r11
    bit #MC_RAPID_Z_APART, MC_FLAGS-MACHINE_SIZE(r11)
    jeq begin_line
    /* Z and another */
    cmp #5, r5
    jlo begin_line
    /* toward its switch is up: Z goes first, else last */
    bit #AXIS_HOME_POSITIVE, MC_AXES+2*AXIS_SIZE+A_FLAGS-MACHINE_SIZE(r11)
    jeq 10f
    inv r15
10: mov #4, r12
    and #3, r5
    tst r15
    jl 11f
    mov r5, r12
    mov #4, r5
11: mov.b r5, &N
begin_line:
    call #line_begin
    mov #NOT_YET, r12
line_ret:
    ret
