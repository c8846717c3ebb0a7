/* Commands of holding registers 2000 and up (InterpCNC V3 Modbus protocol, Commands): 100, 101, 105,
   1110, 1200, and where they fit 103, 106, 107. Others are refused. */
    .section .text.moves,"axR",@progbits
module.moves.commands:

    .if HAS_COMMANDS

    /* What command 106 brings, made an AxisRecord of steps: its place and clearance stand where
       the record wants them, speed and ramps stay in the command. */
    .set HOME_RECORD, COMMAND-4
    .set HOME_SPEED, COMMAND+2*6
    .set HOME_SLOW_SPEED, COMMAND+2*8
    .set HOME_UP, COMMAND+2*10
    .set HOME_DOWN, COMMAND+2*12
    .set HOME_STROKE, COMMAND+2*14
    .set HOME_WAIT, COMMAND+2*16
    .set HOME_CLEARANCE, COMMAND+2*19
    .if HOME_RECORD+A_HOME_CLEARANCE != HOME_CLEARANCE || HOME_RECORD < POOL
    .error "command 106 and AxisRecord differ"
    .endif
    .endif

    /* Executes command r12 with the first argument r13; the others stand behind it in COMMAND, but
       not in a run and while EFFECT is not 0. Leaves r12 = 0 or an exception. Keeps nothing. */
    .global command_execute
command_execute:
    mov r13, r10
    mov r13, r4
    cmp #CMD_STOP_AXES, r12
    jeq command_stop
    cmp #CMD_DIRECT, r12
    jne 1f
    br #direct
1:  mov r12, r7
    dec r10
    cmp #3, r10
    jhs illegal
    mov r10, r12
    call #axis_select
    bit #AXIS_PRESENT, A_FLAGS(r9)
    jeq illegal
    call #axis_bit
    mov r12, r4
    cmp #CMD_STOP_AXIS, r7
    jeq command_stop
    bit.b #RUN_ACTIVE, &RUN
    jne busy
    tst.b &EFFECT
    jne busy
    tst.b &MOVING
    jne busy
    call #blocking
    jne busy
    mov.b r10, &N
    cmp #CMD_SET_POSITION, r7
    jeq command_set
    .if HAS_COMMANDS
    mov #COMMAND+4, r5
    cmp #CMD_MOVE_TO, r7
    jeq command_move
    cmp #CMD_PROBE, r7
    jeq command_probe
    cmp #CMD_HOME, r7
    jeq command_home
    .endif
    cmp #CMD_HOME_PROFILE, r7
    jne illegal
    mov #DEVICE_FAILURE, r12
    tst &VM_CODE
    jeq 2f
    mov r10, r12
    call #home_by_profile
home_under_way:
    mov.b #HOME_BEGIN, &PHASE
    mov r10, r12
    add #OP_HOME, r12
    bic.b r4, &HOMING_ERROR
effect_under_way:
    mov.b r12, &EFFECT
obeyed:
    clr r12
2:  ret
busy:
    mov #EXCEPTION_BUSY, r12
    ret
illegal:
    mov #ILLEGAL_VALUE, r12
    ret

    /* r4 = axes to stop */
command_stop:
    mov #CONTROL_STOP, r12
    bit.b #RUN_ACTIVE, &RUN
    jne command_control
    call #abandon
    bit.b r4, &MOVING
    jeq obeyed
    call #motion_stop
    jmp obeyed
command_control:
    call #control
    jmp obeyed

    /* The work position of the axis becomes the second argument, steps. */
command_set:
    mov &COMMAND+4, r14
    mov &COMMAND+6, r15
    jmp 1f
    /* Work position of the axis r12 becomes r15:r14 steps: r12 = 0 or an exception.
       Keeps r4 to r10. */
    .global set_work_position
set_work_position:
    push r8
    push r9
    call #axis_select
    push #restore_axis
1:  tst.b &MOVING
    jne busy
    mov ACTUAL(r8), r12
    mov ACTUAL+2(r8), r13
    sub r14, r12
    subc r15, r13
    call #to_um
    jc illegal
    call #formula
    F store OFFSET, AXIS, LAST
    jmp obeyed

    .if HAS_COMMANDS
    /* ramp up, speed, ramp down, target */
command_move:
    call #command_pace
    jc illegal
    call #offset_steps
    call #command_target
    jne illegal
    call #command
    call #begin_axis
    jmp obeyed

    /* input from 0, its level, then as 103 with a distance */
command_probe:
    mov @r5+, r12
    inc r12
    mov @r5+, r10
    cmp #2, r10
    jhs illegal
    clr r6
    push r5
    call #probe_input
    pop r5
    jc illegal
    call #command_pace
    jc illegal
    call #formula
    F load ACTUAL, AXIS, LAST
    call #command_target
    jne illegal
    bic.b r4, &PROBE_ERROR
    mov.b #PROBE_MOVES, &PHASE
    call #probe_begin
    mov #OP_PROBE, r12
    jeq effect_under_way
    bis.b r4, &PROBE_ERROR
    jmp obeyed

    /* 0, input from 0, its level when closed, 1 for positive, then speed, speed off the switch, ramps
       up and down, stroke, pause, place, clearance */
command_home:
    mov @r5+, r14
    tst r14
    jne illegal
    mov @r5+, r12
    cmp #17, r12
    jhs illegal
    add #HOME_COMMAND+1, r12
    mov @r5+, r13
    dec r13
    jeq 1f
    bis #HOME_INVERT, r12
    inc r13
    jne illegal
1:  mov.b r12, &BITS
    mov @r5+, r7
    cmp #2, r7
    jhs illegal
    mov #4, r6
2:  mov @r5+, r12
    mov @r5+, r13
    call #positive
    jc illegal
    dec r6
    jne 2b
    rla r7
    rla r7
    mov r7, &HOME_RECORD+A_FLAGS
    mov #1, &HOME_RECORD+A_STEPS
    mov #1, &HOME_RECORD+A_UM
    mov &HOME_SLOW_SPEED, &HOME_RECORD+A_HOME_SLOW
    mov &HOME_WAIT, &HOME_RECORD+A_HOME_PAUSE
    call #formula
    F load HOME_STROKE
    F abs
    F store HOME_RECORD+A_HOME_STROKE
    F load HOME_CLEARANCE, , LAST
    tst r7
    jeq home_under_way
    call #negate
    call #formula
    F store HOME_CLEARANCE, , LAST
    jmp home_under_way

    /* TEMP = pace with ramp up, speed and ramp down at r5, which moves on; carry when one is not
       above 0. Uses r11 to r15. */
command_pace:
    call #axis_pace
    call #1f
    jc 2f
    call #formula
    F least TEMP+4
    F store TEMP+4, , LAST
    call #1f
    jc 2f
    call #speed_least
    call #1f
    jc 2f
    call #formula
    F least TEMP+8
    F store TEMP+8, , LAST
    clrc
    ret
1:  mov @r5+, r12
    mov @r5+, r13
    mov #2, r7
    br #rate_of
2:  ret

    /* NEW_UM, NEW_STEPS = r13:r12 plus the steps at r5; Z clear when that is no place for the axis.
       Uses r10 to r15. */
command_target:
    add @r5+, r12
    addc @r5+, r13
    bit #0x100, r2
    jne 1f
    mov #4+2, r10
    call #aim_place
    tst r12
1:  ret
    .endif

    /* r10 = what to do, r4 the same: all axes for 255 */
direct:
    cmp #255, r10
    jeq command_stop
    mov #direct_codes, r11
1:  mov.b @r11+, r13
    mov.b @r11+, r12
    cmp r13, r10
    jeq command_control
    cmp #direct_codes_end, r11
    jne 1b
    jmp illegal
    /* number and Control; no jog is ever under way that 133 could stop */
direct_codes:
    .byte 88, CONTROL_ACKNOWLEDGE, 129, CONTROL_RESUME, 130, CONTROL_PAUSE, 133, 0
direct_codes_end:

    /* A reference run or a probe by command is given up and counts as failed. Uses r12, r13. */
abandon:
    tst.b &EFFECT
    jne 1f
3:  ret
    /* It is over: r12 = DONE or a fault. Uses r12, r13. */
    .global command_done
command_done:
    tst r12
    jeq 3b
1:  call #axis_n
    call #axis_bit
    mov #HOMING_ERROR, r13
    cmp.b #OP_PROBE, &EFFECT
    jne 2f
    mov #PROBE_ERROR, r13
2:  bis.b r12, 0(r13)
    clr.b &WATCH
    clr &EFFECT
    ret
