/* Made by `cargo run -p lower` of firmware/src/rules/home.rs: change that. */

    .section .text.micro,"axR",@progbits
module.rules.home:
    .balign 2, 0
    .global limits
limits:
    MICRO
    IF_ZERO MOVING, .Lhome_2
    DO map_homes
    IF_CARRY .Lhome_1
.Lhome_2:
    RETURN
.Lhome_1:
    DO micro_first_axis
.Lhome_3:
    DO reference_at
    PUT TEMP
    DO unfiltered
    IF_EQUAL .Lhome_4
    IF_NOT_AXIS MOVING, .Lhome_4
    DO axis_at
    FR word A_FLAGS, SHORT
    IF_NOT_AXIS NEGATIVE, .Lhome_8
    ADDI AXIS_HOME_POSITIVE
.Lhome_8:
    TESTI AXIS_HOME_POSITIVE
    IF_EQUAL .Lhome_9
    DO axis_bit
    AXIS_OFF HOMED
    GET TEMP
    PUT FAULT_IN
    DO motion_halt
    LIT F_LIMIT_SWITCH
    DO fail
    RETURN
.Lhome_9:
.Lhome_4:
    NEXT_AXIS .Lhome_3
    RETURN
fx_home:
    IF_NOT_EQUAL .Lhome_10
    ADDI -OP_HOME
    CASE_NOT (OP_HOME_QUERY-OP_HOME), .Lhome_11
    DO operand_byte
.Lhome_11:
    DO home_by_profile
.Lhome_10:
    DO axis_n
    DO axis_there
    IF_NOT_EQUAL .Lhome_12
    FAULT F_VALUE_RANGE
.Lhome_12:
    DO axis_pace
    IF_NONE BITS, HOME_COMMAND, .Lhome_13
    F load HOME_UP, NEW
    F bound TEMP+4
    F load HOME_DOWN, NEW
    F bound TEMP+8
    F load HOME_SPEED, NEW
    CALL home_record
    GOTO .Lhome_14
.Lhome_13:
    FR load A_HOME_FAST, SHORT, NEW
.Lhome_14:
    DO speed_least
    GET PHASE
    IF_ZERO MOVING, .Lhome_15
    CMPI 6
    IF_NEGATIVE .Lhome_m0
.Lhome_15:
    DO micro_switch
    .byte 0
    TO .Lhome_16
    TO .Lhome_17
    TO .Lhome_18
    TO .Lhome_21
    TO .Lhome_22
    TO .Lhome_19
    TO .Lhome_20
    PLACES_END
.Lhome_22:
    DO here
    EVENT_OK TRACE_HOME
.Lhome_m4:
    RETURN
.Lhome_16:
    DO axis_bit
    AXIS_OFF HOMED
    AXIS_OFF PLACED
    LIT 0
    F store OFFSET, AXIS
    UP PHASE
    DO home_closed
    IF_NOT_EQUAL .Lhome_m1
    LET PHASE, 6
    FR word A_FLAGS, SHORT
home_seek:
    PUT FLAGS
    FR load A_HOME_STROKE, LONG
    DO to_steps
    IF_ANY FLAGS, AXIS_HOME_POSITIVE, .Lhome_32
    DO negate
.Lhome_32:
    F add ACTUAL, AXIS
    F store STEPS, AXIS
    DO begin_axis
    RETURN
.Lhome_17:
    FR load A_HOME_PAUSE, SHORT
    F store TIME
    UP PHASE
.Lhome_m0:
.Lhome_m1:
.Lhome_m2:
    NOT_YET_
.Lhome_18:
    F load TIME
    DO test_long
    IF_NOT_EQUAL .Lhome_m2
    LET PHASE, 7
    FR load A_HOME_SLOW, SHORT, NEW
    DO speed_least
    FR word A_FLAGS, SHORT
    ADDI AXIS_HOME_POSITIVE
    GOTO home_seek
.Lhome_19:
    DO home_closed
    IF_NOT_EQUAL .Lhome_26
    IF_SET MOVING, .Lhome_m3
    DO home_missed
    IF_IS EFFECT, OP_HOME_QUERY, .Lhome_m4
    FAULT F_HOME_NOT_FOUND
.Lhome_26:
    LET PHASE, 2
    DO motion_stop
.Lhome_m3:
.Lhome_m5:
    NOT_YET_
.Lhome_20:
    DO home_closed
    IF_EQUAL .Lhome_29
    IF_SET MOVING, .Lhome_m5
    DO home_missed
    FAULT F_HOME_STAYS_CLOSED
.Lhome_29:
    LET PHASE, 4
    DO here
    F store OPENED
    DO motion_hit
    NOT_YET_
.Lhome_21:
    UP PHASE
    DO axis_bit
    AXIS_ON HOMED
    FR load A_HOME_POSITION, LONG
    DO to_steps
    F add ACTUAL, AXIS
    F sub OPENED
    F store ACTUAL, AXIS
    FR word A_FLAGS, SHORT
    PUT FLAGS
    FR load A_HOME_CLEARANCE, LONG
    IF_NONE FLAGS, AXIS_HOME_POSITIVE, .Lhome_31
    DO negate
.Lhome_31:
    FR add A_HOME_POSITION, LONG
    DO to_steps
    DO axis_at
    CALL settle
    DO begin_axis
    RETURN
    .global home_missed
    ROUTINE_ODD home_missed, module.rules.home
    DO axis_at
    DO settle_here
    DO here
    EVENT TRACE_HOME
    RETURN
    .global home_closed
    ROUTINE_ODD home_closed, module.rules.home
    GET BITS
    ANDI 31
    DO unfiltered
    IF_NONE BITS, HOME_INVERT, .Lhome_33
    ADDI 1
.Lhome_33:
    TESTI 1
    RETURN
    .global home_by_profile
    ROUTINE_ODD home_by_profile, module.rules.home
    PUT N
    CALL reference
    PUT BITS
    RETURN
    .balign 2, 0
