/* Made by `cargo run -p lower` of firmware/src/rules/lines.rs: change that. */

    .section .text.micro,"axR",@progbits
module.rules.lines:
    .global command_axes
    ROUTINE_ODD command_axes, module.rules.lines
    LET RAMPS, 0
    DO micro_first_axis
.Llines_1:
    IF_NOT_AXIS FLAGS, .Llines_3
    DO command
    IF_EQUAL .Llines_3
    DO axis_bit
    AXIS_ON RAMPS
.Llines_3:
    NEXT_AXIS .Llines_1
.Llines_m0:
.Llines_m1:
    RETURN
fx_linear:
    IF_NOT_EQUAL .Llines_4
    PUT UNIT
    CMPI OP_RAPID
    IF_NOT_NEGATIVE .Llines_6
    DO operand_byte
    GOTO .Llines_7
.Llines_17:
    EVENT TRACE_LINE
    GET RAMPS
    DO line_begin
    .if HAS_COURSES
    DO motion_poll
    .endif
fx_goes_on:
.Llines_20:
    .if HAS_COURSES
    IF_NONE MOTION, M_THROUGH, .Llines_21
    IF_ANY MOTION, M_NEXT, .Llines_21
    F load LEFT
    DO test_long
    IF_NOT_EQUAL .Llines_21
    RETURN
    .endif
.Llines_21:
    NOT_YET_
.Llines_4:
    IF_SET MOVING, .Llines_20
    GET N
    CASE 0, .Llines_m1
    LET N, 0
    DO line_rapid
    NOT_YET_
.Llines_6:
    DO short_flags
.Llines_7:
    PUT FLAGS
    IF_IS_NOT UNIT, OP_LINEAR_MIXED, .Llines_8
    CALL linear_mixed
.Llines_8:
    .if HAS_COURSES
    IF_ZERO MOVING, .Llines_9
    BITS_ON MOTION, M_NEXT
    LIT 0
    F store NEXT_DIRS
    F store NEXT_COUNT+2
    DO micro_first_axis
    .endif
.Llines_10:
    .if HAS_COURSES
    F load STEPS, AXIS
    F store ACTUAL, AXIS
    NEXT_AXIS .Llines_10
    .endif
.Llines_9:
    GET FLAGS
    DO half
    DO half
    DO half
    ANDI F_STEPS+F_MACHINE+F_RELATIVE
    PUT FRAME_OF
    DO micro_first_axis
.Llines_12:
    IF_IS_NOT UNIT, OP_LINEAR_MIXED, .Llines_14
    CALL linear_frame
    PUT FRAME_OF
.Llines_14:
    IF_NOT_AXIS FLAGS, .Llines_15
    DO pop_value
    DO axis_at
    DO aim
    DO or_return
.Llines_15:
    NEXT_AXIS .Llines_12
    DO command_axes
    LIT 0
    F store LEFT
    IF_ZERO RAMPS, .Llines_m0
    IF_NONE FLAGS, FL_RAPID, .Llines_17
    EVENT TRACE_RAPID
fx_rapid:
    F base STORED
    FR word PROGRAM_MACHINE+MC_FLAGS, SHORT
    TESTI MC_RAPID_Z_APART
    IF_EQUAL .Llines_22
    GET RAMPS
    CMPI 5
    IF_NEGATIVE .Llines_22
    LIT 2
    DO axis_select
    FR word A_FLAGS, SHORT
    PUT UNIT
    F load STEPS, AXIS
    F sub ACTUAL, AXIS
    IF_NONE UNIT, AXIS_HOME_POSITIVE, .Llines_23
    DO negate
.Llines_23:
    IF_NOT_NEGATIVE .Llines_24
    GET RAMPS
    ANDI 3
    PUT N
    LIT 4
    DO line_rapid
    NOT_YET_
.Llines_24:
    LET N, 4
    DO axis_bit
    AXIS_OFF RAMPS
.Llines_22:
    GET RAMPS
    DO line_rapid
    NOT_YET_
    .balign 2, 0
