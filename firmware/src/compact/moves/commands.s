/* Commands of holding registers 2000 and up (InterpCNC V3 Modbus protocol, Commands): 100, 101,
   103 to 108, 1110, 1200. Others are refused. */
    .section .text.micro,"axR",@progbits
module.moves.commands:

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

    /* what to do, or 255: stop all axes; no jog is ever under way that 133 could stop */
direct:
    F word COMMAND_HEAD+2
    CMPI 255
    IF_EQUAL command_stop
    CMPI 88
    IF_NOT_EQUAL 1f
    LIT CONTROL_ACKNOWLEDGE
    GOTO command_control
1:  LIT 133
    F sub COMMAND_HEAD+2
    CMPI 5
    IF_CARRY command_illegal
    DO micro_switch
    TO command_obeyed
    TO command_illegal
    TO command_illegal
    TO command_control          /* 130: pause */
    TO command_control          /* 129: resume */

command_stop:
    LIT CONTROL_STOP
    IF_ANY RUN, RUN_ACTIVE, command_control
    CALL abandon
    DO micro_first_axis
1:  IF_NOT_AXIS TEMP, 2f
    IF_NOT_AXIS MOVING, 2f
    DO motion_stop
2:  NEXT_AXIS 1b
    DONE_
command_control:
    CALL control
command_obeyed:
    DONE_

    /* The work position of the axis becomes the second argument, steps. */
command_set:
    F load COMMAND+4
    /* The same of acc. */
    ROUTINE_ODD work_position_is
    IF_SET MOVING, command_busy
    F store SPARE
    DO here
    F sub SPARE
    DO to_um
    IF_CARRY command_illegal
    F store OFFSET, AXIS
    DONE_
command_busy:
    LIT EXCEPTION_BUSY
    RETURN
command_illegal:
    LIT ILLEGAL_VALUE
    RETURN
    .balign 2, 0

    /* Executes the command in COMMAND_HEAD; its arguments but the first stand in COMMAND, but not in a
       run and while EFFECT is not 0. Leaves r12 = 0 or an exception. Keeps nothing. */
    .global command_execute
command_execute:
    mov #COMMAND+4, r5
    MICRO
    /* TEMP = axes to stop */
    F word COMMAND_HEAD+2
    PUT TEMP
    F word COMMAND_HEAD
    CMPI CMD_STOP_AXES
    IF_EQUAL command_stop
    LIT16 CMD_DIRECT
    F cmp COMMAND_HEAD
    IF_EQUAL direct
    F word COMMAND_HEAD+2
    CMPI 4
    IF_CARRY command_illegal
    ADDI -1
    DO axis_select
    DO axis_there
    IF_EQUAL command_illegal
    DO axis_bit
    PUT TEMP
    F word COMMAND_HEAD
    CMPI CMD_STOP_AXIS
    IF_EQUAL command_stop
    IF_ANY RUN, RUN_ACTIVE, command_busy
    IF_SET EFFECT, command_busy
    IF_SET MOVING, command_busy
    DO blocking
    IF_NOT_EQUAL command_busy
    F word COMMAND_HEAD+2
    ADDI -1
    PUT N
    LIT16 CMD_HOME_PROFILE
    F cmp COMMAND_HEAD
    IF_EQUAL home_profile
    LIT CMD_PROBE_MASK
    F sub COMMAND_HEAD
    CMPI CMD_PROBE_MASK-CMD_MOVE_TO+1
    IF_CARRY command_illegal
    DO micro_switch
    TO command_probe_mask
    TO command_probe
    TO command_home
    TO command_set
    TO command_move_by
    TO command_move

    /* ramp up, speed, ramp down, work position */
command_move:
    DO command_pace
    IF_EQUAL command_illegal
    DO offset_steps
    GOTO 1f
    /* the same with a distance */
command_move_by:
    DO command_pace
    IF_EQUAL command_illegal
    DO here
1:  DO command_target
    CMPI 0
    IF_NOT_EQUAL command_illegal
    DO command
    DO begin_axis
    DONE_

    /* 108: masks as ProbeMask has them, 107: input from 0, its level; then as 104 */
command_probe_mask:
    LET FLAGS, 0
    F load COMMAND+8
    DO probe_xor
    F load COMMAND+4
    DO probe_and
    DO command_long
    GOTO 2f
command_probe:
    F load COMMAND+6
    PUT UNIT
    CMPI 2
    IF_CARRY command_wrong
    F load COMMAND+4
    CMPI 17
    IF_CARRY command_wrong
    ADDI 1
    LET FLAGS, 0
    DO probe_input
2:  DO command_long
    DO command_pace
    IF_EQUAL command_wrong
    DO here
    DO command_target
    CMPI 0
    IF_NOT_EQUAL command_wrong
    DO axis_bit
    AXIS_OFF PROBE_ERROR
    DO probe_begin
    IF_NOT_EQUAL 1f
    UP PHASE
    LIT OP_PROBE
    PUT EFFECT
    DONE_
1:  DO axis_bit
    AXIS_ON PROBE_ERROR
    DONE_
command_wrong:
    LIT ILLEGAL_VALUE
    RETURN

home_profile:
    F load VM_CODE
    CMPI 0
    IF_EQUAL 1f
    GET N
    DO home_by_profile
home_under_way:
    UP PHASE
    DO axis_bit
    AXIS_OFF HOMING_ERROR
    GET N
    ADDI OP_HOME
    PUT EFFECT
    DONE_
1:  LIT DEVICE_FAILURE
    RETURN

    /* 0, input from 0, its level when closed, 1 for positive, then speed, speed off the switch, ramps
       up and down, stroke, pause, place, clearance */
command_home:
    F word COMMAND+4
    IF_NOT_EQUAL command_wrong
    F load COMMAND+6
    CMPI 17
    IF_CARRY command_wrong
    ADDI HOME_COMMAND+1
    PUT BITS
    F load COMMAND+8
    CMPI 2
    IF_CARRY command_wrong
    TESTI 1
    IF_NOT_EQUAL 1f
    BITS_ON BITS, HOME_INVERT
1:  F load COMMAND+10
    PUT RAMPS
    CMPI 2
    IF_CARRY command_wrong
    LIT 3
    DO axis_select
2:  F load HOME_SPEED, AXIS
    DO not_negative
    DO test_long
    IF_EQUAL command_wrong
    NEXT_AXIS 2b
    DO axis_n
    LIT 1
    F put HOME_RECORD+A_STEPS
    F put HOME_RECORD+A_UM
    F word HOME_SLOW_SPEED
    F put HOME_RECORD+A_HOME_SLOW
    F word HOME_WAIT
    F put HOME_RECORD+A_HOME_PAUSE
    F load HOME_STROKE
    DO abs
    F store HOME_RECORD+A_HOME_STROKE
    LIT 0
    IF_ZERO RAMPS, 3f
    F sub HOME_CLEARANCE
    F store HOME_CLEARANCE
    LIT AXIS_HOME_POSITIVE
3:  F put HOME_RECORD+A_FLAGS
    GOTO home_under_way

    /* TEMP = pace with ramp up, speed and ramp down at r5, which moves on; Z when one is not above
       0. */
    ROUTINE_ODD command_pace
    DO axis_pace
    LET UNIT, 2
    DO command_long
    DO rate_of
    F bound TEMP+4
    DO command_long
    DO rate_of
    DO speed_least
    DO command_long
    DO rate_of
    F bound TEMP+8
    F least TEMP+4
    F least TEMP
    DO test_long
    RETURN

    /* NEW_UM, NEW_STEPS = acc plus the steps at r5; r12 is not 0 when that is no place for the axis. */
    ROUTINE_ODD command_target
    F store SPARE
    DO command_long
    F add SPARE
    IF_OVERFLOW 1f
    LET FRAME_OF, F_STEPS|F_RELATIVE
    CALL aim_place
    RETURN
1:  FAULT F_OVERFLOW
    .balign 2, 0

    /* acc = the next argument */
command_long:
    mov @r5+, r12
    mov @r5+, r13
    ret

    /* Work position of the axis r12 becomes r15:r14 steps: r12 = 0 or an exception.
       Keeps r4 to r8 and r10. */
    .global set_work_position
set_work_position:
    push r8
    call #axis_select
    mov r14, r12
    mov r15, r13
    MICRO
    CALL work_position_is
    END
    pop r8
    ret

    /* What an effect by command came to: r12 = DONE or a fault. Uses r8, r9, r11 to r15. */
    .global command_done
command_done:
    MICRO
    CMPI DONE
    IF_NOT_EQUAL 1f
    RETURN
    /* A reference run or a probe by command is given up and counts as failed. The same. */
    ROUTINE_ODD abandon
    IF_ZERO EFFECT, 3f
1:  DO axis_n
    DO axis_bit
    IF_IS EFFECT, OP_PROBE, 1f
    AXIS_ON HOMING_ERROR
    GOTO 2f
1:  AXIS_ON PROBE_ERROR
2:  LET EFFECT, 0
    LET PHASE, 0
3:  RETURN
    .balign 2, 0
