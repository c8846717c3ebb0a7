/* Made by `cargo run -p lower` of firmware/src/rules/probe.rs: change that. */

    .section .text.micro,"axR",@progbits
module.rules.probe:
fx_probe:
    IF_NOT_EQUAL .Lprobe_1
    DO operand_byte
    DO axis_flags
    DO operand_byte
    PUT RAMPS
    IF_NONE RAMPS, FL_MASK, .Lprobe_3
    DO pop_value
    DO probe_xor
    DO pop_value
    DO probe_and
    GOTO .Lprobe_4
.Lprobe_3:
    LET UNIT, 1
    PROFILE B_PROBE
    IF_NONE RAMPS, FL_SENSOR, .Lprobe_5
    DO pop_level
    POP_NUMBER 1, 17
.Lprobe_5:
    CASE_NOT 0, .Lprobe_6
    FAULT F_VALUE_RANGE
.Lprobe_6:
    DO probe_input
.Lprobe_4:
    IF_NONE FLAGS, FL_SPEED, .Lprobe_7
    DO speed_flags
    IF_NOT_EQUAL .Lprobe_9
.Lprobe_m0:
    FAULT F_SPEED_RANGE
.Lprobe_7:
    LET UNIT, 0
    F load FEED
    IF_NOT_NEGATIVE .Lprobe_10
    LET UNIT, 2
    DO negate
.Lprobe_10:
    DO rate_of
    DO speed_least
    IF_EQUAL .Lprobe_m0
.Lprobe_9:
    GET FLAGS
    ANDI F_STEPS+F_MACHINE+F_RELATIVE
    PUT FRAME_OF
    DO pop_value
    DO aim
    DO or_return
    DO probe_begin
    IF_EQUAL .Lprobe_m1
    DO axis_n
    DO here
    EVENT TRACE_PROBE
    FAULT F_INPUT_ACTIVE
.Lprobe_1:
    DO axis_n
    IF_IS_NOT PHASE, 1, .Lprobe_13
    IF_ZERO HIT, .Lprobe_14
    CALL motion_caught
probe_answered:
    F store PROBED, AXIS
    UP PHASE
    DO axis_bit
    AXIS_ON PROBE_OK
    F load PROBED, AXIS
    DO motion_hit
.Lprobe_m1:
.Lprobe_m2:
.Lprobe_m3:
    NOT_YET_
.Lprobe_14:
    DO probe_answers
    IF_EQUAL .Lprobe_15
    DO here
    GOTO probe_answered
.Lprobe_15:
    IF_SET MOVING, .Lprobe_m2
    LET PHASE, 3
.Lprobe_13:
    IF_SET MOVING, .Lprobe_m3
    IF_IS_NOT PHASE, 2, .Lprobe_18
    F load PROBED, AXIS
    EVENT_OK TRACE_PROBE
.Lprobe_m4:
.Lprobe_m5:
    RETURN
.Lprobe_18:
    DO here
    EVENT TRACE_PROBE
    IF_ANY BITS, FL_QUERY, .Lprobe_m4
    FAULT F_PROBE_MISSED
    .global probe_begin
    ROUTINE_ODD probe_begin, module.rules.probe
    DO axis_bit
    AXIS_OFF PROBE_OK
    DO probe_answers
    IF_NOT_EQUAL .Lprobe_m5
    DO command
    DO begin_axis
    LET HIT, 0
    CALL probe_pins
    PUT WATCH
    PROFILE B_FLAGS
    TESTI BOARD_CHAIN
    IF_EQUAL .Lprobe_21
    LET WATCH, 0
    F word PROBE_AND
    IF_NOT_EQUAL .Lprobe_22
    IF_NONE BITS, PROBE_AND_17, .Lprobe_22
    LET WATCH, P1_REF_X_OR_PROBE
.Lprobe_22:
.Lprobe_21:
    BITS_OFF IDLE, WATCH_ENDS
    F load START2
    F sub NOMINAL2
    IF_NEGATIVE .Lprobe_23
    BITS_ON IDLE, WATCH_ENDS
.Lprobe_23:
    LIT 0
    DO test_long
    RETURN
    .balign 2, 0
