/* Made by `cargo run -p lower` of firmware/src/rules/commands.rs: change that. */

    .section .text.micro,"axR",@progbits
module.rules.commands:
    .balign 2, 0
    .global command_execute
command_execute:
    mov #COMMAND+4, r5
    MICRO
    F word COMMAND_HEAD+2
    PUT TEMP
    ADDI -1
    DO axis_select
    F word COMMAND_HEAD
    CASE 101, command_stop
    CASE 110, command_force
    LIT16 1200
    F cmp COMMAND_HEAD
    IF_EQUAL command_direct
    LIT16 1111
    F cmp COMMAND_HEAD
    IF_EQUAL .Lcommands_4
    F word COMMAND_HEAD+2
    BELOW 4
    DO axis_there
    WANTED
    DO axis_bit
    PUT TEMP
    F word COMMAND_HEAD
    CASE 100, command_stop
.Lcommands_4:
    IF_ANY RUN, RUN_ACTIVE, .Lcommands_m10
    IF_SET EFFECT, .Lcommands_m10
    F word COMMAND_HEAD
    CASE_NOT 102, .Lcommands_8
    F load COMMAND+8
    DO test_long
    IF_EQUAL command_stop
.Lcommands_8:
    IF_SET MOVING, .Lcommands_m10
    DO blocking
    IF_NOT_EQUAL .Lcommands_m10
    F word COMMAND_HEAD+2
    ADDI -1
    PUT N
    LET FLAGS, 0
    LIT 108
    F sub COMMAND_HEAD
    CMPI 7
    IF_CARRY command_by_profile
    DO micro_switch
    TO .Lcommands_17
    TO .Lcommands_16
    TO .Lcommands_m9
    TO .Lcommands_14
    TO .Lcommands_13
    TO .Lcommands_12
    TO .Lcommands_m11
    PLACES_END
command_force:
    F word COMMAND_HEAD+2
    BELOW 16
    ADDI 1
    CALL force_input
    RETURN
.Lcommands_12:
    DO offset_steps
command_go:
    DO command_target
    DO or_return
    DO command
    DO begin_axis
    DONE_
.Lcommands_13:
    DO here
    GOTO command_go
.Lcommands_14:
    F load COMMAND+4
    .global work_position_is
    ROUTINE_ODD work_position_is, module.rules.commands
    IF_ZERO MOVING, .Lcommands_38
.Lcommands_m10:
    LIT EX_BUSY
    RETURN
command_stop:
    IF_NONE RUN, RUN_ACTIVE, .Lcommands_26
    LIT 2
command_control:
    DO control
    DONE_
command_direct:
    F word COMMAND_HEAD+2
    CASE 255, command_stop
    CASE_NOT 88, .Lcommands_31
    LIT 6
    GOTO command_control
.Lcommands_16:
    F word COMMAND+6
    PUT UNIT
    BELOW 2
    F word COMMAND+4
    BELOW 17
    ADDI 1
    DO probe_input
.Lcommands_m8:
    DO command_long
command_probe:
    DO here
    DO command_target
    DO or_return
    DO axis_bit
    AXIS_OFF PROBE_ERROR
    UP PHASE
    LET EFFECT, OP_PROBE
    DO probe_begin
    IF_EQUAL .Lcommands_58
    DO abandon
.Lcommands_58:
    DONE_
.Lcommands_17:
    F load COMMAND+8
    DO probe_xor
    F load COMMAND+4
    DO probe_and
    DO command_long
    GOTO .Lcommands_m8
command_by_profile:
    LIT16 1111
    F sub COMMAND_HEAD
    BELOW 2
    DO micro_switch
    TO .Lcommands_21
    TO .Lcommands_20
    PLACES_END
.Lcommands_m9:
    GOTO command_home
.Lcommands_m11:
    GOTO command_run
.Lcommands_26:
    DO abandon
    DO micro_first_axis
.Lcommands_27:
    IF_NOT_AXIS TEMP, .Lcommands_29
    IF_NOT_AXIS MOVING, .Lcommands_29
    DO motion_stop
.Lcommands_29:
    NEXT_AXIS .Lcommands_27
    DONE_
.Lcommands_31:
    LIT 133
    F sub COMMAND_HEAD+2
    BELOW 5
    DO micro_switch
    TO .Lcommands_34
    TO .Lcommands_35
    TO .Lcommands_35
    TO command_control
    TO command_control
    PLACES_END
.Lcommands_34:
    IF_NONE MOTION, M_JOG, .Lcommands_37
    DO motion_stop
.Lcommands_37:
    DONE_
.Lcommands_38:
    F sub ACTUAL, AXIS
    DO negate
    DO to_um
    IF_CARRY .Lcommands_m4
    F store OFFSET, AXIS
    DONE_
    .global command_target
    ROUTINE_ODD command_target, module.rules.commands
    F store SPARE
    DO command_pace
    WANTED
    DO command_long
    .global command_aim
    ROUTINE_ODD command_aim, module.rules.commands
    F add SPARE
    IF_OVERFLOW .Lcommands_m5
    LET FRAME_OF, F_STEPS|F_RELATIVE
    CALL aim_place
    BELOW 1
    RETURN
.Lcommands_20:
    F word VM_CODE
    IF_EQUAL .Lcommands_m7
    GET N
    DO home_by_profile
    GOTO command_home_under_way
command_run:
    F load COMMAND+4
    F store COMMAND+12
    LIT16 0x2000
    F put SPARE_TOO+2
    F load COMMAND+8
    IF_NOT_NEGATIVE .Lcommands_41
    DO negate
    F store COMMAND+8
    F load SPARE_TOO
    DO negate
    F store SPARE_TOO
    FR load A_MIN, LONG
    GOTO .Lcommands_m2
.Lcommands_35:
.Lcommands_m4:
.Lcommands_m5:
    LIT EX_ILLEGAL_VALUE
    RETURN
.Lcommands_21:
    F word VM_CODE
    IF_NOT_EQUAL command_jog
.Lcommands_m7:
    LIT EX_DEVICE_FAILURE
    RETURN
command_home:
    F word COMMAND+4
    BELOW 1
    F word COMMAND+6
    BELOW 17
    ADDI HOME_COMMAND+1
    PUT BITS
    F word COMMAND+8
    BELOW 2
    TESTI 1
    IF_NOT_EQUAL .Lcommands_53
    BITS_ON BITS, HOME_INVERT
.Lcommands_53:
    F word COMMAND+10
    BELOW 2
    LIT 3
    DO axis_select
.Lcommands_54:
    F load HOME_SPEED, AXIS
    DO not_negative
    DO test_long
    WANTED
    NEXT_AXIS .Lcommands_54
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
    F word COMMAND+10
    IF_EQUAL .Lcommands_m3
    F load HOME_CLEARANCE
    DO negate
    F store HOME_CLEARANCE
    LIT AXIS_HOME_POSITIVE
.Lcommands_m3:
    F put HOME_RECORD+A_FLAGS
command_home_under_way:
    DO axis_n
    UP PHASE
    DO axis_bit
    AXIS_OFF HOMING_ERROR
    GET N
    ADDI OP_HOME
    PUT EFFECT
    DONE_
.Lcommands_41:
    FR load A_MAX, LONG
.Lcommands_m2:
    DO to_steps
    IF_NOT_AXIS HOMED, .Lcommands_44
    GOTO .Lcommands_43
command_jog:
    F word COMMAND_HEAD+2
    BELOW 72
    PUT FLAGS
    TESTI 56
    IF_EQUAL .Lcommands_46
.Lcommands_m6:
    LIT EX_ILLEGAL_VALUE
    RETURN
.Lcommands_44:
    DO here
    F add SPARE_TOO
.Lcommands_43:
    F store STEPS, AXIS
    DO command_pace
    WANTED
    DO begin_axis
command_held:
    IF_ZERO MOVING, .Lcommands_45
    BITS_ON MOTION, M_JOG
.Lcommands_45:
    DONE_
    .global command_pace
    ROUTINE_ODD command_pace, module.rules.commands
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
.Lcommands_46:
    TESTI 7
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
    LIT 0
    DO axis_select
.Lcommands_47:
    IF_NOT_AXIS FLAGS, .Lcommands_48
    DO command_float
    DO axis_at
    DO to_steps
    IF_CARRY .Lcommands_m6
    F store SPARE
    DO here
    IF_ANY FLAGS, JOG_RELATIVE, .Lcommands_52
    DO offset_steps
.Lcommands_52:
    CALL command_aim
    DO or_return
.Lcommands_48:
    UP_AXIS .Lcommands_47
    DO command_axes
    GET RAMPS
    DO line_begin
    GOTO command_held
    .balign 2, 0
    .global command_done
command_done:
    MICRO
    CASE 0, .Lcommands_m0
    .global abandon
    ROUTINE_ODD abandon, module.rules.commands
    IF_ZERO EFFECT, .Lcommands_m1
    DO axis_n
    DO axis_bit
    IF_IS_NOT EFFECT, OP_PROBE, .Lcommands_61
    AXIS_ON PROBE_ERROR
    GOTO .Lcommands_62
.Lcommands_61:
    AXIS_ON HOMING_ERROR
.Lcommands_62:
    F clear EFFECT
.Lcommands_m0:
.Lcommands_m1:
    RETURN
    .balign 2, 0
