/* Commands of holding registers 2000 and up (InterpCNC V3 Modbus protocol, Commands): 100 to 108,
   1110, 1111, 1200. Others are refused. */
    .section .text.micro,"axR",@progbits
module.moves.commands:

    .set JOG_RELATIVE, 0x40

    /* What command 106 brings, made an AxisRecord of steps: its place and clearance stand where
       the record wants them, speed and ramps stay in the command. */
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

    /* input from 0, its level */
command_force:
    F word COMMAND_HEAD+2
    BELOW 16
    ADDI 1
    CALL force_input
    RETURN

    /* what to do, or 255: stop all axes */
direct:
    F word COMMAND_HEAD+2
    CASE 255, command_stop
    CASE_NOT 88, 1f
    LIT CONTROL_ACKNOWLEDGE
    GOTO command_control
1:  LIT 133
    F sub COMMAND_HEAD+2
    BELOW 5
    DO micro_switch
    TO command_jog_ends         /* 133 */
    TO command_illegal
    TO command_illegal
    TO command_control          /* 130: pause */
    TO command_control          /* 129: resume */
    PLACES_END

command_jog_ends:
    IF_NONE MOTION, M_JOG, 1f
    DO motion_stop
1:  DONE_
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
       run and while EFFECT is not 0; r4 = the second one when the request brought it, else 8. Leaves
       r12 = 0 or an exception. Keeps nothing. */
    .global command_execute
command_execute:
    mov #COMMAND+4, r5
    MICRO
    /* TEMP = axes to stop */
    F word COMMAND_HEAD+2
    PUT TEMP
    F word COMMAND_HEAD
    CASE CMD_STOP_AXES, command_stop
    CASE CMD_FORCE_INPUT, command_force
    LIT16 CMD_DIRECT
    F cmp COMMAND_HEAD
    IF_EQUAL direct
    LIT16 CMD_JOG
    F cmp COMMAND_HEAD
    IF_EQUAL 1f
    F word COMMAND_HEAD+2
    BELOW 4
    ADDI -1
    DO axis_select
    DO axis_there
    WANTED
    DO axis_bit
    PUT TEMP
    F word COMMAND_HEAD
    CASE CMD_STOP_AXIS, command_stop
1:  IF_ANY RUN, RUN_ACTIVE, command_busy
    IF_SET EFFECT, command_busy
    /* 102 at no speed */
    LIT CMD_MOVE_SPEED
    F cmp COMMAND_HEAD
    IF_NOT_EQUAL 1f
    F load COMMAND+8
    DO test_long
    IF_EQUAL command_stop
1:  IF_SET MOVING, command_busy
    DO blocking
    IF_NOT_EQUAL command_busy
    F word COMMAND_HEAD+2
    ADDI -1
    PUT N
    LET FLAGS, 0
    LIT CMD_PROBE_MASK
    F sub COMMAND_HEAD
    CMPI CMD_PROBE_MASK-CMD_MOVE_SPEED+1
    IF_CARRY command_by_profile
    DO micro_switch
    TO command_probe_mask
    TO command_probe
    TO command_home_far
    TO command_set
    TO command_move_by
    TO command_move
    TO command_speed_far
    PLACES_END

    /* ramp up, speed, ramp down, work position */
command_move:
    DO offset_steps
    GOTO 1f
    /* the same with a distance */
command_move_by:
    DO here
1:  DO command_target
    BELOW 1
    DO command
    DO begin_axis
    DONE_

    /* 108: masks as ProbeMask has them, 107: input from 0, its level; then as 104 */
command_probe_mask:
    F load COMMAND+8
    DO probe_xor
    F load COMMAND+4
    DO probe_and
    DO command_long
    GOTO 2f
command_probe:
    F load COMMAND+6
    PUT UNIT
    BELOW 2
    F load COMMAND+4
    BELOW 17
    ADDI 1
    DO probe_input
2:  DO command_long
    DO here
    DO command_target
    BELOW 1
    DO axis_bit
    AXIS_OFF PROBE_ERROR
    UP PHASE
    LIT OP_PROBE
    PUT EFFECT
    DO probe_begin
    IF_EQUAL 1f
    CALL abandon
1:  DONE_
command_speed_far:
    GOTO command_speed
command_home_far:
    GOTO command_home_further

    /* those that want a program */
command_by_profile:
    LIT16 CMD_JOG
    F sub COMMAND_HEAD
    BELOW CMD_JOG-CMD_HOME_PROFILE+1
    PUT TEMP
    F word VM_CODE
    IF_EQUAL command_fails
    IF_SET TEMP, home_profile

    /* bits of axes, 64 for distances; mm/min and mm, floats */
    F word COMMAND_HEAD+2
    BELOW JOG_RELATIVE+8
    PUT FLAGS
    TESTI JOG_RELATIVE-8
    IF_NOT_EQUAL command_refused
    ANDI 7
    WANTED
    LIT 60
    DO new
    F store SPARE
    DO command_float
    DO not_negative
    DO new
    F over SPARE
    DO floor
    DO test_long
    WANTED
    F store FEED
    /* all targets before any is commanded */
    LIT 0
    DO axis_select
1:  IF_NOT_AXIS FLAGS, 3f
    DO axis_at
    DO command_float
    DO to_steps
    IF_CARRY command_refused
    F store SPARE
    DO here
    IF_ANY FLAGS, JOG_RELATIVE, 2f
    DO offset_steps
2:  CALL command_aim
    BELOW 1
3:  UP_AXIS 1b
    DO command_axes
    GET RAMPS
    CALL line_begin
    /* axes that move do so for as long as the host speaks */
command_jogging:
    IF_ZERO MOVING, command_jogged
    BITS_ON MOTION, M_JOG
command_jogged:
    DONE_

command_fails:
    LIT DEVICE_FAILURE
    RETURN
command_refused:
    LIT ILLEGAL_VALUE
    RETURN
command_home_further:
    GOTO command_home

    /* ramp, speed with its sign: to the end of the travel of an axis that has homed, for hours of any
       other */
command_speed:
    F load COMMAND+4
    F store COMMAND+12
    LIT16 0x2000
    F put SPARE_TOO+2
    F load COMMAND+8
    IF_NOT_NEGATIVE 1f
    DO negate
    F store COMMAND+8
    F load SPARE_TOO
    DO negate
    F store SPARE_TOO
    FR load A_MIN, LONG
    GOTO 2f
1:  FR load A_MAX, LONG
2:  DO to_steps
    IF_NOT_AXIS HOMED, 3f
    GOTO 4f
3:  DO here
    F add SPARE_TOO
4:  F store STEPS, AXIS
    DO command_pace
    WANTED
    DO begin_axis
    GOTO command_jogging

home_profile:
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

    /* 0, input from 0, its level when closed, 1 for positive, then speed, speed off the switch, ramps
       up and down, stroke, pause, place, clearance */
command_home:
    F word COMMAND+4
    BELOW 1
    F load COMMAND+6
    BELOW 17
    ADDI HOME_COMMAND+1
    PUT BITS
    F load COMMAND+8
    BELOW 2
    TESTI 1
    IF_NOT_EQUAL 1f
    BITS_ON BITS, HOME_INVERT
1:  F load COMMAND+10
    PUT RAMPS
    BELOW 2
    LIT 3
    DO axis_select
2:  F load HOME_SPEED, AXIS
    DO not_negative
    DO test_long
    WANTED
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

    /* The pace at r5, and NEW_UM, NEW_STEPS = acc plus the steps behind it; r12 is not 0 when one is 0
       or that is no place for the axis. */
    ROUTINE_ODD command_target
    F store SPARE
    DO command_pace
    WANTED
    DO command_long
    /* The same of acc plus SPARE. */
    ROUTINE_ODD command_aim
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

    /* acc = the next argument, a float: thousandths of it */
    ROUTINE_ODD command_float
    DO command_long
    F store TEMP+8
    CALL command_scaled
    F store TEMP
    /* 1000/512, so that no exponent of a float leaves the range of scaled numbers */
    LIT 125
    DO new
    SHIFT -6
    F times TEMP
    DO rounded
    IF_NONE TEMP+11, 0x80, 1f
    DO negate
1:  RETURN
    .balign 2, 0

    /* The float r13:r12 without its sign as a scaled number, times 2^22: the exponents' zeros differ. */
command_scaled:
    rla r13
    mov r13, r14
    setc
    rrc.b r13
    and #0xff00, r14
    bis r14, r13
    ret

    /* Input r12 keeps the level r4, until -1 frees it; not one whose role stops the machine. Leaves
       r12 = 0 or an exception. */
force_input:
    mov &BOARD, r14
    add #B_REFERENCE, r14
    mov #B_END_OF_STOPS-B_REFERENCE, r15
1:  cmp.b @r14+, r12
    jeq 3f
    dec r15
    jne 1b
    call #mask_of
    inc r4
    cmp #3, r4
    jhs 3f
    clr r12
    bic r14, &FORCED
    dec r4
    jn 4f
    /* bis and bic leave the flags */
    bis r14, &FORCED
    bic r14, &INPUT
    jeq 4f
    bis r14, &INPUT
4:  ret
3:  mov #ILLEGAL_VALUE, r12
    ret

    /* Work position of the axis r12 becomes r15:r14 steps: r12 = 0 or an exception.
       Keeps r4 to r7 and r10. */
    .global set_work_position
set_work_position:
    call #axis_select
    mov r14, r12
    mov r15, r13
    MICRO
    CALL work_position_is
    RETURN
    .balign 2, 0

    /* What an effect by command came to: r12 = DONE or a fault. Uses r8, r9, r11 to r15. */
    .global command_done
command_done:
    MICRO
    CASE DONE, 3f
    /* A reference run or a probe by command is given up and counts as failed. The same. */
    ROUTINE_ODD abandon
    IF_ZERO EFFECT, 3f
    DO axis_n
    DO axis_bit
    IF_IS EFFECT, OP_PROBE, 1f
    AXIS_ON HOMING_ERROR
    GOTO 2f
1:  AXIS_ON PROBE_ERROR
2:  F clear EFFECT
3:  RETURN
    .balign 2, 0
