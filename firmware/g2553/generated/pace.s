/* Made by `cargo run -p lower` of firmware/src/rules/pace.rs: change that. */

    .section .text.micro,"axR",@progbits
module.rules.pace:
    .global rate
    ROUTINE_ODD rate, module.rules.pace
    PUT UNIT
    DO scaled_most
    IF_NONE UNIT, FL_ACCEL|FL_DECEL|FL_SPEED, .Lpace_m0
    DO pop_value
    .global rate_of
    ROUTINE_ODD rate_of, module.rules.pace
    DO not_negative
    DO new
    IF_ANY UNIT, FL_ACCEL_STEPS|FL_DECEL_STEPS|FL_SPEED_STEPS, .Lpace_2
    FR times A_STEPS, SHORT, NEW
    FR over A_UM, SHORT, NEW
.Lpace_2:
.Lpace_m0:
    DO test_long
    RETURN
    .global speed_flags
    ROUTINE_ODD speed_flags, module.rules.pace
    GET FLAGS
    ANDI (FL_SPEED|FL_SPEED_STEPS)
    DO rate
    .global speed_least
    ROUTINE_ODD speed_least, module.rules.pace
    F bound TEMP
    DO test_long
    RETURN
    .global axis_flags
    ROUTINE_ODD axis_flags, module.rules.pace
    PUT FLAGS
    ANDI FL_AXIS
    PUT N
    DO axis_select
    .global axis_pace
    ROUTINE_ODD axis_pace, module.rules.pace
    FR load A_TOP_RATE, LONG, NEW
    F store TEMP
    FR load A_ACCEL, LONG, NEW
    F store TEMP+4
    FR load A_DECEL, LONG, NEW
    F store TEMP+8
    RETURN
    .balign 2, 0
