/* Made by `cargo run -p lower` of firmware/src/rules/planner.rs: change that. */

    .section .text.line,"axR",@progbits
module.rules.planner:
    .global motion_speed
    ROUTINE_ODD motion_speed, module.rules.planner
    DO axis_select
    DO motion_rests
    IF_NOT_EQUAL .Lplanner_1
    LIT 0
.Lplanner_m2:
    RETURN
.Lplanner_1:
    DO ticks_a_second
    F times V
    F over TICK
    F times INC, AXIS, NEW
    SHIFT -19
    DO rounded
    IF_NOT_AXIS NEGATIVE, .Lplanner_m2
    DO negate
    RETURN
    .global rounded
    ROUTINE_ODD rounded, module.rules.planner
    F store TEMP
    LIT 1
    DO new
    SHIFT 12
    F plus TEMP
    SHIFT -13
    DO floor
.Lplanner_m0:
    RETURN
    .global line_rapid
    ROUTINE_ODD line_rapid, module.rules.planner
    LET HIT, 1
    GOTO plan
    .global axis_begin
    ROUTINE_ODD axis_begin, module.rules.planner
    LET HIT, LONE&255
    GOTO plan
    .global line_begin
    ROUTINE_ODD line_begin, module.rules.planner
    LET HIT, 0
plan:
    PUT MOVING
    IF_IS WATCH, TRIPPED&255, .Lplanner_4
    LET WATCH, 0
.Lplanner_4:
    LIT 0
    F store LEFT
    F store TICK
    DO axis_select
.Lplanner_5:
    LIT 0
    F store NEW_STEPS, AXIS
    IF_NOT_AXIS MOVING, .Lplanner_6
    F load STEPS, AXIS
    F sub ACTUAL, AXIS
    DO test_long
    IF_NOT_EQUAL .Lplanner_9
    DO axis_bit
    AXIS_OFF MOVING
    GOTO .Lplanner_6
.Lplanner_9:
    CALL line_direction
    DO abs
    F store NEW_STEPS, AXIS
    F most LEFT
    F store LEFT
    F load NEW_STEPS, AXIS, NEW
    IF_ANY FEED+3, 0x80, .Lplanner_10
    DO axis_at
    FR times A_UM, SHORT, NEW
    FR over A_STEPS, SHORT, NEW
.Lplanner_10:
    F store CAUGHT
    F times CAUGHT
    F plus TICK
    F store TICK
.Lplanner_6:
    UP_AXIS .Lplanner_5
    IF_ZERO MOVING, .Lplanner_m0
limit:
    DO scaled_most
    F store V
    IF_IS_NOT HIT, LONE&255, .Lplanner_12
    F load LEFT, NEW
    GOTO .Lplanner_m1
.Lplanner_12:
    F store TEMP
    F store TEMP+4
    F store TEMP+8
    F load TICK
    DO root
.Lplanner_m1:
    F store TICK
    DO micro_first_axis
.Lplanner_14:
    IF_NOT_AXIS MOVING, .Lplanner_16
    F load TICK
    F over NEW_STEPS, AXIS, NEW
    DO axis_at
    F store CAUGHT
    FR times A_TOP_RATE, LONG, NEW
    F bound TEMP
    F load CAUGHT
    FR times A_ACCEL, LONG, NEW
    F bound TEMP+4
    F load CAUGHT
    FR times A_DECEL, LONG, NEW
    F bound TEMP+8
    LIT 1
    DO new
    FR most A_START_RATE, SHORT, NEW
    F times CAUGHT
    F bound V
.Lplanner_16:
    F load NEW_STEPS, AXIS
    CALL line_fraction
    .if HAS_COURSES
    IF_NONE MOTION, M_NEXT, .Lplanner_17
    CALL line_change
    F store NEXT_INC, AXIS
    GOTO .Lplanner_15
    .endif
.Lplanner_17:
    F store INC, AXIS
    DO axis_at
    CALL line_origin
.Lplanner_15:
    NEXT_AXIS .Lplanner_14
    F load TEMP
    F store CAUGHT
    DO motion_nominal
remember:
    F load TICK
    F over LEFT, NEW
    F store TICK
    LIT 31
    DO new
    F times TICK
    SHIFT -4
    F store TEMP
    F times TEMP+8
    F store DECEL2
    F load TEMP
    F times TEMP+4
    F store ACCEL2
    F load V
    F times V
    .if HAS_COURSES
    IF_NONE MOTION, M_NEXT, .Lplanner_18
    F bound START2
    F load V2
    GOTO .Lplanner_19
    .endif
.Lplanner_18:
    F store START2
    F least NOMINAL2
    F store V2
.Lplanner_19:
    DO root
    F store V
    DO ticks_a_second
    F times TICK
    F store TICK
    .if HAS_COURSES
    BITS_OFF MOTION, M_THROUGH
    IF_NONE MOTION, M_COURSE, .Lplanner_20
    F load LEFT, NEW
    F times DECEL2
    F store TEMP
    F load EXIT2
    F minus TEMP
    CALL course_line
    GET JOINED
    PUT JOINS
    F load START2
    F sub EXIT2
    IF_CARRY .Lplanner_21
    BITS_ON MOTION, M_THROUGH
    .endif
.Lplanner_21:
.Lplanner_20:
    RETURN
    .global motion_nominal
    ROUTINE_ODD motion_nominal, module.rules.planner
    DO axis_n
    LIT 100
    DO new
    F store TEMP
    GET EFFECT
    ADDI -OP_PROBE
    CMPI OP_HOME_QUERY+1-OP_PROBE
    IF_CARRY .Lplanner_22
    LIT 100
    GOTO .Lplanner_23
.Lplanner_22:
    GET OVERRIDE
    IF_IS_NOT HIT, 1, .Lplanner_24
    GET OVERRIDE+1
.Lplanner_24:
.Lplanner_23:
    DO new
    F over TEMP
    F store TEMP
    IF_SET HIT, .Lplanner_27
    F load FEED
    DO test_long
    IF_EQUAL .Lplanner_27
    DO abs
    DO new
    GOTO .Lplanner_28
.Lplanner_27:
    DO scaled_most
.Lplanner_28:
    F least CAUGHT
    F times TEMP
    IF_IS_NOT HIT, LONE&255, .Lplanner_29
    FR least A_TOP_RATE, LONG, NEW
    GOTO .Lplanner_30
.Lplanner_29:
    F least CAUGHT
.Lplanner_30:
    F store TEMP
    F times TEMP
    F store NOMINAL2
    RETURN
    .balign 2, 0
